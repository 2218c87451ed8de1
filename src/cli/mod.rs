//! Reads the command line, runs the subcommand that it names and returns the exit code. Each
//! subcommand but `manual` has its own file.
//!
//! In: arguments of the command line. Out: a window, or files and lines of text, and an exit code.
//!
//! Exit codes: 0 success; 1 the input cannot be used (one line on stderr names the fault, the file
//! and what to do); 2 wrong usage.

mod archive;
mod compare;
mod convert;
mod desktop;
mod detect;
mod evaluate;
#[cfg(feature = "gui")]
mod film;
mod filter;
mod folders;
mod info;
mod output;
mod plan;
mod process;
mod review;
mod settings;
mod simulate;
#[cfg(feature = "gui")]
mod snapshot;
#[cfg(feature = "gui")]
mod sonogram;
mod status_line;
mod survey_logs;
#[cfg(feature = "gui")]
mod waterfall_options;

pub use simulate::known_objects;

pub use crate::app::crash_report::write_crash_report;
pub use bathyscope_log::support::catch_panic::is_to_be_printed;

use crate::app::LogOrigin;
use crate::app::manual::{self, Topic};
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_log::formats::formats_to_open;
use bathyscope_log::support::catch_panic::panic_as_error;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::model::shipped;
use bathyscope_products::outputs::Product;
use bathyscope_products::pipeline::Settings;
use bathyscope_products::pipeline::settings::slips;
use clap::error::ErrorKind;
use clap::{Parser, Subcommand};
use folders::Folders;
use process::How;
use std::fmt::Display;
use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use survey_logs::OpenedLog;

/// Environment variable set by the program of the start menu of Windows
/// (`assets/packaging/windows/starter.rs`): the user sees no console.
const NO_CONSOLE: &str = "BATHYSCOPE_NO_CONSOLE";

/// Most bytes of a text file that the user names, such as settings or a scene.
const LONGEST_TEXT: u64 = 1 << 20;

/// Output folder of a run without a display.
const OUTPUT: &str = "bathyscope-out";

/// Depth maps and 3D clouds from the logs of low-cost side-scan fish-finders.
#[derive(Debug, Parser)]
#[command(name = "bathyscope", version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[arg(help = format!("Logs to open in Bathyscope, files or folders: {}", formats_to_open()))]
    surveys: Vec<PathBuf>,

    /// Open the bundled demo survey; without a display, process it into bathyscope-out
    #[arg(long, conflicts_with = "surveys")]
    demo: bool,

    /// Objects known to lie in the survey (a table of objects, or a review), with which boxes are
    /// compared
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,

    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// List what is in a log: channels, pings, spans, ranges, warnings
    Info(info::InfoArgs),
    /// Copy a log, or a part of it, into another format: XTF, SL2, CSV, Parquet, GPX
    Convert(convert::ConvertArgs),
    /// Compare points with a reference: mean, spread, 95 %, share within each S-44 order
    Compare(compare::CompareArgs),
    /// Measure predicted boxes against true ones: precision, recall, average precision, confusion
    Evaluate(evaluate::EvaluateArgs),
    /// Remove outliers from a point file: xyz, csv, ply, las, laz
    Filter(filter::FilterArgs),
    /// Process logs: first returns, calibrated cloud and report
    Process(process::ProcessArgs),
    /// Plan survey lines where they reduce the uncertainty most: GPX, KML, QGroundControl, Mission
    /// Planner
    Plan(plan::PlanArgs),
    /// Bring an archive of many logs up to date: height offsets, maps and mosaics of its tiles,
    /// index
    #[command(alias = "lake")]
    Archive(archive::ArchiveArgs),
    /// List the tiles of an archive, what is in them, and whose map is stale
    Tiles(archive::TilesArgs),
    /// Make the map and the mosaic of tiles of an archive
    Tile(archive::TileArgs),
    /// Find the height offsets between the logs of an archive from where they cross
    Adjust(archive::adjust::AdjustArgs),
    /// List which log, ping, side and sample of an archive cover a place
    #[command(alias = "who")]
    Coverage(archive::coverage::CoverageArgs),
    /// Find objects on the bottom, in logs or pictures, with a YOLO model
    Detect(detect::DetectArgs),
    /// Write what was decided about a log's boxes: places for maps, pictures with labels for
    /// training
    Review(review::ReviewArgs),
    /// Draw the window, or one of its views, into a picture
    Snapshot(snapshot::SnapshotArgs),
    /// Draw the side-scan of a log in pages
    #[cfg(feature = "gui")]
    Sonogram(sonogram::SonogramArgs),
    /// Make a film of a log's side-scan
    #[cfg(feature = "gui")]
    Film(film::FilmArgs),
    /// Make a survey of known truth: log, truth and objects
    Simulate(simulate::SimulateArgs),
    /// Print the manual, or one page of it, as Markdown
    Manual {
        /// The page to print; all pages without it
        topic: Option<Topic>,
    },
    /// Open projects and logs by double click: writes a desktop entry, file types, manual pages and
    /// completions for this user
    Desktop(desktop::DesktopArgs),
}

/// Failure that ends a command. The operator `?` converts errors and sentences to it. It does not
/// implement `Display`, so that no failure is made of another.
#[derive(Debug)]
struct Failure {
    /// Message that is printed.
    sentence: String,
}

