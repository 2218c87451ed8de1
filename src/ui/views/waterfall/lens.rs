//! Converts between pings and metres and the screen. Everything drawn over the picture or read from
//! it uses this module for the place of a ping and a range.

use super::camera::{Camera, Size};
use crate::app::Orientation;
use crate::ui::place::{across_m, side_at};
use bathyscope_bottom::picture::{PictureGeometry, PingScale, PingScales};
use bathyscope_log::survey::Side;
use egui::{Pos2, Rect, pos2};
use std::ops::Range;
use std::sync::Arc;

/// Largest number of points of a line along the picture.
const LINE_POINTS: usize = 512;

/// A place of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LensPlace {
    /// Ping number with its fraction: ping 7 is between 7 and 8.
    pub ping: f64,
    /// Slant range as recorded, metres, port negative, in any geometry of the picture.
    pub across_m: f64,
}

impl LensPlace {
    /// Creates the place at a slant range of a side.
    pub(super) fn of(ping: f64, side: Side, range_m: f64) -> Self {
        let across_m = across_m(side, range_m);
        Self { ping, across_m }
    }

    /// Returns the slant range outward on a side, metres; negative beyond the nadir.
    pub(super) fn outward_m(&self, side: Side) -> f64 {
        across_m(side, self.across_m)
    }

    /// Returns the side that the place is on.
    pub(super) fn side(&self) -> Side {
        side_at(self.across_m)
    }
}

/// Layout of the picture, independent of the camera.
#[derive(Clone, Debug, Default)]
pub(super) struct Arrangement {
    /// Direction of time.
    pub orientation: Orientation,
    /// Geometry of the across direction.
    pub geometry: PictureGeometry,
    /// True if later pings are to the left, or above.
    pub flip: bool,
    /// True if starboard is the upper or left side.
    pub starboard_first: bool,
    /// Conversion of slant ranges at each ping; `None` shows the slant range.
    pub scales: Option<Arc<PingScales>>,
}

impl Arrangement {
    /// Converts a screen vector into parts along and across, in the directions of pings and metres.
    pub(super) fn size(&self, vector: egui::Vec2) -> Size {
        let size = Size::of(vector, self.orientation);
        Size { along: if self.flip { -size.along } else { size.along }, ..size }
    }
}

/// A camera that looks into a rectangle of the screen.
#[derive(Clone, Debug)]
pub(super) struct Lens {
    pub rect: Rect,
    pub orientation: Orientation,
    arrangement: Arrangement,
    camera: Camera,
    size: Size,
}

impl Lens {
    /// Creates the lens of a picture of slant ranges, port first.
    #[cfg(test)]
    pub(super) fn new(camera: Camera, rect: Rect, orientation: Orientation) -> Self {
        let arrangement = Arrangement { orientation, ..Arrangement::default() };
        Self::arranged(camera, rect, &arrangement)
    }

    /// Creates the lens of a camera for an arrangement.
    pub(super) fn arranged(camera: Camera, rect: Rect, arrangement: &Arrangement) -> Self {
        Self {
            rect,
            orientation: arrangement.orientation,
            arrangement: arrangement.clone(),
            camera,
            size: Size::of(rect.size(), arrangement.orientation),
        }
    }

    /// Returns the geometry of the across direction.
    pub(super) fn geometry(&self) -> PictureGeometry {
        match self.arrangement.scales {
            Some(_) => self.arrangement.geometry,
            None => PictureGeometry::Slant,
        }
    }

    /// Returns true if later pings are to the left, or above.
    pub(super) fn is_flipped(&self) -> bool {
        self.arrangement.flip
    }

    /// Returns true if a side is the upper or left one.
    pub(super) fn is_first(&self, side: Side) -> bool {
        (side == Side::Port) != self.arrangement.starboard_first
    }

    /// Returns the pings at both ends of the view, with fractions; they may be beyond those of the
    /// survey.
    pub(super) fn pings(&self) -> Range<f64> {
        let half = self.camera.along.per_point * self.size.along / 2.0;
        self.camera.along.centre - half..self.camera.along.centre + half
    }

