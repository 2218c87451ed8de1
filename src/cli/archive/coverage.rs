//! `bathyscope coverage`: lists the logs that cover a place.

use crate::cli::status_line::StatusLine;
use crate::cli::{Failure, output};
use bathyscope_bottom::presentation::text;
use bathyscope_log::formats::read_area;
use bathyscope_log::support::calendar;
use bathyscope_log::support::geo::LonLat;
use bathyscope_products::archive::{Archive, CoverageQuery, PingCoverage, coverage_at};
use serde::Serialize;
use std::path::PathBuf;
use std::str::FromStr;

/// `bathyscope coverage DIR LON,LAT[,RADIUS]`.
#[derive(Debug, clap::Args)]
pub(crate) struct CoverageArgs {
    /// Folder of the archive
    archive: PathBuf,
    /// Longitude and latitude, degrees, and how far around them, metres: -111.4801,36.8603
    /// or -111.4801,36.8603,5
    #[arg(
        value_name = "LON,LAT[,RADIUS]",
        allow_hyphen_values = true,
        required_unless_present = "area",
        conflicts_with = "area"
    )]
    place: Option<SearchPlace>,
    /// Polygon instead of a place: GeoJSON, KML or GPX
    #[arg(long, value_name = "FILE")]
    area: Option<PathBuf>,
    /// Print JSON, with every ping
    #[arg(long)]
    json: bool,
}

/// Place and the radius around it.
#[derive(Clone, Copy, Debug)]
struct SearchPlace {
    at: LonLat,
    radius_m: f64,
}

impl FromStr for SearchPlace {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers = text.split(',').map(|part| part.trim().parse::<f64>());
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().unwrap_or_default();
        let ([lon_deg, lat_deg], radius_m) = match numbers.as_slice() {
            [lon, lat] => ([*lon, *lat], 0.0),
            [lon, lat, radius_m] => ([*lon, *lat], *radius_m),
            _ => {
                return Err(
                    "give longitude and latitude in degrees, and a radius in metres: 9.5,47.6,10",
                );
            }
        };
        let at = LonLat { lon_deg, lat_deg };
        if at.is_on_earth() && (0.0..=10_000.0).contains(&radius_m) {
            Ok(Self { at, radius_m })
        } else {
            Err(
                "longitudes go from -180 to 180 degrees, latitudes from -90 to 90, the radius from 0 to 10000 m",
            )
        }
    }
}

/// Prints the logs that cover the place.
pub(crate) fn run(args: &CoverageArgs) -> Result<(), Failure> {
    let archive = Archive::open(&args.archive)?;
    let area = args.area.as_deref().map(read_area).transpose()?;
    let asked = match (&area, args.place) {
        (Some(area), _) => CoverageQuery::Within(&area.rings),
        (None, Some(SearchPlace { at, radius_m })) => CoverageQuery::Around(at, radius_m),
        (None, None) => return Err("give a place or an area".into()),
    };
    let status = StatusLine::at("rows of pings");
    let found = coverage_at(&archive, asked, &status.progress)?;
    drop(status);
    if args.json {
        output::json(&found.iter().map(Printed::new).collect::<Vec<_>>())
    } else {
        output::results(in_words(&found))
    }
}

/// One side of a ping, as printed in JSON.
#[derive(Serialize)]
struct Printed<'a> {
    log: &'a str,
    name: &'a str,
    ping: i32,
    side: &'static str,
    sample: i32,
    last_sample: i32,
    range_m: f64,
    distance_m: f64,
    time: Option<String>,
    time_s: f64,
    excluded: bool,
}

impl<'a> Printed<'a> {
    fn new(coverage: &'a PingCoverage) -> Self {
        Self {
            log: &coverage.log,
            name: &coverage.name,
            ping: coverage.ping,
            side: coverage.side.name(),
            sample: coverage.seen.samples[0],
            last_sample: coverage.seen.samples[1],
            range_m: coverage.seen.range_m,
            distance_m: coverage.seen.distance_m,
            time: coverage.unix_us.map(utc),
            time_s: coverage.time_s,
            excluded: coverage.is_excluded,
        }
    }
}

fn utc(unix_us: i64) -> String {
    calendar::whole_seconds(unix_us as f64 * 1e-6)
}

/// Returns a line for each pass of a log: consecutive pings that cover the place to the same side.
fn in_words(found: &[PingCoverage]) -> String {
    if found.is_empty() {
        return "no ping of this archive covers ground there".to_owned();
    }
    let mut by_side: Vec<&PingCoverage> = found.iter().collect();
    by_side.sort_by_key(|coverage| (&coverage.name, &coverage.log, coverage.side, coverage.ping));
    let same_pass = |a: &&PingCoverage, b: &&PingCoverage| {
        (&a.log, a.side) == (&b.log, b.side) && b.ping - a.ping <= 1
    };
    let mut logs: Vec<&str> = by_side.iter().map(|coverage| coverage.log.as_str()).collect();
    logs.dedup();
    let mut lines: Vec<String> = by_side.chunk_by(same_pass).map(of_pass).collect();
    lines.push(format!(
        "{} of {}",
        text::plural(found.len(), "side of a ping", "sides of pings"),
        text::plural(logs.len(), "log", "logs")
    ));
    lines.join("\n")
}

fn of_pass(pass: &[&PingCoverage]) -> String {
    let (Some(first), Some(last)) = (pass.first(), pass.last()) else {
        return String::new();
    };
    let samples = pass.iter().map(|coverage| coverage.seen.samples);
    let (least, most) = samples
        .fold((i32::MAX, i32::MIN), |(least, most), [from, to]| (least.min(from), most.max(to)));
    let range =
        |from: i32, to: i32| if from == to { from.to_string() } else { format!("{from} to {to}") };
    let time = first.unix_us.map_or_else(|| format!("{:.1} s", first.time_s), utc);
    let excluded = if pass.iter().all(|coverage| coverage.is_excluded) { ", excluded" } else { "" };
    format!(
        "{}: ping {}, {}, sample {}, slant range {:.1} m, {time}{excluded}",
        first.name,
        range(first.ping, last.ping),
        first.side.name(),
        range(least, most),
        first.seen.range_m,
    )
}
