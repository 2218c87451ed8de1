//! Averages the levels of a chunk of pings on one side in ranges so short that the bed under each
//! is even (a look), which are read from a log once, and places them on the bed as it is known so
//! far: averages them over level cells (a chunk of pings by a length of ground each), and computes
//! how each mean depends on depth, slope, brightness and curves.

use super::layout::{LaidOutLog, PingChunk};
use super::model::{Incidence, LawCurves};
use super::nodes::Nodes;
use crate::bathymetry::{Bends, BentSampler, Node, Tin};
use crate::nearest::Nearest;
use bathyscope_log::survey::Side;

/// Least ground range of level cells, metres: nearer, the beam looks straight down, and depths were
/// measured.
const NEAREST_M: f64 = 1.2;
/// Largest ground range of level cells, metres.
pub(super) const FARTHEST_M: f64 = 40.0;
/// Step in which a ray is followed along the ground, metres, and number of steps before and after a
/// place over which its slope is computed.
const RAY_STEP_M: f64 = 0.125;
const SLOPE_STEPS: usize = 2;
/// Largest angle from straight down, and least angle from the bed's normal, of the used samples,
/// degrees.
const FLATTEST_DEG: f64 = 88.0;
const STEEPEST_DEG: f64 = 24.0;
/// Least number of independent samples in a level cell.
const LEAST_INDEPENDENT: f64 = 8.0;
/// Farthest distance from a measured depth at which the bed is known, metres.
const KNOWN_M: f64 = 20.0;
/// Largest change of a depth in a round, metres.
const MOST_STEP_M: f64 = 0.4;
/// Least altitude over the bed at which slant ranges are converted to angles, metres.
const LEAST_ALTITUDE_M: f64 = 0.1;
/// Share of clipped samples above which a range is not used.
const MOST_CLIPPED: f64 = 0.1;
/// Least length of the mean of the unit vectors outward: below it the boat turns.
const LEAST_STRAIGHT: f64 = 0.997;

/// Depth and brightness of the bed at nodes.
#[derive(Clone, Debug)]
pub(super) struct Bed {
    /// Places of the nodes.
    pub nodes: Nodes,
    /// Depth at each node, metres.
    pub depth_m: Vec<f64>,
    /// Natural logarithm of the bed's own brightness at each node.
    pub ln_brightness: Vec<f64>,
    /// Standard deviation of the depth at each node by the equations, metres; 0 before they are
    /// solved.
    pub sd_m: Vec<f64>,
    /// Depth at each node by the triangles between the measured depths, bent or flat, metres;
    /// beyond the triangles, the nearest measured depth.
    pub triangles_m: Vec<f64>,
    /// True for each node with a measured depth near enough for its own depth to be known.
    pub is_known: Vec<bool>,
}

impl Bed {
    /// Creates the bed from the triangles between the measured depths, and from the nearest
    /// measured depth beyond them; `None` without measured depths.
    pub(super) fn new(nodes: Nodes, measured: &[Node], bends: Option<Bends>) -> Option<Self> {
        let places: Vec<[f64; 2]> = measured.iter().map(Node::place).collect();
        let nearest = Nearest::of(&places)?;
        let tin = Tin::new(measured.to_vec());
        let slopes = bends.map(|bends| bends.slopes(measured));
        let mut triangles = tin.as_ref().map(|tin| BentSampler::new(tin, slopes.as_ref()));
        let mut bed = Self {
            ln_brightness: vec![0.0; nodes.len()],
            sd_m: vec![0.0; nodes.len()],
            nodes,
            depth_m: Vec::new(),
            triangles_m: Vec::new(),
            is_known: Vec::new(),
        };
        for place in (0..nodes.len()).map(|node| nodes.place_m(node)) {
            let (node, distance2_m2) = nearest.at(place);
            let between_m = triangles.as_mut().and_then(|tin| tin.depth_at(place));
            let nearest_m = measured[node].depth_m;
            bed.triangles_m.push(between_m.unwrap_or(nearest_m));
            bed.is_known.push(distance2_m2 <= KNOWN_M * KNOWN_M);
        }
        bed.depth_m = bed.triangles_m.clone();
        Some(bed)
    }

