//! `bathyscope filter`: radius outlier removal on a point file.

use super::status_line::StatusLine;
use crate::cloud::outliers;
use crate::export::points::{self, split_columns};
use crate::progress::Progress;
use std::path::PathBuf;

/// `bathyscope filter CLOUD -o CLOUD --radius R --min-neighbors N`.
#[derive(Debug, clap::Args)]
pub struct FilterArgs {
    /// The points: xyz, csv, txt, ply, las or laz; FILE.csv:x,y,z names its columns
    cloud: String,
    /// Where the kept points go; the suffix decides the format
    #[arg(short, long, value_name = "CLOUD")]
    output: PathBuf,
    /// Radius of the sphere around a point, in the file's units
    #[arg(long, value_name = "R")]
    radius: f64,
    /// A point is kept when at least this many others lie strictly within the sphere
    #[arg(long, value_name = "N")]
    min_neighbors: usize,
}

/// Filters the file and says how many points are left.
pub fn run(args: FilterArgs) -> Result<(), String> {
    let FilterArgs {
        cloud,
        output,
        radius,
        min_neighbors,
    } = args;
    if !(radius > 0.0 && radius.is_finite()) {
        return Err("the radius must be above 0".to_owned());
    }
    if min_neighbors == 0 {
        return Err("the number of neighbours must be at least 1".to_owned());
    }
    let (path, columns) = split_columns(&cloud);
    let file = points::read(&path, columns.as_ref()).map_err(|error| error.to_string())?;
    let progress = Progress::new();
    let status = StatusLine::new(&progress);
    status.step("outliers");
    let kept = outliers::keep(&file.points, radius, min_neighbors, &progress)
        .map_err(|error| error.to_string())?;
    status.step("writing");
    file.write_kept(&output, &kept)
        .map_err(|error| error.to_string())?;
    drop(status);
    let count = kept.iter().filter(|&&kept| kept).count();
    println!(
        "kept {count} of {} points: {}",
        kept.len(),
        output.display()
    );
    Ok(())
}
