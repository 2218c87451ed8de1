//! Transforms between the ground and the map view: north up, the same scale east and north.

use egui::{Pos2, Rect, Vec2, pos2};

/// West, south, east and north of a part of the ground, metres.
pub(super) type GroundBounds = [f64; 4];

/// Bounds that contain nothing.
pub(super) const NOWHERE: GroundBounds =
    [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];

/// Returns the bounds around both.
pub(super) fn joined(
    [west, south, east, north]: GroundBounds,
    [w, s, e, n]: GroundBounds,
) -> GroundBounds {
    [west.min(w), south.min(s), east.max(e), north.max(n)]
}

/// Returns the bounds around places; places without finite coordinates are left out.
pub(super) fn around(places: impl Iterator<Item = [f64; 2]>) -> GroundBounds {
    let placed = places.filter(|place| place.iter().all(|metres| metres.is_finite()));
    placed.fold(NOWHERE, |all, [east, north]| joined(all, [east, north, east, north]))
}

/// Returns the distance of a place outside of bounds, along east and along north, metres; 0 inside.
pub(super) fn away_m(
    [east_m, north_m]: [f64; 2],
    [west, south, east, north]: &GroundBounds,
) -> [f64; 2] {
    let beside = (west - east_m).max(east_m - east).max(0.0);
    let beyond = (south - north_m).max(north_m - north).max(0.0);
    [beside, beyond]
}

/// Boxes around successive places, for finding the nearest place. A boat cannot jump: successive
/// places are close together, and a box around them shows whether they need to be searched.
pub(super) struct PlaceBoxes {
    /// Bounds of [`PlaceBoxes::EACH`] successive places each.
    pub boxes: Vec<GroundBounds>,
}

impl PlaceBoxes {
    /// Number of places in a box.
    pub(super) const EACH: usize = 256;

    /// Creates the boxes in one pass over the places.
    pub(super) fn new<T>(places: &[T], place: impl Fn(&T) -> [f64; 2]) -> Self {
        let each = places.chunks(Self::EACH);
        Self { boxes: each.map(|places| around(places.iter().map(&place))).collect() }
    }

    /// Returns the index of the place nearest to another one and its distance, metres, if one is
    /// within `reach_m`.
    pub(super) fn nearest<T>(
        &self,
        places: &[T],
        place: impl Fn(&T) -> [f64; 2],
        [east_m, north_m]: [f64; 2],
        reach_m: f64,
    ) -> Option<(usize, f64)> {
        let away = self.boxes.iter().map(|bounds| {
            let [beside, beyond] = away_m([east_m, north_m], bounds);
            beside * beside + beyond * beyond
        });
        let away = away.enumerate();
        // The nearest box first: its places rule out most of the other boxes.
        let first = away.clone().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let others = away.filter(|(index, _)| *index != first.0);
        let mut best = (reach_m * reach_m, None);
        for (index, square) in std::iter::once(first).chain(others) {
            if square > best.0 {
                continue;
            }
            let start = index * Self::EACH;
            for (found, at) in (start..).zip(places[start..].iter().take(Self::EACH)) {
                let [east, north] = place(at);
                let square = (east - east_m).powi(2) + (north - north_m).powi(2);
                if square < best.0 || (square == best.0 && best.1.is_none()) {
                    best = (square, Some(found));
                }
            }
        }
        Some((best.1?, best.0.sqrt()))
    }
}

/// Share of the view that fitted bounds cover.
const FIT_SHARE: f64 = 0.84;
/// Width at the right edge that is reserved for the legend, points.
const LEGEND_WIDTH: f32 = 76.0;
/// Width of each further scale of colours, points.
const SCALE_WIDTH: f32 = 72.0;
/// Least and greatest scale, metres per screen point.
const SCALES: [f64; 2] = [1e-4, 1e5];

/// Transform from metres on the ground to points on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MapTransform {
    /// East and north of the middle of the view, metres.
    pub centre_m: [f64; 2],
    /// Metres that a screen point covers.
    pub metres_per_point: f64,
}

impl MapTransform {
    /// Creates a transform that shows all of `bounds`, left of a legend with `scales` scales of
    /// colours.
    pub(super) fn fit(bounds: GroundBounds, rect: Rect, scales: usize) -> Self {
        let [west, south, east, north] = bounds;
        let [nearest, farthest] = SCALES;
        // Fitted bounds leave a margin, which a further scale may cover.
        let margin = 0.5 * (1.0 - FIT_SHARE) as f32 * rect.width();
        let further = (scales.saturating_sub(1) as f32 * SCALE_WIDTH - margin).max(0.0);
        let further = further / FIT_SHARE as f32;
        let legend = LEGEND_WIDTH.min(0.25 * rect.width()) + further.min(0.2 * rect.width());
        let across = (east - west).max(1.0) / f64::from((rect.width() - legend).max(1.0));
        let up = (north - south).max(1.0) / f64::from(rect.height().max(1.0));
        let metres_per_point = (across.max(up) / FIT_SHARE).clamp(nearest, farthest);
        let aside_m = 0.5 * f64::from(legend) * metres_per_point;
        Self { centre_m: [0.5 * (west + east) + aside_m, 0.5 * (south + north)], metres_per_point }
    }

