//! Opens the window on the desktop, and lists the cards and drives that are searched for logs
//! there.

use super::incremental::IncrementalPainter;
use super::offscreen::DRIVER;
use super::{Shell, adapter};
use crate::app::crash_report;
use crate::app::{App, Command, FileToOpen, Jobs};
use eframe::egui_wgpu::{RenderState, WgpuError};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name of the program on the desktop; the folder of its options has the same name.
const APP_ID: &str = "bathyscope";
/// Folder of untitled projects in the folder of the program's options.
const UNTITLED: &str = "untitled";
/// Folders where Linux mounts cards, sticks and drives.
const LINUX: [&str; 3] = ["/media", "/run/media", "/mnt"];

/// Reason why the window cannot be opened: what is missing, a display or a graphics driver.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WindowError {
    /// No graphics adapter works.
    #[error(
        "the window cannot be opened, for there is no graphics adapter: {DRIVER}; `bathyscope process` works without one: {0}"
    )]
    NoAdapter(WgpuError),
    /// The window cannot be opened for another reason.
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

/// Opens the window with the logs or the project of `paths`, with the demo survey, or empty, and
/// with the known objects of the file `truth`; returns when the window is closed.
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
        // Soft edges multiply the triangles. A processor that draws without a graphics card needs
        // as much time for a triangle as for 16 pixels.
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
        shell.app.card_search.look_on(drives);
        shell.app.files.untitled_folder = untitled_folder();
        if let Some(report) = eframe::storage_dir(APP_ID).and_then(crash_report::keep_in) {
            shell.app.notices.tell_of_crash(&report);
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

/// Returns the folder of untitled projects; `None` on a system without a folder for options.
pub(crate) fn untitled_folder() -> Option<PathBuf> {
    Some(eframe::storage_dir(APP_ID)?.join(UNTITLED))
}

/// Returns the icon of the window, for systems where no desktop entry or resource gives one.
fn icon() -> egui::IconData {
    let png = include_bytes!("../../assets/desktop/bathyscope.png");
    eframe::icon_data::from_png_bytes(png).unwrap_or_default()
}

/// Returns the window's device if there is no graphics card.
fn drawn_by_processor<'a>(cc: &'a eframe::CreationContext<'_>) -> Option<&'a RenderState> {
    let state = cc.wgpu_render_state.as_ref();
    state.filter(|state| state.adapter.get_info().device_type == wgpu::DeviceType::Cpu)
}

/// Returns the top folders of cards and drives that are not part of the computer. The call takes as
/// long as the slowest of them: a network drive may need seconds.
fn drives() -> Vec<PathBuf> {
    match std::env::consts::OS {
        "windows" => {
            let system = std::env::var("SystemDrive").unwrap_or_default();
            letters(&system, Path::is_dir)
        }
        "macos" => volumes(Path::new("/Volumes")),
        _ => {
            let mounts = fs::read("/proc/self/mounts").unwrap_or_default();
            mounted(&String::from_utf8_lossy(&mounts))
        }
    }
}

/// Returns the drives of Windows, except that of the system and those of floppy disks, which make a
/// noise when they are accessed.
fn letters(system: &str, is_there: impl Fn(&Path) -> bool) -> Vec<PathBuf> {
    let all = ('C'..='Z').map(|letter| format!("{letter}:"));
    let others = all.filter(|drive| !drive.eq_ignore_ascii_case(system));
    let mut drives: Vec<PathBuf> = others.map(|drive| format!("{drive}\\").into()).collect();
    drives.retain(|drive| is_there(drive));
    drives
}

/// Returns the volumes of macOS, except that of the system, which is a link.
fn volumes(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let folders = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    let mut drives: Vec<PathBuf> = folders.map(|entry| entry.path()).collect();
    drives.sort();
    drives
}

/// Returns the mounts of Linux, from lines like `/dev/sdb1 /media/me/NO\040NAME vfat rw 0 0`.
fn mounted(lines: &str) -> Vec<PathBuf> {
    let points = lines.lines().filter_map(|line| line.split(' ').nth(1));
    // The kernel writes these four characters as octal numbers.
    let points = points.map(|point| {
        let point = point.replace(r"\040", " ").replace(r"\011", "\t");
        PathBuf::from(point.replace(r"\012", "\n").replace(r"\134", r"\"))
    });
    let mut drives: Vec<PathBuf> =
        points.filter(|point| LINUX.iter().any(|folder| point.starts_with(folder))).collect();
    drives.sort();
    drives.dedup();
    drives
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_are_mounts_below_the_folders_of_a_desktop() {
        let lines = "/dev/sda1 / ext4 rw 0 0\n/dev/sdb1 /media/me/NO\\040NAME vfat rw 0 0\n\
                     proc /proc proc rw 0 0\n/dev/sdc1 /run/media/me/A\\134B vfat rw 0 0\n\
                     /dev/sdc1 /run/media/me/A\\134B vfat rw 0 0\nbroken\n/dev/sdd1 /mediation x\n";
        let expected = ["/media/me/NO NAME", r"/run/media/me/A\B"];
        assert_eq!(mounted(lines), expected.map(PathBuf::from));
        assert_eq!(mounted(""), Vec::<PathBuf>::new());
    }

    #[test]
    fn drives_of_windows_are_all_letters_but_that_of_the_system() {
        let is_there = |path: &Path| [r"C:\", r"E:\", r"Z:\"].map(Path::new).contains(&path);
        assert_eq!(letters("c:", is_there), [r"E:\", r"Z:\"].map(PathBuf::from));
        assert_eq!(letters("E:", is_there), [r"C:\", r"Z:\"].map(PathBuf::from));
    }

    #[test]
    fn volumes_are_folders_and_no_links() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("GARMIN")).expect("a card");
        fs::write(folder.path().join("note"), "").expect("a file");
        assert_eq!(volumes(folder.path()), [folder.path().join("GARMIN")]);
        assert_eq!(volumes(&folder.path().join("none")), Vec::<PathBuf>::new());
    }
}
