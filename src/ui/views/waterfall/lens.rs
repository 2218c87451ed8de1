//! The arithmetic between pings and metres and the screen: the one owner of how a ping and a range
//! lie there, for all that is drawn over the picture and all that is read off it.

use super::camera::{Camera, Size};
use crate::app::Orientation;
use crate::ui::place::{across_m, side_at};
use bathyscope_bottom::picture::{PictureGeometry, PingScale, PingScales};
use bathyscope_log::survey::Side;
use egui::{Pos2, Rect, pos2};
use std::ops::Range;
use std::sync::Arc;

/// Points of a line along the picture, at most.
const LINE_POINTS: usize = 512;

/// A place of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LensPlace {
    /// Ping number with its fraction: ping 7 lies between 7 and 8.
    pub ping: f64,
    /// Slant range as recorded, metres, port negative: whatever is shown across.
    pub across_m: f64,
}

impl LensPlace {
    /// Creates the place at a slant range of a side.
    pub(super) fn of(ping: f64, side: Side, range_m: f64) -> Self {
        let across_m = across_m(side, range_m);
        Self { ping, across_m }
    }

    /// Slant range counted outward on a side; negative beyond the nadir.
    pub(super) fn outward_m(&self, side: Side) -> f64 {
        across_m(side, self.across_m)
    }

    /// The side it lies on.
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
    /// Later pings to the left, or above.
    pub flip: bool,
    /// Starboard first.
    pub starboard_first: bool,
    /// Conversion of slant ranges at each ping; without it, slant range is shown.
    pub scales: Option<Arc<PingScales>>,
}

impl Arrangement {
    /// A screen vector as pings and metres run.
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
    /// Slant ranges, port first.
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

    /// Geometry of the across direction.
    pub(super) fn geometry(&self) -> PictureGeometry {
        match self.arrangement.scales {
            Some(_) => self.arrangement.geometry,
            None => PictureGeometry::Slant,
        }
    }

    /// Returns true if later pings lie to the left, or above.
    pub(super) fn is_flipped(&self) -> bool {
        self.arrangement.flip
    }

    /// Returns true if a side is the upper or left one.
    pub(super) fn is_first(&self, side: Side) -> bool {
        (side == Side::Port) != self.arrangement.starboard_first
    }

    /// Pings at both ends, fractions included; may lie beyond the survey's.
    pub(super) fn pings(&self) -> Range<f64> {
        let half = self.camera.along.per_point * self.size.along / 2.0;
        self.camera.along.centre - half..self.camera.along.centre + half
    }

    /// Ends of the view across, metres from the middle, negative on the side that is first.
    pub(super) fn metres(&self) -> Range<f64> {
        let half = self.camera.across.per_point * self.size.across / 2.0;
        self.camera.across.centre - half..self.camera.across.centre + half
    }

    /// Distances from the middle that are seen of a side, metres; empty where none is.
    pub(super) fn seen_of(&self, side: Side) -> Range<f64> {
        let metres = self.metres();
        let seen = if self.is_first(side) { -metres.end..-metres.start } else { metres };
        seen.start.max(0.0)..seen.end.max(0.0)
    }

    /// Pings in a screen point.
    pub(super) fn pings_per_point(&self) -> f64 {
        self.camera.along.per_point
    }

    /// Metres in a screen point.
    pub(super) fn metres_per_point(&self) -> f64 {
        self.camera.across.per_point
    }

    /// The pings in view that exist.
    pub(super) fn visible(&self, pings: usize) -> Range<usize> {
        let seen = self.pings();
        let end = (seen.end.ceil().max(0.0) as usize).min(pings);
        (seen.start.floor().max(0.0) as usize).min(end)..end
    }

    /// Conversion of the slant ranges of a side at a ping.
    fn scale(&self, side: Side, ping: f64) -> PingScale {
        let scales = self.arrangement.scales.as_ref();
        // Beyond the first and last ping, theirs.
        scales.map_or_else(PingScale::default, |scales| scales.at(side, ping as usize))
    }

    /// Distance from the middle at which a recorded range of a side is shown at a ping, metres.
    pub(super) fn distance_m(&self, side: Side, ping: f64, range_m: f64) -> f64 {
        match self.geometry() {
            PictureGeometry::Slant => range_m,
            geometry => self.scale(side, ping).across_m(geometry, range_m),
        }
    }

    /// Screen position of a place.
    pub(super) fn screen_at(&self, place: LensPlace) -> Pos2 {
        let side = place.side();
        let shown_m = self.distance_m(side, place.ping, place.across_m.abs());
        self.at(place.ping, self.signed_m(side, shown_m))
    }

    /// A distance from the middle with the sign of where its side is shown.
    pub(super) fn signed_m(&self, side: Side, shown_m: f64) -> f64 {
        if self.is_first(side) { -shown_m } else { shown_m }
    }

    /// Screen position of a ping at metres from the middle as shown, negative on the side that is
    /// first.
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

    /// Place at a screen position.
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

    /// Points from the middle of the rectangle, as pings and metres run.
    pub(super) fn offset(&self, position: Pos2) -> Size {
        self.arrangement.size(position - self.rect.center())
    }

    /// The line across the picture at a ping.
    pub(super) fn line_at_ping(&self, ping: f64) -> [Pos2; 2] {
        let metres = self.metres();
        [metres.start, metres.end].map(|shown_m| self.at(ping, shown_m))
    }

    /// The line along the picture at a signed range as recorded: straight, but where altitudes bend
    /// it.
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

    /// The straight line along the picture at a distance from the middle as shown.
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

    /// The same with everything that can be turned, over ground 4 m down.
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
        // 5 m of slant range over 4 m of water are 3 m on the ground.
        assert!((lens.distance_m(Side::Port, 7.0, 5.0) - 3.0).abs() < 1e-6);
        assert_eq!(lens.distance_m(Side::Port, 7.0, 2.0), 0.0);
        let line = lens.line_at_range(-5.0);
        let [start, end] = lens.line_at_distance(Side::Port, 3.0);
        assert!((line[0] - start).length() < 0.01);
        assert!((line[line.len() - 1] - end).length() < 0.01);
    }
}
