//! Draws the review of the boxes of all logs: its progress, the selected box enlarged with all its
//! facts, the other boxes of the same object, the queue, and, if truth is known, the comparison
//! with it.
//!
//! The panel reads the state of the app, draws controls and pictures of boxes, and sends commands.

mod judged;
mod queue;
mod selected;
mod texts;

use super::parts::{progress_bar, remark, warning, within};
use super::section::{Section, section};
use crate::app::{Action, App};
use crate::ui::views::chip::{self, BoxChip};
use crate::ui::{ViewContext, text};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_products::pipeline::Background;
use egui::{LayerId, Rect, Response, RichText, Ui};

/// Title of the section.
pub(super) const TITLE: &str = "Review";

/// State of the panel: the picture of the selected box, and the texts that are being edited.
#[derive(Default)]
pub(crate) struct ReviewPanel {
    chip: Background<chip::ChipKey, BoxChip>,
    lines: texts::BoxTexts,
    classes: texts::Classes,
    /// The pictures of the boxes that show the selected object.
    sightings: chip::Chips,
    /// Layer and area of the panel when it was drawn last; `None` while it is not drawn.
    area: Option<(LayerId, Rect)>,
}

impl ReviewPanel {
    /// Returns true if the pictures show the present selected box and its object.
    pub(crate) fn is_settled(&self) -> bool {
        !self.chip.is_running() && !self.sightings.is_running()
    }

    /// Returns true if a control belongs to the panel.
    pub(crate) fn holds(&self, control: &Response) -> bool {
        self.area.is_some_and(|(layer, area)| {
            control.layer_id == layer && area.contains(control.rect.center())
        })
    }

    /// Moves the keyboard to the name of the selected box.
    pub(crate) fn name_box(&mut self) {
        self.lines.wants_name = true;
    }

    /// Forgets the area of the panel while it is not drawn, and everything once there are no boxes.
    pub(super) fn leave(&mut self, app: &App) {
        if app.logs.has_boxes() {
            self.area = None;
        } else {
            *self = Self::default();
        }
    }

    /// Draws the section.
    pub(super) fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let top = ui.cursor().min;
        section(ui, context, &Section::new(TITLE), |ui, context| {
            progress(ui, context);
            if let Some(note) = context.app.search_note() {
                warning(ui, context, &note);
            }
            within(ui, |ui| self.selected(ui, context));
            within(ui, |ui| selected::object(ui, context, &mut self.sightings));
            within(ui, |ui| judged::at_slider(ui, context));
            queue::ui(ui, context);
            objects(ui, context);
            files(ui, context);
        });
        judged::ui(ui, context);
        let end = egui::pos2(ui.max_rect().right(), ui.cursor().top());
        self.area = Some((ui.layer_id(), Rect::from_min_max(top, end)));
    }
}

fn progress(ui: &mut Ui, context: &ViewContext<'_>) {
    let all = context.app.logs.review_counts();
    let counts = all.boxes;
    let (decided, total) = (counts.decided(), counts.total());
    let said = match all.logs {
        0 | 1 => format!("{decided} of {total} decided"),
        logs => format!("{decided} of {total} decided in {logs} logs"),
    };
    ui.horizontal(|ui| {
        ui.label(RichText::new(&said).strong());
        let share = decided as f32 / total.max(1) as f32;
        ui.add(progress_bar(context, share, ui.available_width()));
    });
    let parts = [
        format!("{} accepted", counts.accepted),
        format!("{} rejected", counts.rejected),
        format!("{} added", counts.added),
    ];
    remark(ui, parts.join(" · "));
    if counts.hidden > 0 {
        let proposals = text::plural(counts.hidden, "proposal", "proposals");
        remark(ui, format!("{proposals} below the least score"));
    }
    let app = context.app;
    // The remark always takes one line, so that the controls below it do not move.
    let saved =
        if app.is_at_risk() { "Decisions are not saved." } else { "All decisions are saved." };
    remark(ui, saved);
}

/// Draws the number of objects, and a button that shows their table.
fn objects(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let count = context.app.objects.all().len();
    if count == 0 {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label(text::plural(count, "object", "objects"));
        button(ui, context, (Action::FocusObjects, "Table"));
    });
}

fn files(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let named = [
        (Action::SaveReview, "Save"),
        (Action::OpenReview, "Open…"),
        (Action::ExportBoxes, "Export…"),
    ];
    buttons(ui, context, &named);
}

/// Draws a row of buttons, as [`button`] does.
fn buttons(ui: &mut Ui, context: &mut ViewContext<'_>, named: &[(Action, &str)]) {
    ui.horizontal_wrapped(|ui| named.iter().for_each(|named| button(ui, context, *named)));
}

/// Draws a button of an action with another label; its hint shows the key of the action.
fn button(ui: &mut Ui, context: &mut ViewContext<'_>, (action, name): (Action, &str)) {
    let button = ui.button(name);
    context.keyed_button(button.accessible_name(action.label()), action);
}

/// Returns the extent along the track and in slant range as text: `0.82 × 1.30 m`.
fn size([along_m, across_m]: [f64; 2], units: Units) -> String {
    if along_m.is_finite() {
        let along = units.number(along_m, 2);
        let across = units.measure(across_m, 2);
        format!("{along} × {across}")
    } else {
        format!("{} across", units.measure(across_m, 2))
    }
}
