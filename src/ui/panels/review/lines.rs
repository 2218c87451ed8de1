//! Edits the texts of a box: name, class, remarks, and the analyst's certainty.

use super::super::parts::name_cell;
use crate::app::{App, Command, LogBox};
use crate::ui::{ViewContext, controls};
use bathyscope_objects::review::{Certainty, Edit, Reviewed};
use egui::{TextEdit, Ui};

bathyscope_log::listed! {
    /// All lines, in their order.
    const ALL;

    /// A text of a box.
    #[derive(Clone, Copy, PartialEq)]
    enum Line {
        Name,
        Class,
        Note,
    }
}

impl Line {
    /// Returns the heading of the text, its name for screen readers, and its hint.
    fn words(self) -> [&'static str; 3] {
        match self {
            Self::Name => {
                ["Name", "Name of the box", "What you call it, in tables, maps and the report."]
            }
            Self::Class => {
                ["Class", "Class of the box", "A class of your own; Edit classes gives it a key."]
            }
            Self::Note => ["Remarks", "Note on the box", "Remarks, for table and report."],
        }
    }

    fn of(self, app: &App, id: LogBox) -> Option<String> {
        let review_box = app.logs.log_box(id)?;
        Some(match self {
            Self::Name => review_box.name.clone(),
            Self::Class => {
                let review = &app.logs.get(id.log)?.reviewing.review;
                review.class_name(review_box.class).to_owned()
            }
            Self::Note => review_box.note.clone(),
        })
    }

    fn edit(self, id: LogBox, text: String) -> Command {
        let edit = match self {
            Self::Name => Edit::Rename(id.id, text),
            Self::Class => Edit::Classify(id.id, text),
            Self::Note => Edit::Note(id.id, text),
        };
        Command::EditIn(id.log, edit)
    }
}

/// The texts of a box that are being edited.
#[derive(Default)]
pub(super) struct BoxTexts {
    written: Option<(LogBox, [String; 3])>,
    /// True if the field of the name gets the keyboard when it is drawn next.
    pub wants_name: bool,
}

impl BoxTexts {
    /// Draws the fields of the texts of the selected box.
    pub(super) fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>, review_box: &Reviewed) {
        self.keep(context, context.app.logs.shown.selected_box());
        let Some((id, texts)) = &mut self.written else {
            return;
        };
        for (line, text) in Line::ALL.into_iter().zip(texts) {
            let now = line.of(context.app, *id).unwrap_or_default();
            let [heading, name, hint] = line.words();
            let field = TextEdit::singleline(text).hint_text(heading).desired_width(f32::INFINITY);
            let field = ui.horizontal(|ui| {
                name_cell(ui, heading, hint);
                ui.add(field).accessible_name(name)
            });
            let field = field.inner;
            if line == Line::Name && std::mem::take(&mut self.wants_name) {
                field.request_focus();
                field.scroll_to_me(None);
            }
            if field.lost_focus() && *text != now {
                context.push(line.edit(*id, text.clone()));
            } else if !field.has_focus() {
                // The text was changed elsewhere, for example by undo.
                text.clone_from(&now);
            }
        }
        certainty(ui, context, *id, review_box);
    }

    /// Starts editing the texts of another box; edited texts of the last box are saved, even if
    /// that belongs to another log.
    pub(super) fn keep(&mut self, context: &mut ViewContext<'_>, now: Option<LogBox>) {
        if self.written.as_ref().map(|(id, _)| *id) == now {
            return;
        }
        let app = context.app;
        let before = self.written.take();
        self.written = now.map(|id| {
            let text = |line: Line| line.of(app, id).unwrap_or_default();
            (id, Line::ALL.map(text))
        });
        let Some((id, texts)) = before else {
            return;
        };
        for (line, text) in Line::ALL.into_iter().zip(texts) {
            if line.of(app, id).is_some_and(|now| now != text) {
                context.push(line.edit(id, text));
            }
        }
    }
}

/// Draws the certainty of the analyst; a click on the chosen word removes it.
fn certainty(ui: &mut Ui, context: &mut ViewContext<'_>, id: LogBox, review_box: &Reviewed) {
    let hint = "Your own certainty; the score is that of the detector.";
    ui.horizontal_wrapped(|ui| {
        name_cell(ui, "Certainty", hint);
        for word in Certainty::ALL {
            let chosen = review_box.certainty == Some(word);
            let button = controls::chip(ui, chosen, word.name());
            let button = button.accessible_name(format!("Certainty {}", word.name()));
            if button.clicked() {
                let rated = (!chosen).then_some(word);
                context.push(Command::EditIn(id.log, Edit::Rate(id.id, rated)));
            }
        }
    });
}
