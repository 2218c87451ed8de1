//! The depth map as the files hold it, with the way to the plane of the survey, where the window draws.

use super::plane::Plane;
use crate::bathymetry::{Surface, surface};
use crate::geo::UtmZone;
use crate::pipeline::Products;
use crate::progress::{Cancelled, Progress};
use crate::survey::{Navigation, Survey};
use std::sync::Arc;

/// The surface of all kept points by the `surface.*` settings, in the UTM zone of the survey's first fix: what `depth.tif`
/// holds. `None` where the depths span no surface.
pub(super) fn depth_surface(
    plane: &Plane<'_>,
    products: &Products,
    progress: &Progress,
) -> Result<Option<Surface>, Cancelled> {
    let points = plane.depth_points(products);
    progress.check()?;
    surface(&points, &products.settings.surface, progress)
}

/// The depth map of a survey.
pub struct DepthChart {
    /// The depths, in the metres of a UTM zone.
    pub surface: Surface,
    /// The zone of the survey's first fix.
    pub zone: UtmZone,
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
        let plane = Plane::of(survey, products);
        let made = depth_surface(&plane, products, progress)?;
        let zone = plane.zone;
        Ok(made.map(|surface| Self {
            surface,
            zone,
            survey: survey.clone(),
            navigation: products.navigation.clone(),
        }))
    }

    /// Easting and northing of a place that is given east and north of the survey's origin, metres.
    pub fn to_zone(&self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        let track = &self.survey.track;
        self.zone
            .to_metres(self.navigation.to_lon_lat(track, east_m, north_m))
    }

    /// Inverse of [`DepthChart::to_zone`].
    pub fn to_survey(&self, place: [f64; 2]) -> [f64; 2] {
        let position = self.zone.to_lon_lat(place);
        self.navigation.to_plane(&self.survey.track, position)
    }

    /// Depth at a place east and north of the survey's origin and the distance from its cell to the nearest depth, metres;
    /// `None` where nothing is known.
    pub fn at(&self, place: [f64; 2]) -> Option<(f32, f32)> {
        let [easting_m, northing_m] = self.to_zone(place);
        self.surface.at(easting_m, northing_m)
    }
}
