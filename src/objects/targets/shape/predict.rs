//! Predicts the recorded levels of a solid on the bottom: its echo, and the shadow behind it.
//!
//! Along a ray from the boat outward, the solid is a profile of heights. A step of it is insonified
//! as far as its direction from the vertical exceeds that of all steps before it; its echo, by
//! Lambert's law, is in proportion to the square of the cosine of the angle between the ray and the
//! normal of the step. The bottom behind it is dark up to the point where the farthest of these
//! directions meets the bottom. All powers are relative to that of the bare bottom at the same
//! range, so that gain, spreading and the beam across the track cancel.

use super::levels::{BoxLevels, PingLevels};
use super::ray::{EchoBins, ShapeRay, slant_m};
use super::solid::{ShapeKind, Solid};
use bathyscope_bottom::vectors::{VectorLoop, vectorised};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// A solid at a place, with a heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosedSolid {
    /// Kind and size.
    pub solid: Solid,
    /// Middle of the solid, metres east of the survey's origin.
    pub east_m: f64,
    /// Middle of the solid, metres north of the survey's origin.
    pub north_m: f64,
    /// Direction of the length, radians clockwise from north; for a boat, the direction of the bow.
    pub heading_rad: f64,
}

impl PosedSolid {
    /// Returns the solid with its heading within a circle, or within half a circle if it looks the
    /// same from both ends.
    pub(super) fn with_heading_in_range(self) -> Self {
        let turn_rad = if self.solid.kind.is_boat() { TAU } else { PI };
        Self { heading_rad: self.heading_rad.rem_euclid(turn_rad), ..self }
    }

    /// Returns the heading for people and files, radians; NaN for a tyre, which is round.
    pub fn shown_heading_rad(&self) -> f64 {
        match self.solid.kind {
            ShapeKind::Tyre => f64::NAN,
            _ => self.heading_rad,
        }
    }

    /// Converts a place along and across the solid, metres from its middle, to metres east and
    /// north.
    pub fn place_m(&self, [along_m, across_m]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.heading_rad.sin_cos();
        [
            self.east_m + along_m * sin + across_m * cos,
            self.north_m + along_m * cos - across_m * sin,
        ]
    }
}

/// Echo and shadow of a solid on a ping; slant ranges in the recorder's scale, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeOnPing {
    /// Index of the ping.
    pub ping: usize,
    /// Near and far edge of the echo.
    pub echo_m: [f64; 2],
    /// End of the shadow.
    pub shadow_end_m: f64,
}

/// Least power of the solid's echo in a bin that is part of the echo, and power of the bottom below
/// which a bin is part of the shadow; both as shares of the power of bare bottom.
const SEEN: f32 = 0.1;
const DARK: f32 = 0.5;

/// Returns echo and shadow of a solid on those pings of a look that receive its echo.
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

/// Predicted power over that of the bare bottom, bin by bin and ping by ping.
#[derive(Clone, Debug, Default)]
pub(super) struct Predicted {
    /// Power of the visible bottom; 1 where the solid has no effect.
    pub(super) bottom: Vec<f32>,
    /// Power of the solid's echo, if the solid scattered as strongly as the bottom.
    pub(super) object: Vec<f32>,
    /// Bins of each ping that the solid affects; in all others, `bottom` is 1 and `object` 0.
    pub(super) changed: Vec<Range<usize>>,
}

impl Predicted {
    /// Resets the prediction to that of a look without a solid. The search does this for every
    /// trial, so only the bins that the last trial changed are written.
    #[inline(always)]
    fn clear(&mut self, look: &BoxLevels) {
        let count = look.pings.len() * look.bins;
        if self.bottom.len() != count {
            self.bottom = vec![1.0; count];
            self.object = vec![0.0; count];
            self.changed = vec![0..0; look.pings.len()];
            return;
        }
        let pings = self.bottom.chunks_exact_mut(look.bins);
        let pings = pings.zip(self.object.chunks_exact_mut(look.bins));
        for ((bottom, object), changed) in pings.zip(&mut self.changed) {
            bottom[changed.clone()].fill(1.0);
            object[changed.clone()].fill(0.0);
            *changed = 0..0;
        }
    }
}

