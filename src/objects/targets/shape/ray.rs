//! Follows a ray outward over a solid, and adds its echo and shadow to a ping.

use super::levels::BoxLevels;
use super::solid::{LANES, Solid};
use std::array::from_fn;
use std::ops::Range;

/// Greatest number of steps over a solid, and least length of a step, metres.
const STEPS: usize = 48;
const LEAST_STEP_M: f64 = 0.015;
/// Least depth of a solid below the transducer, and least distance at which rays begin, metres.
const LEAST_BELOW_M: f32 = 0.05;
/// Distance from a side of the rectangle around a solid to the places before and behind it, metres:
/// the sides are nearly upright, and thinner than the side of a boat.
const AT_SIDE_M: f64 = 0.005;
/// Greatest number of places of a ray: those between its steps, and one before and one behind the
/// solid; rounded up so that all places can be computed in full groups.
const MOST_PLACES: usize = (STEPS + 3).next_multiple_of(LANES) + LANES;

type PlaceRow = [f32; MOST_PLACES];

/// Places on a ray, from before the solid to behind it, each with the step that ends there. Each
/// quantity is in a row of its own, so that several places are computed at once: fitting shapes
/// takes most of the time of a search for objects.
pub(super) struct ShapeRay {
    count: usize,
    altitude_m: f32,
    /// Distance out from under the boat, and depth below the transducer, metres.
    out_m: PlaceRow,
    below_m: PlaceRow,
    /// Tangent of the direction of the place, from the vertical.
    tangent: PlaceRow,
    slant_m: PlaceRow,
    /// Echo of the step over that of the bare bottom, for each metre of range that the step covers.
    echo_m: PlaceRow,
    /// Range of the place within a ping, as a fractional number of bins, and the bin.
    in_bins: PlaceRow,
    bin: [i32; MOST_PLACES],
}

impl Default for ShapeRay {
    /// Creates a ray without places.
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
            in_bins: row,
            bin: [0; MOST_PLACES],
        }
    }
}

impl ShapeRay {
    /// Follows the ray that begins under the boat at `start_m` along and across the solid and has
    /// the direction `outward`; the circle around the solid covers twice `half_m` of the ray. Steps
    /// are no shorter than `least_step_m`. Returns true if the ray meets the solid.
    #[inline(always)]
    pub(super) fn follow(
        &mut self,
        altitude_m: f64,
        solid: &Solid,
        half_m: f64,
        (start_m, outward): ([f64; 2], [f64; 2]),
        least_step_m: f64,
    ) -> bool {
        let Some([near_m, far_m]) = solid.met_m(start_m, outward) else {
            return false;
        };
        let first_m = (near_m + AT_SIDE_M).max(f64::from(LEAST_BELOW_M));
        let last_m = far_m - AT_SIDE_M;
        if last_m <= first_m {
            return false;
        }
        let least_m = (2.0 * half_m / STEPS as f64).max(LEAST_STEP_M).max(least_step_m);
        let steps = (((last_m - first_m) / least_m) as usize + 1).clamp(1, STEPS);
        let step_m = (last_m - first_m) / steps as f64;
        self.count = steps + 3;
        self.altitude_m = altitude_m as f32;
        let start_m = [0, 1].map(|axis| start_m[axis] + outward[axis] * first_m);
        let lanes = (steps + 1).next_multiple_of(LANES);
        let heights_m = &mut self.below_m[1..=lanes];
        solid.heights_m(start_m, outward.map(|share| share * step_m), heights_m);
        self.below_m[0] = 0.0;
        self.below_m[steps + 2] = 0.0;
        let (first, step) = (first_m as f32, step_m as f32);
        for (index, out_m) in self.out_m[1..=lanes].iter_mut().enumerate() {
            *out_m = first + index as f32 * step;
        }
        self.out_m[0] = (first_m - 2.0 * AT_SIDE_M) as f32;
        self.out_m[steps + 2] = (last_m + 2.0 * AT_SIDE_M) as f32;
        self.place();
        self.weigh();
        true
    }

