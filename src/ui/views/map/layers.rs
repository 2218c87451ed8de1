//! What the map shows, made off the window's thread so that a frame costs the same for any survey.

use super::ping_boxes::PingBoxes;
use super::transform::GroundBounds;
use crate::bathymetry::{self, Surface, SurfaceSettings};
use crate::progress::Progress;
use crate::render::{LinePyramid, TrackBuffers, Uploader, Vertex, depth_colour, depth_share};
use crate::survey::{Navigation, PingNav, Survey};
use egui::{Color32, ColorImage, TextureHandle, TextureOptions};
use std::sync::Arc;

/// Seconds without a record after which the track is broken instead of bridged.
const BREAK_S: f64 = 10.0;
/// Opacity of the depth map at a sounding and at the farthest from one: what is less sure looks so.
const OPACITY: [f32; 2] = [0.85, 0.25];
/// The depth map is drawn as finely as the screen can show it: cells of this side, metres,
const LEAST_CELL_M: f64 = 0.1;
/// and at most so many along the longer side.
const MOST_CELLS: usize = 1024;

/// The track, ready to draw and to search.
pub struct TrackLayer {
    /// What the places of `pyramid` are relative to, metres.
    pub origin_m: [f64; 2],
    /// All of the track.
    pub bounds: GroundBounds,
    /// Ends of the colour scale, metres.
    pub range_m: Option<[f32; 2]>,
    /// The line.
    pub pyramid: LinePyramid,
    /// The line on the GPU.
    pub buffers: Option<TrackBuffers>,
    boxes: PingBoxes,
}

impl TrackLayer {
    /// `None` when nothing has a position, or cancelled.
    pub fn new(
        survey: &Survey,
        navigation: Arc<Navigation>,
        uploader: Option<&Uploader>,
        progress: &Progress,
    ) -> Option<Self> {
        let range_m = bathymetry::depth_range(locked_depths(survey));
        let records = || records(survey, &navigation);
        let bounds = bounds(records().map(|(_, place, _)| place))?;
        let origin_m = [0.5 * (bounds[0] + bounds[2]), 0.5 * (bounds[1] + bounds[3])];
        progress.check().ok()?;
        let line = vertices(records(), origin_m, range_m);
        let mut buffers = uploader.map(|_| TrackBuffers::default());
        let pyramid = LinePyramid::new(line, |vertices| {
            if let Some((uploader, buffers)) = uploader.zip(buffers.as_mut()) {
                buffers.add(uploader, vertices);
            }
        });
        progress.check().ok()?;
        Some(Self {
            origin_m,
            bounds,
            range_m,
            buffers,
            pyramid,
            boxes: PingBoxes::new(navigation),
        })
    }

    /// The ping nearest to a place, if one is within `reach_m`.
    pub fn nearest_ping(&self, place: [f64; 2], reach_m: f64) -> Option<usize> {
        self.boxes.nearest(place, reach_m)
    }
}

/// Depths that the recorder had the bottom for: the others would stretch the colours.
fn locked_depths(survey: &Survey) -> impl Iterator<Item = f32> {
    survey
        .soundings
        .iter()
        .filter(|sounding| sounding.locked)
        .map(|sounding| sounding.depth_m)
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

/// The interpolated depth map as a texture.
pub struct DepthLayer {
    /// The depths; `None` when the soundings span no surface.
    pub map: Option<(Surface, TextureHandle)>,
    /// Nothing is interpolated farther than this from a sounding, metres.
    pub gap_m: f64,
}

impl DepthLayer {
    /// `None` when cancelled.
    pub fn new(
        survey: &Survey,
        navigation: &Navigation,
        context: &egui::Context,
        progress: &Progress,
    ) -> Option<Self> {
        let settings = SurfaceSettings {
            cell_m: Some(LEAST_CELL_M),
            max_side: MOST_CELLS,
            ..SurfaceSettings::default()
        };
        let points = bathymetry::depth_points(survey, navigation);
        let range_m = bathymetry::depth_range(locked_depths(survey));
        let map = bathymetry::surface(&points, &settings, progress).ok()?;
        let map = map.zip(range_m).map(|(map, range_m)| {
            let image = depth_image(&map, range_m, settings.max_gap_m);
            let texture = context.load_texture("depth map", image, TextureOptions::LINEAR);
            (map, texture)
        });
        Some(Self {
            map,
            gap_m: settings.max_gap_m,
        })
    }
}

fn depth_image(map: &Surface, range_m: [f32; 2], gap_m: f64) -> ColorImage {
    let pixels = map.depth_m.iter().zip(&map.distance_m);
    let colour = |(depth_m, distance_m): (&f32, &f32)| {
        if depth_m.is_nan() {
            return Color32::TRANSPARENT;
        }
        let [r, g, b] = depth_colour(depth_share(*depth_m, range_m));
        // The root lets the first metres beside the track already look less sure.
        let unsure = (distance_m / gap_m as f32).sqrt();
        let opacity = OPACITY[0] + (OPACITY[1] - OPACITY[0]) * unsure;
        Color32::from_rgba_unmultiplied(r, g, b, (255.0 * opacity) as u8)
    };
    ColorImage::new(
        [map.grid.columns, map.grid.rows],
        pixels.map(colour).collect(),
    )
}
