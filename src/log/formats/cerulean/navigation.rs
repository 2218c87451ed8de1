//! Positions of NMEA and MAVLink packets, put beside the profiles that they lie between.

use crate::formats::nmea;
use crate::support::geo::LonLat;
use crate::support::statistics::upper_median;
use crate::survey::Fix;
use serde::Deserialize;

/// Ids of the packets.
const NMEA: u16 = 109;
const MAVLINK: u16 = 150;
/// A clock that says otherwise than the order of the packets by more than this is not followed,
/// seconds.
const MOST_APART_S: f64 = 5.0;
/// The message that has a position, and what it says of a heading that is not known.
const POSITION_MESSAGE: &str = "GLOBAL_POSITION_INT";
const NO_HEADING: u16 = u16::MAX;

/// A position on its way to a fix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Told {
    /// Seconds of the clock of its own, and which clock that is: that of the receiver or that of
    /// the autopilot.
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
    /// Ten millionths of degrees.
    lat: f64,
    lon: f64,
    /// Centimetres a second to the north and to the east.
    vx: Option<f32>,
    vy: Option<f32>,
    /// Hundredths of degrees.
    hdg: Option<u16>,
}

/// Reads positions, and keeps what sentences without one say of course, speed and heading.
#[derive(Debug)]
pub(super) struct Navigation {
    cog_rad: f32,
    speed_mps: f32,
    heading_rad: f32,
    /// Positions with the time of the profile that follows, seconds after the log's time zero.
    placed: Vec<(f64, Told)>,
}

impl Default for Navigation {
    fn default() -> Self {
        Self { cog_rad: f32::NAN, speed_mps: f32::NAN, heading_rad: f32::NAN, placed: Vec::new() }
    }
}

impl Navigation {
    /// Takes a packet; the position that it tells, if it does.
    pub(super) fn take(&mut self, id: u16, payload: &[u8]) -> Option<Told> {
        match id {
            NMEA => self.take_sentence(nmea::sentence(payload)?),
            MAVLINK => take_message(payload),
            _ => None,
        }
    }

    fn take_sentence(&mut self, told: nmea::Sentence) -> Option<Told> {
        let keep = |kept: &mut f32, told: f32| {
            if !told.is_nan() {
                *kept = told;
            }
        };
        keep(&mut self.cog_rad, told.cog_rad);
        keep(&mut self.speed_mps, told.speed_mps);
        keep(&mut self.heading_rad, told.heading_rad);
        Some(Told {
            own_s: told.utc_s.map(|utc_s| (Clock::Receiver, utc_s)),
            fix: Fix {
                time_s: f64::NAN,
                position: told.position?,
                cog_rad: self.cog_rad,
                compass_rad: self.heading_rad,
                speed_mps: self.speed_mps,
            },
        })
    }

    /// Puts a position beside the profile that follows it, of this time, seconds, and with this
    /// heading of the vehicle, degrees; 0 is none.
    pub(super) fn place(&mut self, mut told: Told, time_s: f64, vehicle_deg: f32) {
        if told.fix.compass_rad.is_nan() && vehicle_deg != 0.0 && vehicle_deg.abs() <= 360.0 {
            told.fix.compass_rad = vehicle_deg.to_radians();
        }
        self.placed.push((time_s, told));
    }

    /// The fixes. Packets wait for each other by tenths of seconds, so that the clocks of their own
    /// tell the times better: they differ from the sonar's by a constant, the median.
    pub(super) fn fixes(self) -> Vec<Fix> {
        let later_s = |clock: Clock| {
            let own = self.placed.iter().filter_map(|(time_s, told)| {
                let (its, own_s) = told.own_s?;
                (its == clock).then_some(time_s - own_s)
            });
            upper_median(&mut own.collect::<Vec<f64>>(), f64::total_cmp)
        };
        let [receiver_s, autopilot_s] = [Clock::Receiver, Clock::Autopilot].map(later_s);
        let each = self.placed.iter().map(|(beside_s, told)| {
            let own_s = told.own_s.and_then(|(clock, own_s)| {
                let later_s = match clock {
                    Clock::Receiver => receiver_s,
                    Clock::Autopilot => autopilot_s,
                };
                Some(own_s + later_s?)
            });
            let is_near = |own_s: &f64| (own_s - beside_s).abs() <= MOST_APART_S;
            Fix { time_s: own_s.filter(is_near).unwrap_or(*beside_s), ..told.fix }
        });
        each.collect()
    }
}

fn take_message(payload: &[u8]) -> Option<Told> {
    // Most messages are others, and are not parsed.
    let name = POSITION_MESSAGE.as_bytes();
    payload.windows(name.len()).find(|part| *part == name)?;
    let Wrapped { message } = serde_json::from_slice(payload).ok()?;
    let [lat_deg, lon_deg] = [message.lat, message.lon].map(|value| value / 1e7);
    // 0, 0 is what an autopilot says before it has a fix.
    let is_fix = message.name == POSITION_MESSAGE && lat_deg != 0.0 && lon_deg != 0.0;
    let [north, east] =
        [message.vx, message.vy].map(|speed| speed.map_or(f32::NAN, |cm| cm / 100.0));
    let heading = message.hdg.filter(|heading| *heading != NO_HEADING);
    let speed_mps = north.hypot(east);
    is_fix.then(|| Told {
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
