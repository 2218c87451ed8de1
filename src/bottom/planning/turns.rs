//! Computes turns that a boat can make: the shortest ways between two poses with a least radius.
//!
//! The shortest way is two arcs with a straight piece between them, or three arcs (L. E. Dubins, On
//! curves of minimal length with a constraint on average curvature, 1957). The equations are those
//! of A. M. Shkel and V. Lumelsky (Classification of the Dubins set, 2001).

use Piece::{Left, Right, Straight};
use std::f64::consts::{PI, TAU};

/// Angle between the corners of a drawn arc, radians: the chord is up to 1.5 % of the radius away
/// from the arc.
const STEP_RAD: f64 = 20.0 * PI / 180.0;

/// Straight line with a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Metres east and north.
    pub from: [f64; 2],
    /// Metres east and north.
    pub to: [f64; 2],
}

impl Leg {
    /// Returns the length, metres.
    pub fn length_m(&self) -> f64 {
        apart_m(self.from, self.to)
    }

    /// Returns the heading, radians clockwise from north.
    pub fn heading_rad(&self) -> f64 {
        let [east, north] = self.way();
        east.atan2(north)
    }

    /// Returns the line in the opposite direction.
    #[must_use]
    pub fn turned(self) -> Self {
        Self { from: self.to, to: self.from }
    }

    /// Returns place and course at the start of the line.
    pub(super) fn start(&self) -> TurnPose {
        self.pose(self.from)
    }

    /// Returns place and course at the end of the line.
    pub(super) fn end(&self) -> TurnPose {
        self.pose(self.to)
    }

    fn pose(&self, place: [f64; 2]) -> TurnPose {
        let [east, north] = self.way();
        TurnPose { place, course_rad: north.atan2(east) }
    }

    fn way(&self) -> [f64; 2] {
        [self.to[0] - self.from[0], self.to[1] - self.from[1]]
    }
}

/// Returns the distance of two places, metres.
pub(super) fn apart_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Place and direction of movement of the boat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TurnPose {
    /// Metres east and north.
    pub place: [f64; 2],
    /// Course, radians counter-clockwise from east.
    pub course_rad: f64,
}

/// Piece of a turn: an arc in radians, or a straight piece in radii.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Piece {
    Left(f64),
    Straight(f64),
    Right(f64),
}

/// Way between two poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    from: TurnPose,
    radius_m: f64,
    /// Pieces in order: arcs in radians, straight pieces in radii.
    pieces: [Piece; 3],
}

/// Returns all ways between two poses of two arcs and a straight piece, or of three arcs, the
/// shortest first.
pub(super) fn turns(from: TurnPose, to: TurnPose, radius_m: f64) -> Vec<Turn> {
    let [east, north] = [0, 1].map(|axis| to.place[axis] - from.place[axis]);
    let direction = north.atan2(east);
    let (a, b) = (from.course_rad - direction, to.course_rad - direction);
    let words = words(east.hypot(north) / radius_m, turned(a), turned(b));
    let mut turns: Vec<Turn> =
        (words.into_iter().flatten()).map(|pieces| Turn { from, radius_m, pieces }).collect();
    turns.sort_by(|one, other| one.length_m().total_cmp(&other.length_m()));
    turns
}

/// Reduces an angle to the range from 0 to a full turn; an angle that is less than a full turn by
/// rounding only becomes 0.
fn turned(angle: f64) -> f64 {
    let angle = angle.rem_euclid(TAU);
    if TAU - angle < 1e-9 { 0.0 } else { angle }
}

/// Returns the six words of Dubins for a distance `d` in radii and the courses `a` and `b`,
/// relative to the direction between the places; `None` for a word that does not exist.
fn words(d: f64, a: f64, b: f64) -> [Option<[Piece; 3]>; 6] {
    let ((sin_a, cos_a), (sin_b, cos_b)) = (a.sin_cos(), b.sin_cos());
    let cos_ab = (a - b).cos();
    // A square below zero by rounding counts as zero.
    let root = |square: f64| (square >= -1e-12).then(|| square.max(0.0).sqrt());
    let same = |sign: f64| root(2.0 + d * d - 2.0 * cos_ab + 2.0 * d * sign * (sin_a - sin_b));
    // A single arc has no straight piece with a direction.
    let straight = |p: f64, [y, x]: [f64; 2]| if p < 1e-6 { b } else { y.atan2(x) };
    let lsl = same(1.0).map(|p| {
        let middle = straight(p, [cos_b - cos_a, d + sin_a - sin_b]);
        [Left(turned(middle - a)), Straight(p), Left(turned(b - middle))]
    });
    let rsr = same(-1.0).map(|p| {
        let middle = straight(p, [cos_a - cos_b, d - sin_a + sin_b]);
        [Right(turned(a - middle)), Straight(p), Right(turned(middle - b))]
    });
    let lsr = root(d * d - 2.0 + 2.0 * cos_ab + 2.0 * d * (sin_a + sin_b)).map(|p| {
        let middle = (-cos_a - cos_b).atan2(d + sin_a + sin_b) - (-2.0_f64).atan2(p);
        [Left(turned(middle - a)), Straight(p), Right(turned(middle - b))]
    });
    let rsl = root(d * d - 2.0 + 2.0 * cos_ab - 2.0 * d * (sin_a + sin_b)).map(|p| {
        let middle = (cos_a + cos_b).atan2(d - sin_a - sin_b) - 2.0_f64.atan2(p);
        [Right(turned(a - middle)), Straight(p), Left(turned(b - middle))]
    });
    let arcs = |sign: f64| {
        let cos = (6.0 - d * d + 2.0 * cos_ab + 2.0 * d * sign * (sin_a - sin_b)) / 8.0;
        (cos.abs() <= 1.0).then(|| TAU - cos.acos())
    };
    let rlr = arcs(1.0).map(|p| {
        let t = turned(a - (cos_a - cos_b).atan2(d - sin_a + sin_b) + 0.5 * p);
        [Right(t), Left(p), Right(turned(a - b - t + p))]
    });
    let lrl = arcs(-1.0).map(|p| {
        let t = turned(-a + (cos_b - cos_a).atan2(d + sin_a - sin_b) + 0.5 * p);
        [Left(t), Right(p), Left(turned(b - a - t + p))]
    });
    [lsl, rsr, lsr, rsl, rlr, lrl]
}

