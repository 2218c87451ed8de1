//! The track, made off the window's thread so that a frame costs the same for any survey.

use super::lines::Line;
use super::ping_boxes::PingBoxes;
use super::relief::colour_range_m;
use super::transform::GroundBounds;
use crate::cloud::DepthSource;
use crate::pipeline::Products;
use crate::presentation::colours::{depth_colour, depth_share};
use crate::progress::Progress;
use crate::render::{Specks, Uploader, Vertex};
use crate::survey::{PingNav, Sounding, Survey};

/// Seconds without a record after which the track is broken instead of bridged.
const BREAK_S: f64 = 10.0;
/// Where depth rests on side-scan only, the track shows it in dashes so long, with so much grey between, metres.
const DASH_M: [f64; 2] = [5.0, 2.5];

/// The track, ready to draw and to search.
pub struct TrackLayer {
    /// All of the track.
    pub bounds: GroundBounds,
    /// Ends of the colour scale, metres.
    pub range_m: Option<[f32; 2]>,
    /// Whether depth rests on side-scan only somewhere.
    pub side_scan_only: bool,
    /// The line.
    pub line: Line,
    boxes: PingBoxes,
}

impl TrackLayer {
    /// Its depths are corrected as those of the depth map are. `None` when nothing has a
    /// position, or cancelled.
    pub fn new(
        survey: &Survey,
        products: &Products,
        uploader: Option<&Uploader>,
        progress: &Progress,
    ) -> Option<Self> {
        let range_m = colour_range_m(survey, products);
        let records = records(survey, products);
        let bounds = bounds(records.iter().map(|record| record.place))?;
        let origin_m = [0.5 * (bounds[0] + bounds[2]), 0.5 * (bounds[1] + bounds[3])];
        progress.check().ok()?;
        let side_scan_only = records
            .iter()
            .any(|record| record.source == DepthSource::SideScan);
        let vertices = vertices(&records, origin_m, range_m);
        let line = Line::new(origin_m, vertices, Specks::Kept, uploader);
        progress.check().ok()?;
        Some(Self {
            bounds,
            range_m,
            side_scan_only,
            line,
            boxes: PingBoxes::new(products.navigation.clone()),
        })
    }

    /// The ping nearest to a place, if one is within `reach_m`.
    pub fn nearest_ping(&self, place: [f64; 2], reach_m: f64) -> Option<usize> {
        self.boxes.nearest(place, reach_m)
    }
}

/// A place of the track and the depth there.
struct Record<'a> {
    time_s: f64,
    place: &'a PingNav,
    /// Corrected; NaN without one.
    depth_m: f32,
    source: DepthSource,
}

/// Along the track: of the side-scan pings, or of the soundings in a log without.
fn records<'a>(survey: &Survey, products: &'a Products) -> Vec<Record<'a>> {
    let (navigation, correction) = (&products.navigation, &products.correction);
    if navigation.pings.is_empty() {
        let soundings = survey.soundings.iter().zip(&navigation.soundings);
        let record = |(sounding, place): (&Sounding, &'a PingNav)| Record {
            time_s: sounding.time_s,
            place,
            depth_m: match sounding.locked {
                true => correction.depth_m(sounding.time_s, f64::from(sounding.depth_m)) as f32,
                false => f32::NAN,
            },
            source: DepthSource::Sounding,
        };
        return soundings.map(record).collect();
    }
    let pings = survey.side_scan.iter().zip(&navigation.pings);
    let pings = pings.zip(products.depths.iter());
    let records = pings.map(|((ping, place), depth)| Record {
        time_s: ping.time_s,
        place,
        depth_m: depth.depth_m,
        source: depth.source,
    });
    records.collect()
}

fn vertices(
    records: &[Record<'_>],
    [east_m, north_m]: [f64; 2],
    range_m: Option<[f32; 2]>,
) -> Vec<Vertex> {
    let mut line = Vec::with_capacity(records.len() + 1);
    let mut last_s = f64::NEG_INFINITY;
    let (mut way_m, mut last): (f64, Option<&PingNav>) = (0.0, None);
    for record in records {
        if record.time_s - last_s > BREAK_S {
            line.push(Vertex::BREAK);
        }
        last_s = record.time_s;
        let place = record.place;
        let step_m = last.map_or(0.0, |last| {
            (place.east_m - last.east_m).hypot(place.north_m - last.north_m)
        });
        last = Some(place);
        // Of NaN and a number, this is the number.
        way_m += step_m.max(0.0);
        let [dash_m, gap_m] = DASH_M;
        let is_gap = record.source == DepthSource::SideScan && way_m % (dash_m + gap_m) > dash_m;
        let share = match range_m {
            Some(range_m) if !is_gap => depth_share(record.depth_m, range_m),
            _ => f32::NAN,
        };
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
