//! `bathyscope simulate`: simulates a survey of known truth, as a log and tables; or many surveys,
//! as pictures with labels.

mod dataset;

pub use dataset::known_objects;

use super::status_line::StatusLine;
use super::{Failure, LONGEST_TEXT, output};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::regular_file;
use bathyscope_products::export::{ExportError, write_atomically};
use bathyscope_simulation::{Scene, Simulated, simulate};
use dataset::DatasetArgs;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// `bathyscope simulate [SCENE.toml] -o PREFIX [--seed N]`, `bathyscope simulate --dataset DIR
/// [--images N] [--seed N]`.
#[derive(Debug, clap::Args)]
pub(super) struct SimulateArgs {
    /// The scene; without one, the scene of the bundled demo survey
    scene: Option<PathBuf>,
    /// Written are PREFIX.sl2, PREFIX.truth.csv and PREFIX.objects.csv
    #[arg(short, long, value_name = "PREFIX", required_unless_present = "dataset")]
    output: Option<PathBuf>,
    /// Another seed gives another ground, other objects and other noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    dataset: DatasetArgs,
}

/// Simulates the scene and writes the log and its truth.
pub(super) fn run(args: SimulateArgs) -> Result<(), Failure> {
    let Some(prefix) = &args.output else {
        return dataset::run(&args.dataset, args.seed);
    };
    check_prefix(prefix)?;
    let scene = match &args.scene {
        Some(path) => read_scene(path)?,
        None => Scene::demo(),
    };
    let progress = Progress::new();
    let status = StatusLine::at("simulating", &progress);
    let survey = simulate(&scene, args.seed, &progress)?;
    status.step("writing");
    let written = write(&survey, prefix)?;
    drop(status);
    output::results(format_args!(
        "simulated {} pings and {} objects (seed {}); wrote {written}",
        survey.pings.len(),
        survey.objects.len(),
        args.seed
    ))
}

/// Refuses, before the work begins, a prefix from which the names of the three files cannot be
/// made, or that would replace a log that was not simulated.
fn check_prefix(prefix: &Path) -> Result<(), Failure> {
    if prefix.is_dir() {
        return Err(format!(
            "the output is a folder; add the beginning of the file names to it, for example {}",
            prefix.join("pond").display()
        )
        .into());
    }
    // A log beside its truth was simulated and may be replaced; any other log may be a user's
    // survey.
    let log = with_ending(prefix, "sl2");
    if log.exists() && !with_ending(prefix, "truth.csv").exists() {
        return Err(format!(
            "a log of that name is there and was not simulated (it has no truth beside it); choose another prefix: {}",
            log.display()
        ).into());
    }
    match prefix.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(format!("there is no folder to write into; make it first: {}", folder.display())
                .into())
        }
        _ => Ok(()),
    }
}

fn read_scene(path: &Path) -> Result<Scene, Failure> {
    let text = regular_file::read_text(path, LONGEST_TEXT)
        .map_err(|error| format!("cannot read the scene: {error}: {}", path.display()))?;
    let scene = Scene::from_toml(&text);
    Ok(scene.map_err(|error| format!("cannot use the scene: {error}: {}", path.display()))?)
}

/// Writes the three files of a simulated survey, the log and its tables of truth; returns their
/// names.
fn write(survey: &Simulated, prefix: &Path) -> Result<String, ExportError> {
    let log = written(prefix, "sl2", |out| survey.write_sl2(out))?;
    let truth = written(prefix, "truth.csv", |out| survey.write_truth_csv(out))?;
    let objects = written(prefix, "objects.csv", |out| survey.write_objects_csv(out))?;
    Ok(format!("{log}, {truth}, {objects}"))
}

/// Writes `PREFIX.ending` as a temporary file, renamed when it is complete; returns the path as
/// text.
fn written(
    prefix: &Path,
    ending: &str,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<String, ExportError> {
    let path = with_ending(prefix, ending);
    write_atomically(&path, |file| {
        let mut out = BufWriter::new(file);
        fill(&mut out)?;
        out.flush()
    })?;
    Ok(path.display().to_string())
}

/// Returns `PREFIX.ending`, even if the prefix contains dots.
fn with_ending(prefix: &Path, ending: &str) -> PathBuf {
    let mut name = prefix.as_os_str().to_owned();
    name.push(".");
    name.push(ending);
    PathBuf::from(name)
}
