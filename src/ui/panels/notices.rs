//! Sentences for the analyst, until they are dismissed. They lie over the time line: a line that came and went below the views
//! would move what is being clicked, and one over a view would hide its buttons.

use super::STATUS_HEIGHT;
use crate::app::{Command, Notice};
use crate::ui::{ViewContext, theme};
use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align, Align2, Area, FontSelection, Frame, Id, Label, Layout, Rangef, RichText, Ui, pos2, vec2,
};

/// Notices shown at once.
const SHOWN: usize = 4;
/// Lines of a notice; what is longer is shown whole under the pointer.
const LINES: usize = 4;
/// Widest that a notice becomes, points.
const WIDEST: f32 = 720.0;

/// Draws them over the lower edge of the time line, which reaches `across` the window: the panels beside it stay free, however wide they
/// are. Nothing when there is no notice.
pub fn show(ctx: &egui::Context, context: &mut ViewContext<'_>, across: Rangef) {
    let app = context.app;
    if app.notices.is_empty() {
        return;
    }
    let above = STATUS_HEIGHT + 6.0;
    // Beside it stay the buttons that play along the survey.
    let room = (across.span() - 160.0).max(260.0).min(across.span());
    let foot = pos2(across.center(), ctx.content_rect().bottom() - above);
    let area = Area::new(Id::unique("notices"))
        .pivot(Align2::CENTER_BOTTOM)
        .fixed_pos(foot);
    let shown = area.show(ctx, |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_width(room.min(WIDEST));
            let hidden = app.notices.len().saturating_sub(SHOWN);
            for (index, notice) in app.notices.iter().enumerate().skip(hidden) {
                line(ui, context, index, notice);
            }
            if hidden > 0 {
                let older = format!("{hidden} older notices");
                ui.label(RichText::new(older).weak().small());
            }
        });
    });
    // It stands on its lower edge, and its height is known once it has been drawn: where that is another, it is placed anew at once
    // and does not wait for the pointer to come.
    let (id, size) = (
        Id::unique("size of the notices"),
        shown.response.rect.size(),
    );
    let before = ctx.data_mut(|data| data.get_temp::<egui::Vec2>(id));
    if before != Some(size) {
        ctx.data_mut(|data| data.insert_temp(id, size));
        ctx.request_repaint();
    }
}

fn line(ui: &mut Ui, context: &mut ViewContext<'_>, index: usize, notice: &Notice) {
    let look = context.app.options.theme;
    let colour = if notice.is_error {
        theme::error_colour(look)
    } else {
        theme::accent_colour(look)
    };
    ui.horizontal_top(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(4.0, 18.0), egui::Sense::hover());
        ui.painter().rect_filled(rect, 1.0, colour);
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            if ui.small_button("Dismiss").clicked() {
                context.push(Command::Dismiss(index));
            }
            if let Some(action) = notice.offer {
                let button = ui.small_button(action.label());
                if button.on_hover_text(action.hint()).clicked() {
                    context.push(Command::Do(action));
                }
            }
            ui.with_layout(Layout::left_to_right(Align::Min), |ui| {
                let text = context.app.options.units.sentence(&notice.text);
                // Laid out here: a label in a row would be as wide as its text, and lie over the buttons.
                let lines = ui.painter().layout_job(words(ui, &text));
                ui.add(Label::new(lines)).on_hover_text(&text);
            });
        });
    });
}

/// The sentence in a few lines; a path without a space breaks where the line ends.
fn words(ui: &Ui, text: &str) -> LayoutJob {
    let mut job = LayoutJob::default();
    let colour = ui.visuals().strong_text_color();
    RichText::new(text).strong().color(colour).append_to(
        &mut job,
        ui.style(),
        FontSelection::Default,
        Align::Min,
    );
    job.wrap = TextWrapping {
        max_rows: LINES,
        max_width: ui.available_width(),
        ..TextWrapping::default()
    };
    job
}
