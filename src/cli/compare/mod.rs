//! `bathyscope compare`: prints residual statistics of points, or of a log, against a reference; or
//! how the bottom changed between two depth maps.
//!
//! In: arguments of the command. Out: lines of text, and files of the differences.

mod change;

use super::process::all_processed;
use super::settings::SettingsArgs;
use super::status_line::StatusLine;
use super::survey_logs::{OpenedLog, all_or, inputs, open, open_reference};
use super::{Failure, output};
use bathyscope_bottom::bathymetry::compare::{Comparison, Match, Matching, match_points};
use bathyscope_log::formats::points::{Elevations, PointPlane, split_columns};
use bathyscope_log::formats::{is_named_as_points, multibeam_of, read_points};
use bathyscope_log::support::geo::{Crs, LocalFrame, LonLat};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::export::{ExportError, is_same_file, write_atomically};
use bathyscope_products::outputs::{ComparisonRecord, write_differences};
use bathyscope_products::pipeline::{self, Agreement};
use serde::Serialize;
use std::ffi::{OsStr, OsString};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// `bathyscope compare MEASURED REFERENCE [--json]`.
#[derive(Debug, clap::Args)]
pub(super) struct CompareArgs {
    /// The measured points: xyz, csv, txt, ply, las, laz, the cells of a GeoTIFF or the points of a
    /// GeoJSON; FILE.csv:x,y,z names its columns, a `-` before the third says that it is a depth,
    /// positive down; FILE.xtf:multibeam takes the depths of a multibeam sonar in the file. Or a
    /// log, whose kept points are taken, or a folder of logs or a project, whose logs are taken
    /// together
    measured: OsString,
    /// The reference, named likewise; it may be other columns of the same file, or logs of another
    /// mission over the same water
    reference: OsString,
    /// Source of the reference of a point
    #[arg(long, value_enum, default_value_t = By::Nearest)]
    by: By,
    /// Farthest reference point for `--by nearest`, metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0, value_parser = parse_metres)]
    radius: f64,
    /// Widest gap that the surface spans for `--by surface`, metres to the nearest reference point
    #[arg(long, value_name = "METRES", default_value_t = 20.0, value_parser = parse_metres)]
    max_gap: f64,
    /// Elevation of the water's surface, metres, for the depths that the S-44 orders depend on; of
    /// a measured log it is known
    #[arg(long, value_name = "METRES", default_value_t = 0.0, allow_negative_numbers = true)]
    water_level: f64,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Also write each matched point with its reference and difference into a CSV file
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Options of a comparison of two depth maps
    #[command(flatten)]
    change: change::ChangeArgs,
    /// Settings that logs are processed with
    #[command(flatten)]
    settings: SettingsArgs,
}

impl CompareArgs {
    fn matching(&self) -> Matching {
        match self.by {
            By::Nearest => Matching::Nearest { radius_m: self.radius },
            By::Surface => Matching::Surface { max_gap_m: self.max_gap },
        }
    }
}

/// Source of the reference of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum By {
    /// The nearest reference point within the radius, seen from above
    Nearest,
    /// The triangulated surface of the reference points
    Surface,
}

fn parse_metres(text: &str) -> Result<f64, &'static str> {
    let metres = text.parse().ok();
    metres
        .filter(|metres: &f64| *metres > 0.0 && metres.is_finite())
        .ok_or("a distance is a number above 0")
}

/// Comparison as printed with `--json`.
#[derive(Serialize)]
struct Printed<'a> {
    measured_file: String,
    reference_file: String,
    sign: &'static str,
    by: String,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

const SIGN: &str = "measured minus reference elevation, metres; positive is shallower";

/// Runs the comparison that the arguments ask for and prints its statistics.
pub(super) fn run(args: CompareArgs) -> Result<(), Failure> {
    if let Some(folder) = args.change.folder() {
        return change::run(&args, folder);
    }
    refuse_overwrite_of_inputs(&args)?;
    if is_named_as_points(&args.measured) { points(&args) } else { compare_logs(&args) }
}

