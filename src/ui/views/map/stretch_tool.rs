//! The tools that are pressed on a track and dragged along it: one excludes pings, one proposes them for the scale.

use super::exclusions::{CASING, places};
use super::layers::TrackLayer;
use super::pointer::REACH;
use super::scene::Scene;
use super::transform::MapTransform;
use crate::app::{App, Command, ExclusionEdit, LogId, Tool};
use crate::sonar::calibration::PingRange;
use crate::survey::LogPart;
use crate::ui::views::{drag, legend};
use crate::ui::{ViewContext, exclusion_text, theme};
use egui::{Align2, CursorIcon, Painter, Pos2, Rect, Response, Shape, Stroke, Ui, vec2};

/// The drag under way.
#[derive(Default)]
pub(super) struct StretchTool {
    drag: Option<Drag>,
}

struct Drag {
    log: LogId,
    /// Pings where it began and where it is.
    ends: [usize; 2],
    /// What is done with the pings; `None` where they are proposed for the scale.
    edit: Option<ExclusionEdit>,
}

impl Drag {
    fn pings(&self) -> [usize; 2] {
        let [one, other] = self.ends;
        [one.min(other), one.max(other)]
    }

    fn command(&self) -> Command {
        let pings @ [first, last] = self.pings();
        match self.edit {
            Some(edit) => Command::Exclude {
                log: self.log,
                part: LogPart::Pings(pings),
                edit,
            },
            None => Command::ProposeStretch(PingRange {
                start: first,
                end: last + 1,
            }),
        }
    }
}

/// Where the map lies on the screen.
type View = (Rect, MapTransform);

impl StretchTool {
    /// Follows a drag or a click with one of the tools in hand; returns whether a drag must not move the map. Beside the tracks, with the
    /// middle button or with Space held, it moves the map in any tool.
    pub(super) fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        (rect, transform): View,
        track: &TrackLayer,
        context: &mut ViewContext<'_>,
    ) -> bool {
        if !is_in_hand(context.app) {
            self.drag = None;
            return false;
        }
        let is_calibrating = context.app.log.reviewing.tool == Tool::Calibrate;
        let shown = context.app.log.id;
        let ground = |at: Pos2| transform.to_ground(rect, at);
        let reach_m = f64::from(REACH) * transform.metres_per_point;
        // Only the log that the panels show has a scale to propose.
        let under = |at: Pos2| {
            let near = track.nearest_ping(ground(at), reach_m, shown);
            near.filter(|(log, _)| !is_calibrating || *log == shown)
        };
        if response.hover_pos().and_then(under).is_some() {
            ui.set_cursor_icon(CursorIcon::Crosshair);
        }
        if let Some((log, ping)) = drag::begun(ui, response).and_then(under) {
            let edit = drag::exclusion_edit(ui.input(|input| input.modifiers));
            self.drag = Some(Drag {
                log,
                ends: [ping, ping],
                edit: (!is_calibrating).then_some(edit),
            });
        }
        let clicked = response.clicked().then(|| response.interact_pointer_pos());
        if let Some((log, ping)) = clicked.flatten().and_then(under)
            && let Some(stretch) = context.app.excluded_at(log, ping)
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
            context.push(drag.command());
        }
        true
    }

    /// Draws the drag under way, with what it covers.
    pub(super) fn draw(&self, painter: &Painter, scene: &Scene<'_>, app: &App) {
        let Some((drag, log)) =
            (self.drag.as_ref()).and_then(|drag| Some((drag, app.open_log(drag.log)?)))
        else {
            return;
        };
        let Some((survey, products)) = log.survey.as_ref().zip(log.products.as_ref()) else {
            return;
        };
        let part = LogPart::Pings(drag.pings());
        let sailed = part.places(survey, &products.navigation);
        let line = places(scene, sailed);
        let last = line.last().copied();
        let colour = match drag.edit {
            Some(_) => theme::HAND_COLOUR,
            None => theme::PROPOSAL_COLOUR,
        };
        painter.add(Shape::line(line, Stroke::new(CASING, colour)));
        if let Some((at, extent)) = last.zip(app.extent_of(drag.log, part)) {
            let units = app.view.options.units;
            let text = match drag.edit {
                Some(edit) => exclusion_text::of_drag(edit, &extent, units),
                None => format!("propose {}", exclusion_text::extent(&extent, units)),
            };
            let at = at + vec2(14.0, 14.0);
            legend::words(painter, scene.options, at, Align2::LEFT_TOP, &text);
        }
    }
}

/// Whether one of the tools is in hand.
pub(super) fn is_in_hand(app: &App) -> bool {
    matches!(app.log.reviewing.tool, Tool::Exclude | Tool::Calibrate)
}
