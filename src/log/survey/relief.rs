//! Holds the shape of the bottom across the track, on which echoes and objects are placed.
//!
//! At a distance `g` across the track the bottom is `v(g) = H + deeper(g)` below the transducer,
//! with `H` the altitude of the transducer above the bottom under the boat. The echo of the bottom
//! there has the slant range `r(g) = sqrt(g^2 + v(g)^2)`: on a level bottom `g = sqrt(r^2 - H^2)`.

use super::Side;
use rayon::prelude::*;

/// Number of distances across the track at which the bottom is stored; near the boat they are
/// closer together: the n-th is `(n / 16)^1.5` of the farthest.
const NODES: usize = 16;
/// Number of consecutive pings that share one shape of the bottom.
const PINGS: usize = 4;
/// Number of iterations that find the altitude: on slopes up to 25 degrees each reduces the error
/// to less than a tenth.
const STEPS: usize = 5;

/// Depth of the bottom to one side of the boat, by distance, minus the depth under the boat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcrossTrack {
    farthest_m: f32,
    deeper_m: [f32; NODES],
}

impl AcrossTrack {
    /// A level bottom.
    pub const LEVEL: Self = Self { farthest_m: 1.0, deeper_m: [0.0; NODES] };

    /// Returns the distance of a node across the track, metres; node 0 is under the boat.
    fn ground_of(&self, node: usize) -> f64 {
        let share = node as f64 / NODES as f64;
        f64::from(self.farthest_m) * share * share.sqrt()
    }

    /// Returns the depth of the bottom at a node minus the depth under the boat, metres.
    fn deeper_at(&self, node: usize) -> f64 {
        node.checked_sub(1).map_or(0.0, |behind| f64::from(self.deeper_m[behind]))
    }

    /// Returns the depth of the bottom at a distance minus the depth under the boat, metres; beyond
    /// the farthest node, the value of that node.
    pub fn deeper_m(&self, ground_m: f64) -> f64 {
        let share = (ground_m / f64::from(self.farthest_m)).clamp(0.0, 1.0);
        let before = ((NODES as f64 * (share * share).cbrt()) as usize).min(NODES - 1);
        let [from_m, to_m] = [before, before + 1].map(|node| self.ground_of(node));
        let [from, to] = [before, before + 1].map(|node| self.deeper_at(node));
        from + (to - from) * ((ground_m - from_m) / (to_m - from_m)).clamp(0.0, 1.0)
    }

    /// Returns the slant range of the bottom at a distance, metres, from a transducer `altitude_m`
    /// above the bottom under it.
    pub fn range_m(&self, altitude_m: f64, ground_m: f64) -> f64 {
        let deeper_m = if self.is_level() { 0.0 } else { self.deeper_m(ground_m) };
        length(ground_m, altitude_m + deeper_m)
    }

    /// Replaces distances, in ascending order, by the slant ranges of the bottom there, metres,
    /// from a transducer `altitude_m` above the bottom under it.
    #[inline(always)]
    pub fn replace_by_ranges_m(&self, altitude_m: f64, grounds_m: &mut [f64]) {
        if self.is_level() {
            for ground_m in grounds_m {
                *ground_m = length(*ground_m, altitude_m);
            }
            return;
        }
        let mut rest = grounds_m;
        for node in 0..NODES {
            let (from_m, to_m) = (self.ground_of(node), self.ground_of(node + 1));
            let (deeper_m, more_m) =
                (self.deeper_at(node), self.deeper_at(node + 1) - self.deeper_at(node));
            let end = if node + 1 < NODES {
                rest.partition_point(|ground_m| *ground_m < to_m)
            } else {
                // Beyond the last node the bottom goes on level.
                rest.len()
            };
            let (here, beyond) = rest.split_at_mut(end);
            for ground_m in here {
                let share = ((*ground_m - from_m) / (to_m - from_m)).clamp(0.0, 1.0);
                *ground_m = length(*ground_m, altitude_m + (deeper_m + more_m * share));
            }
            rest = beyond;
        }
    }

