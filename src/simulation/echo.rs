//! What one side of a ping hears of the ground: echo power by slant range, and the true first return.
//!
//! The ground is followed outward in steps, along three directions that stand for the width of the beam along the track
//! (Gauss-Hermite nodes: 0 and +-1.73 standard deviations, with weights 2/3 and 1/6). A step is heard as far as nothing
//! nearer hides it: on a height field it is visible iff its direction from the vertical exceeds that of all steps
//! before it. Steps are spread over the range samples that they cover, so a sample is never missed however short it is.
//!
//! Scattering per unit of area (Mackenzie's -27 dB with Lambert's law, and near-normal facets of 7 degrees):
//! `sigma = 10^-2.7 cos^2 th + 10^-1.2 exp(-tan^2 th / (2 tan^2 7 deg))`.
//! Beam, one way: `G = 2^-((phi - axis) / half width)^2`, with `phi` the angle from the vertical. Each side hears only its
//! own half of the ground, from the point under the boat outward.

use super::arithmetic::{atan, exp, from_db};
use super::bed::Bed;
use super::objects::Placed;
use super::path::Pose;
use super::scene::RecorderSettings;
use super::weed::Weed;
use crate::survey::Side;
use std::f64::consts::{FRAC_PI_2, LN_2};

/// The ground with all that lies and grows on it.
pub struct World {
    pub bed: Bed,
    pub objects: Vec<Placed>,
    pub weed: Option<Weed>,
}

impl World {
    /// Depth of the visible ground (objects included, weed not) below the water surface, metres.
    pub fn depth_m(&self, east_m: f64, north_m: f64) -> f64 {
        let objects = self
            .objects
            .iter()
            .map(|object| object.height_m(east_m, north_m));
        self.bed.depth_m(east_m, north_m) - objects.fold(0.0, f64::max)
    }
}

/// The side beam in numbers that the rays need.
pub struct Beam {
    /// Angle of the axis from the vertical, radians.
    axis_rad: f64,
    half_width_rad: f64,
    /// Half-power width along the track, radians.
    azimuth_rad: f64,
    /// Distance along the track of the outer rays, per metre of distance to the ground.
    spread: f64,
    /// Distances of the steps from the track, metres.
    steps_m: Vec<f64>,
}

/// First step, metres, and its growth per metre of distance.
const STEP_M: (f64, f64) = (0.012, 0.002);
/// Depth at which the ray has reached the shore, metres.
const SHORE_M: f64 = 0.05;
/// Weights of the three rays along the track.
const RAY_WEIGHTS: [f64; 3] = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];

impl Beam {
    /// The beam of a recorder that listens up to `range_m`.
    pub fn new(recorder: &RecorderSettings, range_m: f64) -> Self {
        let azimuth_rad = recorder.beam_azimuth_deg.to_radians();
        let mut steps_m = vec![0.0];
        let mut at = 0.0;
        while at < range_m {
            at += STEP_M.0 + STEP_M.1 * at;
            steps_m.push(at);
        }
        Self {
            axis_rad: FRAC_PI_2 - recorder.beam_axis_deg.to_radians(),
            half_width_rad: 0.5 * recorder.beam_width_deg.to_radians(),
            azimuth_rad,
            spread: 3f64.sqrt() * azimuth_rad / 2.355,
            steps_m,
        }
    }

    /// Two-way gain in a direction from the vertical.
    fn two_way_gain(&self, phi_rad: f64) -> f64 {
        let off = (phi_rad - self.axis_rad) / self.half_width_rad;
        exp(-2.0 * LN_2 * off * off)
    }
}

/// What one side of one ping heard, before losses, gain and noise.
pub struct Echo {
    /// `sum of sigma G^2 azimuth ds` of each range sample, square metres at 1 m; times `r^-3` and absorption it is power.
    pub power: Vec<f64>,
    /// Slant range of the nearest ground in the plane across the boat's heading, metres; NaN where there is none.
    pub first_return_m: f64,
    /// Slant range of the nearest weed, metres; infinite without any.
    pub canopy_m: f64,
    /// Objects heard.
    pub seen: Vec<Seen>,
}

