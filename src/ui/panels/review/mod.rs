//! The review of the boxes of all logs: how far it is, the selected box enlarged with all that is known about it, the other boxes that
//! show the same object, the queue, the list of objects, and where truth is known how the boxes stand to it.

mod chip;
mod judged;
mod lines;
mod object;
mod queue;
mod selected;
mod table;

use super::parts::{warning, within};
use super::section::{Section, section};
use crate::app::{Action, Command};
use crate::pipeline::Background;
use crate::presentation::units::Units;
use crate::ui::{ViewContext, theme};
use chip::Chip;
use egui::{Button, ProgressBar, RichText, Ui};
use object::ObjectPictures;

/// State of the panel: the picture of the selected box, and what is being written about it.
#[derive(Default)]
pub struct ReviewPanel {
    chip: Background<chip::Key, Chip>,
    lines: lines::Lines,
    object: ObjectPictures,
}

impl ReviewPanel {
    /// Whether the picture is that of the selected box.
    pub fn is_settled(&self) -> bool {
        !self.chip.is_running() && self.object.is_settled()
    }

    /// Moves the keyboard to the name of the selected box.
    pub fn name_box(&mut self) {
        self.lines.wants_name = true;
    }

    /// Draws the section; nothing while there are no boxes.
    pub fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        if !context.app.has_boxes() {
            *self = Self::default();
            return;
        }
        let heading = Section {
            number: None,
            title: "Review",
            stage: None,
        };
        section(ui, context, &heading, |ui, context| {
            progress(ui, context);
            if let Some(note) = context.app.search_note() {
                warning(ui, context, &note);
            }
            within(ui, |ui| self.selected(ui, context));
            within(ui, |ui| self.object.ui(ui, context));
            within(ui, |ui| judged::at_slider(ui, context));
            queue::ui(ui, context);
            files(ui, context);
        });
        table::ui(ui, context);
        judged::ui(ui, context);
    }
}

fn progress(ui: &mut Ui, context: &ViewContext<'_>) {
    let all = context.app.review_counts();
    let counts = all.boxes;
    let (decided, total) = (counts.decided(), counts.total());
    let said = match all.logs {
        0 | 1 => format!("{decided} of {total} decided"),
        logs => format!("{decided} of {total} decided in {logs} logs"),
    };
    ui.horizontal(|ui| {
        ui.label(RichText::new(&said).strong());
        let share = decided as f32 / total.max(1) as f32;
        let bar = ProgressBar::new(share)
            .desired_width(ui.available_width())
            .desired_height(8.0)
            .fill(theme::accent_colour(context.app.options.theme));
        ui.add(bar);
    });
    let mut parts = vec![
        format!("{} accepted", counts.accepted),
        format!("{} rejected", counts.rejected),
        format!("{} added", counts.added),
    ];
    if counts.hidden > 0 {
        parts.push(format!("{} below the confidence", counts.hidden));
    }
    if context.app.has_unsaved_review() {
        // What is kept on the way is safe, but not where the analyst put it.
        let kept = match context.app.is_at_risk() {
            true => "not saved",
            false => "not saved, kept next to the log",
        };
        parts.push(kept.to_owned());
    }
    // On one line whatever it says: all that is clicked lies below it.
    let said = parts.join(" · ");
    let words = RichText::new(&said).weak().small();
    ui.add(egui::Label::new(words).truncate());
}

fn files(ui: &mut Ui, context: &mut ViewContext<'_>) {
    ui.horizontal_wrapped(|ui| {
        for (action, name) in [
            (Action::SaveReview, "Save"),
            (Action::OpenReview, "Open…"),
            (Action::ExportBoxes, "Export…"),
        ] {
            button(ui, context, action, name, true);
        }
    });
}

/// A button for an action of the table, with its key in the hint.
fn button(ui: &mut Ui, context: &mut ViewContext<'_>, action: Action, name: &str, enabled: bool) {
    let hint = match action.keys() {
        Some(keys) => format!("{} ({keys})", action.hint()),
        None => action.hint().to_owned(),
    };
    let button = ui
        .add_enabled(enabled, Button::new(name))
        .accessible_name(action.label())
        .on_hover_text(hint);
    if button.clicked() {
        context.push(Command::Do(action));
    }
}

/// Extent along the track and in slant range: `0.82 × 1.30 m`.
fn size([along_m, across_m]: [f64; 2], units: Units) -> String {
    if along_m.is_finite() {
        format!(
            "{} × {}",
            units.number(along_m, 2),
            units.measure(across_m, 2)
        )
    } else {
        format!("{} across", units.measure(across_m, 2))
    }
}
