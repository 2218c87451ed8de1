//! From the levels of pieces to logarithms of power without the noise in them, and where the recorder's gain steps.

use super::layout::ChunkId;
use super::pieces::Piece;
use super::system::Reading;
use crate::statistics::median;
use crate::survey::Side;
use std::collections::{BTreeMap, BTreeSet};

/// Least level over the noise that is believed, natural logarithm of power.
const LEAST_OVER_NOISE: f64 = 0.1;
/// A gain steps where the levels of two chunks differ by more than this from those of the two before, natural logarithm of power.
const STEP: f64 = 0.5;

/// The pieces of a log with the bed's levels in natural logarithms of power; `ln_per_level` is what a step of its level is.
///
/// Noise adds to the echo's power: of a level `l` over that of the noise the bed's share is `1 - exp(-l)`. It is taken off piece by
/// piece, for a dark patch has a smaller share than the bright bed beside it; what is left is as much less certain.
pub fn readings(pieces: &[Piece], ln_per_level: Option<f64>) -> Vec<Reading> {
    let reading = |piece: &Piece| {
        let scale = ln_per_level?;
        let over_noise = scale * f64::from(piece.level - piece.noise_level);
        let over_noise = over_noise.max(LEAST_OVER_NOISE);
        let share = 1.0 - (-over_noise).exp();
        let ln_level = scale * f64::from(piece.noise_level) + over_noise + share.ln();
        let numbers = [
            ln_level,
            piece.slope,
            piece.phi_rad,
            piece.place_m[0],
            piece.place_m[1],
        ];
        numbers
            .iter()
            .all(|number| number.is_finite())
            .then_some(Reading {
                piece: *piece,
                ln_level,
                share,
            })
    };
    pieces.iter().filter_map(reading).collect()
}

/// The chunks before which the gain steps.
pub fn gain_steps(readings: &[Reading]) -> BTreeSet<ChunkId> {
    let mut of_chunk: BTreeMap<ChunkId, Profile> = BTreeMap::new();
    for reading in readings {
        let piece = &reading.piece;
        let across = (piece.ground_m / super::pieces::PIECE_M) as u32;
        let profile = of_chunk.entry(piece.chunk).or_default();
        profile.insert((piece.side, across), reading.ln_level);
    }
    let steps_before = |chunk: &ChunkId| {
        let around = [-2, -1, 0, 1].map(|by| of_chunk.get(&chunk.later(by)?));
        let [second, first, here, next] = around;
        let (second, first, here, next) = (second?, first?, here?, next?);
        let change = |(place, level): (&(Side, u32), &f64)| {
            let [second, first, next] = [second, first, next].map(|of| of.get(place).copied());
            Some(0.5 * (level + next? - first? - second?))
        };
        let mut changes: Vec<f64> = here.iter().filter_map(change).collect();
        (median(&mut changes).abs() > STEP).then_some(*chunk)
    };
    of_chunk.keys().filter_map(steps_before).collect()
}

/// Levels across a chunk.
type Profile = BTreeMap<(Side, u32), f64>;

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(chunk: u32, across: u32, level: f32) -> Piece {
        Piece {
            chunk: ChunkId {
                log: 0,
                number: chunk,
            },
            range_setting: 0,
            side: Side::Port,
            samples: 100,
            level,
            noise_level: 5.0,
            ground_m: 1.25 + 0.5 * f64::from(across),
            phi_rad: 0.8,
            range_m: 3.0,
            place_m: [0.0; 2],
            outward: [1.0, 0.0],
            slope: 0.0,
        }
    }

    #[test]
    fn a_gain_that_steps_is_found_where_it_does() {
        let level = |chunk: u32, across: u32| {
            let step = if chunk >= 7 { 10.0 } else { 0.0 };
            40.0 + step + (across % 3) as f32
        };
        let pieces: Vec<Piece> = (0..14)
            .flat_map(|chunk| (0..6).map(move |across| piece(chunk, across, level(chunk, across))))
            .collect();
        let found = readings(&pieces, Some(0.09));
        assert_eq!(found.len(), pieces.len());
        assert!(found.iter().all(|reading| reading.share > 0.9));
        // 10 steps are 0.9 over both chunks; half of it is seen a chunk before and behind.
        let seventh = ChunkId { log: 0, number: 7 };
        assert_eq!(gain_steps(&found), BTreeSet::from([seventh]));
        assert!(readings(&pieces, None).is_empty());
    }
}
