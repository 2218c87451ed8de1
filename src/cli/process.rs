//! `bathyscope process`: the whole pipeline without a window.

mod survey;

use super::folders::Folders;
use super::settings::{Logs, SettingsArgs};
use super::{detect, many, output};
use crate::app::is_project;
use crate::detection::Model;
use crate::outputs::Product;
use crate::progress::Progress;
use crate::project;
use crate::survey::Survey;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// `bathyscope process SURVEY... -o DIR`.
#[derive(Debug, clap::Args)]
pub struct ProcessArgs {
    /// The logs, or folders of logs; several are one survey, with one set of products. Or a project, NAME.bathyscope, with its settings
    #[arg(required = true)]
    surveys: Vec<PathBuf>,
    /// Folder for the products; made when missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Keep several logs apart: write each into a folder of its own, named after the log, in place of one survey of all of them
    #[arg(long)]
    each: bool,
    /// Apply the height offsets that the crossings of several logs show, so that their depths agree; report.json lists them either way
    #[arg(long, conflicts_with = "each")]
    adjust: bool,
    /// Where the boat was, from another receiver, in place of the recorder's track: CSV with time, lon and lat, or GPX;
    /// `track.offset_s` is added to its times; the same as the setting `track.file`
    #[arg(long, value_name = "FILE")]
    track: Option<PathBuf>,
    /// Also hold the survey against points or another log, named as `compare` takes them: comparison.json, comparison.csv
    #[arg(long, value_name = "FILE")]
    reference: Option<OsString>,
    /// Decisions about the boxes of the log, LOG.review.json of the window: report.html shows them
    #[arg(long, value_name = "FILE")]
    review: Option<PathBuf>,
    /// Leave out the search for objects, which takes the longest
    #[arg(long)]
    no_objects: bool,
    /// What to write beside first_returns.csv, cloud.csv and report.json; all when not given
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PRODUCT,...")]
    products: Vec<Product>,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Processes every log. Of several, one that cannot be used does not keep the others from being processed.
pub fn run(args: ProcessArgs) -> Result<(), String> {
    match args.surveys.as_slice() {
        [path] if is_project(path) => return run_project(path, &args),
        paths => {
            if let Some(path) = paths.iter().find(|path| is_project(path)) {
                let path = path.display();
                return Err(format!(
                    "a project is processed by itself; name it alone: {path}"
                ));
            }
        }
    }
    let mut settings = args.settings.resolve()?;
    if args.track.is_some() {
        settings.track.file = args.track;
    }
    // Before the work: a model that cannot be used should not cost minutes first.
    let model = match args.no_objects {
        true => None,
        false => Some(detect::load(settings.detector.model.as_deref())?),
    };
    let logs = Logs::new(settings)?;
    let requested = match args.products.as_slice() {
        [] => &Product::ALL,
        named => named,
    };
    let how = How {
        model: model.as_ref(),
        requested,
        reference: args.reference.as_deref(),
        review: args.review.as_deref(),
    };
    let paths = many::logs(&args.surveys);
    let surveys: Vec<(PathBuf, &Logs)> = paths.into_iter().map(|path| (path, &logs)).collect();
    how.process_all(&surveys, (args.each, args.adjust), &args.output)
}

/// Processes the visible logs of a project, each with the settings that it has there.
fn run_project(path: &Path, args: &ProcessArgs) -> Result<(), String> {
    if args.settings.are_given() || args.track.is_some() {
        return Err(format!(
            "a project brings its settings; change them in it, or name its logs: {}",
            path.display()
        ));
    }
    let inputs = project::inputs(path, &Progress::new())?;
    let logs = inputs.iter().map(|input| Logs::new(input.settings.clone()));
    let logs: Vec<Logs> = logs.collect::<Result<_, String>>()?;
    let Some(first) = logs.first() else {
        return Ok(());
    };
    let model = match args.no_objects {
        true => None,
        false => Some(detect::load(first.settings.detector.model.as_deref())?),
    };
    let requested = match args.products.as_slice() {
        [] => &Product::ALL,
        named => named,
    };
    let how = How {
        model: model.as_ref(),
        requested,
        reference: args.reference.as_deref(),
        review: args.review.as_deref(),
    };
    let paths = inputs.iter().map(|input| input.log.file.path.clone());
    let surveys: Vec<(PathBuf, &Logs)> = paths.zip(&logs).collect();
    how.process_all(&surveys, (args.each, args.adjust), &args.output)
}

/// What is done to every log.
#[derive(Clone, Copy)]
pub struct How<'a> {
    /// What searches for objects, if anything does.
    pub model: Option<&'a Model>,
    /// The products.
    pub requested: &'a [Product],
    /// What it is held against besides.
    pub reference: Option<&'a OsStr>,
    /// Boxes that were decided about, for the report.
    pub review: Option<&'a Path>,
}

impl How<'_> {
    /// Processes logs, each opened by settings of its own: several as one survey, or each for itself.
    fn process_all(
        &self,
        surveys: &[(PathBuf, &Logs)],
        (each_alone, adjust): (bool, bool),
        output: &Path,
    ) -> Result<(), String> {
        match each_alone && surveys.len() > 1 {
            true => each(surveys, self, output),
            false => self.process_one_survey(surveys, adjust, output),
        }
    }

    /// Opens and processes a log by itself into the folder for it.
    fn process(
        &self,
        logs: &Logs,
        path: &Path,
        folder: impl FnOnce(&Survey) -> PathBuf,
    ) -> Result<(), String> {
        let survey = logs.open(path, &Progress::new())?;
        let folder = folder(&survey);
        self.process_into(vec![(Arc::new(survey), &logs.settings)], false, &folder)
    }
}

fn each(surveys: &[(PathBuf, &Logs)], how: &How<'_>, output: &Path) -> Result<(), String> {
    let mut folders = Folders::in_folder(output);
    let mut failed = 0;
    for (path, logs) in surveys {
        if let Err(sentence) = how.process(logs, path, |survey| folders.next(&survey.name())) {
            failed += 1;
            output::notify(format_args!("bathyscope: {sentence}"));
        }
    }
    all_or(failed, surveys.len())
}

/// An error where some of the logs could not be processed.
fn all_or(failed: usize, all: usize) -> Result<(), String> {
    match failed {
        0 => Ok(()),
        _ => Err(format!(
            "{failed} of {all} logs could not be processed, for the reasons above"
        )),
    }
}
