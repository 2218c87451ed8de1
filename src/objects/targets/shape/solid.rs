//! Defines solids that are similar to objects, by their heights above the bottom.

use bathyscope_log::named;

/// Number of places that are computed together.
pub(super) const LANES: usize = 8;

/// Kind of the shape of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShapeKind {
    /// A crate or a block: straight sides and a flat top.
    Block,
    /// A pipe, a drum or a trunk on its side: as high as it is wide.
    Cylinder,
    /// A tyre that lies flat.
    Tyre,
    /// A boulder: the upper half of an ellipsoid.
    Boulder,
    /// An open boat on its keel: a side around a lower floor.
    Hull,
    /// A boat that lies keel up.
    UpturnedHull,
}

/// Usual sizes of a kind, each from the least to the greatest: length and width in metres, length
/// over width, height over width.
pub(super) struct UsualSize {
    pub(super) length_m: [f64; 2],
    pub(super) width_m: [f64; 2],
    pub(super) slenderness: [f64; 2],
    pub(super) steepness: [f64; 2],
    /// Length over width with which a search begins.
    pub(super) typical_slenderness: f64,
}

named! {
    /// All kinds.
    pub ShapeKind {
        Block: "block",
        Cylinder: "cylinder",
        Tyre: "tyre",
        Boulder: "boulder",
        Hull: "hull",
        UpturnedHull: "hull keel up",
    }
}

impl ShapeKind {
    /// Returns true if the kind is a boat, upright or not: with a bow, it does not look the same
    /// from ahead and from astern.
    pub fn is_boat(self) -> bool {
        matches!(self, ShapeKind::Hull | ShapeKind::UpturnedHull)
    }

    /// Returns the usual sizes of a kind: of crates, drums, tyres of cars and tractors, boulders
    /// that a boat's beam resolves, and boats. Without these limits, one kind could take the place
    /// of another (a boulder four times as long as it is wide is a boat).
    pub(super) fn usual(self) -> UsualSize {
        let usual = |length_m, width_m, slenderness, steepness, typical_slenderness| UsualSize {
            length_m,
            width_m,
            slenderness,
            steepness,
            typical_slenderness,
        };
        match self {
            ShapeKind::Block => usual([0.3, 3.0], [0.2, 3.0], [1.0, 3.0], [0.3, 1.6], 1.5),
            ShapeKind::Cylinder => usual([0.6, 12.0], [0.1, 1.5], [2.5, 15.0], [1.0, 1.0], 5.0),
            ShapeKind::Tyre => usual([0.5, 1.6], [0.5, 1.6], [1.0, 1.0], [0.2, 0.45], 1.0),
            ShapeKind::Boulder => usual([0.3, 3.0], [0.2, 3.0], [1.0, 2.0], [0.3, 1.0], 1.2),
            ShapeKind::Hull | ShapeKind::UpturnedHull => {
                usual([2.5, 60.0], [0.9, 15.0], [2.0, 5.0], [0.15, 0.8], 3.0)
            }
        }
    }
}

/// A shape with its size, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Kind of the shape.
    pub kind: ShapeKind,
    /// Longest extent.
    pub length_m: f64,
    /// Extent across the length.
    pub width_m: f64,
    /// Height of the highest point above the bottom.
    pub height_m: f64,
    /// Excess of a boat's height at its starboard side over that in its middle, as a share of the
    /// latter; the port side is lower by the same amount. 0 for other kinds.
    pub list: f64,
}

/// Radius of the middle of a tyre's ring and half of its thickness, in outer radii: a car's tyre is
/// 0.6 m wide, around a rim of at most 0.4 m.
const RING: [f32; 2] = [0.68, 0.32];
/// Thickness of a boat's side with its fittings, metres; and height of its floor, with the mud on
/// it, as a share of the height of the side.
const SIDE_M: f32 = 0.1;
const FLOOR: f32 = 0.3;

impl Solid {
    /// Returns the radius of the circle around the solid, metres.
    pub fn reach_m(&self) -> f64 {
        0.5 * self.length_m.hypot(self.width_m)
    }

    /// Returns the height above the bottom, metres, at a distance along the solid (ahead to a
    /// boat's bow) and across it (to starboard) from its middle; 0 outside the solid.
    pub fn height_at_m(&self, along_m: f64, across_m: f64) -> f64 {
        let mut height_m = [0.0_f32];
        self.heights_m([along_m, across_m], [0.0; 2], &mut height_m);
        f64::from(height_m[0])
    }

