//! The boat's track for plotters and maps.
//!
//! In: a survey with its navigation. Out: pieces of the track, as GeoJSON and GPX.

mod geojson;
mod gpx;

pub(crate) use geojson::track_geojson;
pub(crate) use gpx::{track_gpx, write_track_gpx};

use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::{Navigation, PingNav, Survey};

/// Points of a track are at least this far apart, metres: recorders place a ping no better.
const LEAST_STEP_M: f64 = 0.5;
/// A pause that breaks the track, seconds.
const PAUSE_S: f64 = 10.0;

/// A place of the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackPoint {
    /// The side-scan ping; the sounding in a log without side-scan.
    pub ping: usize,
    /// Seconds after the log's time zero.
    pub time_s: f64,
    /// Where.
    pub position: LonLat,
}

/// A stretch of the track without a pause.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackPiece {
    /// Two points or more.
    pub points: Vec<TrackPoint>,
    /// Metres on the ground.
    pub length_m: f64,
}

/// The track through the pings that have a place, in pieces, thinned to half a metre.
pub fn track(survey: &Survey, navigation: &Navigation) -> Vec<TrackPiece> {
    let mut pieces = Pieces::default();
    let frame = &survey.track.frame;
    let mut add = |ping: usize, time_s: f64, place: &PingNav| {
        let position = navigation.to_lon_lat(&survey.track, place.east_m, place.north_m);
        let at_m = frame.to_enu(position);
        if at_m.iter().all(|metres| metres.is_finite()) {
            let point = TrackPoint { ping, time_s, position };
            pieces.add(point, at_m);
        }
    };
    if survey.side_scan.is_empty() {
        let places = survey.soundings.iter().zip(navigation.soundings.iter());
        (0..).zip(places).for_each(|(ping, (one, place))| add(ping, one.time_s, place));
    } else {
        let places = survey.side_scan.iter().zip(navigation.pings.iter());
        (0..).zip(places).for_each(|(ping, (one, place))| add(ping, one.time_s, place));
    }
    pieces.finish()
}

#[derive(Default)]
struct Pieces {
    done: Vec<TrackPiece>,
    piece: TrackPiece,
    /// The last point that was kept, and the last that came: place and time.
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

    /// Ends a piece at the last point that came.
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
            // 0.1 m a ping, each place twice.
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
