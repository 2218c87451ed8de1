//! The options of a view, at the right end of its title bar.

use crate::app::{Action, ColourMap, Command, View, ViewOptions, WaterfallOptions};
use crate::ui::ViewContext;
use egui::Ui;

/// Draws the controls from right to left.
pub fn ui(ui: &mut Ui, view: View, context: &mut ViewContext<'_>) {
    ui.add_space(6.0);
    ui.spacing_mut().item_spacing.x = 4.0;
    let before = context.app.options.clone();
    let mut options = before.clone();
    match view {
        View::Waterfall => waterfall(ui, context, &mut options),
        // These draw their controls themselves.
        View::Map | View::Cloud => {}
    }
    if options != before {
        context.push(Command::Show(Box::new(options)));
    }
}

fn button(ui: &mut Ui, context: &mut ViewContext<'_>, action: Action, label: &str) {
    let button = ui.small_button(label).accessible_name(action.label());
    let hint = action.keys().map_or_else(
        || action.hint().to_owned(),
        |keys| format!("{} ({keys})", action.hint()),
    );
    if button.on_hover_text(hint).clicked() {
        context.push(Command::Do(action));
    }
}

fn switch(ui: &mut Ui, on: &mut bool, label: &str, hint: &str) {
    let text = egui::RichText::new(label).small();
    ui.toggle_value(on, text).on_hover_text(hint);
}

fn waterfall(ui: &mut Ui, context: &mut ViewContext<'_>, options: &mut ViewOptions) {
    button(ui, context, Action::Orientation, "Turn");
    let shown = &mut options.waterfall;
    switch(
        ui,
        &mut shown.range_lines,
        "Range lines",
        "Lines of equal slant range.",
    );
    switch(
        ui,
        &mut shown.first_return,
        "First return",
        "Draws the first return on both sides (B).",
    );
    egui::containers::menu::MenuButton::new(egui::RichText::new("Levels").small())
        .config(
            egui::containers::menu::MenuConfig::new()
                .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside),
        )
        .ui(ui, |ui| levels(ui, shown));
    egui::ComboBox::from_id_salt("colour map")
        .width(92.0)
        .selected_text(egui::RichText::new(shown.colour_map.name()).small())
        .show_ui(ui, |ui| {
            for map in ColourMap::ALL {
                ui.selectable_value(&mut shown.colour_map, map, map.name());
            }
        })
        .response
        .accessible_name("Colour map")
        .on_hover_text("Colours of echo strength.");
}

/// Brightness, contrast and gamma.
pub fn levels(ui: &mut Ui, options: &mut WaterfallOptions) {
    ui.spacing_mut().slider_width = 140.0;
    ui.add(
        egui::Slider::new(&mut options.brightness, -1.0..=1.0)
            .text("brightness")
            .fixed_decimals(2),
    );
    ui.add(
        egui::Slider::new(&mut options.contrast, 0.1..=10.0)
            .logarithmic(true)
            .text("contrast")
            .fixed_decimals(2),
    );
    ui.add(
        egui::Slider::new(&mut options.gamma, 0.2..=5.0)
            .logarithmic(true)
            .text("gamma")
            .fixed_decimals(2),
    );
    if ui.button("Reset").clicked() {
        options.reset_levels();
    }
}
