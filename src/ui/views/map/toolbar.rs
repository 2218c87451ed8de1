//! The buttons on the map.

use super::pointer::Pointer;
use crate::app::Command;
use crate::ui::{ViewContext, ViewRequest};
use egui::{Rect, Ui, UiBuilder, vec2};

/// Fit, the calibration tool, and what is drawn.
pub fn show(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    rect: Rect,
    wish: &mut Option<ViewRequest>,
    pointer: &mut Pointer,
) {
    let bar = Rect::from_min_size(rect.min + vec2(6.0, 6.0), vec2(rect.width() - 60.0, 24.0));
    ui.scope_builder(UiBuilder::new().max_rect(bar), |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            if ui
                .button("Fit")
                .on_hover_text("Shows the whole track (F, or a double-click).")
                .clicked()
            {
                *wish = Some(ViewRequest::Fit);
            }
            ui.toggle_value(&mut pointer.calibrating, "Calibrate by click").on_hover_text(
                "The next click on the track or on a numbered stretch measures the scale there. \
                 C does it at the selected ping; Esc leaves the tool.",
            );
            layers(ui, context);
        });
    });
}

fn layers(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mut options = context.app.options.clone();
    let map = &mut options.map;
    ui.toggle_value(&mut map.depth_map, "Depth map")
        .on_hover_text("Depth interpolated between soundings.");
    ui.toggle_value(&mut map.track, "Track")
        .on_hover_text("The track, coloured by the recorded depth.");
    ui.toggle_value(&mut map.flat_spots, "Flat stretches")
        .on_hover_text("The flattest stretches of the track, flattest first.");
    if options.map != context.app.options.map {
        context.push(Command::Show(Box::new(options)));
    }
}
