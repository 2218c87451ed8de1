//! Determines positions of the sonar: the position that a ping states for the sonar, or the ship's
//! position with the layback of a towed sonar and the offsets of antenna and transducer.

use super::from_log::Provenance;
use super::navigation::{HEADING_WITHIN_S, PositionConverter, SentNavigation, recorded};
use super::raw::{FileHeader, PingHeader};
use crate::formats::collected::Collected;
use crate::support::geo::{LocalFrame, LonLat, MPS_PER_KNOT};
use crate::survey::{Fix, ProjectedTrack, nearest_in_time};
use std::ops::Range;

/// Plausible laybacks of a towed sonar, metres.
const LAYBACKS_M: Range<f32> = 0.01..20_000.0;
/// Largest plausible offset, metres; a larger one is taken for a damaged value and ignored.
const FARTHEST_M: f32 = 200.0;
/// Smallest distance between the sonar's and the ship's position, as a share of the layback, from
/// which on the sonar's position is taken to include the layback.
const OWN_FROM: f64 = 0.5;

/// Offset from one point of the ship to another point or to the sonar: forward and to starboard,
/// metres.
type Arm = [f32; 2];

/// Arm and heading of a ping, for positions of packets near it in time.
#[derive(Clone, Copy, Debug)]
struct Towing {
    time_s: f64,
    arm: Arm,
    /// Compass heading, radians; NaN where none was recorded.
    compass_rad: f32,
}

/// Collects the fixes of a file and the data to move them to the sonar.
#[derive(Debug, Default)]
pub(super) struct Positions {
    converter: PositionConverter,
    /// Positions and headings of packets that are no pings.
    pub(super) sent: SentNavigation,
    /// True if headings are those of the track, not of a compass.
    has_track_headings: bool,
    /// Position of the antenna from the ship's reference point.
    antenna_m: Arm,
    latency_ms: i32,
    /// Indices of the log's fixes that are the ship's and have to be moved, each with the arm from
    /// the antenna to the sonar.
    arms: Vec<(usize, Arm)>,
    /// Arms and headings of pings without a position.
    unplaced: Vec<Towing>,
    /// Shortest and longest layback of pings with the ship's position or none, metres.
    laybacks_m: Option<[f32; 2]>,
    /// True if antenna and transducer are at different places.
    has_offsets: bool,
    /// Number of pings whose position already includes the stated layback.
    own: usize,
    /// Longest cable of pings that state no layback, metres.
    cable_m: u16,
    /// True if pings state pitch or roll.
    has_attitude: bool,
    /// First and last time of the pings, seconds after the log's time zero.
    span_s: Option<[f64; 2]>,
}

impl Positions {
    /// Creates a collection for a file with this header. `origin_m` is the origin of positions in
    /// metres, if it is known because earlier bytes of the same log were read before.
    pub(super) fn new(header: Option<FileHeader>, origin_m: Option<[f64; 2]>) -> Self {
        let antenna_m =
            header.map_or([0.0; 2], |header| [header.nav_offset_y_m, header.nav_offset_x_m]);
        Self {
            converter: PositionConverter { units: header.map(|header| header.nav_units), origin_m },
            has_track_headings: header
                .is_some_and(|header| Provenance::of(&header).has_track_headings),
            antenna_m,
            latency_ms: header.map_or(0, |header| header.nav_latency_ms),
            ..Self::default()
        }
    }

    /// Returns a collection for the same file without collected positions.
    pub(super) fn after_head(self) -> Self {
        Self {
            sent: SentNavigation::default(),
            arms: Vec::new(),
            unplaced: Vec::new(),
            laybacks_m: None,
            own: 0,
            span_s: None,
            ..self
        }
    }

