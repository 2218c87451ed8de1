//! Defines the view of the waterfall, and its limits.

use crate::app::Orientation;
use egui::Vec2;
use std::ops::Range;

/// Most screen points that a ping or a sample covers.
const LARGEST_TEXEL: f64 = 48.0;
/// Pings per screen point above which a newly opened picture shows its beginning instead of all
/// pings.
const READABLE_PINGS: f64 = 4.0;

/// Extent of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PictureExtent {
    /// Number of pings of the survey.
    pub pings: f64,
    /// End of the picture at the upper or left edge, metres from the middle: negative if a side is
    /// shown there, 0 if the picture begins at the middle.
    pub near_m: f64,
    /// Farthest slant range, metres.
    pub far_m: f64,
    /// Slant range of the finest sample, metres.
    pub bin_m: f64,
    /// Usual distance from one ping to the next, metres; `None` where it is not known.
    pub ping_m: Option<f64>,
}

/// View along one axis: the value in the middle of the view, and the extent that a screen point
/// covers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CameraAxis {
    pub centre: f64,
    pub per_point: f64,
    /// True if the view shows the whole axis and follows the size of the window.
    fitted: bool,
}

impl CameraAxis {
    fn fit(&mut self, from: f64, to: f64, points: f64) {
        self.centre = (from + to) / 2.0;
        self.per_point = (to - from) / points;
        self.fitted = true;
    }

    /// Enlarges by `factor`; the value at `offset` points from the middle stays at its place on the
    /// screen.
    fn zoom(&mut self, factor: f64, offset: f64) {
        let at = self.centre + offset * self.per_point;
        self.per_point /= factor;
        self.centre = at - offset * self.per_point;
        self.fitted = false;
    }

    /// Moves a range into the middle, unless all of it is in the inner part of the view, or the
    /// view shows the whole axis.
    fn bring_in(&mut self, [from, to]: [f64; 2], points: f64) {
        let inner = WELL_IN_VIEW * self.per_point * points / 2.0;
        if !self.fitted && (from < self.centre - inner || to > self.centre + inner) {
            self.centre = (from + to) / 2.0;
        }
    }

    /// Sets the scale to a given one; a picture that is shorter than the view is then in its
    /// middle.
    fn settle_at(&mut self, per_point: f64, to: f64, points: f64) {
        self.per_point = per_point;
        self.fitted = false;
        let half = per_point * points / 2.0;
        self.centre = if 2.0 * half >= to { to / 2.0 } else { self.centre.clamp(half, to - half) };
    }