    /// Writes the heights at a row of places, each a step along and across from the place before.
    #[inline(always)]
    pub(super) fn heights_m(&self, first_m: [f64; 2], step_m: [f64; 2], into: &mut [f32]) {
        // One loop for each kind: a choice at every place would prevent the computation of several
        // at once.
        match self.kind {
            ShapeKind::Block => self.fill(first_m, step_m, into, |_, _| 1.0),
            ShapeKind::Cylinder => self.fill(first_m, step_m, into, |_, v| lying_round(v)),
            ShapeKind::Tyre => self.fill(first_m, step_m, into, |u, v| {
                lying_round(((u * u + v * v).sqrt() - RING[0]) / RING[1])
            }),
            ShapeKind::Boulder => {
                self.fill(first_m, step_m, into, |u, v| (1.0 - u * u - v * v).max(0.0).sqrt())
            }
            ShapeKind::Hull => self.fill(first_m, step_m, into, |u, v| self.open_hull(u, v)),
            ShapeKind::UpturnedHull => {
                self.fill(first_m, step_m, into, |u, v| lying_round(v / boat_outline(u)))
            }
        }
    }

    /// Writes the heights at a row of places; `upright` returns the height as a share of the
    /// greatest, at a place along and across in half lengths and half widths.
    #[inline(always)]
    fn fill(
        &self,
        first_m: [f64; 2],
        step_m: [f64; 2],
        into: &mut [f32],
        upright: impl Fn(f32, f32) -> f32,
    ) {
        let half_m = self.half_m();
        let [u0, v0] = [0, 1].map(|axis| (first_m[axis] / half_m[axis]) as f32);
        let [du, dv] = [0, 1].map(|axis| (step_m[axis] / half_m[axis]) as f32);
        let list = self.list as f32;
        let middle_m = self.height_m as f32 / (1.0 + list.abs());
        let at = |step: usize| {
            let (u, v) = (u0 + du * step as f32, v0 + dv * step as f32);
            let over_m = middle_m * upright(u, v) * (1.0 + list * v);
            let is_over = u.abs() <= 1.0 && v.abs() <= 1.0;
            if is_over { over_m } else { 0.0 }
        };
        let (together, rest) = into.as_chunks_mut::<LANES>();
        let first_of_rest = LANES * together.len();
        for (index, heights_m) in together.iter_mut().enumerate() {
            for (lane, height_m) in heights_m.iter_mut().enumerate() {
                *height_m = at(LANES * index + lane);
            }
        }
        for (lane, height_m) in rest.iter_mut().enumerate() {
            *height_m = at(first_of_rest + lane);
        }
    }

    /// Returns the distances at which a ray enters and leaves the rectangle around the solid, for a
    /// ray from a place along and across the solid in a direction of length 1; `None` if the ray
    /// misses it.
    #[inline(always)]
    pub(super) fn met_m(&self, start_m: [f64; 2], toward: [f64; 2]) -> Option<[f64; 2]> {
        let half_m = self.half_m();
        let mut met_m = [f64::NEG_INFINITY, f64::INFINITY];
        for axis in 0..2 {
            let sides = [-half_m[axis], half_m[axis]];
            let [one_m, other_m] = sides.map(|side_m| (side_m - start_m[axis]) / toward[axis]);
            met_m[0] = met_m[0].max(one_m.min(other_m));
            met_m[1] = met_m[1].min(one_m.max(other_m));
        }
        (met_m[0] < met_m[1]).then_some(met_m)
    }

    /// Returns half of length and width, metres.
    #[inline(always)]
    fn half_m(&self) -> [f64; 2] {
        [0.5 * self.length_m, 0.5 * self.width_m]
    }

    #[inline(always)]
    fn open_hull(&self, u: f32, v: f32) -> f32 {
        let across_m = 0.5 * self.width_m as f32 * (boat_outline(u) - v.abs());
        let along_m = 0.5 * self.length_m as f32 * (1.0 - u.abs());
        let inside_m = across_m.min(along_m);
        let of_inside = if inside_m < SIDE_M { 1.0 } else { FLOOR };
        if inside_m < 0.0 { 0.0 } else { of_inside }
    }