    /// Adds the position of a ping. `transducer_m` is the transducer's position from the ship's
    /// reference point, from the file header.
    pub(super) fn add(
        &mut self,
        log: &mut Collected,
        ping: &PingHeader,
        time_s: f64,
        transducer_m: Arm,
    ) {
        let [from_s, to_s] = self.span_s.unwrap_or([time_s; 2]);
        self.span_s = Some([from_s.min(time_s), to_s.max(time_s)]);
        let [pitch_deg, roll_deg] = [ping.sensor_pitch_deg, ping.sensor_roll_deg];
        self.has_attitude |= pitch_deg != 0.0 || roll_deg != 0.0;
        let sensor = recorded([ping.sensor_x, ping.sensor_y]);
        let ship = recorded([ping.ship_x, ping.ship_y]);
        let layback_m = Some(ping.layback_m).filter(|layback_m| LAYBACKS_M.contains(layback_m));
        let heading_deg = first_set([ping.sensor_heading_deg, ping.ship_gyro_deg]);
        let heading_deg = heading_deg.filter(|_| !self.has_track_headings);
        let compass_rad = heading_deg.map_or(f32::NAN, f32::to_radians);
        let Some(stated) = sensor.or(ship) else {
            let arm = self.arm(transducer_m, layback_m);
            self.unplaced.push(Towing { time_s, arm, compass_rad });
            return;
        };
        let speed_kn = first_set([ping.sensor_speed_kn, ping.ship_speed_kn]);
        let before = log.fixes.len();
        log.add_fix(Fix {
            compass_rad,
            speed_mps: speed_kn.map_or(f32::NAN, |kn| (f64::from(kn) * MPS_PER_KNOT) as f32),
            ..Fix::at(time_s, self.converter.place(stated))
        });
        if self.is_own(sensor, ship, layback_m.unwrap_or(0.0)) {
            self.own += usize::from(layback_m.is_some());
        } else if log.fixes.len() > before {
            if layback_m.is_none() {
                self.cable_m = self.cable_m.max(ping.cable_out_m);
            }
            let arm = self.arm(transducer_m, layback_m);
            if arm != [0.0; 2] {
                self.arms.push((before, arm));
            }
        }
    }

    /// Returns the arm from the antenna to the sonar, and notes the layback and the offsets for the
    /// warnings.
    fn arm(&mut self, transducer_m: Arm, layback_m: Option<f32>) -> Arm {
        if let Some(layback_m) = layback_m {
            let [shortest_m, longest_m] = self.laybacks_m.unwrap_or([layback_m; 2]);
            self.laybacks_m = Some([shortest_m.min(layback_m), longest_m.max(layback_m)]);
        }
        let [forward_m, right_m] = [0, 1].map(|axis| {
            let offset_m = transducer_m[axis] - self.antenna_m[axis];
            if offset_m.abs() <= FARTHEST_M { offset_m } else { 0.0 }
        });
        self.has_offsets |= [forward_m, right_m] != [0.0; 2];
        [forward_m - layback_m.unwrap_or(0.0), right_m]
    }

    /// Returns true if the used position is the sonar's own: the ping states it, and the ship's
    /// position, if there is one, is another and far enough away for the layback.
    fn is_own(&self, sensor: Option<[f64; 2]>, ship: Option<[f64; 2]>, layback_m: f32) -> bool {
        match (sensor, ship) {
            (Some(sensor), Some(ship)) if sensor == ship => false,
            (Some(sensor), Some(ship)) => {
                self.converter.apart_m(sensor, ship) >= OWN_FROM * f64::from(layback_m)
            }
            (sensor, _) => sensor.is_some(),
        }
    }

    /// Completes the fixes with positions and headings of packets, moves the ship's fixes to the
    /// sonar, and adds warnings about this. `zero_s` is the log's time zero in Unix seconds.
    pub(super) fn finish(&mut self, log: &mut Collected, zero_s: f64) {
        self.sent.settle(zero_s, self.span_s.unwrap_or_default());
        let headings = self.sent.fill_headings(&mut log.fixes);
        let towing = self.towing(&log.fixes);
        let mut moved = self.move_to_sonar(log);
        let stand_ins = self.sent.stand_ins(&mut log.fixes);
        for sent in &stand_ins {
            let position = self.converter.place(sent.recorded);
            let mut fix = Fix { compass_rad: sent.compass_rad, ..Fix::at(sent.time_s, position) };
            let near = nearest_in_time(&towing, fix.time_s, |ping| ping.time_s);
            let near = near.map(|index| towing[index]);
            let is_beside = |ping: &Towing| (ping.time_s - fix.time_s).abs() <= HEADING_WITHIN_S;
            if let Some(ping) = near.filter(is_beside).filter(|_| fix.compass_rad.is_nan()) {
                fix.compass_rad = ping.compass_rad;
            }
            if let Some(arm) = near.map(|ping| ping.arm).filter(|arm| *arm != [0.0; 2]) {
                let there = moved_by(fix, arm);
                moved[usize::from(there.is_none())] += 1;
                fix = there.unwrap_or(fix);
            }
            log.add_fix(fix);
        }
        log.projected = self.converter.origin_m.map(ProjectedTrack::new);
        self.remark(log, [stand_ins.len(), headings], moved);
    }

