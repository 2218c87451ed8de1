//! `bathyscope process --products tiles`: adds the rows of logs to an archive.

use super::ProcessArgs;
use crate::cli::archive::each_in_parallel;
use crate::cli::status_line::StatusLine;
use crate::cli::survey_logs::{LogInput, all_or};
use crate::cli::{Failure, output};
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{Added, Archive, LogRecord, add};

/// Most logs that are in memory at the same time, one for each worker thread. More would only need
/// more memory, since the work on one log is parallel, too.
const MOST_AT_ONCE: usize = 4;

/// Adds every log to the archive of the folder. A log that cannot be used does not prevent the
/// others from being added.
pub(super) fn run(inputs: &[LogInput], args: &ProcessArgs) -> Result<(), Failure> {
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
