//! Computes the way of the boat: straight lines joined by round turns.

use super::arithmetic::{bearing, cos, sin};
use super::scene::TrackSettings;
use bathyscope_log::survey::MountingSettings;
use std::f64::consts::PI;

/// Place and heading of the boat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BoatPose {
    /// Metres east of the scene's centre.
    pub east_m: f64,
    /// Metres north of the scene's centre.
    pub north_m: f64,
    /// Heading, radians clockwise from north.
    pub heading_rad: f64,
}

impl BoatPose {
    /// Returns the unit vector (east, north) forward.
    pub(super) fn forward(&self) -> [f64; 2] {
        [sin(self.heading_rad), cos(self.heading_rad)]
    }

    /// Returns the pose of the antenna when the transducer has this pose.
    pub(super) fn antenna(self, mounting: &MountingSettings) -> Self {
        let [forward_e, forward_n] = self.forward();
        let (forward_m, right_m) = (mounting.forward_m, mounting.right_m);
        Self {
            east_m: self.east_m - forward_m * forward_e - right_m * forward_n,
            north_m: self.north_m - forward_m * forward_n + right_m * forward_e,
            ..self
        }
    }
}

/// A piece of the way with a constant rate of turn.
struct PathPiece {
    start: BoatPose,
    length_m: f64,
    /// Rate of turn, radians clockwise per metre; 0 on a straight line.
    turn_per_m: f64,
}

/// The whole way of the boat.
pub(super) struct Path {
    legs: Vec<PathPiece>,
    length_m: f64,
}

impl Path {
    /// Creates the way along all lines, then all cross lines.
    pub(super) fn new(track: &TrackSettings) -> Self {
        let corners = corners(track);
        let mut path = Self { legs: Vec::new(), length_m: 0.0 };
        let mut from = corners[0];
        for corner in corners.windows(3) {
            from = path.turn(from, corner[1], corner[2], track.turn_radius_m);
        }
        let last = corners[corners.len() - 1];
        // Only a single line bends.
        let bend_deg_per_m = if corners.len() == 2 { track.bend_deg_per_m } else { 0.0 };
        let heading = bearing(last[0] - from[0], last[1] - from[1]);
        path.push(from, heading, distance(from, last), bend_deg_per_m.to_radians());
        path
    }

    /// Adds the straight way from `from` towards `corner` and the round turn towards `next`;
    /// returns the end of the turn.
    fn turn(
        &mut self,
        from: [f64; 2],
        corner: [f64; 2],
        next: [f64; 2],
        radius_m: f64,
    ) -> [f64; 2] {
        let heading = bearing(corner[0] - from[0], corner[1] - from[1]);
        let after = bearing(next[0] - corner[0], next[1] - corner[1]);
        let turn = (after - heading + PI).rem_euclid(2.0 * PI) - PI;
        let half = turn.abs() / 2.0;
        let tangent = sin(half) / cos(half);
        // Half of the way to the next corner is left for the turn there.
        let room = distance(from, corner).min(0.5 * distance(corner, next));
        let cut = (radius_m * tangent).min(room);
        self.push(from, heading, distance(from, corner) - cut, 0.0);
        let start = ahead(corner, heading, -cut);
        if turn.abs() > 1e-6 && cut > 0.0 {
            let radius = cut / tangent;
            self.push(start, heading, radius * turn.abs(), turn.signum() / radius);
        }
        ahead(corner, after, cut)
    }

    fn push(&mut self, at: [f64; 2], heading_rad: f64, length_m: f64, turn_per_m: f64) {
        let start = BoatPose { east_m: at[0], north_m: at[1], heading_rad };
        self.length_m += length_m;
        self.legs.push(PathPiece { start, length_m, turn_per_m });
    }

    /// Returns the length of the whole way, metres.
    pub(super) fn length_m(&self) -> f64 {
        self.length_m
    }

    /// Returns the pose of the boat after `travelled_m` metres; before the start and after the end,
    /// the pose there.
    pub(super) fn at(&self, travelled_m: f64) -> BoatPose {
        let mut rest = travelled_m.clamp(0.0, self.length_m);
        for leg in &self.legs {
            if rest <= leg.length_m {
                return leg.at(rest);
            }
            rest -= leg.length_m;
        }
        let last = &self.legs[self.legs.len() - 1];
        last.at(last.length_m)
    }
}

impl PathPiece {
    fn at(&self, travelled_m: f64) -> BoatPose {
        let turn = self.turn_per_m * travelled_m;
        // The chord of an arc points half the turn away and is shorter by sin(x) / x.
        let half = 0.5 * turn;
        let chord = if half.abs() < 1e-9 { travelled_m } else { travelled_m * sin(half) / half };
        let start = [self.start.east_m, self.start.north_m];
        let place = ahead(start, self.start.heading_rad + half, chord);
        BoatPose {
            east_m: place[0],
            north_m: place[1],
            heading_rad: (self.start.heading_rad + turn).rem_euclid(2.0 * PI),
        }
    }
}

/// Returns the ends of all lines in the order in which the boat reaches them, at least two.
fn corners(track: &TrackSettings) -> Vec<[f64; 2]> {
    if track.corners_m.len() > 1 {
        return track.corners_m.clone();
    }
    let offset = |index: u32, count: u32| {
        (f64::from(index) - 0.5 * (f64::from(count) - 1.0)) * track.spacing_m
    };
    let mut corners = Vec::new();
    for line in 0..track.lines {
        let north = offset(line, track.lines);
        let west = if line % 2 == 0 { -0.5 } else { 0.5 } * track.length_m;
        corners.extend([[west, north], [-west, north]]);
    }
    for line in 0..track.cross_lines {
        let east = offset(line, track.cross_lines);
        let north = if line % 2 == 0 { 0.5 } else { -0.5 } * track.cross_length_m;
        corners.extend([[east, north], [east, -north]]);
    }
    if corners.is_empty() {
        corners.extend([[0.0, 0.0], [1.0, 0.0]]);
    }
    corners
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (east, north) = (b[0] - a[0], b[1] - a[1]);
    (east * east + north * north).sqrt()
}

fn ahead(from: [f64; 2], heading_rad: f64, metres: f64) -> [f64; 2] {
    [from[0] + metres * sin(heading_rad), from[1] + metres * cos(heading_rad)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boat_moves_steadily_and_heads_where_it_goes() {
        let path = Path::new(&TrackSettings::default());
        let step = 0.01;
        let mut before = path.at(0.0);
        let count = (path.length_m() / step) as usize;
        for index in 1..count {
            let pose = path.at(index as f64 * step);
            let moved = distance([before.east_m, before.north_m], [pose.east_m, pose.north_m]);
            assert!((moved - step).abs() < 1e-5, "{index}: {moved}");
            let course = bearing(pose.east_m - before.east_m, pose.north_m - before.north_m);
            let off = (course - pose.heading_rad + PI).rem_euclid(2.0 * PI) - PI;
            assert!(off.abs() < 0.01, "{index}: {off}");
            before = pose;
        }
    }
}