/// Standard deviation of the two-way beam along the track, radians, for a beam a little under a
/// degree wide: the usual 455 kHz.
const BEAM_SIGMA_RAD: f64 = 0.0157 / 2.355;
/// Rays across the width of the beam: their offsets in standard deviations, and their weights
/// (Gauss-Hermite).
const RAYS: [(f64, f32); 3] = [(-1.732, 1.0 / 6.0), (0.0, 2.0 / 3.0), (1.732, 1.0 / 6.0)];

/// Least length of a step of a ray in a coarse picture, as a share of a bin.
const COARSE_STEP: f64 = 0.25;

/// Predicts the levels of a look at a solid, and writes them to `into`.
pub(super) fn predict(look: &BoxLevels, posed: &PosedSolid, into: &mut Predicted) {
    vectorised(Predict { look, posed, into });
}

struct Predict<'a> {
    look: &'a BoxLevels,
    posed: &'a PosedSolid,
    into: &'a mut Predicted,
}

impl VectorLoop for Predict<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { look, posed, into } = self;
        into.clear(look);
        let mut ray = ShapeRay::default();
        let turned = (posed.solid.reach_m(), posed.heading_rad.sin_cos().into());
        let bottom = into.bottom.chunks_exact_mut(look.bins);
        let both = bottom.zip(into.object.chunks_exact_mut(look.bins));
        for ((ping, (bottom, object)), changed) in
            look.pings.iter().zip(both).zip(&mut into.changed)
        {
            let mut bins = EchoBins::new(look, bottom, object);
            one_ping(look, ping, posed, turned, &mut ray, &mut bins);
            let Some(written) = bins.written() else {
                continue;
            };
            *changed = written.start.saturating_sub(1)..(written.end + 1).min(look.bins);
            blur(&mut bottom[changed.clone()]);
            blur(&mut object[changed.clone()]);
        }
    }
}

/// Spreads each bin a little over its neighbours, as the pulse and the receiver's filter do.
#[inline(always)]
fn blur(bins: &mut [f32]) {
    let mut before = bins[0];
    for index in 0..bins.len() {
        let (here, after) = (bins[index], bins[(index + 1).min(bins.len() - 1)]);
        bins[index] = 0.25 * before + 0.5 * here + 0.25 * after;
        before = here;
    }
}

