//! Sentences for the analyst, one line each, until they are dismissed.

use crate::app::Command;
use crate::ui::{ViewContext, theme};
use egui::{RichText, Ui};

/// Notices shown at once.
const SHOWN: usize = 4;

/// Draws the lines; nothing when there is nothing to tell.
pub fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    let look = app.options.theme;
    let hidden = app.notices.len().saturating_sub(SHOWN);
    for (index, notice) in app.notices.iter().enumerate().skip(hidden) {
        let colour = if notice.is_error {
            theme::error_colour(look)
        } else {
            theme::accent_colour(look)
        };
        ui.horizontal(|ui| {
            let (rect, _) = ui.allocate_exact_size(egui::vec2(4.0, 18.0), egui::Sense::hover());
            ui.painter().rect_filled(rect, 1.0, colour);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.small_button("Dismiss").clicked() {
                    context.push(Command::Dismiss(index));
                }
                if let Some(action) = notice.offer {
                    let button = ui.small_button(action.label());
                    if button.on_hover_text(action.hint()).clicked() {
                        context.push(Command::Do(action));
                    }
                }
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    let text = RichText::new(&notice.text).strong();
                    ui.add(egui::Label::new(text).truncate())
                        .on_hover_text(&notice.text);
                });
            });
        });
    }
    if hidden > 0 {
        ui.label(
            RichText::new(format!("{hidden} older notices"))
                .weak()
                .small(),
        );
    }
}
