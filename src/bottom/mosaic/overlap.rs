//! Joins the echoes of cells of the mosaic that were insonified more than once.

use serde::{Deserialize, Serialize};

/// Weight of the edges of a swath; the middle has weight 1.
const EDGE_WEIGHT: f64 = 0.03;

/// Rule for cells that were insonified more than once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Overlap {
    /// The echo of the later pass.
    #[default]
    Later,
    /// The brighter echo: objects stay, shadows are lost.
    Brighter,
    /// The echo nearest to the middle of its swath, halfway out, where side-scan insonifies the
    /// ground best: objects and shadows stay, and the weak ends of a swath show only where there is
    /// nothing else.
    Middle,
    /// The mean, weighted towards the middle of each swath: smooth, but objects and shadows fade.
    Blend,
}

/// Weighted sum of the echoes of a cell so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CellSum {
    /// Sum of levels times their weights.
    weighted: f32,
    /// Sum of the weights; 0 where nothing was insonified.
    weight: f32,
}

impl CellSum {
    /// Creates the sum from one echo, or from the level of a whole log in the cell.
    #[inline(always)]
    pub(super) fn of(level: f32, weight: f32) -> Self {
        Self { weighted: level * weight, weight }
    }

    /// Returns the level: 0 where nothing was insonified, else 1 to 255.
    #[inline(always)]
    pub(super) fn level(&self) -> u8 {
        if self.weight > 0.0 {
            (self.weighted / self.weight).round().clamp(1.0, 255.0) as u8
        } else {
            0
        }
    }

    /// Returns the sum of the weights.
    pub(super) fn weight(&self) -> f32 {
        self.weight
    }
}

impl Overlap {
    /// Returns true if the weight of an echo depends on its place in the swath.
    #[inline(always)]
    pub fn is_weighted(self) -> bool {
        matches!(self, Self::Middle | Self::Blend)
    }

    /// Returns the weight of an echo at a share of the way outward, 0 to 1: largest in the middle
    /// of the swath.
    #[inline(always)]
    pub(super) fn weight(self, way: f64) -> f32 {
        let way = way.clamp(0.0, 1.0);
        if self.is_weighted() { (4.0 * way * (1.0 - way)).max(EDGE_WEIGHT) as f32 } else { 1.0 }
    }

    /// Joins the sum of a cell with the sum of later echoes.
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
