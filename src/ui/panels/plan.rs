//! Draws the section of survey planning, with duration, speed and turning radius.

use super::parts::{remark, row};
use crate::app::{Action, Command, JobKey, PlanRequest};
use crate::ui::ViewContext;
use crate::ui::controls::number_field;
use egui::Ui;

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let before = context.app.map.planning.asked;
    let units = context.units();
    let mut asked = before;
    let hint = "Time from the start of the first line to the end of the last, turns included.";
    row(ui, "Time", hint, |ui| {
        let value = number_field(&mut asked.minutes).range(0.5..=1440.0);
        ui.add(value.speed(0.5).max_decimals(1).suffix(" min"))
    });
    let of_speed = units.speed.metres_per_second();
    let mut speed = asked.speed_mps.unwrap_or(0.0) / of_speed;
    let hint = "Speed of the boat over ground; 0 for the median of the survey.";
    row(ui, "Speed", hint, |ui| {
        let written = |value: f64| {
            if value > 0.0 {
                format!("{value:.2} {}", units.speed.symbol())
            } else {
                "as surveyed".to_owned()
            }
        };
        let value = number_field(&mut speed).range(0.0..=20.0 / of_speed);
        let value = value.custom_formatter(|value, _| written(value));
        ui.add(value.speed(0.05))
    });
    asked.speed_mps = Some(speed * of_speed).filter(|speed_mps| *speed_mps >= 0.1);
    let of_length = units.length.metres();
    let mut radius = asked.turn_radius_m / of_length;
    let hint = "Smallest turning radius of the boat.";
    row(ui, "Turn radius", hint, |ui| {
        let value = number_field(&mut radius).range(0.5 / of_length..=500.0 / of_length);
        let suffix = format!(" {}", units.symbol());
        ui.add(value.speed(0.1).max_decimals(1).suffix(suffix))
    });
    // A value that was not edited is not rounded by the unit in which it is shown.
    if (radius * of_length - asked.turn_radius_m).abs() > 1e-6 {
        asked.turn_radius_m = radius * of_length;
    }
    if asked.speed_mps.zip(before.speed_mps).is_some_and(|(a, b)| (a - b).abs() < 1e-9) {
        asked.speed_mps = before.speed_mps;
    }
    if asked != before {
        context.push(Command::Plan(PlanRequest::Ask(asked)));
    }
    ui.horizontal(|ui| {
        let action = Action::PlanLines;
        let busy = context.app.jobs.is_running(&JobKey::PlanLines);
        let button = ui.add_enabled(!busy, egui::Button::new(action.label()));
        context.button(button, action);
        if busy {
            ui.add(egui::Spinner::new().size(12.0));
        }
    });
    remark(ui, "Lines may cross gaps of the survey: check them on a chart first.");
}
