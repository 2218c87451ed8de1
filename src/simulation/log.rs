//! Writes the simulated log (fixes, recorded depths, and the frames of all channels in time order)
//! and the tables of the truth.

use super::arithmetic::exp;
use super::random::{Random, RandomPurpose};
use super::simulate::{ReceivedPing, Simulated, SimulationRun, mercator};
use bathyscope_log::formats::lowrance::write::{
    COMPOSITE, DOWN_SCAN, PRIMARY, Sl2Frame, WrittenFix, frequency_code, usual_frequency_khz,
};
use std::f64::consts::TAU;
use std::io::{self, Write};

/// Noise of the recorded course, degrees (standard deviation).
const COURSE_NOISE_DEG: f64 = 1.5;
/// Noise of the compass, degrees (standard deviation).
const COMPASS_NOISE_DEG: f64 = 2.0;
/// Noise of the recorded speed, metres a second (standard deviation).
const SPEED_NOISE_MPS: f64 = 0.05;

impl SimulationRun<'_> {
    /// Returns the number of the fix that is valid at a time, and the fix.
    fn fix(&self, time_s: f64) -> (u64, WrittenFix) {
        let rate = self.scene.track.fix_rate_hz;
        let number = (time_s * rate + 1e-6).floor();
        // With a latency the position of the fix is that of `latency_s` before; the boat does not
        // move before the start.
        let fixed_s = (number / rate - self.scene.mounting.latency_s).max(0.0);
        let mut pose = self.pose_at(fixed_s);
        let [off_east_m, off_north_m] = self.plan.position_error_m(number / rate);
        pose.east_m += off_east_m;
        pose.north_m += off_north_m;
        let mut random = Random::new(self.seed, RandomPurpose::Fix, number as u64);
        let [course_noise, compass_noise] = random.normal_pair();
        let speed_noise = random.normal();
        let mounted_deg = self.scene.mounting.heading_offset_deg;
        let noisy = |noise_deg: f64| (pose.heading_rad + noise_deg.to_radians()).rem_euclid(TAU);
        let fix = WrittenFix {
            mercator: mercator(&self.scene_frame, pose.antenna(&self.scene.mounting)),
            course_rad: noisy(COURSE_NOISE_DEG * course_noise),
            speed_mps: (self.scene.track.speed_mps + SPEED_NOISE_MPS * speed_noise).max(0.0),
            compass_rad: (self.scene.recorder.compass)
                .then(|| noisy(COMPASS_NOISE_DEG * compass_noise - mounted_deg)),
        };
        (number as u64, fix)
    }

    /// Returns all frames in the order in which the recorder would write them; moves the side-scan
    /// bytes out of the pings.
    pub(super) fn frames(&self, received: &mut [ReceivedPing]) -> Vec<Sl2Frame> {
        let mut log = Log::default();
        let every = u64::from(self.scene.recorder.sonar_every.max(1));
        let mut depth_m = 0.0;
        for (recorded, ping) in received.iter_mut().enumerate() {
            let moment = Moment {
                milliseconds: self.milliseconds(ping.ping),
                fix: self.fix(ping.truth.time_s),
            };
            if recorded == 0 || ping.ping % every == 0 {
                depth_m = self.recorded_depth_m(ping.ping);
                self.write_sonar(ping, depth_m, &moment, &mut log);
            }
            let range_m = [-ping.range_m, ping.range_m];
            let bytes = std::mem::take(&mut ping.composite);
            log.push(COMPOSITE, range_m, depth_m, &moment, bytes);
        }
        log.frames
    }

    /// Adds the frames of the primary and the down-scan channel of a ping to the log.
    fn write_sonar(&self, ping: &ReceivedPing, depth_m: f64, moment: &Moment, log: &mut Log) {
        let true_depth_m = ping.truth.depth_m;
        let range_m = sonar_range_m(true_depth_m);
        let samples = self.scene.recorder.sonar_samples as usize;
        for channel in [PRIMARY, DOWN_SCAN] {
            let bytes = echogram(channel, samples, range_m, true_depth_m, self.seed, ping.ping);
            log.push(channel, [0.0, range_m], depth_m, moment, bytes);
        }
    }

    /// Returns the depth that the recorder's bottom lock writes at a ping, metres.
    fn recorded_depth_m(&self, ping: u64) -> f64 {
        let noise = Random::new(self.seed, RandomPurpose::Sounding, ping).normal();
        let artefacts = &self.scene.artefacts;
        let late = self.scene.mounting.sounding_lag_s * self.scene.track.ping_rate_hz;
        let measured = ping.saturating_sub(late.round() as u64);
        let measured_m = self.true_depth_m(measured) + artefacts.depth_noise_m * noise;
        (artefacts.depth_scale * measured_m + artefacts.depth_offset_m).max(0.0)
    }
}

