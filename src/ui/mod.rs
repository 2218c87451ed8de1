//! The window: egui only. Reads [`crate::app::App`], pushes [`crate::app::Command`]s, owns nothing but how it looks.
//!
//! It uses all other top folders but `cli` and `simulation`.

mod dialogs;
mod drop_down;
mod exclusion_text;
mod flat;
mod flat_spot_words;
mod incremental;
mod into_texture;
mod list_keys;
pub(crate) mod offscreen;
mod panels;
mod place;
mod raster;
pub(crate) mod render;
mod shell;
pub(crate) mod theme;
mod toggle;
pub(crate) mod views;
mod window;

pub(crate) use shell::{Alone, Shell};
pub(crate) use window::open_window;

use crate::app::{App, Command, View};
use crate::support::presentation::text;

/// What a panel or view gets: the state to read, the list to push commands to.
pub(crate) struct ViewContext<'a> {
    /// The state; read only.
    pub app: &'a App,
    /// The GPU of the window; `None` in a harness without one, where views say so instead of drawing.
    pub render_state: Option<&'a eframe::egui_wgpu::RenderState>,
    /// The view that keys act in.
    pub target: View,
    /// Commands, applied after the frame.
    pub commands: &'a mut Vec<Command>,
}

impl ViewContext<'_> {
    /// Pushes a command.
    pub(crate) fn push(&mut self, command: Command) {
        self.commands.push(command);
    }
}

/// What the shell asks of a view besides drawing itself; menu, keys and palette lead here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ViewRequest {
    /// Show everything.
    Fit,
    /// Enlarge about the centre.
    ZoomIn,
    /// Reduce about the centre.
    ZoomOut,
    /// Make a metre along the track as long as one across, or stretch freely again (waterfall only).
    OneToOne,
    /// Look from above (3D only).
    Top,
    /// Look from the south (3D only).
    Side,
}
