//! Holds the area of the water of a survey, as drawn by a user, and readings of a gauge or tide
//! table over time.

use crate::support::geo::LonLat;
use crate::support::outline::{edges, is_crossed};
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Plausible heights of a water's surface, metres: the Dead Sea is at -430, the highest lake at
/// 6400.
pub const WATER_LEVELS_M: RangeInclusive<f64> = -1000.0..=10_000.0;

/// An area of water, given by rings: a place is in the area where an odd number of rings go around
/// it, so that islands are rings too.
#[derive(Clone, Debug, Default)]
pub struct WaterArea {
    /// The file that it was read from.
    pub path: PathBuf,
    /// Size of the file, bytes.
    pub bytes: usize,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Corners of each ring; the first corner is not repeated at the end.
    pub rings: Vec<Vec<LonLat>>,
}

impl WaterArea {
    /// Returns true if a place is in the area.
    pub fn contains(&self, at: LonLat) -> bool {
        let corner = |at: LonLat| [at.lon_deg, at.lat_deg];
        let edges = self.rings.iter().flat_map(|ring| edges(ring));
        edges.filter(|edge| is_crossed(edge.map(corner), corner(at))).count() % 2 == 1
    }
}

/// Compares path, size and hash of the file instead of the rings, which follow from the file and
/// may be many.
impl PartialEq for WaterArea {
    fn eq(&self, other: &Self) -> bool {
        (&self.path, self.bytes, &self.sha256) == (&other.path, other.bytes, &other.sha256)
    }
}

/// Heights of the water's surface above the gauge's zero, in time order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gauge {
    /// The file that the readings were read from.
    pub path: PathBuf,
    /// Size of the file, bytes.
    pub bytes: usize,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Readings: Unix seconds and metres, each time after the one before.
    pub readings: Vec<(f64, f64)>,
}

impl Gauge {
    /// Returns the Unix seconds of the first and the last reading; NaN without readings.
    pub fn span_s(&self) -> [f64; 2] {
        let time_s = |reading: Option<&(f64, f64)>| reading.map_or(f64::NAN, |(time_s, _)| *time_s);
        [time_s(self.readings.first()), time_s(self.readings.last())]
    }

    /// Returns the two consecutive readings with the longest time between them, of those whose
    /// interval overlaps `from_s` to `to_s`, Unix seconds; `None` where no interval does.
    pub fn widest_gap(&self, [from_s, to_s]: [f64; 2]) -> Option<[(f64, f64); 2]> {
        let pairs = self.readings.windows(2).map(|pair| [pair[0], pair[1]]);
        let over = pairs.filter(|[before, after]| after.0 > from_s && before.0 < to_s);
        let length_s = |[before, after]: &[(f64, f64); 2]| after.0 - before.0;
        over.max_by(|a, b| length_s(a).total_cmp(&length_s(b)))
    }

    /// Returns the level at a time, Unix seconds, interpolated linearly between the readings,
    /// metres; beyond them, the first or the last reading. NaN without readings.
    pub fn level_m(&self, unix_s: f64) -> f64 {
        let after = self.readings.partition_point(|(time_s, _)| *time_s <= unix_s);
        let before = self.readings.get(after.saturating_sub(1));
        let (Some(&(from_s, from_m)), next) = (before, self.readings.get(after)) else {
            return f64::NAN;
        };
        match next {
            Some(&(to_s, to_m)) if after > 0 => {
                from_m + (to_m - from_m) * (unix_s - from_s) / (to_s - from_s)
            }
            _ => from_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_are_joined_by_straight_lines() {
        let made = Gauge {
            readings: vec![(1_634_000_000.0, 1.5), (1_634_003_600.0, 2.5)],
            ..Gauge::default()
        };
        assert_eq!(made.span_s(), [1_634_000_000.0, 1_634_003_600.0]);
        for (after_s, expected_m) in
            [(-9.0, 1.5), (0.0, 1.5), (900.0, 1.75), (3600.0, 2.5), (4000.0, 2.5)]
        {
            let found_m = made.level_m(1_634_000_000.0 + after_s);
            assert!((found_m - expected_m).abs() < 1e-12, "{after_s}: {found_m}");
        }
    }

    #[test]
    fn the_widest_gap_is_one_of_the_survey() {
        let readings = vec![(0.0, 1.0), (600.0, 1.1), (7200.0, 2.0), (90_000.0, 1.0)];
        let made = Gauge { readings, ..Gauge::default() };
        assert_eq!(made.widest_gap([100.0, 500.0]), Some([(0.0, 1.0), (600.0, 1.1)]));
        assert_eq!(made.widest_gap([100.0, 900.0]), Some([(600.0, 1.1), (7200.0, 2.0)]));
        assert_eq!(made.widest_gap([-9.0, 0.0]), None);
    }
}
