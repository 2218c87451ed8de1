//! `bathyscope snapshot` in a build without a window: returns an error.

use super::Failure;
use crate::app::LogOrigin;
use std::ffi::OsString;
use std::path::Path;

/// Message of commands that would draw a picture of the window.
pub(crate) const NO_WINDOW: &str = "this build of Bathyscope has no window and draws no pictures of one; build it with the feature gui, or try `bathyscope process SURVEY -o DIR`";

/// `bathyscope snapshot` with any arguments.
#[derive(Debug, clap::Args)]
pub(crate) struct SnapshotArgs {
    /// This build has no window, and draws no pictures of one
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _arguments: Vec<OsString>,
}

/// Returns the error that this build has no window.
pub(crate) fn run(_: SnapshotArgs) -> Result<(), Failure> {
    Err(NO_WINDOW.into())
}

/// Returns the error that this build has no window.
pub(crate) fn draw_into(_: &LogOrigin, _: &Path) -> Result<(Vec<&'static str>, String), Failure> {
    Err(NO_WINDOW.into())
}
