//! Defines the table of commands, with names, hints and keys, from which menus, palette, key
//! handling and manual are made, and the views in which the bare key of a command acts. A bare key
//! has no Ctrl and no Alt and is no function key, so that it could be part of a text.

mod rows;

use super::options::{LayoutPreset, View, WorkStep};
use bathyscope_log::formats::formats_to_open;
pub(in crate::app) use rows::action_rows;
use std::sync::LazyLock;

/// A key combination, as text that the window turns into its own key type: `Ctrl+Shift+Z`, `[`,
/// `F11`.
pub type Keys = &'static str;

/// An effect on the window of a command that does not change the state of the app.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WindowAction {
    /// Asks for logs to open.
    OpenLogs,
    /// Asks for logs to add.
    AddLogs,
    /// Asks for a folder of logs.
    OpenFolder,
    /// Shows the field for a path.
    OpenPath,
    /// Asks for a base map.
    OpenBaseMap,
    /// Asks for the area of isobaths.
    OpenIsobathArea,
    /// Asks for readings of a gauge or tide.
    OpenWaterLevels,
    /// Asks for the track of another receiver.
    OpenTrack,
    /// Asks for a review of the log.
    OpenReview,
    /// Asks for the objects that are known to lie in the log.
    OpenTruth,
    /// Asks for the reference that points are compared with.
    OpenReference,
    /// Asks for a detector model.
    OpenModel,
    /// Asks which products to write.
    Export,
    /// Asks where to write a copy of the log.
    ExportLog,
    /// Asks where to write the visible pings.
    ExportPings,
    /// Opens the folder into which files were last written.
    OpenExported,
    /// Asks how to print a view.
    PrintView,
    /// Closes the window.
    Quit,
    /// Saves the project.
    SaveProject,
    /// Saves the project in another file.
    SaveProjectAs,
    /// Saves the review.
    SaveReview,
    /// Asks for the folder into which reviewed boxes are written.
    ExportBoxes,
    /// Shows or hides the list of changes.
    History,
    /// Shows or hides the list of notices.
    Notices,
    /// Opens the palette.
    Palette,
    /// Shows or hides the manual.
    Manual,
    /// Moves the keyboard to a view.
    Focus(View),
    /// Turns full screen on or off.
    FullScreen,
    /// Shows the focused view alone, or all views.
    Maximise,
    /// Moves the keyboard to the next panel.
    FocusPanels,
    /// Opens a step of the work.
    OpenStep(WorkStep),
    /// Shows or hides the panel of steps.
    StepsPanel,
    /// Shows or hides the panel of details.
    DetailsPanel,
    /// Arranges the views.
    Arrange(LayoutPreset),
    /// Shows everything in the focused view.
    Fit,
    /// Enlarges the focused view.
    ZoomIn,
    /// Reduces the focused view.
    ZoomOut,
    /// Looks down on the 3D view.
    TopView,
    /// Looks at the 3D view from the side.
    SideView,
    /// Draws the waterfall with equal scales along and across, or ends that.
    OneToOne,
    /// Starts or pauses playing along the survey.
    Play,
    /// Plays faster.
    PlayFaster,
    /// Plays more slowly.
    PlaySlower,
    /// Moves the keyboard to the name of the selected box.
    NameBox,
    /// Sets a corner of the measurement.
    SetCorner,
    /// Asks where to write the measurement.
    SaveFigure,
    /// Asks where to write the depth profile.
    SaveProfile,
    /// Copies the depth profile.
    CopyProfile,
    /// Asks where to write the planned lines.
    SavePlan,
}

/// Names and keys of a command.
struct ActionRow {
    action: Action,
    group: ActionGroup,
    label: &'static str,
    hint: &'static str,
    /// The key that menus show, and a second key where other programs use another one for this
    /// command, or where the first differs on many keyboards.
    keys: [Option<Keys>; 2],
    key_scope: Option<KeyScope>,
    repeats: bool,
    is_about_selected_box: bool,
    asks_by_key: bool,
}

impl ActionRow {
    const fn new(
        action: Action,
        group: ActionGroup,
        label: &'static str,
        hint: &'static str,
    ) -> Self {
        Self {
            action,
            group,
            label,
            hint,
            keys: [None; 2],
            key_scope: None,
            repeats: false,
            is_about_selected_box: false,
            asks_by_key: false,
        }
    }

