//! `cloud.ply`: kept points in local metres with the paper's colours.

use super::{ExportError, LogPoints, Summary, colour, write_aside};
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Writes the kept points as binary little-endian PLY: x east, y north, z up, metres from the survey's origin in the
/// plane of the cloud, as doubles; red, green, blue as bytes.
///
/// # Errors
/// When the file cannot be written.
pub fn cloud_ply(path: &Path, logs: &[LogPoints<'_>]) -> Result<Summary, ExportError> {
    write_aside(path, |file| {
        let (mut out, mut summary) = (BufWriter::new(file), Summary::default());
        let points = logs.iter().flat_map(LogPoints::kept_points);
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\ncomment metres east, north and up of the survey's origin\n\
             element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
            points.clone().count()
        )?;
        for point in points {
            summary.add([point.east_m, point.north_m], point.z_m);
            for value in [point.east_m, point.north_m, point.z_m] {
                out.write_all(&value.to_le_bytes())?;
            }
            out.write_all(&colour(point.source))?;
        }
        out.flush()?;
        Ok(summary)
    })
}
