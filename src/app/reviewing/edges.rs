//! Moves single edges of a box by keys: those of its echo, the border to its shadow, and the end of
//! the shadow; and marks points, which have no edges.

use super::{PIXEL_M, Reviewing, Tool};
use crate::app::{Action, App, LogPlace};
use bathyscope_log::survey::Side;
use bathyscope_objects::ObjectExtent;
use bathyscope_objects::review::{Edit, Reviewed};

/// Part of the selected box that the arrow keys move while it is edited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoxEdge {
    /// The whole box.
    #[default]
    Whole,
    /// The near edge of the echo.
    Near,
    /// The border between echo and shadow.
    Border,
    /// The end of the shadow.
    Far,
    /// The first ping.
    Start,
    /// The last ping.
    End,
}

bathyscope_log::named! {
    /// All parts in their order, with their names in the view.
    pub BoxEdge {
        Whole: "",
        Near: "near edge of the echo",
        Border: "border of echo and shadow",
        Far: "end of the shadow",
        Start: "first ping",
        End: "last ping",
    }
}

impl BoxEdge {
    /// Returns the edge after this one; after the last edge comes the whole box.
    pub fn next(self) -> Self {
        Self::ALL[(self as usize + 1) % Self::ALL.len()]
    }

    /// Returns the edit that moves the edge by a number of pings along the track and of pixels of
    /// the raster to starboard; `None` for the whole box.
    pub(super) fn moved(
        self,
        review_box: &Reviewed,
        border_m: f64,
        along: i32,
        across: i32,
    ) -> Option<Edit> {
        let pings = along as isize;
        let outward = match review_box.mark.side {
            Side::Port => -across,
            Side::Starboard => across,
        };
        let outward_m = f64::from(outward) * PIXEL_M;
        let mut mark = review_box.mark.clone();
        match self {
            BoxEdge::Whole => return None,
            BoxEdge::Border => {
                let border_m = (border_m + outward_m).clamp(mark.near_m, mark.far_m);
                let id = review_box.id;
                return Some(Edit::SetEdges { id, mark, border_m });
            }
            BoxEdge::Near => mark.near_m = (mark.near_m + outward_m).min(mark.far_m - PIXEL_M),
            BoxEdge::Far => mark.far_m = (mark.far_m + outward_m).max(mark.near_m + PIXEL_M),
            BoxEdge::Start => {
                let start = mark.pings.start.saturating_add_signed(pings);
                mark.pings.start = start.min(mark.pings.end - 1);
            }
            BoxEdge::End => {
                let end = mark.pings.end.saturating_add_signed(pings);
                mark.pings.end = end.max(mark.pings.start + 1);
            }
        }
        Some(Edit::Reshape(review_box.id, mark))
    }
}

/// Returns the slant range of the border between the echo and the shadow of a box, metres: as set
/// by hand, else as found. If no shadow is found, the border is a third of the box from its near
/// edge: boxes contain more shadow than echo, and a border on the far edge could not be dragged.
pub fn border_m(reviewing: &Reviewing, review_box: &Reviewed) -> f64 {
    let (near_m, far_m) = (review_box.mark.near_m, review_box.mark.far_m);
    let found = || {
        let placed = reviewing.placed(review_box.id)?;
        // The parts of a box that was just moved are those of its earlier place.
        Some(placed.target.parts?.shadow_m?[0])
    };
    let border_m = review_box.extent.border_m().or_else(found);
    let border_m = border_m.unwrap_or(near_m + (far_m - near_m) / 3.0);
    border_m.clamp(near_m, far_m)
}

impl App {
    /// Selects the next edge of the edited box, after selecting the tool for it.
    pub(in crate::app) fn next_edge(&mut self) {
        if self.logs.shown.reviewing.tool != Tool::Edit {
            self.take_tool(Tool::Edit);
        }
        let is_box = |review_box: &Reviewed| review_box.extent != ObjectExtent::Point;
        let reviewing = &mut self.logs.shown.reviewing;
        if reviewing.tool == Tool::Edit && reviewing.selected_box().is_some_and(is_box) {
            reviewing.edge = reviewing.edge.next();
        }
    }

    /// Selects the tool that marks points, or, if it is selected, marks a point at the pointer or
    /// at the selected place.
    pub(in crate::app) fn point_tool(&mut self) {
        if self.logs.shown.reviewing.tool != Tool::Point {
            return self.take_tool(Tool::Point);
        }
        let places = [self.view.hover, self.view.selection].into_iter().flatten();
        match places.into_iter().find(|mark| mark.sample.is_some()) {
            Some(mark) => self.mark_target(mark),
            None => {
                self.notices.warn(format!(
                    "click the target in the waterfall, or point there and press {}",
                    Action::MarkTarget.key()
                ));
            }
        }
    }

    /// Marks a point at the place of a sample.
    pub(in crate::app) fn mark_target(&mut self, mark: LogPlace) {
        let Some((side, sample)) = mark.side.zip(mark.sample) else {
            return self.notices.warn("nothing was recorded there; mark the target in the picture");
        };
        let span =
            (self.logs.shown.survey.as_ref()).and_then(|survey| survey.span(mark.ping, side));
        let Some(span) = span else {
            return;
        };
        let range_m = span.range_m(f64::from(sample));
        let class = self.logs.shown.reviewing.class();
        let edit = Edit::AddPoint { side, ping: mark.ping, range_m, class };
        self.edit(&edit, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_objects::review::BoxId;

    fn reviewed(side: Side) -> Reviewed {
        let mark = bathyscope_objects::Mark { side, pings: 10..20, near_m: 4.0, far_m: 7.0 };
        Reviewed::drawn(BoxId(4), mark, 0)
    }

    #[test]
    fn arrows_move_one_edge_as_it_looks() {
        let port = reviewed(Side::Port);
        // A move to the right is to starboard: inward on the port side.
        let Some(Edit::SetEdges { border_m, mark, .. }) = BoxEdge::Border.moved(&port, 5.0, 0, 10)
        else {
            panic!("the border moves")
        };
        assert!((border_m - 4.6).abs() < 1e-9 && mark == port.mark);
        let Some(Edit::Reshape(_, mark)) = BoxEdge::Far.moved(&port, 5.0, 3, -10) else {
            panic!("the far edge moves")
        };
        assert!((mark.far_m - 7.4).abs() < 1e-9);
        assert_eq!((mark.near_m, mark.pings), (4.0, 10..20));
        let starboard = reviewed(Side::Starboard);
        let Some(Edit::Reshape(_, mark)) = BoxEdge::Near.moved(&starboard, 5.0, 0, 1000) else {
            panic!("the near edge moves")
        };
        assert!(mark.near_m < mark.far_m);
        let Some(Edit::Reshape(_, mark)) = BoxEdge::End.moved(&starboard, 5.0, -90, 0) else {
            panic!("the last ping moves")
        };
        assert_eq!(mark.pings, 10..11);
        assert_eq!(BoxEdge::Whole.moved(&port, 5.0, 1, 1), None);
    }

    #[test]
    fn the_edges_come_in_turn() {
        let mut edge = BoxEdge::Whole;
        let mut seen = vec![edge];
        while edge.next() != BoxEdge::Whole {
            edge = edge.next();
            seen.push(edge);
        }
        assert_eq!(seen.len(), 6);
    }
}