/// Refuses to write the output over a file that is compared.
fn refuse_overwrite_of_inputs(args: &CompareArgs) -> Result<(), Failure> {
    let inputs = [&args.measured, &args.reference];
    let output = args.output.as_deref();
    let is_input = |path: &&Path| {
        let file = |input| multibeam_of(input).unwrap_or_else(|| split_columns(input).0);
        let paths = inputs.map(|input| file(input));
        paths.iter().any(|input| is_same_file(input, path))
    };
    match output.filter(is_input) {
        Some(path) => Err(format!(
            "that is one of the files compared; choose another name: {}",
            path.display()
        )
        .into()),
        None => Ok(()),
    }
}

/// Compares a file of points with the reference.
fn points(args: &CompareArgs) -> Result<(), Failure> {
    let mut measured = read(&args.measured)?;
    let mut reference = if is_named_as_points(&args.reference) {
        read(&args.reference)?
    } else {
        elevations(&args.reference, &args.settings)?
    };
    into_one_plane(&mut measured, &mut reference)?;
    let matching = args.matching();
    let by = matching.in_words();
    let status = StatusLine::at("matching");
    let matches = match_points(&measured.points, &reference.points, matching, &status.progress)?;
    drop(status);
    let comparison = Comparison::new(measured.points.len(), &matches, args.water_level);
    if matches.is_empty() {
        return Err(format!(
            "no measured point has a reference ({by}); give a larger distance, or see whether both files count from the same origin: {}",
            measured.path.display()
        ).into());
    }
    if let Some(path) = &args.output {
        write_matches(path, &measured, &matches)?;
    }
    if !args.json {
        return output::results(table(&comparison, &by));
    }
    output::json(&Printed {
        measured_file: measured.path.display().to_string(),
        reference_file: reference.path.display().to_string(),
        sign: SIGN,
        by,
        comparison: &comparison,
    })
}

/// Transforms both files into one plane: metres of an unknown coordinate system are taken as metres
/// of the other file's system; degrees, and metres of different systems, become metres about the
/// first reference point.
fn into_one_plane(measured: &mut Elevations, reference: &mut Elevations) -> Result<(), Failure> {
    match (measured.plane, reference.plane) {
        (PointPlane::Degrees, PointPlane::Metres) | (PointPlane::Metres, PointPlane::Degrees) => {
            return Err(format!(
                "one file is in degrees and the other in metres, so they do not fit onto each other; name columns of one kind: {} and {}",
                measured.path.display(),
                reference.path.display()
            ).into());
        }
        (PointPlane::Metres, _) | (_, PointPlane::Metres) => return Ok(()),
        (PointPlane::Degrees, PointPlane::Degrees) => {}
        (one, other) if one == other => return Ok(()),
        _ => {}
    }
    let systems = [system(measured)?, system(reference)?];
    let first = reference.points.first();
    let Some(frame) = first.map(|&[x, y, _]| LocalFrame::new(position(&systems[1], [x, y]))) else {
        return Ok(());
    };
    for (file, system) in [measured, reference].into_iter().zip(&systems) {
        for point in &mut file.points {
            let [east_m, north_m] = frame.to_enu(position(system, [point[0], point[1]]));
            *point = [east_m, north_m, point[2]];
        }
    }
    Ok(())
}

/// Returns the coordinate system of a file in metres; `None` for degrees and for metres of an
/// unknown system.
fn system(file: &Elevations) -> Result<Option<Crs>, Failure> {
    let epsg = match file.plane {
        PointPlane::Utm(zone) => zone.epsg() as u16,
        PointPlane::Epsg(epsg) => epsg,
        PointPlane::Metres | PointPlane::Degrees => return Ok(None),
    };
    let crs = Crs::from_epsg(epsg).map_err(|error| format!("{error}: {}", file.path.display()))?;
    Ok(Some(crs))
}

fn position(system: &Option<Crs>, [x, y]: [f64; 2]) -> LonLat {
    match system {
        Some(crs) => crs.to_lon_lat([x, y]),
        None => LonLat { lon_deg: x, lat_deg: y },
    }
}

