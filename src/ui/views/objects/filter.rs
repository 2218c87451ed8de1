//! The text and the state that rows are looked for by.

use crate::app::{ObjectState, ObjectTable};
use crate::ui::drop_down::DropDown;
use crate::ui::{ViewContext, text};
use egui::{RichText, TextEdit, Ui};

/// Width of the field, points.
const FIELD_WIDTH: f32 = 220.0;

pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mut table = context.options().objects.clone();
    ui.horizontal_wrapped(|ui| {
        let field =
            TextEdit::singleline(&mut table.text).hint_text("Filter").desired_width(FIELD_WIDTH);
        ui.add(field)
            .accessible_name("Filter of the objects")
            .on_hover_text("Number, or part of the name, the class or the remarks.");
        let shown = table.state.map_or("all states", ObjectState::name);
        DropDown::new("state of objects", shown)
            .show(ui, |choices| {
                choices.value(&mut table.state, None, "all states");
                for state in ObjectState::ALL {
                    choices.value(&mut table.state, Some(state), state.name());
                }
            })
            .accessible_name("State of the objects");
        let listed = context.app.listed_objects().len();
        let all = context.app.objects().len();
        let objects = text::plural(all, "object", "objects");
        let count = if listed == all {
            objects
        } else {
            format!("{} of {objects}, by the filter", text::count(listed))
        };
        ui.label(RichText::new(count).strong());
        let keys = "Up and Down select a row, Enter or a double-click shows it enlarged.";
        ui.label(RichText::new(keys).weak());
    });
    show(context, table);
}

/// Has the table shown with another order or filter.
pub(super) fn show(context: &mut ViewContext<'_>, table: ObjectTable) {
    let mut options = context.options().clone();
    options.objects = table;
    context.show(options);
}
