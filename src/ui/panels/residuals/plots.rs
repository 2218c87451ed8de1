//! Plots the distribution of differences, and their dependence on other quantities.

use crate::app::ViewOptions;
use crate::ui::panels::parts::PlotAxes;
use crate::ui::theme;
use bathyscope_bottom::bathymetry::compare::{Bin, DifferenceHistogram};
use bathyscope_bottom::presentation::plot::Axis;
use bathyscope_products::pipeline::ResidualTables;
use egui::{Painter, Rect, Role, Sense, Stroke, Ui, WidgetInfo, vec2};

/// Plot of the differences: their histogram, or their medians over a quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Over {
    #[default]
    Count,
    Depth,
    Across,
    Heading,
}

/// Each plot with its name and its hint.
pub(super) const OVERS: [(Over, &str, &str); 4] = [
    (Over::Count, "Histogram", "How often differences of each size occur."),
    (Over::Depth, "Depth", "Median and standard deviation over the depth of the soundings."),
    (
        Over::Across,
        "Across",
        "Median and standard deviation over the across-track distance: port left, starboard right.",
    ),
    (Over::Heading, "Heading", "Median and standard deviation over the boat's heading."),
];

/// Height of a plot, points.
pub(super) const HEIGHT: f32 = 110.0;

/// Draws a plot of the differences.
pub(super) fn picture(ui: &mut Ui, tables: &ResidualTables, over: Over, options: &ViewOptions) {
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let painter = ui.painter_at(rect);
    let bins = match over {
        Over::Count => {
            if let Some(histogram) = &tables.histogram {
                columns(&painter, rect, histogram, options);
                let columns = histogram.counts.len();
                let said = format!("Histogram of {columns} columns of differences");
                response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &said));
            }
            return;
        }
        Over::Depth => &tables.by_depth_m,
        Over::Across => &tables.by_across_m,
        Over::Heading => &tables.by_heading_deg,
    };
    let units = options.units;
    let written = |value: f64| match over {
        Over::Heading => format!("{}°", short(value)),
        _ => format!("{} {}", short(units.in_unit(value)), units.symbol()),
    };
    medians(&painter, rect, bins, written, options);
    let said = format!("Differences in {} stretches", bins.len());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &said));
}

/// Creates an axis without a name, with ticks at given values instead of round ones.
fn axis<const N: usize>(ends: [f64; 2], values: [f64; N], label: impl Fn(f64) -> String) -> Axis {
    Axis { name: String::new(), ends, ticks: values.map(|value| (value, label(value))).to_vec() }
}

/// Returns a number with at most two decimals, without trailing zeros.
fn short(value: f64) -> String {
    format!("{}", (100.0 * value).round() / 100.0 + 0.0)
}

fn columns(painter: &Painter, rect: Rect, histogram: &DifferenceHistogram, options: &ViewOptions) {
    let DifferenceHistogram { from_m, width_m, counts, .. } = histogram;
    let most = counts.iter().copied().max().unwrap_or(1) as f64;
    let reach_m = from_m.abs().max((from_m + width_m * counts.len() as f64).abs());
    let across = axis([-reach_m, reach_m], [-reach_m, 0.0, reach_m], |value| {
        let units = options.units;
        format!("{} {}", short(units.in_unit(value)), units.symbol())
    });
    let up = axis([0.0, most], [0.0, most], |count| format!("{count:.0}"));
    let axes = PlotAxes::new(painter, rect, across, up);
    axes.draw(painter, theme::plot_ink(options));
    let accent = theme::accent_colour(options.theme);
    for (column, count) in counts.iter().enumerate() {
        let start_m = from_m + width_m * column as f64;
        let top = axes.at(start_m + width_m, *count as f64);
        let bar = Rect::from_two_pos(axes.at(start_m, 0.0), top);
        painter.rect_filled(bar, 0.0, accent);
    }
}

fn medians(
    painter: &Painter,
    rect: Rect,
    bins: &[Bin],
    written: impl Fn(f64) -> String,
    options: &ViewOptions,
) {
    let (Some(first), Some(last)) = (bins.first(), bins.last()) else {
        return;
    };
    let most = bins.iter().map(|bin| bin.residuals.n).max().unwrap_or(0);
    // A bin with a handful of points would determine the scale for all others.
    let counts = |bin: &&Bin| 50 * bin.residuals.n >= most;
    let ends = |bin: &Bin| (bin.residuals.median_m.abs() + bin.residuals.sd_m).max(0.01);
    let reach_m = bins.iter().filter(counts).map(ends).fold(0.0, f64::max);
    let [from, to] = [first.from, last.to];
    let across = axis([from, to], [from, 0.5 * (from + to), to], written);
    let up = axis([-reach_m, reach_m], [-reach_m, 0.0, reach_m], |metres| {
        options.units.small_difference(metres)
    });
    let axes = PlotAxes::new(painter, rect, across, up);
    axes.draw(painter, theme::plot_ink(options));
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
    use egui::{Color32, Context, FontId, LayerId, RawInput, pos2};

    #[test]
    fn the_longest_number_has_room_for_its_sign() {
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(280.0, HEIGHT));
        let numbers = ["-1240 cm", "+0 cm", "+1240 cm"];
        let ctx = Context::default();
        let _output = ctx.run_ui(RawInput::default(), |ui| {
            let painter = ui.ctx().layer_painter(LayerId::background());
            let up = Axis {
                name: String::new(),
                ends: [-1.0, 1.0],
                ticks: numbers.map(|number| (0.0, number.to_owned())).to_vec(),
            };
            let axes = PlotAxes::new(&painter, rect, Axis::new("", [0.0, 1.0]), up);
            for number in numbers {
                let font = FontId::proportional(10.0);
                let galley = painter.layout_no_wrap(number.to_owned(), font, Color32::WHITE);
                let left = axes.area.left() - 4.0 - galley.size().x;
                assert!(left >= rect.left(), "{number} begins at {left}");
            }
        });
    }
}
