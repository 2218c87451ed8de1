//! Draws isobaths: lines of equal depth with their depths written along them.
//!
//! Input: the isobaths of the survey. Output: lines and numbers on the map.

mod labels;
pub(super) mod layer;

pub(crate) use labels::IsobathLabels;
pub(crate) use labels::octave;
pub(crate) use layer::IsobathLayer;

use super::lines::{LinePicture, MapPen};
use super::scene::MapScene;
use crate::app::ThemeChoice;
use crate::ui::views::legend;
use eframe::egui_wgpu::RenderState;
use egui::epaint::TextShape;
use egui::{Align2, Color32, Painter, Shape, Stroke, Vec2, vec2};
use std::sync::Arc;

/// Largest number of segments drawn in a frame, of the thin and of the thick lines: beyond it, a
/// coarser level is used.
const MOST_SEGMENTS: [u32; 2] = [5_000, 2_500];

/// Returns the pen of an isobath. Light lines in dark casings are visible on every colour of depth;
/// in the light theme lines are dark and casings light.
fn pen(theme: ThemeChoice, is_index: bool) -> MapPen {
    let (line, casing) = match theme {
        ThemeChoice::Dark => (Color32::from_gray(244), Color32::from_black_alpha(120)),
        ThemeChoice::Light => (Color32::from_gray(24), Color32::from_white_alpha(110)),
    };
    let width = if is_index { 1.7 } else { 0.9 };
    let strength = if is_index { 0.95 } else { 0.7 };
    MapPen {
        widths: [width + 1.3, width],
        colours: [Some(casing), Some(line.gamma_multiply(strength))],
        most_segments: MOST_SEGMENTS[usize::from(is_index)],
    }
}

/// Draws the lines, and their depths if there are labels for the shown zoom and layer.
pub(super) fn show(
    picture: &mut LinePicture<IsobathLayer>,
    painter: &Painter,
    state: Option<&RenderState>,
    scene: &MapScene<'_>,
    layer: &Arc<IsobathLayer>,
    labels: Option<&IsobathLabels>,
) {
    let Some(state) = state else {
        // The notice that there is no GPU is shown by the track.
        return;
    };
    let theme = scene.options.theme;
    let lines = [(&layer.thin, pen(theme, false)), (&layer.thick, pen(theme, true))];
    let view = (scene.rect, &scene.transform);
    picture.show(painter, state, view, layer, lines);
    let of_these = |labels: &&IsobathLabels| Arc::ptr_eq(&labels.layer, layer);
    // A small tile keeps the lines and leaves out the words.
    if let Some(labels) = labels.filter(of_these)
        && legend::has_room(scene.rect)
    {
        write(painter, scene, layer, labels);
    }
}

fn write(painter: &Painter, scene: &MapScene<'_>, layer: &IsobathLayer, labels: &IsobathLabels) {
    let frame = scene.rect.expand(30.0);
    let plate = crate::ui::theme::plate_colour(scene.options).gamma_multiply(0.8);
    let ink = crate::ui::theme::canvas_text_colour(scene.options);
    for label in &labels.labels {
        let [east_m, north_m] = label.place;
        let place = [layer.origin_m[0] + f64::from(east_m), layer.origin_m[1] + f64::from(north_m)];
        let at = scene.at(place);
        if !frame.contains(at) {
            continue;
        }
        let Some(line) = layer.lines.get(label.line) else {
            continue;
        };
        let galley = painter.layout_no_wrap(line.text.clone(), legend::font(), ink);
        let half = 0.5 * galley.size() + vec2(2.0, -0.5);
        let along = Vec2::angled(label.angle_rad);
        let beside = along.rot90();
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| at + x * half.x * along + y * half.y * beside);
        painter.add(Shape::convex_polygon(corners.to_vec(), plate, Stroke::NONE));
        let corner = Align2::CENTER_CENTER.anchor_size(at, galley.size()).min;
        let text = TextShape::new(corner, galley, ink);
        painter.add(text.with_angle_and_anchor(label.angle_rad, Align2::CENTER_CENTER));
    }
}