    /// Creates a transform that shows all of `ground`, and no more than the shape of `rect`
    /// requires.
    pub(super) fn showing([west, south, east, north]: GroundBounds, rect: Rect) -> Self {
        let [nearest, farthest] = SCALES;
        let across = (east - west) / f64::from(rect.width().max(1.0));
        let up = (north - south) / f64::from(rect.height().max(1.0));
        Self {
            centre_m: [0.5 * (west + east), 0.5 * (south + north)],
            metres_per_point: across.max(up).clamp(nearest, farthest),
        }
    }

    /// Returns a place on the screen.
    pub(super) fn to_screen(self, rect: Rect, [east_m, north_m]: [f64; 2]) -> Pos2 {
        let right = (east_m - self.centre_m[0]) / self.metres_per_point;
        let up = (north_m - self.centre_m[1]) / self.metres_per_point;
        rect.center() + Vec2::new(right as f32, -up as f32)
    }

    /// Returns a place on the ground; inverse of [`MapTransform::to_screen`].
    pub(super) fn to_ground(self, rect: Rect, at: Pos2) -> [f64; 2] {
        let off = at - rect.center();
        [
            self.centre_m[0] + f64::from(off.x) * self.metres_per_point,
            self.centre_m[1] - f64::from(off.y) * self.metres_per_point,
        ]
    }

    /// Returns the ground that the view shows.
    pub(super) fn visible(&self, rect: Rect) -> GroundBounds {
        let [west, south] = self.to_ground(rect, rect.left_bottom());
        let [east, north] = self.to_ground(rect, rect.right_top());
        [west, south, east, north]
    }

    /// Moves the ground with the pointer.
    pub(super) fn pan(&mut self, drag: Vec2) {
        self.centre_m[0] -= f64::from(drag.x) * self.metres_per_point;
        self.centre_m[1] += f64::from(drag.y) * self.metres_per_point;
    }

    /// Enlarges by `factor` (reduces below 1); the place at `at` stays where it is on the screen.
    pub(super) fn zoom(&mut self, rect: Rect, at: Pos2, factor: f64) {
        let held = self.to_ground(rect, at);
        let [nearest, farthest] = SCALES;
        self.metres_per_point = (self.metres_per_point / factor).clamp(nearest, farthest);
        let moved = self.to_ground(rect, at);
        for axis in 0..2 {
            self.centre_m[axis] += held[axis] - moved[axis];
        }
    }

    /// Moves a place into the middle of the view unless it is already well inside.
    pub(super) fn reveal(&mut self, rect: Rect, place: [f64; 2]) {
        let inner = rect.shrink2(rect.size() * 0.1);
        if !inner.contains(self.to_screen(rect, place)) {
            self.centre_m = place;
        }
    }

    /// Enlarges a place so that something of this size there fills about a third of the view.
    pub(super) fn close_up(&mut self, rect: Rect, place: [f64; 2], size_m: f64) {
        let [nearest, farthest] = SCALES;
        let points = f64::from(rect.size().min_elem().max(1.0));
        self.metres_per_point = (3.0 * size_m / points).clamp(nearest, farthest);
        self.centre_m = place;
    }

