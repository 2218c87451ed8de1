//! Two files of points in one plane.

use crate::cli::Failure;
use bathyscope_log::formats::points::{Elevations, PointPlane};
use bathyscope_log::support::geo::{Crs, LocalFrame, LonLat};

/// Puts both files into one plane: metres that say nothing else of themselves are taken as those of
/// the other file; degrees, and metres of different systems, become metres about the first
/// reference point.
pub(super) fn into_one_plane(
    measured: &mut Elevations,
    reference: &mut Elevations,
) -> Result<(), Failure> {
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

/// `None` for degrees.
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
