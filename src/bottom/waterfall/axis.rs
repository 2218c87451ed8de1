//! The one range axis that all pings of a survey are drawn on.

use super::spacing::ping_spacing_m;
use super::{Level, TILE};
use bathyscope_log::survey::{Side, SideSpan, Survey};

/// Ranges beyond this are a damaged header, not a sonar: no side-scan of this class reaches a tenth
/// of it.
const FARTHEST_M: f32 = 5_000.0;
/// Bins of the finest level at most, whatever the headers say, so that no header can ask for
/// unbounded memory.
const MAX_BINS: f64 = 65_536.0;
/// The store of the far-out levels takes at most this part of the samples' bytes.
const STORE_SHARE: u64 = 48;

/// Ping and range extent of a survey's picture, and the metres that one bin of its finest level
/// covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeAxis {
    /// Side-scan pings.
    pub pings: usize,
    /// Samples of both sides of all pings together.
    pub samples: u64,
    /// Slant range that one bin covers, metres: that of the survey's finest samples.
    pub bin_m: f64,
    /// Bins from the boat to the farthest range.
    pub bins: u32,
    /// Farthest slant range of any ping, metres.
    pub far_m: f64,
    /// Level of the store that far-out tiles are reduced from.
    pub store: Level,
    /// Usual movement of the boat from one ping to the next, metres; `None` where its track does
    /// not show it.
    pub ping_m: Option<f64>,
}

impl RangeAxis {
    /// The axis of a survey; `None` when no ping has a usable span. One pass over the spans, none
    /// over the samples.
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

    /// Returns true if tiles of the other axis are tiles of this one: only the number of pings
    /// differs.
    pub(crate) fn is_as_fine(&self, other: &Self) -> bool {
        let Self { bin_m, bins, far_m, store, .. } = *self;
        (bin_m, bins, far_m, store) == (other.bin_m, other.bins, other.far_m, other.store)
    }

    /// The reductions at which the whole survey fits one tile a side.
    pub fn coarsest(&self) -> Level {
        let halvings = |extent: usize| {
            let tiles = extent.div_ceil(TILE).max(1);
            tiles.next_power_of_two().trailing_zeros() as u8
        };
        self.drawable(Level { along: halvings(self.pings), across: halvings(self.bins as usize) })
    }

    /// The level itself where its tiles are quick to make, else the nearest one that the store can
    /// give.
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

/// 16 pings x 8 bins, both sides, two bytes each: finer tiles than that come from the samples.
/// Where a log's range changed, the far pings are finer than their samples on the common axis; the
/// reduction across grows until the store is small all the same.
fn store_level(pings: usize, bins: u32, samples: u64) -> Level {
    let mut level = Level { along: 4, across: 3 };
    let rows = pings.div_ceil(level.pings()) as u64;
    let bytes = |level: Level| rows * 4 * u64::from(bins).div_ceil(level.bins() as u64);
    while bytes(level) > samples / STORE_SHARE && level.bins() < bins as usize {
        level.across += 1;
    }
    level
}

/// Returns true if a span's scale can be drawn: finite, growing, not absurd.
pub(super) fn is_usable(span: &SideSpan) -> bool {
    span.count > 0 && span.near_m >= 0.0 && span.near_m < span.far_m && span.far_m <= FARTHEST_M
}