    fn settle(&mut self, from: f64, to: f64, points: f64, finest: f64) {
        let whole = (to - from) / points;
        if self.fitted || self.per_point >= whole.max(finest) {
            return self.fit(from, to, points);
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

/// Share of the view, around its middle, in which nothing needs to be moved.
const WELL_IN_VIEW: f64 = 0.7;
/// Size of the view divided by that of an object shown close up.
const CLOSE_UP: f64 = 3.0;
/// Size of the view divided by that of an object that is too large for one to one, so that its
/// surroundings are visible, too.
const FITS: f64 = 2.0;

/// View of the waterfall. Along: ping numbers. Across: metres, port negative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Camera {
    pub along: CameraAxis,
    pub across: CameraAxis,
    /// True if a metre along is as long on the screen as a metre across.
    pub is_one_to_one: bool,
    /// Metres from one ping to the next for equal scales; `None` for the usual distance of the
    /// extent.
    ping_m: Option<f64>,
}

impl Camera {
    /// Creates the first view: the whole range across, and one to one from the first ping on. If
    /// the boat's speed is not known, it shows all pings, or as many from the first on as can be
    /// distinguished.
    pub(super) fn start(extent: &PictureExtent, size: Size) -> Self {
        let mut camera = Self::default();
        camera.fit(extent, size);
        if let Some(ping_m) = extent.ping_m {
            camera.is_one_to_one = true;
            camera.along = CameraAxis {
                centre: 0.5 * size.along * camera.across.per_point / ping_m,
                ..CameraAxis::default()
            };
        } else if camera.along.per_point > READABLE_PINGS {
            camera.along =
                CameraAxis { centre: size.along, per_point: READABLE_PINGS / 2.0, fitted: false };
        }
        camera
    }

    /// Shows everything, with separate scales along and across.
    pub(super) fn fit(&mut self, extent: &PictureExtent, size: Size) {
        self.is_one_to_one = false;
        self.along.fit(0.0, extent.pings, size.along);
        self.across.fit(extent.near_m, extent.far_m, size.across);
    }

    /// Returns the ends of the view: first and last ping, and both ends across, metres.
    pub(super) fn seen(&self, size: Size) -> [f64; 4] {
        let ends = |axis: &CameraAxis, points: f64| {
            let half = 0.5 * axis.per_point * points;
            [axis.centre - half, axis.centre + half]
        };
        let [from, to] = ends(&self.along, size.along);
        let [port, starboard] = ends(&self.across, size.across);
        [from, to, port, starboard]
    }

    /// Shows the ends that [`Camera::seen`] returned, also in a view of another size.
    pub(super) fn show(&mut self, [from, to, port, starboard]: [f64; 4], size: Size) {
        self.along.fit(from, to, size.along);
        self.across.fit(port, starboard, size.across);
        self.along.fitted = false;
        self.across.fitted = false;
        self.is_one_to_one = false;
    }

    /// Keeps the first visible ping at its edge of a view that has become longer or shorter, so
    /// that a panel that appears beside the view moves nothing under the pointer.
    pub(super) fn keep_start(&mut self, before: Size, size: Size) {
        if !self.along.fitted && before.across == size.across {
            self.along.centre += 0.5 * (size.along - before.along) * self.along.per_point;
        }
    }

    /// Shows exactly these pings.
    pub(super) fn show_pings(&mut self, pings: &Range<usize>, size: Size) {
        self.is_one_to_one = false;
        self.along.fit(pings.start as f64, pings.end as f64, size.along);
        self.along.fitted = false;
    }

    /// Moves the view so that a ping is in the middle, unless the ping is already in the view and
    /// not at its edge.
    pub(super) fn reveal(&mut self, ping: f64, size: Size) {
        let half = self.along.per_point * size.along / 2.0;
        if (ping - self.along.centre).abs() > 0.95 * half {
            self.along.centre = ping;
            self.along.fitted = false;
        }
    }

    /// Moves the view along so that the end of the log is at its edge; a view of the whole log is
    /// not changed.
    pub(super) fn show_end(&mut self, pings: f64, size: Size) {
        if !self.along.fitted {
            self.along.centre = pings - 0.5 * self.along.per_point * size.along;
        }
    }

    /// Takes the view along the track from the camera of another part of the view. If that camera
    /// has no view yet, it gets the one of this camera first.
    pub(super) fn share_along(&mut self, other: &mut Self, extent: &PictureExtent, size: Size) {
        if other.along.per_point <= 0.0 {
            self.settle(extent, size);
            other.along = self.along;
            other.is_one_to_one = self.is_one_to_one;
        }
        self.along = other.along;
        self.is_one_to_one = false;
    }

    /// Copies the view along the track from another part of the view.
    pub(super) fn take_along(&mut self, other: &Self) {
        if self.along.per_point != other.along.per_point {
            self.is_one_to_one = false;
        }
        self.along = other.along;
    }

    /// Keeps the range across within the picture; the view along the track stays.
    pub(super) fn settle_across(&mut self, extent: &PictureExtent, size: Size) {
        let finest_m = extent.bin_m / LARGEST_TEXEL;
        self.across.settle(extent.near_m, extent.far_m, size.across, finest_m);
    }

    /// Shows these pings and ranges so that they fill about a third of the view, with equal scales
    /// along and across if `metres_per_ping` is known.
    pub(super) fn close_up(
        &mut self,
        pings: [f64; 2],
        across_m: [f64; 2],
        metres_per_ping: Option<f64>,
        size: Size,
    ) {
        let [ping_count, range_m] = [pings, across_m].map(|[from, to]| to - from);
        let mut per_point = [CLOSE_UP * ping_count / size.along, CLOSE_UP * range_m / size.across];
        if let Some(metres) = metres_per_ping {
            let larger_m = per_point[1].max(per_point[0] * metres);
            per_point = [larger_m / metres, larger_m];
        }
        self.centre_on(pings, across_m, per_point);
    }

    /// Moves these pings and ranges into the middle unless they are already in the inner part of
    /// the view; the scale stays.
    pub(super) fn bring_in(&mut self, pings: [f64; 2], across_m: [f64; 2], size: Size) {
        self.along.bring_in(pings, size.along);
        self.across.bring_in(across_m, size.across);
    }

    /// Moves these pings and ranges into the middle at a scale: pings and metres per screen point.
    fn centre_on(&mut self, pings: [f64; 2], across_m: [f64; 2], per_point: [f64; 2]) {
        let axis = |[from, to]: [f64; 2], per_point: f64| CameraAxis {
            centre: 0.5 * (from + to),
            per_point,
            fitted: false,
        };
        self.is_one_to_one = false;
        self.along = axis(pings, per_point[0]);
        self.across = axis(across_m, per_point[1]);
    }

    /// Shows these pings and ranges in the middle with one sample per screen point, and with equal
    /// scales along and across if `metres_per_ping` is known; smaller if they would fill more than
    /// half of the view.
    pub(super) fn sample_to_point(
        &mut self,
        (pings, across_m): ([f64; 2], [f64; 2]),
        metres_per_ping: Option<f64>,
        extent: &PictureExtent,
        size: Size,
    ) {
        let [ping_count, range_m] = [pings, across_m].map(|[from, to]| to - from);
        let fits = [FITS * ping_count / size.along, FITS * range_m / size.across];
        let per_point = match metres_per_ping {
            Some(metres) => {
                let across = extent.bin_m.max(fits[1]).max(fits[0] * metres);
                [across / metres, across]
            }
            None => [fits[0].max(1.0), fits[1].max(extent.bin_m)],
        };
        self.centre_on(pings, across_m, per_point);
    }

    /// Makes a metre along the track as long as one across, from the metres per ping at a ping,
    /// which moves into the middle.
    pub(super) fn equal_scales(&mut self, metres_per_ping: f64, ping: f64) {
        self.is_one_to_one = true;
        self.ping_m = Some(metres_per_ping);
        self.along.centre = ping;
    }

    /// Switches to one to one by the usual speed, keeping the middle of the view; or back from one
    /// to one to everything along the track.
    pub(super) fn toggle_one_to_one(&mut self, extent: &PictureExtent, size: Size) {
        self.ping_m = None;
        if self.is_one_to_one {
            self.is_one_to_one = false;
            self.along.fit(0.0, extent.pings, size.along);
        } else {
            self.is_one_to_one = extent.ping_m.is_some()
        }
    }

    /// Returns the ratio of the drawn length of a metre along to that of a metre across; `None`
    /// where the boat's speed is not known.
    pub(super) fn stretch(&self, extent: &PictureExtent) -> Option<f64> {
        let ping_m = self.ping_m.or(extent.ping_m)?;
        Some(self.across.per_point / (self.along.per_point * ping_m))
    }

    /// Enlarges about the place that is `offset` points from the middle.
    pub(super) fn zoom(&mut self, factor: Size, offset: Size) {
        if factor.along != factor.across {
            self.is_one_to_one = false;
        }
        if factor.along != 1.0 {
            self.along.zoom(factor.along, offset.along);
        }
        if factor.across != 1.0 {
            self.across.zoom(factor.across, offset.across);
        }
    }

    /// Moves the picture by screen points.
    pub(super) fn pan(&mut self, by: Size) {
        if by.along != 0.0 {
            self.along.centre -= by.along * self.along.per_point;
            self.along.fitted = false;
        }
        if by.across != 0.0 {
            self.across.centre -= by.across * self.across.per_point;
            // A range that is shown as a whole stays whole when it is pushed at its edge.
        }
    }

    /// Keeps the view within the picture; fits the axes that follow the window's size again.
    pub(super) fn settle(&mut self, extent: &PictureExtent, size: Size) {
        self.settle_across(extent, size);
        let ping_m = self.ping_m.or(extent.ping_m);
        match ping_m.filter(|_| self.is_one_to_one) {
            Some(ping_m) => {
                let per_point = self.across.per_point / ping_m;
                self.along.settle_at(per_point, extent.pings, size.along);
            }
            None => {
                self.along.settle(0.0, extent.pings, size.along, 1.0 / LARGEST_TEXEL);
            }
        }
    }
}

/// Two numbers along and across the track, whatever the orientation on screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Size {
    pub along: f64,
    pub across: f64,
}

impl Size {
    pub(super) fn new(along: f64, across: f64) -> Self {
        Self { along, across }
    }