    /// Returns true if the bottom is level, as it is for most pings of a single pass. The check
    /// saves time: a mosaic computes the ranges of millions of places.
    fn is_level(&self) -> bool {
        self.deeper_m == [0.0; NODES]
    }

    /// Returns the pieces of the bottom between nodes: distance and depth below the transducer of
    /// both ends, metres.
    fn pieces(&self, altitude_m: f64) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let end = move |node| [self.ground_of(node), altitude_m + self.deeper_at(node)];
        (0..NODES).map(move |node| [end(node), end(node + 1)])
    }

    /// Returns the distance across the track and the slant range of the place of the bottom nearest
    /// to the transducer, metres.
    fn nearest(&self, altitude_m: f64) -> [f64; 2] {
        let foots = self.pieces(altitude_m).map(|[from, to]| {
            let way = [to[0] - from[0], to[1] - from[1]];
            let along = -(from[0] * way[0] + from[1] * way[1]);
            let share = (along / (way[0] * way[0] + way[1] * way[1])).clamp(0.0, 1.0);
            let [ground_m, below_m] = [0, 1].map(|axis| from[axis] + share * way[axis]);
            [ground_m, length(ground_m, below_m)]
        });
        let nearer = |one: [f64; 2], other: [f64; 2]| if other[1] < one[1] { other } else { one };
        foots.reduce(nearer).unwrap_or([0.0, altitude_m])
    }

    /// Returns the altitude above the bottom under the boat, metres, of a transducer whose first
    /// return has the slant range `first_return_m`.
    pub fn altitude_m(&self, first_return_m: f64) -> f64 {
        if self.is_level() {
            return first_return_m.max(0.0);
        }
        let step = |altitude_m: f64, _| altitude_m + first_return_m - self.nearest(altitude_m)[1];
        (0..STEPS).fold(first_return_m, step).max(0.0)
    }

    /// Returns the distance across the track at which the bottom has a slant range, metres: the
    /// first one outward from the place of the bottom nearest to the transducer; the distance of
    /// that place where the range is shorter.
    pub fn ground_m(&self, altitude_m: f64, range_m: f64) -> f64 {
        if self.is_level() {
            return (range_m * range_m - altitude_m * altitude_m).max(0.0).sqrt();
        }
        let [nearest_m, least_m] = self.nearest(altitude_m);
        if range_m <= least_m {
            return nearest_m;
        }
        let mut last = [nearest_m, altitude_m + self.deeper_m(nearest_m)];
        for [_, to] in self.pieces(altitude_m) {
            if to[0] <= last[0] {
                continue;
            }
            if length(to[0], to[1]) >= range_m {
                // Along the piece, g^2 + v^2 = r^2 is a quadratic equation for the way from its
                // beginning.
                let slope = (to[1] - last[1]) / (to[0] - last[0]);
                let [a, b] = [1.0 + slope * slope, last[0] + slope * last[1]];
                let c = last[0] * last[0] + last[1] * last[1] - range_m * range_m;
                return last[0] + ((b * b - a * c).max(0.0).sqrt() - b) / a;
            }
            last = to;
        }
        (range_m * range_m - last[1] * last[1]).max(last[0] * last[0]).sqrt()
    }
}

/// Returns the hypotenuse of two sides. `f64::hypot` handles very large and small numbers, which no
/// survey has, and took a sixth of the time of a run.
#[inline(always)]
fn length(across_m: f64, down_m: f64) -> f64 {
    (across_m * across_m + down_m * down_m).sqrt()
}

/// Shape of the bottom across the track, for all pings of a log. The default is level everywhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Relief {
    farthest_m: f32,
    /// Difference of the bottom's depth from that under the boat, metres, by side, port first, and
    /// by group of [`PINGS`] pings.
    sides: [Vec<[f32; NODES]>; 2],
}

