//! Draws the list of changes, with the present step, where a click goes back or forward to a step;
//! and the list of all notices since the program was started: time, text, and offered action.

use crate::app::{Command, Notice};
use crate::ui::list_keys::ListKeys;
use crate::ui::panels::parts;
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::presentation::text;
use egui::{Align, Button, Layout, Response, RichText, ScrollArea, Ui, Window, vec2};
use std::time::UNIX_EPOCH;

const WIDTH: f32 = 320.0;
const HEIGHT: f32 = 420.0;
/// Height of a row, points.
const ROW: f32 = 20.0;

/// The list of changes; closed at the start.
#[derive(Default)]
pub(super) struct HistoryList {
    /// True if the list is shown.
    pub open: bool,
    /// Number of done steps when the list was last drawn; when it changes, the list scrolls to the
    /// present step.
    at: Option<usize>,
}

impl HistoryList {
    /// Draws the list while it is open.
    pub(super) fn ui(&mut self, ctx: &egui::Context, context: &mut ViewContext<'_>) {
        if !self.open {
            self.at = None;
            return;
        }
        let mut open = true;
        Window::new("History")
            .open(&mut open)
            .collapsible(false)
            .default_size([WIDTH, HEIGHT])
            .default_pos(ctx.content_rect().center_top() + egui::vec2(-0.5 * WIDTH, 60.0))
            .show(ctx, |ui| self.list(ui, context));
        self.open &= open;
    }

    fn list(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let units = context.units();
        let steps: Vec<(String, bool)> = (context.app.document.history.steps())
            .map(|step| (units.sentence(step.label), step.is_undone))
            .collect();
        let done = steps.iter().filter(|(_, is_undone)| !is_undone).count();
        let opened = std::iter::once(("as opened".to_owned(), false));
        let rows: Vec<(String, bool)> = opened.chain(steps).collect();
        let follows = self.at.replace(done) != Some(done);
        let mut area = ScrollArea::vertical().auto_shrink([false, false]);
        if follows {
            let spacing = ui.spacing().item_spacing.y;
            let middle = (ROW + spacing) * done as f32 - 0.5 * ui.available_height();
            area = area.vertical_scroll_offset(middle.max(0.0));
        }
        let keys = ListKeys::read(ui, "steps", rows.len());
        let each = ROW + ui.spacing().item_spacing.y;
        let area = keys.scroll(area, each, ui.available_height() / each);
        area.show_rows(ui, ROW, rows.len(), |ui, range| {
            for (count, (label, is_undone)) in rows[range.clone()].iter().enumerate() {
                let count = range.start + count;
                let row = row(ui, context, (label, *is_undone), count == done);
                keys.row(ui, count, &row);
                if row.clicked() && count != done {
                    context.push(Command::GoToStep(count));
                }
            }
        });
    }
}

/// Draws a step, in weak text if it was undone.
fn row(
    ui: &mut Ui,
    context: &ViewContext<'_>,
    (label, is_undone): (&str, bool),
    is_here: bool,
) -> Response {
    let text = RichText::new(label);
    let text = match (is_here, is_undone) {
        (true, _) => text.color(theme::accent_colour(context.theme())).strong(),
        (false, true) => text.weak().italics(),
        (false, false) => text,
    };
    let size = egui::vec2(ui.available_width(), ROW);
    let state = match (is_here, is_undone) {
        (true, _) => "here",
        (false, true) => "taken back",
        (false, false) => "done",
    };
    let button = ui.add(Button::selectable(is_here, text).min_size(size).truncate());
    let button = button.accessible_name(format!("Step {label}, {state}"));
    button.on_hover_text("Goes back or forward to this step.")
}

const SIZE: [f32; 2] = [560.0, 420.0];

/// The list of notices; closed at the start.
#[derive(Default)]
pub(super) struct NoticeList {
    /// True if the list is shown.
    pub open: bool,
}

impl NoticeList {
    /// Draws the list while it is open.
    pub(super) fn ui(&mut self, ctx: &egui::Context, context: &mut ViewContext<'_>) {
        if !self.open {
            return;
        }
        let mut open = true;
        let room = ctx.content_rect().shrink(8.0);
        let size = vec2(SIZE[0], SIZE[1]).min(room.size());
        Window::new("Notices")
            .open(&mut open)
            .collapsible(false)
            .default_size(size)
            .max_size(room.size())
            .default_pos(room.center_bottom() - vec2(0.5 * size.x, size.y + 40.0))
            .show(ctx, |ui| list(ui, context));
        self.open &= open;
    }
}

fn list(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    if app.notices.all().len() == 0 {
        parts::remark(ui, "There are no messages yet.");
    }
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        for notice in app.notices.all() {
            line(ui, context, notice);
        }
    });
}

fn line(ui: &mut Ui, context: &mut ViewContext<'_>, notice: &Notice) {
    let said = context.units().sentence(&notice.text);
    ui.horizontal_top(|ui| {
        parts::severity(ui, context.theme(), notice.is_error);
        let unix_s = notice.at.duration_since(UNIX_EPOCH).unwrap_or_default();
        let clock = text::clock(Some(0.0), unix_s.as_secs_f64());
        ui.label(RichText::new(clock).monospace().weak());
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            if let Some(action) = notice.offer {
                context.button(ui.small_button(action.label()), action);
            }
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                ui.add(egui::Label::new(said).wrap());
            });
        });
    });
    ui.add_space(2.0);
}
