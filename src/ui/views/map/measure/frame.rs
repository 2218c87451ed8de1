//! Draws the axes of the depth profile: distance to the right, depth down.

use crate::app::ViewOptions;
use crate::ui::theme;
use crate::ui::views::{legend, ticks};
use bathyscope_bottom::bathymetry::TransectStation;
use egui::{Align2, Painter, Pos2, Rect, Stroke, pos2, vec2};

/// Room for the numbers of depth (left) and of distance (below), points.
const ROOM: [f32; 2] = [40.0, 18.0];

/// Transform between metres and the screen.
pub(super) struct ProfileTransform {
    /// Area of the curve.
    pub area: Rect,
    length_m: f64,
    /// Depths at the upper and the lower edge, metres.
    depths_m: [f64; 2],
}

impl ProfileTransform {
    /// Creates a transform that shows a whole line, with room above and below its depths; `None` if
    /// no depth on the line is known, or if `rect` is too small.
    pub(super) fn new(rect: Rect, stations: &[TransectStation]) -> Option<Self> {
        let length_m = stations.last()?.distance_m;
        let depths = || {
            let depths = stations.iter().filter_map(|station| station.depth_m);
            depths.map(f64::from)
        };
        let [shallow_m, deep_m] = [depths().reduce(f64::min)?, depths().reduce(f64::max)?];
        let margin_m = (0.1 * (deep_m - shallow_m)).max(0.05);
        let corner = rect.min + vec2(ROOM[0], 4.0);
        let area = Rect::from_min_max(corner, rect.max - vec2(12.0, ROOM[1]));
        (area.is_positive() && length_m > 0.0).then_some(Self {
            area,
            length_m,
            depths_m: [shallow_m - margin_m, deep_m + margin_m],
        })
    }

    /// Returns the screen x of a distance.
    pub(super) fn x(&self, distance_m: f64) -> f32 {
        self.area.left() + (distance_m / self.length_m) as f32 * self.area.width()
    }

    /// Returns the distance at a screen x, limited to the line; inverse of [`ProfileTransform::x`].
    pub(super) fn distance_m(&self, x: f32) -> f64 {
        let share = (x - self.area.left()) / self.area.width();
        f64::from(share.clamp(0.0, 1.0)) * self.length_m
    }

    /// Returns the screen y of a depth.
    pub(super) fn y(&self, depth_m: f64) -> f32 {
        let [top_m, bottom_m] = self.depths_m;
        self.area.top() + ((depth_m - top_m) / (bottom_m - top_m)) as f32 * self.area.height()
    }

    /// Returns the place of a station on the screen; `None` without a depth.
    pub(super) fn at(&self, station: &TransectStation) -> Option<Pos2> {
        Some(pos2(self.x(station.distance_m), self.y(f64::from(station.depth_m?))))
    }

    /// Returns the vertical exaggeration of the plot.
    pub(super) fn exaggeration(&self) -> f64 {
        let [top_m, bottom_m] = self.depths_m;
        let down = f64::from(self.area.height()) / (bottom_m - top_m);
        down * self.length_m / f64::from(self.area.width())
    }

    /// Draws the axes with their lines and numbers, and a line at each corner.
    pub(super) fn axes(&self, painter: &Painter, options: &ViewOptions, corners_m: &[f64]) {
        let ink = theme::plot_ink(options);
        let faint = Stroke::new(1.0, ink.gamma_multiply(0.2));
        let write = |at: Pos2, anchor: Align2, text: String| {
            painter.text(at, anchor, text, legend::font(), ink);
        };
        let [top_m, bottom_m] = self.depths_m;
        let units = options.units;
        let most = f64::from(self.area.height() / 24.0).max(1.0);
        let step_m = units.round_step_m(bottom_m - top_m, most);
        for depth_m in ticks::multiples(top_m, bottom_m, step_m) {
            let y = self.y(depth_m);
            painter.hline(self.area.x_range(), y, faint);
            let at = pos2(self.area.left() - 4.0, y);
            write(at, Align2::RIGHT_CENTER, units.tick(depth_m, step_m));
        }
        let most = f64::from(self.area.width() / 70.0).max(1.0);
        let step_m = units.round_step_m(self.length_m, most);
        // The unit is written once, at the end of the axis.
        let last_m = self.distance_m(self.area.right() - 78.0);
        for distance_m in ticks::multiples(0.0, last_m, step_m) {
            let x = self.x(distance_m);
            painter.vline(x, self.area.bottom()..=self.area.bottom() + 3.0, (1.0, ink));
            let at = pos2(x, self.area.bottom() + 4.0);
            write(at, Align2::CENTER_TOP, units.tick(distance_m, step_m));
        }
        let end = pos2(self.area.right(), self.area.bottom() + 4.0);
        let unit = format!("distance, {}", units.symbol());
        write(end, Align2::RIGHT_TOP, unit);
        for corner_m in corners_m {
            painter.vline(self.x(*corner_m), self.area.y_range(), faint);
        }
        painter.hline(self.area.x_range(), self.area.bottom(), (1.0, ink));
        painter.vline(self.area.left(), self.area.y_range(), (1.0, ink));
    }
}