    /// Computes the places from the heights above the bottom, which are stored in `below_m` before.
    #[inline(always)]
    fn place(&mut self) {
        let count = self.count.div_ceil(LANES);
        let out_m = &self.out_m.as_chunks::<LANES>().0[..count];
        let below_m = &mut self.below_m.as_chunks_mut::<LANES>().0[..count];
        let tangent = &mut self.tangent.as_chunks_mut::<LANES>().0[..count];
        let slant_m = &mut self.slant_m.as_chunks_mut::<LANES>().0[..count];
        for (((out_m, below_m), tangent), slant_m) in
            out_m.iter().zip(below_m).zip(tangent).zip(slant_m)
        {
            let below: [f32; LANES] =
                from_fn(|lane| (self.altitude_m - below_m[lane]).max(LEAST_BELOW_M));
            *tangent = from_fn(|lane| out_m[lane] / below[lane]);
            *slant_m =
                from_fn(|lane| (out_m[lane] * out_m[lane] + below[lane] * below[lane]).sqrt());
            *below_m = below;
        }
    }

    /// Converts the ranges of the places to bins, `per_m` to a metre from `from_m` on.
    #[inline(always)]
    fn count_in_bins(&mut self, from_m: f32, per_m: f32) {
        let count = self.count.div_ceil(LANES);
        let slant_m = &self.slant_m.as_chunks::<LANES>().0[..count];
        let in_bins = &mut self.in_bins.as_chunks_mut::<LANES>().0[..count];
        let bin = &mut self.bin.as_chunks_mut::<LANES>().0[..count];
        for ((slant_m, in_bins), bin) in slant_m.iter().zip(in_bins).zip(bin) {
            *in_bins = from_fn(|lane| (slant_m[lane] - from_m) * per_m);
            *bin = from_fn(|lane| in_bins[lane] as i32);
        }
    }

    /// Computes the echo of each step.
    #[inline(always)]
    fn weigh(&mut self) {
        let altitude_m2 = self.altitude_m * self.altitude_m;
        let pairs = |row: &PlaceRow, at: usize| -> [[f32; LANES]; 2] {
            [at - 1, at].map(|at| row[at..].as_chunks().0[0])
        };
        for at in (1..self.count).step_by(LANES) {
            let [out0, out1] = pairs(&self.out_m, at);
            let [below0, below1] = pairs(&self.below_m, at);
            let [slant0, slant1] = pairs(&self.slant_m, at);
            let echo: &mut [f32; LANES] = &mut self.echo_m[at..].as_chunks_mut().0[0];
            *echo = from_fn(|lane| {
                let (out_m, below_m) =
                    (0.5 * (out0[lane] + out1[lane]), 0.5 * (below0[lane] + below1[lane]));
                let step_m = out1[lane] - out0[lane];
                let down_m = below1[lane] - below0[lane];
                // Lambert's law on a step that is longer because of its slope: facing^2 / range^2 *
                // length. `facing_m2` is the cosine times length and range.
                let facing_m2 = (below_m * step_m - out_m * down_m).max(0.0);
                let length_m = (step_m * step_m + down_m * down_m).sqrt();
                let range_m2 = out_m * out_m + below_m * below_m;
                // Echo of the bare bottom: cos^2 dy/dr = (H/r)^2 r/y for each metre of range. This
                // is infinite at the nearest point of the bottom.
                let range_m = 0.5 * (slant0[lane] + slant1[lane]);
                let least_m2 = 0.01 * range_m * range_m;
                let level_m = (range_m * range_m - altitude_m2).max(least_m2).sqrt();
                facing_m2 * facing_m2 * range_m * level_m / (range_m2 * length_m * altitude_m2)
            });
        }
    }
}

/// Returns the slant range of a place from its distance out and its depth below. `hypot` is not
/// needed for such numbers, and takes as long as a step.
#[inline(always)]
pub(super) fn slant_m(out_m: f64, below_m: f64) -> f64 {
    (out_m * out_m + below_m * below_m).sqrt()
}

/// The bins of a ping, to which rays are added.
pub(super) struct EchoBins<'a> {
    from_m: f32,
    per_m: f32,
    bottom: &'a mut [f32],
    object: &'a mut [f32],
    written: Range<usize>,
}

impl<'a> EchoBins<'a> {
    /// Creates the bins of a ping without a solid: visible shares of the bottom, and echoes of the
    /// solid.
    pub(super) fn new(look: &'a BoxLevels, bottom: &'a mut [f32], object: &'a mut [f32]) -> Self {
        Self {
            from_m: look.from_m as f32,
            per_m: look.step_m.recip() as f32,
            bottom,
            object,
            written: look.bins..0,
        }
    }

    /// Returns the range of bins that rays were added to; `None` if there is none.
    pub(super) fn written(self) -> Option<Range<usize>> {
        (self.written.start < self.written.end).then_some(self.written)
    }

