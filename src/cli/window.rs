//! The window, opened from the command line.

use super::Failure;
use std::path::PathBuf;

/// Opens the window on a log, on the demo survey, or empty; returns when it is closed.
#[cfg(feature = "gui")]
pub(super) fn run(paths: Vec<PathBuf>, demo: bool, truth: Option<PathBuf>) -> Result<(), Failure> {
    Ok(crate::ui::open_window(paths, demo, truth)?)
}

/// Says why there is no window to who has started the program from a desktop, and sees nothing else
/// of it.
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

/// There is no box either.
#[cfg(not(feature = "gui"))]
pub(super) fn say_in_a_box(_: &str) {}

/// Says that there is none.
#[cfg(not(feature = "gui"))]
pub(crate) fn run(_: Vec<PathBuf>, _: bool, _: Option<PathBuf>) -> Result<(), Failure> {
    Err(super::snapshot::NO_WINDOW.into())
}

/// Returns true if a window can be opened here. Elsewhere than on Linux and the BSDs there is
/// always a display.
pub(super) fn display_available() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || set("WAYLAND_DISPLAY") || set("DISPLAY")
}
