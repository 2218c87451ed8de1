//! Prepares the tracks of the map in a background thread, so that a frame costs the same for any
//! survey, and draws them: a line coloured by depth with an outline that sets it off from the depth
//! map. Where positions come from another receiver, the recorder's own track is drawn beneath it
//! for comparison. At the selected ping, antenna and transducer are shown where they are apart.

use super::MapScene;
use super::lines::{LinePicture, MapLine, MapPen};
use super::transform::{GroundBounds, NOWHERE, PlaceBoxes, around};
use crate::app::{App, LogId, MapLayer, VisibleLog};
use crate::ui::render::{Specks, Uploader, Vertex};
use crate::ui::theme;
use crate::ui::views::legend;
use bathyscope_bottom::cloud::{Correction, DepthSource, PingDepth};
use bathyscope_bottom::presentation::colours::{depth_colour, depth_share};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Navigation, PingNav, Sounding, Survey};
use bathyscope_products::pipeline::{ProcessedLog, Same};
use eframe::egui_wgpu::RenderState;
use egui::{Align2, Painter, Pos2, Shape, Stroke, vec2};
use std::sync::Arc;

/// Seconds without a record above which the track is broken instead of bridged.
const BREAK_S: f64 = 10.0;
/// Lengths of a coloured dash and of the grey gap after it where depth comes from side-scan only,
/// metres.
const DASH_M: [f64; 2] = [5.0, 2.5];

/// Inputs of the tracks of some logs; equal keys give equal tracks.
pub(super) type TrackKey = (Vec<LogTrackKey>, Option<[f32; 2]>, bool);

/// Inputs of the track of a log: the log and its colour, and what the track is made from.
type LogTrackKey =
    ((LogId, [u8; 3]), Same<Survey>, Same<Navigation>, Same<Vec<PingDepth>>, Arc<Correction>);

/// Returns the key of these logs with a colour scale between two depths, metres; `by_log` colours
/// by log instead of depth.
pub(super) fn key(logs: &[VisibleLog], range_m: Option<[f32; 2]>, by_log: bool) -> TrackKey {
    let key = |shown: &VisibleLog| {
        let products = &shown.log.products;
        let navigation = Same(products.navigation.clone());
        let depths = Same(products.depths.clone());
        let survey = Same(shown.log.survey.clone());
        ((shown.id, shown.colour), survey, navigation, depths, products.correction.clone())
    };
    (logs.iter().map(key).collect(), range_m, by_log)
}

/// The tracks of all logs, ready to draw and to search.
pub(super) struct TrackLayer {
    /// Bounds of all tracks.
    pub bounds: GroundBounds,
    /// Ends of the colour scale, metres; `None` where tracks are not coloured by depth.
    pub range_m: Option<[f32; 2]>,
    /// True if depth somewhere comes from side-scan only and tracks are coloured by depth.
    pub side_scan_only: bool,
    /// Names and colours of the logs; empty where the tracks are coloured by depth.
    pub logs: Vec<(String, [u8; 3])>,
    /// The line of all tracks.
    pub line: MapLine,
    /// Pings of each log, and the boxes around them.
    boxes: Vec<(LogId, Arc<Navigation>, PlaceBoxes)>,
}

impl TrackLayer {
    /// Creates the tracks, with depths corrected like those of the depth map; `None` when nothing
    /// has a position, or when cancelled.
    pub(super) fn new(
        logs: &[VisibleLog],
        range_m: Option<[f32; 2]>,
        by_log: bool,
        uploader: Option<&Uploader>,
        progress: &Progress,
    ) -> Option<Self> {
        let each = || logs.iter().map(|shown| (shown, records(&shown.log)));
        let place = |record: Record<'_>| [record.place.east_m, record.place.north_m];
        let bounds = around(each().flat_map(|(_, records)| records.into_iter().map(place)));
        if bounds == NOWHERE {
            return None;
        }
        let origin_m = [0.5 * (bounds[0] + bounds[2]), 0.5 * (bounds[1] + bounds[3])];
        let (mut line, mut side_scan_only) = (Vec::new(), false);
        for (shown, records) in each() {
            progress.check().ok()?;
            let by_side_scan = |record: &Record<'_>| record.source == DepthSource::SideScan;
            side_scan_only |= records.iter().any(by_side_scan);
            let colouring =
                if by_log { Colouring::Log(shown.colour) } else { Colouring::Depth(range_m) };
            line.extend(vertices(&records, origin_m, &colouring));
        }
        let line = MapLine::new(origin_m, line, Specks::Kept, uploader);
        progress.check().ok()?;
        let boxes = logs.iter().map(|shown| {
            let navigation = shown.log.products.navigation.clone();
            let boxes = PlaceBoxes::new(&navigation.pings, place_of);
            (shown.id, navigation, boxes)
        });
        let named = logs.iter().filter(|_| by_log);
        Some(Self {
            bounds,
            range_m: range_m.filter(|_| !by_log),
            side_scan_only: side_scan_only && !by_log,
            logs: named.map(|shown| (shown.name.clone(), shown.colour)).collect(),
            line,
            boxes: boxes.collect(),
        })
    }

