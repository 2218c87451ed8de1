//! What a pass records of a solid on the bottom: its echo, and the shadow behind it.
//!
//! Along a ray from the boat outward the solid is a profile of heights. A step of it is insonified as far as its direction from the
//! vertical exceeds that of all steps before it; its echo, by Lambert's law, goes with the square of the cosine of the angle between the
//! ray and the normal of the step. What it hides of the bottom is dark up to where the last of those directions meets the bottom.
//! Everything is power over that of the bare bottom at the same range, so that gain, spreading and the beam across the track cancel.

use super::levels::{BoxLevels, PingLevels};
use super::solid::{ShapeKind, Solid};
use std::f64::consts::{PI, TAU};

/// A solid in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PosedSolid {
    /// Kind and size.
    pub solid: Solid,
    /// Its middle, metres east of the survey's origin.
    pub east_m: f64,
    /// The same, metres north.
    pub north_m: f64,
    /// Direction of its length, radians clockwise from north; a boat's bow is there.
    pub heading_rad: f64,
}

impl PosedSolid {
    /// The same with its heading within a circle, or within half of one where it looks the same from both ends.
    pub(super) fn with_heading_in_range(self) -> Self {
        let turn_rad = match self.solid.kind.is_boat() {
            true => TAU,
            false => PI,
        };
        Self {
            heading_rad: self.heading_rad.rem_euclid(turn_rad),
            ..self
        }
    }

    /// Its heading where that says something, for people and files: NaN of a tyre, which is round.
    pub(crate) fn shown_heading_rad(&self) -> f64 {
        match self.solid.kind {
            ShapeKind::Tyre => f64::NAN,
            _ => self.heading_rad,
        }
    }

    /// A place along and across its length, metres from its middle, in metres east and north.
    pub(crate) fn place_m(&self, [along_m, across_m]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.heading_rad.sin_cos();
        [
            self.east_m + along_m * sin + across_m * cos,
            self.north_m + along_m * cos - across_m * sin,
        ]
    }
}

/// Where echo and shadow of a solid lie in a ping, slant ranges on the recorder's scale, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShapeOnPing {
    /// Index of the ping.
    pub ping: usize,
    /// Near and far edge of its echo.
    pub echo_m: [f64; 2],
    /// End of its shadow.
    pub shadow_end_m: f64,
}

/// Share of the bottom's power from which on a bin has an echo of the solid, and below which it lies in the shadow.
const SEEN: f32 = 0.1;
const DARK: f32 = 0.5;

/// Where echo and shadow of a solid lie in the pings of a look that it changes.
pub(super) fn on_pings(look: &BoxLevels, posed: &PosedSolid) -> Vec<ShapeOnPing> {
    let mut predicted = Predicted::default();
    predict(look, posed, &mut predicted);
    let bottom = predicted.bottom.chunks_exact(look.bins);
    let both = bottom.zip(predicted.object.chunks_exact(look.bins));
    let pings = look.pings.iter().zip(both);
    let on_ping = pings.filter_map(|(ping, (bottom, object))| {
        let first = object.iter().position(|power| *power > SEEN)?;
        let last = object.iter().rposition(|power| *power > SEEN)?;
        let dark = bottom.iter().rposition(|share| *share < DARK);
        Some(ShapeOnPing {
            ping: ping.ping,
            echo_m: [first, last + 1].map(|bin| look.recorded_m(bin)),
            shadow_end_m: look.recorded_m(dark.map_or(0, |bin| bin + 1).max(last + 1)),
        })
    });
    on_ping.collect()
}

/// Power over that of the bare bottom, bins of a ping together, ping after ping.
#[derive(Clone, Debug, Default)]
pub(super) struct Predicted {
    /// What of the bottom is seen; 1 where the solid changes nothing.
    pub(super) bottom: Vec<f32>,
    /// The solid's echo, were it to scatter as strongly as the bottom.
    pub(super) object: Vec<f32>,
}

/// Standard deviation of the two-way beam along the track, radians, of a beam a little under a degree wide: the usual 455 kHz.
const BEAM_SIGMA_RAD: f64 = 0.0157 / 2.355;
/// Rays that stand for its width, in standard deviations, and their weights (Gauss-Hermite).
const RAYS: [(f64, f64); 3] = [(-1.732, 1.0 / 6.0), (0.0, 2.0 / 3.0), (1.732, 1.0 / 6.0)];
/// Steps that a solid is followed in at most, and how short they are at least, metres.
const STEPS: usize = 48;
const LEAST_STEP_M: f64 = 0.015;
/// A solid ends so far under the transducer at least, metres.
const LEAST_BELOW_M: f64 = 0.05;

