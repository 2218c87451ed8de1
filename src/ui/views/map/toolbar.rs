//! Draws the buttons on the map. The layers are chosen in the view's title.

use crate::app::{Action, Command, Tool};
use crate::ui::views::legend;
use crate::ui::{ViewContext, ViewRequest, controls, theme};
use bathyscope_products::project::MeasurementKind;
use egui::{Rect, Ui, vec2};

/// Shows the buttons Fit and Calibrate, and the menu of measuring tools.
pub(super) fn show(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    rect: Rect,
    request: &mut Option<ViewRequest>,
) {
    let bar = Rect::from_min_size(rect.min + vec2(4.0, 4.0), vec2(rect.width() - 60.0, 28.0));
    legend::framed(ui, context.options(), bar, |ui| {
        ui.horizontal(|ui| {
            buttons(ui, context, request);
            measure(ui, context);
        });
    });
}

fn buttons(ui: &mut Ui, context: &mut ViewContext<'_>, request: &mut Option<ViewRequest>) {
    ui.spacing_mut().item_spacing.x = 4.0;
    let fit = ui.button("Fit");
    let hint = format!(
        "Shows the whole track and the layers around it ({}, or a double-click).",
        Action::Fit.key()
    );
    if fit.on_hover_text(hint).clicked() {
        *request = Some(ViewRequest::Fit);
    }
    let action = Action::Calibrate;
    let holds = context.app.logs.shown.reviewing.tool == Tool::Calibrate;
    let tool = controls::chip(ui, holds, "Calibrate").accessible_name(action.label());
    context.keyed_button(tool, action);
}

fn measure(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let tools = [
        (Action::MeasureDistance, MeasurementKind::Distance),
        (Action::MeasureArea, MeasurementKind::Area),
        (Action::DepthProfile, MeasurementKind::Profile),
        (Action::HeightFromShadow, MeasurementKind::Height),
    ];
    let tool = context.app.map.measuring.tool;
    let title = egui::RichText::new("Measure");
    let title = match tool {
        Some(_) => title.color(theme::MEASURE_COLOUR),
        None => title,
    };
    ui.menu_button(title, |ui| {
        for (action, kind) in tools {
            let is_it = tool == Some(kind);
            let button = egui::Button::selectable(is_it, action.label());
            let button = button.shortcut_text(action.key());
            let button = controls::underline(ui, is_it, button);
            if button.on_hover_text(action.hint()).clicked() {
                context.push(Command::Do(action));
                ui.close();
            }
        }
    });
}
