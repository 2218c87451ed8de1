//! Takes the depths along the line of a depth profile from the depth map.

use super::App;
use bathyscope_bottom::bathymetry::{Corner, TransectStation, transect};
use bathyscope_log::support::geo::LonLat;
use bathyscope_products::pipeline::DepthMap;
use bathyscope_products::project::{Measurement, MeasurementKind};
use std::sync::Arc;

/// Greatest number of places along a line at which depths are taken.
const MOST_STATIONS: usize = 2000;

/// The depths along a line, with the line and the depth map that they come from.
#[derive(Clone)]
pub struct ProfileLine {
    line: Measurement,
    map: Option<Arc<DepthMap>>,
    /// Places along the line with their depths.
    pub stations: Vec<TransectStation>,
    /// Distance from the start of the line to each corner, metres.
    pub corners_m: Vec<f64>,
}

impl ProfileLine {
    /// Returns true if there is no depth map to take depths from.
    pub(crate) fn lacks_map(&self) -> bool {
        self.map.is_none()
    }

    fn is_of(&self, line: &Measurement, map: Option<&Arc<DepthMap>>) -> bool {
        self.line == *line && self.map.as_ref().map(Arc::as_ptr) == map.map(Arc::as_ptr)
    }

    fn new(
        line: Measurement,
        map: Option<&Arc<DepthMap>>,
        place: impl Fn(LonLat) -> [f64; 2],
    ) -> Self {
        let corners_m = line.distances_m();
        let corners: Vec<Corner> = (line.corners.iter().zip(&corners_m))
            .map(|(at, distance_m)| Corner { place: place(*at), distance_m: *distance_m })
            .collect();
        // Two samples in each cell miss nothing that is drawn.
        let step_m = map.map_or(f64::INFINITY, |map| 0.5 * map.surface.grid.cell_m);
        let depth_at = |place| map?.depth_at(place);
        Self {
            stations: transect(&corners, step_m, MOST_STATIONS, depth_at),
            line,
            map: map.cloned(),
            corners_m,
        }
    }
}

const NO_LINE: &str = "there is no line to cut along: draw a depth profile on the map first";

impl App {
    /// Turns the cut of the 3D view along the line of the profile on or off.
    pub(super) fn toggle_cut(&mut self) {
        if self.map.measuring.stations().is_empty() {
            return self.notices.warn(NO_LINE.to_owned());
        }
        self.view.options.cloud.cut = !self.view.options.cloud.cut;
    }

    /// Takes the depths along the line again if the line or the depth map has changed.
    pub(super) fn follow_profile(&mut self) {
        let is_profile = |line: &Measurement| line.kind == MeasurementKind::Profile;
        let figure = self.map.measuring.figure.as_deref();
        let set = figure.map(|figure| figure.measurement.clone());
        let set = set.filter(is_profile);
        let next = self.map.measuring.next.filter(|_| self.map.measuring.is_drawing());
        let drawn = set.clone().map(|line| match next {
            Some(next) => line.with(next, None),
            None => line,
        });
        self.map.measuring.set = self.profile_line(set, self.map.measuring.set.as_ref());
        self.map.measuring.drawn = match drawn {
            // The finished and the drawn line are the same, so the depths are shared.
            Some(drawn) if self.map.measuring.set.as_ref().is_some_and(|set| set.line == drawn) => {
                self.map.measuring.set.clone()
            }
            drawn => self.profile_line(drawn, self.map.measuring.drawn.as_ref()),
        };
    }

    fn profile_line(
        &self,
        line: Option<Measurement>,
        before: Option<&Arc<ProfileLine>>,
    ) -> Option<Arc<ProfileLine>> {
        let (survey, products) =
            self.logs.shown.survey.as_ref().zip(self.logs.shown.products.as_ref())?;
        let (line, map) = (line?, self.depth_map().flatten());
        if let Some(before) = before.filter(|before| before.is_of(&line, map)) {
            return Some(before.clone());
        }
        let place = |at| products.navigation.to_plane(&survey.track, at);
        Some(Arc::new(ProfileLine::new(line, map, place)))
    }
}
