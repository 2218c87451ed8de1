//! `bathyscope [SURVEY...]`: opens the window, or processes the surveys if there is no display.

use super::folders::Folders;
use super::process::How;
use super::survey_logs::OpenedLog;
use super::{Failure, output, snapshot};
use crate::app::LogOrigin;
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::model::shipped;
use bathyscope_products::outputs::Product;
use bathyscope_products::pipeline::Settings;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Output folder of a run without a display.
const OUTPUT: &str = "bathyscope-out";

/// Opens the window on the surveys; without a display processes them into [`OUTPUT`] and draws
/// their pictures.
pub(super) fn run(
    surveys: Vec<PathBuf>,
    demo: bool,
    truth: Option<PathBuf>,
) -> Result<(), Failure> {
    if display_available() {
        return open_window(surveys, demo, truth);
    }
    if truth.is_some() {
        return Err(
            "no display to compare boxes with the truth on; try `bathyscope snapshot SURVEY --objects --truth FILE -o window.png`".into(),
        );
    }
    if surveys.is_empty() && !demo {
        return Err(
            "no display to open Bathyscope on; try `bathyscope --demo`, or `bathyscope process SURVEY -o DIR`".into(),
        );
    }
    output::restart_if_noisy();
    output::results(format_args!(
        "no display: processing into {OUTPUT} instead of opening Bathyscope"
    ))?;
    let mut folders = Folders::in_folder(Path::new(OUTPUT));
    let paths = surveys.into_iter().map(LogOrigin::Path);
    for origin in demo.then_some(LogOrigin::Demo).into_iter().chain(paths) {
        without_display(&origin, &mut folders)?;
    }
    output::results(
        "for the desktop program, run the same command in a desktop session (DISPLAY or WAYLAND_DISPLAY is set)",
    )
}

/// Opens the window on logs, on the demo survey, or empty; returns when the window is closed.
#[cfg(feature = "gui")]
fn open_window(paths: Vec<PathBuf>, demo: bool, truth: Option<PathBuf>) -> Result<(), Failure> {
    Ok(crate::ui::open_window(paths, demo, truth)?)
}

/// Returns the error that this build has no window.
#[cfg(not(feature = "gui"))]
fn open_window(_: Vec<PathBuf>, _: bool, _: Option<PathBuf>) -> Result<(), Failure> {
    Err(snapshot::NO_WINDOW.into())
}

/// Shows in a message box why the window cannot open, for a user who started the program from a
/// desktop and sees no terminal.
#[cfg(feature = "gui")]
pub(super) fn say_in_a_box(sentence: &str) {
    use crate::app::system_words::in_plain_words;
    use bathyscope_log::support::printable::one_line;
    rfd::MessageDialog::new()
        .set_title("Bathyscope")
        .set_level(rfd::MessageLevel::Error)
        .set_description(one_line(&in_plain_words(sentence)))
        .show();
}

/// Does nothing: this build has no message box.
#[cfg(not(feature = "gui"))]
pub(super) fn say_in_a_box(_: &str) {}

/// Returns true if a window can be opened here. On systems other than Linux and the BSDs there is
/// always a display.
pub(super) fn display_available() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || set("WAYLAND_DISPLAY") || set("DISPLAY")
}

fn without_display(origin: &LogOrigin, folders: &mut Folders) -> Result<(), Failure> {
    let survey = origin.open(&Progress::new())?;
    let folder = folders.next(&survey.name());
    let how = How {
        model: Some(&shipped()?),
        requested: &Product::ALL,
        reference: None,
        adjust: false,
        held: None,
        wanted: Wanted::default(),
    };
    let log = OpenedLog { survey: Arc::new(survey), settings: Settings::default(), review: None };
    how.process_into(&[log], &folder)?;
    // The products are complete without pictures, so a machine without any Vulkan driver is no
    // failure.
    match snapshot::draw_into(origin, &folder) {
        Ok((files, adapter)) => {
            output::results(format_args!("drew {} on {adapter}", files.join(", ")))
        }
        Err(Failure { sentence }) => output::results(format_args!("no pictures: {sentence}")),
    }
}
