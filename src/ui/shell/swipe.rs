//! Draws the controls of the swipe, which choose the side of the divider for each layer of the map.

use crate::app::{Action, MapOptions, SwipeSide};
use crate::ui::drop_down::DropDown;
use crate::ui::hint_with_key;
use egui::{RichText, Ui};

/// Draws the check box that divides the map, and a row for each visible layer.
pub(super) fn control(ui: &mut Ui, map: &mut MapOptions) {
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