impl Turn {
    /// Returns the length of the way, metres.
    pub(super) fn length_m(&self) -> f64 {
        let [first, middle, last] = self.pieces.map(|piece| match piece {
            Left(part) | Straight(part) | Right(part) => part,
        });
        self.radius_m * (first + middle + last)
    }

    /// Returns places along the way, without its ends: the ends of its pieces, enough places within
    /// arcs to draw them round, and a place every `straight_m` metres on straight pieces.
    pub(super) fn places(&self, straight_m: f64) -> Vec<[f64; 2]> {
        let mut pose = self.from;
        let mut places = Vec::new();
        for piece in self.pieces {
            let (part, most) = match piece {
                Left(angle) | Right(angle) => (angle, STEP_RAD),
                Straight(radii) => (radii, straight_m / self.radius_m),
            };
            if part * self.radius_m < 1e-6 {
                continue;
            }
            let steps = (part / most).ceil().max(1.0);
            let start = pose;
            for step in 1..=steps as u32 {
                pose = self.after(start, piece, part * f64::from(step) / steps);
                places.push(pose.place);
            }
        }
        places.pop();
        places
    }

    /// Returns the pose after a part of a piece that begins at `from`.
    fn after(&self, from: TurnPose, piece: Piece, part: f64) -> TurnPose {
        let TurnPose { place: [east, north], course_rad } = from;
        let radius_m = self.radius_m;
        let sign = match piece {
            Straight(_) => {
                let (sin, cos) = course_rad.sin_cos();
                let way_m = radius_m * part;
                return TurnPose { place: [east + way_m * cos, north + way_m * sin], course_rad };
            }
            Left(_) => 1.0,
            Right(_) => -1.0,
        };
        let after = course_rad + sign * part;
        TurnPose {
            place: [
                east + sign * radius_m * (after.sin() - course_rad.sin()),
                north - sign * radius_m * (after.cos() - course_rad.cos()),
            ],
            course_rad: after,
        }
    }

    /// Returns the pose at the end of the turn.
    #[cfg(test)]
    fn end(&self) -> TurnPose {
        self.pieces.into_iter().fold(self.from, |pose, piece| {
            let (Left(part) | Straight(part) | Right(part)) = piece;
            self.after(pose, piece, part)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(east: f64, north: f64, course_rad: f64) -> TurnPose {
        TurnPose { place: [east, north], course_rad }
    }

    #[test]
    fn every_way_arrives_where_it_should() {
        let mut words = 0;
        for index in 0..400_u32 {
            let draw = |step: u32| f64::from((index * 7919 + step * 104_729) % 1000) / 1000.0;
            let from = pose(10.0 * draw(1), 10.0 * draw(2), TAU * draw(3));
            let to = pose(20.0 * draw(4), 20.0 * draw(5), TAU * draw(6));
            let all = turns(from, to, 3.0);
            assert!(all.len() >= 2);
            words += all.len();
            for turn in all {
                let end = turn.end();
                let off_m = (end.place[0] - to.place[0]).hypot(end.place[1] - to.place[1]);
                let off_rad = (end.course_rad - to.course_rad).sin().abs();
                assert!(off_m < 1e-6 && off_rad < 1e-6, "{turn:?}: {off_m} {off_rad}");
            }
        }
        assert!(words > 1400, "{words}");
    }

    #[test]
    fn known_ways_have_known_lengths() {
        let shortest = |from, to| turns(from, to, 2.0)[0].length_m();
        // Straight ahead; a half circle to the line at two radii; a quarter circle to the left.
        for (to, length_m) in [
            (pose(7.0, 0.0, 0.0), 7.0),
            (pose(0.0, 4.0, PI), 2.0 * PI),
            (pose(2.0, 2.0, PI / 2.0), PI),
        ] {
            let found_m = shortest(pose(0.0, 0.0, 0.0), to);
            assert!((found_m - length_m).abs() < 1e-6, "{to:?}: {found_m}");
        }
    }

    #[test]
    fn its_corners_lie_on_no_smaller_circle_than_the_radius() {
        for turn in turns(pose(0.0, 0.0, 0.3), pose(3.0, 4.0, 2.0), 2.5) {
            let mut places = vec![turn.from.place];
            places.extend(turn.places(1.0));
            places.push(turn.end().place);
            for corner in places.windows(3) {
                let side = |i: usize, j: usize| {
                    (corner[i][0] - corner[j][0]).hypot(corner[i][1] - corner[j][1])
                };
                let (a, b, c) = (side(0, 1), side(1, 2), side(0, 2));
                let cross = (corner[1][0] - corner[0][0]) * (corner[2][1] - corner[0][1])
                    - (corner[1][1] - corner[0][1]) * (corner[2][0] - corner[0][0]);
                // The radius of the circle through three places is a b c over twice the cross
                // product.
                let radius_m = a * b * c / (2.0 * cross.abs()).max(1e-12);
                assert!(radius_m > 2.49, "{turn:?}: {radius_m}");
            }
        }
    }
}
