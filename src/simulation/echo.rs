//! Computes the echo of the ground on one side of a ping: echo power by slant range, and the true
//! first return.
//!
//! The ground is followed outward in steps, along three rays that represent the width of the beam
//! along the track, with all objects on it and without each of them. A step is insonified if
//! nothing nearer hides it: on a height field a step is visible if its direction from the vertical
//! exceeds that of all steps before it. The echo of a step is spread over the range samples that it
//! covers, so that no step is missed, however short. Each side receives only its own half of the
//! ground, from the point under the boat outward.

use super::arithmetic::{atan, from_db};
use super::listener::{Beam, Listener, WeedBed, backscatter};

/// Echoes that one side of one ping received, before losses, gain and noise.
pub(super) struct Echo {
    /// `sum of sigma G^2 azimuth ds` of each range sample, square metres at 1 m; multiplied by
    /// `r^-3` and absorption this is the echo power.
    pub power: Vec<f64>,
    /// Slant range of the nearest ground in the plane across the boat's heading, metres; NaN where
    /// there is none.
    pub first_return_m: f64,
    /// Slant range of the nearest weed, metres; infinite without weed.
    pub canopy_m: f64,
    /// Objects that the middle ray insonifies.
    pub seen: Vec<ObjectEcho>,
    /// Index of each object in the beam, with `power` as it would be without the object.
    pub without: Vec<(usize, Vec<f64>)>,
}

/// Slant ranges of an object and its shadow in one ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ObjectEcho {
    /// Index of the object.
    pub object: usize,
    /// Slant range of the nearest point of the visible surface, metres.
    pub near_m: f64,
    /// Slant range of the farthest point of the visible surface, metres.
    pub far_m: f64,
    /// Slant range at which the ground behind the object is visible again, metres; NaN where the
    /// shadow extends beyond the range.
    pub shadow_end_m: f64,
    /// Height above the ground of the far edge of the visible surface, which casts the end of the
    /// shadow, metres.
    pub top_height_m: f64,
    /// Slant range at which the ground ends, visible or not: the recorded range or the shore,
    /// metres.
    pub reach_m: f64,
}

/// The ground along the rays, one entry per step of the beam up to the shore or the end of the
/// range.
struct Ground {
    /// Depth along the ray behind, the middle ray and the ray ahead, metres.
    depth_m: [Vec<f64>; 3],
    /// Two-way gain of the beam towards the ground.
    gain: Vec<f64>,
    /// Scattering strength along the middle ray, weakened under weed.
    strength: Vec<f64>,
    /// Depth under the boat, metres.
    under_boat_m: f64,
}

/// The ground without the objects on it, and the height of each object above it.
struct Bare {
    /// Depth along the three rays, metres.
    depth_m: [Vec<f64>; 3],
    /// Scattering strength of the ground.
    strength: Vec<f64>,
    /// Share of an echo that is left under the weed over the ground.
    weed_loss: Vec<f64>,
    /// Depth under the boat, objects included, metres.
    under_boat_m: f64,
    /// Heights of the objects that the rays meet.
    heights: Vec<ObjectHeights>,
}

/// Heights of one object along the rays.
struct ObjectHeights {
    /// Index of the object.
    object: usize,
    /// Index of each step of each ray that meets the object, and height of the object above the
    /// ground there, metres.
    height_m: [Vec<(usize, f64)>; 3],
}

/// Depth at which a ray ends at the shore, metres.
const SHORE_M: f64 = 0.05;
/// Scattering strength of weed, dB per square metre.
const WEED_DB: f64 = -18.0;

