//! Shapes of objects as heights over the ground they cover.

use super::hull::Hull;
use super::limbs::Limbs;
use super::random::{NoiseField, Random, RandomPurpose};
use super::scene::{ObjectKind, ObjectSettings};

/// The shape of one object, with what its seed has drawn.
pub(super) enum Shape {
    /// A rounded boulder with bumps.
    Rock(NoiseField),
    /// Steep sides, flat top.
    Block,
    /// A round section along the length.
    Cylinder,
    /// A ring.
    Tyre,
    /// A sunken boat.
    Hull(Hull),
    /// Round members: a log, a body.
    Limbs(Limbs),
}

/// Width of steep sides, metres: steep, but wide enough to be met by the rays.
pub(super) const SIDE_M: f64 = 0.04;

impl Shape {
    /// The shape of an object; the seed draws its bumps, branches or pose.
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

    /// Height as a share of the object's whole height at a place `along_m` and `across_m` from its
    /// centre, `offset` from it to the east and north.
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
            // The ring's middle lies at 0.7 of the outer radius, its half thickness is 0.3 of it.
            Shape::Tyre => round(((u * u + v * v).sqrt() - 0.7) / 0.3),
            Shape::Hull(hull) => hull.share(along_m, across_m, size_m, SIDE_M),
            Shape::Limbs(limbs) => limbs.share(along_m, across_m),
        }
    }
}

/// Upper half of a round section that touches the ground from above: 1 at the middle, 1/2 at the
/// widest, 0 beyond.
fn round(offset: f64) -> f64 {
    if offset.abs() >= 1.0 {
        return 0.0;
    }
    0.5 + 0.5 * (1.0 - offset * offset).sqrt()
}
