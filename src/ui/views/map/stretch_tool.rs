//! Implements the tools that are dragged along a track: one excludes pings, one proposes them for
//! the scale.

use super::exclusions::{CASING, places};
use super::layers::TrackLayer;
use super::pointer::REACH;
use super::scene::MapScene;
use super::transform::MapTransform;
use crate::app::{App, Command, ExclusionEdit, LogId, Tool};
use crate::ui::ViewContext;
use crate::ui::views::drag::{self, Does};
use crate::ui::views::legend;
use bathyscope_log::survey::LogPart;
use egui::{Align2, CursorIcon, Painter, Pos2, Rect, Response, Shape, Stroke, Ui, vec2};

/// State of both tools; `None` while there is no drag.
#[derive(Default)]
pub(super) struct StretchTool {
    drag: Option<Drag>,
}

struct Drag {
    log: LogId,
    /// Ping where the drag began, and ping where it is now.
    ends: [usize; 2],
    does: Does,
}

impl Drag {
    fn pings(&self) -> [usize; 2] {
        let [one, other] = self.ends;
        [one.min(other), one.max(other)]
    }
}

/// Area of the map on the screen, and its transform.
type MapPosition = (Rect, MapTransform);

impl StretchTool {
    /// Handles a drag or a click with the selected tool; returns true if the drag must not move the
    /// map. Beside the tracks, with the middle button or with Space held, a drag moves the map with
    /// any tool.
    pub(super) fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        (rect, transform): MapPosition,
        track: &TrackLayer,
        context: &mut ViewContext<'_>,
    ) -> bool {
        if !is_in_hand(context.app) {
            self.drag = None;
            return false;
        }
        let is_calibrating = context.app.logs.shown.reviewing.tool == Tool::Calibrate;
        let shown = context.app.logs.shown.id;
        let ground = |at: Pos2| transform.to_ground(rect, at);
        let reach_m = f64::from(REACH) * transform.metres_per_point;
        // Only the log in the panels has a scale to propose.
        let under = |at: Pos2| {
            let near = track.nearest_ping(ground(at), reach_m, shown);
            near.filter(|(log, _)| !is_calibrating || *log == shown)
        };
        if response.hover_pos().and_then(under).is_some() {
            ui.set_cursor_icon(CursorIcon::Crosshair);
        }
        if let Some((log, ping)) = drag::begun(ui, response).and_then(under) {
            let edit = drag::exclusion_edit(ui.input(|input| input.modifiers));
            let does = if is_calibrating { Does::Propose } else { Does::Exclusion(edit) };
            let ends = [ping, ping];
            self.drag = Some(Drag { log, ends, does });
        }
        let clicked = response.clicked().then(|| response.interact_pointer_pos());
        if let Some((log, ping)) = clicked.flatten().and_then(under)
            && let Some(stretch) = context.app.logs.excluded_at(log, ping)
            && !is_calibrating
        {
            let (part, edit) = (stretch.part(), ExclusionEdit::Include);
            context.push(Command::Exclude { log, part, edit });
        }
        if drag::is_given_up(ui, response) {
            self.drag = None;
        }
        let Some(drag) = &mut self.drag else {
            return false;
        };
        let at = response.interact_pointer_pos().or(response.hover_pos());
        if let Some(ping) = at.and_then(|at| track.ping_of(drag.log, ground(at))) {
            drag.ends[1] = ping;
        }
        if response.drag_stopped()
            && let Some(drag) = self.drag.take()
        {
            context.push(drag.does.command(drag.log, drag.pings()));
        }
        true
    }

    /// Draws the drag in progress, and describes the stretch that it covers.
    pub(super) fn draw(&self, painter: &Painter, scene: &MapScene<'_>, app: &App) {
        let Some((drag, log)) =
            (self.drag.as_ref()).and_then(|drag| Some((drag, app.logs.get(drag.log)?)))
        else {
            return;
        };
        let Some((survey, products)) = log.survey.as_ref().zip(log.products.as_ref()) else {
            return;
        };
        let sailed = LogPart::Pings(drag.pings()).places(survey, &products.navigation);
        let line = places(scene, sailed);
        let last = line.last().copied();
        let stroke = Stroke::new(CASING, drag.does.colour());
        painter.add(Shape::line(line, stroke));
        if let Some((at, text)) = last.zip(drag.does.words(app, drag.log, drag.pings())) {
            let at = at + vec2(14.0, 14.0);
            legend::words(painter, scene.options, at, Align2::LEFT_TOP, &text);
        }
    }
}

/// Returns true if one of the tools is selected.
pub(super) fn is_in_hand(app: &App) -> bool {
    matches!(app.logs.shown.reviewing.tool, Tool::Exclude | Tool::Calibrate)
}
