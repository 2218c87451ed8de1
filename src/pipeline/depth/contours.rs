//! What is drawn of a depth map: lines of equal depth, the areas between them and what lies below each.

use crate::bathymetry::Surface;
use crate::bathymetry::isobaths::{DepthArea, Isobath, Storage, depth_areas, isobaths, storage};
use crate::progress::{Cancelled, Progress};

/// Lines shorter than this, metres, are left out: rounded to the millimetre of the files, they are no lines any more.
const LEAST_LENGTH_M: f64 = 0.01;

/// What is drawn of a depth map.
#[derive(Clone, Debug)]
pub struct Contours {
    /// Lines of equal depth.
    pub lines: Vec<Isobath>,
    /// The areas between them.
    pub areas: Vec<DepthArea>,
    /// Area and volume below each level.
    pub table: Vec<Storage>,
}

impl Contours {
    /// Of levels, metres, from shallow to deep.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        surface: &Surface,
        levels_m: &[f64],
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let with_ends = with_ends(levels_m, surface.range_m());
        let mut lines = isobaths(surface, levels_m, progress)?;
        lines.retain(|line| line.length_m() > LEAST_LENGTH_M);
        Ok(Self {
            lines,
            areas: depth_areas(surface, &with_ends, progress)?,
            table: storage(surface, &with_ends),
        })
    }
}

/// The levels, with the shallowest and what is just beyond the deepest depth around them, so that the areas cover all.
fn with_ends(levels_m: &[f64], [least_m, most_m]: [f64; 2]) -> Vec<f64> {
    let within = levels_m
        .iter()
        .copied()
        .filter(|level| *level > least_m && *level <= most_m);
    let beyond_m = most_m.next_up();
    std::iter::once(least_m)
        .chain(within)
        .chain([beyond_m])
        .collect()
}
