//! The pictures of differences: how often each size occurs, and what they hang on.

use crate::app::ViewOptions;
use crate::bathymetry::compare::{Bin, Histogram};
use crate::pipeline::ResidualTables;
use crate::ui::theme;
use egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2,
};

/// What the differences are drawn over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Over {
    #[default]
    Count,
    Depth,
    Across,
    Heading,
}

/// Each of them with its name and what it shows.
pub const OVERS: [(Over, &str, &str); 4] = [
    (
        Over::Count,
        "Histogram",
        "How often differences of each size occur.",
    ),
    (
        Over::Depth,
        "Depth",
        "Median and standard deviation over the depth of the soundings.",
    ),
    (
        Over::Across,
        "Across",
        "Median and standard deviation over the distance beside the track: port left, starboard right.",
    ),
    (
        Over::Heading,
        "Heading",
        "Median and standard deviation over the boat's heading.",
    ),
];

/// Height of the picture, points.
pub const HEIGHT: f32 = 110.0;
/// Room for the numbers below, points.
const BELOW: f32 = 26.0;

/// Draws one of them.
pub fn picture(ui: &mut Ui, tables: &ResidualTables, over: Over, options: &ViewOptions) {
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let painter = ui.painter_at(rect);
    let bins = match over {
        Over::Count => {
            if let Some(histogram) = &tables.histogram {
                columns(&painter, rect, histogram, options);
                let said = format!(
                    "Histogram of {} columns of differences",
                    histogram.counts.len()
                );
                response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &said));
            }
            return;
        }
        Over::Depth => &tables.by_depth_m,
        Over::Across => &tables.by_across_m,
        Over::Heading => &tables.by_heading_deg,
    };
    let unit = if over == Over::Heading { "°" } else { " m" };
    medians(&painter, rect, bins, unit, options);
    let said = format!("Differences in {} stretches", bins.len());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &said));
}

/// Between numbers and the screen.
struct Axes {
    area: Rect,
    x: [f64; 2],
    y: [f64; 2],
}

impl Axes {
    /// With room on the left for its numbers: one that is cut loses its sign first.
    fn new(painter: &Painter, rect: Rect, x: [f64; 2], y: [f64; 2], numbers: &[String]) -> Self {
        let font = FontId::proportional(10.0);
        let width = |text: &String| {
            let galley = painter.layout_no_wrap(text.clone(), font.clone(), Color32::PLACEHOLDER);
            galley.size().x
        };
        let widest = numbers.iter().map(width).fold(20.0, f32::max);
        let min = rect.min + vec2(widest.ceil() + 6.0, 6.0);
        Self {
            area: Rect::from_min_max(min, rect.max - vec2(20.0, BELOW)),
            x,
            y,
        }
    }

    fn at(&self, x: f64, y: f64) -> Pos2 {
        let share =
            |value: f64, [from, to]: [f64; 2]| ((value - from) / (to - from).max(1e-12)) as f32;
        self.area
            .lerp_inside(vec2(share(x, self.x), 1.0 - share(y, self.y)))
    }

    /// A line and its number for each of some values.
    fn below(&self, painter: &Painter, values: &[f64], unit: &str, ink: Color32) {
        for value in values {
            let at = self.at(*value, self.y[0]);
            let text = format!("{}{unit}", short(*value));
            let place = pos2(at.x, self.area.bottom() + 3.0);
            painter.text(
                place,
                Align2::CENTER_TOP,
                text,
                FontId::proportional(10.0),
                ink,
            );
            let faint = Stroke::new(1.0, ink.gamma_multiply(0.2));
            painter.vline(at.x, self.area.y_range(), faint);
        }
    }

    fn beside(&self, painter: &Painter, values: &[f64], numbers: &[String], ink: Color32) {
        for (value, number) in values.iter().zip(numbers) {
            let at = self.at(self.x[0], *value);
            let place = pos2(self.area.left() - 4.0, at.y);
            let font = FontId::proportional(10.0);
            painter.text(place, Align2::RIGHT_CENTER, number, font, ink);
            let faint = Stroke::new(1.0, ink.gamma_multiply(0.2));
            painter.hline(self.area.x_range(), at.y, faint);
        }
    }
}

