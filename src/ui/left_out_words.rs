//! What is said of left-out stretches, the same in all views and panels.

use crate::app::{Action, App, Extent, Leave, LogId};
use crate::support::presentation::units::Units;
use crate::survey::LeftOutStretch;
use crate::ui::text;

/// `412 pings · 512 m · 1:02`.
pub fn extent(extent: &Extent, units: Units) -> String {
    let way = units.way(extent.length_m);
    let lasts = text::duration(extent.duration_s);
    match extent.pings {
        0 => format!("{way} · {lasts}"),
        pings => format!("{} · {way} · {lasts}", text::plural(pings, "ping", "pings")),
    }
}

/// What a drag with the tool will do.
pub fn of_drag(leave: Leave, covered: &Extent, units: Units) -> String {
    let what = match leave {
        Leave::Out => "exclude",
        Leave::In => "include again",
        Leave::AsFound => "reset",
    };
    format!("{what} {}", extent(covered, units))
}

/// Why a ping does not count, `excluded: turn`; `None` where it does.
pub fn at(app: &App, log: LogId, ping: usize) -> Option<String> {
    let stretch = app.left_out_at(log, ping)?;
    Some(format!("excluded: {}", stretch.reason.name()))
}

/// An entry of a view's menu that takes a stretch back in; whether it was chosen.
pub fn take_back_in(ui: &mut egui::Ui, stretch: &LeftOutStretch) -> bool {
    let hint = format!("Excluded: {}.", stretch.reason.name());
    let chosen = ui.button(Action::TakeBackIn.label()).on_hover_text(hint);
    if chosen.clicked() {
        ui.close();
    }
    chosen.clicked()
}

/// How much of the log that is shown is left out, behind a comma; empty where nothing is.
pub fn and_stretches(app: &App) -> String {
    let count = app
        .log
        .left_out()
        .map_or(0, |found| found.left_out.stretches.len());
    match count {
        0 => String::new(),
        count => format!(", {} excluded", text::plural(count, "stretch", "stretches")),
    }
}
