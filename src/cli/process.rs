//! `bathyscope process`: runs the whole pipeline without a window. With `--products tiles` it adds
//! the rows of logs to an archive instead.

use super::archive::each_in_parallel;
use super::detect::proposed_in_words;
use super::folders::{Folders, name_of};
use super::settings::{SettingsArgs, processed};
use super::status_line::StatusLine;
use super::survey_logs::{
    self, LogInput, OpenedLog, all_or, open, open_reference, survey_review, take_reviews,
};
use super::{Failure, output};
use bathyscope_bottom::bathymetry::compare::Matching;
use bathyscope_bottom::bathymetry::height_offsets::Datum;
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{MountingSettings, Survey};
use bathyscope_objects::Model;
use bathyscope_objects::review::Review;
use bathyscope_products::archive::{Added, Archive, LogRecord, add};
use bathyscope_products::outputs::{self, Order, Product};
use bathyscope_products::pipeline::joint::{
    LogPositions, RequestedCorrection, compare_heights, position_offsets,
};
use bathyscope_products::pipeline::{Derived, ProcessedLog, Settings};
use clap::ValueEnum;
use clap::builder::PossibleValue;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// `bathyscope process SURVEY... [-o DIR]`.
#[derive(Debug, clap::Args)]
pub(super) struct ProcessArgs {
    /// The logs, or folders of logs; several are one survey, with one set of products. Or a
    /// project, NAME.bathyscope, with its settings
    #[arg(required = true)]
    surveys: Vec<PathBuf>,
    /// Folder for the products, made when missing; without it one in this folder, named after the
    /// log, the project or what the names of several logs have in common
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Keep several logs apart: write each into a folder of its own, named after the log, in place
    /// of one survey of all of them
    #[arg(long)]
    each: bool,
    /// Apply the height offsets that the crossings of several logs show, so that their depths
    /// agree, and leave out soundings that other logs show to be false; report.json lists both
    /// either way
    #[arg(long, conflicts_with = "each")]
    adjust: bool,
    /// Log whose height stays, by the name of its file (with --adjust); without it the mean of
    /// connected logs stays
    #[arg(long, value_name = "LOG", requires = "adjust")]
    hold: Option<String>,
    /// Move each log, too, by the shift of its positions that crossings over slopes show
    #[arg(long, requires = "adjust")]
    positions: bool,
    /// Correct how late positions are, as crossings over slopes show it, and how late soundings
    /// are, as first returns show it
    #[arg(long)]
    latency: bool,
    /// Positions of the boat from another receiver, in place of the recorder's track: CSV with
    /// time, lon and lat, or GPX; `track.offset_s` is added to its times; the same as the setting
    /// `track.file`
    #[arg(long, value_name = "FILE")]
    track: Option<PathBuf>,
    /// Also compare the survey with points or other logs, named as `compare` takes them:
    /// quality/comparison.json, quality/comparison.csv
    #[arg(long, value_name = "FILE")]
    reference: Option<OsString>,
    /// Decisions about the boxes of a log, LOG.review.json of Bathyscope: report.html shows them.
    /// May be given again, for each of several logs
    #[arg(long, value_name = "FILE")]
    review: Vec<PathBuf>,
    /// Leave out the search for objects, which takes the longest
    #[arg(long)]
    no_objects: bool,
    /// Products to write in addition to points/first_returns.csv, points/cloud.csv, report.json and
    /// manifest.json; all but tiles when not given
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PRODUCT,...")]
    products: Vec<Requested>,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Group of files of a run, or the rows of an archive. These are no files of a run: many logs share
/// the folder of an archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Requested {
    /// Files of a run.
    Files(Product),
    /// Rows of an archive.
    Tiles,
}

/// All groups of files, and the tiles.
const REQUESTED: [Requested; Product::ALL.len() + 1] = {
    let mut all = [Requested::Tiles; Product::ALL.len() + 1];
    let mut index = 0;
    while index < Product::ALL.len() {
        all[index] = Requested::Files(Product::ALL[index]);
        index += 1;
    }
    all
};

impl ValueEnum for Requested {
    fn value_variants<'a>() -> &'a [Self] {
        &REQUESTED
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Self::Files(product) => product.to_possible_value(),
            Self::Tiles => Some(PossibleValue::new("tiles").help(
                "alone, into an archive: points and pings of each log by tile, points/*/*.parquet; pings/*/*.parquet",
            )),
        }
    }
}

