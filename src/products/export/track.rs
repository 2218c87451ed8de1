//! Writes the boat's track for plotters and maps, and the ground that its side-scan insonified.
//!
//! In: a survey with its navigation. Out: pieces of the track, as GeoJSON and as GPX 1.1 (for
//! plotters and handheld receivers); the ground as GeoJSON.

use super::geojson::{areas, collection, feature_at, line_at};
use super::{ExportError, GPX_HEAD, Summary, millimetres, write_summed};
use bathyscope_bottom::bathymetry::isobaths::Polygon;
use bathyscope_log::support::calendar::timestamp;
use bathyscope_log::support::geo::{LonLat, MapPlane};
use bathyscope_log::support::printable::xml;
use bathyscope_log::survey::{Navigation, Survey};
use serde_json::json;
use std::io::{self, Write};
use std::path::Path;

/// Least distance between points of a track, metres: recorders place a ping no better.
const LEAST_STEP_M: f64 = 0.5;
/// Length of a pause that breaks the track, seconds.
const PAUSE_S: f64 = 10.0;

/// A point of the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackPoint {
    /// Index of the side-scan ping; that of the sounding in a log without side-scan.
    pub ping: usize,
    /// Time of the point, seconds after the log's time zero.
    pub time_s: f64,
    /// Position of the point.
    pub position: LonLat,
}

/// A stretch of the track without a pause.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackPiece {
    /// Points of the piece, at least two.
    pub points: Vec<TrackPoint>,
    /// Length on the ground, metres.
    pub length_m: f64,
}

/// Returns the track through the pings that have a place, in pieces, thinned to half a metre.
pub fn track(survey: &Survey, navigation: &Navigation) -> Vec<TrackPiece> {
    let mut pieces = Pieces::default();
    let frame = &survey.track.frame;
    let has_pings = !survey.side_scan.is_empty();
    let places = if has_pings { &navigation.pings } else { &navigation.soundings };
    let records = survey.record_times_s().into_iter().zip(places.iter());
    for (ping, (time_s, place)) in records.enumerate() {
        let position = navigation.to_lon_lat(&survey.track, place.east_m, place.north_m);
        let at_m = frame.to_enu(position);
        if at_m.iter().all(|metres| metres.is_finite()) {
            pieces.add(TrackPoint { ping, time_s, position }, at_m);
        }
    }
    pieces.finish()
}

#[derive(Default)]
struct Pieces {
    done: Vec<TrackPiece>,
    piece: TrackPiece,
    /// Place of the last point that was kept; `None` at the beginning of a piece.
    kept_m: Option<[f64; 2]>,
    came: Option<(TrackPoint, [f64; 2])>,
}

impl Pieces {
    fn add(&mut self, point: TrackPoint, at_m: [f64; 2]) {
        let paused = |(last, _): &(TrackPoint, [f64; 2])| point.time_s - last.time_s > PAUSE_S;
        if self.came.as_ref().is_some_and(paused) {
            self.close();
        }
        let step_m = self.kept_m.map_or(f64::INFINITY, |from| apart_m(from, at_m));
        if step_m >= LEAST_STEP_M {
            self.keep(point, at_m);
        }
        self.came = Some((point, at_m));
    }

    fn keep(&mut self, point: TrackPoint, at_m: [f64; 2]) {
        self.piece.length_m += self.kept_m.map_or(0.0, |from| apart_m(from, at_m));
        self.piece.points.push(point);
        self.kept_m = Some(at_m);
    }

    /// Ends a piece at the last point that was added.
    fn close(&mut self) {
        if let Some((point, at_m)) = self.came.take()
            && self.kept_m.is_some_and(|from| apart_m(from, at_m) > 0.0)
        {
            self.keep(point, at_m);
        }
        self.kept_m = None;
        let piece = std::mem::take(&mut self.piece);
        if piece.points.len() > 1 {
            self.done.push(piece);
        }
    }

    fn finish(mut self) -> Vec<TrackPiece> {
        self.close();
        self.done
    }
}

fn apart_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Writes each piece of the track as a line.
pub(crate) fn track_geojson(path: &Path, pieces: &[TrackPiece]) -> Result<Summary, ExportError> {
    let feature = |piece: &TrackPiece, summary: &mut Summary| {
        summary.count += 1;
        let ends = [piece.points.first(), piece.points.last()];
        let [from, to] = ends.map(|end| end.map(|point| (point.ping, point.time_s)));
        let properties = json!({
            "ping_from": from.map(|end| end.0),
            "ping_to": to.map(|end| end.0),
            "from_s": from.map(|end| end.1),
            "to_s": to.map(|end| end.1),
            "length_m": millimetres(piece.length_m),
        });
        line_at(piece.points.iter().map(|point| point.position), properties, summary)
    };
    collection(path, pieces.iter(), feature)
}

