//! Derives the parameters with which a search begins from the box of an object.

use super::levels::BoxLevels;
use super::problem::{DARKNESS, Numbers, OF_LOOK, STRENGTH};
use super::solid::ShapeKind;
use crate::targets::Target;
use std::f64::consts::{PI, TAU};

/// Number of initial headings over half a circle.
const HEADINGS: usize = 8;
/// Offsets outward from the box's place at which a search begins, as shares of the box.
const OUTWARD: [f64; 3] = [-0.15, 0.0, 0.15];

/// Logarithm of the ratio of two steepnesses above which a search begins with both.
const STEEPNESS_APART: f64 = 0.3;

/// Initial guess of an object from one of its boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct InitialGuess {
    /// Place of the object, metres east and north.
    pub(super) place_m: [f64; 2],
    /// Direction of the track, radians clockwise from north.
    pub(super) heading_rad: f64,
    /// Extents along and across the track, metres.
    pub(super) along_m: f64,
    pub(super) across_m: f64,
    /// Extent of the box across the track on a level bottom, its shadow included, metres.
    pub(super) box_m: f64,
    /// Unit vector (east, north) across the track, to the side of the look.
    pub(super) outward: [f64; 2],
    /// Height, metres; NaN without a visible shadow.
    pub(super) height_m: f64,
}

impl InitialGuess {
    /// Creates the guess from a placed box and its look.
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

    /// Returns the initial parameters of a look.
    pub(super) fn of_look(&self) -> [f64; OF_LOOK] {
        let [east_m, north_m] = self.place_m;
        [east_m, north_m, STRENGTH[0], DARKNESS, 0.0]
    }
}

/// Returns the initial height: that of the box, or, if its shadow is not whole enough for a height,
/// that of the shadow in the middle of the box.
fn height_m(target: &Target) -> f64 {
    let in_middle_m = || {
        let [start_m, end_m] = target.parts?.shadow_m?;
        Some(target.altitude_m * (end_m - start_m) / end_m)
    };
    if target.height_m.is_finite() { target.height_m } else { in_middle_m().unwrap_or(f64::NAN) }
}

/// Returns initial parameters: the solid has a typical slenderness, its length follows from the
/// extents along the track, across it, or both, and it is in the middle of the picture or a little
/// nearer or farther.
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
        // About half of a box is shadow.
        let by_box_m = 0.6 * start.box_m / (sin + cos / slenderness);
        let both_m = (by_along_m * by_across_m).sqrt();
        for length_m in [by_along_m, by_across_m, both_m, by_box_m] {
            let length_m = length_m.clamp(usual.length_m[0], usual.length_m[1]);
            let heading_rad = start.heading_rad + off_rad;
            let steepnesses = steepnesses(kind, start.height_m * slenderness / length_m);
            for (steepness, out) in
                steepnesses.flat_map(|steepness| OUTWARD.map(|out| (steepness, out)))
            {
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

/// Returns initial steepnesses: that of the shadow, if it is known. The shadow of a boat may be
/// that of a thwart or of one end, so the search for a boat begins with a usual steepness as well.
fn steepnesses(kind: ShapeKind, by_shadow: f64) -> impl Iterator<Item = f64> {
    let [low, high] = kind.usual().steepness;
    let usual = (low * high).sqrt();
    let known = (by_shadow > 0.0).then(|| by_shadow.clamp(low, high));
    let is_far = |known: f64| (known / usual).ln().abs() > STEEPNESS_APART;
    let is_other = known.is_none_or(|known| kind.is_boat() && is_far(known));
    known.into_iter().chain(is_other.then_some(usual))
}
