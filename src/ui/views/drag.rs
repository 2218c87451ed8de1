//! Handles drags with a tool, in the same way for all views.

use crate::app::{App, Command, ExclusionEdit, LogId};
use crate::ui::{stretch_text, theme};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::survey::{LogPart, Side};
use egui::{Color32, Key, Modifiers, PointerButton, Pos2, Response, Ui};

/// Effect of a drag along the pings of a log.
#[derive(Clone, Copy)]
pub(super) enum Does {
    Exclusion(ExclusionEdit),
    Propose,
    Accept(Side, bool),
}

impl Does {
    pub(super) fn command(self, log: LogId, pings: [usize; 2]) -> Command {
        let part = LogPart::Pings(pings);
        match self {
            Self::Exclusion(edit) => Command::Exclude { log, part, edit },
            Self::Propose => {
                Command::ProposeStretch(PingRange { start: pings[0], end: pings[1] + 1 })
            }
            Self::Accept(side, accept) => Command::AcceptBottom { side, pings, accept },
        }
    }

    /// Describes the effect, with the length that the drag covers; `None` if that length is
    /// unknown.
    pub(super) fn words(self, app: &App, log: LogId, pings: [usize; 2]) -> Option<String> {
        let units = app.view.options.units;
        let extent = app.logs.extent_of(log, LogPart::Pings(pings))?;
        let covered = stretch_text::extent(&extent, units);
        Some(match self {
            Self::Exclusion(edit) => stretch_text::of_drag(edit, &extent, units),
            Self::Propose => format!("propose {covered}"),
            Self::Accept(side, true) => format!("accept as bottom, {}: {covered}", side.name()),
            Self::Accept(side, false) => format!("no longer accepted, {}: {covered}", side.name()),
        })
    }

    pub(super) fn colour(self) -> Color32 {
        match self {
            Self::Propose => theme::PROPOSAL_COLOUR,
            Self::Exclusion(_) | Self::Accept(..) => theme::HAND_COLOUR,
        }
    }
}

/// Returns the place where a drag with a tool began in this frame; `None` while Space is held,
/// which makes the drag move the picture instead.
pub(super) fn begun(ui: &Ui, response: &Response) -> Option<Pos2> {
    let (space, pressed) =
        ui.input(|input| (input.key_down(Key::Space), input.pointer.press_origin()));
    let begun = response.drag_started_by(PointerButton::Primary) && !space;
    let at = pressed.or(response.interact_pointer_pos());
    at.filter(|_| begun)
}

/// Returns true if a drag has ended while the button is still held: Escape has ended it, and it
/// must have no effect.
pub(super) fn is_given_up(ui: &Ui, response: &Response) -> bool {
    response.drag_stopped() && ui.input(|input| input.pointer.primary_down())
}

/// Returns the effect of the tool for excluded stretches with the modifier keys that are held.
pub(super) fn exclusion_edit(held: Modifiers) -> ExclusionEdit {
    if held.alt {
        ExclusionEdit::Reset
    } else if held.command {
        ExclusionEdit::Include
    } else if held.shift {
        ExclusionEdit::Trust
    } else {
        ExclusionEdit::Exclude
    }
}
