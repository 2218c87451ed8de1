//! Draws step 5: objects on the bottom, found by a detector and decided by the analyst.

use super::parts::{self, fact};
use super::section::{Section, section};
use crate::app::{Action, SearchStatus};
use crate::ui::{ViewContext, text};
use egui::{Button, Ui};

/// Draws the section.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    section(ui, context, Section::new("Objects").step(5), |ui, context| {
        found(ui, context);
        if let Some(note) = context.app.search_note() {
            parts::warning(ui, context, &note);
        }
        let hint = context.app.findings.search.model_description().map_or_else(
            || "The detector in use.".to_owned(),
            |known| format!("The detector in use: {known}"),
        );
        fact(ui, "Model", &hint, context.app.findings.search.model_name());
        search(ui, context);
    });
}

fn found(ui: &mut Ui, context: &ViewContext<'_>) {
    if !context.app.logs.has_boxes() {
        let key = Action::NewBox.key();
        let text = format!("No boxes yet: find objects, or draw a box with {key}.");
        return parts::remark(ui, text);
    }
    let all = context.app.logs.review_counts();
    let counts = all.boxes;
    let boxes = text::plural(counts.total(), "box", "boxes");
    let value = match counts.proposed {
        0 if context.app.search_note().is_some() => format!("{boxes} so far, decided"),
        0 => format!("{boxes} · all decided"),
        open => format!("{boxes} · {} undecided", text::count(open)),
    };
    let hint = "Boxes from the least score on, and those that were decided.";
    fact(ui, "Found", hint, value);
    if all.logs > 1 {
        let logs = text::plural(all.logs, "log", "logs");
        let hint = "Logs that have boxes, and the objects that all their boxes show.";
        let objects = text::plural(context.app.objects.all().len(), "object", "objects");
        fact(ui, "In", hint, format!("{logs} · {objects}"));
    }
}

fn search(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if let Some(status) = context.app.search_status() {
        if status.logs > 1 {
            parts::remark(ui, searching(context, &status));
        }
        ui.horizontal(|ui| {
            ui.add(parts::progress_bar(context, status.share, 140.0));
            let stop = ui.small_button("Stop");
            context.button_with_hint(stop, Action::Cancel, "What was found so far stays.");
        });
        return;
    }
    let ready = context.app.logs.shown.products.is_some();
    ui.horizontal(|ui| {
        for (action, ready) in [(Action::FindObjects, ready), (Action::ChooseModel, true)] {
            let button = ui.add_enabled(ready, Button::new(action.label()));
            let lack = "There is no track yet to place objects on.";
            context.button(button.on_disabled_hover_text(lack), action);
        }
    });
}

/// Returns the text of a running search: `Searching lake-2, log 2 of 4`.
fn searching(context: &ViewContext<'_>, status: &SearchStatus) -> String {
    let log = status.log.and_then(|id| context.app.logs.get(id));
    let place = format!("log {} of {}", status.place, status.logs);
    match log {
        Some(log) => format!("Searching {}, {place}", log.name()),
        None => format!("Waiting for results of {place}"),
    }
}