    /// Returns the ends of the view across, metres from the middle, negative on the first side.
    pub(super) fn metres(&self) -> Range<f64> {
        let half = self.camera.across.per_point * self.size.across / 2.0;
        self.camera.across.centre - half..self.camera.across.centre + half
    }

    /// Returns the visible distances of a side from the middle, metres; empty if the side is not
    /// visible.
    pub(super) fn seen_of(&self, side: Side) -> Range<f64> {
        let metres = self.metres();
        let seen = if self.is_first(side) { -metres.end..-metres.start } else { metres };
        seen.start.max(0.0)..seen.end.max(0.0)
    }

    /// Returns the number of pings per screen point.
    pub(super) fn pings_per_point(&self) -> f64 {
        self.camera.along.per_point
    }

    /// Returns the metres per screen point.
    pub(super) fn metres_per_point(&self) -> f64 {
        self.camera.across.per_point
    }

    /// Returns the visible pings that exist.
    pub(super) fn visible(&self, pings: usize) -> Range<usize> {
        let seen = self.pings();
        let end = (seen.end.ceil().max(0.0) as usize).min(pings);
        (seen.start.floor().max(0.0) as usize).min(end)..end
    }

    /// Returns the conversion of the slant ranges of a side at a ping.
    fn scale(&self, side: Side, ping: f64) -> PingScale {
        let scales = self.arrangement.scales.as_ref();
        // Beyond the first or last ping, the conversion of that ping is used.
        scales.map_or_else(PingScale::default, |scales| scales.at(side, ping as usize))
    }

    /// Returns the distance from the middle at which a recorded range of a side is shown at a ping,
    /// metres.
    pub(super) fn distance_m(&self, side: Side, ping: f64, range_m: f64) -> f64 {
        match self.geometry() {
            PictureGeometry::Slant => range_m,
            geometry => self.scale(side, ping).across_m(geometry, range_m),
        }
    }

    /// Returns the screen position of a place.
    pub(super) fn screen_at(&self, place: LensPlace) -> Pos2 {
        let side = place.side();
        let shown_m = self.distance_m(side, place.ping, place.across_m.abs());
        self.at(place.ping, self.signed_m(side, shown_m))
    }

    /// Returns a distance from the middle with the sign of its side on the screen.
    pub(super) fn signed_m(&self, side: Side, shown_m: f64) -> f64 {
        if self.is_first(side) { -shown_m } else { shown_m }
    }

    /// Returns the screen position of a ping at a shown distance from the middle, metres, negative
    /// on the first side.
    pub(super) fn at(&self, ping: f64, shown_m: f64) -> Pos2 {
        let Camera { along, across, .. } = &self.camera;
        let centre = self.rect.center();
        let sign = if self.arrangement.flip { -1.0 } else { 1.0 };
        let a = (sign * (ping - along.centre) / along.per_point) as f32;
        let b = ((shown_m - across.centre) / across.per_point) as f32;
        match self.orientation {
            Orientation::Horizontal => pos2(centre.x + a, centre.y + b),
            Orientation::Vertical => pos2(centre.x + b, centre.y + a),
        }
    }

    /// Returns the place at a screen position.
    pub(super) fn place_at(&self, position: Pos2) -> LensPlace {
        let offset = self.offset(position);
        let Camera { along, across, .. } = &self.camera;
        let ping = along.centre + offset.along * along.per_point;
        let shown_m = across.centre + offset.across * across.per_point;
        let side =
            if (shown_m < 0.0) == self.is_first(Side::Port) { Side::Port } else { Side::Starboard };
        let range_m = match self.geometry() {
            PictureGeometry::Slant => shown_m.abs(),
            geometry => {
                let scale = self.scale(side, ping);
                scale.recorded_at_m(geometry, shown_m.abs()).max(0.0)
            }
        };
        LensPlace::of(ping, side, range_m)
    }

    /// Returns the offset of a position from the middle of the rectangle, points, in the directions
    /// of pings and metres.
    pub(super) fn offset(&self, position: Pos2) -> Size {
        self.arrangement.size(position - self.rect.center())
    }

    /// Returns the line across the picture at a ping.
    pub(super) fn line_at_ping(&self, ping: f64) -> [Pos2; 2] {
        let metres = self.metres();
        [metres.start, metres.end].map(|shown_m| self.at(ping, shown_m))
    }