    /// Adds a ray with a weight.
    #[inline(always)]
    pub(super) fn add(&mut self, ray: &mut ShapeRay, weight: f32) {
        let altitude_m = ray.altitude_m;
        ray.count_in_bins(self.from_m, self.per_m);
        // Tangent of the farthest direction seen so far, and the places where the solid begins and
        // ends.
        let mut horizon = ray.tangent[0];
        let mut solid: Option<[usize; 2]> = None;
        for index in 1..ray.count {
            let of_solid = ray.below_m[index - 1] < altitude_m || ray.below_m[index] < altitude_m;
            if of_solid {
                solid = Some([solid.map_or(index - 1, |[first, _]| first), index]);
            }
            let [before, here] = [ray.tangent[index - 1], ray.tangent[index]];
            if here > horizon {
                let visible =
                    if before >= horizon { 1.0 } else { (here - horizon) / (here - before) };
                horizon = here;
                if solid.is_some() {
                    let echo = weight * visible * ray.echo_m[index];
                    let step = [index - 1, index].map(|at| (ray.in_bins[at], ray.bin[at]));
                    self.add_echo(step, echo, of_solid);
                }
            }
        }
        if let Some([first, last]) = solid {
            let end_m = ray.out_m[last].max(horizon * altitude_m);
            // The visible part of this stretch was added as echoes; the bottom itself is hidden in
            // all of it.
            let ranges_m = [ray.out_m[first], end_m]
                .map(|out_m| (out_m * out_m + altitude_m * altitude_m).sqrt());
            self.hide(ranges_m.map(|range_m| (range_m - self.from_m) * self.per_m), weight);
        }
    }

    /// Adds the echo of a step between two places, given as fractional bins, each with its bin.
    #[inline(always)]
    fn add_echo(
        &mut self,
        [(one, one_bin), (other, other_bin)]: [(f32, i32); 2],
        echo: f32,
        of_solid: bool,
    ) {
        let (from, to) = (one.min(other), one.max(other));
        let per_bin = echo * self.per_m;
        // Most steps are within one bin.
        let is_in_one = one_bin == other_bin && from >= 0.0 && to > 0.0;
        let span =
            if is_in_one { self.write_bins([one_bin as usize; 2]) } else { self.write([from, to]) };
        let Some(span) = span else {
            return;
        };
        let into = if of_solid { &mut *self.object } else { &mut *self.bottom };
        if is_in_one {
            into[span[0]] += per_bin
        } else {
            let each = per_bin / (to - from).max(1e-6 * self.per_m);
            add_shares(into, span, [from, to], each);
        }
    }

    /// Removes the bottom between two places, given as fractional bins.
    #[inline(always)]
    fn hide(&mut self, [from, to]: [f32; 2], weight: f32) {
        if let (true, Some(span)) = (from < to, self.write([from, to])) {
            add_shares(self.bottom, span, [from, to], -weight);
        }
    }

    /// Marks the bins between two places as written, and returns the first and the last of them;
    /// `None` if there are none.
    #[inline(always)]
    fn write(&mut self, [from, to]: [f32; 2]) -> Option<[usize; 2]> {
        let count = self.bottom.len();
        let is_within = to > 0.0 && from < count as f32;
        if !is_within {
            return None;
        }
        self.write_bins([from.max(0.0) as usize, (to as usize).min(count - 1)])
    }

    /// Marks two bins and those between them as written, and returns the two; `None` if the first
    /// is beyond the ping.
    #[inline(always)]
    fn write_bins(&mut self, [first, last]: [usize; 2]) -> Option<[usize; 2]> {
        (first < self.bottom.len()).then(|| {
            self.written.start = self.written.start.min(first);
            self.written.end = self.written.end.max(last + 1);
            [first, last]
        })
    }
}

/// Adds a value to some bins, multiplied by the share of each bin that is between two places.
#[inline(always)]
fn add_shares(bins: &mut [f32], [first, last]: [usize; 2], [from, to]: [f32; 2], value: f32) {
    let share = |bin: usize| {
        let bin = bin as f32;
        (to.min(bin + 1.0) - from.max(bin)).max(0.0)
    };
    bins[first] += value * share(first);
    if last > first {
        // The bins in between are covered completely.
        for into in &mut bins[first + 1..last] {
            *into += value;
        }
        bins[last] += value * share(last);
    }
}
