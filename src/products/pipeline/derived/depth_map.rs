//! Makes the depth map of a survey, which the files and the window share, and the area that clips
//! its isobaths, transformed from degrees into the plane of the map.

use crate::pipeline::{
    CommonUncertainty, ProcessedLog, Same, colour_range_m, joint_depth_points, joint_depth_surface,
    map_plane,
};
use bathyscope_bottom::bathymetry::isobaths::{
    ClipArea, DepthExtent, IsobathSettings, NoIsobaths, with_shoalest,
};
use bathyscope_bottom::bathymetry::{
    CellSource, DepthPoint, Light, Surface, SurfaceSettings, hill_shade,
};
use bathyscope_bottom::cloud::{PointClass, PointCloud};
use bathyscope_log::support::geo::{Crs, CrsChoice, LonLat, MapPlane, bounds_deg};
use bathyscope_log::support::outline::{between, bounds, edges};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::colour_ends;
use bathyscope_log::survey::{Navigation, Survey};
use std::sync::{Arc, OnceLock};

/// Length of the pieces into which edges are cut, metres. Edges are straight in degrees, pieces are
/// straight in the plane; at this length they differ by less than a millimetre.
const PIECE_M: f64 = 50.0;
/// Most pieces of all edges; longer edges are cut into longer pieces.
const MOST_PIECES: f64 = 1e6;
/// Margin around the map within which edges count, degrees: a shoreline may be that of a continent,
/// which no plane can hold.
const MARGIN_DEG: f64 = 0.01;

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

/// Returns the area that `isobaths.clip` names, within a box about the map (west, south, east,
/// north, degrees) and in the plane to which `place` transforms; `None` if no area is named. The
/// area may be empty.
///
/// # Errors
/// When the file of the area has not been read.
pub fn clip_area(
    settings: &IsobathSettings,
    bounds_deg: [f64; 4],
    place: impl Fn(LonLat) -> [f64; 2],
) -> Result<Option<ClipArea>, NoIsobaths> {
    let Some(path) = &settings.clip else {
        return Ok(None);
    };
    let Some(area) = &settings.area else {
        return Err(NoIsobaths::AreaNotRead { path: path.clone() });
    };
    let [west, south, east, north] = bounds_deg;
    let around = [west - MARGIN_DEG, south - MARGIN_DEG, east + MARGIN_DEG, north + MARGIN_DEG];
    let middle_deg = 0.5 * (west + east);
    let rings = area.rings.iter().map(|ring| clip_ring(ring, middle_deg, around));
    let rings: Vec<Vec<[f64; 2]>> = rings.filter(|ring| !ring.is_empty()).collect();
    let place = |[lon_deg, lat_deg]: [f64; 2]| place(LonLat { lon_deg, lat_deg });
    let length_m = |[from, to]: [[f64; 2]; 2]| {
        let [from, to] = [from, to].map(place);
        (to[0] - from[0]).hypot(to[1] - from[1])
    };
    let all_m: f64 = rings.iter().flat_map(|ring| edges(ring)).map(length_m).sum();
    let piece_m = PIECE_M.max(all_m / MOST_PIECES);
    let in_pieces = |ring: &Vec<[f64; 2]>| {
        let corners = edges(ring).flat_map(|edge| {
            let count = (length_m(edge) / piece_m).ceil().max(1.0) as usize;
            let [from, to] = edge;
            (0..count).map(move |step| between(from, to, step as f64 / count as f64))
        });
        corners.map(place).collect()
    };
    Ok(Some(ClipArea::new(rings.iter().map(in_pieces).collect())))
}

/// Clips a ring to a box (Sutherland and Hodgman 1974): the parts outside follow the edges of the
/// box. A ring beyond the date line is moved by whole turns, so that its middle is nearest to
/// `middle_deg`.
fn clip_ring(ring: &[LonLat], middle_deg: f64, around: [f64; 4]) -> Vec<[f64; 2]> {
    let [west, _, east, _] = bounds(ring.iter().map(|at| [at.lon_deg, at.lat_deg]));
    let turns = ((middle_deg - 0.5 * (west + east)) / 360.0).round();
    let near = |at: &LonLat| [at.lon_deg + 360.0 * turns, at.lat_deg];
    let mut ring: Vec<[f64; 2]> = ring.iter().map(near).collect();
    let [west, south, east, north] = around;
    for (axis, edge, sign) in [(0, west, 1.0), (0, east, -1.0), (1, south, 1.0), (1, north, -1.0)] {
        let is_in = |at: [f64; 2]| sign * (at[axis] - edge) >= 0.0;
        let mut cut = Vec::with_capacity(ring.len());
        for [from, to] in edges(&ring) {
            if is_in(from) {
                cut.push(from);
            }
            if is_in(from) != is_in(to) {
                let share = (edge - from[axis]) / (to[axis] - from[axis]);
                let mut at = between(from, to, share);
                at[axis] = edge;
                cut.push(at);
            }
        }
        ring = cut;
    }
    ring
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::WaterArea;

    fn settings(corners: &[[f64; 2]]) -> IsobathSettings {
        let ring = corners.iter().map(|[lon_deg, lat_deg]| LonLat::new(*lon_deg, *lat_deg));
        IsobathSettings {
            clip: Some("shore.kml".into()),
            area: Some(Arc::new(WaterArea { rings: vec![ring.collect()], ..WaterArea::default() })),
            ..IsobathSettings::default()
        }
    }

    /// Converts degrees to metres: a hundred kilometres a degree.
    fn plane(at: LonLat) -> [f64; 2] {
        [1e5 * at.lon_deg, 1e5 * at.lat_deg]
    }

    #[test]
    fn a_shore_that_is_far_larger_than_the_map_is_what_lies_about_the_map() {
        // A hemisphere, whose southern edge runs through the map.
        let half = [[-180.0, 47.0], [180.0, 47.0], [180.0, 90.0], [-180.0, 90.0]];
        let map = [8.0, 46.99, 8.02, 47.01];
        let area = clip_area(&settings(&half), map, plane);
        let area = area.expect("it was read").expect("it is named");
        assert!(area.holds([8.01e5, 47.001e5]) && !area.holds([8.01e5, 46.999e5]));
        let elsewhere = clip_area(&settings(&half), [8.0, -40.0, 8.02, -39.9], plane);
        assert!(elsewhere.is_ok_and(|area| area.is_some_and(|area| area.is_empty())));
    }

    #[test]
    fn beyond_the_date_line_longitudes_are_those_of_the_map() {
        let bay = [[-179.999, 10.0], [-179.99, 10.0], [-179.99, 10.01]];
        let area = clip_area(&settings(&bay), [179.995, 10.0, 180.02, 10.01], plane);
        let area = area.expect("it was read").expect("it is named");
        assert!(area.holds([180.005e5, 10.001e5]));
    }

    #[test]
    fn what_was_not_read_is_said_and_what_is_not_named_cuts_nothing() {
        let mut named = settings(&[]);
        named.area = None;
        let error = clip_area(&named, [0.0; 4], plane).expect_err("it was not read");
        assert!(
            error.to_string().contains("has not been read")
                && error.to_string().ends_with("shore.kml")
        );
        named.clip = None;
        assert!(clip_area(&named, [0.0; 4], plane).is_ok_and(|area| area.is_none()));
    }
}
