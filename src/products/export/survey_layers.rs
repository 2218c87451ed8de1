//! Makes the layers of `survey.gpkg`: the track, the insonified ground, and the lines, areas and
//! soundings of the depth map.

use super::geopackage::{FeatureGeometry, Layer, Ring};
use super::isobaths::DrawnLines;
use super::millimetres;
use super::qgis_style::{
    depth_area_style, footprint_style, isobath_style, spot_sounding_style, track_style,
};
use super::rings::rounded;
use super::sqlite::{Value, count, text};
use super::track::{SideScanCoverage, TrackPiece};
use bathyscope_bottom::bathymetry::DepthPoint;
use bathyscope_bottom::bathymetry::isobaths::{DepthArea, Isobath, IsobathSettings, Polygon};
use bathyscope_log::support::geo::{LonLat, MapPlane};

/// Number of steps of coordinates in a metre and in a degree: a step is a millimetre.
const STEPS_M: f64 = 1e3;
const STEPS_DEG: f64 = 1e8;

/// Converter from the plane of a map to geometries in the map's coordinate system.
pub(crate) struct MapGeometry<'a> {
    map: &'a MapPlane,
    steps: f64,
}

impl<'a> MapGeometry<'a> {
    /// Creates the converter to the coordinate system of a map.
    pub(crate) fn new(map: &'a MapPlane) -> Self {
        let steps = if map.crs.is_degrees() { STEPS_DEG } else { STEPS_M };
        Self { map, steps }
    }

    /// Converts a position, rounded to the millimetre.
    pub(crate) fn position(&self, at: LonLat) -> [f64; 2] {
        self.rounded(self.map.crs.place(at))
    }

    /// Converts a place of the plane, rounded to the millimetre.
    fn place(&self, at: [f64; 2]) -> [f64; 2] {
        self.rounded(self.map.in_crs(at))
    }

    fn rounded(&self, place: [f64; 2]) -> [f64; 2] {
        place.map(|value| (value * self.steps).round() / self.steps)
    }

    fn polygons(&self, shapes: &[Polygon]) -> Vec<Vec<Ring>> {
        rounded(shapes, self.steps, |at| self.map.in_crs(at))
    }
}

/// Returns the layer of the track, a line for each piece.
pub(crate) fn track_layer(placed: &MapGeometry<'_>, pieces: &[TrackPiece]) -> Layer {
    let feature = |piece: &TrackPiece| {
        let places = piece.points.iter().map(|point| placed.position(point.position));
        let ends = [piece.points.first(), piece.points.last()];
        let pings = ends.map(|end| end.map_or(Value::Null, |end| count(end.ping)));
        let times = ends.map(|end| Value::Real(end.map_or(f64::NAN, |end| end.time_s)));
        let length = [Value::Real(millimetres(piece.length_m))];
        let values = pings.into_iter().chain(times).chain(length).collect();
        Some((line_through(places)?, values))
    };
    Layer {
        name: "track",
        title: "Track",
        about: "The boat's track",
        geometry: "LINESTRING",
        columns: "ping_from INTEGER, ping_to INTEGER, from_s DOUBLE, to_s DOUBLE, length_m DOUBLE"
            .into(),
        features: pieces.iter().filter_map(feature).collect(),
        style: track_style(),
    }
}

/// Returns the layer of the ground that the side-scan insonified, one feature with its area on the
/// ground.
pub(crate) fn footprint_layer(
    placed: &MapGeometry<'_>,
    name: &str,
    ground: &SideScanCoverage,
) -> Layer {
    let polygons = placed.polygons(&ground.shapes);
    let is_some = !polygons.is_empty();
    let values = vec![text(name), Value::Real(ground.rounded_m2())];
    let feature = is_some.then_some((FeatureGeometry::Polygons(polygons), values));
    Layer {
        name: "footprint",
        title: "Footprint",
        about: "The ground that the side-scan insonified",
        geometry: "MULTIPOLYGON",
        columns: "log TEXT, area_m2 DOUBLE".into(),
        features: feature.into_iter().collect(),
        style: footprint_style(),
    }
}

