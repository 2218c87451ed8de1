//! Holds the functions that all writers of GeoJSON files (RFC 7946) share.
//!
//! A line or an area that crosses the 180th meridian is split into several that do not cross it
//! (RFC 7946, 3.1.9).

use super::rings::rounded;
use super::{ExportError, Summary, write_summed};
use bathyscope_bottom::bathymetry::isobaths::Polygon;
use bathyscope_log::support::geo::LonLat;
use serde::Serialize;
use serde_json::{Value, json};
use std::io::Write as _;
use std::path::Path;

/// Number of steps of longitude and latitude in a degree: 1e-8 of a degree is a millimetre.
const STEPS: f64 = 1e8;

/// Writes a feature collection, one feature a line, so that only one feature at a time is in memory
/// as text.
pub(super) fn collection<T>(
    path: &Path,
    things: impl Iterator<Item = T>,
    feature: impl Fn(T, &mut Summary) -> Value,
) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
        out.write_all(b"{ \"type\": \"FeatureCollection\", \"features\": [")?;
        for (index, thing) in things.enumerate() {
            out.write_all(if index == 0 { b"\n" } else { b",\n" })?;
            serde_json::to_writer(&mut *out, &feature(thing, summary))?;
        }
        out.write_all(b"\n] }\n")
    })
}

/// Returns a feature of a collection.
pub(super) fn feature_at(kind: &str, coordinates: impl Serialize, properties: Value) -> Value {
    let geometry = json!({ "type": kind, "coordinates": coordinates });
    json!({ "type": "Feature", "geometry": geometry, "properties": properties })
}

/// Returns longitude and latitude, rounded to a millimetre.
pub(super) fn position(at: LonLat) -> [f64; 2] {
    [at.lon_deg, at.lat_deg].map(|degrees| (degrees * STEPS).round() as i64 as f64 / STEPS)
}

/// Returns the positions of a line without repeated neighbours.
pub(super) fn positions(places: impl Iterator<Item = LonLat>) -> Vec<[f64; 2]> {
    let mut positions: Vec<[f64; 2]> = places.map(position).collect();
    positions.dedup();
    positions
}

/// Returns the coordinates of a `MultiPolygon`: polygons, each an outline and its holes, valid
/// after rounding.
pub(super) fn areas(
    shapes: &[Polygon],
    place: &impl Fn([f64; 2]) -> LonLat,
) -> Vec<Vec<Vec<[f64; 2]>>> {
    rounded(&cut_areas(shapes, place), STEPS, |at| at)
}

/// Returns a line as a feature: a `LineString`, or a `MultiLineString` where it crosses the 180th
/// meridian.
pub(super) fn line_at(
    places: impl Iterator<Item = LonLat>,
    properties: Value,
    summary: &mut Summary,
) -> Value {
    let mut parts: Vec<Vec<[f64; 2]>> = cut_line(places)
        .into_iter()
        .map(|part| positions(part.into_iter().map(|[lon, lat]| LonLat::new(lon, lat))))
        .collect();
    parts.iter().flatten().for_each(|at| summary.reach(*at));
    match parts.len() {
        0 | 1 => feature_at("LineString", parts.pop().unwrap_or_default(), properties),
        _ => feature_at("MultiLineString", parts, properties),
    }
}

/// Longitude and latitude, degrees.
type Degrees = [f64; 2];

/// Returns the equivalent longitude that is nearest to another one, degrees; it may lie beyond 180.
fn near_deg(lon_deg: f64, other_deg: f64) -> f64 {
    lon_deg - 360.0 * ((lon_deg - other_deg) / 360.0).round()
}

/// Returns the index of the whole turn that a longitude lies in: 0 from -180 to 180 degrees.
fn turn(lon_deg: f64) -> i64 {
    ((lon_deg + 180.0) / 360.0).floor() as i64
}

/// Returns the longitude where a turn ends and the next one begins, degrees.
fn border_deg(turn: i64) -> f64 {
    360.0 * turn as f64 + 180.0
}

/// Returns the place where the way from one place to another crosses a longitude.
fn crossing(from: Degrees, to: Degrees, lon_deg: f64) -> Degrees {
    let share = (lon_deg - from[0]) / (to[0] - from[0]);
    [lon_deg, from[1] + share * (to[1] - from[1])]
}

