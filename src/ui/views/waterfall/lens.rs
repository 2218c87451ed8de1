//! The arithmetic between pings and metres and the screen.

use super::camera::{Camera, Size};
use crate::app::Orientation;
use crate::survey::Side;
use egui::{Pos2, Rect, pos2};
use std::ops::Range;

/// A place of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// Ping number with its fraction: ping 7 lies between 7 and 8.
    pub ping: f64,
    /// Slant range, metres, port negative.
    pub across_m: f64,
}

impl Place {
    /// The side it lies on.
    pub fn side(&self) -> Side {
        if self.across_m < 0.0 {
            Side::Port
        } else {
            Side::Starboard
        }
    }
}

/// A slant range with the sign of its side.
pub(super) fn across_m(side: Side, range_m: f64) -> f64 {
    match side {
        Side::Port => -range_m,
        Side::Starboard => range_m,
    }
}

/// A camera that looks into a rectangle of the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lens {
    pub rect: Rect,
    pub orientation: Orientation,
    camera: Camera,
    size: Size,
}

impl Lens {
    pub fn new(camera: Camera, rect: Rect, orientation: Orientation) -> Self {
        Self {
            rect,
            orientation,
            camera,
            size: Size::of(rect.size(), orientation),
        }
    }

    /// Pings at both ends, fractions included; may lie beyond the survey's.
    pub fn pings(&self) -> Range<f64> {
        let half = self.camera.along.per_point * self.size.along / 2.0;
        self.camera.along.centre - half..self.camera.along.centre + half
    }

    /// Signed metres at both ends.
    pub fn metres(&self) -> Range<f64> {
        let half = self.camera.across.per_point * self.size.across / 2.0;
        self.camera.across.centre - half..self.camera.across.centre + half
    }

    /// Pings in a screen point.
    pub fn pings_per_point(&self) -> f64 {
        self.camera.along.per_point
    }

    /// Metres in a screen point.
    pub fn metres_per_point(&self) -> f64 {
        self.camera.across.per_point
    }

    /// The pings in view that exist.
    pub fn visible(&self, pings: usize) -> Range<usize> {
        let seen = self.pings();
        let end = (seen.end.ceil().max(0.0) as usize).min(pings);
        (seen.start.floor().max(0.0) as usize).min(end)..end
    }

    /// Screen position of a place.
    pub fn screen_at(&self, place: Place) -> Pos2 {
        let Camera { along, across } = &self.camera;
        let centre = self.rect.center();
        let a = ((place.ping - along.centre) / along.per_point) as f32;
        let b = ((place.across_m - across.centre) / across.per_point) as f32;
        match self.orientation {
            Orientation::Horizontal => pos2(centre.x + a, centre.y + b),
            Orientation::Vertical => pos2(centre.x + b, centre.y + a),
        }
    }

    /// Place at a screen position.
    pub fn place_at(&self, position: Pos2) -> Place {
        let offset = self.offset(position);
        let Camera { along, across } = &self.camera;
        Place {
            ping: along.centre + offset.along * along.per_point,
            across_m: across.centre + offset.across * across.per_point,
        }
    }

    /// Points from the middle of the rectangle.
    pub fn offset(&self, position: Pos2) -> Size {
        Size::of(position - self.rect.center(), self.orientation)
    }

    /// The line across the picture at a ping.
    pub fn line_at_ping(&self, ping: f64) -> [Pos2; 2] {
        let metres = self.metres();
        [metres.start, metres.end].map(|across_m| self.screen_at(Place { ping, across_m }))
    }

    /// The line along the picture at a signed range.
    pub fn line_at_range(&self, across_m: f64) -> [Pos2; 2] {
        let pings = self.pings();
        [pings.start, pings.end].map(|ping| self.screen_at(Place { ping, across_m }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::views::waterfall::camera::Extent;

    const BOTH: [Orientation; 2] = [Orientation::Horizontal, Orientation::Vertical];

    fn lens(orientation: Orientation) -> Lens {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), egui::vec2(800.0, 300.0));
        let extent = Extent {
            pings: 3453.0,
            far_m: 30.0,
            bin_m: 0.02,
        };
        let camera = Camera::start(&extent, Size::of(rect.size(), orientation));
        Lens::new(camera, rect, orientation)
    }

    #[test]
    fn a_place_comes_back_from_the_screen() {
        for orientation in BOTH {
            let lens = lens(orientation);
            let place = Place {
                ping: 1204.5,
                across_m: -7.25,
            };
            let back = lens.place_at(lens.screen_at(place));
            assert!((back.ping - place.ping).abs() < 0.01, "{back:?}");
            assert!((back.across_m - place.across_m).abs() < 1e-3, "{back:?}");
            assert_eq!(place.side(), Side::Port);
        }
    }

    #[test]
    fn starboard_and_later_are_to_the_right_and_down() {
        let place = |ping, across_m| Place { ping, across_m };
        for orientation in BOTH {
            let lens = lens(orientation);
            let at = |ping, across_m| lens.screen_at(place(ping, across_m));
            let later = at(100.0, -5.0) - at(0.0, -5.0);
            let starboard = at(0.0, 5.0) - at(0.0, -5.0);
            let (time, range) = match orientation {
                Orientation::Horizontal => (later.x, starboard.y),
                Orientation::Vertical => (later.y, starboard.x),
            };
            assert!(time > 0.0 && range > 0.0, "{orientation:?}");
        }
    }
}
