//! The buttons on the map. What is drawn is chosen in the view's title.

use super::pointer::Pointer;
use crate::app::ViewOptions;
use crate::ui::ViewRequest;
use crate::ui::views::legend;
use egui::{Rect, Ui, UiBuilder, vec2};

/// Fit, and the calibration tool.
pub fn show(
    ui: &mut Ui,
    options: &ViewOptions,
    rect: Rect,
    wish: &mut Option<ViewRequest>,
    pointer: &mut Pointer,
) {
    let bar = Rect::from_min_size(rect.min + vec2(4.0, 4.0), vec2(rect.width() - 60.0, 28.0));
    ui.scope_builder(UiBuilder::new().max_rect(bar), |ui| {
        legend::frame(options).show(ui, |ui| ui.horizontal(|ui| buttons(ui, wish, pointer)));
    });
}

fn buttons(ui: &mut Ui, wish: &mut Option<ViewRequest>, pointer: &mut Pointer) {
    ui.spacing_mut().item_spacing.x = 4.0;
    let fit = ui.button("Fit");
    if fit
        .on_hover_text("Shows the whole track (F, or a double-click).")
        .clicked()
    {
        *wish = Some(ViewRequest::Fit);
    }
    let tool = ui.toggle_value(&mut pointer.calibrating, "Calibrate by click");
    tool.on_hover_text(
        "The next click on the track or on a numbered stretch measures the scale there. \
         C does it at the selected ping; Esc leaves the tool.",
    );
}
