//! The depth profile along a drawn line as a table.

use super::{ExportError, write_bytes};
use bathyscope_bottom::bathymetry::TransectStation;
use bathyscope_log::survey::{Navigation, Survey};
use std::path::Path;

/// Writes one line for each station, `distance_m,lon,lat,east_m,north_m,depth_m`: metres on the
/// ground from the start, WGS84, the survey's local metres as in `cloud.csv`, and the depth, empty
/// where nothing is known.
pub fn profile_csv(
    survey: &Survey,
    navigation: &Navigation,
    stations: &[TransectStation],
) -> String {
    let mut text = "distance_m,lon,lat,east_m,north_m,depth_m\n".to_owned();
    for station in stations {
        let [east_m, north_m] = station.place;
        let at = navigation.to_lon_lat(&survey.track, east_m, north_m);
        let depth = station.depth_m.map_or_else(String::new, |depth_m| format!("{depth_m:.3}"));
        // Writing to a string does not fail.
        text += &format!(
            "{:.3},{:.9},{:.9},{east_m:.4},{north_m:.4},{depth}\n",
            station.distance_m, at.lon_deg, at.lat_deg
        );
    }
    text
}

/// Writes [`profile_csv`] into a file.
pub fn write_profile_csv(path: &Path, text: &str) -> Result<(), ExportError> {
    write_bytes(path, text)
}
