//! Stones strewn over rough ground, at most one in each cell of a grid.

use super::random::{RandomPurpose, mix};

/// Side of a cell, metres.
const CELL_M: f64 = 1.6;
/// Smallest and largest radius of a stone, metres.
const RADIUS_M: (f64, f64) = (0.08, 0.28);
/// Height of a stone as a share of its radius. Stones of a river lie on their flat side, about 0.6
/// of their length high, and half of that is in the ground.
const HEIGHT_SHARE: f64 = 0.6;

/// Strewn stones.
pub(super) struct Stones {
    key: u64,
}

impl Stones {
    /// Stones whose places and sizes come from the seed.
    pub(super) fn new(seed: u64) -> Self {
        Self { key: mix(seed ^ mix(RandomPurpose::Stones as u64)) }
    }

    /// Height of a stone's surface above the ground at a place, metres; 0 between stones.
    pub(super) fn height_m(&self, east_m: f64, north_m: f64) -> f64 {
        let (column, row) = ((east_m / CELL_M).floor(), (north_m / CELL_M).floor());
        let place = (column as i64 as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (row as i64 as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        let bits = mix(self.key ^ place);
        // Three numbers between 0 and 1 from the same 64 bits; small stones are more common than
        // large ones.
        let share = |shift: u32| ((bits >> shift) & 0xf_ffff) as f64 / f64::from(1 << 20);
        let size = share(40);
        let radius = RADIUS_M.0 + (RADIUS_M.1 - RADIUS_M.0) * size * size;
        let room = CELL_M - 2.0 * radius;
        let east = east_m - column * CELL_M - radius - room * share(0);
        let north = north_m - row * CELL_M - radius - room * share(20);
        let off = (east * east + north * north) / (radius * radius);
        HEIGHT_SHARE * radius * (1.0 - off).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stones_cover_a_small_share_of_the_ground_and_stay_low() {
        let stones = Stones::new(5);
        let (mut covered, mut highest) = (0, 0.0_f64);
        let places = 400;
        for i in 0..places {
            for j in 0..places {
                let height = stones.height_m(f64::from(i) * 0.05 - 9.0, f64::from(j) * 0.05 - 9.0);
                covered += usize::from(height > 0.0);
                highest = highest.max(height);
            }
        }
        let share = covered as f64 / f64::from(places * places);
        assert!((0.02..0.08).contains(&share), "{share}");
        assert!((0.12..0.17).contains(&highest), "{highest}");
    }
}
