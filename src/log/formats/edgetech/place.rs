//! The position of a trace, in degrees or in metres of a projection that the file does not name.

use crate::support::geo::LonLat;
use crate::survey::ProjectedTrack;

/// A position as a trace has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinates {
    /// Longitude, or easting.
    pub(super) x: i32,
    /// Latitude, or northing.
    pub(super) y: i32,
    /// 1: millimetres, 2: ten thousandths of minutes of arc, 3: decimetres, 4: centimetres.
    pub(super) units: u16,
}

/// Turns the positions of a file into degrees.
#[derive(Debug, Default)]
pub(super) struct PositionConverter {
    /// First projected position, where positions are in metres.
    pub(super) origin_m: Option<[f64; 2]>,
}

impl PositionConverter {
    /// Degrees; metres lie around longitude 0, latitude 0. `None` for what is not set.
    pub(super) fn position(&mut self, place: Coordinates) -> Option<LonLat> {
        if place.x == 0 || place.y == 0 {
            return None;
        }
        let [x, y] = [place.x, place.y].map(f64::from);
        let per_metre = match place.units {
            1 => 1000.0,
            2 => return Some(LonLat::new(x / 600_000.0, y / 600_000.0)),
            3 => 10.0,
            4 => 100.0,
            _ => return None,
        };
        let [x_m, y_m] = [x, y].map(|value| value / per_metre);
        let [x0_m, y0_m] = *self.origin_m.get_or_insert([x_m, y_m]);
        Some(ProjectedTrack::frame().to_lon_lat(x_m - x0_m, y_m - y0_m))
    }
}
