//! Makes the depth map of a survey, which the files and the window share.

use crate::pipeline::{
    CommonUncertainty, ProcessedLog, Same, clip_area, colour_range_m, joint_depth_points,
    joint_depth_surface, map_plane,
};
use bathyscope_bottom::bathymetry::isobaths::{
    ClipArea, DepthExtent, IsobathSettings, NoIsobaths, with_shoalest,
};
use bathyscope_bottom::bathymetry::{
    CellSource, DepthPoint, Light, Surface, SurfaceSettings, hill_shade,
};
use bathyscope_bottom::cloud::{PointClass, PointCloud};
use bathyscope_log::support::geo::{Crs, CrsChoice, MapPlane, bounds_deg};
use bathyscope_log::support::outline::bounds;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::colour_ends;
use bathyscope_log::survey::{Navigation, Survey};
use std::sync::{Arc, OnceLock};

/// Inputs of a depth map: equal keys give equal maps.
#[derive(Clone, PartialEq)]
pub struct DepthMapKey(Vec<DepthMapLogKey>);

#[derive(Clone, PartialEq)]
struct DepthMapLogKey {
    survey: Same<Survey>,
    navigation: Same<Navigation>,
    cloud: Same<PointCloud>,
    classes: Same<Vec<PointClass>>,
    crs: CrsChoice,
    surface: SurfaceSettings,
}

impl DepthMapKey {
    /// Creates the key from the results of some logs.
    pub fn of(logs: &[ProcessedLog]) -> Self {
        let key = |ProcessedLog { survey, products }: &ProcessedLog| DepthMapLogKey {
            survey: Same(survey.clone()),
            navigation: Same(products.navigation.clone()),
            cloud: Same(products.cloud.clone()),
            classes: Same(products.classes.clone()),
            crs: products.settings.crs,
            surface: products.settings.surface.clone(),
        };
        Self(logs.iter().map(key).collect())
    }
}

/// Depth map of a survey.
pub struct DepthMap {
    /// Depths, in the metres of a plane.
    pub surface: Surface,
    /// Plane of the map: of the coordinate system that `crs` names, or of the UTM zone if that
    /// system does not fit the survey.
    pub map: MapPlane,
    /// Direction of the light of the hill-shade.
    pub light: Light,
    /// Ends of the colour scale of depth on the screen, metres
    /// ([`crate::pipeline::Products::depth_range_m`]).
    pub colour_range_m: [f32; 2],
    /// Usual error of the depths ([`Surface::usual_error_m`]): found with the map, since every cell
    /// is examined for it.
    pub usual_error_m: Option<[f64; 2]>,
    /// Error of measured depths ([`Surface::measured_error_m`]), metres; 0 if none is stated.
    measured_error_m: f64,
    /// Farthest distance from a depth to which depths are interpolated, metres.
    pub gap_m: f64,
    bounds_m: OnceLock<[f64; 4]>,
    shade: OnceLock<Vec<u8>>,
    shoalest: OnceLock<Surface>,
    logs: Vec<ProcessedLog>,
    survey: Arc<Survey>,
    navigation: Arc<Navigation>,
}

