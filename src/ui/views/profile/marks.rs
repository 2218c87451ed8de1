//! Draws the marks of the profile: threshold, dead zone, picks and the bottom under the boat.

use super::Shown;
use super::plot::ProfilePlot;
use crate::app::ViewOptions;
use crate::ui::{place, theme};
use bathyscope_log::survey::Side;
use egui::{Align2, FontId, Painter, Rect, Shape, Stroke, pos2, vec2};

/// Draws the range around the transducer that is ignored.
pub(super) fn dead_zone(
    painter: &Painter,
    plot: &ProfilePlot,
    dead_zone_m: f64,
    options: &ViewOptions,
) {
    let x = plot.x(-dead_zone_m)..=plot.x(dead_zone_m);
    let zone = Rect::from_x_y_ranges(x, plot.area.y_range()).intersect(plot.area);
    painter.rect_filled(zone, 0.0, theme::plot_ink(options).gamma_multiply(0.15));
}

/// Draws depth, threshold and picks, the picks on top.
pub(super) fn draw(
    painter: &Painter,
    plot: &ProfilePlot,
    shown: &Shown<'_>,
    options: &ViewOptions,
) {
    let altitude_m = shown.bottom.map_or(f64::NAN, |bottom| bottom.altitude_m);
    for across_m in [-altitude_m, altitude_m] {
        let stroke = Stroke::new(1.0, theme::DEPTH_LINE_COLOUR);
        vertical(painter, plot, across_m, stroke);
    }
    threshold(painter, plot, shown.threshold, options);
    for side in Side::BOTH {
        pick(painter, plot, shown, side, options);
    }
    if let Some(why) = &shown.excluded {
        let at = plot.area.center_bottom() - vec2(0.0, 4.0);
        let ink = theme::plot_ink(options);
        let font = FontId::proportional(10.5);
        painter.text(at, Align2::CENTER_BOTTOM, why, font, ink);
    }
}

fn threshold(painter: &Painter, plot: &ProfilePlot, level: f32, options: &ViewOptions) {
    let y = plot.y(level);
    let colour = theme::accent_colour(options.theme);
    let ends = [pos2(plot.area.left(), y), pos2(plot.area.right(), y)];
    let stroke = Stroke::new(1.5, colour);
    painter.extend(Shape::dashed_line(&ends, stroke, 6.0, 3.0));
    let (words, font) = (format!("threshold {level:.2}"), FontId::proportional(10.0));
    let galley = painter.layout_no_wrap(words, font, colour);
    // Above the line, or below it at the top of the plot; on a background, because the curve
    // crosses the text.
    let above = y - galley.size().y > plot.area.top();
    let anchor = if above { Align2::RIGHT_BOTTOM } else { Align2::RIGHT_TOP };
    let text = anchor.anchor_size(pos2(plot.area.right() - 2.0, y), galley.size());
    let ground = theme::canvas_colour(options).gamma_multiply(0.75);
    painter.rect_filled(text.expand2(vec2(2.0, 0.0)), 2.0, ground);
    painter.galley(text.min, galley, colour);
}

fn pick(
    painter: &Painter,
    plot: &ProfilePlot,
    shown: &Shown<'_>,
    side: Side,
    options: &ViewOptions,
) {
    let Some(found) = shown.picks[side as usize] else {
        return;
    };
    let across_m = place::across_m(side, found.range_m);
    let colour = theme::side_colour(options, side);
    if !vertical(painter, plot, across_m, Stroke::new(2.0, colour)) {
        return;
    }
    let above_bottom = if found.pick.above_bottom { " above bottom" } else { "" };
    let label = format!("{}{above_bottom}", options.units.measure(found.range_m, 2));
    let anchor = match side {
        Side::Port => Align2::RIGHT_BOTTOM,
        Side::Starboard => Align2::LEFT_BOTTOM,
    };
    // Beside its line; a label that is too long for its side begins at the edge of the plot.
    let galley = painter.layout_no_wrap(label, FontId::proportional(10.5), colour);
    let at = pos2(plot.x(across_m), plot.area.top() - 2.0);
    let text = anchor.anchor_size(at, galley.size());
    let room = painter.clip_rect().x_range();
    let x = text.left().min(room.max - galley.size().x).max(room.min);
    painter.galley(pos2(x, text.top()), galley, colour);
}

/// Draws a line at a range if the plot shows that range; returns true if it does.
fn vertical(painter: &Painter, plot: &ProfilePlot, across_m: f64, stroke: Stroke) -> bool {
    let x = plot.x(across_m);
    let in_view = plot.area.x_range().contains(x);
    if in_view {
        painter.vline(x, plot.area.y_range(), stroke);
    }
    in_view
}
