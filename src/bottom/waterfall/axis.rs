//! Computes the common range axis of all pings of a survey, and the usual distance that the boat
//! moves from one ping to the next.

use super::{Level, TILE};
use bathyscope_log::support::statistics::median_of;
use bathyscope_log::survey::{Fix, Side, SideSpan, Survey};

/// Largest range that is believed, metres: no side-scan of this class reaches a tenth of it, so a
/// larger one comes from a damaged header.
const FARTHEST_M: f32 = 5_000.0;
/// Largest number of bins of the finest level, so that no header can request unbounded memory.
const MAX_BINS: f64 = 65_536.0;
/// Ratio of the samples' bytes to the largest size of the store of the coarse levels.
const STORE_SHARE: u64 = 48;
/// Largest number of stretches of the track whose lengths are compared.
const STRETCHES: usize = 400;
/// Length of a stretch, seconds: fixes repeat, and their scatter makes a shorter stretch seem
/// longer.
const STRETCH_S: f64 = 10.0;
/// Distance in a stretch below which the boat does not count as moving, metres.
const STILL_M: f64 = 1.0;
/// Bounds of a plausible movement, metres a ping.
const BELIEVED_M: [f64; 2] = [1e-3, 50.0];

/// Extent of a survey's picture in pings and range, with the length of a bin of its finest level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeAxis {
    /// Number of side-scan pings.
    pub pings: usize,
    /// Number of samples of both sides of all pings together.
    pub samples: u64,
    /// Slant range that one bin covers, metres: that of the survey's shortest samples.
    pub bin_m: f64,
    /// Number of bins from the boat to the farthest range.
    pub bins: u32,
    /// Farthest slant range of any ping, metres.
    pub far_m: f64,
    /// Level of the store that coarse tiles are reduced from.
    pub store: Level,
    /// Usual movement of the boat from one ping to the next, metres; `None` where the track does
    /// not determine it.
    pub ping_m: Option<f64>,
}

impl RangeAxis {
    /// Creates the axis of a survey in one pass over the spans, without reading the samples; `None`
    /// when no ping has a usable span.
    pub fn of(survey: &Survey) -> Option<Self> {
        let (mut finest_m, mut far_m, mut samples) = (f64::INFINITY, 0.0_f64, 0_u64);
        for ping in survey.side_scan.iter() {
            for span in Side::BOTH.into_iter().filter_map(|side| ping.side(side)) {
                if is_usable(span) {
                    finest_m = finest_m.min(span.metres_per_sample());
                    far_m = far_m.max(f64::from(span.far_m));
                    samples += u64::from(span.count);
                }
            }
        }
        if samples == 0 {
            return None;
        }
        let bin_m = finest_m.max(far_m / MAX_BINS);
        let pings = survey.side_scan.len();
        let bins = ((far_m / bin_m).round() as u32).max(1);
        Some(Self {
            pings,
            samples,
            bin_m,
            bins,
            far_m,
            store: store_level(pings, bins, samples),
            ping_m: ping_spacing_m(survey),
        })
    }

    /// Returns true if tiles of the other axis are valid for this one: only the number of pings and
    /// samples may differ.
    pub(crate) fn is_as_fine(&self, other: &Self) -> bool {
        let Self { bin_m, bins, far_m, store, .. } = *self;
        (bin_m, bins, far_m, store) == (other.bin_m, other.bins, other.far_m, other.store)
    }

    /// Returns the level at which the whole survey fits into one tile for each side.
    pub fn coarsest(&self) -> Level {
        let halvings = |extent: usize| {
            let tiles = extent.div_ceil(TILE).max(1);
            tiles.next_power_of_two().trailing_zeros() as u8
        };
        self.drawable(Level { along: halvings(self.pings), across: halvings(self.bins as usize) })
    }