fn read(argument: &OsStr) -> Result<Elevations, Failure> {
    let file = read_points(argument, &Progress::new())?;
    let shown = file.path.display();
    if let Some(note) = &file.note {
        output::notify(format_args!("warning: {note}: {shown}"));
    }
    if file.blank > 0 {
        let count = file.blank;
        output::notify(format_args!(
            "warning: {count} lines or features without a coordinate are left out: {shown}"
        ));
    }
    Ok(file)
}

fn table(comparison: &Comparison, by: &str) -> String {
    let mut lines = vec![
        format!("measured minus reference (up is positive), {by}"),
        format!(
            "matched   {} of {} points, {} without a reference",
            comparison.measured - comparison.unmatched,
            comparison.measured,
            comparison.unmatched
        ),
    ];
    if let Some(found) = &comparison.residuals {
        let signed = [("mean", found.mean_m), ("median", found.median_m)];
        lines.extend(signed.map(|(name, value)| format!("{name:<9} {value:+.4} m")));
        let sizes =
            [("sd", found.sd_m), ("RMS", found.rms_m), ("MAE", found.mae_m), ("95 %", found.p95_m)];
        lines.extend(sizes.map(|(name, value)| format!("{name:<9}  {value:.4} m")));
    }
    lines.extend(comparison.orders.iter().map(|order_share| {
        let order = order_share.order;
        let verdict = if order_share.share >= 0.95 { "" } else { " (95 % required)" };
        format!("S-44 {:<9} {:6.2} % within{verdict}", order.order, 100.0 * order_share.share)
    }));
    lines.join("\n")
}

fn write_matches(path: &Path, measured: &Elevations, matches: &[Match]) -> Result<(), ExportError> {
    write_atomically(path, |file| {
        let mut out = BufWriter::new(file);
        writeln!(out, "x_m,y_m,z_m,reference_z_m,difference_m")?;
        for matched in matches {
            let [x, y, z] = measured.points[matched.measured];
            let Match { reference_z_m, difference_m, .. } = matched;
            writeln!(out, "{x},{y},{z},{reference_z_m},{difference_m}")?;
        }
        out.flush()
    })
}

/// Compares the points from which the depth map of some logs is made, and prints the statistics.
fn compare_logs(args: &CompareArgs) -> Result<(), Failure> {
    let opened = opened(&args.measured, &args.settings)?;
    let Some(first) = opened.first() else {
        return Ok(());
    };
    let status = StatusLine::new();
    let measured = all_processed(&opened, &status)?;
    status.step("comparing");
    let progress = &status.progress;
    let reference = Arc::new(open_reference(&args.reference, first, progress)?);
    let matching = args.matching();
    let agreement = Agreement::with_reference(&measured, &reference, matching, progress)?;
    if let Some(path) = &args.output {
        write_differences(path, &measured, &agreement)?;
    }
    let inputs = reference.inputs(progress)?;
    let record = ComparisonRecord::new(&measured, &agreement, &inputs)?;
    drop(status);
    for note in &reference.notes {
        let path = reference.path().display();
        output::notify(format_args!("warning: {note}: {path}"));
    }
    if args.json {
        output::json(&record)
    } else {
        output::results(table(&agreement.comparison, record.by()))?;
        match record.summary_of_logs() {
            Some(lines) => output::results(lines),
            None => Ok(()),
        }
    }
}

/// Returns the points from which the depth map of some logs is made, as if read from a file of
/// points.
fn elevations(argument: &OsStr, settings: &SettingsArgs) -> Result<Elevations, Failure> {
    let opened = opened(argument, settings)?;
    let logs = all_processed(&opened, &StatusLine::new())?;
    let points = logs.iter().flat_map(|log| pipeline::positions(&log.survey, &log.products));
    Ok(Elevations {
        path: argument.into(),
        points: points.collect(),
        plane: PointPlane::Degrees,
        blank: 0,
        note: None,
    })
}

/// Opens the logs that an argument names, in one local coordinate frame.
fn opened(argument: &OsStr, settings: &SettingsArgs) -> Result<Vec<OpenedLog>, Failure> {
    let inputs = inputs(&[PathBuf::from(argument)], settings, None)?;
    let (opened, failed) = open(&inputs)?;
    all_or(failed, inputs.len())?;
    Ok(opened)
}
