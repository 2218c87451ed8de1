//! Measures on the map: the selected tool, its drawing, and the depths along the line.
//!
//! Input: the state and the actions of the pointer. Output: lines, a plot, and commands.
//!
//! `profile` is the plot below the map, with its axes.

mod profile;

use super::MapScene;
use crate::app::{Action, App, Command, Measure, View};
use crate::ui::views::{legend, measured};
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::bathymetry::TransectStation;
use bathyscope_log::support::geo::LonLat;
use bathyscope_products::project::{Measurement, MeasurementKind};
use egui::{Painter, Pos2, Rect, Response, Shape, Stroke, Ui};

pub(crate) use profile::split;

/// State of measuring that the view keeps between frames.
#[derive(Default)]
pub(super) struct MeasureTool {
    /// Place of the cross that the arrow keys have moved, metres; `None` if the pointer has moved
    /// since.
    cross: Option<[f64; 2]>,
    /// True if a corner was requested by key.
    wants_corner: bool,
    /// Next corner of a profile, as it was last reported to the state.
    next: Option<LonLat>,
    /// Place of the pointer along the line, metres from its start; `None` if the pointer is not on
    /// the line or the plot.
    hovered_m: Option<f64>,
}

impl MeasureTool {
    /// Sets a corner in the next frame.
    pub(super) fn set_corner(&mut self) {
        self.wants_corner = true;
    }

    /// Handles the tool, and paints the figure and its measurements; called while the map is drawn.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        context: &mut ViewContext<'_>,
        scene: &MapScene<'_>,
        response: &Response,
    ) {
        let next = self.next_place(ui, context, scene, response);
        self.act(context, scene, response, next);
        let next = next.map(|place| scene.position(scene.at(place)));
        let shown = shown(context.app, next);
        self.tell_next(ui, context, next);
        let painter = ui.painter_at(scene.rect);
        if let Some(cross) = self.cross {
            measured::cross(&painter, scene.at(cross));
        }
        if let Some(shown) = &shown {
            paint_figure(&painter, scene, context.app, shown);
            self.follow_on_map(ui, context.app, scene, response);
        }
        let hovered = self.hovered_m.and_then(|at_m| profile::nearest(stations(context.app), at_m));
        if let Some(station) = hovered {
            paint_station(&painter, scene, station);
        }
        if let Some(shown) = shown.filter(|shown| shown.picks.is_empty()) {
            measured::strip(ui, context, scene.rect, &shown);
        }
    }

    /// Draws the plot of the depth profile into its part of the view.
    pub(super) fn plot(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect) {
        let mut hovered_m = self.hovered_m;
        profile::ui(ui, context, rect, &mut hovered_m);
        if self.hovered_m != hovered_m {
            self.hovered_m = hovered_m;
            // The map above has already been drawn in this frame.
            ui.ctx().request_repaint();
        }
    }

    /// Returns the place of the next corner: under the pointer, or at the cross if the arrow keys
    /// have moved it; `None` without a tool or place.
    fn next_place(
        &mut self,
        ui: &mut Ui,
        context: &ViewContext<'_>,
        scene: &MapScene<'_>,
        response: &Response,
    ) -> Option<[f64; 2]> {
        let tool = context.app.map.measuring.tool;
        if tool.is_none() || tool == Some(MeasurementKind::Height) {
            self.cross = None;
            return None;
        }
        let hover = response.hover_pos();
        if ui.input(|input| input.pointer.delta() != egui::Vec2::ZERO) && hover.is_some() {
            self.cross = None;
        }
        let moved = match context.target {
            View::Map => measured::arrows(ui),
            _ => [0.0; 2],
        };
        let under = hover.map(|at| scene.transform.to_ground(scene.rect, at));
        if moved != [0.0; 2] {
            let from = self.cross.or(under).unwrap_or(scene.transform.centre_m);
            let metres = scene.transform.metres_per_point;
            self.cross = Some([from[0] + moved[0] * metres, from[1] + moved[1] * metres]);
        }
        self.cross.or(under)
    }

    fn act(
        &mut self,
        context: &mut ViewContext<'_>,
        scene: &MapScene<'_>,
        response: &Response,
        next: Option<[f64; 2]>,
    ) {
        let by_key = std::mem::take(&mut self.wants_corner);
        let tool = context.app.map.measuring.tool;
        if tool.is_none() || tool == Some(MeasurementKind::Height) {
            return;
        }
        let corner = |at: Pos2| Command::Measure(Measure::Corner(scene.position(at)));
        if response.double_clicked() {
            // The first click of the double-click has set the last corner.
            context.push(Command::Do(Action::EndFigure));
        } else if response.clicked()
            && let Some(at) = response.interact_pointer_pos()
        {
            context.push(corner(at));
        } else if by_key && let Some(place) = next {
            context.push(corner(scene.at(place)));
        }
    }

    /// Reports the place of the next corner of a profile to the state, which then computes the
    /// depths up to there.
    fn tell_next(&mut self, ui: &Ui, context: &mut ViewContext<'_>, next: Option<LonLat>) {
        let is_drawing =
            context.app.map.measuring.is_drawing() && context.app.map.measuring.shows_profile();
        let next = next.filter(|_| is_drawing);
        if self.next != next {
            self.next = next;
            context.push(Command::Measure(Measure::Next(next)));
            ui.ctx().request_repaint();
        }
        if context.app.map.measuring.profile().is_none() {
            self.hovered_m = None;
        }
    }

    /// Marks in the plot the place of the line that is under the pointer on the map.
    fn follow_on_map(&mut self, ui: &Ui, app: &App, scene: &MapScene<'_>, response: &Response) {
        const REACH: f32 = 12.0;
        let Some(at) = response.hover_pos() else {
            return;
        };
        let off = |station: &TransectStation| scene.at(station.place).distance(at);
        let nearest = stations(app).iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        let hovered_m =
            nearest.filter(|station| off(station) < REACH).map(|station| station.distance_m);
        if hovered_m != self.hovered_m {
            self.hovered_m = hovered_m;
            ui.ctx().request_repaint();
        }
    }
}