    /// Moves the bed to a solution, each depth by [`MOST_STEP_M`] at most; `values` are depths at
    /// all nodes, then brightness.
    pub(super) fn step(&mut self, values: &[f64]) {
        let (depths, others) = values.split_at(self.nodes.len());
        for (depth_m, value) in self.depth_m.iter_mut().zip(depths) {
            *depth_m += (value - *depth_m).clamp(-MOST_STEP_M, MOST_STEP_M);
        }
        self.ln_brightness.copy_from_slice(&others[..self.nodes.len()]);
    }

    /// Adds `values` (depths at all nodes, then brightness), multiplied by `times`, to the bed.
    pub(super) fn add(&mut self, values: &[f64], times: f64) {
        let (depths, others) = values.split_at(self.nodes.len());
        for (sum, value) in self.depth_m.iter_mut().zip(depths) {
            *sum += times * value;
        }
        for (sum, value) in self.ln_brightness.iter_mut().zip(others) {
            *sum += times * value;
        }
    }
}

/// Mean level of a level cell, its excess over the expected level, and the derivatives of the
/// latter.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlopeObservation {
    /// Mean excess of the logarithm of power over the expected one.
    pub over: f64,
    /// Mean logarithm of power.
    pub ln_power: f64,
    /// Number of independent samples.
    pub independent: f64,
    /// Mean range, angle and slope of the samples.
    pub at: Incidence,
    /// Share of the echo in the power.
    pub share: f64,
    /// Change of the expected level for a unit of slope.
    pub per_slope: f64,
    /// Change of the expected level for a metre of depth.
    pub per_depth: f64,
    /// Middle of the cell, east and north, metres.
    pub place_m: [f64; 2],
}

/// Bed under a look: slope and slant range at even steps of ground range.
struct Ray {
    /// Ground range of the first step, metres.
    from_m: f64,
    /// Slant range at each step, metres, rising: of two places at the same range, the nearer one
    /// counts.
    range_m: Vec<f64>,
    slope: Vec<f64>,
}

impl Ray {
    /// Creates the ray of a look between two ground ranges in metres. Shadows of nearer ground are
    /// ignored.
    fn new(look: &SideChunk, bed: &Bed, [from_m, to_m]: [f64; 2]) -> Self {
        let steps = ((to_m - from_m) / RAY_STEP_M) as usize + 1 + SLOPE_STEPS;
        let mut depth_m = Vec::with_capacity(steps + 1);
        for step in 0..=steps {
            let place = look.at(from_m + step as f64 * RAY_STEP_M);
            if !bed.nodes.holds(place) || !bed.is_known[bed.nodes.nearest(place)] {
                break;
            }
            depth_m.push(bed.nodes.value_at(&bed.depth_m, place));
        }
        let mut most_m2: f64 = 0.0;
        let mut ray = Self {
            from_m,
            range_m: Vec::with_capacity(depth_m.len()),
            slope: Vec::with_capacity(depth_m.len()),
        };
        for step in 0..depth_m.len().saturating_sub(SLOPE_STEPS) {
            let ground_m = from_m + step as f64 * RAY_STEP_M;
            let altitude_m = depth_m[step] - look.transducer_m;
            if altitude_m < LEAST_ALTITUDE_M {
                break;
            }
            most_m2 = most_m2.max(ground_m * ground_m + altitude_m * altitude_m);
            // The ranges rise strictly, so that each range has one place.
            ray.range_m.push(most_m2.sqrt() + 1e-9 * step as f64);
            let from = step.saturating_sub(SLOPE_STEPS);
            let over_m = (step + SLOPE_STEPS - from) as f64 * RAY_STEP_M;
            ray.slope.push((depth_m[step + SLOPE_STEPS] - depth_m[from]) / over_m);
        }
        ray
    }
}

/// Averaged levels of a chunk of pings on one side: a look.
#[derive(Clone, Debug)]
pub(super) struct SideChunk {
    /// Index of the log, and number of the stretch in the log.
    pub stretch: (u32, u32),
    /// Index of the set of curves.
    pub curves: usize,
    /// Side of the boat: -1 is port, 1 is starboard.
    pub side: f64,
    /// Mean place of the pings, east and north, metres.
    pub place_m: [f64; 2],
    /// Unit vector outward, east and north.
    pub outward: [f64; 2],
    /// Mean depth of the transducer, metres.
    pub transducer_m: f64,
    /// Slant range of the middle of the first range, and length of each range, metres.
    pub first_m: f64,
    /// See `first_m`.
    pub step_m: f64,
    /// Number of independent samples in a range.
    pub independent: f64,
    /// Mean logarithm of power of each range less the gain; NaN where the range is not used.
    pub ln_power: Vec<f32>,
}

