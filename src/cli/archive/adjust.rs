//! `bathyscope adjust`: finds the height offsets of the logs of an archive, and the corrections of
//! their positions.

use crate::cli::status_line::StatusLine;
use crate::cli::{Failure, output};
use bathyscope_bottom::bathymetry::position_offsets::{FoundShift, Wanted};
use bathyscope_bottom::presentation::text;
use bathyscope_products::Error;
use bathyscope_products::archive::{Adjusted, Archive, OffsetRow, adjust};
use serde::Serialize;
use std::path::PathBuf;

/// `bathyscope adjust DIR`.
#[derive(Debug, clap::Args)]
pub(crate) struct AdjustArgs {
    /// Folder of the archive
    archive: PathBuf,
    /// Also find how far the positions of each log are off, where its tracks cross others over a
    /// bottom that slopes
    #[arg(long)]
    positions: bool,
    /// Also find how much later the positions of each log are than its depths, from crossings in
    /// different directions
    #[arg(long)]
    latency: bool,
    /// Print JSON for scripts
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Printed<'a> {
    name: &'a str,
    log: &'a str,
    offset_m: f64,
    standard_error_m: Option<f64>,
    ties: usize,
    group: usize,
    pinned: bool,
    east_m: f64,
    north_m: f64,
    shift_error_m: Option<f64>,
    latency_s: f64,
    latency_error_s: Option<f64>,
    level_factor: f64,
    level_ties: usize,
}

/// Finds the offsets of the archive, writes its table of offsets and prints them.
pub(crate) fn run(args: &AdjustArgs) -> Result<(), Failure> {
    let archive = Archive::open(&args.archive)?;
    let wanted = Wanted { shifts: args.positions, latencies: args.latency };
    let adjusted = adjusted(&archive, wanted)?;
    tell(&adjusted);
    let rows = adjusted.offsets.rows();
    if args.json {
        let known = |value: f64| Some(value).filter(|value| value.is_finite());
        let printed = rows.iter().map(|row| Printed {
            name: &row.name,
            log: &row.log,
            offset_m: row.offset_m,
            standard_error_m: known(row.standard_error_m),
            ties: row.ties,
            group: row.group,
            pinned: row.is_pinned,
            east_m: row.found.shift.east_m,
            north_m: row.found.shift.north_m,
            shift_error_m: known(row.found.shift_error_m),
            latency_s: row.found.shift.latency_s,
            latency_error_s: known(row.found.latency_error_s),
            level_factor: row.level.factor,
            level_ties: row.level.ties,
        });
        return output::json(&printed.collect::<Vec<_>>());
    }
    let mut lines: Vec<String> = rows.into_iter().map(of_log).collect();
    lines.push(summary(&adjusted));
    output::results(lines.join("\n"))
}

/// Finds the offsets of an archive and writes its table.
pub(super) fn adjusted(archive: &Archive, wanted: Wanted) -> Result<Adjusted, Error> {
    let status = StatusLine::at("height offsets");
    adjust(archive, wanted, &status.progress)
}

/// Prints warnings about the differences that no offset explains, and the logs that no tie connects
/// to another log.
pub(super) fn tell(adjusted: &Adjusted) {
    for ([one, other], left_m) in &adjusted.contradictions {
        output::notify(format_args!(
            "warning: no height offset explains how {one} and {other} differ: {left_m:+.2} m are left; another water level on the way, a wrong position, or a bottom that moved"
        ));
    }
    let untied = adjusted.offsets.untied();
    if !untied.is_empty() {
        output::notify(format_args!(
            "warning: nothing ties {} to another log: {}",
            text::plural(untied.len(), "log", "logs"),
            untied.join(", ")
        ));
    }
    if adjusted.groups > 1 {
        output::notify(format_args!(
            "warning: the logs are {} groups that nothing ties to each other, so that heights of one cannot be compared with those of another; offsets.csv numbers them",
            adjusted.groups
        ));
    }
}

/// Returns the numbers of tied, untied and pinned logs as a line of text.
pub(super) fn summary(adjusted: &Adjusted) -> String {
    let rows = adjusted.offsets.rows();
    let pinned = rows.iter().filter(|row| row.is_pinned).count();
    format!(
        "{} tied, {} not, {} pinned; the table is offsets.csv",
        text::plural(rows.len() - adjusted.offsets.untied().len(), "log", "logs"),
        adjusted.offsets.untied().len(),
        pinned
    )
}

fn of_log(row: &OffsetRow) -> String {
    let how = match (row.is_pinned, row.ties) {
        (true, _) => "pinned".to_owned(),
        (false, 0) => "not tied".to_owned(),
        (false, _) if row.standard_error_m.is_nan() => {
            "not determined, for its ties contradict each other".to_owned()
        }
        (false, ties) => format!(
            "standard error {:.4} m, {}, group {}",
            row.standard_error_m,
            text::plural(ties, "tie", "ties"),
            row.group
        ),
    };
    let mut text = format!("{}: {:+.4} m, {how}", row.name, row.offset_m);
    let FoundShift { shift, shift_error_m, latency_error_s } = row.found;
    if !shift_error_m.is_nan() {
        text += &format!(
            "; positions {:+.2} m east, {:+.2} m north, standard error {:.2} m",
            shift.east_m, shift.north_m, shift_error_m
        );
    }
    if !latency_error_s.is_nan() {
        text +=
            &format!("; {:+.2} s late, standard error {:.2} s", shift.latency_s, latency_error_s);
    }
    if row.level.ties > 0 {
        text += &format!("; levels times {:.3}", row.level.factor);
    }
    text
}
