//! `cloud.csv`: one line a point.

use super::{ExportError, Summary, write_aside};
use crate::cloud::PointCloud;
use crate::survey::{Navigation, Survey};
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Writes every point, kept or not, in the cloud's order.
pub fn cloud_csv(
    path: &Path,
    survey: &Survey,
    navigation: &Navigation,
    cloud: &PointCloud,
    kept: &[bool],
) -> Result<Summary, ExportError> {
    write_aside(path, |file| {
        let (mut out, mut summary) = (BufWriter::new(file), Summary::default());
        writeln!(out, "source,ping,lon,lat,east_m,north_m,z_m,kept")?;
        for (point, &kept) in cloud.points.iter().zip(kept) {
            let at = navigation.to_lon_lat(&survey.track, point.east_m, point.north_m);
            summary.add([at.lon_deg, at.lat_deg], point.z_m);
            writeln!(
                out,
                "{},{},{:.9},{:.9},{:.4},{:.4},{:.4},{}",
                point.source.name(),
                point.ping,
                at.lon_deg,
                at.lat_deg,
                point.east_m,
                point.north_m,
                point.z_m,
                u8::from(kept)
            )?;
        }
        out.flush()?;
        Ok(summary)
    })
}