/// Returns the layer of isobaths. A metre of the plane is `scale` metres on the ground.
pub(crate) fn isobath_layer(placed: &MapGeometry<'_>, drawn: &DrawnLines<'_>, scale: f64) -> Layer {
    let feature = |line: &Isobath| {
        let places = line.points.iter().map(|point| placed.place(*point));
        let depth = drawn.settings.in_unit(line.depth_m);
        let flags = [drawn.is_index(line), line.is_ring()];
        let [is_index, is_ring] = flags.map(|flag| Value::Integer(flag.into()));
        let values = vec![
            Value::Real(line.depth_m),
            Value::Real(depth),
            text(drawn.settings.unit.symbol()),
            text(&depth.to_string()),
            is_index,
            is_ring,
            Value::Real(millimetres(scale * line.length_m())),
        ];
        Some((line_through(places)?, values))
    };
    Layer {
        name: "isobaths",
        title: "Isobaths",
        about: "Lines of equal depth",
        geometry: "LINESTRING",
        columns: "depth_m DOUBLE, depth DOUBLE, unit TEXT, label TEXT, is_index BOOLEAN, ring BOOLEAN, length_m DOUBLE".into(),
        features: drawn.lines.iter().filter_map(feature).collect(),
        style: isobath_style(),
    }
}

/// Returns the layer of the areas between depths, coloured by depth: `colour` returns the colour of
/// a share of the range from the shallowest to the deepest. A square metre of the plane is `ground`
/// square metres on the ground.
pub(crate) fn depth_area_layer(
    placed: &MapGeometry<'_>,
    areas: &[DepthArea],
    ground: f64,
    colour: impl Fn(f32) -> [u8; 3],
) -> Layer {
    let filled = || areas.iter().filter(|area| !area.polygons.is_empty());
    let feature = |area: &DepthArea| {
        let numbers = [area.from_m, area.to_m, ground * area.area_m2()];
        let values = numbers.map(|number| Value::Real(millimetres(number)));
        let polygons = FeatureGeometry::Polygons(placed.polygons(&area.polygons));
        (polygons, values.into())
    };
    let ends = areas.first().zip(areas.last());
    let [least_m, most_m] = ends.map_or([0.0; 2], |(first, last)| [first.from_m, last.to_m]);
    let classes = filled().map(|area| {
        let middle_m = 0.5 * (area.from_m + area.to_m);
        let share = (middle_m - least_m) / (most_m - least_m).max(f64::MIN_POSITIVE);
        ([area.from_m, area.to_m].map(millimetres), colour(share as f32))
    });
    let style = depth_area_style(&classes.collect::<Vec<_>>());
    Layer {
        name: "depth_areas",
        title: "Depth areas",
        about: "Areas between depths",
        geometry: "MULTIPOLYGON",
        columns: "from_m DOUBLE, to_m DOUBLE, area_m2 DOUBLE".into(),
        features: filled().map(feature).collect(),
        style,
    }
}

/// Returns the layer of spot soundings: depths as the figures that a chart prints.
pub(crate) fn spot_sounding_layer(
    placed: &MapGeometry<'_>,
    soundings: &[DepthPoint],
    settings: &IsobathSettings,
) -> Layer {
    let feature = |point: &DepthPoint| {
        let at = FeatureGeometry::Point(placed.place([point.east_m, point.north_m]));
        let values = vec![
            Value::Real(millimetres(point.depth_m)),
            text(settings.unit.symbol()),
            text(&settings.charted(point.depth_m)),
            Value::Integer(point.is_sounding.into()),
        ];
        (at, values)
    };
    Layer {
        name: "spot_soundings",
        title: "Spot soundings",
        about: "The shoalest depths of their surroundings",
        geometry: "POINT",
        columns: "depth_m DOUBLE, unit TEXT, label TEXT, is_sounding BOOLEAN".into(),
        features: soundings.iter().map(feature).collect(),
        style: spot_sounding_style(),
    }
}

/// Returns a line through places; `None` where all places are the same to the millimetre.
fn line_through(places: impl Iterator<Item = [f64; 2]>) -> Option<FeatureGeometry> {
    let mut places: Vec<[f64; 2]> = places.collect();
    places.dedup();
    (places.len() > 1).then_some(FeatureGeometry::Line(places))
}