    /// Creates a size with the same value along and across.
    pub(super) fn both(value: f64) -> Self {
        Self::new(value, value)
    }

    /// Returns the parts of a screen vector along and across the track.
    pub(super) fn of(vector: Vec2, orientation: Orientation) -> Self {
        let (x, y) = (f64::from(vector.x), f64::from(vector.y));
        match orientation {
            Orientation::Horizontal => Self::new(x, y),
            Orientation::Vertical => Self::new(y, x),
        }
    }
}

#[cfg(test)]
pub(super) const EXTENT: PictureExtent =
    PictureExtent { pings: 3453.0, near_m: -30.0, far_m: 30.0, bin_m: 0.02, ping_m: None };

#[cfg(test)]
pub(super) fn rect() -> egui::Rect {
    egui::Rect::from_min_size(egui::pos2(10.0, 20.0), egui::vec2(800.0, 300.0))
}

#[cfg(test)]
pub(super) fn size(orientation: Orientation) -> Size {
    Size::of(rect().size(), orientation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::views::waterfall::lens::Lens;
    use egui::pos2;

    #[test]
    fn zoom_keeps_the_place_under_the_pointer() {
        let orientation = Orientation::Horizontal;
        let mut camera = Camera::start(&EXTENT, size(orientation));
        let pointer = pos2(300.0, 140.0);
        let lens = Lens::new(camera, rect(), orientation);
        let before = lens.place_at(pointer);
        camera.zoom(Size::new(3.0, 2.0), lens.offset(pointer));
        camera.settle(&EXTENT, size(orientation));
        let after = Lens::new(camera, rect(), orientation).place_at(pointer);
        assert!((after.ping - before.ping).abs() < 1e-6);
        assert!((after.across_m - before.across_m).abs() < 1e-9);
    }

    #[test]
    fn what_lies_near_an_edge_comes_into_the_middle_and_the_scale_stays() {
        let size = size(Orientation::Horizontal);
        let mut camera = Camera::default();
        camera.show([1000.0, 1400.0, -10.0, 10.0], size);
        let before = camera;
        camera.bring_in([1190.0, 1202.0], [-4.0, -2.0], size);
        assert_eq!(camera, before, "it is well in view");
        // The last ping of the box is in the view, at its edge.
        camera.bring_in([1380.0, 1392.0], [-4.0, -2.0], size);
        assert_eq!(camera.seen(size), [1186.0, 1586.0, -10.0, 10.0]);
        camera.bring_in([1380.0, 1392.0], [24.0, 28.0], size);
        assert_eq!(camera.seen(size), [1186.0, 1586.0, 16.0, 36.0]);
        // A view of the whole log stays one.
        camera.fit(&EXTENT, size);
        let whole = camera;
        camera.bring_in([3440.0, 3450.0], [24.0, 28.0], size);
        assert_eq!(camera, whole);
    }

    #[test]
    fn a_view_that_becomes_narrower_keeps_its_first_ping() {
        let size = size(Orientation::Horizontal);
        let mut camera = Camera::start(&EXTENT, size);
        camera.show_pings(&(1000..1400), size);
        let narrower = Size::new(0.75 * size.along, size.across);
        camera.keep_start(size, narrower);
        let [from, to, ..] = camera.seen(narrower);
        assert!((from - 1000.0).abs() < 1e-6 && (to - 1300.0).abs() < 1e-6, "{from} to {to}");
    }

    #[test]
    fn zooming_out_ends_at_the_whole_picture() {
        let size = size(Orientation::Horizontal);
        let mut camera = Camera::start(&EXTENT, size);
        camera.show_pings(&(1000..1010), size);
        for _ in 0..40 {
            camera.zoom(Size::both(0.5), size);
            camera.settle(&EXTENT, size);
        }
        let mut whole = Camera::default();
        whole.fit(&EXTENT, size);
        assert_eq!(camera, whole);
    }

    #[test]
    fn a_long_log_starts_readable_at_its_first_ping() {
        let extent = PictureExtent { pings: 1e6, ..EXTENT };
        let camera = Camera::start(&extent, size(Orientation::Horizontal));
        let lens = Lens::new(camera, rect(), Orientation::Horizontal);
        assert_eq!(lens.visible(1_000_000), 0..1600);
    }

    #[test]
    fn equal_scales_make_a_metre_a_metre() {
        let orientation = Orientation::Horizontal;
        let mut camera = Camera::start(&EXTENT, size(orientation));
        camera.equal_scales(0.1, 1204.5);
        camera.settle(&EXTENT, size(orientation));
        let lens = Lens::new(camera, rect(), orientation);
        assert!((lens.pings_per_point() * 0.1 - lens.metres_per_point()).abs() < 1e-12);
        assert!((lens.place_at(rect().center()).ping - 1204.5).abs() < 1e-6);
    }

    #[test]
    fn a_picture_begins_one_to_one_until_it_is_stretched() {
        let size = size(Orientation::Horizontal);
        let extent = PictureExtent { ping_m: Some(0.25), ..EXTENT };
        let mut camera = Camera::start(&extent, size);
        camera.settle(&extent, size);
        // 60 m in 300 points: 800 points are 160 m, 640 pings.
        let [from, to, ..] = camera.seen(size);
        assert!(from.abs() < 1e-9 && (to - 640.0).abs() < 1e-9, "{from} {to}");
        camera.zoom(Size::both(2.0), Size::both(0.0));
        camera.settle(&extent, size);
        assert!((camera.stretch(&extent).expect("a speed") - 1.0).abs() < 1e-9);
        camera.zoom(Size::new(3.0, 1.0), Size::both(0.0));
        camera.settle(&extent, size);
        assert!(!camera.is_one_to_one);
        assert!((camera.stretch(&extent).expect("a speed") - 3.0).abs() < 1e-9);
        camera.toggle_one_to_one(&extent, size);
        camera.settle(&extent, size);
        assert!(camera.is_one_to_one);
        camera.fit(&extent, size);
        assert_eq!(camera.seen(size), [0.0, 3453.0, -30.0, 30.0]);
    }
}
