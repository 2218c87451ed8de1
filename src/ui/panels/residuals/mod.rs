//! Draws the differences between the points of the survey and a reference: statistics, their
//! distribution, and their dependence on other quantities.
//!
//! The panel reads the state of the app, draws tables and histograms, and sends commands.

mod plots;

use super::cloud;
use super::parts::{self, fact};
use super::section::{Section, section};
use crate::app::{Action, App, Command, JobKey, MapLayer, ReferenceBy};
use crate::ui::controls::number_slider;
use crate::ui::{ViewContext, text};
use bathyscope_bottom::bathymetry::compare::Comparison;
use bathyscope_bottom::cloud::Residuals;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_products::pipeline::Stage;
use egui::{Button, Rect, Ui, vec2};
use plots::{HEIGHT, OVERS};

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Residuals").of(Stage::Outliers), |ui, context| {
        // The comparison needs a triangulation of all soundings, and starts only when the section
        // is visible.
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
        // The row is wrapped: one that is wider than the panel would widen the panel when it comes
        // into view.
        ui.horizontal_wrapped(|ui| {
            for (each, name, hint) in OVERS {
                ui.selectable_value(&mut over, each, name).on_hover_text(hint);
            }
        });
        ui.data_mut(|data| data.insert_temp(id, over));
        plots::picture(ui, &agreement.tables, over, context.options());
        let of = if agreement.reference.is_some() {
            "Elevation of the points minus that of the reference at their place"
        } else {
            "Elevation of side-scan points minus that of the soundings at their place"
        };
        parts::remark(ui, format!("{of}: above 0 is shallower."));
        on_map(ui, context);
    });
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
