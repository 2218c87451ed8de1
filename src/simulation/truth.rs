//! Holds the truth about a simulated survey that its log does not contain: the true places of boat
//! and objects, and the true ranges.

use super::echo::ObjectEcho;
use super::scene::ObjectKind;
use super::visibility::VisiblePart;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::Side;
use std::ops::Range;

/// The truth about one recorded side-scan ping. East and north are metres in the survey's local
/// coordinate frame, whose origin is the first recorded fix
/// ([`bathyscope_log::survey::Track::frame`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PingTruth {
    /// Seconds after the first ping, as recorded (whole milliseconds).
    pub time_s: f64,
    /// True position of the boat.
    pub position: LonLat,
    /// True position, metres east.
    pub east_m: f64,
    /// True position, metres north.
    pub north_m: f64,
    /// True heading, radians clockwise from north.
    pub heading_rad: f64,
    /// True depth of the ground (objects included, weed not) under the boat, metres below the
    /// transducer.
    pub depth_m: f64,
    /// Recorded slant range of one sample, metres; sample `i` covers `i` to `i + 1` times this
    /// value, minus `recorder.range_offset_m`.
    pub metres_per_sample: f64,
    /// Truth about the port side.
    pub port: SideTruth,
    /// Truth about the starboard side.
    pub starboard: SideTruth,
}

/// The truth about one side of one ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideTruth {
    /// Slant range of the nearest ground (objects included, fish and weed not) on this side, in the
    /// vertical plane across the boat's heading, metres. NaN where there is no water under the
    /// boat.
    pub first_return_m: f64,
    /// True if the echo of weed comes before that of the ground, or at most 10 cm behind it: the
    /// detected first return may then be above the bottom without being an error.
    pub weed: bool,
}

impl PingTruth {
    /// Returns the truth about one side.
    pub fn side(&self, side: Side) -> &SideTruth {
        match side {
            Side::Port => &self.port,
            Side::Starboard => &self.starboard,
        }
    }
}

/// An object, and the passes that insonified it.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectTruth {
    /// Kind of the object.
    pub kind: ObjectKind,
    /// Position of the object's centre.
    pub position: LonLat,
    /// Centre of the object, metres east in the survey's local coordinate frame.
    pub east_m: f64,
    /// Centre of the object, metres north in the survey's local coordinate frame.
    pub north_m: f64,
    /// Extent along the heading, metres.
    pub length_m: f64,
    /// Extent across the heading, metres.
    pub width_m: f64,
    /// Height above the ground, metres.
    pub height_m: f64,
    /// Heading, the direction of the object's length, degrees clockwise from north.
    pub heading_deg: f64,
    /// Passes of the boat in which a side insonified the object.
    pub sightings: Vec<ObjectPass>,
}

/// One pass of the boat along an object. Pings count recorded pings ([`super::Simulated::pings`]).
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectPass {
    /// The side that insonified the object.
    pub side: Side,
    /// First ping with the echo of the object.
    pub first_ping: usize,
    /// Last ping with the echo of the object.
    pub last_ping: usize,
    /// Nearest slant range of the object's visible surface, metres.
    pub near_m: f64,
    /// Farthest slant range of the object's visible surface, metres.
    pub far_m: f64,
    /// Slant ranges of the start and the end of the longest shadow, metres; the end is NaN where a
    /// shadow extends beyond the range. The start is the far edge of the object's top: with the
    /// altitude H, the height of the object is `H (end - start) / end`.
    pub shadow_m: [f64; 2],
    /// A ping with the longest shadow.
    pub shadow_ping: usize,
    /// Height above the ground of the edge that casts the longest shadow, metres: for an open hull
    /// that lists, or a trunk that tapers, this is not the greatest height of the object.
    pub top_height_m: f64,
    /// Slant range at which the ground ends in the pings of the pass, visible or not: the recorded
    /// range or the shore, metres.
    pub reach_m: f64,
    /// Number of pings before `first_ping` and after `last_ping` that still insonify the object
    /// because of the width of the beam: one standard deviation of the two-way beam on the ground.
    pub spread_pings: usize,
    /// Part of the object that a picture shows; `None` where speckle, noise, or the shadow of
    /// another object hides it.
    pub shown: Option<VisiblePart>,
}

impl ObjectPass {
    /// Returns the recorded pings that show the object, of `count` pings in all; where nothing is
    /// shown, the pings that insonify it, including the spread of the beam.
    pub fn pings(&self, count: usize) -> Range<usize> {
        if let Some(shown) = &self.shown {
            return shown.first_ping..shown.last_ping + 1;
        }
        let end = (self.last_ping + 1 + self.spread_pings).min(count);
        self.first_ping.saturating_sub(self.spread_pings)..end
    }

    /// Returns the slant ranges of the box around the shown part of echo and shadow, metres; where
    /// nothing is shown, those by the geometry, with a shadow that extends beyond the range cut at
    /// `reach_m`.
    pub fn echo_and_shadow_m(&self) -> [f64; 2] {
        if let Some(shown) = &self.shown {
            return [shown.near_m, shown.far_m];
        }
        let [_, end] = self.shadow_m;
        let end = if end.is_nan() { self.reach_m } else { end };
        [self.near_m, self.far_m.max(end)]
    }
}

/// Largest step from one ping with an echo to the next of the same pass, pings. In a turn the beam
/// swings over an object more than once, with bare ground between: these are separate passes.
const PASS_GAP: usize = 3;

/// Adds the echo of an object in one ping to the passes of the object.
pub(super) fn note(sightings: &mut Vec<ObjectPass>, ping: usize, side: Side, seen: &ObjectEcho) {
    let pass = sightings.iter_mut().rev().find(|pass| pass.side == side);
    match pass.filter(|pass| ping - pass.last_ping <= PASS_GAP) {
        Some(pass) => {
            pass.last_ping = ping;
            pass.near_m = pass.near_m.min(seen.near_m);
            pass.far_m = pass.far_m.max(seen.far_m);
            pass.reach_m = pass.reach_m.max(seen.reach_m);
            // A shadow that extends beyond the range is longer than any that ends within it, so
            // that NaN stays.
            let [start, end] = pass.shadow_m;
            let longer = seen.shadow_end_m - seen.far_m > end - start;
            if !end.is_nan() && (seen.shadow_end_m.is_nan() || longer) {
                pass.shadow_m = [seen.far_m, seen.shadow_end_m];
                pass.shadow_ping = ping;
                pass.top_height_m = seen.top_height_m;
            }
        }
        None => sightings.push(ObjectPass {
            side,
            first_ping: ping,
            last_ping: ping,
            near_m: seen.near_m,
            far_m: seen.far_m,
            shadow_m: [seen.far_m, seen.shadow_end_m],
            shadow_ping: ping,
            top_height_m: seen.top_height_m,
            reach_m: seen.reach_m,
            spread_pings: 0,
            shown: None,
        }),
    }
}
