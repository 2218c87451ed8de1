//! Contours of a depth map: lines of equal depth, the areas between them, and the area and volume
//! below each.

use crate::pipeline::{DepthMap, Isobaths};
use bathyscope_bottom::bathymetry::Surface;
use bathyscope_bottom::bathymetry::isobaths::{DepthArea, Storage, depth_areas, storage};
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::sync::Arc;

/// Lines and areas that are drawn of a depth map.
#[derive(Clone, Debug)]
pub struct Contours {
    /// Lines of equal depth.
    pub isobaths: Arc<Isobaths>,
    /// The areas between them.
    pub areas: Vec<DepthArea>,
    /// Area and volume below each level.
    pub table: Vec<Storage>,
}

impl Contours {
    /// Computes the areas between the lines of a depth map, and area and volume below them. The
    /// areas are bounded by the lines before these are smoothed, and by the area that the lines end
    /// at; area and volume are counted by the cells of the depth map.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        depth_map: &DepthMap,
        isobaths: Arc<Isobaths>,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let levels_of = |surface: &Surface| with_ends(&isobaths.levels_m, surface.range_m());
        let (surface, drawn) = (&depth_map.surface, isobaths.surface(depth_map, progress)?);
        let mut areas = depth_areas(drawn, &levels_of(drawn), progress)?;
        if let Some(clip) = &isobaths.clip {
            progress.check()?;
            areas = areas.par_iter().map(|area| clip.part_of(area)).collect();
        }
        Ok(Self {
            areas,
            table: storage(surface, &levels_of(surface), isobaths.clip.as_deref()),
            isobaths,
        })
    }
}

/// The levels, with the shallowest and what is just beyond the deepest depth around them, so that
/// the areas cover all.
fn with_ends(levels_m: &[f64], [least_m, most_m]: [f64; 2]) -> Vec<f64> {
    let within = levels_m.iter().copied().filter(|level| *level > least_m && *level <= most_m);
    let beyond_m = most_m.next_up();
    std::iter::once(least_m).chain(within).chain([beyond_m]).collect()
}