    /// Returns scale and offset from metres relative to `origin_m` to pixels (from the top left of
    /// `rect`), as `track.wgsl` reads them.
    pub(super) fn pixels(&self, rect: Rect, pixels_per_point: f32, origin_m: [f64; 2]) -> [f32; 4] {
        let origin = self.to_screen(rect, origin_m) - rect.min;
        let scale = f64::from(pixels_per_point) / self.metres_per_point;
        let origin = pos2(0.0, 0.0) + origin * pixels_per_point;
        [scale as f32, -scale as f32, origin.x, origin.y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rect() -> Rect {
        Rect::from_min_size(pos2(10.0, 20.0), Vec2::new(400.0, 300.0))
    }

    #[test]
    fn fitted_bounds_lie_in_the_view_with_north_up() {
        let transform = MapTransform::fit([-50.0, 0.0, 150.0, 40.0], rect(), 1);
        let south_west = transform.to_screen(rect(), [-50.0, 0.0]);
        let north_east = transform.to_screen(rect(), [150.0, 40.0]);
        assert!(rect().contains(south_west) && rect().contains(north_east));
        assert!(north_east.x > south_west.x && north_east.y < south_west.y);
        let across = f64::from(north_east.x - south_west.x) / 200.0;
        let up = f64::from(south_west.y - north_east.y) / 40.0;
        assert!((across - up).abs() < 1e-4, "{across} {up}");
    }

    #[test]
    fn what_is_shown_close_up_fills_a_third_of_the_view() {
        let mut transform = MapTransform::fit([-50.0, 0.0, 150.0, 40.0], rect(), 1);
        transform.close_up(rect(), [40.0, 10.0], 6.0);
        let ends = [37.0, 43.0].map(|east| transform.to_screen(rect(), [east, 10.0]));
        assert!((ends[1].x - ends[0].x - 100.0).abs() < 0.1, "{ends:?}");
        let middle = transform.to_screen(rect(), [40.0, 10.0]);
        assert!(middle.distance(rect().center()) < 0.1);
    }

    #[test]
    fn the_same_ground_is_seen_in_a_frame_of_another_shape() {
        let seen = MapTransform::fit([-50.0, 0.0, 150.0, 40.0], rect(), 1).visible(rect());
        let paper = Rect::from_min_size(pos2(0.0, 0.0), Vec2::new(1123.0, 794.0));
        let [west, south, east, north] = MapTransform::showing(seen, paper).visible(paper);
        assert!(west <= seen[0] + 1e-9 && east >= seen[2] - 1e-9);
        assert!(south <= seen[1] + 1e-9 && north >= seen[3] - 1e-9);
        let spare =
            ((east - west) / (seen[2] - seen[0])).min((north - south) / (seen[3] - seen[1]));
        assert!((spare - 1.0).abs() < 1e-6, "{spare}");
    }

    #[test]
    fn a_further_scale_does_not_cover_what_is_fitted() {
        let bounds = [-50.0, 0.0, 150.0, 40.0];
        let east = |scales| {
            let transform = MapTransform::fit(bounds, rect(), scales);
            rect().right() - transform.to_screen(rect(), [150.0, 40.0]).x
        };
        assert!(east(1) > LEGEND_WIDTH && east(1) < LEGEND_WIDTH + SCALE_WIDTH);
        assert!(east(2) > LEGEND_WIDTH + 0.9 * SCALE_WIDTH, "{}", east(2));
    }

    #[test]
    fn ground_and_screen_are_inverses() {
        let transform = MapTransform::fit([-50.0, 0.0, 150.0, 40.0], rect(), 1);
        let place = [31.25, 17.5];
        let back = transform.to_ground(rect(), transform.to_screen(rect(), place));
        assert!((back[0] - place[0]).abs() < 1e-3 && (back[1] - place[1]).abs() < 1e-3);
    }

    #[test]
    fn zoom_holds_the_place_under_the_pointer() {
        let mut transform = MapTransform::fit([-50.0, 0.0, 150.0, 40.0], rect(), 1);
        let at = pos2(50.0, 60.0);
        let held = transform.to_ground(rect(), at);
        transform.zoom(rect(), at, 7.0);
        let now = transform.to_screen(rect(), held);
        assert!(now.distance(at) < 1e-2, "{now:?}");
    }

    #[test]
    fn the_shader_and_the_painter_agree() {
        let mut transform = MapTransform::fit([-50.0, 0.0, 150.0, 40.0], rect(), 1);
        transform.pan(Vec2::new(13.0, -7.0));
        let [sx, sy, ox, oy] = transform.pixels(rect(), 2.0, [100.0, 10.0]);
        let by_shader = pos2(12.0 * sx + ox, 5.0 * sy + oy);
        let by_painter = (transform.to_screen(rect(), [112.0, 15.0]) - rect().min) * 2.0;
        assert!((by_shader.to_vec2() - by_painter).length() < 1e-2);
    }

    #[test]
    fn a_place_in_view_does_not_move_the_map() {
        let mut transform = MapTransform::fit([-50.0, 0.0, 150.0, 40.0], rect(), 1);
        let before = transform;
        transform.reveal(rect(), [50.0, 20.0]);
        assert_eq!(transform, before);
        transform.reveal(rect(), [5000.0, 20.0]);
        assert_eq!(transform.centre_m, [5000.0, 20.0]);
    }

    #[test]
    fn the_nearest_place_is_that_of_a_look_at_all() {
        let spiral = |index: usize| match index % 400 {
            0..3 => [f64::NAN, 1.0],
            _ => {
                let (sin, cos) = (index as f64 * 0.013).sin_cos();
                let reach_m = 5.0 + index as f64 * 0.02;
                [reach_m * cos, reach_m * sin]
            }
        };
        let places: Vec<[f64; 2]> = (0..3000).map(spiral).collect();
        let boxes = PlaceBoxes::new(&places, |place| *place);
        for (reach_m, usual) in [(4.0, 50..190), (20.0, 50..200)] {
            let mut found_some = 0;
            for step in 0..200 {
                let (sin, cos) = f64::from(step).sin_cos();
                let at = [0.5 * f64::from(step) * cos, 0.5 * f64::from(step) * sin];
                let off = |place: &[f64; 2]| (place[0] - at[0]).hypot(place[1] - at[1]);
                let offs = places.iter().map(off).filter(|off| off.is_finite());
                let least_m = offs.fold(f64::MAX, f64::min);
                let found = boxes.nearest(&places, |place| *place, at, reach_m);
                assert_eq!(found.is_some(), least_m <= reach_m, "{at:?}");
                let is_it = |(place, away_m): (usize, f64)| {
                    off(&places[place]) == least_m && (away_m - least_m).abs() < 1e-9
                };
                assert!(found.is_none_or(is_it), "{at:?}");
                found_some += usize::from(found.is_some());
            }
            assert!(usual.contains(&found_some), "{found_some}");
        }
    }
}