    /// Returns the line along the picture at a signed recorded range: straight, or bent where the
    /// altitude changes.
    pub(super) fn line_at_range(&self, across_m: f64) -> Vec<Pos2> {
        let pings = self.pings();
        let steps = match self.geometry() {
            PictureGeometry::Slant => 1,
            _ => LINE_POINTS,
        };
        let ping = |step: usize| {
            let share = step as f64 / steps as f64;
            pings.start + share * (pings.end - pings.start)
        };
        (0..=steps)
            .map(|step| {
                let ping = ping(step);
                self.screen_at(LensPlace { ping, across_m })
            })
            .collect()
    }

    /// Returns the straight line along the picture at a shown distance from the middle.
    pub(super) fn line_at_distance(&self, side: Side, shown_m: f64) -> [Pos2; 2] {
        let pings = self.pings();
        let shown_m = self.signed_m(side, shown_m);
        [pings.start, pings.end].map(|ping| self.at(ping, shown_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::views::waterfall::camera::{EXTENT, rect, size};

    const BOTH: [Orientation; 2] = [Orientation::Horizontal, Orientation::Vertical];

    fn lens(orientation: Orientation) -> Lens {
        let camera = Camera::start(&EXTENT, size(orientation));
        Lens::new(camera, rect(), orientation)
    }

    /// Returns a lens with flipped time, starboard first, and a bottom at 4 m.
    fn turned(orientation: Orientation, geometry: PictureGeometry) -> Lens {
        let plain = lens(orientation);
        let arrangement = Arrangement {
            orientation,
            geometry,
            flip: true,
            starboard_first: true,
            scales: Some(Arc::new(PingScales::level(3453, 4.0))),
        };
        Lens::arranged(plain.camera, plain.rect, &arrangement)
    }

    #[test]
    fn a_place_comes_back_from_the_screen() {
        let geometries =
            [PictureGeometry::Slant, PictureGeometry::SlantBeyondWater, PictureGeometry::Ground];
        for orientation in BOTH {
            let turned = geometries.map(|geometry| turned(orientation, geometry));
            for lens in [lens(orientation)].into_iter().chain(turned) {
                let place = LensPlace { ping: 1204.5, across_m: -7.25 };
                let back = lens.place_at(lens.screen_at(place));
                assert!((back.ping - place.ping).abs() < 0.01, "{back:?}");
                assert!((back.across_m - place.across_m).abs() < 1e-3, "{back:?}");
                assert_eq!(place.side(), Side::Port);
            }
        }
    }

    #[test]
    fn starboard_and_later_are_to_the_right_and_down() {
        let place = |ping, across_m| LensPlace { ping, across_m };
        for orientation in BOTH {
            let towards = |lens: Lens| {
                let at = |ping, across_m| lens.screen_at(place(ping, across_m));
                let later = at(100.0, -5.0) - at(0.0, -5.0);
                let starboard = at(0.0, 5.0) - at(0.0, -5.0);
                match orientation {
                    Orientation::Horizontal => (later.x, starboard.y),
                    Orientation::Vertical => (later.y, starboard.x),
                }
            };
            let (time, range) = towards(lens(orientation));
            assert!(time > 0.0 && range > 0.0, "{orientation:?}");
            let (time, range) = towards(turned(orientation, PictureGeometry::Slant));
            assert!(time < 0.0 && range < 0.0, "{orientation:?}");
        }
    }

    #[test]
    fn ground_range_is_the_side_of_the_triangle() {
        let lens = turned(Orientation::Horizontal, PictureGeometry::Ground);
        // A slant range of 5 m over 4 m of water is 3 m on the ground.
        assert!((lens.distance_m(Side::Port, 7.0, 5.0) - 3.0).abs() < 1e-6);
        assert_eq!(lens.distance_m(Side::Port, 7.0, 2.0), 0.0);
        let line = lens.line_at_range(-5.0);
        let [start, end] = lens.line_at_distance(Side::Port, 3.0);
        assert!((line[0] - start).length() < 0.01);
        assert!((line[line.len() - 1] - end).length() < 0.01);
    }
}
