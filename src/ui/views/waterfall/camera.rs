//! Where the waterfall looks, and the arithmetic between pings, metres and the screen.

use crate::app::Orientation;
use crate::survey::Side;
use egui::{Pos2, Rect, Vec2, pos2};
use std::ops::Range;

/// Screen points that a ping or a sample takes at most.
const LARGEST_TEXEL: f64 = 48.0;
/// Pings in a screen point beyond which a picture that is opened starts at its beginning instead of showing all.
const READABLE_PINGS: f64 = 4.0;

/// What there is to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    /// Pings of the survey.
    pub pings: f64,
    /// Farthest slant range to each side, metres.
    pub far_m: f64,
    /// Slant range of the finest sample, metres.
    pub bin_m: f64,
}

/// One axis: what is in its middle and how much a screen point covers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Axis {
    centre: f64,
    per_point: f64,
    /// Follows the size of the window.
    fitted: bool,
}

impl Axis {
    fn fit(&mut self, from: f64, to: f64, points: f64) {
        self.centre = (from + to) / 2.0;
        self.per_point = (to - from) / points;
        self.fitted = true;
    }

    /// Keeps the value at `offset` points from the middle where it is.
    fn zoom(&mut self, factor: f64, offset: f64) {
        let at = self.centre + offset * self.per_point;
        self.per_point /= factor;
        self.centre = at - offset * self.per_point;
        self.fitted = false;
    }

    fn settle(&mut self, from: f64, to: f64, points: f64, finest: f64) {
        let whole = (to - from) / points;
        if self.fitted || self.per_point >= whole.max(finest) {
            self.fit(from, to, points);
            return;
        }
        self.per_point = self.per_point.clamp(finest.min(whole), whole.max(finest));
        let half = self.per_point * points / 2.0;
        self.centre = if 2.0 * half >= to - from {
            (from + to) / 2.0
        } else {
            self.centre.clamp(from + half, to - half)
        };
    }
}

/// Where the view looks. Along: ping numbers. Across: metres, port negative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Camera {
    along: Axis,
    across: Axis,
}

impl Camera {
    /// The whole range across; all pings, or as many from the first as can be told apart.
    pub fn start(extent: &Extent, size: Size) -> Self {
        let mut camera = Self::default();
        camera.fit(extent, size);
        if camera.along.per_point > READABLE_PINGS {
            camera.along = Axis {
                centre: size.along,
                per_point: READABLE_PINGS / 2.0,
                fitted: false,
            };
        }
        camera
    }

    /// Everything.
    pub fn fit(&mut self, extent: &Extent, size: Size) {
        self.along.fit(0.0, extent.pings, size.along);
        self.across.fit(-extent.far_m, extent.far_m, size.across);
    }

    /// Exactly these pings.
    pub fn show_pings(&mut self, pings: &Range<usize>, size: Size) {
        self.along
            .fit(pings.start as f64, pings.end as f64, size.along);
        self.along.fitted = false;
    }

    /// Moves so that a ping is in the middle, unless it is well in view.
    pub fn reveal(&mut self, ping: f64, size: Size) {
        let half = self.along.per_point * size.along / 2.0;
        if (ping - self.along.centre).abs() > 0.95 * half {
            self.along.centre = ping;
            self.along.fitted = false;
        }
    }

    /// Enlarges about a place, `offset` points from the middle.
    pub fn zoom(&mut self, factor: Size, offset: Size) {
        if factor.along != 1.0 {
            self.along.zoom(factor.along, offset.along);
        }
        if factor.across != 1.0 {
            self.across.zoom(factor.across, offset.across);
        }
    }

    /// Moves the picture by screen points.
    pub fn pan(&mut self, by: Size) {
        if by.along != 0.0 {
            self.along.centre -= by.along * self.along.per_point;
            self.along.fitted = false;
        }
        if by.across != 0.0 {
            self.across.centre -= by.across * self.across.per_point;
            // A whole range that was pushed at its edge stays whole.
        }
    }

    /// Keeps the camera on the picture; fits again what follows the window's size.
    pub fn settle(&mut self, extent: &Extent, size: Size) {
        self.along
            .settle(0.0, extent.pings, size.along, 1.0 / LARGEST_TEXEL);
        let finest_m = extent.bin_m / LARGEST_TEXEL;
        self.across
            .settle(-extent.far_m, extent.far_m, size.across, finest_m);
    }
}

