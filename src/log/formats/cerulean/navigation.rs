//! Reads positions of NMEA and MAVLink packets and gives them the times of the profiles around
//! them.

use crate::formats::nmea;
use crate::support::geo::LonLat;
use crate::support::statistics::upper_median;
use crate::survey::Fix;
use serde::Deserialize;

/// Packet ids of NMEA sentences and MAVLink messages.
const NMEA: u16 = 109;
const MAVLINK: u16 = 150;
/// Largest difference between a position's own clock and the profile after it, seconds; where it is
/// larger, the time of the profile is used.
const MOST_APART_S: f64 = 5.0;
/// MAVLink message with a position, and its value for an unknown heading.
const POSITION_MESSAGE: &str = "GLOBAL_POSITION_INT";
const NO_HEADING: u16 = u16::MAX;

/// A position whose time on the sonar's clock is not known yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReceivedPosition {
    /// Time on the position's own clock, seconds, and which clock that is; `None` without a time.
    own_s: Option<(Clock, f64)>,
    fix: Fix,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Clock {
    Receiver,
    Autopilot,
}

/// Wrapper of a MAVLink message, as mavlink2rest writes it.
#[derive(Deserialize)]
struct Wrapped {
    message: GlobalPosition,
}

/// MAVLink's `GLOBAL_POSITION_INT`.
#[derive(Deserialize)]
struct GlobalPosition {
    #[serde(rename = "type")]
    name: String,
    time_boot_ms: Option<f64>,
    /// Latitude and longitude, ten millionths of degrees.
    lat: f64,
    lon: f64,
    /// Speed to the north and to the east, centimetres a second.
    vx: Option<f32>,
    vy: Option<f32>,
    /// Heading, hundredths of degrees.
    hdg: Option<u16>,
}

/// Collects positions, with the last course, speed and heading of sentences without a position.
#[derive(Debug)]
pub(super) struct Navigation {
    cog_rad: f32,
    speed_mps: f32,
    heading_rad: f32,
    /// Positions, each with the time of the profile that follows, seconds after the log's time
    /// zero.
    placed: Vec<(f64, ReceivedPosition)>,
}

impl Default for Navigation {
    fn default() -> Self {
        Self { cog_rad: f32::NAN, speed_mps: f32::NAN, heading_rad: f32::NAN, placed: Vec::new() }
    }
}

impl Navigation {
    /// Reads a packet; returns its position, or `None` if it has none.
    pub(super) fn take(&mut self, id: u16, payload: &[u8]) -> Option<ReceivedPosition> {
        match id {
            NMEA => self.take_sentence(nmea::sentence(payload)?),
            MAVLINK => take_message(payload),
            _ => None,
        }
    }

    fn take_sentence(&mut self, sentence: nmea::Sentence) -> Option<ReceivedPosition> {
        let keep = |kept: &mut f32, value: f32| {
            if !value.is_nan() {
                *kept = value;
            }
        };
        keep(&mut self.cog_rad, sentence.cog_rad);
        keep(&mut self.speed_mps, sentence.speed_mps);
        keep(&mut self.heading_rad, sentence.heading_rad);
        Some(ReceivedPosition {
            own_s: sentence.utc_s.map(|utc_s| (Clock::Receiver, utc_s)),
            fix: Fix {
                time_s: f64::NAN,
                position: sentence.position?,
                cog_rad: self.cog_rad,
                compass_rad: self.heading_rad,
                speed_mps: self.speed_mps,
            },
        })
    }

    /// Stores a position with the time of the profile that follows, seconds; the vehicle's heading
    /// in that profile, degrees (0 is unknown), is used where the position has none.
    pub(super) fn place(&mut self, mut position: ReceivedPosition, time_s: f64, vehicle_deg: f32) {
        if position.fix.compass_rad.is_nan() && vehicle_deg != 0.0 && vehicle_deg.abs() <= 360.0 {
            position.fix.compass_rad = vehicle_deg.to_radians();
        }
        self.placed.push((time_s, position));
    }

    /// Returns the fixes. Packets are delayed by tenths of seconds, so that the clocks of receiver
    /// and autopilot give better times: their constant difference from the sonar's clock is
    /// estimated by the median.
    pub(super) fn fixes(self) -> Vec<Fix> {
        let later_s = |clock: Clock| {
            let own = self.placed.iter().filter_map(|(time_s, position)| {
                let (its, own_s) = position.own_s?;
                (its == clock).then_some(time_s - own_s)
            });
            upper_median(&mut own.collect::<Vec<f64>>(), f64::total_cmp)
        };
        let later_s = [Clock::Receiver, Clock::Autopilot].map(later_s);
        let each = self.placed.iter().map(|(beside_s, position)| {
            let own_s = position.own_s;
            let own_s = own_s.and_then(|(clock, own_s)| Some(own_s + later_s[clock as usize]?));
            let is_near = |own_s: &f64| (own_s - beside_s).abs() <= MOST_APART_S;
            Fix { time_s: own_s.filter(is_near).unwrap_or(*beside_s), ..position.fix }
        });
        each.collect()
    }
}

fn take_message(payload: &[u8]) -> Option<ReceivedPosition> {
    // Most messages are of other types and are not parsed.
    let name = POSITION_MESSAGE.as_bytes();
    payload.windows(name.len()).find(|part| *part == name)?;
    let Wrapped { message } = serde_json::from_slice(payload).ok()?;
    let [lat_deg, lon_deg] = [message.lat, message.lon].map(|value| value / 1e7);
    // An autopilot sends 0, 0 before it has a fix.
    let is_fix = message.name == POSITION_MESSAGE && lat_deg != 0.0 && lon_deg != 0.0;
    let [north, east] =
        [message.vx, message.vy].map(|speed| speed.map_or(f32::NAN, |cm| cm / 100.0));
    let heading = message.hdg.filter(|heading| *heading != NO_HEADING);
    let speed_mps = north.hypot(east);
    is_fix.then(|| ReceivedPosition {
        own_s: message.time_boot_ms.map(|boot_ms| (Clock::Autopilot, boot_ms / 1000.0)),
        fix: Fix {
            time_s: f64::NAN,
            position: LonLat { lon_deg, lat_deg },
            // A boat at rest has no course.
            cog_rad: if speed_mps > 0.0 { east.atan2(north) } else { f32::NAN },
            compass_rad: heading
                .map_or(f32::NAN, |heading| (f32::from(heading) / 100.0).to_radians()),
            speed_mps,
        },
    })
}