/// Writes what the look would be of a solid.
pub(super) fn predict(look: &BoxLevels, posed: &PosedSolid, into: &mut Predicted) {
    let count = look.pings.len() * look.bins;
    into.bottom.clear();
    into.bottom.resize(count, 1.0);
    into.object.clear();
    into.object.resize(count, 0.0);
    let bottom = into.bottom.chunks_exact_mut(look.bins);
    let both = bottom.zip(into.object.chunks_exact_mut(look.bins));
    for (ping, (bottom, object)) in look.pings.iter().zip(both) {
        let mut bins = Bins {
            look,
            bottom,
            object,
        };
        if one_ping(look, ping, posed, &mut bins) {
            blur(bottom);
            blur(object);
        }
    }
}

/// Spreads each bin a little over its neighbours, as the pulse and the receiver's filter do.
fn blur(bins: &mut [f32]) {
    let mut before = bins[0];
    for index in 0..bins.len() {
        let (here, after) = (bins[index], bins[(index + 1).min(bins.len() - 1)]);
        bins[index] = 0.25 * before + 0.5 * here + 0.25 * after;
        before = here;
    }
}

/// The bins of a ping.
struct Bins<'a> {
    look: &'a BoxLevels,
    bottom: &'a mut [f32],
    object: &'a mut [f32],
}

/// Writes what a ping would be, and says whether it meets the solid.
fn one_ping(look: &BoxLevels, ping: &PingLevels, posed: &PosedSolid, bins: &mut Bins<'_>) -> bool {
    let [x, y] = ping.outward;
    let [east_m, north_m] = [
        posed.east_m - ping.boat_m[0],
        posed.north_m - ping.boat_m[1],
    ];
    let out_m = east_m * x + north_m * y;
    let [ahead_x, ahead_y] = [-y, x];
    let ahead_m = east_m * ahead_x + north_m * ahead_y;
    let reach_m = posed.solid.reach_m();
    let (sin, cos) = posed.heading_rad.sin_cos();
    // Pings that were summed see more of the way: evenly over a width its standard deviation is that over the root of 12.
    let beam_m = BEAM_SIGMA_RAD * out_m.hypot(look.altitude_m);
    let sigma_m = beam_m.hypot(look.ping_m / 12f64.sqrt());
    // What is coarse anyway needs no width.
    let rays = match look.together {
        1 => &RAYS[..],
        _ => &[(0.0, 1.0)][..],
    };
    let mut meets = false;
    for &(at, weight) in rays {
        let beside_m = ahead_m - at * sigma_m;
        let half_m = (reach_m * reach_m - beside_m * beside_m).max(0.0).sqrt();
        if half_m == 0.0 || out_m + half_m <= 0.0 {
            continue;
        }
        meets = true;
        let start = [
            ping.boat_m[0] + at * sigma_m * ahead_x,
            ping.boat_m[1] + at * sigma_m * ahead_y,
        ];
        let step_m = (2.0 * half_m / STEPS as f64).max(LEAST_STEP_M);
        let from_m = (out_m - half_m - step_m).max(LEAST_BELOW_M);
        let steps = ((out_m + half_m - from_m) / step_m).ceil() as usize + 1;
        // Along and across the solid, which turn with the heading only.
        let (east_m, north_m) = (start[0] - posed.east_m, start[1] - posed.north_m);
        let (along_m, across_m) = (east_m * sin + north_m * cos, east_m * cos - north_m * sin);
        let (along, across) = (x * sin + y * cos, x * cos - y * sin);
        let height_m = |y_m: f64| {
            posed
                .solid
                .height_at_m(along_m + along * y_m, across_m + across * y_m)
        };
        ray(bins, height_m, (from_m, step_m, steps), weight);
    }
    meets
}