    /// Returns the level itself where its tiles are quick to draw, or else the nearest level that
    /// the store can give.
    pub fn drawable(&self, level: Level) -> Level {
        if level.is_near() {
            return level;
        }
        Level {
            along: level.along.max(self.store.along),
            across: level.across.max(self.store.across),
        }
    }
}

/// Returns the level of the store: 16 pings x 8 bins a texel, for both sides, with two bytes each;
/// finer tiles come from the samples. Where the range of a log changed, the bins of the common axis
/// are shorter than the samples of the longer ranges; the reduction across then grows until the
/// store is small enough.
fn store_level(pings: usize, bins: u32, samples: u64) -> Level {
    let mut level = Level { along: 4, across: 3 };
    let rows = pings.div_ceil(level.pings()) as u64;
    let bytes = |level: Level| rows * 4 * u64::from(bins).div_ceil(level.bins() as u64);
    while bytes(level) > samples / STORE_SHARE && level.bins() < bins as usize {
        level.across += 1;
    }
    level
}

/// Returns true if a span can be drawn: it has samples, and its range is finite, rises and is not
/// absurdly large.
pub(super) fn is_usable(span: &SideSpan) -> bool {
    span.count > 0 && span.near_m >= 0.0 && span.near_m < span.far_m && span.far_m <= FARTHEST_M
}

/// Returns the median, over the moving stretches of a track, of the distance that the boat moved
/// for each ping, metres; `None` where the track does not determine it.
fn ping_spacing_m(survey: &Survey) -> Option<f64> {
    let (first, last) = (survey.side_scan.first()?, survey.side_scan.last()?);
    let span_s = last.time_s - first.time_s;
    let interval_s = span_s / (survey.side_scan.len().checked_sub(1)? as f64);
    let fixes = &survey.track.fixes;
    let count = ((span_s / STRETCH_S) as usize).clamp(1, STRETCHES);
    let long_s = STRETCH_S.min(span_s);
    let speeds_mps = (0..count).filter_map(|stretch| {
        let share = (stretch as f64 + 0.5) / count as f64;
        let middle_s = first.time_s + share * span_s;
        let [from, to] = [-0.5, 0.5].map(|half| at(fixes, middle_s + half * long_s));
        let (from, to) = (from?, to?);
        let seconds = to.time_s - from.time_s;
        let frame = &survey.track.frame;
        let [a, b] = [from, to].map(|fix| frame.to_enu(fix.position));
        let metres = (b[0] - a[0]).hypot(b[1] - a[1]);
        (seconds > 0.0 && metres > STILL_M).then(|| metres / seconds)
    });
    let metres = median_of(speeds_mps) * interval_s;
    (BELIEVED_M[0]..=BELIEVED_M[1]).contains(&metres).then_some(metres)
}

/// Returns the last fix up to a time, or else the first; `None` without fixes.
fn at(fixes: &[Fix], time_s: f64) -> Option<&Fix> {
    let after = fixes.partition_point(|fix| fix.time_s <= time_s);
    fixes.get(after.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::{LocalFrame, LonLat};
    use bathyscope_log::survey::{SidePing, Track};

    /// Survey of a boat at 2 m/s that stays in one place for a third of the time; ten pings and one
    /// fix a second.
    #[test]
    fn stops_do_not_shorten_the_spacing() {
        let origin = LonLat::new(-111.5, 36.8);
        let frame = LocalFrame::new(origin);
        let fixes = (0..300).map(|second| {
            Fix::at(f64::from(second), frame.to_lon_lat(2.0 * f64::from(second.min(200)), 0.0))
        });
        let ping = |index: i32| SidePing::with_depth(f64::from(index) / 10.0, f32::NAN);
        let survey =
            Survey { track: Track::new(fixes.collect()), ..Survey::of_pings((0..3000).map(ping)) };
        let metres = ping_spacing_m(&survey).expect("a spacing");
        assert!((metres - 0.2).abs() < 0.005, "{metres}");
        assert_eq!(ping_spacing_m(&Survey::default()), None);
    }
}