/// Processes every log. If there are several, a log that cannot be used does not prevent the
/// processing of the others.
pub(super) fn run(args: ProcessArgs) -> Result<(), Failure> {
    let inputs = survey_logs::inputs(&args.surveys, &args.settings, args.track.clone())?;
    let products = args.products()?;
    if products.is_empty() {
        return add_tiles(&inputs, &args);
    }
    // Loaded before the work, so that a model that cannot be used does not cost minutes first.
    let model = match (inputs.first(), args.no_objects) {
        (Some(first), false) => {
            Some(Model::load_or_shipped(first.logs.settings.detector.model.as_deref())?)
        }
        _ => None,
    };
    let how = How {
        model: model.as_ref(),
        requested: &products,
        reference: args.reference.as_deref(),
        adjust: args.adjust,
        held: args.hold.as_deref(),
        wanted: Wanted { shifts: args.positions, latencies: args.latency },
    };
    if args.each && inputs.len() > 1 {
        return each(&inputs, &how, &args);
    }
    let (mut logs, failed) = open(&inputs)?;
    if !logs.is_empty() {
        take_reviews(&mut logs, &args.review)?;
        how.process_into(&logs, &folder_of_all(&args, &logs)?)?;
    }
    all_or(failed, inputs.len())
}

impl ProcessArgs {
    /// Returns the groups of files that are asked for; empty for tiles.
    fn products(&self) -> Result<Vec<Product>, Failure> {
        let files = self.products.iter().filter_map(|requested| match requested {
            Requested::Files(product) => Some(*product),
            Requested::Tiles => None,
        });
        let files: Vec<Product> = files.collect();
        let tiles = self.products.contains(&Requested::Tiles);
        match (tiles, files.is_empty()) {
            (true, false) => Err(
                "tiles go into the folder of an archive, other products into one of their own; ask for --products tiles alone".into(),
            ),
            (false, true) => Ok(Product::ALL.to_vec()),
            _ => Ok(files),
        }
    }
}

/// Returns the folder for the products of one survey.
fn folder_of_all(args: &ProcessArgs, logs: &[OpenedLog]) -> Result<PathBuf, Failure> {
    match &args.output {
        Some(folder) => Ok(folder.clone()),
        None => {
            let name = name_of(&args.surveys, logs);
            chosen(Folders::in_folder(Path::new("")).next_free(&name, logs))
        }
    }
}

/// Prints the path of a folder that the user did not name, before the work begins, and returns it.
fn chosen(folder: PathBuf) -> Result<PathBuf, Failure> {
    output::results(format_args!("writing into the folder {}", folder.display()))?;
    Ok(folder)
}

/// Processes each log as a survey of its own.
fn each(inputs: &[LogInput], how: &How<'_>, args: &ProcessArgs) -> Result<(), Failure> {
    let mut folders = Folders::in_folder(args.output.as_deref().unwrap_or(Path::new("")));
    let mut failed = 0;
    for input in inputs {
        let processed = input.open().and_then(|log| {
            let mut logs = [log];
            let name = logs[0].survey.name();
            let folder = match &args.output {
                Some(_) => folders.next(&name),
                None => chosen(folders.next_free(&name, &logs))?,
            };
            let is_own = |path: &&PathBuf| Review::open_for(path, &logs[0].survey).is_ok();
            let own: Vec<PathBuf> = args.review.iter().filter(is_own).cloned().collect();
            take_reviews(&mut logs, &own)?;
            how.process_into(&logs, &folder)
        });
        if let Err(Failure { sentence }) = processed {
            failed += 1;
            output::notify(format_args!("bathyscope: {sentence}"));
        }
    }
    all_or(failed, inputs.len())
}

/// Adds every log to the archive of the folder. A log that cannot be used does not prevent the
/// others from being added.
fn add_tiles(inputs: &[LogInput], args: &ProcessArgs) -> Result<(), Failure> {
    let folder = args.output.as_deref().ok_or(
        "tiles go into the folder of an archive, which many runs share; name it with -o DIR",
    )?;
    if args.adjust || args.latency || args.reference.is_some() || !args.review.is_empty() {
        return Err(
            "tiles are written of each log by itself: --adjust, --latency, --reference and --review do not go with them (`bathyscope adjust DIR` finds height offsets)".into(),
        );
    }
    let Some(first) = inputs.first() else {
        return Ok(());
    };
    let archive = Archive::open_for(folder, &first.logs.settings)?;
    let done = each_in_parallel("tiles", inputs, |input| added(&archive, input));
    let mut failed = 0;
    for (input, added) in inputs.iter().zip(done) {
        match added {
            Ok(Added::Twice) => output::notify(format_args!(
                "warning: the log holds the same bytes as another and is taken once: {}",
                input.path.display()
            )),
            Ok(Added::Written(record)) => {
                output::results(format_args!("wrote {}", in_words(&record)))?;
            }
            Ok(Added::UpToDate(record)) => {
                output::results(format_args!("up to date: {}", in_words(&record)))?;
            }
            Err(Failure { sentence }) => {
                failed += 1;
                output::notify(format_args!("bathyscope: {sentence}"));
            }
        }
    }
    all_or(failed, inputs.len())
}

