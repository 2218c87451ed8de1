//! Draws the axes of a plot in a panel, with lines and numbers, and places values on the screen.

use bathyscope_bottom::presentation::plot::Axis;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, pos2, vec2};

/// Space below for numbers and a name, points.
const BELOW: f32 = 26.0;
/// Space on the right for half of the last number, points.
const RIGHT: f32 = 20.0;
/// Space above for half of the highest number, points.
const ABOVE: f32 = 6.0;

/// The two axes of a plot on the screen.
pub(crate) struct PlotAxes {
    /// Area in which curves are drawn.
    pub area: Rect,
    across: Axis,
    up: Axis,
}

impl PlotAxes {
    /// Creates axes with space on the left for numbers and name: a number that is cut off would
    /// lose its sign first.
    pub(crate) fn new(painter: &Painter, rect: Rect, across: Axis, up: Axis) -> Self {
        let width = |(_, label): &(f64, String)| {
            let galley = painter.layout_no_wrap(label.clone(), font(), Color32::PLACEHOLDER);
            galley.size().x
        };
        let widest = up.ticks.iter().map(width).fold(20.0, f32::max);
        let name = if up.name.is_empty() { 0.0 } else { 8.0 };
        let min = rect.min + vec2(widest.ceil() + 6.0 + name, ABOVE);
        Self { area: Rect::from_min_max(min, rect.max - vec2(RIGHT, BELOW)), across, up }
    }

    /// Returns the position of a pair of values on the screen.
    pub(crate) fn at(&self, x: f64, y: f64) -> Pos2 {
        // The shares are small enough for an `f32`.
        let [x, y] = [self.across.share(x), self.up.share(y)].map(|share| share as f32);
        self.area.lerp_inside(vec2(x, 1.0 - y))
    }

    /// Draws lines, numbers and names of both axes.
    pub(crate) fn draw(&self, painter: &Painter, ink: Color32) {
        let faint = Stroke::new(1.0, ink.gamma_multiply(0.2));
        for (value, label) in &self.across.ticks {
            let x = self.at(*value, self.up.ends[0]).x;
            let below = pos2(x, self.area.bottom() + 3.0);
            painter.text(below, Align2::CENTER_TOP, label, font(), ink);
            painter.vline(x, self.area.y_range(), faint);
        }
        for (value, label) in &self.up.ticks {
            let y = self.at(self.across.ends[0], *value).y;
            let beside = pos2(self.area.left() - 4.0, y);
            painter.text(beside, Align2::RIGHT_CENTER, label, font(), ink);
            painter.hline(self.area.x_range(), y, faint);
        }
        let below = pos2(self.area.center().x, self.area.bottom() + 13.0);
        painter.text(below, Align2::CENTER_TOP, &self.across.name, font(), ink);
        let name = painter.layout_no_wrap(self.up.name.clone(), font(), ink);
        let left = self.area.left() - 24.0 - 8.0;
        let start = pos2(left, self.area.center().y + 0.5 * name.size().x);
        let quarter = std::f32::consts::FRAC_PI_2;
        painter.add(egui::epaint::TextShape::new(start, name, ink).with_angle(-quarter));
    }
}

fn font() -> FontId {
    FontId::proportional(10.0)
}
