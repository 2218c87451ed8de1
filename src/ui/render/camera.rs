//! Provides a camera that orbits a target, and its projection. World: x east, y north, z up,
//! metres.

use glam::camera::rh::proj::directx::perspective_infinite_reverse;
use glam::{Mat3, Mat4, Vec2, Vec3};

/// Vertical field of view, radians.
const FIELD_OF_VIEW: f32 = 0.7;
/// Least and greatest distance of the camera from its target, metres.
const DISTANCES_M: [f32; 2] = [0.05, 1e6];

/// Least and greatest distance that [`OrbitCamera::hold`] allows, as a share of the box's size.
const HELD: [f32; 2] = [0.002, 20.0];
/// Least distance in [`OrbitCamera::hold`] and [`OrbitCamera::close_up`], metres.
const LEAST_M: f32 = 0.3;

/// A camera that looks at a target from a distance and never rolls, so that up stays up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitCamera {
    /// Point that the camera looks at, metres, before vertical exaggeration.
    pub target: Vec3,
    /// Distance from the target, metres.
    pub distance_m: f32,
    /// Compass direction of the view, radians clockwise from north.
    pub azimuth_rad: f32,
    /// Height of the camera over the horizon seen from the target, radians.
    pub elevation_rad: f32,
    /// Factor on z (vertical exaggeration).
    pub exaggeration: f32,
}

impl Default for OrbitCamera {
    fn default() -> Self {
        Self {
            target: Vec3::ZERO,
            distance_m: 100.0,
            azimuth_rad: 0.5,
            elevation_rad: 0.6,
            exaggeration: 1.0,
        }
    }
}

impl OrbitCamera {
    /// Turns the camera by a drag across the picture, in pictures' heights: right turns the scene
    /// right, down lifts the camera.
    pub(crate) fn orbit(&mut self, drag: Vec2) {
        use std::f32::consts::{FRAC_PI_2, TAU};
        self.azimuth_rad = (self.azimuth_rad + drag.x * TAU * 0.5).rem_euclid(TAU);
        self.elevation_rad = (self.elevation_rad + drag.y * TAU * 0.5).clamp(-FRAC_PI_2, FRAC_PI_2);
    }

    /// Moves the target so that the scene follows a drag across the picture, in pictures' heights.
    pub(crate) fn pan(&mut self, drag: Vec2) {
        let [right, up, _] = self.axes();
        let height_m = 2.0 * self.distance_m * (0.5 * FIELD_OF_VIEW).tan();
        self.move_target(-(right * drag.x - up * drag.y) * height_m);
    }

    /// Moves the camera `factor` times nearer (above 1) while the place under `ndc` stays where it
    /// is in the picture.
    pub fn zoom(&mut self, factor: f32, ndc: Vec2, aspect: f32) {
        let [nearest, farthest] = DISTANCES_M;
        let distance_m = (self.distance_m / factor).clamp(nearest, farthest);
        let [right, up, _] = self.axes();
        let tan = (0.5 * FIELD_OF_VIEW).tan();
        let offset = right * (ndc.x * tan * aspect) + up * (ndc.y * tan);
        self.move_target(offset * (self.distance_m - distance_m));
        self.distance_m = distance_m;
    }

    /// Moves the target to the depth of a place without moving the camera: the picture stays as it
    /// is, and later turns and zooms are about that depth. A place behind the camera changes
    /// nothing.
    pub(crate) fn look_at_depth_of(&mut self, place: Vec3) {
        let [_, _, back] = self.axes();
        let eye = self.target + self.shrink(back * self.distance_m);
        let depth_m = self.exaggerate(eye - place).dot(back);
        let [nearest, farthest] = DISTANCES_M;
        if (nearest..farthest).contains(&depth_m) {
            self.target = eye - self.shrink(back * depth_m);
            self.distance_m = depth_m;
        }
    }

    /// Keeps the camera near a box: the target within half of the box's size around the box, and
    /// the distance between limits that depend on that size.
    pub(crate) fn hold(&mut self, [low, high]: [Vec3; 2]) {
        let half = 0.5 * (high - low).max(Vec3::ONE);
        self.target = self.target.clamp(low - half, high + half);
        let size_m = self.exaggerate(high - low).length().max(1.0);
        let [nearest, farthest] = HELD.map(|share| share * size_m);
        self.distance_m = self.distance_m.clamp(nearest.max(LEAST_M), farthest.max(1.0));
    }

