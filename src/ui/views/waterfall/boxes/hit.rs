//! Finds the edges of a box under the pointer, and computes the box that results from a drag.

use super::Lens;
use crate::ui::views::waterfall::lens::LensPlace;
use bathyscope_objects::Mark;
use egui::CursorIcon;

/// Greatest distance of the pointer from an edge, points.
const REACH: f64 = 6.0;
/// Greatest distance of the pointer from the border between echo and shadow in a very small box,
/// points: the rest of the box must remain for other drags.
const LEAST_REACH: f64 = 2.0;

/// The edges that a drag moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Edges {
    pub start: bool,
    pub end: bool,
    pub near: bool,
    pub far: bool,
}

impl Edges {
    /// The whole box.
    pub(super) const ALL: Self = Self { start: true, end: true, near: true, far: true };

    /// Returns the edges under the pointer; all edges if it is inside the box, `None` if it is
    /// outside.
    pub(super) fn under(lens: &Lens, mark: &Mark, at: LensPlace) -> Option<Self> {
        let range_m = at.outward_m(mark.side);
        let points = |from: f64, to: f64, per_point: f64| (to - from) / per_point;
        let (along, across) = (lens.pings_per_point(), lens.metres_per_point());
        let start = points(mark.pings.start as f64, at.ping, along);
        let end = points(at.ping, mark.pings.end as f64, along);
        let near = points(mark.near_m, range_m, across);
        let far = points(range_m, mark.far_m, across);
        if [start, end, near, far].iter().any(|inside| *inside < -REACH) {
            return None;
        }
        // In a box smaller than the reach, only the nearer edge counts.
        let edges = Self {
            start: start < REACH && start <= end,
            end: end < REACH && end < start,
            near: near < REACH && near <= far,
            far: far < REACH && far < near,
        };
        let is_inside = !(edges.start || edges.end || edges.near || edges.far);
        Some(if is_inside { Self::ALL } else { edges })
    }

    /// Returns true if the border between echo and shadow is under the pointer, and nearer than the
    /// two edges parallel to it. Most of echo and shadow remains for dragging the whole box.
    pub(super) fn is_border(lens: &Lens, mark: &Mark, border_m: f64, at: LensPlace) -> bool {
        let range_m = at.outward_m(mark.side);
        let points = |from_m: f64, to_m: f64| (to_m - from_m).abs() / lens.metres_per_point();
        let (echo, shadow) = (points(mark.near_m, border_m), points(border_m, mark.far_m));
        let reach = (0.25 * echo.min(shadow)).clamp(LEAST_REACH, REACH);
        let off = points(range_m, border_m);
        // Where the border is on an edge, the pointer grips the edge; dragging the edge away leaves
        // the border behind.
        let is_nearest = off < points(range_m, mark.near_m).min(points(range_m, mark.far_m));
        let along = lens.pings_per_point();
        let inside = [
            (at.ping - mark.pings.start as f64) / along,
            (mark.pings.end as f64 - at.ping) / along,
        ];
        off < reach && is_nearest && inside.iter().all(|inside| *inside > -REACH)
    }

    /// Returns the cursor for a drag of these edges.
    pub(super) fn cursor(&self) -> CursorIcon {
        match self {
            _ if *self == Self::ALL => CursorIcon::Move,
            Self { start: false, end: false, .. } | Self { near: false, far: false, .. } => {
                CursorIcon::Crosshair
            }
            _ => CursorIcon::AllScroll,
        }
    }

    /// Returns the mark after a drag from one place to another. A box keeps its side, and an extent
    /// of at least a ping and a centimetre.
    pub(super) fn dragged(&self, mark: &Mark, from: LensPlace, to: LensPlace) -> Mark {
        let pings = (to.ping - from.ping).round() as isize;
        let outward = to.outward_m(mark.side) - from.outward_m(mark.side);
        let mut after = mark.clone();
        if *self == Self::ALL {
            let pings = pings.max(-(mark.pings.start as isize));
            let outward = outward.max(-mark.near_m);
            after.pings = mark.pings.start.saturating_add_signed(pings)
                ..mark.pings.end.saturating_add_signed(pings);
            (after.near_m, after.far_m) = (mark.near_m + outward, mark.far_m + outward);
            return after;
        }
        if self.start {
            let start = mark.pings.start.saturating_add_signed(pings);
            after.pings.start = start.min(mark.pings.end - 1);
        }
        if self.end {
            let end = mark.pings.end.saturating_add_signed(pings);
            after.pings.end = end.max(mark.pings.start + 1);
        }
        if self.near {
            after.near_m = (mark.near_m + outward).clamp(0.0, mark.far_m - LEAST_M);
        }
        if self.far {
            after.far_m = (mark.far_m + outward).max(mark.near_m + LEAST_M);
        }
        after
    }
}

/// Least extent in range that a drag leaves, metres.
const LEAST_M: f64 = 0.01;

/// Returns the box between two places, on the side of the first place.
pub(super) fn drawn(from: LensPlace, to: LensPlace) -> Mark {
    let side = from.side();
    let ranges = [from, to].map(|at| at.outward_m(side).max(0.0));
    let pings = [from, to].map(|at| at.ping.max(0.0));
    // `as` saturates; the number of pings of a survey is far below the limit.
    Mark {
        side,
        pings: pings[0].min(pings[1]).floor() as usize..pings[0].max(pings[1]).ceil() as usize,
        near_m: ranges[0].min(ranges[1]),
        far_m: ranges[0].max(ranges[1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::Side;

    fn port() -> Mark {
        Mark { side: Side::Port, pings: 10..20, near_m: 4.0, far_m: 6.0 }
    }

    fn place(ping: f64, across_m: f64) -> LensPlace {
        LensPlace { ping, across_m }
    }

    #[test]
    fn a_drag_moves_a_box_or_its_edges_and_never_turns_it_inside_out() {
        let moved = Edges::ALL.dragged(&port(), place(15.0, -5.0), place(12.0, -4.5));
        assert_eq!((moved.pings, moved.near_m, moved.far_m), (7..17, 3.5, 5.5));
        let stopped = Edges::ALL.dragged(&port(), place(15.0, -5.0), place(-90.0, 5.0));
        assert_eq!((stopped.pings, stopped.near_m, stopped.far_m), (0..10, 0.0, 2.0));
        let edges = Edges { start: false, end: true, near: true, far: false };
        let sized = edges.dragged(&port(), place(20.0, -4.0), place(5.0, -9.0));
        assert_eq!((sized.pings, sized.far_m), (10..11, 6.0));
        assert!((sized.near_m - 5.99).abs() < 1e-9);
    }

    #[test]
    fn a_box_is_drawn_in_any_direction_and_stays_on_its_side() {
        let mark = drawn(place(20.2, -6.0), place(10.9, -4.0));
        assert_eq!(mark, Mark { pings: 10..21, ..port() });
        let cut = drawn(place(20.2, -6.0), place(10.9, 4.0));
        assert_eq!((cut.side, cut.near_m, cut.far_m), (Side::Port, 0.0, 6.0));
    }
}
