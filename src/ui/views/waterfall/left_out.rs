//! The pings that are left out, under a veil, and the tool that leaves them out.

use super::labels::{self, Labels};
use super::lens::Lens;
use crate::app::{App, Command, Leave, Tool};
use crate::survey::{LeftOutReason, LogPart};
use crate::ui::views::drag;
use crate::ui::{ViewContext, left_out_words, theme};
use egui::{Align2, Color32, CursorIcon, Painter, Pos2, Rect, Response, Stroke, Ui};
use egui::{pos2, vec2};

/// Points between the lines of the veil.
const HATCH: f32 = 14.0;
/// A stretch narrower than this on the screen has edges and no lines, points.
const NARROW: f32 = 6.0;
/// A stretch narrower than this is named by its reason alone, points.
const WORDY: f32 = 90.0;

/// The drag under way.
#[derive(Default)]
pub(super) struct LeaveOutTool {
    drag: Option<Drag>,
}

struct Drag {
    /// Pings with their fractions where it began and where it is.
    ends: [f64; 2],
    leave: Leave,
}

impl Drag {
    /// The pings that it covers, of so many; `None` beyond the log.
    fn part(&self, count: usize) -> Option<LogPart> {
        let [one, other] = self.ends;
        let (first, last) = (one.min(other), one.max(other));
        if last < 0.0 || first >= count as f64 {
            return None;
        }
        let last = (last as usize).min(count.checked_sub(1)?);
        Some(LogPart::Pings([first.max(0.0) as usize, last]))
    }
}

impl LeaveOutTool {
    /// Follows a drag with the tool in hand; returns whether the drag must not move the picture.
    pub fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        lens: &Lens,
        context: &mut ViewContext<'_>,
    ) -> bool {
        if context.app.log.reviewing.tool != Tool::LeaveOut {
            self.drag = None;
            return false;
        }
        if response.hovered() {
            ui.set_cursor_icon(CursorIcon::Crosshair);
        }
        if let Some(at) = drag::begun(ui, response) {
            let ping = lens.place_at(at).ping;
            self.drag = Some(Drag {
                ends: [ping, ping],
                leave: drag::leave_by(ui.input(|input| input.modifiers)),
            });
        }
        if drag::is_given_up(ui, response) {
            self.drag = None;
        }
        let Some(drag) = &mut self.drag else {
            return false;
        };
        if let Some(at) = response.interact_pointer_pos().or(response.hover_pos()) {
            drag.ends[1] = lens.place_at(at).ping;
        }
        if response.drag_stopped()
            && let Some(drag) = self.drag.take()
        {
            let log = &context.app.log;
            let count = log
                .survey
                .as_ref()
                .map_or(0, |survey| survey.side_scan.len());
            if let Some(part) = drag.part(count) {
                let (log, leave) = (log.id, drag.leave);
                context.push(Command::LeaveOut { log, part, leave });
            }
        }
        true
    }

    /// Draws the drag under way, with what it covers.
    pub fn draw(&self, painter: &Painter, lens: &Lens, app: &App) {
        let Some(drag) = &self.drag else {
            return;
        };
        let count = (app.log.survey.as_ref()).map_or(0, |survey| survey.side_scan.len());
        let Some(part @ LogPart::Pings(pings)) = drag.part(count) else {
            return;
        };
        let Some(area) = area(lens, pings) else {
            return;
        };
        match drag.leave {
            Leave::Out => veil(painter, area),
            Leave::In | Leave::AsFound => {}
        }
        let stroke = Stroke::new(2.0, theme::hand_colour());
        for edge in edges(lens, pings) {
            painter.line_segment(edge, stroke);
        }
        if let Some(extent) = app.extent_of(app.log.id, part) {
            let text = left_out_words::of_drag(drag.leave, &extent, app.options.units);
            let at = pos2(area.center().x, area.top() + 18.0);
            labels::text(painter, at, Align2::CENTER_TOP, &text);
        }
    }
}

/// A stretch in view.
pub(super) struct Veiled {
    area: Rect,
    edges: [[Pos2; 2]; 2],
    reason: LeftOutReason,
}

/// The left-out stretches that a lens sees.
pub(super) fn in_view(lens: &Lens, app: &App) -> Vec<Veiled> {
    let found = app.log.left_out();
    let stretches = found.iter().flat_map(|found| &found.left_out.stretches);
    let seen = stretches.filter_map(|stretch| {
        let pings = stretch.pings?;
        Some(Veiled {
            area: area(lens, pings)?,
            edges: edges(lens, pings),
            reason: stretch.reason,
        })
    });
    seen.collect()
}

impl Veiled {
    /// Draws the veil: what lies under it stays readable.
    pub fn draw(&self, painter: &Painter) {
        veil(painter, self.area);
        for edge in self.edges {
            painter.line_segment(edge, Stroke::new(1.0, Color32::from_white_alpha(150)));
        }
    }

    /// Writes why at its end.
    pub fn label(&self, labels: &mut Labels<'_>) {
        let reason = self.reason.name();
        let text = match self.area.width() < WORDY {
            true => reason.to_owned(),
            false => format!("left out: {reason}"),
        };
        let corner = self.area.left_bottom() + vec2(5.0, -22.0);
        labels.write(corner, Align2::LEFT_BOTTOM, &text, labels::INK);
    }
}

fn edges(lens: &Lens, [first, last]: [usize; 2]) -> [[Pos2; 2]; 2] {
    [first as f64, last as f64 + 1.0].map(|ping| lens.line_at_ping(ping))
}

/// What pings cover of the picture; `None` out of view.
fn area(lens: &Lens, pings: [usize; 2]) -> Option<Rect> {
    let [from, to] = edges(lens, pings);
    let area = Rect::from_two_pos(from[0], to[1]).intersect(lens.rect);
    area.is_positive().then_some(area)
}

/// Darkens a part of the picture, which is dark or coloured in any theme, and hatches it.
fn veil(painter: &Painter, area: Rect) {
    painter.rect_filled(area, 0.0, Color32::from_black_alpha(150));
    if area.width().min(area.height()) < NARROW {
        return;
    }
    let painter = painter.with_clip_rect(area.intersect(painter.clip_rect()));
    let line = Stroke::new(1.0, Color32::from_white_alpha(60));
    // On the screen's own grid, so that the lines stand still while the picture moves less than it is redrawn.
    let reach = area.height();
    let mut x = (area.left() / HATCH).floor() * HATCH;
    while x < area.right() + reach {
        painter.line_segment([pos2(x, area.top()), pos2(x - reach, area.bottom())], line);
        x += HATCH;
    }
}
