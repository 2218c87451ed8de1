//! Reads the depths across the track, a swath, of sonars that measure them (interferometry).
//!
//! The depths stay in the bytes of the file, as samples do: pairs of little-endian f32, distance
//! outward from the boat and depth below the transducer, both in feet, as Lowrance writes them.

use super::{Side, Survey};
use crate::support::geo::METRES_PER_FOOT;
use std::ops::{Range, RangeInclusive};

/// Number of bytes of a pair of distance and depth.
pub(crate) const SWATH_PAIR: usize = 8;
/// Plausible distances outward, feet.
const OUT_FT: RangeInclusive<f32> = 0.001..=1000.0;
/// Plausible depths, feet.
const DEPTH_FT: RangeInclusive<f32> = 1.0..=250.0;

/// The depths of one ping: first those to port, then those to starboard, then those that the
/// recorder marks as unreliable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwathPing {
    /// Seconds after the log's time zero.
    pub time_s: f64,
    /// Byte offset of the first pair.
    pub offset: u64,
    /// Index into [`Survey::bytes`].
    pub file: u16,
    /// Number of pairs that were recorded to port.
    pub port: u16,
    /// Number of pairs that were recorded to starboard.
    pub starboard: u16,
    /// Number of pairs that the recorder marks as unreliable; they are not used.
    pub unreliable: u16,
}

impl SwathPing {
    /// Returns the number of pairs of both sides, without the unreliable ones.
    pub fn len(&self) -> usize {
        usize::from(self.port) + usize::from(self.starboard)
    }

    /// Returns true if the ping has no pair of either side.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the byte range of a pair by its number; `None` where the offset overflows.
    fn bytes_of(&self, number: usize) -> Option<Range<usize>> {
        let start = usize::try_from(self.offset).ok()?.checked_add(SWATH_PAIR * number)?;
        Some(start..start.checked_add(SWATH_PAIR)?)
    }
}

/// A depth across the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwathSounding {
    /// Number of the pair in its ping, from 0.
    pub number: usize,
    /// Side of the boat.
    pub side: Side,
    /// Horizontal distance outward from the boat, metres.
    pub out_m: f64,
    /// Depth below the transducer, metres.
    pub depth_m: f64,
}

/// Reads distance outward and depth of a pair, metres; `None` where they are not plausible.
pub(crate) fn swath_pair_m(pair: [u8; SWATH_PAIR]) -> Option<[f64; 2]> {
    let [a, b, c, d, e, f, g, h] = pair;
    let out_ft = f32::from_le_bytes([a, b, c, d]);
    let depth_ft = f32::from_le_bytes([e, f, g, h]);
    let can_be = OUT_FT.contains(&out_ft) && DEPTH_FT.contains(&depth_ft);
    can_be.then(|| [out_ft, depth_ft].map(|feet| f64::from(feet) * METRES_PER_FOOT))
}

impl Survey {
    /// Returns a depth of a swath ping by its number; `None` where the depth is not plausible, is
    /// marked as unreliable, or is outside of the bytes.
    pub fn swath_sounding(&self, ping: &SwathPing, number: usize) -> Option<SwathSounding> {
        let bytes = self.bytes.get(usize::from(ping.file))?;
        let pair = bytes.get(ping.bytes_of(number)?)?;
        let [out_m, depth_m] = swath_pair_m(pair.try_into().ok()?)?;
        let recorded = if number < usize::from(ping.port) { Side::Port } else { Side::Starboard };
        (number < ping.len()).then_some(SwathSounding {
            number,
            side: if self.swapped_sides { recorded.other() } else { recorded },
            out_m,
            depth_m,
        })
    }

    /// Returns the plausible depths of a swath ping.
    pub fn swath_soundings<'a>(
        &'a self,
        ping: &'a SwathPing,
    ) -> impl Iterator<Item = SwathSounding> + 'a {
        (0..ping.len()).filter_map(|number| self.swath_sounding(ping, number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::Bytes;
    use std::sync::Arc;

    fn pair(out_ft: f32, depth_ft: f32) -> Vec<u8> {
        [out_ft.to_le_bytes(), depth_ft.to_le_bytes()].concat()
    }

    #[test]
    fn pairs_are_read_where_they_lie_and_change_sides_with_the_cables() {
        let pairs = [pair(10.0, 20.0), pair(f32::NAN, 20.0), pair(30.0, 40.0), pair(1.0, 2.0)];
        let bytes = [vec![0; 5], pairs.concat()].concat();
        let ping =
            SwathPing { time_s: 0.0, offset: 5, file: 0, port: 2, starboard: 1, unreliable: 1 };
        let mut survey = Survey { bytes: vec![Bytes::Held(Arc::new(bytes))], ..Survey::default() };
        let read = |survey: &Survey| -> Vec<(usize, Side, f64)> {
            let all = survey.swath_soundings(&ping);
            all.map(|sounding| (sounding.number, sounding.side, sounding.out_m)).collect()
        };
        // The second pair has a NaN, the last is unreliable.
        let [near_m, far_m] = [10.0, 30.0].map(|feet| feet * METRES_PER_FOOT);
        let expected = [(0, Side::Port, near_m), (2, Side::Starboard, far_m)];
        assert_eq!(read(&survey), expected);
        assert_eq!(survey.swath_sounding(&ping, 3), None);
        survey.swapped_sides = true;
        let [first, last] = expected.map(|(number, side, out_m)| (number, side.other(), out_m));
        assert_eq!(read(&survey), [first, last]);
        survey.bytes.clear();
        assert!(read(&survey).is_empty());
    }
}