impl Listener<'_> {
    /// Computes the echo that this side receives.
    pub(super) fn receive(&self) -> Echo {
        let mut echo = Echo {
            power: vec![0.0; self.samples],
            first_return_m: f64::NAN,
            canopy_m: f64::INFINITY,
            seen: Vec::new(),
            without: Vec::new(),
        };
        let reach_m = self.samples as f64 * self.metres_per_sample;
        let widest_m = self.beam.outer_ray_m(reach_m, reach_m);
        let objects = self.world.objects_across(self.pose, widest_m, reach_m);
        let Some(bare) = self.bare(&objects, reach_m) else {
            return echo;
        };
        let ground = self.ground(&bare, None);
        echo.first_return_m = self.nearest(&ground.depth_m[1]);
        echo.canopy_m = self.sound(&ground, reach_m, &mut echo.power);
        let visible = self.visible_steps(&ground.depth_m[1]);
        let ground_end_m = self.last_step_m(&ground.depth_m[1]).min(reach_m);
        for object in objects {
            echo.seen.extend(self.look_for(object, &visible, ground_end_m));
        }
        for above in &bare.heights {
            let mut power = vec![0.0; self.samples];
            self.sound(&self.ground(&bare, Some(above.object)), reach_m, &mut power);
            echo.without.push((above.object, power));
        }
        echo
    }

    /// Adds the echoes of the ground and of weed to `power`; returns the slant range of the nearest
    /// weed, metres, infinite without weed.
    fn sound(&self, ground: &Ground, reach_m: f64, power: &mut [f64]) -> f64 {
        for ray in 0..3 {
            self.scatter(ground, ray, power);
        }
        let weed = self.world.weed.iter();
        let canopies = weed.map(|weed| self.weed_echo_m(weed, &ground.depth_m[1], reach_m, power));
        canopies.fold(f64::INFINITY, f64::min)
    }

    fn nearest(&self, depth_m: &[f64]) -> f64 {
        let squares = depth_m.iter().zip(&self.beam.steps_m);
        let nearest = squares.map(|(d, y)| d * d + y * y).fold(f64::INFINITY, f64::min);
        nearest.sqrt()
    }

    /// Adds the echo of the visible steps of one ray to `power`.
    fn scatter(&self, ground: &Ground, ray: usize, power: &mut [f64]) {
        let steps = &self.beam.steps_m;
        let weight = Beam::RAY_WEIGHTS[ray] * self.beam.azimuth_rad;
        let [behind, _, ahead] = &ground.depth_m;
        let depth_m = &ground.depth_m[ray];
        // Tangent of the largest angle from the vertical at which ground was visible so far.
        let mut horizon = 0.0;
        for j in 1..depth_m.len() {
            let (d0, d1, y0, y1) = (depth_m[j - 1], depth_m[j], steps[j - 1], steps[j]);
            let (t0, t1) = (y0 / d0, y1 / d1);
            if t1 <= horizon {
                continue;
            }
            let visible = if t0 >= horizon { 1.0 } else { (t1 - horizon) / (t1 - t0) };
            horizon = t1;
            let (y, d, step) = (0.5 * (y0 + y1), 0.5 * (d0 + d1), y1 - y0);
            let across = (d1 - d0) / step;
            let along =
                (ahead[j] - behind[j]) / (2.0 * self.beam.outer_ray_m(y, ground.under_boat_m));
            // The slope's normal is (-across, -along, 1) / stretch; its product with the direction
            // is cos th.
            let stretch = (1.0 + across * across + along * along).sqrt();
            let facing = (d - y * across).max(0.0) / stretch;
            let sigma =
                backscatter(facing * facing / (y * y + d * d), self.world.bed.scatter_power);
            let gain = 0.5 * (ground.gain[j - 1] + ground.gain[j]);
            let amount = sigma * ground.strength[j] * gain * weight * step * stretch * visible;
            let range = |y: f64, d: f64| (y * y + d * d).sqrt();
            self.spread_over(range(y0, d0), range(y1, d1), amount, power);
        }
    }

    /// Spreads power evenly over the samples between two slant ranges, metres.
    fn spread_over(&self, from_m: f64, to_m: f64, amount: f64, power: &mut [f64]) {
        let sample = |range_m: f64| (range_m + self.range_offset_m) / self.metres_per_sample;
        let (from, to) = (sample(from_m.min(to_m)).max(0.0), sample(from_m.max(to_m)));
        if to < 0.0 {
            return;
        }
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

    /// Returns the distance from the track and the slant range of the visible steps of the middle
    /// ray, metres.
    fn visible_steps(&self, depth_m: &[f64]) -> Vec<[f64; 2]> {
        let mut horizon = 0.0;
        let mut visible = Vec::new();
        for (&depth, &across) in depth_m.iter().zip(&self.beam.steps_m) {
            if across / depth >= horizon {
                horizon = across / depth;
                visible.push([across, (across * across + depth * depth).sqrt()]);
            }
        }
        visible
    }

    /// Returns the slant range of the farthest step, metres.
    fn last_step_m(&self, depth_m: &[f64]) -> f64 {
        let mut steps = depth_m.iter().zip(&self.beam.steps_m);
        let last = steps.next_back().map(|(d, y)| (d * d + y * y).sqrt());
        last.unwrap_or(0.0)
    }

    /// Finds the slant ranges at which the middle ray meets an object, and at which the shadow of
    /// the object ends; `None` where the object is not visible to the ray.
    fn look_for(&self, object: usize, visible: &[[f64; 2]], reach_m: f64) -> Option<ObjectEcho> {
        let placed = &self.world.objects[object];
        let mut found: Option<ObjectEcho> = None;
        for &[across, range] in visible {
            let [east, north] = self.place(across, 0.0);
            let height_m = placed.height_m(east, north);
            if height_m > 0.0 {
                let seen = found.get_or_insert(ObjectEcho {
                    object,
                    near_m: range,
                    far_m: range,
                    shadow_end_m: f64::NAN,
                    top_height_m: height_m,
                    reach_m,
                });
                seen.near_m = seen.near_m.min(range);
                seen.far_m = seen.far_m.max(range);
                seen.shadow_end_m = f64::NAN;
                seen.top_height_m = height_m;
            } else if let Some(seen) = &mut found
                && seen.shadow_end_m.is_nan()
            {
                seen.shadow_end_m = range;
            }
        }
        found
    }

    /// Adds the echo of a bed of weed to `power`; returns the slant range of its nearest leaves,
    /// metres, infinite where the beam does not meet it.
    fn weed_echo_m(&self, weed: &WeedBed, depth_m: &[f64], reach_m: f64, power: &mut [f64]) -> f64 {
        let mut canopy_m = f64::INFINITY;
        if !weed.is_near(self.pose.east_m, self.pose.north_m, reach_m) {
            return canopy_m;
        }
        let steps = self.beam.steps_m.windows(2).zip(depth_m.iter().skip(1));
        for (step, &depth) in steps {
            let across = step[1];
            let [east, north] = self.place(across, 0.0);
            let height = weed.height_m(east, north);
            if height <= 0.0 {
                continue;
            }
            let range = |depth: f64| (across * across + depth * depth).sqrt();
            let (top, foot) = (range(depth - height), range(depth));
            canopy_m = canopy_m.min(top);
            let gain = self.beam.two_way_gain(atan(across / depth) + self.roll_rad);
            let strength = from_db(WEED_DB) * weed.density(east, north);
            let amount = strength * gain * self.beam.azimuth_rad * (across - step[0]);
            // Most of the sound is returned by the upper third of the leaves.
            self.spread_over(top, top + (foot - top) / 3.0, 0.8 * amount, power);
            self.spread_over(top, foot, 0.2 * amount, power);
        }
        canopy_m
    }

    /// Samples the ground and the heights of `objects` along the three rays; `None` where the boat
    /// is on land.
    fn bare(&self, objects: &[usize], reach_m: f64) -> Option<Bare> {
        let under_boat_m = self.world.depth_m(self.pose.east_m, self.pose.north_m);
        if under_boat_m <= SHORE_M {
            return None;
        }
        let steps = || (self.beam.steps_m.iter()).take_while(|&&across_m| across_m <= reach_m);
        let places = [-1.0, 0.0, 1.0].map(|ray| {
            let place = |&across_m: &f64| {
                let along_m = ray * self.beam.outer_ray_m(across_m, under_boat_m);
                self.place(across_m, along_m)
            };
            steps().map(place).collect::<Vec<[f64; 2]>>()
        });
        let depth_m = places.each_ref().map(|places| {
            let depths = (places.iter()).map(|&[east, north]| self.world.bed.depth_m(east, north));
            (depths.take_while(|&depth| depth > SHORE_M)).collect::<Vec<f64>>()
        });
        let ground = places[1].iter().take(depth_m[1].len());
        Some(Bare {
            strength: (ground.clone())
                .map(|&[east, north]| self.world.bed.strength(east, north))
                .collect(),
            weed_loss: ground.map(|&[east, north]| self.world.weed_loss(east, north)).collect(),
            heights: (objects.iter())
                .filter_map(|&object| self.heights_of(object, &places))
                .collect(),
            depth_m,
            under_boat_m,
        })
    }

    /// Returns the heights of an object along the rays; `None` where no ray meets it.
    fn heights_of(&self, object: usize, places: &[Vec<[f64; 2]>; 3]) -> Option<ObjectHeights> {
        let placed = &self.world.objects[object];
        let height_m = places.each_ref().map(|places| {
            let heights = (places.iter()).map(|&[east, north]| placed.height_m(east, north));
            (heights.enumerate())
                .filter(|&(_, height_m)| height_m > 0.0)
                .collect::<Vec<(usize, f64)>>()
        });
        (height_m.iter().any(|ray| !ray.is_empty())).then_some(ObjectHeights { object, height_m })
    }

    /// Returns the ground with the objects on it, except for `missing`.
    fn ground(&self, bare: &Bare, missing: Option<usize>) -> Ground {
        let mut depth_m = bare.depth_m.clone();
        let mut strength = bare.strength.clone();
        let heights = || (bare.heights.iter()).filter(|above| Some(above.object) != missing);
        for (ray, depths) in depth_m.iter_mut().enumerate() {
            // Where objects overlap, the higher one counts.
            for &(step, height_m) in heights().flat_map(|above| &above.height_m[ray]) {
                if let (Some(depth), Some(bed)) =
                    (depths.get_mut(step), bare.depth_m[ray].get(step))
                {
                    *depth = depth.min(bed - height_m);
                }
            }
            let wet = depths.iter().position(|&depth| depth <= SHORE_M);
            depths.truncate(wet.unwrap_or(depths.len()));
        }
        let count = depth_m.iter().map(Vec::len).min().unwrap_or(0);
        depth_m.iter_mut().for_each(|ray| ray.truncate(count));
        strength.truncate(count);
        // Where two objects overlap, the strength is that of the first.
        for above in heights().collect::<Vec<&ObjectHeights>>().into_iter().rev() {
            for &(step, _) in &above.height_m[1] {
                if let Some(strength) = strength.get_mut(step) {
                    *strength = self.world.objects[above.object].strength;
                }
            }
        }
        let losses = strength.iter_mut().zip(&bare.weed_loss);
        losses.for_each(|(strength, loss)| *strength *= loss);
        let towards = |(&across, depth): (&f64, &f64)| {
            self.beam.two_way_gain(atan(across / depth) + self.roll_rad)
        };
        Ground {
            gain: (self.beam.steps_m.iter().zip(&depth_m[1])).map(towards).collect(),
            strength,
            depth_m,
            under_boat_m: bare.under_boat_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::bed::SceneBed;
    use crate::listener::World;
    use crate::path::BoatPose;
    use bathyscope_log::survey::Side;

    /// Computes the starboard echo of level ground 3 m deep, with samples of 1 cm.
    fn level_echo() -> Echo {
        let mut scene = Scene::gentle();
        scene.bed.mean_depth_m = 3.0;
        let world =
            World { bed: SceneBed::level(&scene.bed), objects: Vec::new(), weed: Vec::new() };
        let beam = Beam::new(&scene.recorder, 12.0);
        let pose = BoatPose { east_m: 0.0, north_m: 0.0, heading_rad: 0.0 };
        let listener = Listener {
            world: &world,
            beam: &beam,
            pose,
            forward: pose.forward(),
            side: Side::Starboard,
            roll_rad: 0.0,
            metres_per_sample: 0.01,
            range_offset_m: 0.0,
            samples: 1200,
        };
        listener.receive()
    }

    /// Returns the echo of level ground between two slant ranges, by integrating the scattering law
    /// over the ground.
    fn integral(depth: f64, from_m: f64, to_m: f64) -> f64 {
        let ground = |range: f64| (range * range - depth * depth).max(0.0).sqrt();
        let (y0, y1) = (ground(from_m), ground(to_m));
        let pieces = 2000;
        let width = (y1 - y0) / f64::from(pieces);
        let piece = |index| {
            let y = y0 + (f64::from(index) + 0.5) * width;
            let theta = (y / depth).atan();
            let normal = (theta.tan() / 7f64.to_radians().tan()).powi(2);
            let sigma =
                10f64.powf(-2.7) * theta.cos().powi(2) + 10f64.powf(-1.2) * (-0.5 * normal).exp();
            let off = (theta.to_degrees() - 45.0) / 29.0;
            let gain = 0.5f64.powf(off * off);
            sigma * gain * gain * 0.9f64.to_radians() * width
        };
        (0..pieces).map(piece).sum()
    }

    #[test]
    fn level_ground_echoes_as_the_scattering_law_integrates() {
        let echo = level_echo();
        for first in [300, 301, 305, 320, 360, 450, 700, 1100] {
            let ours = echo.power[first..first + 5].iter().sum::<f64>();
            let from = first as f64 * 0.01;
            let theirs = integral(3.0, from, from + 0.05);
            assert!((ours / theirs - 1.0).abs() < 0.01, "{first}: {ours} {theirs}");
        }
        assert_eq!(echo.power[..300].iter().sum::<f64>(), 0.0);
        assert!((echo.first_return_m - 3.0).abs() < 1e-12);
    }
}
