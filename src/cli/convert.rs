//! `bathyscope convert`: writes a log, or a part of it, into a file for other programs.

use super::settings::{LogOpener, SettingsArgs};
use super::status_line::StatusLine;
use super::{Failure, output};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::formats::read_area;
use bathyscope_products::export::{LogPartChoice, TimeBound, check_copy, copy_log};
use std::path::PathBuf;

/// `bathyscope convert LOG -o FILE`.
#[derive(Debug, clap::Args)]
pub(super) struct ConvertArgs {
    /// The log
    log: PathBuf,
    /// File to write; its ending names the format: .sl2, .xtf, .csv, .parquet, .gpx
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Side-scan pings to write, B left out; soundings of a log without side-scan
    #[arg(long, value_name = "A..B")]
    pings: Option<PingRange>,
    /// Times to write, in seconds of the log or as dates with times in UTC: 60..120,
    /// 2024-05-01T10:00:00..2024-05-01T10:30:00
    #[arg(long, value_name = "FROM..TO", value_parser = TimeBound::span)]
    time: Option<[TimeBound; 2]>,
    /// Write what was recorded in this area: GeoJSON, KML or GPX
    #[arg(long, value_name = "FILE")]
    area: Option<PathBuf>,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// Writes the copy; names on stderr the data that the format cannot hold.
pub(super) fn run(args: &ConvertArgs) -> Result<(), Failure> {
    check_copy(&args.output, std::slice::from_ref(&args.log))?;
    let choice = LogPartChoice {
        pings: args.pings,
        time: args.time,
        area: args.area.as_deref().map(read_area).transpose()?,
    };
    let opener = LogOpener::new(args.settings.resolve()?)?;
    let status = StatusLine::at("conversion");
    let survey = opener.open(&args.log, &status.progress)?;
    let positions = opener.settings.position_settings();
    let copied = copy_log(&args.output, &survey, positions, &choice, &status.progress);
    drop(status);
    let copied = copied.map_err(|error| format!("{error}: {}", args.log.display()))?;
    for loss in &copied.losses {
        output::notify(format_args!("note: {loss}"));
    }
    output::notify(copied.summary());
    Ok(())
}
