//! Measures in the waterfall: corners on the ground under the picture, and the height of an object
//! from its shadow.

use super::labels;
use super::lens::{Lens, LensPlace};
use crate::app::{Action, App, Command, Measure, View};
use crate::ui::views::{legend, measured, tool};
use crate::ui::{ViewContext, theme};
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_products::project::{Measurement, MeasurementKind, Pick};
use egui::{CursorIcon, Painter, Pos2, Rect, Response, Shape, Stroke, Ui, Vec2, vec2};

/// Half of the length of the stroke at the end of a shadow, points.
const TICK: f32 = 7.0;

/// The cross that the arrow keys move over the waterfall with a tool selected; its place is `None`
/// before a key has moved it, and after the pointer has moved.
#[derive(Default)]
pub(super) struct Cross {
    place: Option<LensPlace>,
}

impl Cross {
    /// Moves the cross by the keys of this frame; returns true if they moved it.
    pub(super) fn follow(
        &mut self,
        ui: &mut Ui,
        response: &Response,
        lens: &Lens,
        context: &ViewContext<'_>,
    ) -> bool {
        let hover = response.hover_pos();
        if hover.is_some() && ui.input(|input| input.pointer.delta() != Vec2::ZERO) {
            self.place = None;
        }
        let moved = match context.target {
            View::Waterfall => measured::arrows(ui),
            _ => [0.0; 2],
        };
        if moved == [0.0; 2] {
            return false;
        }
        let from = self.place.or(hover.map(|at| lens.place_at(at)));
        let from = from.map_or(lens.rect.center(), |place| lens.screen_at(place));
        // Up on the screen is a smaller y.
        let to = from + vec2(moved[0] as f32, -moved[1] as f32);
        self.place = Some(lens.place_at(to));
        true
    }

    /// Returns the place of the cross, or else of the pointer.
    fn or_pointer(&self, response: &Response, lens: &Lens) -> Option<LensPlace> {
        let under = response.hover_pos().map(|at| lens.place_at(at));
        self.place.or(under)
    }

    /// Returns the place of the cross.
    pub(super) fn place(&self) -> Option<LensPlace> {
        self.place
    }

    /// Draws the cross.
    pub(super) fn draw(&self, painter: &Painter, lens: &Lens) {
        let Some(place) = self.place else {
            return;
        };
        measured::cross(painter, lens.screen_at(place));
    }
}

/// State of measuring that the view keeps between frames.
#[derive(Default)]
pub(super) struct MeasureTool {
    /// Cross that the arrow keys move; it disappears when the pointer moves.
    cross: Cross,
    /// True if a corner was requested by key.
    wants_corner: bool,
    /// True during a drag along a shadow.
    drags: bool,
    /// Place of the next corner; `None` where nothing was recorded.
    next: Option<Pick>,
}

impl MeasureTool {
    /// Sets a corner in the next frame.
    pub(super) fn set_corner(&mut self) {
        self.wants_corner = true;
    }

    /// Handles pointer and keys with a measuring tool; returns true if a drag must not move the
    /// picture.
    pub(super) fn follow(
        &mut self,
        ui: &mut Ui,
        response: &Response,
        lens: &Lens,
        survey: &Survey,
        context: &mut ViewContext<'_>,
    ) -> bool {
        let by_key = std::mem::take(&mut self.wants_corner);
        let Some(kind) = context.app.map.measuring.tool else {
            *self = Self::default();
            return false;
        };
        if response.hovered() {
            ui.set_cursor_icon(CursorIcon::Crosshair);
        }
        self.cross.follow(ui, response, lens, context);
        let place = self.cross.or_pointer(response, lens);
        let pick =
            |place: LensPlace| Some(context.app.map.measuring.on_one_ping(pick_at(survey, place)?));
        self.next = place.and_then(pick);
        let set = |at: Option<Pos2>| pick(lens.place_at(at?));
        let mut picked = None;
        if kind == MeasurementKind::Height
            && let Some(at) = tool::begun(ui, response)
        {
            picked = set(Some(at));
            self.drags = picked.is_some();
        }
        let held = self.drags;
        if self.drags && response.drag_stopped() {
            self.drags = false;
            if tool::is_given_up(ui, response) {
                context.push(Command::Do(Action::TakeCornerBack))
            } else {
                picked = set(response.interact_pointer_pos())
            }
        }
        if response.double_clicked() {
            // The first click of the double-click has set the last corner.
            context.push(Command::Do(Action::EndFigure));
        } else if response.clicked() {
            picked = set(response.interact_pointer_pos());
        } else if by_key {
            picked = self.next.clone();
        }
        if let Some(pick) = picked {
            context.push(Command::Measure(Measure::Pick(pick)));
        }
        held
    }

    /// Draws the part of the figure in this log, with the next corner while drawing.
    pub(super) fn draw(&self, painter: &Painter, lens: &Lens, app: &App) {
        if app.map.measuring.tool.is_some() {
            self.cross.draw(painter, lens);
        }
        let Some(shown) = self.shown(app) else {
            return;
        };
        match shown.kind {
            MeasurementKind::Height => shadow(painter, lens, app, &shown),
            _ => corners(painter, lens, app, &shown),
        }
    }

    /// Draws the strip with the result of the measurement, if it was measured in a waterfall.
    pub(super) fn strip(&self, ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect) {
        let shown = self.shown(context.app);
        if let Some(shown) = shown.filter(|shown| !shown.picks.is_empty()) {
            measured::strip(ui, context, rect, &shown);
        }
    }

