//! Writes the texts about excluded and flat stretches, the same in all views and panels.

use crate::app::{Action, App, ExcludedExtent, ExclusionEdit, LogId};
use crate::ui::text;
use bathyscope_bottom::calibration::FlatSpot;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::ExcludedStretch;

/// Formats an extent as `412 pings · 512 m · 1:02`.
pub(super) fn extent(extent: &ExcludedExtent, units: Units) -> String {
    let way = units.way(extent.length_m);
    let lasts = text::duration(extent.duration_s);
    match extent.pings {
        0 => format!("{way} · {lasts}"),
        pings => format!("{} · {way} · {lasts}", text::plural(pings, "ping", "pings")),
    }
}

/// Describes the effect of a drag with the tool on the stretch that it covers.
pub(super) fn of_drag(edit: ExclusionEdit, covered: &ExcludedExtent, units: Units) -> String {
    let what = match edit {
        ExclusionEdit::Exclude => "exclude",
        ExclusionEdit::Include => "include again",
        ExclusionEdit::Trust => "trust the soundings of",
        ExclusionEdit::Reset => "reset",
    };
    format!("{what} {}", extent(covered, units))
}

/// Returns the reason why a ping is excluded, as `excluded: turn`; `None` where it is not excluded.
pub(super) fn excluded_at(app: &App, log: LogId, ping: usize) -> Option<String> {
    let stretch = app.logs.excluded_at(log, ping)?;
    Some(format!("excluded: {}", stretch.reason.name()))
}

/// Adds to a view's menu an entry that includes a stretch again; returns true if it was chosen.
pub(super) fn include_again(ui: &mut egui::Ui, stretch: &ExcludedStretch) -> bool {
    let hint = format!("Excluded: {}.", stretch.reason.name());
    let chosen = ui.button(Action::IncludeAgain.label()).on_hover_text(hint);
    if chosen.clicked() {
        ui.close();
    }
    chosen.clicked()
}

/// Returns the number of excluded stretches of the shown log, after a comma; empty if there are
/// none.
pub(super) fn and_stretches(app: &App) -> String {
    let found = app.logs.shown.exclusions();
    let count = found.map_or(0, |found| found.exclusions.stretches.len());
    match count {
        0 => String::new(),
        count => format!(", {} excluded", text::plural(count, "stretch", "stretches")),
    }
}

/// Describes a flat stretch as `10 m, relief 4 cm, ±1.2 %`.
pub(super) fn brief(spot: &FlatSpot, units: Units) -> String {
    let length = units.measure(spot.length_m, 0);
    let relief = relief(spot, units);
    match spread(spot) {
        Some(spread) => format!("{length}, relief {relief}, {spread}"),
        None => format!("{length}, relief {relief}, no scale"),
    }
}

/// Formats the spread of the scale of single pings as `±1.2 %`; `None` if it is unknown.
pub(super) fn spread(spot: &FlatSpot) -> Option<String> {
    Some(format!("±{:.1} %", 100.0 * spot.spread()?))
}

/// Formats the factor on the recorded range as `×0.949`; `None` if it is unknown.
pub(super) fn factor(spot: &FlatSpot) -> Option<String> {
    Some(format!("×{:.3}", spot.factor?))
}

/// Formats the relief as `4 cm`; a dash if it is unknown.
pub(super) fn relief(spot: &FlatSpot, units: Units) -> String {
    let written = units.small_difference(spot.relief_m);
    if spot.relief_m.is_finite() {
        written.trim_start_matches('+').to_owned()
    } else {
        text::NONE.to_owned()
    }
}
