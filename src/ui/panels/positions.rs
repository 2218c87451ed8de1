//! Shifts and latencies of the positions of the logs.

use super::parts::{self, name_of, press, press_short, remark};
use crate::app::{Action, App, FoundPositions};
use crate::ui::{ViewContext, text};
use bathyscope_bottom::bathymetry::position_offsets::FoundShift;
use egui::{RichText, Ui};

/// Draws the buttons, and what was found.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    ui.horizontal(|ui| {
        let can_compare = !app.is_matching_positions();
        press(ui, context, Action::ComparePositions, can_compare);
        let tells = app.position_offsets().is_some_and(FoundPositions::tells);
        press_short(ui, context, (Action::ApplyPositions, "Apply"), tells);
        if app.is_matching_positions() {
            ui.add(egui::Spinner::new().size(12.0));
        }
    });
    let Some(found) = app.position_offsets() else {
        return;
    };
    table(ui, app, found);
    if !found.tells() {
        remark(ui, FoundPositions::NOTHING_TOLD);
    }
}

const COLUMNS: [(&str, &str); 6] = [
    ("Log", ""),
    ("east", "Shift of its positions to the east."),
    ("north", "Shift of its positions to the north."),
    ("\u{b1}", "Standard error of both shifts; about 2 m where no crossing shows them."),
    ("late, s", "How much later its positions are than its echoes, seconds."),
    ("\u{b1} s", "Standard error of the latency; about 1 s where no crossing shows it."),
];

fn table(ui: &mut Ui, app: &App, found: &FoundPositions) {
    parts::table(ui, "positions", &COLUMNS, |ui| {
        for (id, log) in &found.logs {
            let name = RichText::new(name_of(app, *id)).small();
            ui.add(egui::Label::new(name).truncate());
            for value in values(app, &log.found) {
                ui.label(RichText::new(value).small());
            }
            ui.end_row();
        }
    });
}

fn values(app: &App, found: &FoundShift) -> [String; 5] {
    let units = app.view.options.units;
    let of = |error: f64, value: &dyn Fn() -> String| {
        if error.is_nan() { text::NONE.to_owned() } else { value() }
    };
    let (shift_m, error_m, error_s) = (&found.shift, found.shift_error_m, found.latency_error_s);
    [
        of(error_m, &|| units.signed(shift_m.east_m, 2)),
        of(error_m, &|| units.signed(shift_m.north_m, 2)),
        of(error_m, &|| units.spread(error_m, 2)),
        of(error_s, &|| format!("{:+.2}", shift_m.latency_s)),
        of(error_s, &|| format!("{error_s:.2}")),
    ]
}