/// Returns the places along a line with continuous longitudes: neighbours differ by at most half a
/// turn.
fn unrolled(places: impl Iterator<Item = LonLat>) -> Vec<Degrees> {
    let mut unrolled: Vec<Degrees> = Vec::new();
    for LonLat { lon_deg, lat_deg } in places {
        let lon_deg = unrolled.last().map_or(lon_deg, |last| near_deg(lon_deg, last[0]));
        unrolled.push([lon_deg, lat_deg]);
    }
    unrolled
}

/// Returns the parts of a line, each within -180 to 180 degrees.
fn cut_line(places: impl Iterator<Item = LonLat>) -> Vec<Vec<Degrees>> {
    let (mut parts, mut part) = (Vec::new(), Vec::new());
    let mut last: Option<Degrees> = None;
    let in_turn = |[lon_deg, lat_deg]: Degrees, turn: i64| [lon_deg - 360.0 * turn as f64, lat_deg];
    for place in unrolled(places) {
        if let Some(from) = last {
            let (mut at, end) = (turn(from[0]), turn(place[0]));
            while at != end {
                let next = at + (end - at).signum();
                let border = crossing(from, place, border_deg(at.min(next)));
                part.push(in_turn(border, at));
                parts.push(std::mem::replace(&mut part, vec![in_turn(border, next)]));
                at = next;
            }
        }
        part.push(in_turn(place, turn(place[0])));
        last = Some(place);
    }
    parts.push(part);
    // A line that only touches the meridian has no part beyond it.
    parts.retain(|part| part.iter().any(|place| Some(place) != part.first()));
    parts
}

/// Returns polygons in degrees, each within -180 to 180; `place` returns the position of a corner.
/// Polygons that do not cross the meridian are only converted.
fn cut_areas(shapes: &[Polygon], place: &impl Fn([f64; 2]) -> LonLat) -> Vec<Polygon> {
    let mut cut = Vec::new();
    for shape in shapes {
        let first_deg = shape.outline.first().map_or(0.0, |corner| place(*corner).lon_deg);
        let ring = |corners: &Vec<[f64; 2]>| -> Vec<Degrees> {
            let corners = corners.iter().map(|corner| place(*corner));
            corners.map(|at| [near_deg(at.lon_deg, first_deg), at.lat_deg]).collect()
        };
        let outline = ring(&shape.outline);
        let holes: Vec<Vec<Degrees>> = shape.holes.iter().map(ring).collect();
        let turns = || outline.iter().map(|corner| turn(corner[0]));
        let (from, to) = (turns().min().unwrap_or(0), turns().max().unwrap_or(0));
        for at in from..=to {
            let ring_in_turn = |ring: &Vec<Degrees>| {
                if from == to { moved(ring.clone(), at) } else { moved(within_turn(ring, at), at) }
            };
            let part = Polygon {
                outline: ring_in_turn(&outline),
                holes: holes.iter().map(ring_in_turn).filter(|hole| !hole.is_empty()).collect(),
            };
            if !part.outline.is_empty() {
                cut.push(split_at_borders(part));
            }
        }
    }
    cut
}

/// Moves a ring from a turn to turn 0.
fn moved(mut ring: Vec<Degrees>, turn: i64) -> Vec<Degrees> {
    ring.iter_mut().for_each(|corner| corner[0] -= 360.0 * turn as f64);
    ring
}

/// Returns the part of a closed ring that lies in a turn (Sutherland and Hodgman 1974); sides along
/// the borders of the turn may overlap.
fn within_turn(ring: &[Degrees], turn: i64) -> Vec<Degrees> {
    let east_of = clipped(ring, border_deg(turn - 1), 1.0);
    clipped(&east_of, border_deg(turn), -1.0)
}

/// Returns the part of a closed ring on one side of a longitude: east of it where `sign` is 1.
fn clipped(ring: &[Degrees], lon_deg: f64, sign: f64) -> Vec<Degrees> {
    let is_inside = |corner: &Degrees| sign * (corner[0] - lon_deg) >= 0.0;
    let mut inside: Vec<Degrees> = Vec::new();
    for pair in ring.windows(2) {
        if is_inside(&pair[0]) {
            inside.push(pair[0]);
        }
        if is_inside(&pair[0]) != is_inside(&pair[1]) {
            inside.push(crossing(pair[0], pair[1], lon_deg));
        }
    }
    inside.extend(inside.first().copied());
    inside
}