/// Writes the pieces as segments of one track; with times if the start of the log (Unix seconds) is
/// known.
pub(crate) fn track_gpx(
    path: &Path,
    name: &str,
    start_unix_s: Option<f64>,
    pieces: &[TrackPiece],
) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
        for point in pieces.iter().flat_map(|piece| &piece.points) {
            summary.add([point.position.lon_deg, point.position.lat_deg], f64::NAN);
        }
        write_track_gpx(out, name, start_unix_s, pieces)
    })
}

/// Does the same as [`track_gpx`] for an output that is open.
pub(crate) fn write_track_gpx(
    out: &mut impl Write,
    name: &str,
    start_unix_s: Option<f64>,
    pieces: &[TrackPiece],
) -> io::Result<()> {
    let name = xml(name);
    writeln!(out, "{GPX_HEAD}>\n<trk><name>{name}</name>")?;
    for piece in pieces {
        writeln!(out, "<trkseg>")?;
        for point in &piece.points {
            let (lon, lat) = (point.position.lon_deg, point.position.lat_deg);
            write!(out, "<trkpt lat=\"{lat:.8}\" lon=\"{lon:.8}\">")?;
            if let Some(start_unix_s) = start_unix_s {
                let time = timestamp(start_unix_s + point.time_s);
                write!(out, "<time>{time}</time>")?;
            }
            writeln!(out, "</trkpt>")?;
        }
        writeln!(out, "</trkseg>")?;
    }
    writeln!(out, "</trk>\n</gpx>")
}

/// The ground that the side-scan insonified.
pub(crate) struct SideScanCoverage {
    /// Outlines of the ground, in the plane of the map; empty without side-scan.
    pub shapes: Vec<Polygon>,
    /// Area on the ground, square metres.
    pub area_m2: f64,
}

impl SideScanCoverage {
    /// Creates the coverage from outlines in the plane of a map.
    pub(crate) fn new(shapes: Vec<Polygon>, map: &MapPlane) -> Self {
        // Without any corner there is nothing to draw.
        let Some(first) = shapes.first().and_then(|shape| shape.outline.first()).copied() else {
            return Self { shapes: Vec::new(), area_m2: 0.0 };
        };
        let on_map_m2: f64 = shapes.iter().map(|shape| shape.area_m2()).sum();
        Self { shapes, area_m2: on_map_m2 / map.area_scale_at(first) }
    }

    /// Returns the area for a file, rounded to a tenth of a square metre.
    pub(super) fn rounded_m2(&self) -> f64 {
        (self.area_m2 * 10.0).round() / 10.0
    }
}

/// Writes the insonified ground of one log as one feature with its area.
pub(crate) fn footprint_geojson(
    path: &Path,
    name: &str,
    ground: &SideScanCoverage,
    place: impl Fn([f64; 2]) -> LonLat,
) -> Result<Summary, ExportError> {
    let feature = |_: (), summary: &mut Summary| {
        let polygons = areas(&ground.shapes, &place);
        summary.count += 1;
        let corners = polygons.iter().flatten().flatten();
        corners.for_each(|corner| summary.reach(*corner));
        let properties = json!({ "log": name, "area_m2": ground.rounded_m2() });
        feature_at("MultiPolygon", polygons, properties)
    };
    collection(path, std::iter::once(()), feature)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_breaks_the_track_and_repeats_go() {
        let mut pieces = Pieces::default();
        let mut add = |ping: usize, time_s: f64, east_m: f64| {
            let position = LonLat { lon_deg: east_m, lat_deg: 0.0 };
            let point = TrackPoint { ping, time_s, position };
            pieces.add(point, [east_m, 0.0]);
        };
        for ping in 0..100 {
            // 0.1 m a ping, each position twice.
            add(ping, 0.1 * ping as f64, 0.1 * (ping / 2) as f64);
        }
        add(100, 60.0, 50.0);
        add(101, 61.0, 53.0);
        add(102, 90.0, 60.0);
        let pieces = pieces.finish();
        assert_eq!(pieces.len(), 2, "a single place is no track");
        let first = &pieces[0];
        assert!((first.length_m - 4.9).abs() < 1e-9, "{}", first.length_m);
        assert!(first.points.len() < 12);
        let ends = [&first.points[0], &first.points[first.points.len() - 1]];
        assert_eq!(ends.map(|point| point.ping), [0, 99]);
        assert_eq!(pieces[1].points.len(), 2);
    }
}
