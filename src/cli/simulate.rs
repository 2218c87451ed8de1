//! `bathyscope simulate`: a survey of known truth, as a log and tables; or many, as pictures with
//! labels.

use super::dataset::{self, DatasetArgs};
use super::simulated_files::{with_ending, write};
use super::status_line::StatusLine;
use super::{Failure, LONGEST_TEXT, output};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::regular_file;
use bathyscope_simulation::{Scene, simulate};
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

/// Refuses what the three files could not be named after, before the work begins.
fn check_prefix(prefix: &Path) -> Result<(), Failure> {
    if prefix.is_dir() {
        return Err(format!(
            "the output is a folder; add the beginning of the file names to it, for example {}",
            prefix.join("pond").display()
        )
        .into());
    }
    // A log beside its truth was simulated and may be simulated again; any other may be somebody's
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
