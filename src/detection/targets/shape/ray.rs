//! A ray outward over a solid, and the echo and shadow that it adds to a ping.

use super::levels::BoxLevels;
use super::solid::Solid;
use std::ops::Range;

/// Steps that a solid is followed in at most, and how short they are at least, metres.
const STEPS: usize = 48;
const LEAST_STEP_M: f64 = 0.015;
/// A solid ends so far under the transducer at least, and rays begin so far out, metres.
const LEAST_BELOW_M: f64 = 0.05;
/// Sides of the rectangle around a solid stand between places so far before and behind them, metres: upright, and thinner than the side of
/// a boat.
const AT_SIDE_M: f64 = 0.005;
/// Most places of a ray: those between its steps, and one before and one behind the solid.
const MOST_PLACES: usize = STEPS + 3;

type PlaceRow = [f64; MOST_PLACES];

/// Places on a ray, from before the solid to behind it, each with the step that ends there. They lie in rows, so that several are computed
/// at once: fitting shapes is most of a search for objects.
pub(super) struct ShapeRay {
    count: usize,
    altitude_m: f64,
    /// How far out from under the boat and how far below the transducer.
    out_m: PlaceRow,
    below_m: PlaceRow,
    /// Tangent of the direction, from the vertical.
    tangent: PlaceRow,
    slant_m: PlaceRow,
    /// Echo of the step over that of the bare bottom, for each metre of range that the step extends over.
    echo_m: PlaceRow,
}

impl Default for ShapeRay {
    /// A ray without places.
    fn default() -> Self {
        let row = [0.0; MOST_PLACES];
        Self {
            count: 0,
            altitude_m: 0.0,
            out_m: row,
            below_m: row,
            tangent: row,
            slant_m: row,
            echo_m: row,
        }
    }
}

impl ShapeRay {
    /// Follows the ray that begins under the boat at `start_m` along and across the solid and goes in the direction `outward`; the circle
    /// around the solid covers twice `half_m` of it. Whether the ray meets the solid.
    pub(super) fn follow(
        &mut self,
        altitude_m: f64,
        solid: &Solid,
        half_m: f64,
        (start_m, outward): ([f64; 2], [f64; 2]),
    ) -> bool {
        let Some([near_m, far_m]) = solid.met_m(start_m, outward) else {
            return false;
        };
        let first_m = (near_m + AT_SIDE_M).max(LEAST_BELOW_M);
        let last_m = far_m - AT_SIDE_M;
        if last_m <= first_m {
            return false;
        }
        let least_m = (2.0 * half_m / STEPS as f64).max(LEAST_STEP_M);
        let steps = (((last_m - first_m) / least_m).ceil() as usize).clamp(1, STEPS);
        let step_m = (last_m - first_m) / steps as f64;
        self.count = steps + 3;
        self.altitude_m = altitude_m;
        let start_m = [0, 1].map(|axis| start_m[axis] + outward[axis] * first_m);
        let heights_m = &mut self.below_m[..self.count];
        heights_m.fill(0.0);
        let within_m = &mut heights_m[1..steps + 2];
        solid.heights_m(start_m, outward.map(|share| share * step_m), within_m);
        for index in 0..=steps {
            self.out_m[index + 1] = first_m + index as f64 * step_m;
        }
        self.out_m[0] = first_m - 2.0 * AT_SIDE_M;
        self.out_m[steps + 2] = last_m + 2.0 * AT_SIDE_M;
        self.place();
        self.weigh();
        true
    }

    /// Computes the places from the heights above the bottom, which stand in the row of `below_m`.
    fn place(&mut self) {
        for index in 0..self.count {
            let out_m = self.out_m[index];
            let below_m = (self.altitude_m - self.below_m[index]).max(LEAST_BELOW_M);
            self.below_m[index] = below_m;
            self.tangent[index] = out_m / below_m;
            self.slant_m[index] = slant_m(out_m, below_m);
        }
    }

    /// Computes the echo of each step.
    fn weigh(&mut self) {
        let altitude_m2 = self.altitude_m * self.altitude_m;
        for index in 1..self.count {
            let middle = |row: &PlaceRow| 0.5 * (row[index - 1] + row[index]);
            let (out_m, below_m) = (middle(&self.out_m), middle(&self.below_m));
            let step_m = self.out_m[index] - self.out_m[index - 1];
            let down_m = self.below_m[index] - self.below_m[index - 1];
            // Lambert's law on a step that is longer for its slope: facing^2 / range^2 * length. The cosine times the length is meant here.
            let facing_m2 = (below_m * step_m - out_m * down_m).max(0.0);
            let length_m = slant_m(step_m, down_m);
            let range_m2 = out_m * out_m + below_m * below_m;
            // Of the bare bottom: cos^2 dy/dr = (H/r)^2 r/y a metre of range. At its nearest point that grows without end.
            let range_m = middle(&self.slant_m);
            let least_m2 = 0.01 * range_m * range_m;
            let level_m = (range_m * range_m - altitude_m2).max(least_m2).sqrt();
            self.echo_m[index] =
                facing_m2 * facing_m2 * range_m * level_m / (range_m2 * length_m * altitude_m2);
        }
    }
}

