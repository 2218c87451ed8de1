//! `bathyscope process`: runs the whole pipeline without a window. With `--products tiles` it adds
//! the rows of logs to an archive instead.

mod survey;

pub(crate) use survey::{How, all_processed};

use super::archive::each_in_parallel;
use super::folders::{Folders, name_of};
use super::settings::SettingsArgs;
use super::status_line::StatusLine;
use super::survey_logs::{self, LogInput, OpenedLog, all_or, is_of, open, take_reviews};
use super::{Failure, detect, output};
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{Added, Archive, LogRecord, add};
use bathyscope_products::outputs::Product;
use clap::ValueEnum;
use clap::builder::PossibleValue;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

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
        (Some(first), false) => Some(detect::load(first.logs.settings.detector.model.as_deref())?),
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
            let own = args.review.iter().filter(|path| is_of(path, &logs[0]));
            let own: Vec<PathBuf> = own.cloned().collect();
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

/// Most logs that are in memory at the same time, one for each worker thread. More would only need
/// more memory, since the work on one log is parallel, too.
const MOST_AT_ONCE: usize = 4;

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
    let progress = Progress::new();
    let status = StatusLine::at("tiles", &progress);
    progress.start(inputs.len() as u64);
    let done = each_in_parallel(inputs, MOST_AT_ONCE, |input| {
        let added = added(&archive, input);
        progress.advance(1);
        added
    });
    drop(status);
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
