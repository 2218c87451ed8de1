//! `cloud.csv`: one line a point.

use super::fixed::Fixed;
use super::log_points::LogColumn;
use super::{ExportError, LogPoints, Summary, write_summed};
use bathyscope_log::survey::SoundingFault;
use std::io::Write as _;
use std::path::Path;

/// Writes every point with its class, log by log in the cloud's order; of several logs with the
/// column `log` before the others. `kept` is 1 where the class is that of the bottom. The level of
/// the echo is that of first returns, 0 to 255; the slant range of a sounding is its distance
/// straight below, that of a swath point the distance straight to it. The fault is that of a
/// sounding that does not count.
pub(crate) fn cloud_csv(path: &Path, logs: &[LogPoints<'_>]) -> Result<Summary, ExportError> {
    let column = LogColumn::of(logs);
    write_summed(path, |out, summary| {
        let header = column.header;
        writeln!(
            out,
            "{header}source,ping,lon,lat,east_m,north_m,z_m,kept,class,level,range_m,fault"
        )?;
        for log in logs {
            let (name, reduction) = (column.field(log), log.reduction());
            for (point, class) in log.points() {
                let (east_m, north_m) = (point.east_m, point.north_m);
                let at = log.navigation.to_lon_lat(&log.survey.track, east_m, north_m);
                summary.add([at.lon_deg, at.lat_deg], point.z_m);
                let range_m = reduction.point_range_m(log.survey, point);
                let level = if point.source.is_side_scan() {
                    point.level.to_string()
                } else {
                    String::new()
                };
                writeln!(
                    out,
                    "{name}{},{},{},{},{},{},{},{},{},{level},{},{}",
                    point.source.name(),
                    point.ping,
                    Fixed(at.lon_deg, 9),
                    Fixed(at.lat_deg, 9),
                    Fixed(east_m, 4),
                    Fixed(north_m, 4),
                    Fixed(point.z_m, 4),
                    u8::from(class.is_kept()),
                    class.code(),
                    Fixed(range_m, 3),
                    point.fault.map_or("", SoundingFault::name)
                )?;
            }
        }
        Ok(())
    })
}
