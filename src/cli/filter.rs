//! `bathyscope filter`: removes outliers of a point file by the number of neighbours within a
//! radius.

use super::status_line::StatusLine;
use super::{Failure, output};
use bathyscope_bottom::cloud::outliers;
use bathyscope_log::formats::points::{self, PointFormat, split_columns};
use bathyscope_products::export::kept_points;
use std::ffi::OsString;
use std::path::PathBuf;

/// `bathyscope filter CLOUD -o CLOUD --radius R --min-neighbors N`.
#[derive(Debug, clap::Args)]
pub(super) struct FilterArgs {
    /// The points: xyz, csv, txt, ply, las, laz or copc.laz; FILE.csv:x,y,z names its columns
    cloud: OsString,
    /// File for the kept points; the suffix decides the format
    #[arg(short, long, value_name = "CLOUD")]
    output: PathBuf,
    /// Radius of the sphere around a point, in the file's units
    #[arg(long, value_name = "R", value_parser = parse_radius)]
    radius: f64,
    /// A point is kept when at least this many others lie strictly within the sphere
    #[arg(long, value_name = "N", value_parser = parse_neighbors)]
    min_neighbors: usize,
}

fn parse_radius(text: &str) -> Result<f64, &'static str> {
    let radius = text.parse().ok();
    radius
        .filter(|radius: &f64| *radius > 0.0 && radius.is_finite())
        .ok_or("a radius is a number above 0")
}

fn parse_neighbors(text: &str) -> Result<usize, &'static str> {
    let count = text.parse().ok();
    count
        .filter(|&count| count >= 1)
        .ok_or("the number of neighbours is a whole number, at least 1")
}

/// Filters the file and prints how many points are left.
pub(super) fn run(args: FilterArgs) -> Result<(), Failure> {
    let FilterArgs { cloud, output: destination, radius, min_neighbors } = args;
    let (path, columns) = split_columns(&cloud);
    let format = PointFormat::of(&destination)?;
    let file = points::read(&path, columns.as_ref())?;
    if let Some(note) = &file.note {
        output::notify(format_args!("warning: {note}: {}", path.display()));
    }
    let status = StatusLine::at("outliers");
    let kept = outliers::keep(&file.points, radius, min_neighbors, &status.progress)?;
    status.step("writing");
    kept_points(&destination, format, &file, &kept)?;
    drop(status);
    let count = kept.iter().filter(|&&kept| kept).count();
    output::results(format_args!(
        "kept {count} of {} points: {}",
        kept.len(),
        destination.display()
    ))
}