fn added(archive: &Archive, input: &LogInput) -> Result<Added, Failure> {
    // Checked for each log, since each log of a project has its own settings.
    archive.check(&input.logs.settings)?;
    let log = input.open()?;
    let added = add(archive, &log.survey, &log.settings, &Progress::new());
    Ok(added.map_err(|error| format!("{error}: {}", input.path.display()))?)
}

fn in_words(record: &LogRecord) -> String {
    format!(
        "{} and {} in {}: {}",
        text::plural(record.points, "point", "points"),
        text::plural(record.pings, "ping", "pings"),
        text::plural(record.tiles.len(), "tile", "tiles"),
        record.name
    )
}

/// Options for processing the logs of a survey.
#[derive(Clone, Copy)]
pub(crate) struct How<'a> {
    /// Detector that searches for objects; `None` for no search.
    pub model: Option<&'a Model>,
    /// Products to write.
    pub requested: &'a [Product],
    /// Points or logs with which the survey is also compared; `None` for no comparison.
    pub reference: Option<&'a OsStr>,
    /// True if the height offsets of several logs are applied.
    pub adjust: bool,
    /// Name of the log whose height stays when offsets are applied; `None` for the mean of
    /// connected logs.
    pub held: Option<&'a str>,
    /// Further corrections of positions and times.
    pub wanted: Wanted,
}

impl How<'_> {
    /// Runs the pipeline on the logs of a survey, which are in one local coordinate frame, searches
    /// them with the model if one is given, writes their products and prints a short report.
    ///
    /// # Errors
    /// When the reference cannot be used, no log is called as `held`, a file cannot be written, or
    /// the work was cancelled.
    pub(crate) fn process_into(&self, opened: &[OpenedLog], folder: &Path) -> Result<(), Failure> {
        let Some(first) = opened.first() else {
            return Ok(());
        };
        let status = StatusLine::new();
        let datum = datum(self.held, opened)?;
        let open = |argument| open_reference(argument, first, &status.progress);
        let reference = self.reference.map(open).transpose()?.map(Arc::new);
        let surveys = opened.iter().map(|log| &*log.survey);
        let run = outputs::begin(folder, surveys, reference.as_deref())?;
        let mut logs = all_processed(opened, &status)?;
        let mut corrections = Vec::new();
        if let ([log], true) = (logs.as_slice(), self.adjust) {
            corrections = RequestedCorrection::of_one_log(&log.survey.name(), self.wanted);
        }
        if self.wanted.latencies {
            status.step("sounding lag");
            logs = timed(opened, &logs, &mut corrections, &status)?;
        }
        // The shift of the positions of a single log cannot be found.
        let wanted = Wanted { shifts: self.wanted.shifts && logs.len() > 1, ..self.wanted };
        if wanted.is_anything() {
            status.step("positions");
            logs = placed(&logs, wanted, &mut corrections, &status)?;
        }
        if self.adjust && logs.len() > 1 {
            status.step("height offsets");
            logs = adjusted(&logs, datum, &mut corrections, &status)?;
        }
        let review = survey_review(opened);
        let max_gap_m = first.settings.surface.max_gap_m;
        let order = Order {
            logs: &logs,
            derived: &Derived::default(),
            requested: self.requested,
            reference: (reference.as_ref())
                .map(|reference| (reference, Matching::Surface { max_gap_m })),
            search: self.model,
            review: &review,
            corrections: &corrections,
        };
        let written = outputs::write(&order, run, &status.progress, |what| status.step(what))?;
        drop(status);
        for warning in &written.report.warnings {
            output::notify(format_args!("warning: {warning}"));
        }
        output::results(written.report.summary())?;
        if let Some(sentence) = &written.report.depths_between_lines {
            output::results(sentence)?;
        }
        if let (Some(found), Some(model)) = (&written.found, self.model) {
            let objects = proposed_in_words(found, model.names());
            output::results(format_args!("proposed by the detector: {objects}"))?;
        }
        output::results(written.summary(folder))
    }
}

/// Runs the pipeline on every log of a survey with its own settings.
///
/// # Errors
/// When a log was cut or changed after it was opened, or the work was cancelled.
pub(crate) fn all_processed(
    opened: &[OpenedLog],
    status: &StatusLine,
) -> Result<Vec<ProcessedLog>, Failure> {
    let process = |(number, log): (usize, &OpenedLog)| -> Result<ProcessedLog, Failure> {
        let name = match opened.len() {
            1 => String::new(),
            count => format!("log {number} of {count}"),
        };
        status.work_on(&name, log.survey.side_scan.len());
        let log = processed(&log.survey, &log.settings, None, status)?;
        log.survey.check_files()?;
        Ok(log)
    };
    let logs = (1..).zip(opened).map(process).collect();
    let all = opened.iter().map(|log| log.survey.side_scan.len());
    status.work_on("", all.sum());
    logs
}