/// Follows a ray over the solid.
fn ray(
    bins: &mut Bins<'_>,
    height_m: impl Fn(f64) -> f64,
    (from_m, step_m, steps): (f64, f64, usize),
    weight: f64,
) {
    let altitude_m = bins.look.altitude_m;
    // Tangent, from the vertical, of the farthest direction seen so far; where the solid begins and ends.
    let mut horizon = 0.0;
    let mut solid_m: Option<[f64; 2]> = None;
    let (mut y0, mut below0) = (from_m, altitude_m);
    for step in 1..=steps {
        let y1 = from_m + step as f64 * step_m;
        let below1 = (altitude_m - height_m(y1)).max(LEAST_BELOW_M);
        let of_solid = below0 < altitude_m || below1 < altitude_m;
        if of_solid {
            solid_m = Some([solid_m.map_or(y0, |[first, _]| first), y1]);
        }
        let (t0, t1) = (y0 / below0, y1 / below1);
        if t1 > horizon {
            let visible = match t0 >= horizon {
                true => 1.0,
                false => (t1 - horizon) / (t1 - t0),
            };
            horizon = t1;
            if solid_m.is_some() {
                bins.echo([y0, y1], [below0, below1], weight * visible, of_solid);
            }
        }
        (y0, below0) = (y1, below1);
    }
    if let Some([first_m, last_m]) = solid_m {
        let end_m = last_m.max(horizon * altitude_m);
        // What is seen within was added; from where the last step of the bottom was seen on nothing is.
        bins.hide([first_m, end_m].map(|y_m| y_m.hypot(altitude_m)), weight);
    }
}

impl Bins<'_> {
    /// Adds the echo of a step, from so far out and so far below to so far out and below.
    fn echo(&mut self, [y0, y1]: [f64; 2], [below0, below1]: [f64; 2], weight: f64, solid: bool) {
        let (y_m, below_m, step_m) = (0.5 * (y0 + y1), 0.5 * (below0 + below1), y1 - y0);
        let slope = (below1 - below0) / step_m;
        let [r0, r1] = [slant_m(y0, below0), slant_m(y1, below1)];
        let (near_m, width_m) = (r0.min(r1), (r1 - r0).abs().max(1e-6));
        // Lambert's law on a step that is longer for its slope: facing^2 / range^2 * length.
        let facing_m = (below_m - y_m * slope).max(0.0);
        let range_m2 = y_m * y_m + below_m * below_m;
        let power = facing_m * facing_m * step_m / (range_m2 * (1.0 + slope * slope).sqrt());
        // Of the bare bottom: cos^2 dy/dr = (H/r)^2 r/y a metre of range. At its nearest point that grows without end.
        let range_m = 0.5 * (r0 + r1);
        let altitude_m2 = self.look.altitude_m * self.look.altitude_m;
        let least_m2 = 0.01 * range_m * range_m;
        let out_m = (range_m * range_m - altitude_m2).max(least_m2).sqrt();
        let scale = weight * power * range_m * out_m / (altitude_m2 * width_m);
        let into = match solid {
            true => &mut *self.object,
            false => &mut *self.bottom,
        };
        spread(self.look, [near_m, near_m + width_m], |bin, share| {
            into[bin] += (scale * share) as f32;
        });
    }

    /// Takes the bottom away between two slant ranges.
    fn hide(&mut self, ranges_m: [f64; 2], weight: f64) {
        let bottom = &mut *self.bottom;
        spread(self.look, ranges_m, |bin, share| {
            bottom[bin] -= (weight * share) as f32;
        });
    }
}

/// Slant range of a place so far out and so far below. These are no numbers that `hypot` would be needed for, which costs as much as a step.
fn slant_m(out_m: f64, below_m: f64) -> f64 {
    (out_m * out_m + below_m * below_m).sqrt()
}

