//! Drags with a tool in hand, the same in all views.

use crate::app::ExclusionEdit;
use egui::{Key, Modifiers, PointerButton, Pos2, Response, Ui};

/// Where a drag with a tool in hand began in this frame; with Space held it moves the picture instead.
pub(super) fn begun(ui: &Ui, response: &Response) -> Option<Pos2> {
    let (space, pressed) =
        ui.input(|input| (input.key_down(Key::Space), input.pointer.press_origin()));
    let begun = response.drag_started_by(PointerButton::Primary) && !space;
    let at = pressed.or(response.interact_pointer_pos());
    at.filter(|_| begun)
}

/// Whether a drag ended with the button still held: Escape ends it, and nothing is to come of it.
pub(super) fn is_given_up(ui: &Ui, response: &Response) -> bool {
    response.drag_stopped() && ui.input(|input| input.pointer.primary_down())
}

/// What the tool for excluded stretches does by the keys that are held.
pub(super) fn exclusion_edit(held: Modifiers) -> ExclusionEdit {
    if held.alt {
        ExclusionEdit::Reset
    } else if held.command {
        ExclusionEdit::Include
    } else {
        ExclusionEdit::Exclude
    }
}