    /// Returns the arms and headings of pings with the ship's position or without a position, in
    /// time order.
    fn towing(&self, fixes: &[Fix]) -> Vec<Towing> {
        let of_fix = |&(index, arm): &(usize, Arm)| {
            fixes.get(index).map(|fix| Towing {
                time_s: fix.time_s,
                arm,
                compass_rad: fix.compass_rad,
            })
        };
        let placed = self.arms.iter().filter_map(of_fix);
        let mut towing: Vec<Towing> = placed.chain(self.unplaced.iter().copied()).collect();
        towing.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        towing
    }

    /// Moves the ship's fixes to the sonar; returns how many were moved, and how many were not
    /// because they have no heading. A position that a recorder repeats is moved by the same vector
    /// each time, whatever the heading, because later steps recognise repeats by equal positions.
    fn move_to_sonar(&self, log: &mut Collected) -> [usize; 2] {
        let mut moved = [0; 2];
        // Last position of the ship, and the position to which it was moved.
        let mut last: Option<(LonLat, LonLat)> = None;
        for &(index, arm) in &self.arms {
            let Some(fix) = log.fixes.get_mut(index) else {
                continue;
            };
            let ship = fix.position;
            let again = last.filter(|(from, _)| *from == ship).map(|(_, to)| to);
            let to = again.or_else(|| Some(moved_by(*fix, arm)?.position));
            let Some(to) = to else {
                moved[1] += 1;
                continue;
            };
            fix.position = to;
            last = Some((ship, to));
            moved[0] += 1;
        }
        moved
    }

    /// Describes the distances by which the ship's positions are moved.
    fn arms_in_words(&self) -> String {
        let layback = self.laybacks_m.map(|[from_m, to_m]| {
            if from_m == to_m {
                format!("the stated layback of {from_m:.1} m")
            } else {
                format!("the stated layback of {from_m:.1} to {to_m:.1} m")
            }
        });
        let offsets = "the stated offsets of antenna and transducer".to_owned();
        let offsets = self.has_offsets.then_some(offsets);
        let both: Vec<String> = layback.into_iter().chain(offsets).collect();
        both.join(" and ")
    }

    fn remark(&self, log: &Collected, [positions, headings]: [usize; 2], moved: [usize; 2]) {
        let say = |text: String| log.report.log(text);
        if positions > 0 {
            say(format!(
                "{positions} positions of navigation packets stand in where pings have none or an old one"
            ));
        }
        if headings > 0 {
            say(format!("{headings} pings have the heading of other packets"));
        }
        let [applied, left] = moved;
        if applied > 0 {
            say(format!(
                "{applied} positions are the ship's and were moved to the sonar along its heading, by {}; mounting.forward_m and mounting.right_m are added to that",
                self.arms_in_words()
            ));
        }
        if left > 0 {
            say(format!(
                "{left} positions are the ship's and were not moved to the sonar by the stated layback and offsets: no heading is known there"
            ));
        }
        if self.own > 0 {
            say(format!(
                "{} pings state a layback that was not applied: their positions are the sonar's own",
                self.own
            ));
        }
        if self.cable_m > 0 {
            say(format!(
                "the log states up to {} m of cable but no layback, so positions are the ship's; set mounting.forward_m to less than 0",
                self.cable_m
            ));
        }
        if self.latency_ms != 0 {
            say(format!(
                "the file header states a latency of positions of {} ms, which was not applied; set mounting.latency_s if positions are late",
                self.latency_ms
            ));
        }
        if self.has_attitude || self.sent.attitudes > 0 {
            say("pitch, roll and heave that the log states are not used".to_owned());
        }
    }
}

/// Returns a fix of the antenna moved to the sonar; `None` without a heading.
fn moved_by(fix: Fix, [forward_m, right_m]: Arm) -> Option<Fix> {
    let (sin, cos) = f64::from(fix.compass_rad).sin_cos();
    let [forward_m, right_m] = [forward_m, right_m].map(f64::from);
    let east_m = forward_m * sin + right_m * cos;
    let north_m = forward_m * cos - right_m * sin;
    let position = LocalFrame::new(fix.position).to_lon_lat(east_m, north_m);
    (!fix.compass_rad.is_nan()).then_some(Fix { position, ..fix })
}

/// Returns the first of two values that was recorded; 0 means "not recorded".
pub(super) fn first_set(values: [f32; 2]) -> Option<f32> {
    values.into_iter().find(|value| value.is_finite() && *value != 0.0)
}
