//! `.waypoints` of Mission Planner: the text format `QGC WPL 110`.

use super::PlannedWay;
use super::qgroundcontrol::{NAV_WAYPOINT, RELATIVE_HEIGHT};
use bathyscope_log::support::geo::LonLat;

/// `MAV_FRAME_GLOBAL`, of the home position.
const ABSOLUTE_HEIGHT: u8 = 0;

/// A row a place: number, whether it is the current one, frame, command, four parameters, latitude,
/// longitude, height, whether to go on by itself. Row 0 is home.
pub(super) fn text(way: &PlannedWay<'_>) -> String {
    let mut text = "QGC WPL 110\n".to_owned() + &row(0, ABSOLUTE_HEIGHT, way.home);
    for (number, place) in (1..).zip(way.places()) {
        text += &row(number, RELATIVE_HEIGHT, place.at);
    }
    text
}

fn row(number: u32, frame: u8, at: LonLat) -> String {
    let current = u8::from(number == 0);
    let (lat, lon) = (at.lat_deg, at.lon_deg);
    let parameters = "0\t0\t0\t0";
    format!(
        "{number}\t{current}\t{frame}\t{NAV_WAYPOINT}\t{parameters}\t{lat:.8}\t{lon:.8}\t0.000000\t1\n"
    )
}
