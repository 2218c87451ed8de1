//! The part of a scene that is drawn.

use glam::{Vec2, Vec3, Vec4};

/// Part of a scene in a box, and on one side of a vertical plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScenePart {
    /// Corners of the box outside of which nothing is drawn, metres.
    pub corners: [Vec3; 2],
    /// The plane beyond which nothing is drawn.
    pub cut: Option<Cut>,
}

/// An upright plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Unit vector square to it, towards what is left out: east and north.
    pub outward: Vec2,
    /// Distance of the plane along that vector, metres.
    pub at_m: f32,
}

impl Default for ScenePart {
    /// Everything.
    fn default() -> Self {
        Self::WHOLE
    }
}

impl ScenePart {
    /// Everything.
    pub const WHOLE: Self = Self { corners: [Vec3::MIN, Vec3::MAX], cut: None };

    /// Returns true if a place is drawn.
    pub fn holds(&self, place: Vec3) -> bool {
        let [low, high] = self.corners;
        let is_beyond = |cut: Cut| cut.outward.dot(place.truncate()) > cut.at_m;
        (place.cmpge(low) & place.cmple(high)).all() && !self.cut.is_some_and(is_beyond)
    }

    /// Returns the part as the shaders read it: the corners, and the plane as its unit vector and
    /// its distance along that vector.
    pub(super) fn uniform(&self) -> [Vec4; 3] {
        let [low, high] = self.corners.map(|corner| corner.extend(0.0));
        let cut = self
            .cut
            .map_or(Vec4::ZERO.with_z(f32::MAX), |cut| cut.outward.extend(cut.at_m).extend(0.0));
        [low, high, cut]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_ends_at_its_box_and_at_its_plane() {
        let part = ScenePart {
            corners: [Vec3::splat(-2.0), Vec3::splat(2.0)],
            cut: Some(Cut { outward: Vec2::Y, at_m: 1.0 }),
        };
        let holds = |east, north, up| part.holds(Vec3::new(east, north, up));
        assert!(holds(2.0, 1.0, -2.0));
        assert!(!holds(0.0, 1.1, 0.0), "beyond the plane");
        assert!(!holds(2.1, 0.0, 0.0), "beside the box");
        assert!(ScenePart::WHOLE.holds(Vec3::splat(1e9)));
    }
}
