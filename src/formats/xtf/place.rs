//! The position of a ping, in degrees or in metres of an unknown projection.

use super::from_log::Provenance;
use super::raw::{FileHeader, PingHeader};
use crate::support::geo::{LonLat, MPS_PER_KNOT};
use crate::survey::{Fix, ProjectedTrack};

/// Navigation units of the file header that are degrees.
pub(super) const DEGREES: u16 = 3;

/// Turns the positions of a file into degrees.
#[derive(Debug)]
pub(super) struct PositionConverter {
    units: Option<u16>,
    /// Whether headings are not of a compass.
    no_compass: bool,
    /// First projected position, where positions are in metres.
    origin: Option<[f64; 2]>,
}

impl PositionConverter {
    /// Of a file with this header; `None` when it is damaged.
    pub(super) fn new(header: Option<&FileHeader>) -> Self {
        Self {
            units: header.map(|header| header.nav_units),
            no_compass: header.is_some_and(|header| Provenance::of(header).has_track_headings),
            origin: None,
        }
    }

    /// Easting and northing of the place that stands at longitude 0, latitude 0, where positions were metres of a system that is not
    /// named.
    pub(super) fn origin_m(&self) -> Option<[f64; 2]> {
        self.origin
    }

    /// The sonar's fix, or the ship's where the sonar has none.
    pub(super) fn fix(&mut self, ping: &PingHeader, time_s: f64) -> Option<Fix> {
        let heading_deg = first_set([ping.sensor_heading_deg, ping.ship_gyro_deg]);
        let heading_deg = heading_deg.filter(|_| !self.no_compass);
        let speed_kn = first_set([ping.sensor_speed_kn, ping.ship_speed_kn]);
        Some(Fix {
            time_s,
            position: self.position(ping)?,
            cog_rad: f32::NAN,
            compass_rad: heading_deg.map_or(f32::NAN, f32::to_radians),
            speed_mps: speed_kn.map_or(f32::NAN, |kn| (f64::from(kn) * MPS_PER_KNOT) as f32),
        })
    }

    fn position(&mut self, ping: &PingHeader) -> Option<LonLat> {
        let sensor = [ping.sensor_x, ping.sensor_y];
        let ship = [ping.ship_x, ping.ship_y];
        let is_set = |[x, y]: &[f64; 2]| x.is_finite() && y.is_finite() && *x != 0.0 && *y != 0.0;
        let [x, y] = [sensor, ship].into_iter().find(is_set)?;
        // Some programs write degrees and say metres.
        let fits_degrees = x.abs() <= 180.0 && y.abs() <= 90.0;
        if self.units == Some(DEGREES) || (self.origin.is_none() && fits_degrees) {
            return Some(LonLat {
                lon_deg: x,
                lat_deg: y,
            });
        }
        let [x0, y0] = *self.origin.get_or_insert([x, y]);
        Some(ProjectedTrack::frame().to_lon_lat(x - x0, y - y0))
    }
}

/// The first value that was recorded: 0 stands for none.
fn first_set(values: [f32; 2]) -> Option<f32> {
    values
        .into_iter()
        .find(|value| value.is_finite() && *value != 0.0)
}
