//! The depth map as the files hold it, with the way to the plane of the survey, where the window draws.

use super::plane::Plane;
use crate::bathymetry::{Surface, surface};
use crate::geo::MapPlane;
use crate::pipeline::{ProcessedLog, Products};
use crate::progress::{Cancelled, Progress};
use crate::survey::{Navigation, Survey};
use std::sync::Arc;

/// The surface of all kept points by the `surface.*` settings, in the plane of the system that `crs` names: what
/// `depth.tif` holds. `None` where the depths span no surface.
pub fn depth_surface(
    plane: &Plane<'_>,
    products: &Products,
    progress: &Progress,
) -> Result<Option<Surface>, Cancelled> {
    let points = plane.depth_points(products);
    progress.check()?;
    surface(points, &products.settings.surface, progress)
}

/// The surface of the kept points of all logs of a survey in the plane of a map, by the `surface.*` settings of the first. Each log's
/// points weigh what its own settings give them; where logs meet in a cell the weighted median stands, so that a log with many points
/// there counts more. `None` where the depths span no surface.
///
/// # Errors
/// When the work was cancelled.
pub fn joint_depth_surface(
    logs: &[ProcessedLog],
    map: &MapPlane,
    progress: &Progress,
) -> Result<Option<Surface>, Cancelled> {
    let Some(first) = logs.first() else {
        return Ok(None);
    };
    let mut points = Vec::new();
    for log in logs {
        progress.check()?;
        let plane = Plane::new(&log.survey, &log.products, map.clone());
        points.append(&mut plane.depth_points(&log.products));
    }
    surface(points, &first.products.settings.surface, progress)
}

/// The depth map of a survey.
pub struct DepthChart {
    /// The depths, in the metres of a plane, without their spread.
    pub surface: Surface,
    /// The plane: of the system that `crs` names, or of the UTM zone where that does not fit the survey.
    pub map: MapPlane,
    survey: Arc<Survey>,
    navigation: Arc<Navigation>,
}

impl DepthChart {
    /// Makes the map that `depth.tif` holds; `None` where the depths span no surface.
    pub fn new(
        survey: &Arc<Survey>,
        products: &Products,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let log = ProcessedLog {
            survey: survey.clone(),
            products: products.clone(),
        };
        Self::of_logs(&[log], progress)
    }

    /// Makes the map of all logs of a survey ([`joint_depth_surface`]), which lie in the frame of the first.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn of_logs(logs: &[ProcessedLog], progress: &Progress) -> Result<Option<Self>, Cancelled> {
        let Some(ProcessedLog { survey, products }) = logs.first() else {
            return Ok(None);
        };
        let map = Plane::or_utm(survey, products).map;
        let made = joint_depth_surface(logs, &map, progress)?;
        Ok(made.map(|surface| Self {
            surface: Surface {
                // Millions of cells, and the window shows no spread.
                spread_m: Vec::new(),
                ..surface
            },
            map,
            survey: survey.clone(),
            navigation: products.navigation.clone(),
        }))
    }

    /// The place in the plane of one that is given east and north of the survey's origin, metres.
    pub fn to_map(&self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        let track = &self.survey.track;
        self.map
            .place(self.navigation.to_lon_lat(track, east_m, north_m))
    }

    /// Inverse of [`DepthChart::to_map`].
    pub fn to_survey(&self, place: [f64; 2]) -> [f64; 2] {
        let position = self.map.to_lon_lat(place);
        self.navigation.to_plane(&self.survey.track, position)
    }

    /// Depth at a place east and north of the survey's origin and the distance from its cell to the nearest depth, metres;
    /// `None` where nothing is known.
    pub fn at(&self, place: [f64; 2]) -> Option<(f32, f32)> {
        let [easting_m, northing_m] = self.to_map(place);
        self.surface.at(easting_m, northing_m)
    }
}
