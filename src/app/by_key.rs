//! Notifies the analyst of changes that a bare key made, with undo, so that a slip of the hand, or
//! text that is typed outside a field, is noticed at once.

use super::history::{LogStep, UndoStep};
use super::{Action, App, Command, Enlarged, KeyFocus, LogBox, MapLayer, View};
use bathyscope_objects::review::BoxId;
use bathyscope_products::pipeline::{SettingValues, setting_values};
use std::sync::Arc;

/// Prefix of the keys of settings that change how the waterfall looks, but no result.
const PICTURE: &str = "picture.";

impl App {
    /// Notifies the analyst of depths and decisions that a bare key has changed since `before`, and
    /// offers undo. The next key replaces the notice.
    pub(crate) fn say_changed_by_key(&mut self, keys: &str, before: &UndoStep) {
        if !changes_results(before, &self.step_now()) {
            return;
        }
        let done = self.document.history.undo_label().unwrap_or("settings").to_owned();
        self.notices.offer_undo(format!("key {keys}: {done}"));
    }

    /// Returns true if a bare key must not act, and notifies the analyst of the reason: the action
    /// needs confirmation, or the object that it acts on is not selected or not visible.
    pub(crate) fn holds_key_back(
        &mut self,
        keys: &str,
        command: &Command,
        focus: KeyFocus,
    ) -> bool {
        match *command {
            Command::Do(action) if action.asks_by_key() => self.ask_by_key(keys, action),
            Command::Do(Action::ThresholdDown | Action::ThresholdUp) => {
                let is_blind = self.view.selection.is_none();
                if is_blind {
                    self.notices.warn("select a ping first: its profile shows the threshold");
                }
                is_blind
            }
            Command::Do(action) if action.is_about_selected_box() => self.misses_box(keys, focus),
            Command::Edit { .. } | Command::Nudge(_) => self.misses_box(keys, focus),
            _ => false,
        }
    }

    /// Offers an action whose key alone must not carry it out; returns true if it was offered.
    fn ask_by_key(&mut self, keys: &str, action: Action) -> bool {
        let consequence = match action {
            Action::SwapSides if self.logs.shown.survey.is_some() => {
                "exchange port and starboard of this log in every view and product"
            }
            // The other actions notify the analyst themselves of what is missing.
            _ => return false,
        };
        self.notices.withdraw(action);
        self.notices.offer(format!("key {keys}: {consequence}?"), action);
        true
    }

    /// Returns true if no box is selected, or the selected box is not visible where the key was
    /// pressed; a box outside the visible pings is brought into view.
    fn misses_box(&mut self, keys: &str, focus: KeyFocus) -> bool {
        let Some(review_box) = self.logs.shown.reviewing.selected_box() else {
            self.notices.ask_for_box();
            return true;
        };
        let (BoxId(number), pings) = (review_box.id, review_box.mark.pings.clone());
        let options = &self.view.options;
        let is_drawn = match focus {
            KeyFocus::View(View::Waterfall) => options.waterfall.boxes,
            KeyFocus::View(View::Map) => options.map.layers.is_visible(MapLayer::Boxes),
            KeyFocus::View(View::Cloud) => options.cloud.boxes,
            KeyFocus::View(View::Objects | View::Profile) | KeyFocus::Review => true,
        };
        if !is_drawn {
            let show = Action::Boxes.key();
            self.notices.warn(format!("boxes are hidden here; {show} shows them"));
            return true;
        }
        let is_in_view = focus != KeyFocus::View(View::Waterfall)
            || pings.start < self.view.visible.end && self.view.visible.start < pings.end;
        if !is_in_view {
            let hidden = LogBox { log: self.logs.shown.id, id: BoxId(number) };
            self.show_box(hidden, Enlarged::AsItIs);
            let text = format!("box {number} was out of view; press {keys} again");
            self.notices.notify(text);
        }
        !is_in_view
    }
}

/// Returns true if depths, places or decisions differ between two steps.
fn changes_results(before: &UndoStep, after: &UndoStep) -> bool {
    let shared = !Arc::ptr_eq(&before.shared, &after.shared)
        && results_of(&setting_values(&before.shared))
            != results_of(&setting_values(&after.shared));
    let logs = before.logs.len() != after.logs.len()
        || (before.logs.iter().zip(&after.logs)).any(|(was, is)| changes_log(was, is));
    shared || logs || before.closed != after.closed || before.mountings != after.mountings
}

fn changes_log(before: &LogStep, after: &LogStep) -> bool {
    let own = !Arc::ptr_eq(&before.own, &after.own)
        && (results_of(before.own.own()) != results_of(after.own.own())
            || before.own.bottom != after.own.bottom);
    own || !Arc::ptr_eq(&before.review, &after.review)
        || before.id != after.id
        || before.is_visible != after.is_visible
}

/// Returns the settings that affect results.
fn results_of(values: &SettingValues) -> SettingValues {
    let mut values = values.clone();
    values.retain(|key, _| !key.starts_with(PICTURE));
    values
}
