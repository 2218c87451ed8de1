//! Draws the differences between the points of the survey and a reference: statistics, their
//! distribution, and their dependence on other quantities.
//!
//! The panel reads the state of the app, draws tables and histograms, and sends commands.

use super::cloud;
use super::parts::{self, PlotAxes, fact};
use crate::app::{Action, App, Command, JobKey, MapLayer, ReferenceBy, ViewOptions};
use crate::ui::controls::number_slider;
use crate::ui::{ViewContext, text, theme};
use bathyscope_bottom::bathymetry::compare::{Bin, Comparison, DifferenceHistogram};
use bathyscope_bottom::cloud::Residuals;
use bathyscope_bottom::presentation::plot::Axis;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_products::pipeline::ResidualTables;
use egui::{Button, Painter, Rect, Role, Sense, Stroke, Ui, WidgetInfo, vec2};

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    // The comparison needs a triangulation of all soundings, and starts only when the section is
    // visible.
    let place = Rect::from_min_size(ui.cursor().min, vec2(ui.available_width(), HEIGHT));
    if context.app.logs.shown.products.is_some() && ui.is_rect_visible(place) {
        context.push(Command::CompareWithReference);
    }
    reference(ui, context);
    let Some(agreement) = context.app.findings.reference_comparison.agreement().cloned() else {
        return parts::remark(ui, lack(context.app));
    };
    let figures = context.app.logs.shown.figures.as_ref();
    let same_ping = figures
        .filter(|_| agreement.reference.is_none() && agreement.logs.len() == 1)
        .and_then(|figures| figures.residuals.as_ref());
    let units = context.units();
    statistics(ui, &agreement.comparison, same_ping, units);
    // Soundings of the same recorder are no evidence for an order of S-44.
    if agreement.reference.is_some() {
        orders(ui, &agreement.comparison);
    }
    let id = egui::Id::unique("residuals over");
    let mut over = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    // The row is wrapped: one that is wider than the panel would widen the panel when it comes into
    // view.
    ui.horizontal_wrapped(|ui| {
        for (each, name, hint) in OVERS {
            ui.selectable_value(&mut over, each, name).on_hover_text(hint);
        }
    });
    ui.data_mut(|data| data.insert_temp(id, over));
    picture(ui, &agreement.tables, over, context.options());
    let of = if agreement.reference.is_some() {
        "Elevation of the points minus that of the reference at their place"
    } else {
        "Elevation of side-scan points minus that of the soundings at their place"
    };
    parts::remark(ui, format!("{of}: above 0 is shallower."));
    on_map(ui, context);
}

/// Returns the reason why there is nothing to show.
fn lack(app: &App) -> &str {
    match app.findings.reference_comparison.problem() {
        _ if app.jobs.is_running(&JobKey::CompareReference) => "Residuals are being compared.",
        Some(problem) => problem,
        None => "No side-scan point lies over the soundings.",
    }
}

/// Draws the statistics of the differences, in rows; `same_ping` are the differences from the
/// sounding of each point's own ping, if soundings are the reference.
fn statistics(ui: &mut Ui, comparison: &Comparison, same_ping: Option<&Residuals>, units: Units) {
    if let Some(residuals) = same_ping {
        let value = cloud::same_ping(residuals, units);
        fact(ui, cloud::SAME_PING, cloud::SAME_PING_HINT, value);
    }
    let matched = comparison.measured - comparison.unmatched;
    let hint = "Points that have a reference, of all that could have one.";
    let [matched, measured] = [matched, comparison.measured].map(text::count);
    fact(ui, "Compared", hint, format!("{matched} of {measured}"));
    if let Some(found) = &comparison.residuals {
        let pairs = [
            (
                "Mean, median",
                "Of the differences at the same place: above 0 is shallower than the reference.",
                [found.mean_m, found.median_m].map(|value_m| units.signed_difference(value_m)),
            ),
            (
                "SD, RMS",
                "Standard deviation about the mean, and root mean square about 0.",
                [found.sd_m, found.rms_m].map(|value_m| units.difference(value_m)),
            ),
            (
                "MAE, 95 %",
                "Mean absolute difference, and 95th percentile of the absolute difference.",
                [found.mae_m, found.p95_m].map(|value_m| units.difference(value_m)),
            ),
        ];
        for (name, hint, [first, second]) in pairs {
            fact(ui, name, hint, format!("{first}, {second}"));
        }
    }
}

