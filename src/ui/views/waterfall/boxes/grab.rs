//! Handles clicks and drags on boxes: finds the edges of a box under the pointer, and computes the
//! box that results from a drag.

use super::{Lens, on_screen};
use crate::app::{App, Command, Tool, border_m};
use crate::ui::views::tool;
use crate::ui::views::waterfall::lens::LensPlace;
use crate::ui::{ViewContext, theme};
use bathyscope_objects::review::{BoxId, Edit, Reviewed};
use bathyscope_objects::{Mark, ObjectExtent};
use egui::{CursorIcon, Painter, Pos2, Rect, Response, Stroke, StrokeKind, Ui, Vec2};

/// Greatest distance of a click from a box that it selects, points.
const NEAR: f32 = 3.0;
/// Side of the square in which a click finds a point, points.
const POINT: f32 = 18.0;
/// Least extent on the screen of a newly drawn box, points: a smaller one is an accidental drag.
const LEAST: f32 = 4.0;

/// Box, border or corner that the pointer drags.
enum Held {
    /// A box, or some of its edges, with the place where the drag began.
    Box { id: BoxId, edges: Edges, origin: Mark, from: LensPlace },
    /// The border between echo and shadow of a box, with the place where the drag began.
    Border {
        id: BoxId,
        mark: Mark,
        /// Extent before the drag; its border may not have been set.
        extent: ObjectExtent,
        border_m: f64,
        from: LensPlace,
    },
    /// The first corner of a new box.
    Corner(Pos2),
}

/// State of the pointer on boxes; `None` while nothing is dragged.
#[derive(Default)]
pub(in crate::ui::views::waterfall) struct BoxGrab {
    held: Option<Held>,
}

impl BoxGrab {
    /// Handles a drag with a tool for boxes; returns true if the drag is about boxes and must not
    /// move the picture. The middle button and Space move the picture with any tool.
    pub(crate) fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        lens: &Lens,
        context: &mut ViewContext<'_>,
    ) -> bool {
        let tool = context.app.logs.shown.reviewing.tool;
        if !matches!(tool, Tool::Edit | Tool::Draw) {
            self.held = None;
            if tool == Tool::Point && response.hovered() {
                ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
            }
            return false;
        }
        let pointer = response.interact_pointer_pos().or(response.hover_pos());
        self.show_cursor(ui, response, lens, context.app);
        if let Some(at) = tool::begun(ui, response) {
            self.held = take(context.app, lens, at);
        }
        if tool::is_given_up(ui, response) {
            self.give_up(context);
        }
        let (Some(held), Some(at)) = (&self.held, pointer) else {
            return false;
        };
        let is_over = response.drag_stopped();
        match held {
            Held::Box { id, edges, origin, from } => {
                let mark = edges.dragged(origin, *from, lens.place_at(at));
                context.push(Command::Edit { edit: Edit::Reshape(*id, mark), live: !is_over });
            }
            Held::Border { id, mark, border_m, from, .. } => {
                let moved_m = lens.place_at(at).outward_m(mark.side) - from.outward_m(mark.side);
                let border_m = (border_m + moved_m).clamp(mark.near_m, mark.far_m);
                let (id, mark) = (*id, mark.clone());
                context.push(Command::Edit {
                    edit: Edit::SetEdges { id, mark, border_m },
                    live: !is_over,
                });
            }
            Held::Corner(corner) if is_over => {
                let extent = (at - *corner).abs();
                if extent.min_elem() >= LEAST {
                    let mark = drawn(lens.place_at(*corner), lens.place_at(at));
                    let class = context.app.logs.shown.reviewing.class();
                    context.push(Command::Edit { edit: Edit::Add { mark, class }, live: false });
                }
            }
            Held::Corner(_) => {}
        }
        if is_over {
            self.held = None;
        }
        true
    }

    /// Ends a drag without a change: a box goes back to its former place.
    fn give_up(&mut self, context: &mut ViewContext<'_>) {
        let edit = match self.held.take() {
            Some(Held::Box { id, origin, .. }) => Edit::Reshape(id, origin),
            Some(Held::Border { id, mark, extent, .. }) => match extent.border_m() {
                Some(border_m) => Edit::SetEdges { id, mark, border_m },
                None => Edit::FindEdges(id),
            },
            Some(Held::Corner(_)) | None => return,
        };
        context.push(Command::Edit { edit, live: false });
    }

    fn show_cursor(&self, ui: &Ui, response: &Response, lens: &Lens, app: &App) {
        let Some(at) = response.hover_pos() else {
            return;
        };
        let icon = match app.logs.shown.reviewing.tool {
            Tool::Draw => Some(CursorIcon::Crosshair),
            Tool::Edit => app
                .logs
                .shown
                .reviewing
                .selected_box()
                .and_then(|review_box| cursor(app, lens, review_box, lens.place_at(at))),
            _ => None,
        };
        if let Some(icon) = icon {
            ui.ctx().set_cursor_icon(icon);
        }
    }

    /// Draws the new box while it is being drawn.
    pub(crate) fn draw(&self, painter: &Painter, at: Option<Pos2>) {
        if let Some((Held::Corner(corner), at)) = self.held.as_ref().zip(at) {
            let rect = Rect::from_two_pos(*corner, at);
            let stroke = Stroke::new(1.5, theme::SELECTION_COLOUR);
            painter.rect_stroke(rect, 0.0, stroke, StrokeKind::Middle);
        }
    }
}