    /// Returns the area of the figure on the screen while it is being drawn; `None` otherwise.
    pub(super) fn area(&self, lens: &Lens, app: &App) -> Option<Rect> {
        let shown = self.shown(app).filter(|_| app.map.measuring.is_drawing())?;
        let places = on_screen(lens, app, &shown);
        let points: Vec<Pos2> = places.into_iter().map(|(_, at)| at).collect();
        (!points.is_empty()).then(|| Rect::from_points(&points))
    }

    /// Returns the figure, with the next corner while it is being drawn.
    fn shown(&self, app: &App) -> Option<Measurement> {
        let figure = &app.map.measuring.figure.as_deref()?.measurement;
        let next = self.next.as_ref();
        let next = next.filter(|_| app.map.measuring.is_drawing());
        let at = figure.corners.last().copied();
        Some(match next.zip(at) {
            // The place of the next corner on the ground is not known before it is set; until then
            // only the picture needs the corner.
            Some((next, at)) if figure.kind == MeasurementKind::Height => {
                figure.with(at, Some(next.clone()))
            }
            _ => figure.clone(),
        })
    }
}

/// Returns the pick at a place of the picture; `None` where nothing was recorded.
fn pick_at(survey: &Survey, place: LensPlace) -> Option<Pick> {
    if place.ping < 0.0 {
        return None;
    }
    let (ping, side) = (place.ping as usize, place.side());
    let span = survey.span(ping, side)?;
    let far_m = span.range_m(f64::from(span.count));
    Some(Pick { log: Identity::of(survey), side, ping, slant_m: place.across_m.abs().min(far_m) })
}

/// Returns the places on the screen of the figure's picks in the shown log, each with the number of
/// its corner.
fn on_screen<'a>(lens: &'a Lens, app: &App, figure: &'a Measurement) -> Vec<(usize, Pos2)> {
    let Some(survey) = &app.logs.shown.survey else {
        return Vec::new();
    };
    let shown = Identity::of(survey);
    let picks = figure.picks.iter();
    let own = picks.filter(|(_, pick)| pick.log.is_same_log(&shown));
    let at =
        |pick: &Pick| LensPlace::of(pick.ping as f64 + 0.5, pick.side_in(survey), pick.slant_m);
    own.map(|(corner, pick)| (*corner, lens.screen_at(at(pick)))).collect()
}

/// Draws the corners, the lines between adjacent corners in this log, and the numbers beside the
/// last corner.
fn corners(painter: &Painter, lens: &Lens, app: &App, figure: &Measurement) {
    let corners = on_screen(lens, app, figure);
    let colour = theme::MEASURE_COLOUR;
    let casing = egui::Color32::from_black_alpha(180);
    let count = figure.corners.len();
    let closes = figure.kind == MeasurementKind::Area && count > 2;
    let next =
        |corner: usize| if corner + 1 == count { closes.then_some(0) } else { Some(corner + 1) };
    for (corner, at) in &corners {
        let to = next(*corner).and_then(|next| corners.iter().find(|(other, _)| *other == next));
        if let Some((_, to)) = to {
            painter.line_segment([*at, *to], Stroke::new(4.0, casing));
            painter.line_segment([*at, *to], Stroke::new(2.0, colour));
        }
    }
    for (_, at) in &corners {
        painter.circle(*at, 3.5, colour, Stroke::new(1.0, casing));
    }
    let last = corners.last().filter(|(corner, _)| corner + 1 == count);
    if let Some(((_, at), words)) = last.zip(measured::beside(app, figure)) {
        label(painter, lens, *at, &words);
    }
}

/// Draws the shadow between its ends, with the height computed from its length.
fn shadow(painter: &Painter, lens: &Lens, app: &App, figure: &Measurement) {
    let ends = on_screen(lens, app, figure);
    let colour = theme::MEASURE_COLOUR;
    let casing = egui::Color32::from_black_alpha(180);
    if let [(_, top), (_, end)] = ends[..] {
        let along =
            if (end - top).length() > 0.0 { (end - top).normalized() } else { vec2(0.0, 1.0) };
        let tick = TICK * along.rot90();
        for (width, ink) in [(4.0, casing), (2.0, colour)] {
            let stroke = Stroke::new(width, ink);
            painter.line_segment([top, end], stroke);
            for at in [top, end] {
                painter.line_segment([at - tick, at + tick], stroke);
            }
        }
    }
    for (corner, at) in &ends {
        if *corner == 0 {
            // The top of the object: a triangle over its place.
            let tip = [vec2(0.0, -7.0), vec2(6.0, 4.0), vec2(-6.0, 4.0)].map(|by| *at + by);
            let outline = Stroke::new(1.0, casing);
            painter.add(Shape::convex_polygon(tip.to_vec(), colour, outline));
        }
    }
    let words = figure
        .shadow()
        .and_then(|(top, recorded_m)| app.logs.shadow_height(top, recorded_m))
        .map(|found| measured::height(&found, app.view.options.units));
    if let Some(((_, at), words)) = ends.last().zip(words) {
        label(painter, lens, *at, &words);
    }
}

/// Writes numbers beside a place, on the side where there is more room.
fn label(painter: &Painter, lens: &Lens, at: Pos2, words: &str) {
    let (shift, anchor) = legend::beside(at, lens.rect, 12.0);
    labels::text(painter, at + shift, anchor, words);
}