/// An object as one ping heard it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Index of the object.
    pub object: usize,
    /// Nearest and farthest slant range of its visible surface, metres.
    pub near_m: f64,
    /// See `near_m`.
    pub far_m: f64,
    /// Slant range at which the ground behind it is seen again, metres; NaN when its shadow runs off the range.
    pub shadow_end_m: f64,
}

/// One listening side at one place.
pub struct Listener<'a> {
    pub world: &'a World,
    pub beam: &'a Beam,
    pub pose: Pose,
    pub side: Side,
    /// Roll towards this side, radians: the beam looks that much deeper.
    pub roll_rad: f64,
    pub metres_per_sample: f64,
    pub samples: usize,
}

/// The ground along one ray.
struct Ray {
    depth_m: Vec<f64>,
}

impl Listener<'_> {
    /// Follows the ground outward.
    pub fn hear(&self) -> Echo {
        let mut echo = Echo {
            power: vec![0.0; self.samples],
            first_return_m: f64::NAN,
            canopy_m: f64::INFINITY,
            seen: Vec::new(),
        };
        let reach_m = self.samples as f64 * self.metres_per_sample;
        let under_boat_m = self.world.depth_m(self.pose.east_m, self.pose.north_m);
        if under_boat_m <= SHORE_M {
            return echo;
        }
        let near = self.objects_within(reach_m);
        let rays = [-1.0, 0.0, 1.0].map(|ray| self.follow(ray, under_boat_m, reach_m, &near));
        let count = rays.iter().map(|ray| ray.depth_m.len()).min().unwrap_or(0);
        echo.first_return_m = self.nearest(&rays[1].depth_m);
        let gains = self.gains(&rays[1].depth_m[..count]);
        let strengths = self.strengths(count);
        for (index, ray) in rays.iter().enumerate() {
            let weight = RAY_WEIGHTS[index] * self.beam.azimuth_rad;
            self.scatter(
                ray,
                &rays,
                under_boat_m,
                weight,
                &gains,
                &strengths,
                &mut echo.power,
            );
        }
        self.look_for_objects(&rays[1].depth_m, &near, &mut echo.seen);
        self.hear_weed(&rays[1].depth_m, reach_m, &mut echo);
        echo
    }

    /// The place `across_m` to this side and `along_m` ahead of the boat.
    fn place(&self, across_m: f64, along_m: f64) -> [f64; 2] {
        let [east, north] = self.pose.forward();
        let across_m = match self.side {
            Side::Starboard => across_m,
            Side::Port => -across_m,
        };
        [
            self.pose.east_m + along_m * east + across_m * north,
            self.pose.north_m + along_m * north - across_m * east,
        ]
    }

    /// Objects that the rays may meet.
    fn objects_within(&self, reach_m: f64) -> Vec<usize> {
        let [east, north] = self.pose.forward();
        let widest = reach_m * self.beam.spread;
        let objects = self.world.objects.iter().enumerate();
        let met = objects.filter(|(_, object)| {
            let (de, dn) = (
                object.settings.east_m - self.pose.east_m,
                object.settings.north_m - self.pose.north_m,
            );
            let along = de * east + dn * north;
            let across = de * north - dn * east;
            along.abs() <= object.reach_m + widest && across.abs() <= reach_m + object.reach_m
        });
        met.map(|(index, _)| index).collect()
    }

    /// Depths along one of the three rays (-1, 0, 1), as far as there is water and range.
    fn follow(&self, ray: f64, under_boat_m: f64, reach_m: f64, near: &[usize]) -> Ray {
        let mut depth_m = Vec::with_capacity(self.beam.steps_m.len());
        for &across in &self.beam.steps_m {
            let along = ray * self.outer_ray_m(across, under_boat_m);
            let [e, n] = self.place(across, along);
            let mut depth = self.world.bed.depth_m(e, n);
            for &object in near {
                depth -= self.world.objects[object].height_m(e, n);
            }
            if depth <= SHORE_M || across > reach_m {
                break;
            }
            depth_m.push(depth);
        }
        Ray { depth_m }
    }

    /// Distance along the track between the middle and an outer ray, metres.
    fn outer_ray_m(&self, across_m: f64, under_boat_m: f64) -> f64 {
        self.beam.spread * (across_m * across_m + under_boat_m * under_boat_m).sqrt()
    }

    fn nearest(&self, depth_m: &[f64]) -> f64 {
        let squares = depth_m.iter().zip(&self.beam.steps_m);
        let nearest = squares
            .map(|(d, y)| d * d + y * y)
            .fold(f64::INFINITY, f64::min);
        nearest.sqrt()
    }

    /// Two-way beam gain towards each step.
    fn gains(&self, depth_m: &[f64]) -> Vec<f64> {
        let steps = depth_m.iter().zip(&self.beam.steps_m);
        steps
            .map(|(depth, across)| self.beam.two_way_gain(atan(across / depth) + self.roll_rad))
            .collect()
    }

    /// Scattering strength of the ground at each step.
    fn strengths(&self, count: usize) -> Vec<f64> {
        let steps = self.beam.steps_m.iter().take(count);
        steps
            .map(|&across| {
                let [e, n] = self.place(across, 0.0);
                let weed = self.world.weed.as_ref();
                let shaded = weed.is_some_and(|weed| weed.height_m(e, n) > 0.0);
                let loss = if shaded { WEED_LOSS } else { 1.0 };
                self.world.bed.strength(e, n) * loss
            })
            .collect()
    }

    /// Adds the echo of one ray's visible steps.
    fn scatter(
        &self,
        ray: &Ray,
        rays: &[Ray; 3],
        under_boat_m: f64,
        weight: f64,
        gains: &[f64],
        strengths: &[f64],
        power: &mut [f64],
    ) {
        let steps = &self.beam.steps_m;
        let mut horizon = 0.0;
        let mut range = ray.depth_m.first().copied().unwrap_or(0.0);
        for j in 1..gains.len() {
            let (d0, d1) = (ray.depth_m[j - 1], ray.depth_m[j]);
            let (y0, y1) = (steps[j - 1], steps[j]);
            let (t0, t1) = (y0 / d0, y1 / d1);
            let before = range;
            range = (y1 * y1 + d1 * d1).sqrt();
            if t1 <= horizon {
                continue;
            }
            let visible = if t0 >= horizon {
                1.0
            } else {
                (t1 - horizon) / (t1 - t0)
            };
            horizon = t1;
            let step = y1 - y0;
            let slope_across = (d1 - d0) / step;
            let slope_along = (rays[2].depth_m[j] - rays[0].depth_m[j])
                / (2.0 * self.outer_ray_m(y1, under_boat_m));
            let stretch = 1.0 + slope_across * slope_across + slope_along * slope_along;
            let (y, d) = (0.5 * (y0 + y1), 0.5 * (d0 + d1));
            let cos_squared = {
                let facing = (d - y * slope_across).max(0.0);
                facing * facing / ((y * y + d * d) * stretch)
            };
            let area = step * stretch.sqrt() * visible;
            let echo = backscatter(cos_squared) * strengths[j] * gains[j] * weight * area;
            self.spread_over(before, range, echo, power);
        }
    }

    /// Spreads power evenly over the samples between two slant ranges.
    fn spread_over(&self, from_m: f64, to_m: f64, amount: f64, power: &mut [f64]) {
        let from = from_m.min(to_m) / self.metres_per_sample;
        let to = from_m.max(to_m) / self.metres_per_sample;
        let (first, last) = (from as usize, to as usize);
        if first == last {
            if let Some(sample) = power.get_mut(first) {
                *sample += amount;
            }
            return;
        }
        let per_sample = amount / (to - from);
        let end = (last + 1).min(power.len());
        for (index, sample) in power[first.min(end)..end].iter_mut().enumerate() {
            let low = (first + index) as f64;
            *sample += per_sample * ((low + 1.0).min(to) - low.max(from));
        }
    }

    /// Notes which objects the middle ray sees, and where their shadows end.
    fn look_for_objects(&self, depth_m: &[f64], near: &[usize], seen: &mut Vec<Seen>) {
        for &object in near {
            let placed = &self.world.objects[object];
            let mut found: Option<Seen> = None;
            let mut horizon = 0.0;
            for (&depth, &across) in depth_m.iter().zip(&self.beam.steps_m) {
                let visible = across / depth >= horizon;
                if !visible {
                    continue;
                }
                horizon = across / depth;
                let range = (across * across + depth * depth).sqrt();
                let [e, n] = self.place(across, 0.0);
                if placed.height_m(e, n) > 0.0 {
                    let sighting = found.get_or_insert(Seen {
                        object,
                        near_m: range,
                        far_m: range,
                        shadow_end_m: f64::NAN,
                    });
                    sighting.near_m = sighting.near_m.min(range);
                    sighting.far_m = sighting.far_m.max(range);
                } else if let Some(sighting) = &mut found
                    && sighting.shadow_end_m.is_nan()
                {
                    sighting.shadow_end_m = range;
                }
            }
            seen.extend(found);
        }
    }

    /// Adds the weed's echo.
    fn hear_weed(&self, depth_m: &[f64], reach_m: f64, echo: &mut Echo) {
        let Some(weed) = &self.world.weed else {
            return;
        };
        if !weed.is_near(self.pose.east_m, self.pose.north_m, reach_m) {
            return;
        }
        for j in 1..depth_m.len() {
            let across = self.beam.steps_m[j];
            let [e, n] = self.place(across, 0.0);
            let height = weed.height_m(e, n);
            if height <= 0.0 {
                continue;
            }
            let range = |depth: f64| (across * across + depth * depth).sqrt();
            let (top, foot) = (range(depth_m[j] - height), range(depth_m[j]));
            echo.canopy_m = echo.canopy_m.min(top);
            let gain = self
                .beam
                .two_way_gain(atan(across / depth_m[j]) + self.roll_rad);
            let area = across - self.beam.steps_m[j - 1];
            let strength = from_db(WEED_DB) * weed.density(e, n);
            let amount = strength * gain * self.beam.azimuth_rad * area;
            // Most of the sound comes back from the upper third of the leaves.
            self.spread_over(top, top + (foot - top) / 3.0, 0.8 * amount, &mut echo.power);
            self.spread_over(top, foot, 0.2 * amount, &mut echo.power);
        }
    }
}

/// Scattering strength of weed, dB per square metre.
const WEED_DB: f64 = -16.0;
/// What is left of the echo of the ground under weed (6 dB lost, both ways).
const WEED_LOSS: f64 = 0.25;

/// Scattering per unit of area at an angle of incidence given by the square of its cosine.
fn backscatter(cos_squared: f64) -> f64 {
    /// 10^-2.7, 10^-1.2 and 2 tan^2(7 degrees).
    const LAMBERT: f64 = 1.995_262_3e-3;
    const NORMAL: f64 = 6.309_573_4e-2;
    const FACETS: f64 = 2.0 * 0.122_784_56 * 0.122_784_56;
    if cos_squared <= 0.0 {
        return 0.0;
    }
    let tan_squared = (1.0 - cos_squared) / cos_squared;
    let normal = if tan_squared < 0.5 {
        NORMAL * exp(-tan_squared / FACETS)
    } else {
        0.0
    };
    LAMBERT * cos_squared + normal
}
