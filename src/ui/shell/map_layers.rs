//! Draws the controls of the layers of the map, the topmost first: visibility, opacity and order;
//! and those of the swipe, which choose the side of the divider for each layer.

use crate::app::{Action, LayerShown, LayerStack, MapOptions, SwipeSide};
use crate::ui::controls::number_slider;
use crate::ui::drop_down::DropDown;
use crate::ui::hint_with_key;
use egui::{Button, Checkbox, RichText, Ui};

/// Width of a layer's name and of its opacity, points.
const WIDTHS: [f32; 2] = [118.0, 84.0];

/// Draws a row for each layer.
pub(super) fn control(ui: &mut Ui, stack: &mut LayerStack) {
    let rows: Vec<LayerShown> = stack.bottom_up().rev().copied().collect();
    let last = rows.len().saturating_sub(1);
    egui::Grid::new("map layers").num_columns(3).spacing([8.0, 3.0]).show(ui, |ui| {
        for (index, shown) in rows.into_iter().enumerate() {
            visible(ui, stack, shown);
            opacity(ui, stack, shown);
            order(ui, stack, shown, [index > 0, index < last]);
            ui.end_row();
        }
    });
}

fn visible(ui: &mut Ui, stack: &mut LayerStack, shown: LayerShown) {
    let mut visible = shown.visible;
    ui.set_min_width(WIDTHS[0]);
    let check = ui.add(Checkbox::new(&mut visible, shown.layer.name()));
    if check.on_hover_text(shown.layer.hint()).changed() {
        stack.set_visible(shown.layer, visible);
    }
}

fn opacity(ui: &mut Ui, stack: &mut LayerStack, shown: LayerShown) {
    let mut percent = (100.0 * shown.opacity).round();
    ui.spacing_mut().slider_width = WIDTHS[1];
    let slider =
        number_slider(&mut percent, 0.0..=100.0).step_by(1.0).fixed_decimals(0).suffix(" %");
    let name = format!("{} opacity", shown.layer.name());
    let slider = ui.add_enabled(shown.visible, slider);
    let slider = slider.on_hover_text(&name).accessible_name(name);
    if slider.changed() {
        stack.set_opacity(shown.layer, percent / 100.0);
    }
}

fn order(ui: &mut Ui, stack: &mut LayerStack, shown: LayerShown, [up, down]: [bool; 2]) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        let mut button = |enabled, text: &str, what: &str| {
            let button = Button::new(RichText::new(text).small());
            let name = format!("{what} {}", shown.layer.name());
            let button = ui.add_enabled(enabled, button).accessible_name(&name);
            button.on_hover_text(name).clicked()
        };
        if button(up, "Up", "Raise") {
            stack.raise(shown.layer);
        }
        if button(down, "Down", "Lower") {
            stack.lower(shown.layer);
        }
    });
}

/// Draws the check box that divides the map, and a row for each visible layer.
pub(super) fn swipe_control(ui: &mut Ui, map: &mut MapOptions) {
    let mut on = map.swipe.on;
    let check = ui.checkbox(&mut on, "Swipe");
    if check.on_hover_text(hint_with_key(Action::Swipe)).changed() {
        map.swipe.toggle(&mut map.layers);
    }
    if !on {
        return;
    }
    let shown = map.layers.bottom_up().rev();
    let shown: Vec<_> = shown.map(|shown| shown.layer).collect();
    egui::Grid::new("swipe sides").num_columns(2).spacing([8.0, 3.0]).show(ui, |ui| {
        for layer in shown.into_iter().filter(|layer| map.layers.is_visible(*layer)) {
            ui.label(RichText::new(layer.name()).small());
            let mut side = map.swipe.side(layer);
            DropDown::new(("side", layer), RichText::new(side.name()).small())
                .width(64.0)
                .pick(ui, &mut side, SwipeSide::ALL, SwipeSide::name)
                .accessible_name(format!("Side of {}", layer.name()));
            if side != map.swipe.side(layer) {
                map.swipe.set_side(layer, side);
            }
            ui.end_row();
        }
    });
}
