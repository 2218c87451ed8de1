//! Draws the list of changes, with the present step; a click goes back or forward to a step.

use crate::app::Command;
use crate::ui::list_keys::ListKeys;
use crate::ui::{ViewContext, theme};
use egui::{Button, Response, RichText, ScrollArea, Ui, Window};

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
