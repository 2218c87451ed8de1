//! Computes the contours of a depth map: lines of equal depth, the areas between them, and the area
//! and volume below each.

use super::DepthMap;
use crate::pipeline::Same;
use bathyscope_bottom::bathymetry::Surface;
use bathyscope_bottom::bathymetry::isobaths::{
    ClipArea, DepthArea, Isobath, IsobathSettings, NoIsobaths, Storage, depth_areas, isobaths,
    smoothed, storage,
};
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::sync::Arc;

/// Least length of a line, metres: shorter lines are left out, since rounded to the millimetre of
/// the files they are points.
const LEAST_LENGTH_M: f64 = 0.01;

/// Inputs of isobaths: equal keys give equal lines.
#[derive(Clone, PartialEq)]
pub struct IsobathKey {
    depth_map: Same<DepthMap>,
    settings: IsobathSettings,
}

impl IsobathKey {
    /// Creates the key of a depth map and the settings `isobaths.*`.
    pub fn of(depth_map: &Arc<DepthMap>, settings: &IsobathSettings) -> Self {
        Self { depth_map: Same(depth_map.clone()), settings: settings.clone() }
    }
}

/// Isobaths of a depth map.
#[derive(Clone, Debug, Default)]
pub struct Isobaths {
    /// Depths of the isobaths from shallow to deep, metres.
    pub levels_m: Vec<f64>,
    /// Lines in the plane of the depth map as they are drawn: smoothed, and cut at the edges of the
    /// clip area.
    pub lines: Vec<Isobath>,
    /// True if every depth that is shallower than a line is on the shallow side of the line.
    pub shoal_safe: bool,
    /// Area at whose edges the lines end, in the plane of the depth map; `None` if they are not
    /// clipped.
    pub clip: Option<Arc<ClipArea>>,
}

impl Isobaths {
    /// Computes the isobaths by `isobaths.*`; the inner error is the reason why there are none.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        depth_map: &DepthMap,
        settings: &IsobathSettings,
        progress: &Progress,
    ) -> Result<Result<Self, NoIsobaths>, Cancelled> {
        let levels_m = settings.levels_m(depth_map.extent());
        let clip = depth_map.clip_area(settings);
        let (levels_m, clip) = match levels_m.and_then(|levels_m| Ok((levels_m, clip?))) {
            Ok(parts) => parts,
            Err(error) => return Ok(Err(error)),
        };
        let shoal_safe = settings.shoal_safe;
        let surface = drawn_on(depth_map, shoal_safe, progress)?;
        let mut lines = isobaths(surface, &levels_m, progress)?;
        lines.retain(|line| line.length_m() > LEAST_LENGTH_M);
        for line in &mut lines {
            line.points = smoothed(&line.points, settings.smoothing());
        }
        if let Some(area) = &clip {
            progress.check()?;
            lines = lines.par_iter().flat_map_iter(|line| area.parts_of(line)).collect();
        }
        Ok(Ok(Self { levels_m, lines, shoal_safe, clip: clip.map(Arc::new) }))
    }

    /// Returns the surface through which the lines run.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn surface<'a>(
        &self,
        depth_map: &'a DepthMap,
        progress: &Progress,
    ) -> Result<&'a Surface, Cancelled> {
        drawn_on(depth_map, self.shoal_safe, progress)
    }

    /// Returns the lines as places in the plane of the survey, metres.
    pub fn on_ground(&self, depth_map: &DepthMap) -> Vec<Vec<[f64; 2]>> {
        let on_ground = |line: &Isobath| {
            let places = line.points.iter();
            places.map(|place| depth_map.to_survey(*place)).collect()
        };
        self.lines.par_iter().map(on_ground).collect()
    }
}

/// Returns the surface on which isobaths are drawn: if `shoal_safe`, the one that is nowhere deeper
/// than the depths from which the map was made.
fn drawn_on<'a>(
    depth_map: &'a DepthMap,
    shoal_safe: bool,
    progress: &Progress,
) -> Result<&'a Surface, Cancelled> {
    if shoal_safe { depth_map.shoalest(progress) } else { Ok(&depth_map.surface) }
}

/// Lines and areas drawn from a depth map.
#[derive(Clone, Debug)]
pub(crate) struct Contours {
    /// Lines of equal depth.
    pub isobaths: Arc<Isobaths>,
    /// Areas between the lines.
    pub areas: Vec<DepthArea>,
    /// Area and volume below each level.
    pub table: Vec<Storage>,
}

impl Contours {
    /// Computes the areas between the lines of a depth map, and area and volume below the lines.
    /// The areas are bounded by the lines before smoothing, and by the clip area; area and volume
    /// are counted in cells of the depth map.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub(crate) fn new(
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

/// Returns the levels within the range of depths, with the least depth before and a value just
/// beyond the greatest depth after them, so that the areas cover all depths.
fn with_ends(levels_m: &[f64], [least_m, most_m]: [f64; 2]) -> Vec<f64> {
    let inner_levels =
        levels_m.iter().copied().filter(|level| *level > least_m && *level <= most_m);
    let beyond_m = most_m.next_up();
    std::iter::once(least_m).chain(inner_levels).chain([beyond_m]).collect()
}
