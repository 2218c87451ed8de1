//! Draws the boat's track on the map, as a line coloured by depth with an outline that sets it off
//! from the depth map. Where positions come from another receiver, the recorder's own track is
//! drawn beneath it for comparison. At the selected ping, antenna and transducer are shown where
//! they are apart.

use super::MapScene;
use super::layers::TrackLayer;
use super::lines::{LinePicture, MapPen};
use crate::app::{App, MapLayer};
use crate::ui::theme;
use crate::ui::views::{empty, legend};
use eframe::egui_wgpu::RenderState;
use egui::{Align2, Painter, Pos2, Shape, Stroke, vec2};

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
        painter.text(at, middle, empty::NO_GPU, legend::font(), colour);
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
    let at = |place: &_| {
        let navigation = &scene.products.navigation;
        scene.at(navigation.to_plane(&scene.survey.track, *place))
    };
    let colour = theme::recorded_track_colour(scene.options);
    let line: Vec<_> = apart.line.iter().map(at).collect();
    painter.add(Shape::line(line, Stroke::new(1.2, colour)));
    let stroke = Stroke::new(0.8, colour);
    let mut last: Option<Pos2> = None;
    for pair in &apart.pairs {
        let ends = [at(&pair[0]), at(&pair[1])];
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
