//! The window on the desktop.

use super::drives::drives;
use super::incremental::IncrementalPainter;
use super::offscreen::DRIVER;
use super::{Shell, adapter};
use crate::app::crash_report;
use crate::app::{App, Command, FileToOpen, Jobs};
use eframe::egui_wgpu::{RenderState, WgpuError};
use std::path::PathBuf;
use std::sync::Arc;

/// Name of the program for the desktop; the folder of its options has the same name.
const APP_ID: &str = "bathyscope";

/// Reason why the window cannot be opened: what is missing, a display or a graphics driver.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WindowError {
    /// No graphics adapter works.
    #[error(
        "the window cannot be opened, for there is no graphics adapter: {DRIVER}; `bathyscope process` works without one: {0}"
    )]
    NoAdapter(WgpuError),
    /// Something else.
    #[error(
        "the window cannot be opened: {0}; `bathyscope process` and `bathyscope snapshot` work without one"
    )]
    Other(eframe::Error),
}

impl From<eframe::Error> for WindowError {
    fn from(error: eframe::Error) -> Self {
        match error {
            eframe::Error::Wgpu(error) => Self::NoAdapter(error),
            error => Self::Other(error),
        }
    }
}

/// Opens the window on the first of `paths`, on the demo survey, or empty, with the `truth` about
/// it; returns when it is closed.
///
/// # Errors
/// When a display or a graphics driver is missing.
pub(crate) fn open_window(
    paths: Vec<PathBuf>,
    demo: bool,
    truth: Option<PathBuf>,
) -> Result<(), WindowError> {
    let mut options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Bathyscope")
            .with_app_id(APP_ID)
            .with_icon(icon())
            .with_inner_size([1600.0, 1000.0])
            .with_min_inner_size([800.0, 500.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        ..eframe::NativeOptions::default()
    };
    options.wgpu_options.wgpu_setup = adapter::setup();
    let start = move |cc: &eframe::CreationContext<'_>| {
        let ctx = cc.egui_ctx.clone();
        // Soft edges multiply the triangles, each of which costs a processor that draws them as
        // much as 16 pixels.
        if let Some(state) = drawn_by_processor(cc) {
            ctx.tessellation_options_mut(|options| options.feathering = false);
            ctx.add_plugin(IncrementalPainter::new(state.clone()));
        }
        let mut shell =
            Shell::new(App::new(Jobs::Threads(Arc::new(move || ctx.request_repaint()))))
                .on_cleared_window();
        if let Some(storage) = cc.storage {
            shell.restore(storage);
        }
        shell.app.look_for_cards(drives);
        let folder = eframe::storage_dir(APP_ID);
        if let Some(report) = folder.and_then(crash_report::keep_in) {
            shell.app.tell_of_crash(&report);
        }
        if demo && paths.is_empty() {
            shell.app.apply(Command::OpenDemo);
        } else {
            shell.app.apply(Command::OpenAll(paths));
        }
        if let Some(truth) = truth {
            shell.app.apply(Command::OpenFile(FileToOpen::Truth(truth)));
        }
        Ok(Box::new(shell) as Box<dyn eframe::App>)
    };
    Ok(eframe::run_native(APP_ID, options, Box::new(start))?)
}

/// Icon of the window where no desktop entry or resource gives one.
fn icon() -> egui::IconData {
    let png = include_bytes!("../../assets/desktop/bathyscope.png");
    eframe::icon_data::from_png_bytes(png).unwrap_or_default()
}

/// The window's device where there is no graphics card.
fn drawn_by_processor<'a>(cc: &'a eframe::CreationContext<'_>) -> Option<&'a RenderState> {
    let state = cc.wgpu_render_state.as_ref();
    state.filter(|state| state.adapter.get_info().device_type == wgpu::DeviceType::Cpu)
}