/// Two digits behind the point at most, and none that say nothing.
fn short(value: f64) -> String {
    format!("{}", (100.0 * value).round() / 100.0 + 0.0)
}

fn columns(painter: &Painter, rect: Rect, histogram: &Histogram, options: &ViewOptions) {
    let Histogram {
        from_m,
        width_m,
        counts,
        ..
    } = histogram;
    let most = counts.iter().copied().max().unwrap_or(1) as f64;
    let reach_m = from_m
        .abs()
        .max((from_m + width_m * counts.len() as f64).abs());
    let numbers = [0.0, most].map(|count| format!("{count:.0}"));
    let axes = Axes::new(painter, rect, [-reach_m, reach_m], [0.0, most], &numbers);
    let ink = theme::plot_ink(options);
    axes.below(painter, &[-reach_m, 0.0, reach_m], " m", ink);
    axes.beside(painter, &[0.0, most], &numbers, ink);
    let accent = theme::accent_colour(options.theme);
    for (column, count) in counts.iter().enumerate() {
        let start_m = from_m + width_m * column as f64;
        let bar = Rect::from_two_pos(
            axes.at(start_m, 0.0),
            axes.at(start_m + width_m, *count as f64),
        );
        painter.rect_filled(bar, 0.0, accent);
    }
}

fn medians(painter: &Painter, rect: Rect, bins: &[Bin], unit: &str, options: &ViewOptions) {
    let (Some(first), Some(last)) = (bins.first(), bins.last()) else {
        return;
    };
    let most = bins.iter().map(|bin| bin.residuals.n).max().unwrap_or(0);
    // A stretch with a handful of points would set the scale for all others.
    let counts = |bin: &&Bin| 50 * bin.residuals.n >= most;
    let ends = |bin: &Bin| (bin.residuals.median_m.abs() + bin.residuals.sd_m).max(0.01);
    let reach_m = bins.iter().filter(counts).map(ends).fold(0.0, f64::max);
    let levels_m = [-reach_m, 0.0, reach_m];
    let numbers = levels_m.map(|metres| format!("{:+.0} cm", 100.0 * metres));
    let (x, y) = ([first.from, last.to], [-reach_m, reach_m]);
    let axes = Axes::new(painter, rect, x, y, &numbers);
    let ink = theme::plot_ink(options);
    axes.below(
        painter,
        &[first.from, 0.5 * (first.from + last.to), last.to],
        unit,
        ink,
    );
    axes.beside(painter, &levels_m, &numbers, ink);
    let accent = theme::accent_colour(options.theme);
    for bin in bins.iter().filter(counts) {
        let (middle, found) = (0.5 * (bin.from + bin.to), &bin.residuals);
        let ends = [found.median_m - found.sd_m, found.median_m + found.sd_m];
        let ends = ends.map(|metres| axes.at(middle, metres.clamp(-reach_m, reach_m)));
        painter.line_segment(ends, Stroke::new(1.0, accent.gamma_multiply(0.6)));
        painter.circle_filled(axes.at(middle, found.median_m), 3.0, accent);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Context, LayerId, RawInput};

    #[test]
    fn the_longest_number_has_room_for_its_sign() {
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(280.0, HEIGHT));
        let numbers = ["-1240 cm", "+0 cm", "+1240 cm"].map(str::to_owned);
        let ctx = Context::default();
        let _output = ctx.run_ui(RawInput::default(), |ui| {
            let painter = ui.ctx().layer_painter(LayerId::background());
            let axes = Axes::new(&painter, rect, [0.0, 1.0], [-1.0, 1.0], &numbers);
            for number in &numbers {
                let font = FontId::proportional(10.0);
                let galley = painter.layout_no_wrap(number.clone(), font, Color32::WHITE);
                let left = axes.area.left() - 4.0 - galley.size().x;
                assert!(left >= rect.left(), "{number} begins at {left}");
            }
        });
    }
}
