//! Assigns to each command without arguments the function that carries it out and the condition
//! under which it has something to act on.

use crate::app::action::action_rows;
use crate::app::heights::FoundHeights;
use crate::app::{
    Action, App, FoundPositions, LayoutPreset, LogOrigin, MapLayer, Orientation, SideColours,
    ThemeChoice, Tool, View, ViewOptions, WindowAction,
};
use bathyscope_bottom::calibration::ScaleMode;
use bathyscope_bottom::presentation::units::{LengthUnit, SpeedUnit};
use bathyscope_log::support::geo::CoordinateFormat;
use bathyscope_objects::review::Edit;
use bathyscope_products::pipeline::Preset;
use bathyscope_products::project::MeasurementKind;

/// Effect of a command.
enum Effect {
    /// A function that changes the state.
    State(fn(&mut App)),
    /// A function that changes the display options.
    Options(fn(&mut ViewOptions)),
    /// A display option that the command turns on or off, with its name.
    Toggle(&'static str, fn(&mut ViewOptions) -> &mut bool),
    /// Something that the window carries out.
    Window(WindowAction),
}

macro_rules! effects {
    ($(
        $(#[$of_group:meta])*
        $group:ident {$(
            $action:ident, $label:literal, $($with:ident($($arg:tt)*),)* $hint:literal
                => $effect:ident($($do:tt)*) $(, when($($when:tt)*))?;
        )*}
    )*) => {
        impl Action {
            fn effect(self) -> Effect {
                match self {
                    $($(Action::$action => Effect::$effect($($do)*),)*)*
                }
            }

            /// Returns the condition under which a command has something to act on; `None` for
            /// commands that notify the analyst themselves of what is missing.
            fn condition(self) -> Option<fn(&App) -> bool> {
                match self {
                    $($($(Action::$action => Some($($when)*),)?)*)*
                    _ => None,
                }
            }
        }
    };
}

action_rows!(effects);

impl Action {
    /// Returns the effect of a command on the window; `None` for a command that changes the state.
    pub(crate) fn in_window(self) -> Option<WindowAction> {
        match self.effect() {
            Effect::Window(action) => Some(action),
            Effect::State(_) | Effect::Options(_) | Effect::Toggle(..) => None,
        }
    }
}

impl Action {
    /// Returns the name of the display option that the command turns on or off, and the option in
    /// `options`; `None` for other commands.
    pub(crate) fn display_option(
        self,
        options: &mut ViewOptions,
    ) -> Option<(&'static str, &mut bool)> {
        match self.effect() {
            Effect::Toggle(name, option) => Some((name, option(options))),
            Effect::State(_) | Effect::Options(_) | Effect::Window(_) => None,
        }
    }
}

impl App {
    fn has_survey(&self) -> bool {
        self.logs.shown.survey.is_some()
    }

    fn can_keep_recorded_range(&self) -> bool {
        self.logs.shown.settings.calibration.mode == ScaleMode::FlatSpot
            || self.logs.shown.proposed_stretch().is_some()
    }

    fn next_cloud_colour(&mut self) {
        let has_several = self.logs.count() > 1;
        self.view.options.cloud.colour = self.view.options.cloud.colour.next(has_several);
    }

    fn fly_to_selected(&mut self) {
        match self.logs.shown.selected_box() {
            Some(id) => self.fly_to(id),
            None => self.ask_for_box(),
        }
    }

    /// Returns `false` if a command would remove or leave something that does not exist.
    pub(crate) fn is_available(&self, action: Action) -> bool {
        action.condition().is_none_or(|condition| condition(self))
    }

    /// Carries out a command; commands of the window have no effect here.
    pub(super) fn act(&mut self, action: Action) {
        match action.effect() {
            Effect::State(change) => change(self),
            Effect::Options(change) => change(&mut self.view.options),
            Effect::Toggle(_, option) => {
                let option = option(&mut self.view.options);
                *option = !*option;
            }
            Effect::Window(_) => {}
        }
    }
}

fn next_bottom_colour(options: &mut ViewOptions) {
    let cloud = &mut options.cloud;
    // A hidden bottom is shown with the colours that it had.
    if std::mem::replace(&mut cloud.bottom, true) {
        cloud.bottom_colour = cloud.bottom_colour.next();
    }
}

fn exchange_side_colours(options: &mut ViewOptions) {
    options.side_colours = match options.side_colours {
        SideColours::Paper => SideColours::Maritime,
        SideColours::Maritime => SideColours::Paper,
    };
}

fn turn_waterfall(options: &mut ViewOptions) {
    options.waterfall.orientation = match options.waterfall.orientation {
        Orientation::Horizontal => Orientation::Vertical,
        Orientation::Vertical => Orientation::Horizontal,
    };
}

fn switch_theme(options: &mut ViewOptions) {
    options.theme = match options.theme {
        ThemeChoice::Dark => ThemeChoice::Light,
        ThemeChoice::Light => ThemeChoice::Dark,
    };
}
