//! The window: egui only. Reads [`crate::app::App`], pushes [`crate::app::Command`]s, owns nothing
//! but how it looks.

mod adapter;
mod controls;
mod dialogs;
mod drop_down;
mod flat;
mod incremental;
mod list_keys;
pub mod offscreen;
mod panels;
mod place;
mod raster;
pub mod render;
mod shell;
mod stretch_text;
pub(crate) mod theme;
pub mod views;
mod window;

pub use shell::{Alone, Shell};
pub(crate) use window::open_window;

use crate::app::{Action, App, Command, LogPlace, ThemeChoice, View, ViewOptions};
use bathyscope_bottom::presentation::text;
use bathyscope_bottom::presentation::units::Units;
use bathyscope_products::pipeline::Settings;
use egui::{Event, Response, Ui, WidgetText};
use render::Uploader;

/// Input of a panel or view: the state to read and the list to push commands to.
pub struct ViewContext<'a> {
    /// The state; read only.
    pub app: &'a App,
    /// The GPU of the window; `None` in a harness without one, where views say so instead of
    /// drawing.
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

    /// Display options: what is shown, and how.
    pub fn options(&self) -> &'a ViewOptions {
        &self.app.view.options
    }

    /// The units in use.
    pub fn units(&self) -> Units {
        self.app.view.options.units
    }

    /// Light or dark.
    pub fn theme(&self) -> ThemeChoice {
        self.app.view.options.theme
    }

    /// Changes what is shown and how, where that differs from how it is.
    pub fn show(&mut self, options: ViewOptions) {
        if options != self.app.view.options {
            self.push(Command::Show(Box::new(options)));
        }
    }

    /// Changes the settings; undo names it by the label.
    pub fn change(&mut self, label: &'static str, change: impl FnOnce(&mut Settings)) {
        self.change_live(label, false, change);
    }

    /// Changes the settings; what is `live` goes on, and is one step with what follows.
    pub(crate) fn change_live(
        &mut self,
        label: &'static str,
        live: bool,
        change: impl FnOnce(&mut Settings),
    ) {
        let mut settings = Box::new(Settings::clone(&self.app.log.settings));
        change(&mut settings);
        self.push(Command::Change { settings, label, live });
    }

    /// Has a button do an action: what that does is said under the pointer.
    pub(crate) fn button(&mut self, button: Response, action: Action) {
        self.button_with_hint(button, action, action.hint());
    }

    /// The same where the button does not bear the name of the action.
    pub(crate) fn named_button(&mut self, button: Response, action: Action) {
        self.button(button.accessible_name(action.label()), action);
    }

    /// The same, and its key is said too.
    pub(crate) fn keyed_button(&mut self, button: Response, action: Action) {
        self.button_with_hint(button, action, hint_with_key(action));
    }

    /// Has a button do an action, with words of its own under the pointer.
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

/// The hover that a view has told the state: its own is the view's to take back.
#[derive(Default)]
pub(crate) struct OwnHover(bool);

impl OwnHover {
    /// Tells what the pointer is over now.
    pub(crate) fn tell(&mut self, context: &mut ViewContext<'_>, hover: Option<LogPlace>) {
        let ours = hover.is_some() || self.0;
        if ours && context.app.view.hover != hover {
            context.push(Command::Hover(hover));
        }
        self.0 = hover.is_some();
    }
}

/// Takes what was typed in this frame: no field gets it.
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

/// Request of the shell to a view; menu, keys and palette send these.
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