impl<E: Display> From<E> for Failure {
    fn from(error: E) -> Self {
        Self { sentence: error.to_string() }
    }
}

/// Returns the definition of all commands and arguments.
fn program() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// Returns the message for a misspelt command: a word that is no command and no file, but close to
/// a command; `None` for other words.
fn misspelt_command(word: &str) -> Option<String> {
    // Largest edit distance for a suggestion, which must also be less than half the length of the
    // command's name.
    const SLIPS: usize = 2;
    if Path::new(word).exists() {
        return None;
    }
    let commands = program();
    let names = commands.get_subcommands().map(clap::Command::get_name);
    let mut old_names = commands.get_subcommands().flat_map(clap::Command::get_all_aliases);
    if old_names.any(|name| name == word) {
        return None;
    }
    let (slips, name) = names.map(|name| (slips(name, word), name)).min()?;
    ((1..=SLIPS).contains(&slips) && 2 * slips < name.len())
        .then(|| format!("there is no command `{word}`; did you mean `{name}`?"))
}

/// Refuses, before any work, a path with none of these endings: a file named by mistake, such as a
/// log, would be replaced. `rule` states the ending.
fn check_ending(path: &Path, endings: &[&str], rule: &str) -> Result<(), Failure> {
    let ending = path.extension().unwrap_or_default();
    if endings.iter().any(|known| ending.eq_ignore_ascii_case(known)) {
        return Ok(());
    }
    Err(format!("{rule}: {}", path.display()).into())
}

/// Runs the program with the process's own arguments.
pub fn main() -> ExitCode {
    let first = std::env::args_os().nth(1);
    let sentence = first.and_then(|word| misspelt_command(word.to_str()?));
    if let Some(sentence) = sentence {
        program().error(ErrorKind::InvalidSubcommand, sentence).exit();
    }
    let cli = Cli::parse();
    let opens_window = cli.command.is_none() && display_available();
    let outcome = if opens_window {
        // The window has its own handling of panics, and goes on when a part of its work fails.
        run(cli)
    } else {
        panic_as_error(|| run(cli)).unwrap_or_else(|fault| {
            Err(format!(
                "a fault in Bathyscope itself stopped the work, and no half file is left: {fault}; please report it, with the file that it was about"
            ).into())
        })
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure { sentence }) => {
            output::notify(format_args!("bathyscope: {sentence}"));
            if opens_window && !is_printed_to_a_person() {
                say_in_a_box(&sentence);
            }
            ExitCode::FAILURE
        }
    }
}

/// Returns true if a person may read the printed text: a program that a desktop starts has no
/// terminal.
fn is_printed_to_a_person() -> bool {
    let has_terminal =
        io::stdin().is_terminal() || io::stdout().is_terminal() || io::stderr().is_terminal();
    if cfg!(windows) { std::env::var_os(NO_CONSOLE).is_none() } else { has_terminal }
}

fn run(cli: Cli) -> Result<(), Failure> {
    let Cli { surveys, demo, truth, command } = cli;
    match command {
        Some(command) => command.run(),
        None => run_default(surveys, demo, truth),
    }
}

impl Command {
    fn run(self) -> Result<(), Failure> {
        match self {
            Self::Info(args) => info::run(args),
            Self::Convert(args) => convert::run(&args),
            Self::Compare(args) => compare::run(args),
            Self::Evaluate(args) => evaluate::run(args),
            Self::Filter(args) => filter::run(args),
            Self::Process(args) => process::run(args),
            Self::Plan(args) => plan::run(args),
            Self::Archive(args) => archive::run_archive(&args),
            Self::Tiles(args) => archive::run_tiles(&args),
            Self::Tile(args) => archive::run_tile(&args),
            Self::Adjust(args) => archive::adjust::run(&args),
            Self::Coverage(args) => archive::coverage::run(&args),
            Self::Detect(args) => detect::run(args),
            Self::Review(args) => review::run(args),
            Self::Snapshot(args) => snapshot::run(args),
            #[cfg(feature = "gui")]
            Self::Sonogram(args) => sonogram::run(args),
            #[cfg(feature = "gui")]
            Self::Film(args) => film::run(args),
            Self::Simulate(args) => simulate::run(args),
            Self::Manual { topic } => {
                output::results(topic.map_or_else(manual::whole, Topic::text).trim_end())
            }
            Self::Desktop(args) => desktop::run(&args),
        }
    }
}

/// Opens the window on the surveys; without a display processes them into [`OUTPUT`] and draws
/// their pictures.
fn run_default(surveys: Vec<PathBuf>, demo: bool, truth: Option<PathBuf>) -> Result<(), Failure> {
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
fn say_in_a_box(sentence: &str) {
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
fn say_in_a_box(_: &str) {}

/// Returns true if a window can be opened here. On systems other than Linux and the BSDs there is
/// always a display.
fn display_available() -> bool {
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

/// `bathyscope snapshot` in a build without a window: returns an error.
#[cfg(not(feature = "gui"))]
mod snapshot {
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
    pub(crate) fn draw_into(
        _: &LogOrigin,
        _: &Path,
    ) -> Result<(Vec<&'static str>, String), Failure> {
        Err(NO_WINDOW.into())
    }
}