    /// Returns the outline on the bottom: places along and across from the middle, metres, back to
    /// the first.
    pub fn outline_m(&self) -> Vec<[f64; 2]> {
        const POINTS: usize = 32;
        let [length_m, width_m] = self.half_m();
        if matches!(self.kind, ShapeKind::Block | ShapeKind::Cylinder) {
            let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
            return corners.map(|(u, v)| [u * length_m, v * width_m]).to_vec();
        }
        let round = (0..=POINTS).map(|point| {
            let (sin, cos) = (std::f64::consts::TAU * point as f64 / POINTS as f64).sin_cos();
            let half = if self.kind.is_boat() {
                f64::from(boat_outline(cos as f32)).copysign(sin)
            } else {
                sin
            };
            [cos * length_m, half * width_m]
        });
        round.collect()
    }
}

/// Returns half of a boat's width at a place along it in half lengths (the bow at 1), as a share of
/// the greatest: the boat has a transom, and a bow that is not quite pointed.
#[inline(always)]
fn boat_outline(u: f32) -> f32 {
    // Both are computed, so that several places can be computed together.
    let astern = 1.0 - 0.25 * u * u;
    let ahead = (1.0 - u * u * (0.3 + 0.7 * u)).max(1e-6);
    if u < 0.0 { astern } else { ahead }
}

/// Returns the height of the upper half of a round section that lies on the bottom: 1 in the
/// middle, one half at its sides, 0 beyond.
#[inline(always)]
fn lying_round(offset: f32) -> f32 {
    let height = 0.5 + 0.5 * (1.0 - offset * offset).max(0.0).sqrt();
    if offset.abs() < 1.0 { height } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(kind: ShapeKind) -> Solid {
        Solid { kind, length_m: 4.0, width_m: 2.0, height_m: 1.0, list: 0.0 }
    }

    #[test]
    fn shapes_are_as_high_as_they_are_said_to_be_and_end_at_their_outline() {
        for kind in ShapeKind::ALL {
            let solid = solid(kind);
            let heights = (-25..=25)
                .flat_map(|a| (-15..=15).map(move |c| (f64::from(a) * 0.1, f64::from(c) * 0.1)));
            let highest = heights.map(|(a, c)| solid.height_at_m(a, c)).fold(0.0, f64::max);
            assert!((highest - 1.0).abs() < 0.03, "{kind:?}: {highest}");
            let outline = solid.outline_m();
            assert!(outline.len() > 4);
            for [along, across] in outline {
                assert!(solid.height_at_m(1.03 * along, 1.03 * across) == 0.0, "{kind:?}");
                let height_m = solid.height_at_m(0.96 * along, 0.96 * across);
                assert!(height_m > 0.2, "{kind:?} {along} {across}: {height_m}");
            }
        }
    }

    #[test]
    fn a_tyre_has_a_hole_and_an_open_boat_a_floor() {
        assert_eq!(solid(ShapeKind::Tyre).height_at_m(0.0, 0.0), 0.0);
        assert_eq!(solid(ShapeKind::Hull).height_at_m(0.0, 0.0), f64::from(FLOOR));
        assert_eq!(solid(ShapeKind::UpturnedHull).height_at_m(0.0, 0.0), 1.0);
        let listing = Solid { list: 0.2, ..solid(ShapeKind::Hull) };
        let sides = [0.95, -0.95].map(|across_m| listing.height_at_m(0.0, across_m));
        assert!((sides[0] / sides[1] - 1.19 / 0.81).abs() < 1e-6);
        // The bow is ahead, and narrower than the stern.
        let hull = solid(ShapeKind::Hull);
        assert_eq!(hull.height_at_m(1.8, 0.6), 0.0);
        assert!(hull.height_at_m(-1.8, 0.6) > 0.0);
    }

    #[test]
    fn a_ray_meets_the_rectangle_around_a_solid_where_its_sides_are() {
        let solid = solid(ShapeKind::Block);
        assert_eq!(solid.met_m([-5.0, 0.5], [1.0, 0.0]), Some([3.0, 7.0]));
        assert_eq!(solid.met_m([0.5, 5.0], [0.0, -1.0]), Some([4.0, 6.0]));
        assert_eq!(solid.met_m([-5.0, 1.5], [1.0, 0.0]), None);
        let diagonal = [0.5_f64.sqrt(); 2];
        assert_eq!(solid.met_m([1.2, -2.0], diagonal), None, "past a corner");
        assert!(solid.met_m([0.8, -2.0], diagonal).is_some());
    }
}
