//! Implements the tools that are dragged along the pings: one excludes them, one proposes them for
//! the scale, one accepts their first returns as bottom. Draws a veil over excluded pings.

use super::labels::{self, WaterfallLabels};
use super::lens::Lens;
use crate::app::{App, ExclusionEdit, Tool};
use crate::ui::views::drag::{self, Does};
use crate::ui::{ViewContext, place};
use bathyscope_log::survey::{ExclusionReason, Side};
use egui::{Align2, Color32, CursorIcon, Painter, Pos2, Rect, Response, Stroke, Ui, pos2, vec2};

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

/// Distance between the lines of the veil, points.
const HATCH: f32 = 14.0;
/// Width on the screen below which a stretch has edges but no lines, points.
const NARROW: f32 = 6.0;
/// Width on the screen below which a stretch is labelled with its reason only, points.
const WORDY: f32 = 90.0;

/// A visible excluded stretch.
pub(super) struct Veiled {
    area: Rect,
    edges: [[Pos2; 2]; 2],
    reason: ExclusionReason,
}

/// Returns the visible excluded stretches.
pub(super) fn in_view(lens: &Lens, app: &App) -> Vec<Veiled> {
    let found = app.logs.shown.exclusions();
    let stretches = found.iter().flat_map(|found| &found.exclusions.stretches);
    let seen = stretches.filter_map(|stretch| {
        let pings = stretch.pings?;
        Some(Veiled { area: area(lens, pings)?, edges: edges(lens, pings), reason: stretch.reason })
    });
    seen.collect()
}

impl Veiled {
    /// Draws the veil; the picture below stays readable.
    pub(super) fn draw(&self, painter: &Painter) {
        veil(painter, self.area);
        for edge in self.edges {
            painter.line_segment(edge, Stroke::new(1.0, Color32::from_white_alpha(150)));
        }
    }

    /// Writes the reason at the end of the stretch.
    pub(super) fn label(&self, labels: &mut WaterfallLabels<'_>) {
        let reason = self.reason.name();
        let text = if self.area.width() < WORDY {
            reason.to_owned()
        } else {
            format!("excluded: {reason}")
        };
        let corner = self.area.left_bottom() + vec2(5.0, -22.0);
        labels.write(corner, Align2::LEFT_BOTTOM, &text, labels::INK);
    }
}

fn edges(lens: &Lens, [first, last]: [usize; 2]) -> [[Pos2; 2]; 2] {
    [first as f64, last as f64 + 1.0].map(|ping| lens.line_at_ping(ping))
}

/// Returns the area of pings in the picture; `None` if they are not visible.
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
    // On the grid of the screen, so that the lines stay in place while the picture moves.
    let reach = area.height();
    let mut x = (area.left() / HATCH).floor() * HATCH;
    while x < area.right() + reach {
        painter.line_segment([pos2(x, area.top()), pos2(x - reach, area.bottom())], line);
        x += HATCH;
    }
}
