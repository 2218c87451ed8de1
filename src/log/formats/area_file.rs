//! Reads the polygon of a water body from a GeoJSON, KML or GPX file.

use super::gpx::{is, lon_lat, text_of};
use crate::support::file_error::{FaultText, FileError};
use crate::support::geo::LonLat;
use crate::support::regular_file;
use crate::survey::WaterArea;
use quick_xml::Reader;
use quick_xml::events::Event;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// Size of the largest area file that is read, bytes; enough for any shoreline that a boat follows.
const LONGEST: u64 = 1 << 26;
/// Most corners that all rings of an area may have together.
const MOST_CORNERS: usize = 100_000;
/// Fewest corners of a ring; a ring with fewer corners has no area and is left out.
const LEAST_CORNERS: usize = 3;

/// Reads the polygons of a GeoJSON or KML file, or the tracks and routes of a GPX file; each track
/// segment and each route becomes a ring.
///
/// # Errors
/// When the file cannot be read, is damaged, contains no polygon or has too many corners.
pub fn read_area(path: &Path) -> Result<WaterArea, FileError> {
    let fail = FileError::<FaultText>::at(path);
    let text = regular_file::read_text(path, LONGEST)
        .map_err(|error| fail(format!("cannot read the area: {error}").into()))?;
    let hash = Sha256::digest(text.as_bytes());
    let bytes = text.len();
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let rings = if text.starts_with('<') { of_xml(text) } else { of_geojson(text) };
    Ok(WaterArea {
        path: path.to_owned(),
        bytes,
        sha256: hash.iter().map(|byte| format!("{byte:02x}")).collect(),
        rings: checked(rings.map_err(fail)?).map_err(fail)?,
    })
}

type Rings = Vec<Vec<[f64; 2]>>;

/// Returns the rings that have enough corners, without repeated corners; fails where a corner is
/// not on Earth, no ring is left or there are too many corners.
fn checked(rings: Rings) -> Result<Vec<Vec<LonLat>>, FaultText> {
    let mut made = Vec::new();
    for ring in rings {
        let mut corners: Vec<LonLat> = (ring.iter())
            .map(|[lon_deg, lat_deg]| LonLat { lon_deg: *lon_deg, lat_deg: *lat_deg })
            .collect();
        if let Some(bad) = corners.iter().find(|corner| !corner.is_on_earth()) {
            return Err(format!(
                "a corner of the area is no longitude and latitude ({}, {}); write it in degrees of WGS84",
                bad.lon_deg, bad.lat_deg
            )
            .into());
        }
        corners.dedup();
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() >= LEAST_CORNERS {
            made.push(corners);
        }
    }
    match made.iter().map(Vec::len).sum::<usize>() {
        0 => Err("the area has no polygon; draw one, and save it as GeoJSON, KML or GPX".into()),
        count if count > MOST_CORNERS => {
            Err(format!("the area has {count} corners; simplify it to {MOST_CORNERS} at most")
                .into())
        }
        _ => Ok(made),
    }
}

/// Returns the rings of all polygons in a GeoJSON text, at any level of its collections.
fn of_geojson(text: &str) -> Result<Rings, FaultText> {
    let root: Value = serde_json::from_str(text)
        .map_err(|error| format!("the area is neither GeoJSON nor KML nor GPX: {error}"))?;
    let mut rings = Vec::new();
    let mut left = vec![&root];
    while let Some(value) = left.pop() {
        let coordinates = &value["coordinates"];
        match value["type"].as_str() {
            Some("FeatureCollection") => {
                left.extend(value["features"].as_array().into_iter().flatten())
            }
            Some("GeometryCollection") => {
                left.extend(value["geometries"].as_array().into_iter().flatten())
            }
            Some("Feature") => left.push(&value["geometry"]),
            Some("Polygon") => add_polygon(coordinates, &mut rings),
            Some("MultiPolygon") => {
                let polygons = coordinates.as_array().into_iter().flatten();
                polygons.for_each(|polygon| add_polygon(polygon, &mut rings));
            }
            _ => {}
        }
    }
    Ok(rings)
}

fn add_polygon(polygon: &Value, rings: &mut Rings) {
    let place = |place: &Value| Some([place.get(0)?.as_f64()?, place.get(1)?.as_f64()?]);
    let each = polygon.as_array().into_iter().flatten();
    rings.extend(each.map(|ring| {
        let corners = ring.as_array().into_iter().flatten();
        corners.filter_map(place).collect::<Vec<[f64; 2]>>()
    }));
}

