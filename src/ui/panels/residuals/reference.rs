//! Draws the settings of the reference that the points are compared with, and of the method that
//! finds the reference of a point.

use crate::app::{Action, Command, JobKey, ReferenceBy};
use crate::ui::ViewContext;
use crate::ui::controls::number_slider;
use crate::ui::panels::parts::{self, fact};
use egui::{Button, Ui};

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
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
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