    const fn key(self, key: Keys) -> Self {
        let keys =
            if self.keys[0].is_none() { [Some(key), None] } else { [self.keys[0], Some(key)] };
        Self { keys, ..self }
    }

    const fn acts_in(self, scope: KeyScope) -> Self {
        Self { key_scope: Some(scope), ..self }
    }

    const fn repeats(self) -> Self {
        Self { repeats: true, ..self }
    }

    const fn about_box(self) -> Self {
        Self { is_about_selected_box: true, ..self }
    }

    const fn asks(self) -> Self {
        Self { asks_by_key: true, ..self }
    }
}

macro_rules! define {
    ($(
        $(#[$of_group:meta])*
        $group:ident {$(
            $action:ident, $label:literal, $($with:ident($($arg:tt)*),)* $hint:literal
                => $run:ident($($do:tt)*) $(, when($($when:tt)*))?;
        )*}
    )*) => {
        /// A command without arguments.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Action {
            $($(#[doc = $hint] $action,)*)*
        }

        /// Commands that menus show together.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum ActionGroup {
            $($(#[$of_group])* $group,)*
        }

        /// The rows of the commands, in their order.
        static ROWS: &[ActionRow] = &[$($(
            ActionRow::new(Action::$action, ActionGroup::$group, $label, $hint)
                $(.$with($($arg)*))*,
        )*)*];

        impl Action {
            /// All commands, in the order of the manual.
            pub const ALL: &'static [Action] = &[$($(Action::$action,)*)*];
        }
    };
}

action_rows!(define);

impl ActionGroup {
    /// Returns the commands of the group, in their order.
    pub(crate) fn actions(self) -> impl Iterator<Item = Action> {
        ROWS.iter().filter(move |row| row.group == self).map(|row| row.action)
    }
}

impl Action {
    fn row(self) -> &'static ActionRow {
        &ROWS[self as usize]
    }

    /// Returns the group of the command.
    #[cfg(test)]
    pub(crate) fn group(self) -> ActionGroup {
        self.row().group
    }

    /// Returns the name of the command in menus and the palette.
    pub fn label(self) -> &'static str {
        self.row().label
    }

    /// Returns a sentence that describes the command.
    pub fn hint(self) -> &'static str {
        static OPEN: LazyLock<String> = LazyLock::new(|| {
            let plain = Action::Open.row().hint.trim_end_matches('.');
            format!("{plain}: {}.", formats_to_open())
        });
        match self {
            Action::Open => &OPEN,
            _ => self.row().hint,
        }
    }

    /// Returns the key of the command that menus show; `None` if it has no key.
    pub fn keys(self) -> Option<Keys> {
        self.row().keys[0]
    }

    /// Returns the key of the command for use in texts; empty if it has no key.
    pub fn key(self) -> Keys {
        self.keys().unwrap_or_default()
    }

    /// Returns all keys of the command, beginning with the key that menus show.
    pub fn all_keys(self) -> impl Iterator<Item = Keys> {
        self.row().keys.into_iter().flatten()
    }

    /// Returns the scope of the command's bare key; `None` where it has no such key.
    pub fn key_scope(self) -> Option<KeyScope> {
        self.row().key_scope
    }

    /// Returns true if a held key repeats the command: stepping, undo and redo. All other commands
    /// act once a press; a held A would otherwise accept box after box before the analyst has
    /// looked at them.
    pub(crate) fn repeats(self) -> bool {
        self.row().repeats
    }

    /// Returns true if the bare key of the command only offers it, with a button that carries it
    /// out: the command changes depths or places of the whole log, and a slip of the hand must not.
    pub(crate) fn asks_by_key(self) -> bool {
        self.row().asks_by_key
    }

    /// Returns true if the command decides about the selected box or changes it, so that the box
    /// must be visible.
    pub(crate) fn is_about_selected_box(self) -> bool {
        self.row().is_about_selected_box
    }
}

/// View or panel that has the keyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyFocus {
    /// One of the views of the centre.
    View(View),
    /// A control of the panel in which boxes are reviewed: its buttons, its lists.
    Review,
}

/// Views and panels in which a bare key acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyScope {
    /// Every view.
    Views,
    /// Every view and the review of boxes.
    Boxes,
    /// The waterfall and the review of boxes.
    BoxesInWaterfall,
    /// The waterfall.
    Waterfall,
    /// The waterfall and the map.
    WaterfallAndMap,
    /// The map.
    Map,
    /// The 3D view.
    Cloud,
}