    /// Returns the ping of a log that is nearest to a place, however far away.
    pub(super) fn ping_of(&self, log: LogId, place: [f64; 2]) -> Option<usize> {
        let (_, navigation, boxes) = self.boxes.iter().find(|(id, ..)| *id == log)?;
        Some(boxes.nearest(&navigation.pings, place_of, place, f64::INFINITY)?.0)
    }

    /// Returns the ping nearest to a place and its log, if one is within `reach_m`; of equally near
    /// pings that of the log `first`.
    pub(super) fn nearest_ping(
        &self,
        place: [f64; 2],
        reach_m: f64,
        first: LogId,
    ) -> Option<(LogId, usize)> {
        let near = self.boxes.iter().filter_map(|(id, navigation, boxes)| {
            let (ping, away_m) = boxes.nearest(&navigation.pings, place_of, place, reach_m)?;
            Some((away_m, *id != first, *id, ping))
        });
        let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        Some((nearest.2, nearest.3))
    }
}

fn place_of(ping: &PingNav) -> [f64; 2] {
    [ping.east_m, ping.north_m]
}

/// Meaning of the colour of a track.
enum Colouring {
    /// The colour shows the depth, between the ends of the scale, metres.
    Depth(Option<[f32; 2]>),
    /// The colour is that of the log.
    Log([u8; 3]),
}

/// A place of the track and the depth there.
struct Record<'a> {
    time_s: f64,
    place: &'a PingNav,
    /// Corrected depth, metres; NaN if it is unknown.
    depth_m: f32,
    source: DepthSource,
}

/// Returns the records along the track: of the side-scan pings, or of the soundings in a log
/// without side-scan pings.
fn records<'a>(ProcessedLog { survey, products }: &'a ProcessedLog) -> Vec<Record<'a>> {
    let (navigation, correction) = (&products.navigation, &products.correction);
    if navigation.pings.is_empty() {
        let soundings = survey.soundings.iter().zip(navigation.soundings.iter());
        let record = |(sounding, place): (&Sounding, &'a PingNav)| Record {
            time_s: sounding.time_s,
            place,
            depth_m: if sounding.is_good() {
                correction.depth_m(sounding.time_s, f64::from(sounding.depth_m)) as f32
            } else {
                f32::NAN
            },
            source: DepthSource::Sounding,
        };
        return soundings.map(record).collect();
    }
    let pings = survey.side_scan.iter().zip(navigation.pings.iter());
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
    colouring: &Colouring,
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
        let step_m = last
            .map_or(0.0, |last| (place.east_m - last.east_m).hypot(place.north_m - last.north_m));
        last = Some(place);
        // A NaN step counts as 0: the maximum of NaN and a number is the number.
        way_m += step_m.max(0.0);
        let [dash_m, gap_m] = DASH_M;
        let is_gap = record.source == DepthSource::SideScan && way_m % (dash_m + gap_m) > dash_m;
        let [r, g, b] = match *colouring {
            Colouring::Log(colour) => colour,
            Colouring::Depth(Some(range_m)) if !is_gap => {
                depth_colour(depth_share(record.depth_m, range_m))
            }
            Colouring::Depth(_) => depth_colour(f32::NAN),
        };
        line.push(Vertex {
            place: [(place.east_m - east_m) as f32, (place.north_m - north_m) as f32],
            colour: [r, g, b, 255],
        });
    }
    line
}

/// Largest number of segments drawn in a frame: beyond it, a coarser level is used.
const MOST_SEGMENTS: u32 = 5_000;
/// Width of the line under the track and of the track, points.
const WIDTHS: [f32; 2] = [4.6, 3.0];
/// Opacity of the line under the track.
const CASING_OPACITY: f32 = 0.75;
/// Least distance between the strokes that join the recorder's track to the track of another
/// receiver, points.
const APART: f32 = 18.0;
/// Half of the size of the antenna's triangle, points.
const HALF: f32 = 5.0;
/// Least distance between antenna and transducer at which each is labelled, points.
const NAMED: f32 = 34.0;

