//! Enlarges a box in all views.

use super::Reviewing;
use crate::app::{App, CloseUp, Enlarged, LogBox};
use bathyscope_log::survey::Side;
use bathyscope_objects::review::{BoxId, Reviewed};

/// Least longer side that a box is given for enlarging, metres, so that the surroundings of small
/// boxes and points are visible, too.
/// too.
const LEAST_M: f64 = 1.5;

impl App {
    /// Shows the log of a box, if it is not shown yet, and enlarges the box in all views.
    pub(in crate::app) fn fly_to(&mut self, id: LogBox) {
        self.select_log_box(id);
        self.enlarge(Enlarged::Third);
    }

    /// Shows the log of a box of the queue, if it is not shown yet, and the box: one to one in the
    /// waterfall, if that option is on.
    pub(in crate::app) fn come_to(&mut self, id: LogBox) {
        self.select_log_box(id);
        self.enlarge(if self.view.options.waterfall.zooms_to_boxes {
            Enlarged::OneToOne
        } else {
            Enlarged::AsItIs
        });
    }

    /// Shows the log of a box, if it is not shown yet, and the box with its surroundings, at the
    /// present scale of each view.
    pub(in crate::app) fn bring_in(&mut self, id: LogBox) {
        self.select_log_box(id);
        self.enlarge(Enlarged::AsItIs);
    }

    /// Toggles whether the boxes of the queue are shown one to one, or at the present scale of the
    /// waterfall.
    pub(in crate::app) fn toggle_zoom_to_boxes(&mut self) {
        let zooms = &mut self.view.options.waterfall.zooms_to_boxes;
        *zooms = !*zooms;
        if let Some(id) = self.logs.shown.selected_box() {
            self.come_to(id);
        }
    }

    fn enlarge(&mut self, enlarged: Enlarged) {
        let reviewing = &self.logs.shown.reviewing;
        let selected = reviewing.selected_box();
        let close_up =
            selected.map(|review_box| close_up(reviewing, review_box, review_box.id, enlarged));
        if let Some(reveal) = &mut self.view.reveal {
            reveal.close_up = close_up;
        }
    }
}

fn close_up(
    reviewing: &Reviewing,
    review_box: &Reviewed,
    id: BoxId,
    enlarged: Enlarged,
) -> CloseUp {
    let mark = &review_box.mark;
    let middle_m = 0.5 * (mark.near_m + mark.far_m);
    let half_m = (0.5 * (mark.far_m - mark.near_m)).max(0.5 * LEAST_M);
    let ends_m = [(middle_m - half_m).max(0.0), middle_m + half_m];
    let across_m = match mark.side {
        Side::Port => [-ends_m[1], -ends_m[0]],
        Side::Starboard => ends_m,
    };
    let target = reviewing.placed(id).map(|placed| &placed.target);
    let size_m = target.map_or(f64::NAN, |target| target.length_m.max(target.width_m));
    CloseUp {
        enlarged,
        pings: [mark.pings.start, mark.pings.end],
        across_m,
        place_m: target.map(|target| [target.east_m, target.north_m, -target.depth_m]),
        // The size of a point is NaN, for which `max` returns the least size.
        size_m: size_m.max(LEAST_M),
    }
}