/// Returns the edges of a box under the pointer, if there are any; a point has no edges and moves
/// as a whole.
fn edges_under(lens: &Lens, review_box: &Reviewed, at: LensPlace) -> Option<Edges> {
    let edges = Edges::under(lens, &review_box.mark, at)?;
    Some(match review_box.extent {
        ObjectExtent::Point => Edges::ALL,
        ObjectExtent::Found | ObjectExtent::Drawn { .. } => edges,
    })
}

/// Returns the border between echo and shadow, metres of slant range, if it is under the pointer.
fn border_under(app: &App, lens: &Lens, review_box: &Reviewed, at: LensPlace) -> Option<f64> {
    let border_m = border_m(&app.logs.shown.reviewing, review_box);
    let is_under = review_box.extent != ObjectExtent::Point
        && Edges::is_border(lens, &review_box.mark, border_m, at);
    is_under.then_some(border_m)
}

fn cursor(app: &App, lens: &Lens, review_box: &Reviewed, at: LensPlace) -> Option<CursorIcon> {
    match border_under(app, lens, review_box, at) {
        Some(_) => Some(CursorIcon::Crosshair),
        None => edges_under(lens, review_box, at).map(|edges| edges.cursor()),
    }
}

fn take(app: &App, lens: &Lens, at: Pos2) -> Option<Held> {
    if app.logs.shown.reviewing.tool == Tool::Draw {
        return Some(Held::Corner(at));
    }
    let review_box = app.logs.shown.reviewing.selected_box()?;
    let from = lens.place_at(at);
    if let Some(border_m) = border_under(app, lens, review_box, from) {
        return Some(Held::Border {
            id: review_box.id,
            mark: review_box.mark.clone(),
            extent: review_box.extent,
            border_m,
            from,
        });
    }
    let edges = edges_under(lens, review_box, from)?;
    Some(Held::Box { id: review_box.id, edges, origin: review_box.mark.clone(), from })
}

/// Returns the area of a box for clicks: its outline with a margin, or the ring of a point.
fn reach(lens: &Lens, review_box: &Reviewed) -> Rect {
    let rect = on_screen(lens, &review_box.mark);
    match review_box.extent {
        ObjectExtent::Point => Rect::from_center_size(rect.center(), Vec2::splat(POINT)),
        ObjectExtent::Found | ObjectExtent::Drawn { .. } => rect.expand(NEAR),
    }
}

/// Returns the box under the pointer; of several boxes the smallest, which the others would
/// otherwise hide.
pub(in crate::ui::views::waterfall) fn under(lens: &Lens, app: &App, at: Pos2) -> Option<BoxId> {
    if !app.view.options.waterfall.boxes {
        return None;
    }
    let count = app.logs.shown.survey.as_ref()?.side_scan.len();
    let boxes = app.logs.shown.reviewing.between(lens.visible(count));
    boxes
        .map(|review_box| (review_box.id, reach(lens, review_box)))
        .filter(|(_, rect)| rect.contains(at))
        .min_by(|(_, a), (_, b)| a.area().total_cmp(&b.area()))
        .map(|(id, _)| id)
}

/// Greatest distance of the pointer from an edge, points.
const REACH: f64 = 6.0;
/// Greatest distance of the pointer from the border between echo and shadow in a very small box,
/// points: the rest of the box must remain for other drags.
const LEAST_REACH: f64 = 2.0;

/// The edges that a drag moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Edges {
    pub start: bool,
    pub end: bool,
    pub near: bool,
    pub far: bool,
}

impl Edges {
    /// The whole box.
    const ALL: Self = Self { start: true, end: true, near: true, far: true };

    /// Returns the edges under the pointer; all edges if it is inside the box, `None` if it is
    /// outside.
    fn under(lens: &Lens, mark: &Mark, at: LensPlace) -> Option<Self> {
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
    fn is_border(lens: &Lens, mark: &Mark, border_m: f64, at: LensPlace) -> bool {
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
    fn cursor(&self) -> CursorIcon {
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
    fn dragged(&self, mark: &Mark, from: LensPlace, to: LensPlace) -> Mark {
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
fn drawn(from: LensPlace, to: LensPlace) -> Mark {
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
