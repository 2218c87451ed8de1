//! Derives the beginnings of a search from the box of an object.

use super::levels::BoxLevels;
use super::problem::{DARKNESS, Numbers, OF_LOOK, STRENGTH};
use super::solid::ShapeKind;
use crate::targets::Target;
use std::f64::consts::{PI, TAU};

/// Headings that are tried at first over half a circle.
const HEADINGS: usize = 8;
/// Distances outward from the box's place at which a search begins, in shares of the box.
const OUTWARD: [f64; 3] = [-0.15, 0.0, 0.15];

/// Logarithm of the ratio of two steepnesses from which on a search begins with both.
const STEEPNESS_APART: f64 = 0.3;

/// Prior estimate of an object from one of its boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct InitialGuess {
    /// Its place, metres east and north.
    pub(super) place_m: [f64; 2],
    /// Direction of the track, radians clockwise from north.
    pub(super) heading_rad: f64,
    /// Extents along and across the track, metres.
    pub(super) along_m: f64,
    pub(super) across_m: f64,
    /// Extent of the box across the track on a level bottom, its shadow included, metres.
    pub(super) box_m: f64,
    /// Unit vector across the track to the side of the look, east and north.
    pub(super) outward: [f64; 2],
    /// Height, metres; NaN where no shadow is seen.
    pub(super) height_m: f64,
}

impl InitialGuess {
    /// Creates the estimate from a box that is placed, and its look.
    pub(super) fn of(target: &Target, look: &BoxLevels) -> Self {
        Self {
            place_m: [target.east_m, target.north_m],
            heading_rad: target.heading_rad,
            along_m: target.length_m,
            across_m: target.width_m,
            box_m: look.across_m(),
            outward: look.pings.first().map_or([0.0; 2], |ping| ping.outward),
            height_m: height_m(target),
        }
    }

    /// The numbers of a look to begin with.
    pub(super) fn of_look(&self) -> [f64; OF_LOOK] {
        let [east_m, north_m] = self.place_m;
        [east_m, north_m, STRENGTH[0], DARKNESS, 0.0]
    }
}

/// The height to begin with: that of the object, or that of the shadow in the middle of the box
/// where it is not whole enough to tell one.
fn height_m(target: &Target) -> f64 {
    let in_middle_m = || {
        let [start_m, end_m] = target.parts?.shadow_m?;
        Some(target.altitude_m * (end_m - start_m) / end_m)
    };
    if target.height_m.is_finite() { target.height_m } else { in_middle_m().unwrap_or(f64::NAN) }
}

/// Sizes and poses to begin with: of a typical slenderness, as long as the extents along the track,
/// across it, or both say, and in the middle of the picture or a little nearer or farther.
pub(super) fn beginnings(kind: ShapeKind, start: &InitialGuess) -> Vec<Numbers> {
    let usual = kind.usual();
    let slenderness = usual.typical_slenderness;
    let headings = match kind {
        ShapeKind::Tyre => 1,
        _ if kind.is_boat() => 2 * HEADINGS,
        _ => HEADINGS,
    };
    let turn_rad = if kind.is_boat() { TAU } else { PI };
    let mut all = Vec::new();
    for heading in 0..headings {
        let off_rad = turn_rad * heading as f64 / headings as f64;
        let (sin, cos) = (off_rad.sin().abs(), off_rad.cos().abs());
        let by_along_m = start.along_m.max(0.2) / (cos + sin / slenderness);
        let by_across_m = start.across_m.max(0.1) / (sin + cos / slenderness);
        // Of a box half is shadow, more or less.
        let by_box_m = 0.6 * start.box_m / (sin + cos / slenderness);
        let both_m = (by_along_m * by_across_m).sqrt();
        for length_m in [by_along_m, by_across_m, both_m, by_box_m] {
            let length_m = length_m.clamp(usual.length_m[0], usual.length_m[1]);
            let heading_rad = start.heading_rad + off_rad;
            let steepnesses = steepnesses(kind, start.height_m * slenderness / length_m);
            for (steepness, out) in steepnesses.flat_map(|one| OUTWARD.map(|out| (one, out))) {
                let sizes = [length_m.ln(), slenderness.ln(), steepness.ln()];
                let mut of_look = start.of_look();
                let out_m = out * start.box_m;
                of_look[0] += out_m * start.outward[0];
                of_look[1] += out_m * start.outward[1];
                all.push([&[heading_rad], &sizes[..], &[0.0], &of_look].concat());
            }
        }
    }
    all
}

/// Steepnesses to begin with: that of the shadow, where it is known. The shadow of a boat may be
/// that of a thwart or of one end, so a search for one begins with a usual steepness as well.
fn steepnesses(kind: ShapeKind, by_shadow: f64) -> impl Iterator<Item = f64> {
    let [low, high] = kind.usual().steepness;
    let usual = (low * high).sqrt();
    let known = (by_shadow > 0.0).then(|| by_shadow.clamp(low, high));
    let is_other = match known {
        Some(known) => kind.is_boat() && (known / usual).ln().abs() > STEEPNESS_APART,
        None => true,
    };
    known.into_iter().chain(is_other.then_some(usual))
}
