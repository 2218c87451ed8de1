//! Texts about excluded stretches, the same in all views and panels.

use crate::app::{Action, App, ExcludedExtent, ExclusionEdit, LogId};
use crate::ui::text;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::ExcludedStretch;

/// `412 pings · 512 m · 1:02`.
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

/// Reason why a ping is excluded, `excluded: turn`; `None` where it is not.
pub(super) fn at(app: &App, log: LogId, ping: usize) -> Option<String> {
    let stretch = app.excluded_at(log, ping)?;
    Some(format!("excluded: {}", stretch.reason.name()))
}

/// An entry of a view's menu that includes a stretch again; whether it was chosen.
pub(super) fn include_again(ui: &mut egui::Ui, stretch: &ExcludedStretch) -> bool {
    let hint = format!("Excluded: {}.", stretch.reason.name());
    let chosen = ui.button(Action::IncludeAgain.label()).on_hover_text(hint);
    if chosen.clicked() {
        ui.close();
    }
    chosen.clicked()
}

/// Number of excluded stretches of the shown log, after a comma; empty if there are none.
pub(super) fn and_stretches(app: &App) -> String {
    let found = app.log.exclusions();
    let count = found.map_or(0, |found| found.exclusions.stretches.len());
    match count {
        0 => String::new(),
        count => format!(", {} excluded", text::plural(count, "stretch", "stretches")),
    }
}
