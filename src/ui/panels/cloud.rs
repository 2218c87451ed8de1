//! Draws steps 3 to 5: the point cloud, its outliers, and the objects on the bottom, which are
//! found by a detector and decided by the analyst.

use super::parts::{self, fact, setting};
use crate::app::{Action, Figures, SearchStatus};
use crate::ui::{ViewContext, text};
use bathyscope_bottom::cloud::{Geometry, Residuals};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{HeadingSource, Projection};
use bathyscope_products::pipeline::Products;
use bathyscope_products::pipeline::settings::rows;
use egui::{Button, Ui};

/// Name of the figure that compares side-scan points with the soundings of their own pings, which
/// is the same in every panel.
pub(super) const SAME_PING: &str = "Minus sounding";
/// Hint of this figure.
pub(super) const SAME_PING_HINT: &str = "Elevation of side-scan points minus that of the sounding at the same ping: median (above 0 is shallower) and 95 % limit.";

/// Returns the text of this figure.
pub(super) fn same_ping(residuals: &Residuals, units: Units) -> String {
    let median = units.signed_difference(residuals.median_m);
    let p95 = units.difference(residuals.p95_m);
    format!("{median} · p95 {p95}")
}

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if let (Some(products), Some(figures)) =
        (&context.app.logs.shown.products, &context.app.logs.shown.figures)
    {
        found(ui, products, figures, context.units());
    }
    controls(ui, context);
}

fn found(ui: &mut Ui, products: &Products, figures: &Figures, units: Units) {
    let hint = "All points of the cloud, and how many of them are side-scan points; the others are soundings.";
    let all = text::count(figures.classes.all());
    let side_scan = text::count(figures.classes.side_scan);
    let value = format!("{all} · {side_scan} side-scan");
    fact(ui, "Points", hint, value);
    if figures.classes.swath > 0 {
        let hint = "Points across the track that the sonar measured itself (StructureScan 3D): one for each stretch of a tenth of the depth.";
        fact(ui, "Swath", hint, text::count(figures.classes.swath));
    }
    let zero = products.navigation.zero_heading;
    let share = 100.0 * zero as f64 / products.navigation.pings.len().max(1) as f64;
    let hint = "Pings without a heading give no side-scan point.";
    let value = format!("{} ({share:.1} %)", text::plural(zero, "ping", "pings"));
    fact(ui, "No heading", hint, value);
    if let Some(residuals) = figures.residuals {
        fact(ui, SAME_PING, SAME_PING_HINT, same_ping(&residuals, units));
    }
}

fn controls(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let settings = context.app.logs.shown.settings.clone();
    let geometry = settings.cloud.geometry;
    setting(ui, context, &rows::GEOMETRY);
    if matches!(geometry, Geometry::Published | Geometry::SelfConsistent) {
        setting(ui, context, &rows::ALPHA2);
    }
    if geometry == Geometry::Published {
        parts::warning(ui, context, &published_depth(settings.cloud.alpha2_deg));
    }
    setting(ui, context, &rows::HEADING);
    if settings.heading.source == HeadingSource::TrackFit {
        setting(ui, context, &rows::HEADING_WINDOW);
    }
    setting(ui, context, &rows::PROJECTION);
    if settings.projection == Projection::Mercator {
        parts::remark(ui, "Mercator metres are longer than ground metres.");
    }
}

/// Describes the change by the published equations of the depth on which they were calibrated: at
/// the calibration spot r = d, and z = r cos(α2).
fn published_depth(alpha2_deg: f64) -> String {
    let percent = 100.0 * (alpha2_deg.to_radians().cos() - 1.0);
    format!(
        "Published formula: the depth at the flat stretch is multiplied by cos(α2), {percent:+.2} %."
    )
}

/// Draws the section of radius outlier removal, where the removed points can be seen first.
pub(super) fn outliers(ui: &mut Ui, context: &mut ViewContext<'_>) {
    removed(ui, context);
    parts::settings_of(ui, context, "Outliers");
    preview(ui, context);
}

fn removed(ui: &mut Ui, context: &ViewContext<'_>) {
    let Some(figures) = &context.app.logs.shown.figures else {
        return parts::remark(ui, "No result yet.");
    };
    let classes = figures.classes;
    let hint = "Side-scan points that the filter removes, and their share; about 10 % in the paper (Pulido et al.).";
    let noise = text::count(classes.noise());
    let percent = 100.0 * classes.noise_share();
    let value = format!("{noise} ({percent:.1} %)");
    fact(ui, "Removed", hint, value);
}

fn preview(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let action = Action::OutlierPreview;
    let mut on = context.options().cloud.outlier_preview;
    let toggle = ui.checkbox(&mut on, "Show unused points in 3D");
    context.named_button(toggle, action);
}

/// Draws the section.
pub(super) fn objects(ui: &mut Ui, context: &mut ViewContext<'_>) {
    found_objects(ui, context);
    if let Some(note) = context.app.search_note() {
        parts::warning(ui, context, &note);
    }
    let hint = context.app.findings.search.model_description().map_or_else(
        || "The detector in use.".to_owned(),
        |known| format!("The detector in use: {known}"),
    );
    fact(ui, "Model", &hint, context.app.findings.search.model_name());
    search(ui, context);
}

fn found_objects(ui: &mut Ui, context: &ViewContext<'_>) {
    if !context.app.logs.has_boxes() {
        let key = Action::NewBox.key();
        let text = format!("No boxes yet: find objects, or draw a box with {key}.");
        return parts::remark(ui, text);
    }
    let all = context.app.logs.review_counts();
    let counts = all.boxes;
    let boxes = text::plural(counts.total(), "box", "boxes");
    let value = match counts.proposed {
        0 if context.app.search_note().is_some() => format!("{boxes} so far, decided"),
        0 => format!("{boxes} · all decided"),
        open => format!("{boxes} · {} undecided", text::count(open)),
    };
    let hint = "Boxes from the least score on, and those that were decided.";
    fact(ui, "Found", hint, value);
    if all.logs > 1 {
        let logs = text::plural(all.logs, "log", "logs");
        let hint = "Logs that have boxes, and the objects that all their boxes show.";
        let objects = text::plural(context.app.objects.all().len(), "object", "objects");
        fact(ui, "In", hint, format!("{logs} · {objects}"));
    }
}

fn search(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if let Some(status) = context.app.search_status() {
        if status.logs > 1 {
            parts::remark(ui, searching(context, &status));
        }
        ui.horizontal(|ui| {
            ui.add(parts::progress_bar(context, status.share, 140.0));
            let stop = ui.small_button("Stop");
            context.button_with_hint(stop, Action::Cancel, "What was found so far stays.");
        });
        return;
    }
    let ready = context.app.logs.shown.products.is_some();
    ui.horizontal(|ui| {
        for (action, ready) in [(Action::FindObjects, ready), (Action::ChooseModel, true)] {
            let button = ui.add_enabled(ready, Button::new(action.label()));
            let lack = "There is no track yet to place objects on.";
            context.button(button.on_disabled_hover_text(lack), action);
        }
    });
}

/// Returns the text of a running search: `Searching lake-2, log 2 of 4`.
fn searching(context: &ViewContext<'_>, status: &SearchStatus) -> String {
    let log = status.log.and_then(|id| context.app.logs.get(id));
    let place = format!("log {} of {}", status.place, status.logs);
    match log {
        Some(log) => format!("Searching {}, {place}", log.name()),
        None => format!("Waiting for results of {place}"),
    }
}