/// Two numbers along and across the track, whatever the orientation on screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Size {
    pub along: f64,
    pub across: f64,
}

impl Size {
    /// A screen vector read in an orientation.
    pub fn of(vector: Vec2, orientation: Orientation) -> Self {
        let (x, y) = (f64::from(vector.x), f64::from(vector.y));
        match orientation {
            Orientation::Horizontal => Self {
                along: x,
                across: y,
            },
            Orientation::Vertical => Self {
                along: y,
                across: x,
            },
        }
    }
}

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
    pub fn to_screen(&self, place: Place) -> Pos2 {
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
    pub fn to_place(&self, position: Pos2) -> Place {
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
        [metres.start, metres.end].map(|across_m| self.to_screen(Place { ping, across_m }))
    }

    /// The line along the picture at a signed range.
    pub fn line_at_range(&self, across_m: f64) -> [Pos2; 2] {
        let pings = self.pings();
        [pings.start, pings.end].map(|ping| self.to_screen(Place { ping, across_m }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXTENT: Extent = Extent {
        pings: 3453.0,
        far_m: 30.0,
        bin_m: 0.02,
    };

    fn rect() -> Rect {
        Rect::from_min_size(pos2(10.0, 20.0), egui::vec2(800.0, 300.0))
    }

    fn size(orientation: Orientation) -> Size {
        Size::of(rect().size(), orientation)
    }

    #[test]
    fn a_place_comes_back_from_the_screen() {
        for orientation in [Orientation::Horizontal, Orientation::Vertical] {
            let camera = Camera::start(&EXTENT, size(orientation));
            let lens = Lens::new(camera, rect(), orientation);
            let place = Place {
                ping: 1204.5,
                across_m: -7.25,
            };
            let back = lens.to_place(lens.to_screen(place));
            assert!((back.ping - place.ping).abs() < 0.01, "{back:?}");
            assert!((back.across_m - place.across_m).abs() < 1e-3, "{back:?}");
            assert_eq!(place.side(), Side::Port);
        }
    }

    #[test]
    fn port_is_up_or_left_and_time_runs_right_or_down() {
        let port = Place {
            ping: 0.0,
            across_m: -5.0,
        };
        let later = Place {
            ping: 100.0,
            across_m: 5.0,
        };
        for (orientation, sign) in [(Orientation::Horizontal, 1.0), (Orientation::Vertical, 1.0)] {
            let lens = Lens::new(
                Camera::start(&EXTENT, size(orientation)),
                rect(),
                orientation,
            );
            let step = lens.to_screen(later) - lens.to_screen(port);
            assert!(step.x * sign > 0.0 && step.y * sign > 0.0);
        }
    }

    #[test]
    fn zoom_keeps_the_place_under_the_pointer() {
        let orientation = Orientation::Horizontal;
        let mut camera = Camera::start(&EXTENT, size(orientation));
        let pointer = pos2(300.0, 140.0);
        let lens = Lens::new(camera, rect(), orientation);
        let before = lens.to_place(pointer);
        camera.zoom(
            Size {
                along: 3.0,
                across: 2.0,
            },
            lens.offset(pointer),
        );
        camera.settle(&EXTENT, size(orientation));
        let after = Lens::new(camera, rect(), orientation).to_place(pointer);
        assert!((after.ping - before.ping).abs() < 1e-6);
        assert!((after.across_m - before.across_m).abs() < 1e-9);
    }

    #[test]
    fn zooming_out_ends_at_the_whole_picture() {
        let size = size(Orientation::Horizontal);
        let mut camera = Camera::start(&EXTENT, size);
        camera.show_pings(&(1000..1010), size);
        for _ in 0..40 {
            let both = Size {
                along: 0.5,
                across: 0.5,
            };
            camera.zoom(both, size);
            camera.settle(&EXTENT, size);
        }
        let mut whole = Camera::default();
        whole.fit(&EXTENT, size);
        assert_eq!(camera, whole);
    }

    #[test]
    fn a_long_log_starts_readable_at_its_first_ping() {
        let extent = Extent {
            pings: 1e6,
            ..EXTENT
        };
        let camera = Camera::start(&extent, size(Orientation::Horizontal));
        let lens = Lens::new(camera, rect(), Orientation::Horizontal);
        assert_eq!(lens.visible(1_000_000), 0..1600);
    }
}
