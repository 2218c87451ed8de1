//! Computes the shapes of objects, as heights above the ground that they cover.

use super::hull::Hull;
use super::limbs::Limbs;
use super::random::{NoiseField, Random, RandomPurpose};
use super::scene::{ObjectKind, ObjectSettings};

/// Shape of one object, with the random details drawn from its seed.
pub(super) enum Shape {
    /// A rounded boulder with bumps.
    Rock(NoiseField),
    /// A block with steep sides and a flat top.
    Block,
    /// A cylinder with a round section along the length.
    Cylinder,
    /// A tyre: a ring.
    Tyre,
    /// A sunken boat.
    Hull(Hull),
    /// A log or a body, made of round members.
    Limbs(Limbs),
}

/// Horizontal width of steep sides, metres, wide enough for the rays to meet them.
pub(super) const SIDE_M: f64 = 0.04;

impl Shape {
    /// Creates the shape of an object; `seed` determines its bumps, branches or pose.
    pub(super) fn new(object: &ObjectSettings, seed: u64) -> Self {
        let (length, width, height) = (object.length_m, object.width_m, object.height_m);
        let mut random = Random::new(seed, RandomPurpose::Shape, 0);
        match object.kind {
            ObjectKind::Rock => {
                Shape::Rock(NoiseField::new(seed, RandomPurpose::Bumps, 0.3 * length.min(width)))
            }
            ObjectKind::Block => Shape::Block,
            ObjectKind::Cylinder => Shape::Cylinder,
            ObjectKind::Tyre => Shape::Tyre,
            ObjectKind::Boat => Shape::Hull(Hull::new(&mut random)),
            ObjectKind::Log => Shape::Limbs(Limbs::log(length, width, height, &mut random)),
            ObjectKind::Effigy => Shape::Limbs(Limbs::body(length, width, height, &mut random)),
        }
    }

    /// Returns the height at a place as a share of the object's whole height. The place is
    /// `along_m` and `across_m` from the centre of the object; `offset` is the same offset to the
    /// east and north, metres.
    pub(super) fn share(
        &self,
        along_m: f64,
        across_m: f64,
        size_m: [f64; 2],
        offset: [f64; 2],
    ) -> f64 {
        let [length_m, width_m] = size_m;
        // Distances from the centre in half lengths and half widths.
        let (u, v) = (2.0 * along_m / length_m, 2.0 * across_m / width_m);
        match self {
            Shape::Rock(bumps) => {
                let bumpy = 1.0 + 0.12 * bumps.at(offset[0], offset[1]);
                bumpy * (1.0 - u * u - v * v).max(0.0).sqrt()
            }
            Shape::Block => {
                let inside = (0.5 * length_m - along_m.abs()).min(0.5 * width_m - across_m.abs());
                ((inside + SIDE_M) / SIDE_M).clamp(0.0, 1.0)
            }
            Shape::Cylinder if u.abs() > 1.0 => 0.0,
            Shape::Cylinder => round(v),
            // The middle of the ring is at 0.7 of the outer radius, its half thickness is 0.3 of
            // the radius.
            Shape::Tyre => round(((u * u + v * v).sqrt() - 0.7) / 0.3),
            Shape::Hull(hull) => hull.share(along_m, across_m, size_m, SIDE_M),
            Shape::Limbs(limbs) => limbs.share(along_m, across_m),
        }
    }
}

/// Returns the height of the upper half of a round section that lies on the ground: 1 at the
/// middle, 1/2 at the widest, 0 beyond.
fn round(offset: f64) -> f64 {
    if offset.abs() >= 1.0 {
        return 0.0;
    }
    0.5 + 0.5 * (1.0 - offset * offset).sqrt()
}
