//! Points with what they were held against: one line a point.

use super::{ExportError, Summary, write_aside};
use crate::bathymetry::compare::Match;
use crate::cloud::PointCloud;
use crate::survey::{Navigation, Survey};
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// Writes the points of a cloud that differences are of, whose `measured` is the index there.
pub fn differences_csv(
    path: &Path,
    survey: &Survey,
    navigation: &Navigation,
    cloud: &PointCloud,
    differences: &[Match],
) -> Result<Summary, ExportError> {
    write_aside(path, |file| {
        let (mut out, mut summary) = (BufWriter::new(file), Summary::default());
        writeln!(
            out,
            "source,ping,lon,lat,east_m,north_m,z_m,reference_z_m,difference_m"
        )?;
        for one in differences {
            let Some(point) = cloud.points.get(one.measured) else {
                continue;
            };
            let at = navigation.to_lon_lat(&survey.track, point.east_m, point.north_m);
            summary.add([at.lon_deg, at.lat_deg], one.difference_m);
            writeln!(
                out,
                "{},{},{:.9},{:.9},{:.4},{:.4},{:.4},{:.4},{:.4}",
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
        out.flush()?;
        Ok(summary)
    })
}
