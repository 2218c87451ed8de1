//! Writes measured lines and areas as GeoJSON or CSV, and the depth profile along a drawn line as a
//! table.

use super::geojson::{collection, feature_at, position};
use super::{ExportError, millimetres, write_bytes};
use bathyscope_bottom::bathymetry::TransectStation;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::{Navigation, Survey};
use bathyscope_objects::targets::ShadowHeight;
use serde_json::{Value, json};
use std::path::Path;

/// A line or an area that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredFigure {
    /// Name of the log under the figure.
    pub log: String,
    /// `distance`, `area`, `profile` or `height`.
    pub kind: &'static str,
    /// Corners in the order of drawing.
    pub corners: Vec<LonLat>,
    /// Distances from the start to each corner, metres on the ellipsoid.
    pub distances_m: Vec<f64>,
    /// Length of the line, or perimeter of the area, metres.
    pub length_m: f64,
    /// Area, square metres; `None` for a line.
    pub area_m2: Option<f64>,
    /// Measurements that a height is computed from by its shadow; `None` for other figures.
    pub shadow: Option<ShadowHeight>,
    /// Places along a profile, with distance from the start and depth, metres; a depth of `None`
    /// where none is known.
    pub stations: Vec<(LonLat, f64, Option<f32>)>,
}

/// Writes a `LineString` or a `Polygon` with the measured values, and a `Point` for each place of a
/// profile.
pub fn figure_geojson(path: &Path, figure: &MeasuredFigure) -> Result<(), ExportError> {
    let points = figure.stations.iter().map(Some);
    let features = std::iter::once(None).chain(points);
    collection(path, features, |station, _| match station {
        None => outline(figure),
        Some(station) => station_feature(station),
    })?;
    Ok(())
}

fn outline(figure: &MeasuredFigure) -> Value {
    let mut places: Vec<[f64; 2]> = figure.corners.iter().map(|at| position(*at)).collect();
    let geometry = match figure.area_m2 {
        None => json!({ "type": "LineString", "coordinates": places }),
        Some(_) => {
            // Outlines run counter-clockwise and end where they begin (RFC 7946, 3.1.6).
            if turns_right(&places) {
                places.reverse();
            }
            places.extend(places.first().copied());
            json!({ "type": "Polygon", "coordinates": [places] })
        }
    };
    let mut properties = json!({
        "log": figure.log,
        "measured": figure.kind,
        "length_m": millimetres(figure.length_m),
    });
    if let Some(area_m2) = figure.area_m2 {
        properties["area_m2"] = json!(millimetres(area_m2));
    }
    if let Some(shadow) = &figure.shadow {
        for (name, value_m) in shadow_columns(shadow) {
            properties[name] = json!(millimetres(value_m));
        }
        properties["height_is_least"] = json!(shadow.is_least);
    }
    json!({ "type": "Feature", "geometry": geometry, "properties": properties })
}

/// Returns a height and the measurements it is computed from, metres, with the names of their
/// columns.
fn shadow_columns(shadow: &ShadowHeight) -> [(&'static str, f64); 5] {
    [
        ("height_m", shadow.height_m()),
        ("height_sigma_m", shadow.sigma_m()),
        ("altitude_m", shadow.altitude_m),
        ("shadow_start_m", shadow.top_m),
        ("shadow_end_m", shadow.end_m),
    ]
}

fn station_feature((at, distance_m, depth_m): &(LonLat, f64, Option<f32>)) -> Value {
    let depth_m = depth_m.map(|depth_m| millimetres(f64::from(depth_m)));
    let properties = json!({ "distance_m": millimetres(*distance_m), "depth_m": depth_m });
    feature_at("Point", position(*at), properties)
}

/// Returns true if a ring runs clockwise, by its signed area.
fn turns_right(ring: &[[f64; 2]]) -> bool {
    let next = ring.iter().cycle().skip(1);
    let doubled: f64 = ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
    doubled < 0.0
}

/// Writes a line for each corner, `corner,lon,lat,distance_m`. An area has a further column
/// `area_m2` and ends with its first corner again, at the length of its perimeter; a height has
/// further columns, `height_m` and the measurements it is computed from.
pub fn figure_csv(path: &Path, figure: &MeasuredFigure) -> Result<(), ExportError> {
    let area = figure.area_m2;
    let mut text = "corner,lon,lat,distance_m".to_owned();
    let mut whole = String::new();
    let area_column = area.map(|area_m2| ("area_m2", area_m2));
    let shadow_columns = figure.shadow.as_ref().map(shadow_columns);
    for (name, value) in area_column.into_iter().chain(shadow_columns.into_iter().flatten()) {
        text += &format!(",{name}");
        whole += &format!(",{value:.3}");
    }
    text.push('\n');
    let corners = figure.corners.iter().zip(&figure.distances_m);
    let closing = area.and(figure.corners.first()).map(|first| (first, &figure.length_m));
    for (index, (at, distance_m)) in corners.chain(closing).enumerate() {
        let corner = index % figure.corners.len() + 1;
        text += &format!("{corner},{:.9},{:.9},{distance_m:.3}{whole}\n", at.lon_deg, at.lat_deg);
    }
    write_bytes(path, text)
}

/// Returns a table with one line for each station, `distance_m,lon,lat,east_m,north_m,depth_m`:
/// metres on the ground from the start, WGS84, the survey's local coordinate frame as in
/// `cloud.csv`, and the depth, empty where none is known.
pub fn profile_csv(
    survey: &Survey,
    navigation: &Navigation,
    stations: &[TransectStation],
) -> String {
    let mut text = "distance_m,lon,lat,east_m,north_m,depth_m\n".to_owned();
    for station in stations {
        let [east_m, north_m] = station.place;
        let at = navigation.to_lon_lat(&survey.track, east_m, north_m);
        let depth = station.depth_m.map_or_else(String::new, |depth_m| format!("{depth_m:.3}"));
        text += &format!(
            "{:.3},{:.9},{:.9},{east_m:.4},{north_m:.4},{depth}\n",
            station.distance_m, at.lon_deg, at.lat_deg
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(area_m2: Option<f64>) -> MeasuredFigure {
        let at = |lon_deg, lat_deg| LonLat { lon_deg, lat_deg };
        MeasuredFigure {
            log: "pond".to_owned(),
            kind: "area",
            // Clockwise.
            corners: vec![at(8.0, 47.0), at(8.0, 47.001), at(8.001, 47.0)],
            distances_m: vec![0.0, 111.2, 246.6],
            length_m: 322.7,
            area_m2,
            shadow: None,
            stations: Vec::new(),
        }
    }

    #[test]
    fn an_area_is_a_closed_ring_to_the_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("area.geojson");
        figure_geojson(&path, &triangle(Some(4227.0))).unwrap();
        let read: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let feature = &read["features"][0];
        assert_eq!(feature["properties"]["area_m2"], 4227.0);
        assert_eq!(
            feature["geometry"]["coordinates"],
            json!([[[8.001, 47.0], [8.0, 47.001], [8.0, 47.0], [8.001, 47.0]]])
        );
    }

    #[test]
    fn the_table_of_an_area_ends_where_it_begins() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("area.csv");
        figure_csv(&path, &triangle(Some(4227.0))).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with(
            "corner,lon,lat,distance_m,area_m2\n1,8.000000000,47.000000000,0.000,4227.000\n"
        ));
        assert!(text.ends_with("1,8.000000000,47.000000000,322.700,4227.000\n"), "{text}");
        figure_csv(&path, &triangle(None)).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().count(), 4, "{text}");
    }
}