/// Calls for each bin that a stretch of range overlaps, with the share of the bin that it overlaps.
fn spread(look: &BoxLevels, [from_m, to_m]: [f64; 2], mut add: impl FnMut(usize, f64)) {
    let bin = |range_m: f64| (range_m - look.from_m) / look.step_m;
    let (from, to) = (bin(from_m).max(0.0), bin(to_m).min(look.bins as f64));
    if from >= to {
        return;
    }
    for index in from as usize..(to as usize + 1).min(look.bins) {
        let share = to.min(index as f64 + 1.0) - from.max(index as f64);
        add(index, share.max(0.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A look to starboard of a boat that sails north, 3 m above the bottom, at ranges from 5 to 11 m.
    fn look() -> BoxLevels {
        let ping = |index: usize| PingLevels {
            ping: index,
            boat_m: [0.0, 0.1 * (index as f64 - 10.0)],
            outward: [1.0, 0.0],
            levels: vec![0.0; 120],
        };
        BoxLevels {
            altitude_m: 3.0,
            recorded_m: [5.0, 0.05],
            from_m: 5.0,
            step_m: 0.05,
            bins: 120,
            ping_m: 0.1,
            noise: 0.5,
            together: 1,
            pings: (0..21).map(ping).collect(),
        }
    }

    /// A block 1 m across the track, 2 m long and 0.5 m high, its near side 6 m out.
    fn block() -> (BoxLevels, PosedSolid) {
        let look = look();
        let solid = Solid {
            kind: ShapeKind::Block,
            length_m: 2.0,
            width_m: 1.0,
            height_m: 0.5,
            list: 0.0,
        };
        let posed = PosedSolid {
            solid,
            east_m: 6.5,
            north_m: 0.0,
            heading_rad: 0.0,
        };
        (look, posed)
    }

    /// What the look records of it.
    fn of_block() -> (BoxLevels, Predicted) {
        let (look, posed) = block();
        let mut predicted = Predicted::default();
        predict(&look, &posed, &mut predicted);
        (look, predicted)
    }

    #[test]
    fn a_blocks_shadow_ends_where_the_geometry_says() {
        let (look, predicted) = of_block();
        let middle = &predicted.bottom[10 * look.bins..11 * look.bins];
        // The far upper edge lies 7 m out and 2.5 m below: the ray over it meets the bottom at 7 * 3 / 2.5 = 8.4 m, 8.92 m of range.
        let range_m = |bin: usize| look.from_m + (bin as f64 + 0.5) * look.step_m;
        let dark: Vec<f64> = (0..look.bins)
            .filter(|bin| middle[*bin] < 0.5)
            .map(range_m)
            .collect();
        // It begins at the near side's foot, 6 m out on the bottom: 6.71 m of range.
        assert!((dark[0] - 6.71).abs() < 0.06, "{}", dark[0]);
        assert!((dark[dark.len() - 1] - 8.92).abs() < 0.06, "{dark:?}");
        assert!(dark.windows(2).all(|pair| pair[1] - pair[0] < 0.06));
    }

    #[test]
    fn echo_and_shadow_lie_where_they_are_predicted_in_each_ping_that_meets_the_solid() {
        let (look, posed) = block();
        let on_pings = on_pings(&look, &posed);
        // 2 m of pings every 0.1 m, and what the width of the beam adds.
        assert!((20..=21).contains(&on_pings.len()), "{}", on_pings.len());
        let middle = on_pings[on_pings.len() / 2];
        assert_eq!(middle.ping, 10);
        for (found_m, expected_m) in [
            (middle.echo_m[0], 6.5),
            (middle.echo_m[1], 7.43),
            (middle.shadow_end_m, 8.92),
        ] {
            assert!((found_m - expected_m).abs() < 0.1, "{middle:?}");
        }
    }

    #[test]
    fn the_near_side_is_brightest_and_the_echo_is_of_the_insonified_sides() {
        let (look, predicted) = of_block();
        let middle = &predicted.object[10 * look.bins..11 * look.bins];
        let brightest = (0..look.bins).max_by(|a, b| middle[*a].total_cmp(&middle[*b]));
        let range_m = look.from_m + (brightest.expect("bins") as f64 + 0.5) * look.step_m;
        // From the upper edge at 6.5 m of range to the foot at 6.71 m.
        assert!((6.45..6.75).contains(&range_m), "{range_m}");
        // The top goes on to its far edge, 7 m out and 2.5 m below: 7.43 m.
        let last = (0..look.bins).rev().find(|bin| middle[*bin] > 0.0);
        let last_m = look.from_m + (last.expect("an echo") as f64 + 1.0) * look.step_m;
        assert!((last_m - 7.43).abs() < 0.08, "{last_m}");
    }

    #[test]
    fn what_lies_out_of_the_look_changes_nothing() {
        let look = look();
        let solid = Solid {
            kind: ShapeKind::Boulder,
            length_m: 1.0,
            width_m: 1.0,
            height_m: 0.5,
            list: 0.0,
        };
        for (east_m, north_m) in [(7.0, 20.0), (-7.0, 0.0), (40.0, 0.0)] {
            let posed = PosedSolid {
                solid,
                east_m,
                north_m,
                heading_rad: 0.3,
            };
            let mut predicted = Predicted::default();
            predict(&look, &posed, &mut predicted);
            assert!(predicted.bottom.iter().all(|share| *share == 1.0));
            assert!(predicted.object.iter().all(|share| *share == 0.0));
        }
    }
}