    /// Moves the camera so that a box is entirely within the inner `1 / margin` of the picture,
    /// without turning.
    pub fn fit(&mut self, [low, high]: [Vec3; 2], aspect: f32, margin: f32) {
        self.target = 0.5 * (low + high);
        let tan = (0.5 * FIELD_OF_VIEW).tan();
        let [right, up, back] = self.axes();
        let needed = corners(low, high).map(|corner| {
            let offset = self.exaggerate(corner - self.target);
            let beside = (offset.dot(right).abs() / (tan * aspect)).max(offset.dot(up).abs() / tan);
            beside * margin + offset.dot(back)
        });
        let [nearest, farthest] = DISTANCES_M;
        let distance_m = needed.into_iter().fold(0.0, f32::max);
        self.distance_m = distance_m.max(0.5).clamp(nearest, farthest);
    }

    /// Moves the camera to a place without turning, so that something of this size there fills
    /// about a third of the picture's height.
    pub fn close_up(&mut self, place: Vec3, size_m: f32) {
        let [nearest, farthest] = DISTANCES_M;
        self.target = place;
        let distance_m = 3.0 * size_m / (2.0 * (0.5 * FIELD_OF_VIEW).tan());
        self.distance_m = distance_m.clamp(nearest.max(LEAST_M), farthest);
    }

    /// Turns the camera to look from the south, from this height over the horizon, radians; a
    /// quarter of a turn looks from above, north up.
    pub(crate) fn look_from_south(&mut self, elevation_rad: f32) {
        self.azimuth_rad = 0.0;
        self.elevation_rad = elevation_rad;
    }

    /// Returns the projection for a picture with this ratio of width to height.
    pub fn projection(&self, aspect: f32) -> CameraProjection {
        let [right, up, back] = self.axes();
        let view_from_world = Mat4::from_mat3(Mat3::from_cols(right, up, back).transpose());
        let clip_from_view =
            perspective_infinite_reverse(FIELD_OF_VIEW, aspect.max(1e-3), 0.01 * self.distance_m);
        let clip_from_world = clip_from_view
            * Mat4::from_translation(Vec3::new(0.0, 0.0, -self.distance_m))
            * view_from_world
            * Mat4::from_scale(Vec3::new(1.0, 1.0, self.exaggeration))
            * Mat4::from_translation(-self.target);
        CameraProjection { clip_from_world, eye: self.target + self.shrink(back * self.distance_m) }
    }

    /// Returns right, up and back of the camera in the exaggerated world.
    fn axes(&self) -> [Vec3; 3] {
        let (sin_a, cos_a) = self.azimuth_rad.sin_cos();
        let (sin_e, cos_e) = self.elevation_rad.sin_cos();
        let right = Vec3::new(cos_a, -sin_a, 0.0);
        let back = Vec3::new(-sin_a * cos_e, -cos_a * cos_e, sin_e);
        [right, back.cross(right), back]
    }

    fn exaggerate(&self, offset: Vec3) -> Vec3 {
        offset * Vec3::new(1.0, 1.0, self.exaggeration)
    }

    fn shrink(&self, offset: Vec3) -> Vec3 {
        offset / Vec3::new(1.0, 1.0, self.exaggeration)
    }

    fn move_target(&mut self, by: Vec3) {
        self.target += self.shrink(by);
    }
}

/// Returns the eight corners of a box; bit 0 of the index is x, bit 1 y, bit 2 z.
pub(super) fn corners(low: Vec3, high: Vec3) -> [Vec3; 8] {
    std::array::from_fn(|index| {
        let pick = |bit: usize, axis: usize| {
            if index >> bit & 1 == 1 { high[axis] } else { low[axis] }
        };
        Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    })
}

/// Projection from the world to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraProjection {
    /// Matrix from world metres to clip space.
    pub clip_from_world: Mat4,
    /// Position of the camera, world metres.
    pub eye: Vec3,
}

