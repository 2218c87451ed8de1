//! Points with what they were compared with: one line a point.

use super::log_points::LogColumn;
use super::{ExportError, LogPoints, Summary, write_summed};
use bathyscope_bottom::bathymetry::compare::Match;
use std::io::Write as _;
use std::path::Path;

/// Writes the points that differences are of, log by log: their `measured` is the index in the
/// log's cloud.
pub(crate) fn differences_csv(
    path: &Path,
    logs: &[LogPoints<'_>],
    differences: &[&[Match]],
) -> Result<Summary, ExportError> {
    let column = LogColumn::of(logs);
    write_summed(path, |out, summary| {
        writeln!(
            out,
            "{}source,ping,lon,lat,east_m,north_m,z_m,reference_z_m,difference_m",
            column.header
        )?;
        for (log, differences) in logs.iter().zip(differences) {
            let name = column.field(log);
            for one in *differences {
                let Some(point) = log.cloud.points.get(one.measured) else {
                    continue;
                };
                let track = &log.survey.track;
                let at = (log.navigation).to_lon_lat(track, point.east_m, point.north_m);
                summary.add([at.lon_deg, at.lat_deg], one.difference_m);
                writeln!(
                    out,
                    "{name}{},{},{:.9},{:.9},{:.4},{:.4},{:.4},{:.4},{:.4}",
                    point.source.name(),
                    point.ping,
                    at.lon_deg,
                    at.lat_deg,
                    point.east_m,
                    point.north_m,
                    point.z_m,
                    one.reference_z_m,
                    one.difference_m
                )?;
            }
        }
        Ok(())
    })
}