/// Draws the track if it has changed, and shows it.
pub(super) fn show(
    picture: &mut LinePicture<TrackLayer>,
    painter: &Painter,
    state: Option<&RenderState>,
    scene: &MapScene<'_>,
) {
    let Some(state) = state else {
        let (at, middle) = (scene.rect.center(), Align2::CENTER_CENTER);
        let colour = theme::canvas_text_colour(scene.options);
        painter.text(at, middle, legend::NO_GPU, legend::font(), colour);
        return;
    };
    // The line under the track sets it off from the depth map, whose colours it shares.
    let casing = theme::canvas_colour(scene.options).gamma_multiply(CASING_OPACITY);
    let pen =
        MapPen { widths: WIDTHS, colours: [Some(casing), None], most_segments: MOST_SEGMENTS };
    let (view, lines) = ((scene.rect, &scene.transform), [(&scene.track.line, pen)]);
    picture.show(painter, state, view, scene.track, lines);
}

/// Draws the recorder's own track as a thin line beneath the track of another receiver, with
/// strokes that join the positions of both at the same times.
pub(super) fn paint_recorded(painter: &Painter, scene: &MapScene<'_>, app: &App) {
    if app.logs.shown.external.recorded.is_none() || !scene.shows(MapLayer::Track) {
        return;
    }
    let apart = &app.logs.shown.external.apart;
    let colour = theme::recorded_track_colour(scene.options);
    let line: Vec<_> = apart.line.iter().map(|place| scene.at_position(*place)).collect();
    painter.add(Shape::line(line, Stroke::new(1.2, colour)));
    let stroke = Stroke::new(0.8, colour);
    let mut last: Option<Pos2> = None;
    for pair in &apart.pairs {
        let ends = pair.map(|place| scene.at_position(place));
        if last.is_none_or(|last| last.distance(ends[1]) > APART) {
            painter.line_segment(ends, stroke);
            last = Some(ends[1]);
        }
    }
}

/// Returns the places of antenna and transducer at the selected ping, metres east and north; `None`
/// while they are at one place.
fn mounting_places(scene: &MapScene<'_>, app: &App) -> Option<[[f64; 2]; 2]> {
    let ping = app.view.selection?.ping;
    let navigation = &scene.products.navigation;
    let antenna = *navigation.antenna.get(ping)?;
    let transducer = navigation.pings.get(ping)?;
    let places = [antenna, [transducer.east_m, transducer.north_m]];
    let mut metres = places.as_flattened().iter();
    metres.all(|metres| metres.is_finite()).then_some(places)
}

/// Draws antenna and transducer at the selected ping while they are apart: the antenna as a
/// triangle and the transducer as a disc, joined by a line.
pub(super) fn paint_mounting(painter: &Painter, scene: &MapScene<'_>, app: &App) {
    let Some([antenna, transducer]) =
        mounting_places(scene, app).map(|places| places.map(|at| scene.at(at)))
    else {
        return;
    };
    let colour = theme::SELECTION_COLOUR;
    painter.line_segment([antenna, transducer], Stroke::new(1.5, colour));
    let corners = [vec2(0.0, -HALF), vec2(HALF, HALF), vec2(-HALF, HALF)];
    let corners = corners.map(|corner| antenna + corner).to_vec();
    let fill = theme::canvas_colour(scene.options);
    let edge = Stroke::new(1.5, colour);
    painter.add(Shape::convex_polygon(corners, fill, edge));
    painter.circle_filled(transducer, 3.0, colour);
    if antenna.distance(transducer) < NAMED {
        return;
    }
    let name = |at: Pos2, other: Pos2, text: &str| {
        let (anchor, aside) = if at.x < other.x {
            (Align2::RIGHT_CENTER, vec2(-12.0, 0.0))
        } else {
            (Align2::LEFT_CENTER, vec2(12.0, 0.0))
        };
        legend::words(painter, scene.options, at + aside, anchor, text);
    };
    name(antenna, transducer, "antenna");
    name(transducer, antenna, "transducer");
}

/// Returns a text about antenna and transducer for screen readers, which follows the name of the
/// map.
pub(super) fn mounting_name(app: &App) -> String {
    let products = app.logs.shown.products.as_ref();
    let apart = products
        .zip(app.view.selection)
        .is_some_and(|(products, mark)| products.navigation.antenna.get(mark.ping).is_some());
    if apart { ", antenna and transducer of the selected ping".to_owned() } else { String::new() }
}