#[cfg(test)]
bathyscope_log::listed! {
    /// All scopes.
    pub KeyScope { Views, Boxes, BoxesInWaterfall, Waterfall, WaterfallAndMap, Map, Cloud }
}

impl KeyScope {
    /// Returns true if a key of this scope acts while `focus` has the keyboard.
    pub fn holds(self, focus: KeyFocus) -> bool {
        use KeyFocus::{Review, View as In};
        use View::{Cloud, Map, Waterfall};
        match self {
            KeyScope::Views => matches!(focus, In(_)),
            KeyScope::Boxes => true,
            KeyScope::BoxesInWaterfall => matches!(focus, In(Waterfall) | Review),
            KeyScope::Waterfall => focus == In(Waterfall),
            KeyScope::WaterfallAndMap => matches!(focus, In(Waterfall | Map)),
            KeyScope::Map => focus == In(Map),
            KeyScope::Cloud => focus == In(Cloud),
        }
    }

    /// Returns the phrase that follows the key in the manual.
    pub fn name(self) -> &'static str {
        match self {
            KeyScope::Views => "in each view",
            KeyScope::Boxes => "in each view and the review",
            KeyScope::BoxesInWaterfall => "in the waterfall and the review",
            KeyScope::Waterfall => "in the waterfall",
            KeyScope::WaterfallAndMap => "in the waterfall and on the map",
            KeyScope::Map => "on the map",
            KeyScope::Cloud => "in the 3D cloud",
        }
    }
}

/// Returns true if a key of the table could be part of a text: no Ctrl, no Alt, no function key.
pub fn is_bare(keys: &str) -> bool {
    let is_function_key = |key: &str| {
        let number = key.strip_prefix('F');
        number.is_some_and(|number| number.parse::<u8>().is_ok())
    };
    let mut names = keys.split('+');
    !names.any(|name| matches!(name, "Ctrl" | "Alt") || is_function_key(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn a_row_is_that_of_its_command() {
        for action in Action::ALL {
            assert_eq!(action.row().action, *action);
        }
    }

    #[test]
    fn no_two_actions_share_a_key() {
        let mut seen = HashMap::new();
        for action in Action::ALL {
            for keys in action.all_keys() {
                let other = seen.insert(keys, action.label());
                assert_eq!(other, None, "{keys} is {} and {other:?}", action.label());
            }
        }
    }

    /// The window receives these keys as events of the clipboard, also with Shift.
    #[test]
    fn no_command_has_a_key_of_the_clipboard() {
        for action in Action::ALL {
            for keys in action.all_keys() {
                let is_taken = keys.contains("Ctrl") && keys.ends_with(['C', 'X', 'V']);
                assert!(!is_taken, "{keys} is {}", action.label());
            }
        }
    }

    #[test]
    fn each_bare_key_has_a_scope_and_no_other_key_has() {
        for action in Action::ALL {
            let has_bare_key = action.all_keys().any(is_bare);
            let label = action.label();
            assert_eq!(action.key_scope().is_some(), has_bare_key, "{label}");
            assert!(has_bare_key || !action.asks_by_key(), "{label}");
        }
    }

    #[test]
    fn keys_that_could_be_typed_are_bare() {
        for keys in ["A", "Shift+A", "[", "+", "=", "Tab", "F", "Shift+F", "1"] {
            assert!(is_bare(keys), "{keys}");
        }
        for keys in ["Ctrl+A", "Ctrl+Shift+A", "F2", "F11", "Shift+F11", "Alt+X"] {
            assert!(!is_bare(keys), "{keys}");
        }
    }

    #[test]
    fn each_scope_holds_somewhere_and_the_narrow_ones_not_everywhere() {
        let views = View::ALL.map(KeyFocus::View);
        let everywhere = [views.as_slice(), &[KeyFocus::Review]].concat();
        for scope in KeyScope::ALL {
            let held = everywhere.iter().filter(|focus| scope.holds(**focus));
            let count = held.count();
            assert!(count > 0, "{scope:?}");
            assert_eq!(count == everywhere.len(), scope == KeyScope::Boxes, "{scope:?}");
        }
    }
}