/// Returns the bytes of one echogram column, nearest first, over `range_m` metres with the bottom
/// at `depth_m`.
///
/// The column is plausible, not physical: only its depth matters.
fn echogram(
    channel: u16,
    samples: usize,
    range_m: f64,
    depth_m: f64,
    seed: u64,
    ping: u64,
) -> Vec<u8> {
    // The traditional sonar has a wide cone and a long pulse, the down-scan a thin fan and a short
    // pulse.
    let (stream, onset_m, tail_m, level) = match channel {
        DOWN_SCAN => (2 * ping, 0.02, 0.35, 175.0),
        _ => (2 * ping + 1, 0.06, 0.8, 215.0),
    };
    let mut random = Random::new(seed, RandomPurpose::Echogram, stream);
    let bottom = |range: f64, depth: f64| {
        let behind = range - depth;
        let rise = 1.0 / (1.0 + exp(-behind / onset_m));
        rise * exp(-behind.max(0.0) / tail_m)
    };
    (0..samples)
        .map(|index| {
            let range = (index as f64 + 0.5) * range_m / samples as f64;
            let ringing = 255.0 * exp(-range / 0.12);
            let echo = level * bottom(range, depth_m) + 0.35 * level * bottom(range, 2.0 * depth_m);
            let fading = 0.75 + 0.25 * random.exponential().min(2.0);
            let noise = 12.0 * random.exponential();
            (ringing + echo * fading + noise).clamp(0.0, 255.0) as u8
        })
        .collect()
}

/// Returns the range of the sonar channels, metres: 1.6 times the depth, rounded up to a multiple
/// of 5 m.
fn sonar_range_m(depth_m: f64) -> f64 {
    5.0 * (1.6 * depth_m / 5.0).ceil().max(1.0)
}

/// Time and fix that all frames of one ping share.
struct Moment {
    milliseconds: i32,
    /// Number of the valid fix, and the fix.
    fix: (u64, WrittenFix),
}

/// Frames in file order, and the number of the last fix.
#[derive(Default)]
struct Log {
    frames: Vec<Sl2Frame>,
    last_fix: Option<u64>,
}

impl Log {
    fn push(
        &mut self,
        channel: u16,
        range_m: [f64; 2],
        depth_m: f64,
        moment: &Moment,
        bytes: Vec<u8>,
    ) {
        let (fix_number, fix) = moment.fix;
        let fresh = self.last_fix != Some(fix_number);
        self.last_fix = Some(fix_number);
        self.frames.push(Sl2Frame {
            channel,
            frequency: frequency_code(usual_frequency_khz(channel)),
            range_m,
            depth_m,
            milliseconds: moment.milliseconds,
            fix,
            fresh,
            bytes,
        });
    }
}

impl Simulated {
    /// Writes the truth about the pings as CSV, one line per recorded ping:
    /// `ping,time_s,lon,lat,east_m,north_m,heading_deg,depth_m,metres_per_sample,port_range_m,port_weed,starboard_range_m,starboard_weed`.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_truth_csv(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(
            out,
            "ping,time_s,lon,lat,east_m,north_m,heading_deg,depth_m,metres_per_sample,\
             port_range_m,port_weed,starboard_range_m,starboard_weed"
        )?;
        for (index, ping) in self.pings.iter().enumerate() {
            writeln!(
                out,
                "{index},{:.3},{:.9},{:.9},{:.4},{:.4},{:.4},{:.4},{:.9},{},{},{},{}",
                ping.time_s,
                ping.position.lon_deg,
                ping.position.lat_deg,
                ping.east_m,
                ping.north_m,
                ping.heading_rad.to_degrees(),
                ping.depth_m,
                ping.metres_per_sample,
                metres(ping.port.first_return_m),
                u8::from(ping.port.weed),
                metres(ping.starboard.first_return_m),
                u8::from(ping.starboard.weed),
            )?;
        }
        Ok(())
    }

    /// Writes the truth about the objects as CSV, one line per sighting, and one with empty fields
    /// for an object that was never insonified:
    /// `object,kind,lon,lat,east_m,north_m,length_m,width_m,height_m,heading_deg,side,first_ping,last_ping,near_m,far_m,shadow_start_m,shadow_end_m,box_first_ping,box_last_ping,box_near_m,box_far_m,shown`.
    /// The box is around the part of echo and shadow that a picture shows, and is what a detector
    /// should propose; `shown` is 0 where nothing is shown ([`crate::ObjectPass::shown`]).
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_objects_csv(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(
            out,
            "object,kind,lon,lat,east_m,north_m,length_m,width_m,height_m,heading_deg,\
             side,first_ping,last_ping,near_m,far_m,shadow_start_m,shadow_end_m,\
             box_first_ping,box_last_ping,box_near_m,box_far_m,shown"
        )?;
        for (index, object) in self.objects.iter().enumerate() {
            let what = format!(
                "{index},{},{:.9},{:.9},{:.3},{:.3},{:.3},{:.3},{:.3},{:.1}",
                object.kind.name(),
                object.position.lon_deg,
                object.position.lat_deg,
                object.east_m,
                object.north_m,
                object.length_m,
                object.width_m,
                object.height_m,
                object.heading_deg,
            );
            if object.sightings.is_empty() {
                writeln!(out, "{what},,,,,,,,,,,,")?;
            }
            for seen in &object.sightings {
                let pings = seen.pings(self.pings.len());
                let [box_near_m, box_far_m] = seen.echo_and_shadow_m();
                writeln!(
                    out,
                    "{what},{},{},{},{},{},{},{},{},{},{},{},{}",
                    seen.side.name(),
                    seen.first_ping,
                    seen.last_ping,
                    metres(seen.near_m),
                    metres(seen.far_m),
                    metres(seen.shadow_m[0]),
                    metres(seen.shadow_m[1]),
                    pings.start,
                    pings.end - 1,
                    metres(box_near_m),
                    metres(box_far_m),
                    u8::from(seen.shown.is_some()),
                )?;
            }
        }
        Ok(())
    }
}

/// Formats metres for a table; empty when there is no value.
fn metres(value: f64) -> String {
    if value.is_finite() { format!("{value:.4}") } else { String::new() }
}
