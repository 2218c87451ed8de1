//! `cloud.ply`: all points in local metres with the paper's colours and their class.

use super::{ExportError, LogPoints, Summary, colour, write_summed};
use std::io::Write as _;
use std::path::Path;

/// Writes all points as binary little-endian PLY: x east, y north, z up, metres from the survey's
/// origin in the plane of the cloud, as doubles; red, green, blue, the level of the echo
/// (`intensity`, 0 for soundings) and the class (`classification`) as bytes; the slant range in
/// metres as a float.
pub(crate) fn cloud_ply(path: &Path, logs: &[LogPoints<'_>]) -> Result<Summary, ExportError> {
    write_summed(path, |out, summary| {
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\ncomment metres east, north and up of the survey's origin\n\
             element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\n\
             property uchar intensity\nproperty uchar classification\nproperty float range_m\nend_header\n",
            logs.iter().map(|log| log.points().count()).sum::<usize>()
        )?;
        for log in logs {
            let reduction = log.reduction();
            for (point, class) in log.points() {
                summary.add([point.east_m, point.north_m], point.z_m);
                for value in [point.east_m, point.north_m, point.z_m] {
                    out.write_all(&value.to_le_bytes())?;
                }
                out.write_all(&colour(point.source))?;
                out.write_all(&[point.level, class.code()])?;
                let range_m = reduction.point_range_m(log.survey, point) as f32;
                out.write_all(&range_m.to_le_bytes())?;
            }
        }
        Ok(())
    })
}
