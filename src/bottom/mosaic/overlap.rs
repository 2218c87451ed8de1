//! Rules for cells of the mosaic that were seen more than once.

use serde::{Deserialize, Serialize};

/// Weight of the edges of a swath; its middle has 1.
const EDGE_WEIGHT: f64 = 0.03;

/// Rule for cells that were seen more than once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Overlap {
    /// The later pass over the earlier.
    #[default]
    Later,
    /// The brighter echo: objects stay, shadows are lost.
    Brighter,
    /// The echo that lies nearest to the middle of its swath, halfway out, where side-scan
    /// insonifies the ground best: objects and shadows stay, and a swath's weak ends show only
    /// where there is nothing else.
    Middle,
    /// The mean, weighted towards the middle of each swath: smooth, but objects and shadows fade.
    Blend,
}

/// Weighted sum of the echoes seen in a cell so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CellSum {
    /// Sum of levels times their weights.
    weighted: f32,
    /// Sum of the weights; 0 where nothing was seen.
    weight: f32,
}

impl CellSum {
    /// Creates the sum of one echo, or of all that a log shows of the cell.
    #[inline(always)]
    pub(super) fn of(level: f32, weight: f32) -> Self {
        Self { weighted: level * weight, weight }
    }

    /// 0 where nothing was seen, else 1 to 255.
    #[inline(always)]
    pub(super) fn level(&self) -> u8 {
        if self.weight > 0.0 {
            (self.weighted / self.weight).round().clamp(1.0, 255.0) as u8
        } else {
            0
        }
    }

    /// See [`CellSum::of`].
    pub(super) fn weight(&self) -> f32 {
        self.weight
    }
}

impl Overlap {
    /// Returns true if echoes count differently by where they lie in their swath.
    #[inline(always)]
    pub fn is_weighted(self) -> bool {
        matches!(self, Self::Middle | Self::Blend)
    }

    /// Returns the weight of an echo at a share of the way out: greatest in the middle of the
    /// swath.
    #[inline(always)]
    pub(super) fn weight(self, way: f64) -> f32 {
        let way = way.clamp(0.0, 1.0);
        if self.is_weighted() { (4.0 * way * (1.0 - way)).max(EDGE_WEIGHT) as f32 } else { 1.0 }
    }

    /// Joins what was seen of a cell with what was seen of it later.
    #[inline(always)]
    pub(super) fn join(self, cell: &mut CellSum, later: CellSum) {
        if later.weight == 0.0 {
            return;
        }
        match self {
            Self::Later => *cell = later,
            Self::Brighter if cell.weight == 0.0 || later.weighted > cell.weighted => *cell = later,
            Self::Brighter => {}
            Self::Middle if later.weight > cell.weight => *cell = later,
            Self::Middle => {}
            Self::Blend => {
                cell.weighted += later.weighted;
                cell.weight += later.weight;
            }
        }
    }
}
