//! Samples the ground along the three rays of a side, with all objects on it or without one of
//! them.

use super::arithmetic::atan;
use super::listener::Listener;

/// The ground along the rays, one entry per step of the beam up to the shore or the end of the
/// range.
pub(super) struct Ground {
    /// Depth along the ray behind, the middle ray and the ray ahead, metres.
    pub depth_m: [Vec<f64>; 3],
    /// Two-way gain of the beam towards the ground.
    pub gain: Vec<f64>,
    /// Scattering strength along the middle ray, weakened under weed.
    pub strength: Vec<f64>,
    /// Depth under the boat, metres.
    pub under_boat_m: f64,
}

/// The ground without the objects on it, and the height of each object above it.
pub(super) struct Bare {
    /// Depth along the three rays, metres.
    depth_m: [Vec<f64>; 3],
    /// Scattering strength of the ground.
    strength: Vec<f64>,
    /// Share of an echo that is left under the weed over the ground.
    weed_loss: Vec<f64>,
    /// Depth under the boat, objects included, metres.
    under_boat_m: f64,
    /// Heights of the objects that the rays meet.
    pub heights: Vec<ObjectHeights>,
}

/// Heights of one object along the rays.
pub(super) struct ObjectHeights {
    /// Index of the object.
    pub object: usize,
    /// Index of each step of each ray that meets the object, and height of the object above the
    /// ground there, metres.
    height_m: [Vec<(usize, f64)>; 3],
}

/// Depth at which a ray ends at the shore, metres.
const SHORE_M: f64 = 0.05;

impl Listener<'_> {
    /// Samples the ground and the heights of `objects` along the three rays; `None` where the boat
    /// is on land.
    pub(super) fn bare(&self, objects: &[usize], reach_m: f64) -> Option<Bare> {
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
    pub(super) fn ground(&self, bare: &Bare, missing: Option<usize>) -> Ground {
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
