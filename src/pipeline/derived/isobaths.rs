//! Lines of equal depth through a depth map.

use super::DepthMap;
use crate::bathymetry::Surface;
use crate::bathymetry::isobaths::{Isobath, IsobathSettings, Smoothing, isobaths, smoothed};
use crate::pipeline::Same;
use crate::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::sync::Arc;

/// Lines shorter than this, metres, are left out: rounded to the millimetre of the files, they are no lines any more.
const LEAST_LENGTH_M: f64 = 0.01;

/// What isobaths are made of; equal keys give equal lines.
#[derive(Clone, PartialEq)]
pub struct IsobathKey {
    depth_map: Same<DepthMap>,
    settings: IsobathSettings,
}

impl IsobathKey {
    /// Of a depth map by `isobaths.*`.
    pub fn of(depth_map: &Arc<DepthMap>, settings: &IsobathSettings) -> Self {
        Self {
            depth_map: Same(depth_map.clone()),
            settings: settings.clone(),
        }
    }
}

/// The isobaths of a depth map.
#[derive(Clone, Debug, Default)]
pub struct Isobaths {
    /// Their depths from shallow to deep, metres.
    pub levels_m: Vec<f64>,
    /// The lines in the plane of the depth map, as they run through its cells.
    pub lines: Vec<Isobath>,
    /// Whether every depth that is shallower than a line lies on its shallow side.
    pub shoal_safe: bool,
}

impl Isobaths {
    /// At some depths, metres, from shallow to deep; `shoal_safe` where no depth that is shallower than a line may lie beyond it.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        depth_map: &DepthMap,
        levels_m: Vec<f64>,
        shoal_safe: bool,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let surface = drawn_on(depth_map, shoal_safe, progress)?;
        let mut lines = isobaths(surface, &levels_m, progress)?;
        lines.retain(|line| line.length_m() > LEAST_LENGTH_M);
        Ok(Self {
            levels_m,
            lines,
            shoal_safe,
        })
    }

    /// The surface that the lines run through.
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

    /// The lines as they are drawn: smoothed in so many rounds, each as places in the plane of the survey, metres.
    pub fn on_ground(&self, depth_map: &DepthMap, rounds: u32) -> Vec<Vec<[f64; 2]>> {
        let smoothing = Smoothing {
            passes: rounds,
            toward_deep: self.shoal_safe,
        };
        let on_ground = |line: &Isobath| {
            let places = smoothed(&line.points, smoothing).into_iter();
            places.map(|place| depth_map.to_survey(place)).collect()
        };
        self.lines.par_iter().map(on_ground).collect()
    }
}

/// The surface that isobaths are drawn on.
fn drawn_on<'a>(
    depth_map: &'a DepthMap,
    shoal_safe: bool,
    progress: &Progress,
) -> Result<&'a Surface, Cancelled> {
    match shoal_safe {
        true => depth_map.shoalest(progress),
        false => Ok(&depth_map.surface),
    }
}