/// Returns the rings of a KML text, or the tracks and routes of a GPX text.
fn of_xml(text: &str) -> Result<Rings, FaultText> {
    let mut reader = Reader::from_str(text);
    reader.config_mut().allow_dangling_amp = true;
    let mut rings: Rings = Vec::new();
    // True while the reader is inside a ring, and inside the coordinates of a ring.
    let (mut in_ring, mut in_coordinates) = (false, false);
    let mut coordinates = String::new();
    loop {
        let event = reader.read_event().map_err(|error| {
            format!("the area is damaged at byte {}: {error}", reader.error_position())
        })?;
        match &event {
            Event::Eof => return Ok(rings),
            Event::Start(element) if is(element, "LinearRing") => in_ring = true,
            Event::Start(element) if is(element, "coordinates") => in_coordinates = in_ring,
            Event::Start(element) if is(element, "trkseg") || is(element, "rte") => {
                rings.push(Vec::new());
            }
            Event::Start(element) | Event::Empty(element)
                if is(element, "trkpt") || is(element, "rtept") =>
            {
                if let Some(ring) = rings.last_mut() {
                    ring.extend(lon_lat(element));
                }
            }
            Event::End(_) if in_coordinates => {
                rings.push(kml_places(&std::mem::take(&mut coordinates)));
                (in_ring, in_coordinates) = (false, false);
            }
            event if in_coordinates => coordinates.extend(text_of(event)),
            _ => {}
        }
    }
}

/// Parses places of the form `lon,lat[,height]`, separated by white space.
fn kml_places(text: &str) -> Vec<[f64; 2]> {
    let place = |tuple: &str| {
        let mut numbers = tuple.split(',').map(|number| number.trim().parse::<f64>().ok());
        Some([numbers.next()??, numbers.next()??])
    };
    text.split_whitespace().filter_map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Vec<LonLat>>, FileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("area");
        std::fs::write(&path, text).unwrap();
        read_area(&path).map(|area| area.rings)
    }

    #[test]
    fn one_polygon_with_an_island_is_the_same_in_three_formats() {
        let geojson = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"Polygon",
            "coordinates":[[[8,47],[8.1,47],[8.1,47.1],[8,47]],[[8.04,47.01],[8.06,47.01],[8.06,47.03],[8.04,47.01]]]}}]}"#;
        let kml = "<?xml version='1.0'?><kml xmlns='http://www.opengis.net/kml/2.2'><Placemark><Point><coordinates>1,2</coordinates></Point></Placemark>\
            <Placemark><Polygon><outerBoundaryIs><LinearRing><tessellate>1</tessellate><coordinates>\n 8,47,0 8.1,47,0\n8.1,47.1 8,47 </coordinates>\
            </LinearRing></outerBoundaryIs><innerBoundaryIs><LinearRing><coordinates>8.04,47.01 8.06,47.01 8.06,47.03 8.04,47.01</coordinates>\
            </LinearRing></innerBoundaryIs></Polygon></Placemark></kml>";
        let gpx = "<gpx><wpt lat='1' lon='1'/><trk><trkseg><trkpt lat='47' lon='8'/><trkpt lat='47' lon='8.1'><ele>1</ele></trkpt><trkpt lat='47.1' lon='8.1'/>\
            </trkseg></trk><rte><rtept lat='47.01' lon='8.04'/><rtept lat='47.01' lon='8.06'/><rtept lat='47.03' lon='8.06'/></rte></gpx>";
        let [geojson, kml, gpx] = [geojson, kml, gpx].map(|text| read(text).unwrap());
        assert_eq!(geojson.iter().map(Vec::len).collect::<Vec<_>>(), [3, 3]);
        assert_eq!(geojson, kml);
        assert_eq!(geojson, gpx);
    }

    #[test]
    fn what_is_no_area_is_refused_in_a_sentence() {
        for (text, words) in [
            ("hello", "neither GeoJSON nor KML nor GPX"),
            ("{}", "no polygon"),
            ("<gpx/>", "no polygon"),
            ("<kml><a></b></kml>", "damaged at byte"),
            (
                r#"{"type":"Polygon","coordinates":[[[500000,5200000],[1,2],[3,4]]]}"#,
                "degrees of WGS84",
            ),
            (r#"{"type":"LineString","coordinates":[[1,2],[3,4]]}"#, "no polygon"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(words) && error.ends_with("area"), "{text}: {error}");
        }
    }
}
