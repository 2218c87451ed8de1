//! The tables of pings and points, and the cloud for other programs.

use super::record::{Coordinates, Made};
use crate::cloud::CloudPoint;
use crate::export::{self, ExportError};
use crate::geo::MapPlane;
use crate::pipeline::Products;
use crate::progress::Progress;
use crate::survey::Survey;
use std::path::Path;

/// What no cloud depends on.
const REGARDLESS_OF: [&str; 4] = ["detector", "isobaths", "mosaic", "surface"];

/// Writes `first_returns.csv` and `cloud.csv`, which the report counts.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled.
pub fn write_tables(
    survey: &Survey,
    products: &Products,
    folder: &Path,
    progress: &Progress,
) -> Result<Vec<Made>, String> {
    let Products {
        navigation,
        left_out,
        returns,
        calibration,
        cloud,
        kept,
        ..
    } = products;
    let fail = |error: ExportError| error.to_string();
    progress.check().map_err(|error| error.to_string())?;
    let name = "first_returns.csv";
    let pings = export::first_returns_csv(
        &folder.join(name),
        survey,
        navigation,
        returns,
        calibration,
        left_out,
    )
    .map_err(fail)?;
    let pings = Made {
        name,
        what: "First return on both sides, position and recorded depth of every side-scan ping",
        coordinates: Coordinates::Degrees,
        counted: "pings",
        measured: "depth_m",
        summary: pings,
        regardless_of: &REGARDLESS_OF,
    };
    progress.check().map_err(|error| error.to_string())?;
    let name = "cloud.csv";
    let points =
        export::cloud_csv(&folder.join(name), survey, navigation, cloud, kept).map_err(fail)?;
    let points = Made {
        name,
        what: "All points, those that the outlier filter removed too",
        counted: "points",
        measured: "z_m",
        summary: points,
        ..pings.clone()
    };
    Ok(vec![pings, points])
}

/// Writes the kept points: `cloud.laz` and `cloud.xyz` in the system of the map, `cloud.ply` in the survey's own plane. Nothing where
/// no point was kept.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled.
pub fn write_clouds(
    survey: &Survey,
    products: &Products,
    map: &MapPlane,
    folder: &Path,
    progress: &Progress,
) -> Result<Vec<Made>, String> {
    let (cloud, kept) = (&products.cloud, &products.kept);
    if !kept.contains(&true) {
        return Ok(Vec::new());
    }
    let place = |point: &CloudPoint| {
        let (east_m, north_m) = (point.east_m, point.north_m);
        let navigation = &products.navigation;
        map.crs
            .place(navigation.to_lon_lat(&survey.track, east_m, north_m))
    };
    let fail = |error: ExportError| error.to_string();
    let made = |name, coordinates, summary| Made {
        name,
        what: "The points that the outlier filter kept; z is elevation above the transducer",
        coordinates,
        counted: "points",
        measured: "z_m",
        summary,
        regardless_of: &REGARDLESS_OF,
    };
    let system = || Coordinates::System(map.crs.clone());
    progress.check().map_err(|error| error.to_string())?;
    let (laz, ply, xyz) = ("cloud.laz", "cloud.ply", "cloud.xyz");
    let in_laz = export::cloud_laz(
        &folder.join(laz),
        survey,
        &products.returns,
        &map.crs,
        place,
        cloud,
        kept,
    );
    let in_laz = in_laz.map_err(fail)?;
    progress.check().map_err(|error| error.to_string())?;
    let in_ply = export::cloud_ply(&folder.join(ply), cloud, kept).map_err(fail)?;
    let decimals = if map.crs.is_degrees() { 9 } else { 3 };
    let in_xyz = export::cloud_xyz(&folder.join(xyz), decimals, place, cloud, kept);
    let in_xyz = in_xyz.map_err(fail)?;
    let in_laz = Made {
        what: match survey.start_unix_s {
            Some(_) => {
                "The points that the outlier filter kept; z is elevation above the transducer, intensity the echo level of the first return times 257, time adjusted standard GPS time"
            }
            None => {
                "The points that the outlier filter kept; z is elevation above the transducer, intensity the echo level of the first return times 257, time seconds after the log's beginning"
            }
        },
        ..made(laz, system(), in_laz)
    };
    let origin = Coordinates::Local(survey.track.frame.origin());
    Ok(vec![
        in_laz,
        made(ply, origin, in_ply),
        made(xyz, system(), in_xyz),
    ])
}
