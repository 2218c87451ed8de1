//! The tools that are dragged along the pings: one excludes them, one proposes them for the scale, one accepts their first returns as
//! bottom.

use super::exclusions::{area, edges, veil};
use super::labels;
use super::lens::Lens;
use crate::app::{App, Command, ExclusionEdit, Tool};
use crate::sonar::calibration::PingRange;
use crate::survey::{LogPart, Side};
use crate::ui::views::drag;
use crate::ui::{ViewContext, exclusion_text, place, theme};
use egui::{Align2, CursorIcon, Painter, Response, Stroke, Ui, pos2};

/// The drag under way.
#[derive(Default)]
pub(super) struct StretchTool {
    drag: Option<Drag>,
}

struct Drag {
    /// Pings with their fractions where it began and where it is.
    ends: [f64; 2],
    does: Does,
}

/// What comes of a drag.
#[derive(Clone, Copy)]
enum Does {
    Exclusion(ExclusionEdit),
    Propose,
    Accept(Side, bool),
}

impl Does {
    /// What the tool in hand does with what was begun on a side.
    fn of(tool: Tool, side: Side, ui: &Ui) -> Option<Self> {
        let modifiers = ui.input(|input| input.modifiers);
        match tool {
            Tool::Exclude => Some(Self::Exclusion(drag::exclusion_edit(modifiers))),
            Tool::Calibrate => Some(Self::Propose),
            Tool::Accept => Some(Self::Accept(side, !modifiers.alt)),
            _ => None,
        }
    }
}

impl Drag {
    /// The first and last ping that it covers, of so many; `None` beyond the log.
    fn pings(&self, count: usize) -> Option<[usize; 2]> {
        let [one, other] = self.ends;
        let (first, last) = (one.min(other), one.max(other));
        if last < 0.0 || first >= count as f64 {
            return None;
        }
        let last = (last as usize).min(count.checked_sub(1)?);
        Some([first.max(0.0) as usize, last])
    }

    fn command(&self, app: &App) -> Option<Command> {
        let pings @ [first, last] = self.pings(place::ping_count(app))?;
        Some(match self.does {
            Does::Exclusion(edit) => Command::Exclude {
                log: app.log.id,
                part: LogPart::Pings(pings),
                edit,
            },
            Does::Propose => Command::ProposeStretch(PingRange {
                start: first,
                end: last + 1,
            }),
            Does::Accept(side, accept) => Command::AcceptBottom {
                side,
                pings,
                accept,
            },
        })
    }

    /// What it will do, with how much it covers.
    fn words(&self, app: &App, pings: [usize; 2]) -> Option<String> {
        let units = app.view.options.units;
        let extent = app.extent_of(app.log.id, LogPart::Pings(pings))?;
        let covered = exclusion_text::extent(&extent, units);
        Some(match self.does {
            Does::Exclusion(edit) => exclusion_text::of_drag(edit, &extent, units),
            Does::Propose => format!("propose {covered}"),
            Does::Accept(side, true) => format!("accept as bottom, {}: {covered}", side.name()),
            Does::Accept(side, false) => format!("no longer accepted, {}: {covered}", side.name()),
        })
    }
}

impl StretchTool {
    /// Follows a drag with one of the tools in hand; returns whether the drag must not move the picture.
    pub(super) fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        lens: &Lens,
        context: &mut ViewContext<'_>,
    ) -> bool {
        let tool = context.app.log.reviewing.tool;
        if !matches!(tool, Tool::Exclude | Tool::Calibrate | Tool::Accept) {
            self.drag = None;
            return false;
        }
        if response.hovered() {
            ui.set_cursor_icon(CursorIcon::Crosshair);
        }
        if let Some(at) = drag::begun(ui, response) {
            let place = lens.place_at(at);
            let does = Does::of(tool, place.side(), ui);
            self.drag = does.map(|does| Drag {
                ends: [place.ping, place.ping],
                does,
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
            && let Some(command) = self.drag.take().and_then(|drag| drag.command(context.app))
        {
            context.push(command);
        }
        true
    }

    /// Draws the drag under way, with what it covers.
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
        let colour = match drag.does {
            Does::Propose => theme::PROPOSAL_COLOUR,
            Does::Exclusion(_) | Does::Accept(..) => theme::HAND_COLOUR,
        };
        for edge in edges(lens, pings) {
            painter.line_segment(edge, Stroke::new(2.0, colour));
        }
        if let Some(words) = drag.words(app, pings) {
            let at = pos2(area.center().x, area.top() + 18.0);
            labels::text(painter, at, Align2::CENTER_TOP, &words);
        }
    }
}