/// Slant range of a place so far out and so far below. These are no numbers that `hypot` would be needed for, which costs as much as a step.
pub(super) fn slant_m(out_m: f64, below_m: f64) -> f64 {
    (out_m * out_m + below_m * below_m).sqrt()
}

/// The bins of a ping, and what rays add to them.
pub(super) struct EchoBins<'a> {
    look: &'a BoxLevels,
    bottom: &'a mut [f32],
    object: &'a mut [f32],
    written: Range<usize>,
}

impl<'a> EchoBins<'a> {
    /// Bins of a ping without a solid: shares of the bottom that are seen, and echoes of the solid.
    pub(super) fn new(look: &'a BoxLevels, bottom: &'a mut [f32], object: &'a mut [f32]) -> Self {
        Self {
            look,
            bottom,
            object,
            written: look.bins..0,
        }
    }

    /// The bins that rays added to.
    pub(super) fn written(self) -> Option<Range<usize>> {
        (self.written.start < self.written.end).then_some(self.written)
    }

    /// Adds a ray of some weight.
    pub(super) fn add(&mut self, ray: &ShapeRay, weight: f64) {
        let altitude_m = ray.altitude_m;
        // Tangent of the farthest direction seen so far; where the solid begins and ends.
        let mut horizon = ray.tangent[0];
        let mut solid_m: Option<[f64; 2]> = None;
        for index in 1..ray.count {
            let of_solid = ray.below_m[index - 1] < altitude_m || ray.below_m[index] < altitude_m;
            if of_solid {
                let begins_m = solid_m.map_or(ray.out_m[index - 1], |[first_m, _]| first_m);
                solid_m = Some([begins_m, ray.out_m[index]]);
            }
            let [before, here] = [ray.tangent[index - 1], ray.tangent[index]];
            if here > horizon {
                let visible = match before >= horizon {
                    true => 1.0,
                    false => (here - horizon) / (here - before),
                };
                horizon = here;
                if solid_m.is_some() {
                    self.add_echo(ray, index, weight * visible, of_solid);
                }
            }
        }
        if let Some([first_m, last_m]) = solid_m {
            let end_m = last_m.max(horizon * altitude_m);
            // What is seen within was added; from where the last step of the bottom was seen on nothing is.
            self.hide(
                [first_m, end_m].map(|out_m| slant_m(out_m, altitude_m)),
                weight,
            );
        }
    }

    /// Adds the echo of a step.
    fn add_echo(&mut self, ray: &ShapeRay, index: usize, weight: f64, of_solid: bool) {
        let [from_m, to_m] = [ray.slant_m[index - 1], ray.slant_m[index]];
        let (near_m, width_m) = (from_m.min(to_m), (to_m - from_m).abs().max(1e-6));
        let echo = weight * ray.echo_m[index] / width_m;
        let overlap = self.overlap([near_m, near_m + width_m]);
        let into = match of_solid {
            true => &mut *self.object,
            false => &mut *self.bottom,
        };
        overlap.each(|bin, share| into[bin] += (echo * share) as f32);
    }

    /// Takes the bottom away between two slant ranges.
    fn hide(&mut self, ranges_m: [f64; 2], weight: f64) {
        let overlap = self.overlap(ranges_m);
        overlap.each(|bin, share| self.bottom[bin] -= (weight * share) as f32);
    }

    /// The bins between two slant ranges, which count as written.
    fn overlap(&mut self, ranges_m: [f64; 2]) -> RangeOverlap {
        let per_m = self.look.step_m.recip();
        let [from, to] = ranges_m.map(|range_m| (range_m - self.look.from_m) * per_m);
        let (from, to) = (from.max(0.0), to.min(self.look.bins as f64));
        let bins = match from < to {
            true => from as usize..(to as usize + 1).min(self.look.bins),
            false => 0..0,
        };
        if !bins.is_empty() {
            self.written.start = self.written.start.min(bins.start);
            self.written.end = self.written.end.max(bins.end);
        }
        RangeOverlap { from, to, bins }
    }
}

/// A stretch of ranges that begins and ends within bins.
struct RangeOverlap {
    from: f64,
    to: f64,
    bins: Range<usize>,
}

impl RangeOverlap {
    /// Calls for each bin with the share of it that the stretch overlaps.
    fn each(self, mut add: impl FnMut(usize, f64)) {
        for bin in self.bins {
            let share = self.to.min(bin as f64 + 1.0) - self.from.max(bin as f64);
            add(bin, share.max(0.0));
        }
    }
}