impl Relief {
    /// Creates the shape for `pings` pings, up to a distance across the track. `deeper_m` returns
    /// the depth at a distance minus the depth under the boat; it is called for the middle one of
    /// each group of pings. Where it returns `None`, the last value nearer to the boat is used.
    pub fn new(
        pings: usize,
        farthest_m: f64,
        deeper_m: impl Fn(Side, usize, f64) -> Option<f64> + Sync,
    ) -> Self {
        let across = AcrossTrack { farthest_m: farthest_m as f32, ..AcrossTrack::LEVEL };
        let of_side = |side: Side| {
            let profile = |index: usize| {
                let ping = (index * PINGS + PINGS / 2).min(pings - 1);
                let mut last_m = 0.0;
                std::array::from_fn(|node| {
                    last_m = deeper_m(side, ping, across.ground_of(node + 1)).unwrap_or(last_m);
                    last_m as f32
                })
            };
            let profiles = (0..pings.div_ceil(PINGS)).into_par_iter();
            profiles.map(profile).collect()
        };
        Self { farthest_m: farthest_m as f32, sides: Side::BOTH.map(of_side) }
    }

    /// Returns true if the bottom is level everywhere.
    pub fn is_level(&self) -> bool {
        self.sides.iter().all(Vec::is_empty)
    }

    /// Returns the bottom to one side of a ping; level where nothing is known.
    pub fn across(&self, side: Side, ping: usize) -> AcrossTrack {
        let profile = self.sides[side as usize].get(ping / PINGS);
        profile.map_or(AcrossTrack::LEVEL, |deeper_m| AcrossTrack {
            farthest_m: self.farthest_m,
            deeper_m: *deeper_m,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a bottom that is `deeper` metres deeper per metre of distance, up to 40 m.
    fn slope(deeper: f64) -> AcrossTrack {
        let relief = Relief::new(1, 40.0, |_, _, ground_m| Some(deeper * ground_m));
        relief.across(Side::Port, 0)
    }

    #[test]
    fn a_level_bottom_has_the_side_of_the_triangle() {
        let level = AcrossTrack::LEVEL;
        assert!((level.ground_m(3.0, 5.0) - 4.0).abs() < 1e-12);
        assert!((level.range_m(3.0, 4.0) - 5.0).abs() < 1e-12);
        assert_eq!((level.ground_m(3.0, 2.0), level.altitude_m(3.0)), (0.0, 3.0));
        assert_eq!(Relief::default().across(Side::Starboard, 7), level);
    }

    #[test]
    fn ranges_and_distances_belong_together_on_any_bottom() {
        let wavy = Relief::new(9, 30.0, |side, ping, ground_m| {
            let phase = ping as f64 + f64::from(u8::from(side == Side::Port));
            Some(0.8 * (0.3 * ground_m + phase).sin() - 0.8 * phase.sin())
        });
        let mut all = vec![slope(0.2), slope(-0.2), slope(0.0)];
        all.extend((0..9).flat_map(|ping| Side::BOTH.map(|side| wavy.across(side, ping))));
        for across in all {
            let [nearest_m, least_m] = across.nearest(5.0);
            for step in 1..60 {
                let range_m = least_m + 0.5 * f64::from(step);
                let ground_m = across.ground_m(5.0, range_m);
                assert!(ground_m >= nearest_m);
                let again_m = across.range_m(5.0, ground_m);
                assert!((again_m - range_m).abs() < 1e-3, "{range_m} {ground_m} {again_m}");
            }
        }
    }

    #[test]
    fn the_first_return_of_a_slope_comes_from_its_foot() {
        // On the rising side the foot of the perpendicular is at the slant range H cos(slope); on
        // the falling side the nearest place is below the boat.
        let cos = 1.0 / f64::hypot(1.0, 0.25);
        assert!((slope(-0.25).altitude_m(4.0 * cos) - 4.0).abs() < 1e-3);
        assert!((slope(0.25).altitude_m(4.0) - 4.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_not_known_goes_on_as_it_last_was() {
        let known = |_, _, ground_m: f64| (ground_m < 10.0).then_some(0.1 * ground_m);
        let across = Relief::new(5, 40.0, known).across(Side::Port, 4);
        let last_m = across.deeper_m(40.0);
        assert!((0.5..1.0).contains(&last_m));
        assert_eq!(across.deeper_m(100.0), last_m);
        assert!((across.deeper_m(4.0) - 0.4).abs() < 1e-6);
    }
}