impl SideChunk {
    /// Returns the place at a ground range, east and north, metres.
    pub(super) fn at(&self, ground_m: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.place_m[axis] + ground_m * self.outward[axis])
    }

    /// Returns the ground ranges between which level cells may be within some nodes, metres; `None`
    /// where there are none.
    pub(super) fn ranges_within(&self, nodes: &Nodes) -> Option<[f64; 2]> {
        let last_m = self.first_m + self.step_m * self.ln_power.len() as f64;
        let [west_m, south_m, east_m, north_m] = nodes.bounds_m();
        let (mut from_m, mut to_m) = (NEAREST_M, last_m.min(FARTHEST_M));
        for (axis, [low_m, high_m]) in
            [[west_m, east_m], [south_m, north_m]].into_iter().enumerate()
        {
            // For a look along the other axis both ends are infinite: with the same sign outside
            // the bounds, with different signs inside.
            let ends =
                [low_m, high_m].map(|edge_m| (edge_m - self.place_m[axis]) / self.outward[axis]);
            from_m = from_m.max(ends[0].min(ends[1]));
            to_m = to_m.min(ends[0].max(ends[1]));
        }
        (from_m < to_m).then_some([from_m, to_m])
    }

    /// Calls `found` with the observations of the level cells of this look that are within some
    /// nodes; the nodes of the bed may reach farther. Without curves, expected levels and
    /// derivatives are 0.
    pub(super) fn read(
        &self,
        bed: &Bed,
        nodes: &Nodes,
        curves: Option<&LawCurves>,
        level_cell_m: f64,
        mut found: impl FnMut(SlopeObservation),
    ) {
        let Some(span_m) = self.ranges_within(nodes) else {
            return;
        };
        let ray = Ray::new(self, bed, span_m);
        let mut sums = [0.0; 10];
        let mut cell = 0;
        let mut step = 0;
        let [flattest, steepest] = [FLATTEST_DEG, STEEPEST_DEG].map(f64::to_radians);
        let mut finish = |sums: &mut [f64; 10]| {
            let observation = self.observation(std::mem::take(sums));
            observation
                .filter(|observation| nodes.holds(observation.place_m))
                .into_iter()
                .for_each(&mut found);
        };
        for (index, ln_power) in self.ln_power.iter().enumerate() {
            let range_m = self.first_m + index as f64 * self.step_m;
            while step + 1 < ray.range_m.len() && ray.range_m[step + 1] < range_m {
                step += 1;
            }
            let (Some(&[from, to]), Some(&[slope, next])) = (
                ray.range_m.get(step..step + 2).and_then(|pair| pair.first_chunk()),
                ray.slope.get(step..step + 2).and_then(|pair| pair.first_chunk()),
            ) else {
                break;
            };
            let share = (range_m - from) / (to - from);
            let ground_m = ray.from_m + (step as f64 + share) * RAY_STEP_M;
            if share < 0.0 || ln_power.is_nan() {
                continue;
            }
            let slope = slope + share * (next - slope);
            let phi_rad = (ground_m / range_m).min(1.0).asin();
            if phi_rad > flattest || phi_rad + slope.atan() < steepest {
                continue;
            }
            let here = (ground_m / level_cell_m) as usize;
            if here != cell {
                finish(&mut sums);
                cell = here;
            }
            let at = Incidence { range_m, phi_rad, slope, side: self.side };
            let brightness = bed.nodes.value_at(&bed.ln_brightness, self.at(ground_m));
            let ln_power = f64::from(*ln_power);
            let [over, share, per_slope, per_depth] = curves.map_or([0.0; 4], |curves| {
                let expected = curves.expected(&at, brightness);
                let over = ln_power - expected.ln_power;
                [over, expected.share, expected.per_slope, expected.per_depth]
            });
            let of_ground = [1.0, ground_m, range_m, phi_rad, slope, ln_power];
            let added = of_ground.into_iter().chain([over, share, per_slope, per_depth]);
            sums.iter_mut().zip(added).for_each(|(sum, value)| *sum += value);
        }
        finish(&mut sums);
    }

    /// Returns the observation of a level cell; `None` for too few samples.
    fn observation(&self, sums: [f64; 10]) -> Option<SlopeObservation> {
        let count = sums[0];
        let [_, ground_m, range_m, phi_rad, slope, ln_power, over, share, per_slope, per_depth] =
            sums.map(|sum| sum / count);
        let independent = count * self.independent;
        (independent >= LEAST_INDEPENDENT).then(|| SlopeObservation {
            over,
            ln_power,
            independent,
            at: Incidence { range_m, phi_rad, slope, side: self.side },
            share,
            per_slope,
            per_depth,
            place_m: self.at(ground_m),
        })
    }

    /// Creates the look of a side of a chunk, in ranges of `length_m` metres, or of one sample
    /// where samples are longer; `None` where nothing was recorded, or the boat turns.
    pub(super) fn new(
        log: &LaidOutLog<'_>,
        number: usize,
        chunk: &PingChunk,
        curves: usize,
        side: Side,
        ln_power: &[f32; 256],
        length_m: f64,
    ) -> Option<Self> {
        let law = log.law?;
        let pings = log.echoes.pings.get(chunk.pings.clone())?;
        let count = pings.len() as f64;
        let (mut place_m, mut outward, mut transducer_m) = ([0.0; 2], [0.0; 2], 0.0);
        for ping in pings {
            let out = ping.outward(side);
            for axis in 0..2 {
                place_m[axis] += ping.place_m[axis] / count;
                outward[axis] += out[axis] / count;
            }
            transducer_m += ping.transducer_m / count;
        }
        let straight = outward[0].hypot(outward[1]);
        let echoes = *pings.first()?.side(side);
        if !echoes.has_ranges() || straight.is_nan() || straight < LEAST_STRAIGHT {
            return None;
        }
        let each = ((length_m / echoes.step_m).round() as usize).max(1);
        let mut sums: Vec<(f32, u32, u32)> = Vec::new();
        let mut levels = Vec::new();
        for ping in chunk.pings.clone() {
            log.echoes.read(ping, side, &mut levels);
            sums.resize(sums.len().max(levels.len() / each), (0.0, 0, 0));
            for (part, sum) in levels.chunks_exact(each).zip(&mut sums) {
                for level in part {
                    sum.0 += ln_power[usize::from(*level)];
                    sum.1 += 1;
                    sum.2 += u32::from(*level == 0 || *level >= law.most_level);
                }
            }
        }
        let mean = |(sum, count, clipped): (f32, u32, u32)| {
            if f64::from(clipped) > MOST_CLIPPED * f64::from(count) {
                f32::NAN
            } else {
                sum / count as f32 - chunk.gain as f32
            }
        };
        Some(Self {
            stretch: (number as u32, chunk.stretch),
            curves,
            side: side.to_starboard(1.0),
            place_m,
            outward: outward.map(|part| part / straight),
            transducer_m,
            first_m: echoes.near_m + 0.5 * each as f64 * echoes.step_m,
            step_m: each as f64 * echoes.step_m,
            independent: (each * pings.len()) as f64 / law.grain_samples,
            // Collected anew, since the sums take three times the memory.
            ln_power: sums.iter().copied().map(mean).collect(),
        })
    }
}

/// Eighths of the circle from which a place is seen, with one bit for each.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SeenOctants(u8);

impl SeenOctants {
    /// Adds the direction of a look, a unit vector east and north.
    pub(super) fn add(&mut self, [east, north]: [f64; 2]) {
        let eighth = (east.atan2(north) / std::f64::consts::FRAC_PI_4).round() as i32;
        self.0 |= 1 << eighth.rem_euclid(8);
    }

    /// Returns true if the place is seen from any eighth.
    pub(super) fn is_any(&self) -> bool {
        self.0 != 0
    }

    /// Returns true if the place is seen from two eighths that are about opposite to each other.
    pub(super) fn are_two(&self) -> bool {
        [3, 4, 5].iter().any(|by| self.0 & self.0.rotate_left(*by) != 0)
    }
}
