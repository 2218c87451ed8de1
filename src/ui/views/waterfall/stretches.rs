//! Draws stretches of the log over the picture: a veil over excluded pings, the ranked flat
//! stretches along the nadir, numbered as on the map, the stretch that the calibration was measured
//! on, and the proposed stretch. Implements the tools that are dragged along the pings: one
//! excludes them, one proposes them for the scale, one accepts their first returns as bottom.

use super::labels::{self, WaterfallLabels};
use super::lens::{Lens, LensPlace};
use crate::app::{App, ExclusionEdit, Tool, View};
use crate::ui::views::tool::{self, Does};
use crate::ui::{ViewContext, place, theme};
use bathyscope_bottom::calibration::{FlatSpot, PingRange};
use bathyscope_log::survey::{ExclusionReason, Side};
use egui::{Align2, Color32, CursorIcon, Painter, Pos2, Rect, Response, Stroke, Ui, pos2, vec2};
use std::ops::Range;

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
        Tool::Exclude => Some(Does::Exclusion(tool::exclusion_edit(modifiers))),
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
        if let Some(at) = tool::begun(ui, response) {
            let place = lens.place_at(at);
            self.drag = does(tool, place.side(), ui)
                .map(|does| Drag { ends: [place.ping, place.ping], does });
        }
        if tool::is_given_up(ui, response) {
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
        let edges = edges(lens, range(pings));
        let Some(area) = area(lens, edges) else {
            return;
        };
        if matches!(drag.does, Does::Exclusion(ExclusionEdit::Exclude)) {
            veil(painter, area);
        }
        for edge in edges {
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
pub(super) fn excluded_in_view(lens: &Lens, app: &App) -> Vec<Veiled> {
    let found = app.logs.shown.exclusions();
    let stretches = found.iter().flat_map(|found| &found.exclusions.stretches);
    let seen = stretches.filter_map(|stretch| {
        let edges = edges(lens, range(stretch.pings?));
        Some(Veiled { area: area(lens, edges)?, edges, reason: stretch.reason })
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

fn range([first, last]: [usize; 2]) -> Range<usize> {
    first..last + 1
}

/// Returns the lines across the picture where pings begin and end.
fn edges(lens: &Lens, pings: Range<usize>) -> [[Pos2; 2]; 2] {
    [pings.start, pings.end].map(|ping| lens.line_at_ping(ping as f64))
}

/// Returns the area between two edges in the picture; `None` if it is not visible.
fn area(lens: &Lens, [from, to]: [[Pos2; 2]; 2]) -> Option<Rect> {
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

/// Thickness of a bar, points.
const BAR: f32 = 2.0;
/// Greatest distance of the pointer from a bar, points.
const REACH: f32 = 10.0;

/// A visible flat stretch.
pub(super) struct ShownStretch {
    /// Area of the stretch over the whole range of the picture.
    area: Rect,
    edges: [[egui::Pos2; 2]; 2],
    nadir: Rect,
    kind: Kind,
    name: String,
}

/// Kind of a stretch.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    InUse,
    Proposed,
    Ranked,
}

/// Returns the visible stretches: that of the calibration, the proposed one, and the ranked ones if
/// they are shown or one is to be chosen.
pub(super) fn flat_in_view(lens: &Lens, app: &App) -> Vec<ShownStretch> {
    let products = app.logs.shown.products.as_ref();
    let Some(products) = products.filter(|_| place::has_side_scan(app)) else {
        return Vec::new();
    };
    let calibration = &products.calibration;
    let name = place::calibrated_name(calibration.mode);
    let is_shown = app.view.options.shows_measured_stretch(calibration.mode);
    let used = calibration.flat_spot.iter().filter(|_| is_shown);
    let used = used.filter_map(|spot| stretch(lens, &spot.pings, Kind::InUse, name.to_owned()));
    let proposed = app.logs.shown.proposed_stretch();
    let proposed = proposed.map(|pings| pings.start..pings.end);
    let proposed = proposed.and_then(|pings| {
        let name = "proposed for the scale".to_owned();
        stretch(lens, &pings, Kind::Proposed, name)
    });
    let units = app.view.options.units;
    let ranked = products.flat_spots.iter().enumerate();
    let ranked = ranked.filter(|_| shows_ranked(app)).filter_map(|(rank, spot)| {
        let name = format!("{}: {}", rank + 1, place::stretch_brief(spot, units));
        stretch(lens, &spot.pings, Kind::Ranked, name)
    });
    proposed.into_iter().chain(used).chain(ranked).collect()
}

fn shows_ranked(app: &App) -> bool {
    app.view.options.shows_flat_stretches(View::Waterfall)
        || app.logs.shown.reviewing.tool == Tool::Calibrate
}

/// Returns the ranked stretch whose bar is under the pointer.
pub(super) fn under_bar(lens: &Lens, app: &App, at: Pos2) -> Option<PingRange> {
    let spots = app.logs.shown.products.as_ref()?.flat_spots.iter();
    let mut spots = spots.filter(|_| shows_ranked(app));
    let is_here = |spot: &&FlatSpot| {
        let found = stretch(lens, &spot.pings, Kind::Ranked, String::new());
        found.is_some_and(|found| found.nadir.expand(REACH).contains(at))
    };
    spots.find(is_here).map(FlatSpot::range)
}

fn stretch(lens: &Lens, pings: &Range<usize>, kind: Kind, name: String) -> Option<ShownStretch> {
    let edges = edges(lens, pings.clone());
    let area = area(lens, edges)?;
    let at = |ping: usize| lens.screen_at(LensPlace::of(ping as f64, Side::Starboard, 0.0));
    let [start, end] = [pings.start, pings.end].map(at);
    let nadir = Rect::from_two_pos(start, end).expand(BAR / 2.0);
    let nadir = nadir.intersect(lens.rect.expand(BAR));
    Some(ShownStretch { area, edges, nadir, kind, name })
}

impl ShownStretch {
    /// Draws the stretch: two lines across the picture for the stretch of the calibration and the
    /// proposed one, a bar along the nadir for the others. The echoes between the lines stay
    /// visible.
    pub(super) fn draw(&self, painter: &Painter) {
        let colour = self.colour();
        if self.kind == Kind::Ranked {
            painter.rect_filled(self.nadir.expand(1.0), 1.0, Color32::from_black_alpha(150));
            painter.rect_filled(self.nadir, 1.0, colour);
            return;
        }
        for edge in self.edges {
            painter.line_segment(edge, Stroke::new(3.0, Color32::from_black_alpha(110)));
            let width = if self.kind == Kind::Proposed { 2.0 } else { 1.0 };
            painter.line_segment(edge, Stroke::new(width, colour));
        }
        if self.kind == Kind::Proposed {
            painter.rect_filled(self.nadir.expand(1.0), 1.0, colour);
        }
    }

    /// Writes the name at the beginning of the stretch or, for a bar, in its middle.
    pub(super) fn label(&self, labels: &mut WaterfallLabels<'_>) {
        let (at, anchor) = match self.kind {
            Kind::Ranked => (self.nadir.center(), Align2::CENTER_CENTER),
            Kind::InUse => (self.area.left_top() + vec2(5.0, 4.0), Align2::LEFT_TOP),
            // Lower than the name of the stretch in use, so that both fit if they are the same
            // stretch.
            Kind::Proposed => (self.area.left_top() + vec2(5.0, 22.0), Align2::LEFT_TOP),
        };
        labels.write(at, anchor, &self.name, self.colour());
    }

    fn colour(&self) -> Color32 {
        match self.kind {
            // White in any theme, because the picture is dark or coloured.
            Kind::Ranked => Color32::from_gray(235),
            Kind::InUse => theme::CALIBRATION_COLOUR,
            Kind::Proposed => theme::PROPOSAL_COLOUR,
        }
    }
}