impl DepthMap {
    /// Creates the depth map of all logs of a survey ([`joint_depth_surface`]), which are in the
    /// local coordinate frame of the first; `None` if the depths span no surface.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(logs: &[ProcessedLog], progress: &Progress) -> Result<Option<Self>, Cancelled> {
        let Some(ProcessedLog { survey, products }) = logs.first() else {
            return Ok(None);
        };
        let origin = survey.track.frame.origin();
        let utm = |_| MapPlane::new(Crs::utm(origin), origin);
        let map = map_plane(survey, &products.settings).unwrap_or_else(utm);
        let Some(mut surface) = joint_depth_surface(logs, &map, progress)? else {
            return Ok(None);
        };
        CommonUncertainty::of(logs, progress)?.add_to(&mut surface);
        let of_surface = || colour_ends(surface.depth_m.iter().copied());
        let range_m = colour_range_m(logs.iter().map(|log| &log.products)).or_else(of_surface);
        Ok(range_m.map(|colour_range_m| Self {
            light: Light::suited(&surface),
            usual_error_m: surface.usual_error_m(),
            measured_error_m: surface.measured_error_m().unwrap_or(0.0),
            surface,
            map,
            colour_range_m,
            gap_m: products.settings.surface.max_gap_m,
            bounds_m: OnceLock::new(),
            shade: OnceLock::new(),
            shoalest: OnceLock::new(),
            logs: logs.to_vec(),
            survey: survey.clone(),
            navigation: products.navigation.clone(),
        }))
    }

    /// Returns the range and the error of the depths, for the levels of isobaths.
    pub fn extent(&self) -> DepthExtent {
        DepthExtent { range_m: self.surface.range_m(), error_m: self.measured_error_m }
    }

    /// Returns the brightness of every cell under [`DepthMap::light`], 0 where it is unknown;
    /// computed at the first call.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn shade(&self, progress: &Progress) -> Result<&[u8], Cancelled> {
        if let Some(shade) = self.shade.get() {
            return Ok(shade);
        }
        let shade = hill_shade(&self.surface, &self.light, progress)?;
        Ok(self.shade.get_or_init(|| shade))
    }

    /// Returns the depths from which the map was made, in the plane of the map.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub(crate) fn depth_points(&self, progress: &Progress) -> Result<Vec<DepthPoint>, Cancelled> {
        joint_depth_points(&self.logs, &self.map, progress)
    }

    /// Returns the surface for shoal-safe isobaths, nowhere deeper than the depths from which the
    /// map was made ([`with_shoalest`]); computed at the first call.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub(crate) fn shoalest(&self, progress: &Progress) -> Result<&Surface, Cancelled> {
        if let Some(shoalest) = self.shoalest.get() {
            return Ok(shoalest);
        }
        let made = with_shoalest(&self.surface, &self.depth_points(progress)?);
        Ok(self.shoalest.get_or_init(|| made))
    }

    /// Returns the area that `isobaths.clip` names, in the plane of the map; `None` if none is
    /// named.
    ///
    /// # Errors
    /// When the file has not been read, or its area is nowhere near the depths.
    pub(crate) fn clip_area(
        &self,
        settings: &IsobathSettings,
    ) -> Result<Option<ClipArea>, NoIsobaths> {
        let area = clip_area(settings, self.bounds_deg(), |at| self.map.place(at))?;
        match (area, &settings.clip) {
            (Some(area), Some(path)) if area.is_empty() => {
                Err(NoIsobaths::AreaElsewhere { path: path.clone() })
            }
            (area, _) => Ok(area),
        }
    }

    /// Returns west, south, east and north of the grid, degrees. The edges of the grid are bent in
    /// degrees, so their middles are included.
    pub fn bounds_deg(&self) -> [f64; 4] {
        let grid = &self.surface.grid;
        let steps = [0.0, 0.5, 1.0];
        let shares = steps.into_iter().flat_map(|across| steps.map(|down| [across, down]));
        bounds_deg(shares.map(|[across, down]| {
            self.map.to_lon_lat([
                grid.west_m + across * grid.columns as f64 * grid.cell_m,
                grid.north_m - down * grid.rows as f64 * grid.cell_m,
            ])
        }))
    }

    /// Returns the place in the plane of the map for a place east and north of the survey's origin,
    /// metres.
    pub fn to_map(&self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        let track = &self.survey.track;
        self.map.place(self.navigation.to_lon_lat(track, east_m, north_m))
    }

    /// Returns the place east and north of the survey's origin, metres: the inverse of
    /// [`DepthMap::to_map`].
    pub fn to_survey(&self, place: [f64; 2]) -> [f64; 2] {
        let position = self.map.to_lon_lat(place);
        self.navigation.to_plane(&self.survey.track, position)
    }

    /// Returns the depth at a place east and north of the survey's origin, and the distance from
    /// its cell to the nearest depth, metres; `None` if the depth is unknown.
    pub fn at(&self, place: [f64; 2]) -> Option<(f32, f32)> {
        let [easting_m, northing_m] = self.to_map(place);
        self.surface.at(easting_m, northing_m)
    }

    /// Returns the source of the depth at a place.
    pub fn source_at(&self, place: [f64; 2]) -> CellSource {
        let [easting_m, northing_m] = self.to_map(place);
        let cell = self.surface.grid.index_at(easting_m, northing_m);
        let source = cell.and_then(|cell| self.surface.source.get(cell));
        source.copied().unwrap_or(CellSource::None)
    }

    /// Returns the depth at a place east and north of the survey's origin, interpolated between the
    /// cells, metres; `None` if it is unknown.
    pub fn depth_at(&self, place: [f64; 2]) -> Option<f32> {
        self.surface.depth_at(self.to_map(place))
    }

    /// Returns west, south, east and north of the grid in the plane of the survey, metres; computed
    /// once, since the map on the screen needs them each time it is drawn.
    pub fn bounds_m(&self) -> [f64; 4] {
        *self.bounds_m.get_or_init(|| {
            let [west_m, south_m, east_m, north_m] = self.surface.grid.bounds_m();
            // The edges of a UTM zone's grid are bent by centimetres in the plane of the survey, so
            // their middles are included.
            let eastings_m = [west_m, 0.5 * (west_m + east_m), east_m].into_iter();
            let northings_m = [south_m, 0.5 * (north_m + south_m), north_m];
            let places = eastings_m.flat_map(|e| northings_m.map(|n| [e, n]));
            bounds(places.map(|place| self.to_survey(place)))
        })
    }
}
