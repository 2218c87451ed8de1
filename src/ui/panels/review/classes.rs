//! Draws the choice of the class of the selected box, and the list of classes, which can be edited.

use crate::app::Command;
use crate::ui::{ViewContext, controls};
use bathyscope_objects::review::{Edit, Reviewed};
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