/// Returns the logs with their soundings corrected for the lag that first returns show; adds the
/// corrections to `corrections`.
fn timed(
    opened: &[OpenedLog],
    logs: &[ProcessedLog],
    corrections: &mut Vec<RequestedCorrection>,
    status: &StatusLine,
) -> Result<Vec<ProcessedLog>, Cancelled> {
    let names = outputs::log_names(logs);
    let with = |((opened, log), name): ((&OpenedLog, &ProcessedLog), &String)| {
        let Some(lag) = log.products.calibration.sounding_lag else {
            return Ok(log.clone());
        };
        corrections.push(RequestedCorrection::of_sounding_lag(name, &lag));
        let mut settings = Settings::clone(&log.products.settings);
        let more = MountingSettings { sounding_lag_s: lag.told_s(), ..MountingSettings::default() };
        settings.mounting.sounding_lag_s += more.sounding_lag_s;
        let survey = Arc::new(Survey::clone(&opened.survey).mounted(&more));
        processed(&survey, &settings, None, status)
    };
    opened.iter().zip(logs).zip(&names).map(with).collect()
}

/// Returns the logs with their positions corrected as crossings show; adds the corrections to
/// `corrections`.
fn placed(
    logs: &[ProcessedLog],
    wanted: Wanted,
    corrections: &mut Vec<RequestedCorrection>,
    status: &StatusLine,
) -> Result<Vec<ProcessedLog>, Cancelled> {
    let found = position_offsets(logs, wanted, &status.progress)?;
    for (index, name) in outputs::log_names(logs).iter().enumerate() {
        let of_log = found.as_ref().and_then(|found| found.get(index));
        corrections.extend(RequestedCorrection::of_positions(name, wanted, of_log));
    }
    let Some(found) = found else {
        return Ok(logs.to_vec());
    };
    let with = |(log, found): (&ProcessedLog, &LogPositions)| {
        let mut settings = Settings::clone(&log.products.settings);
        if let Some(shift) = found.told_shift() {
            settings.position_shift = shift;
        }
        if let Some(latency_s) = found.told_latency_s() {
            settings.mounting.latency_s = latency_s;
        }
        if settings == *log.products.settings {
            Ok(log.clone())
        } else {
            processed(&log.survey, &settings, Some(log), status)
        }
    };
    logs.iter().zip(&found).map(with).collect()
}

/// Returns the datum of the logs' heights: the log named `held`, by the name of its file with or
/// without its ending, or the mean of the logs.
fn datum(held: Option<&str>, opened: &[OpenedLog]) -> Result<Datum, Failure> {
    let Some(held) = held else {
        return Ok(Datum::Mean);
    };
    let names: Vec<String> = opened.iter().map(|log| log.survey.name()).collect();
    let stem = Path::new(held).file_stem().unwrap_or_default().to_string_lossy();
    let place = names.iter().position(|name| name == held || *name == stem);
    place.map(Datum::Log).ok_or_else(|| {
        format!("no log is called {held}; give --hold one of these: {}", names.join(", ")).into()
    })
}

/// Returns the logs with the height offsets that their overlaps show, and without the soundings
/// that other logs show to be false; adds both to `corrections`.
fn adjusted(
    logs: &[ProcessedLog],
    datum: Datum,
    corrections: &mut Vec<RequestedCorrection>,
    status: &StatusLine,
) -> Result<Vec<ProcessedLog>, Cancelled> {
    let mut found = compare_heights(logs, datum, &status.progress)?;
    if let Datum::Log(held) = datum {
        found.offsets.raise(held, logs[held].products.correction.height_offset_m());
    }
    let names = outputs::log_names(logs);
    let mut with = |(index, log): (usize, &ProcessedLog)| {
        let mut settings = Settings::clone(&log.products.settings);
        let offset = &found.offsets.logs[index];
        if offset.log_overlaps == 0 || offset.is_determined() {
            settings.height_offset_m = offset.applied_m();
        }
        for stretch in found.contradicted.iter().filter(|stretch| stretch.log == index) {
            settings.excluded = settings.excluded.excluding(&log.survey, stretch.part());
            corrections.push(RequestedCorrection::of_false_soundings(&names[index], stretch));
        }
        processed(&log.survey, &settings, Some(log), status)
    };
    logs.iter().enumerate().map(&mut with).collect()
}
