//! Collects the contents of one frame of the map.

use super::isobaths::IsobathLayer;
use super::layers::TrackLayer;
use super::residuals::ResidualLayer;
use super::transform::MapTransform;
use crate::app::{MapLayer, ViewOptions};
use crate::ui::theme;
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{DepthMap, Products};
use egui::{Color32, Pos2, Rect};
use std::sync::Arc;

/// Contents of a frame of the map.
pub(super) struct MapScene<'a> {
    pub rect: Rect,
    pub transform: MapTransform,
    pub survey: &'a Survey,
    pub products: &'a Products,
    pub track: &'a Arc<TrackLayer>,
    /// The depth map; outer `None` while it is not needed or not ready, inner `None` if the depths
    /// do not span an area.
    pub depth_map: Option<Option<&'a Arc<DepthMap>>>,
    /// The isobaths; `None` while they are not shown or not ready.
    pub isobaths: Option<Arc<IsobathLayer>>,
    /// The residuals; `None` while they are not shown or not ready.
    pub residuals: Option<Arc<ResidualLayer>>,
    /// True if soundings have a fault, because of which the track is grey there.
    pub has_faults: bool,
    /// Number of pings of the shown log that depth map, isobaths and mosaic are made of; `None` if
    /// these are made of all pings. A log that is being followed has more pings.
    pub made_of: Option<usize>,
    /// True if some of the pings are excluded.
    pub has_excluded: bool,
    /// True if a log has depths across the track.
    pub has_swath: bool,
    /// The stretch that is proposed for the scale; `None` if no stretch is.
    pub proposed: Option<PingRange>,
    pub options: &'a ViewOptions,
}

impl MapScene<'_> {
    /// Returns a place on the screen.
    pub(super) fn at(&self, place: [f64; 2]) -> Pos2 {
        self.transform.to_screen(self.rect, place)
    }

    /// Returns the WGS84 position of a place on the screen.
    pub(super) fn position(&self, at: Pos2) -> LonLat {
        let [east_m, north_m] = self.transform.to_ground(self.rect, at);
        let navigation = &self.products.navigation;
        navigation.to_lon_lat(&self.survey.track, east_m, north_m)
    }

    /// Returns the ends of the colour scale of depth, metres; `None` without depths.
    pub(super) fn range_m(&self) -> Option<[f32; 2]> {
        let of_surface = || Some(self.depth_map.flatten()?.colour_range_m);
        self.track.range_m.or_else(of_surface)
    }

    /// Returns true if a layer is drawn.
    pub(super) fn shows(&self, layer: MapLayer) -> bool {
        self.options.map.layers.is_visible(layer)
    }

    /// Returns the colour of words on the map.
    pub(super) fn text_colour(&self) -> Color32 {
        theme::canvas_text_colour(self.options)
    }
}