/// Returns the figure as drawn on the map: with the next corner while drawing.
fn shown(app: &App, next: Option<LonLat>) -> Option<Measurement> {
    let measuring = &app.map.measuring;
    let figure = &measuring.figure.as_deref()?.measurement;
    Some(match next.filter(|_| measuring.is_drawing()) {
        Some(next) => figure.with(next, None),
        None => figure.clone(),
    })
}

/// Returns the depths along the line of the profile.
fn stations(app: &App) -> &[TransectStation] {
    let profile = app.map.measuring.profile();
    profile.map_or(&[], |line| &line.stations)
}

/// Draws line, corners, and the numbers beside the last one.
fn paint_figure(painter: &Painter, scene: &MapScene<'_>, app: &App, figure: &Measurement) {
    let corners: Vec<Pos2> =
        figure.corners.iter().map(|corner| scene.at_position(*corner)).collect();
    let colour = theme::MEASURE_COLOUR;
    let casing = theme::canvas_colour(scene.options);
    let mut line = corners.clone();
    if figure.kind == MeasurementKind::Area && corners.len() > 2 {
        line.push(corners[0]);
    }
    let around = Stroke::new(4.0, casing.gamma_multiply(0.7));
    painter.add(Shape::line(line.clone(), around));
    painter.add(Shape::line(line, Stroke::new(2.0, colour)));
    for at in &corners {
        painter.circle(*at, 3.5, colour, Stroke::new(1.0, casing));
    }
    if let (Some(at), Some(words)) = (corners.last(), measured::beside(app, figure)) {
        let (shift, anchor) = legend::beside(*at, scene.rect, 10.0);
        legend::words(painter, scene.options, *at + shift, anchor, &words);
    }
}

/// Draws the place of the line that is under the pointer in the plot.
fn paint_station(painter: &Painter, scene: &MapScene<'_>, station: &TransectStation) {
    let at = scene.at(station.place);
    let around = Stroke::new(4.0, theme::canvas_colour(scene.options));
    painter.circle_stroke(at, 6.0, around);
    painter.circle_stroke(at, 6.0, Stroke::new(2.0, theme::HOVER_COLOUR));
}
