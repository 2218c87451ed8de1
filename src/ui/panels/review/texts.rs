//! Edits the texts of a box (name, class, remarks), the certainty of the analyst, and the list of
//! classes.

use crate::app::{App, Command, LogBox};
use crate::ui::panels::parts::name_cell;
use crate::ui::{ViewContext, controls};
use bathyscope_objects::review::{Certainty, Edit, Reviewed};
use egui::{Button, CollapsingHeader, TextEdit, Ui};

/// Number of classes that have a key.
const KEYED: usize = 9;

/// Texts that are being edited in the list.
#[derive(Default)]
pub(super) struct Classes {
    /// The list of classes, and its names as they are being edited.
    written: (Vec<String>, Vec<String>),
    /// Name of a class to add.
    new: String,
}

impl Classes {
    /// Draws the choice of the class of the selected box, and the list of classes.
    pub(super) fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>, review_box: &Reviewed) {
        choose(ui, context, review_box);
        CollapsingHeader::new("Edit classes")
            .id_salt("list of classes")
            .show(ui, |ui| self.list(ui, context));
    }

    /// Draws the survey's list of classes: the name of each, and buttons that move or remove it.
    fn list(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let list = context.app.logs.shown.settings.review.classes.clone();
        if self.written.0 != list {
            self.written = (list.clone(), list.clone());
        }
        for index in 0..list.len() {
            ui.horizontal(|ui| {
                let key = if index < KEYED { format!("{}", index + 1) } else { String::new() };
                ui.add_sized([14.0, 18.0], egui::Label::new(key).selectable(false));
                self.name(ui, context, &list, index);
                place(ui, context, &list, index);
            });
        }
        ui.horizontal(|ui| {
            ui.add_space(14.0 + ui.spacing().item_spacing.x);
            let field =
                TextEdit::singleline(&mut self.new).hint_text("New class").desired_width(110.0);
            let field = ui.add(field).accessible_name("New class");
            let enter = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            let name = self.new.trim().to_owned();
            let is_new = !name.is_empty() && !list.contains(&name);
            let add = ui
                .add_enabled(is_new, Button::new("Add"))
                .accessible_name("Add class")
                .on_hover_text("Adds the class to the end of the list.");
            if is_new && (enter || add.clicked()) {
                let mut list = list.clone();
                list.push(name);
                context.push(Command::SetClasses(list));
                self.new.clear();
            }
        });
    }

    /// Draws the field that renames a class and all boxes of that class.
    fn name(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>, list: &[String], index: usize) {
        let (Some(text), Some(now)) = (self.written.1.get_mut(index), list.get(index)) else {
            return;
        };
        let field = TextEdit::singleline(text).desired_width(110.0);
        let field = ui
            .add(field)
            .accessible_name(format!("Name of class {now}"))
            .on_hover_text("Renames the class in the list and for its boxes in all logs.");
        if !field.lost_focus() {
            return;
        }
        match text.trim() {
            "" => text.clone_from(now),
            to if to == now => text.clone_from(now),
            to => context.push(Command::RenameClass { from: now.clone(), to: to.to_owned() }),
        }
    }
}

/// Draws the buttons that move a class in the list or remove it.
fn place(ui: &mut Ui, context: &mut ViewContext<'_>, list: &[String], index: usize) {
    let name = &list[index];
    let mut press = |label: &str, what: &str, hint: &str, enabled: bool| {
        ui.add_enabled(enabled, Button::new(label).small())
            .accessible_name(format!("{what} {name}"))
            .on_hover_text(hint)
            .clicked()
    };
    let mut after = list.to_vec();
    let hint = "Moves the class up by one: the keys 1 to 9 name the first nine.";
    if press("Up", "Move up", hint, index > 0) {
        after.swap(index - 1, index);
    }
    let is_last = index + 1 == list.len();
    let hint = "Moves the class down by one.";
    if press("Down", "Move down", hint, !is_last) {
        after.swap(index, index + 1);
    }
    let hint = "Removes the class from the list; boxes keep it.";
    if press("×", "Remove class", hint, true) {
        after.remove(index);
    }
    if after != list {
        context.push(Command::SetClasses(after));
    }
}

/// Draws a button for each class, which gives that class to the selected box.
fn choose(ui: &mut Ui, context: &mut ViewContext<'_>, review_box: &Reviewed) {
    let app = context.app;
    let now = app.logs.shown.reviewing.review.class_name(review_box.class);
    let mut chosen = None;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (class, name) in app.logs.class_names().into_iter().enumerate() {
            let (label, hint) = if class < KEYED {
                (format!("{} {name}", class + 1), format!("Key {}", class + 1))
            } else {
                (name.to_owned(), String::new())
            };
            let chip =
                controls::chip(ui, name == now, label).accessible_name(format!("Class {name}"));
            let chip = if hint.is_empty() { chip } else { chip.on_hover_text(hint) };
            if chip.clicked() {
                chosen = Some(name.to_owned());
            }
        }
    });
    if let Some(name) = chosen {
        context.push(Command::Edit { edit: Edit::Classify(review_box.id, name), live: false });
    }
}

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
