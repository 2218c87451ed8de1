//! Draws the axes of the profile: intensity up, slant range to both sides.

use crate::app::ViewOptions;
use crate::ui::theme;
use bathyscope_bottom::presentation::units::Units;
use egui::{Align2, FontId, Painter, Pos2, Rect, Stroke, pos2, vec2};

/// Room for the numbers of the vertical axes, points.
const SIDE: f32 = 26.0;
/// Room for the numbers of the range axis, points.
const BELOW: f32 = 16.0;
/// Room for the words above, points.
const ABOVE: f32 = 16.0;

/// Transform between values and the screen.
pub(super) struct ProfilePlot {
    /// Area of the curves.
    pub area: Rect,
    far_m: f64,
}

impl ProfilePlot {
    /// Creates a plot of both sides up to `far_m`.
    pub(super) fn new(rect: Rect, far_m: f64) -> Self {
        let min = rect.min + vec2(SIDE, ABOVE);
        let max = rect.max - vec2(SIDE, BELOW);
        Self { area: Rect::from_min_max(min, max.max(min + vec2(1.0, 1.0))), far_m }
    }

    /// Returns the screen x of a slant range, port negative.
    pub(super) fn x(&self, across_m: f64) -> f32 {
        self.area.center().x + (across_m / self.far_m) as f32 * self.area.width() / 2.0
    }

    /// Returns the slant range at a screen x, port negative; inverse of [`ProfilePlot::x`].
    pub(super) fn across_m(&self, x: f32) -> f64 {
        f64::from((x - self.area.center().x) / (self.area.width() / 2.0)) * self.far_m
    }

    /// Returns the screen y of a level, 0 to 1.
    pub(super) fn y(&self, level: f32) -> f32 {
        self.area.bottom() - level * self.area.height()
    }

    /// Returns the level at a screen y, limited to 0 to 1; inverse of [`ProfilePlot::y`].
    pub(super) fn level(&self, y: f32) -> f32 {
        ((self.area.bottom() - y) / self.area.height()).clamp(0.0, 1.0)
    }

    /// Returns the metres between ticks that leave room for their numbers.
    fn step_m(&self, units: Units) -> f64 {
        let per_point = 2.0 * self.far_m / f64::from(self.area.width());
        units.round_up_m(per_point * 44.0)
    }
}

/// Draws the axes with numbers: normalised left, raw right, slant range below.
pub(super) fn axes(painter: &Painter, plot: &ProfilePlot, options: &ViewOptions) {
    let ink = theme::plot_ink(options);
    let faint = Stroke::new(1.0, ink.gamma_multiply(0.25));
    let font = FontId::proportional(10.0);
    let write = |at: Pos2, anchor: Align2, text: String| {
        painter.text(at, anchor, text, font.clone(), ink);
    };
    let area = plot.area;
    for (level, raw) in [(0.0, "0"), (0.5, "128"), (1.0, "255")] {
        let y = plot.y(level);
        painter.hline(area.x_range(), y, faint);
        let normalised = format!("{level}");
        write(pos2(area.left() - 4.0, y), Align2::RIGHT_CENTER, normalised);
        let right = pos2(area.right() + 4.0, y);
        write(right, Align2::LEFT_CENTER, raw.to_owned());
    }
    let step_m = plot.step_m(options.units);
    let ticks = (plot.far_m / step_m).floor() as i32;
    for tick in -ticks..=ticks {
        let across_m = f64::from(tick) * step_m;
        let x = plot.x(across_m);
        let tick = area.bottom()..=area.bottom() + 3.0;
        painter.vline(x, tick, Stroke::new(1.0, ink));
        let label = options.units.tick_with_unit(across_m.abs(), step_m);
        write(pos2(x, area.bottom() + 3.0), Align2::CENTER_TOP, label);
    }
    painter.vline(area.center().x, area.y_range(), faint);
    let top = area.top() + 2.0;
    let port = pos2(area.left() + 4.0, top);
    write(port, Align2::LEFT_TOP, "port".to_owned());
    let starboard = pos2(area.right() - 4.0, top);
    write(starboard, Align2::RIGHT_TOP, "starboard".to_owned());
}
