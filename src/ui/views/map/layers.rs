//! The track, made off the window's thread so that a frame costs the same for any survey.

use super::lines::Line;
use super::ping_boxes::PingBoxes;
use super::relief::colour_range_m;
use super::transform::GroundBounds;
use crate::cloud::Correction;
use crate::progress::Progress;
use crate::render::{Specks, Uploader, Vertex, depth_colour, depth_share};
use crate::survey::{Navigation, PingNav, Survey};
use std::sync::Arc;

/// Seconds without a record after which the track is broken instead of bridged.
const BREAK_S: f64 = 10.0;
/// The track, ready to draw and to search.
pub struct TrackLayer {
    /// All of the track.
    pub bounds: GroundBounds,
    /// Ends of the colour scale, metres.
    pub range_m: Option<[f32; 2]>,
    /// The line.
    pub line: Line,
    boxes: PingBoxes,
}

impl TrackLayer {
    /// Its depths are corrected as those of the depth map are. `None` when nothing has a
    /// position, or cancelled.
    pub fn new(
        survey: &Survey,
        navigation: Arc<Navigation>,
        correction: &Correction,
        uploader: Option<&Uploader>,
        progress: &Progress,
    ) -> Option<Self> {
        let range_m = colour_range_m(survey, correction);
        let corrected = |(time_s, place, depth_m)| {
            let depth_m = correction.depth_m(time_s, f64::from(depth_m)) as f32;
            (time_s, place, depth_m)
        };
        let records = || records(survey, &navigation).map(corrected);
        let bounds = bounds(records().map(|(_, place, _)| place))?;
        let origin_m = [0.5 * (bounds[0] + bounds[2]), 0.5 * (bounds[1] + bounds[3])];
        progress.check().ok()?;
        let vertices = vertices(records(), origin_m, range_m);
        let line = Line::new(origin_m, vertices, Specks::Kept, uploader);
        progress.check().ok()?;
        Some(Self {
            bounds,
            range_m,
            line,
            boxes: PingBoxes::new(navigation),
        })
    }

    /// The ping nearest to a place, if one is within `reach_m`.
    pub fn nearest_ping(&self, place: [f64; 2], reach_m: f64) -> Option<usize> {
        self.boxes.nearest(place, reach_m)
    }
}

/// Time, place and depth along the track: of the side-scan pings, or of the soundings in a log without.
fn records<'a>(
    survey: &'a Survey,
    navigation: &'a Navigation,
) -> impl Iterator<Item = (f64, &'a PingNav, f32)> {
    let pings = survey.side_scan.iter().zip(&navigation.pings);
    let pings = pings.map(|(ping, place)| (ping.time_s, place, ping.locked_depth_m()));
    let places = match navigation.pings.is_empty() {
        true => &navigation.soundings[..],
        false => &[],
    };
    let soundings = survey.soundings.iter().zip(places);
    pings.chain(soundings.map(|(sounding, place)| {
        let depth_m = match sounding.locked {
            true => sounding.depth_m,
            false => f32::NAN,
        };
        (sounding.time_s, place, depth_m)
    }))
}

fn vertices<'a>(
    records: impl Iterator<Item = (f64, &'a PingNav, f32)>,
    [east_m, north_m]: [f64; 2],
    range_m: Option<[f32; 2]>,
) -> Vec<Vertex> {
    let mut line = Vec::with_capacity(records.size_hint().0 + 1);
    let mut last_s = f64::NEG_INFINITY;
    for (time_s, place, depth_m) in records {
        if time_s - last_s > BREAK_S {
            line.push(Vertex::BREAK);
        }
        last_s = time_s;
        let share = range_m.map_or(f32::NAN, |range_m| depth_share(depth_m, range_m));
        let [r, g, b] = depth_colour(share);
        line.push(Vertex {
            place: [
                (place.east_m - east_m) as f32,
                (place.north_m - north_m) as f32,
            ],
            colour: [r, g, b, 255],
        });
    }
    line
}

fn bounds<'a>(places: impl Iterator<Item = &'a PingNav>) -> Option<GroundBounds> {
    places
        .filter(|place| place.east_m.is_finite() && place.north_m.is_finite())
        .fold(None, |all: Option<GroundBounds>, place| {
            let (e, n) = (place.east_m, place.north_m);
            let [west, south, east, north] = all.unwrap_or([e, n, e, n]);
            Some([west.min(e), south.min(n), east.max(e), north.max(n)])
        })
}
