//! Implements the tools that are dragged along the pings: one excludes them, one proposes them for
//! the scale, one accepts their first returns as bottom.

use super::exclusions::{area, edges, veil};
use super::labels;
use super::lens::Lens;
use crate::app::{App, ExclusionEdit, Tool};
use crate::ui::views::drag::{self, Does};
use crate::ui::{ViewContext, place};
use bathyscope_log::survey::Side;
use egui::{Align2, CursorIcon, Painter, Response, Stroke, Ui, pos2};

/// State of these tools; `None` while there is no drag.
#[derive(Default)]
pub(super) struct StretchTool {
    drag: Option<Drag>,
}

struct Drag {
    /// Ping numbers, with their fractions, where the drag began and where it is now.
    ends: [f64; 2],
    does: Does,
}

/// Returns the effect of a drag with this tool that began on a side; `None` for other tools.
fn does(tool: Tool, side: Side, ui: &Ui) -> Option<Does> {
    let modifiers = ui.input(|input| input.modifiers);
    match tool {
        Tool::Exclude => Some(Does::Exclusion(drag::exclusion_edit(modifiers))),
        Tool::Calibrate => Some(Does::Propose),
        Tool::Accept => Some(Does::Accept(side, !modifiers.alt)),
        _ => None,
    }
}

impl Drag {
    /// Returns the first and last ping of the drag in a log of `count` pings; `None` if the drag is
    /// beyond the log.
    fn pings(&self, count: usize) -> Option<[usize; 2]> {
        let [one, other] = self.ends;
        let (first, last) = (one.min(other), one.max(other));
        if last < 0.0 || first >= count as f64 {
            return None;
        }
        let last = (last as usize).min(count.checked_sub(1)?);
        Some([first.max(0.0) as usize, last])
    }
}

impl StretchTool {
    /// Handles a drag with one of the tools; returns true if the drag must not move the picture.
    pub(super) fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        lens: &Lens,
        context: &mut ViewContext<'_>,
    ) -> bool {
        let tool = context.app.logs.shown.reviewing.tool;
        if !matches!(tool, Tool::Exclude | Tool::Calibrate | Tool::Accept) {
            self.drag = None;
            return false;
        }
        if response.hovered() {
            ui.set_cursor_icon(CursorIcon::Crosshair);
        }
        if let Some(at) = drag::begun(ui, response) {
            let place = lens.place_at(at);
            self.drag = does(tool, place.side(), ui)
                .map(|does| Drag { ends: [place.ping, place.ping], does });
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
            && let Some(pings) = drag.pings(place::ping_count(context.app))
        {
            context.push(drag.does.command(context.app.logs.shown.id, pings));
        }
        true
    }

    /// Draws the drag in progress, and describes the stretch that it covers.
    pub(super) fn draw(&self, painter: &Painter, lens: &Lens, app: &App) {
        let Some(drag) = &self.drag else {
            return;
        };
        let Some(pings) = drag.pings(place::ping_count(app)) else {
            return;
        };
        let Some(area) = area(lens, pings) else {
            return;
        };
        if matches!(drag.does, Does::Exclusion(ExclusionEdit::Exclude)) {
            veil(painter, area);
        }
        for edge in edges(lens, pings) {
            painter.line_segment(edge, Stroke::new(2.0, drag.does.colour()));
        }
        if let Some(words) = drag.does.words(app, app.logs.shown.id, pings) {
            let at = pos2(area.center().x, area.top() + 18.0);
            labels::text(painter, at, Align2::CENTER_TOP, &words);
        }
    }
}