/// Adds the rays of one ping to its bins. The solid reaches `reach_m` from its middle, and the sine
/// and cosine of its heading are precomputed.
#[inline(always)]
fn one_ping(
    look: &BoxLevels,
    ping: &PingLevels,
    posed: &PosedSolid,
    (reach_m, [sin, cos]): (f64, [f64; 2]),
    ray: &mut ShapeRay,
    bins: &mut EchoBins<'_>,
) {
    let [x, y] = ping.outward;
    let [ahead_x, ahead_y] = [-y, x];
    let [east_m, north_m] = [posed.east_m - ping.boat_m[0], posed.north_m - ping.boat_m[1]];
    let out_m = east_m * x + north_m * y;
    let ahead_m = east_m * ahead_x + north_m * ahead_y;
    // A ping that is the mean of several covers more of the track: the standard deviation of an
    // even distribution is its width over the root of 12.
    let beam_m = BEAM_SIGMA_RAD * slant_m(out_m, look.altitude_m);
    let sigma_m = slant_m(beam_m, look.ping_m / 12f64.sqrt());
    // A coarse picture needs no beam width.
    let (rays, least_step_m) = match look.together {
        1 => (&RAYS[..], 0.0),
        _ => (&[(0.0, 1.0)][..], COARSE_STEP * look.step_m),
    };
    // Components of a step outward along and across the solid.
    let outward = [x * sin + y * cos, x * cos - y * sin];
    for &(at, weight) in rays {
        let beside_m = ahead_m - at * sigma_m;
        let half_m = (reach_m * reach_m - beside_m * beside_m).max(0.0).sqrt();
        if half_m == 0.0 || out_m + half_m <= 0.0 {
            continue;
        }
        let [east_m, north_m] = [at * sigma_m * ahead_x - east_m, at * sigma_m * ahead_y - north_m];
        let start_m = [east_m * sin + north_m * cos, east_m * cos - north_m * sin];
        let from = (start_m, outward);
        if ray.follow(look.altitude_m, &posed.solid, half_m, from, least_step_m) {
            bins.add(ray, weight);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a look to starboard of a boat that sails north, 3 m above the bottom, at ranges from
    /// 5 to 11 m.
    fn look() -> BoxLevels {
        let ping = |index: usize| PingLevels {
            ping: index,
            boat_m: [0.0, 0.1 * (index as f64 - 10.0)],
            outward: [1.0, 0.0],
            levels: vec![0.0; 120],
        };
        BoxLevels::of_pings((0..21).map(ping).collect(), 0.1, [5.0, 0.05])
    }

    /// Creates a block 1 m across the track, 2 m long and 0.5 m high, with its near side 6 m out,
    /// and its look.
    fn block() -> (BoxLevels, PosedSolid) {
        let look = look();
        let solid =
            Solid { kind: ShapeKind::Block, length_m: 2.0, width_m: 1.0, height_m: 0.5, list: 0.0 };
        let posed = PosedSolid { solid, east_m: 6.5, north_m: 0.0, heading_rad: 0.0 };
        (look, posed)
    }

    /// Returns the block's look, and its prediction.
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
        // The far upper edge is 7 m out and 2.5 m below: the ray over this edge meets the bottom at
        // 7 * 3 / 2.5 = 8.4 m, which is 8.92 m of range.
        let range_m = |bin: usize| look.from_m + (bin as f64 + 0.5) * look.step_m;
        let dark: Vec<f64> = (0..look.bins).filter(|bin| middle[*bin] < 0.5).map(range_m).collect();
        // The shadow begins at the foot of the near side, 6 m out on the bottom: 6.71 m of range.
        assert!((dark[0] - 6.71).abs() < 0.06, "{}", dark[0]);
        assert!((dark[dark.len() - 1] - 8.92).abs() < 0.06, "{dark:?}");
        assert!(dark.windows(2).all(|pair| pair[1] - pair[0] < 0.06));
    }

    #[test]
    fn echo_and_shadow_lie_where_they_are_predicted_in_each_ping_that_meets_the_solid() {
        let (look, posed) = block();
        let on_pings = on_pings(&look, &posed);
        // There are 2 m of pings every 0.1 m; the width of the beam may add one.
        assert!((20..=21).contains(&on_pings.len()), "{}", on_pings.len());
        let middle = on_pings[on_pings.len() / 2];
        assert_eq!(middle.ping, 10);
        for (found_m, expected_m) in
            [(middle.echo_m[0], 6.5), (middle.echo_m[1], 7.43), (middle.shadow_end_m, 8.92)]
        {
            assert!((found_m - expected_m).abs() < 0.1, "{middle:?}");
        }
    }

    #[test]
    fn the_near_side_is_brightest_and_the_echo_is_of_the_insonified_sides() {
        let (look, predicted) = of_block();
        let middle = &predicted.object[10 * look.bins..11 * look.bins];
        let brightest = (0..look.bins).max_by(|a, b| middle[*a].total_cmp(&middle[*b]));
        let range_m = look.from_m + (brightest.expect("bins") as f64 + 0.5) * look.step_m;
        // The echo of the near side is between the upper edge at 6.5 m of range and the foot at
        // 6.71 m.
        assert!((6.45..6.75).contains(&range_m), "{range_m}");
        // The top continues to its far edge, 7 m out and 2.5 m below: 7.43 m.
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
            let posed = PosedSolid { solid, east_m, north_m, heading_rad: 0.3 };
            let mut predicted = Predicted::default();
            predict(&look, &posed, &mut predicted);
            assert!(predicted.bottom.iter().all(|share| *share == 1.0));
            assert!(predicted.object.iter().all(|share| *share == 0.0));
        }
    }
}