impl CameraProjection {
    /// Returns a place in normalised device coordinates (x right, y up, -1 to 1) and its nearness
    /// (reverse-Z: larger is nearer); `None` behind the camera.
    pub fn project(&self, place: Vec3) -> Option<Vec3> {
        let clip = self.clip_from_world * place.extend(1.0);
        (clip.w > 1e-6).then(|| clip.truncate() / clip.w)
    }

    /// Returns the direction from the camera to what is visible at a place of the picture; `None`
    /// where the projection has no inverse.
    pub(crate) fn towards(&self, ndc: Vec2) -> Option<Vec3> {
        let place = self.clip_from_world.inverse() * ndc.extend(0.5).extend(1.0);
        let towards = place.truncate() / place.w - self.eye;
        towards.try_normalize()
    }

    /// Returns the number of the point under the pointer: the nearest one within `reach_px`, or the
    /// one in front if several are equally near. Distances are rounded to pixels, and all within
    /// `cover_px` count as equal. `pointer_px` and `size_px` are in pixels from the top left.
    pub fn pick(
        &self,
        points: impl Iterator<Item = (usize, Vec3)>,
        pointer_px: Vec2,
        size_px: Vec2,
        [cover_px, reach_px]: [f32; 2],
    ) -> Option<usize> {
        let half = 0.5 * size_px;
        let mut best: Option<(f32, f32, usize)> = None;
        for (index, point) in points {
            let Some(ndc) = self.project(point) else {
                continue;
            };
            let at_px = Vec2::new(1.0 + ndc.x, 1.0 - ndc.y) * half;
            let off_px = at_px.distance(pointer_px);
            if off_px > reach_px {
                continue;
            }
            let off_px = off_px.max(cover_px).round();
            let better = |(off, z, _)| off_px < off || (off_px == off && ndc.z > z);
            if best.is_none_or(better) {
                best = Some((off_px, ndc.z, index));
            }
        }
        best.map(|(_, _, index)| index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOW: Vec3 = Vec3::new(-20.0, -10.0, -6.0);
    const HIGH: Vec3 = Vec3::new(20.0, 10.0, -1.0);

    fn fitted(exaggeration: f32) -> OrbitCamera {
        let mut camera = OrbitCamera { exaggeration, ..OrbitCamera::default() };
        camera.fit([LOW, HIGH], 1.5, 1.1);
        camera
    }

    #[test]
    fn from_above_north_is_up_and_east_is_right() {
        let mut camera = fitted(5.0);
        camera.look_from_south(std::f32::consts::FRAC_PI_2);
        let projection = camera.projection(1.5);
        let centre = projection.project(camera.target).unwrap();
        let north = projection.project(camera.target + Vec3::Y).unwrap();
        let east = projection.project(camera.target + Vec3::X).unwrap();
        assert!(centre.truncate().length() < 1e-5);
        assert!(north.y > 0.0 && north.x.abs() < 1e-5);
        assert!(east.x > 0.0 && east.y.abs() < 1e-5);
    }

    #[test]
    fn from_the_south_up_is_up_and_nearer_is_larger_in_depth() {
        let mut camera = fitted(5.0);
        camera.look_from_south(0.0);
        let projection = camera.projection(1.5);
        let above = projection.project(camera.target + Vec3::Z).unwrap();
        let north = projection.project(camera.target + Vec3::Y).unwrap();
        let south = projection.project(camera.target - Vec3::Y).unwrap();
        assert!(above.y > 0.0);
        assert!(south.z > north.z);
    }

    #[test]
    fn what_is_seen_at_a_place_of_the_picture_lies_in_its_direction() {
        for exaggeration in [1.0, 8.0] {
            let projection = fitted(exaggeration).projection(1.5);
            for corner in corners(LOW, HIGH) {
                let ndc = projection.project(corner).unwrap().truncate();
                let towards = projection.towards(ndc).unwrap();
                let away_m = (corner - projection.eye).dot(towards);
                let off_m = (projection.eye + away_m * towards).distance(corner);
                assert!(off_m < 1e-3 * away_m, "{off_m} m at {away_m} m");
            }
        }
    }

    #[test]
    fn a_fitted_box_lies_in_the_picture_from_everywhere() {
        for azimuth in 0..12 {
            for elevation in -3..=3 {
                let mut camera = fitted(8.0);
                camera.azimuth_rad = azimuth as f32 * 0.5;
                camera.elevation_rad = elevation as f32 * 0.5;
                camera.fit([LOW, HIGH], 0.8, 1.1);
                let projection = camera.projection(0.8);
                let most = corners(LOW, HIGH)
                    .map(|corner| {
                        let ndc = projection.project(corner).unwrap();
                        ndc.truncate().abs().max_element()
                    })
                    .into_iter()
                    .fold(0.0, f32::max);
                assert!((0.5..1.0).contains(&most), "{most}");
            }
        }
    }

    #[test]
    fn zooming_keeps_the_place_under_the_pointer() {
        let mut camera = fitted(5.0);
        let ndc = Vec2::new(0.4, -0.3);
        let [right, up, _] = camera.axes();
        let tan = (0.5 * FIELD_OF_VIEW).tan() * camera.distance_m;
        let offset = right * (ndc.x * tan * 1.5) + up * (ndc.y * tan);
        let place = camera.target + camera.shrink(offset);
        camera.zoom(3.0, ndc, 1.5);
        let after = camera.projection(1.5).project(place).unwrap();
        assert!(after.truncate().distance(ndc) < 1e-4, "{after}");
    }

    #[test]
    fn another_depth_to_turn_about_leaves_the_picture_as_it_is() {
        let mut camera = fitted(5.0);
        let before = camera.projection(1.5);
        camera.look_at_depth_of(HIGH);
        let after = camera.projection(1.5);
        for corner in corners(LOW, HIGH) {
            let [was, is] = [before, after].map(|projection| projection.project(corner).unwrap());
            assert!(was.truncate().distance(is.truncate()) < 1e-4, "{was} {is}");
        }
        let held = camera;
        camera.look_at_depth_of(held.projection(1.5).eye + (held.projection(1.5).eye - LOW));
        assert_eq!(camera, held, "behind it");
    }

    #[test]
    fn a_held_camera_loses_the_box_in_no_direction() {
        for (factor, ndc) in [(1.5, Vec2::new(0.9, 0.8)), (1.0 / 1.5, Vec2::new(-0.9, 0.2))] {
            let mut camera = fitted(5.0);
            for _ in 0..200 {
                camera.zoom(factor, ndc, 1.5);
                camera.hold([LOW, HIGH]);
            }
            let size_m = camera.exaggerate(HIGH - LOW).length();
            assert!((0.05..25.0 * size_m).contains(&camera.distance_m));
            let off = (camera.target - 0.5 * (LOW + HIGH)).abs();
            assert!(off.cmple(HIGH - LOW).all(), "{off}");
        }
    }

    #[test]
    fn panning_moves_the_target_with_the_pointer() {
        let mut camera = fitted(5.0);
        let before = camera.target;
        camera.pan(Vec2::new(0.25, 0.1));
        let after = camera.projection(1.5).project(before).unwrap();
        assert!((after.x - 0.5 / 1.5).abs() < 1e-4, "{after}");
        assert!((after.y + 0.2).abs() < 1e-4, "{after}");
    }

    #[test]
    fn picking_takes_the_point_in_front_and_none_behind() {
        let mut camera = OrbitCamera::default();
        camera.look_from_south(0.0);
        let projection = camera.projection(1.0);
        let size = Vec2::new(200.0, 200.0);
        let centre = Vec2::new(100.0, 100.0);
        let points = [
            Vec3::new(0.0, 20.0, 0.0),
            Vec3::new(0.0, -20.0, 0.0),
            Vec3::new(0.0, -500.0, 0.0),
            Vec3::new(30.0, 0.0, 0.0),
        ];
        let pick = |at| projection.pick(points.iter().copied().enumerate(), at, size, [3.0, 8.0]);
        assert_eq!(pick(centre), Some(1));
        assert_eq!(pick(centre + Vec2::new(6.0, 0.0)), Some(1));
        assert_eq!(pick(centre + Vec2::new(30.0, 30.0)), None);
    }
}