/// Adds a corner to a polygon wherever a corner of another side lies on a side along a border, so
/// that overlapping sides have the same ends.
fn split_at_borders(polygon: Polygon) -> Polygon {
    let rings = || std::iter::once(&polygon.outline).chain(&polygon.holes);
    let is_border = |corner: &Degrees| corner[0].abs() == 180.0;
    let mut on_border: Vec<Degrees> = rings().flatten().copied().filter(is_border).collect();
    on_border.sort_unstable_by(|a, b| a[1].total_cmp(&b[1]));
    let split = |ring: &Vec<Degrees>| -> Vec<Degrees> {
        let mut corners: Vec<Degrees> = ring.first().copied().into_iter().collect();
        for pair in ring.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            if is_border(&from) && from[0] == to[0] {
                let is_between = |corner: &&Degrees| {
                    let [low, high] = [from[1].min(to[1]), from[1].max(to[1])];
                    corner[0] == from[0] && low < corner[1] && corner[1] < high
                };
                let between: Vec<Degrees> = on_border.iter().filter(is_between).copied().collect();
                if from[1] < to[1] {
                    corners.extend(between)
                } else {
                    corners.extend(between.into_iter().rev())
                }
            }
            corners.push(to);
        }
        corners
    };
    Polygon { outline: split(&polygon.outline), holes: polygon.holes.iter().map(split).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place([lon_deg, lat_deg]: [f64; 2]) -> LonLat {
        // The longitude wraps at 180 degrees, as in a log's local coordinate frame.
        LonLat::new(near_deg(lon_deg, 0.0), lat_deg)
    }

    #[test]
    fn a_line_across_the_meridian_becomes_two_that_meet_there() {
        let line = [[179.0, 0.0], [179.5, 1.0], [180.5, 3.0], [181.0, 3.0]];
        let parts = cut_line(line.into_iter().map(place));
        let west = vec![[179.0, 0.0], [179.5, 1.0], [180.0, 2.0]];
        let east = vec![[-180.0, 2.0], [-179.5, 3.0], [-179.0, 3.0]];
        assert_eq!(parts, [west, east]);
        let back = cut_line(line.into_iter().rev().map(place));
        assert_eq!(back[0].last(), Some(&[-180.0, 2.0]));
        assert_eq!(back[1].first(), Some(&[180.0, 2.0]));
        let near_zero = [[-1.0, 5.0], [1.0, 6.0]];
        assert_eq!(cut_line(near_zero.into_iter().map(place)), [near_zero]);
        assert!(cut_line(std::iter::empty()).is_empty());
    }

    #[test]
    fn areas_across_the_meridian_keep_their_size_and_their_holes() {
        // A comb with two teeth to the east, and a hole across the meridian.
        let outline = vec![
            [178.0, 0.0],
            [182.0, 0.0],
            [182.0, 1.0],
            [179.5, 1.0],
            [179.5, 3.0],
            [182.0, 3.0],
            [182.0, 6.0],
            [178.0, 6.0],
            [178.0, 0.0],
        ];
        let hole = vec![[179.0, 4.0], [179.0, 5.0], [181.0, 5.0], [181.0, 4.0], [179.0, 4.0]];
        let whole = Polygon { outline, holes: vec![hole] };
        let parts = cut_areas(std::slice::from_ref(&whole), &place);
        assert_eq!(parts.len(), 2);
        for part in &parts {
            let corners = || std::iter::once(&part.outline).chain(&part.holes).flatten();
            assert!(corners().all(|corner| corner[0].abs() <= 180.0), "{part:?}");
            let east = corners().any(|corner| corner[0] < 0.0);
            assert!(corners().all(|corner| (corner[0] < 0.0) == east), "{part:?}");
        }
        let area: f64 = parts.iter().map(Polygon::area_m2).sum();
        assert!((area - whole.area_m2()).abs() < 1e-9, "{area}");
        let valid = rounded(&parts, 1e8, |at| at);
        // The two teeth are separate parts now; the western part is one.
        assert_eq!(valid.len(), 3, "{valid:?}");
        let square = |ring: &Vec<[f64; 2]>| -> f64 {
            ring.windows(2).map(|w| (w[0][0] * w[1][1] - w[1][0] * w[0][1]) / 2.0).sum()
        };
        let area: f64 = valid.iter().flatten().map(square).sum();
        assert!((area - whole.area_m2()).abs() < 1e-6, "{area}");
    }
}
