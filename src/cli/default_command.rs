//! `bathyscope [SURVEY...]`: the window, or the same work where there is no display.

use super::detect;
use super::folders::Folders;
use super::process::How;
use super::survey_logs::OpenedLog;
use super::{Failure, output, quiet_driver, snapshot, window};
use crate::app::LogOrigin;
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_log::support::progress::Progress;
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
    if window::display_available() {
        return window::run(surveys, demo, truth);
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
    quiet_driver::restart_if_noisy();
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

fn without_display(origin: &LogOrigin, folders: &mut Folders) -> Result<(), Failure> {
    let survey = origin.open(&Progress::new())?;
    let folder = folders.next(&survey.name());
    let how = How {
        model: Some(&detect::load(None)?),
        requested: &Product::ALL,
        reference: None,
        adjust: false,
        held: None,
        wanted: Wanted::default(),
    };
    let log = OpenedLog { survey: Arc::new(survey), settings: Settings::default(), review: None };
    how.process_into(&[log], &folder)?;
    // The products are whole without pictures: a machine without any Vulkan driver has still done
    // the job.
    match snapshot::draw_into(origin, &folder) {
        Ok((files, adapter)) => {
            output::results(format_args!("drew {} on {adapter}", files.join(", ")))
        }
        Err(Failure { sentence }) => output::results(format_args!("no pictures: {sentence}")),
    }
}