/// Draws the share of the points within the limits of each order of IHO S-44.
fn orders(ui: &mut Ui, comparison: &Comparison) {
    for order_share in &comparison.orders {
        let name = format!("S-44 {}", order_share.order.order);
        let verdict = if order_share.share >= 0.95 { "" } else { ", 95 % required" };
        let share = format!("{:.1} % within{verdict}", 100.0 * order_share.share);
        let hint = "Share of the points within what this order of IHO S-44 allows at their depth.";
        fact(ui, &name, hint, share);
    }
}

/// Draws the switch that shows the residuals of single points on the map.
fn on_map(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let layers = &context.options().map.layers;
    let mut is_shown = layers.is_visible(MapLayer::Residuals);
    let check = ui.checkbox(&mut is_shown, "Residuals on the map");
    context.button_with_hint(check, Action::ResidualLayer, MapLayer::Residuals.hint());
}

/// Radii that can be chosen, metres.
const RADII_M: [f64; 2] = [0.1, 20.0];

const BYS: [(ReferenceBy, &str, &str); 2] = [
    (
        ReferenceBy::Surface,
        "Surface",
        "The triangulated points of the reference, across gaps as wide as the depth map spans.",
    ),
    (
        ReferenceBy::Nearest,
        "Nearest point",
        "The nearest point of the reference, seen from above, within a radius.",
    ),
];

/// Draws the reference with its settings.
fn reference(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let reference = context.app.map.comparing.reference.clone();
    let (name, hint) = match &reference {
        Some(reference) => (reference.name(), reference.path().display().to_string()),
        None => (
            "own soundings".to_owned(),
            "Side-scan against the soundings of the same log.".to_owned(),
        ),
    };
    fact(ui, "Reference", &hint, name);
    buttons(ui, context, reference.is_some());
    let Some(reference) = reference else {
        return;
    };
    matching(ui, context);
    if reference.is_mission() {
        parts::remark(ui, "Another mission, processed with the same settings.");
    }
    for note in &reference.notes {
        parts::remark(ui, context.units().sentence(note));
    }
}

fn buttons(ui: &mut Ui, context: &mut ViewContext<'_>, is_open: bool) {
    let ready = context.app.logs.shown.products.is_some()
        && !context.app.jobs.is_running(&JobKey::OpenReference);
    ui.horizontal_wrapped(|ui| {
        for (action, enabled) in [(Action::CompareWith, ready), (Action::CloseReference, is_open)] {
            let button = ui.add_enabled(enabled, Button::new(action.label()));
            context.button(button, action);
        }
    });
}

fn matching(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let comparing = &context.app.map.comparing;
    let (before, mut by, radius_m) = (comparing.by, comparing.by, comparing.radius_m);
    ui.horizontal_wrapped(|ui| {
        for (each, name, hint) in BYS {
            ui.selectable_value(&mut by, each, name).on_hover_text(hint);
        }
    });
    let units = context.units();
    let [least, most] = RADII_M.map(|radius_m| units.in_unit(radius_m));
    let (mut radius, radii) = (units.in_unit(radius_m), least..=most);
    let mut moved = false;
    if by == ReferenceBy::Nearest {
        let hint = "How far the nearest point may be.";
        let slider = parts::row(ui, "Radius", hint, |ui| {
            let slider = number_slider(&mut radius, radii).logarithmic(true);
            let unit = format!(" {}", units.symbol());
            ui.add(slider.fixed_decimals(1).suffix(unit))
        });
        moved = slider.changed();
    }
    if by != before || moved {
        let radius_m = if moved {
            (radius * units.length.metres()).clamp(RADII_M[0], RADII_M[1])
        } else {
            radius_m
        };
        context.push(Command::MatchBy { by, radius_m });
    }
}

/// Plot of the differences: their histogram, or their medians over a quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Over {
    #[default]
    Count,
    Depth,
    Across,
    Heading,
}

/// Each plot with its name and its hint.
const OVERS: [(Over, &str, &str); 4] = [
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
const HEIGHT: f32 = 110.0;

/// Draws a plot of the differences.
fn picture(ui: &mut Ui, tables: &ResidualTables, over: Over, options: &ViewOptions) {
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
