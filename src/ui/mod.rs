//! Draws the window, with egui only: reads [`crate::app::App`], pushes [`crate::app::Command`]s,
//! and keeps no state except that of its own look.

mod adapter;
mod controls;
mod dialogs;
mod flat;
mod incremental;
pub mod offscreen;
mod panels;
mod place;
pub mod render;
mod shell;
pub(crate) mod theme;
pub mod views;
mod window;

pub use shell::Shell;
pub(crate) use window::{open_window, untitled_folder};

use crate::app::{Action, App, Command, LogPlace, ThemeChoice, View, ViewOptions};
use bathyscope_bottom::presentation::text;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_products::pipeline::Settings;
use bathyscope_products::pipeline::settings::{ControlValue, SettingRow};
use egui::{Event, Response, Ui, WidgetText};
use render::Uploader;

/// Input of a panel or view: the state to read and the list to push commands to.
pub struct ViewContext<'a> {
    /// The state; read only.
    pub app: &'a App,
    /// The GPU of the window; `None` in a harness without one, where views show a notice instead of
    /// a drawing.
    pub render_state: Option<&'a eframe::egui_wgpu::RenderState>,
    /// The view that keys act in.
    pub target: View,
    /// Commands, applied after the frame.
    pub commands: &'a mut Vec<Command>,
}

impl<'a> ViewContext<'a> {
    /// Pushes a command.
    pub fn push(&mut self, command: Command) {
        self.commands.push(command);
    }

    /// Returns the uploader that fills buffers of the window's GPU; `None` without a GPU.
    pub(crate) fn uploader(&self) -> Option<Uploader> {
        let state = self.render_state?;
        Some(Uploader::new(&state.device, &state.queue))
    }

    /// Returns the display options: what is shown, and how.
    pub fn options(&self) -> &'a ViewOptions {
        &self.app.view.options
    }

    /// Returns the units in use.
    pub fn units(&self) -> Units {
        self.app.view.options.units
    }

    /// Returns the theme, light or dark.
    pub fn theme(&self) -> ThemeChoice {
        self.app.view.options.theme
    }

    /// Changes the display options, if `options` differ from the current ones.
    pub fn show(&mut self, options: ViewOptions) {
        if options != self.app.view.options {
            self.push(Command::Show(Box::new(options)));
        }
    }

    /// Changes several settings at once; undo shows the label as the name of the change.
    pub fn change(&mut self, label: &'static str, change: impl FnOnce(&mut Settings)) {
        self.change_live(label, false, change);
    }

    /// Changes several settings at once. A `live` change is still going on, and is one undo step
    /// with the changes that follow.
    pub(crate) fn change_live(
        &mut self,
        label: &'static str,
        live: bool,
        change: impl FnOnce(&mut Settings),
    ) {
        let mut settings = Box::new(Settings::clone(&self.app.logs.shown.settings));
        change(&mut settings);
        self.push(Command::Change { settings, label, live });
    }

    /// Gives a setting the value of its control. A `live` change is still going on, and is one undo
    /// step with the changes that follow.
    pub(crate) fn set(&mut self, row: &'static SettingRow, value: ControlValue, live: bool) {
        self.push(Command::Set { key: row.key, value, live });
    }

    /// Makes a button do an action; the hint of the action is shown under the pointer.
    pub(crate) fn button(&mut self, button: Response, action: Action) {
        self.button_with_hint(button, action, action.hint());
    }

    /// Makes a button do an action and gives the button the action's name for accessibility,
    /// because it does not show that name.
    pub(crate) fn named_button(&mut self, button: Response, action: Action) {
        self.button(button.accessible_name(action.label()), action);
    }

    /// Makes a button do an action; the hint under the pointer also contains the action's key.
    pub(crate) fn keyed_button(&mut self, button: Response, action: Action) {
        self.button_with_hint(button, action, hint_with_key(action));
    }

    /// Makes a button do an action, with this hint under the pointer.
    pub(crate) fn button_with_hint(
        &mut self,
        button: Response,
        action: Action,
        hint: impl Into<WidgetText>,
    ) {
        if button.on_hover_text(hint).clicked() {
            self.push(Command::Do(action));
        }
    }
}

/// True if the view has set the hovered place of the state: it then has to clear that place, too.
#[derive(Default)]
pub(crate) struct OwnHover(bool);

impl OwnHover {
    /// Sets the place under the pointer in the state, or clears a place that this view has set.
    pub(crate) fn tell(&mut self, context: &mut ViewContext<'_>, hover: Option<LogPlace>) {
        let ours = hover.is_some() || self.0;
        if ours && context.app.view.hover != hover {
            context.push(Command::Hover(hover));
        }
        self.0 = hover.is_some();
    }
}

/// Removes the text typed in this frame from the input, so that no field gets it, and returns the
/// text.
pub(crate) fn take_typed(ui: &Ui) -> String {
    let mut typed = String::new();
    ui.input_mut(|input| {
        input.events.retain(|event| match event {
            Event::Text(text) => {
                typed += text;
                false
            }
            _ => true,
        });
    });
    typed
}

/// Returns the hint of an action, with its key.
pub(crate) fn hint_with_key(action: Action) -> String {
    match action.keys() {
        Some(keys) => format!("{} ({keys})", action.hint()),
        None => action.hint().to_owned(),
    }
}

/// Request to a view, sent by menu, keys and palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewRequest {
    /// Show everything.
    Fit,
    /// Enlarge about the centre.
    ZoomIn,
    /// Reduce about the centre.
    ZoomOut,
    /// Make a metre along the track as long as one across, or stretch freely again (waterfall
    /// only).
    OneToOne,
    /// Look from above (3D only).
    Top,
    /// Look from the south (3D only).
    Side,
}
