//! Handles the pointer on the map: it moves the map, reads values, selects, and proposes a stretch
//! for the scale.

use super::stretches::{self, REACH};
use super::transform::MapTransform;
use super::{MapScene, objects};
use crate::app::{App, Command, LogId, LogPlace, PassesFound, Tool, mark_of};
use crate::ui::views::legend;
use crate::ui::{OwnHover, ViewContext, place, text, theme};
use bathyscope_log::support::geo::{CoordinateFormat, LonLat};
use bathyscope_products::pipeline::DepthMap;
use egui::{Align2, PointerButton, Pos2, Response, Ui, vec2};
use std::sync::Arc;

/// Greatest distance of the pointer from a point whose residual is shown, points.
const NEAR: f32 = 6.0;

/// Least width of the map for a place in one line in degrees and in metres, points.
const TWO_PLACES: f32 = 360.0;
/// Least width of the map for the whole read-out in one line, points.
const ONE_LINE: f32 = 720.0;

/// State of the pointer on the map.
#[derive(Default)]
pub(super) struct MapPointer {
    /// Room that the banner of a tool takes below the buttons, points.
    pub banner_height: f32,
    hover: OwnHover,
    /// Place at which the menu was opened; `None` before the first time.
    menu_at: Option<MenuAt>,
}

/// Place that the menu refers to.
struct MenuAt {
    position: LonLat,
    /// The nearby ping of a track, and its log; `None` if there is none.
    near: Option<(LogId, usize)>,
}

/// Moves the map: the wheel zooms at the pointer, a drag moves the map, with the main button only
/// if `drag_moves` (otherwise that button has another use).
pub(super) fn move_view(
    ui: &Ui,
    response: &Response,
    transform: &mut MapTransform,
    drag_moves: bool,
) {
    let rect = response.rect;
    let dragged = (drag_moves && response.dragged_by(PointerButton::Primary))
        || response.dragged_by(PointerButton::Middle);
    if dragged {
        transform.pan(response.drag_delta());
    }
    if let Some(at) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = f64::from((scroll * 0.005).exp() * pinch);
        if factor != 1.0 {
            transform.zoom(rect, at, factor);
        }
    }
}

impl MapPointer {
    /// Handles hover, click and menu.
    pub(super) fn handle(
        &mut self,
        ui: &mut Ui,
        context: &mut ViewContext<'_>,
        scene: &MapScene<'_>,
        response: &Response,
    ) {
        let at = response.hover_pos();
        // A selected measuring tool uses the pointer for itself.
        let is_measuring = context.app.map.measuring.tool.is_some();
        let near = at.and_then(|at| nearest(scene, context.app, at)).filter(|_| !is_measuring);
        // Other views show the log of the selection; they have no place for a ping of another log.
        let here = near.filter(|(log, _)| *log == context.app.logs.shown.id);
        let ping = here.map(|(_, ping)| LogPlace::ping(ping));
        self.hover.tell(context, ping);
        if let Some(at) = at {
            self.show_under(ui, context, scene, at, near);
        }
        if let Some(at) = response.interact_pointer_pos()
            && response.clicked()
            && !is_measuring
            && context.app.logs.shown.reviewing.tool != Tool::Exclude
        {
            self.click(context, scene, at);
        }
        if response.secondary_clicked() {
            let at = response.interact_pointer_pos();
            self.menu_at = at.map(|at| MenuAt {
                position: scene.position(at),
                near: nearest(scene, context.app, at),
            });
            if let Some(MenuAt { position, .. }) = self.menu_at {
                context.push(Command::FindPasses(position));
            }
        }
        self.menu(context, response);
    }

    /// Handles a click. It proposes a numbered stretch for the scale, or with the calibration tool
    /// any place of the track; otherwise it selects a box or a ping.
    fn click(&self, context: &mut ViewContext<'_>, scene: &MapScene<'_>, at: Pos2) {
        let near = nearest(scene, context.app, at);
        let spot = stretches::under(scene, at);
        let is_calibrating = context.app.logs.shown.reviewing.tool == Tool::Calibrate;
        if is_calibrating || spot.is_some() {
            let shown = &context.app.logs.shown;
            let own = near.filter(|(log, _)| *log == shown.id);
            let around = || own.and_then(|(_, ping)| shown.stretch_around(ping));
            let pings = spot.map(|(_, spot)| spot.range()).or_else(around);
            context.commands.extend(pings.map(Command::ProposeStretch));
            return;
        }
        if let Some(id) = objects::under(scene, context.app, at) {
            context.push(Command::SelectLogBox(id));
            return;
        }
        context.push(match near {
            Some((log, ping)) => Command::RevealIn(log, LogPlace::ping(ping)),
            None => Command::Select(None),
        });
    }

    fn menu(&mut self, context: &mut ViewContext<'_>, response: &Response) {
        let Some(MenuAt { position, near }) = self.menu_at else {
            return;
        };
        response.context_menu(|ui| {
            theme::whole_words(ui);
            let written = place::written(context.app, position);
            ui.label(&written);
            if ui.button("Copy position").clicked() {
                ui.copy_text(written);
                ui.close();
            }
            passes_menu(ui, context, position);
            let Some((log, ping)) = near else {
                return;
            };
            ui.separator();
            ui.label(named_ping(context.app, (log, ping)));
            let is_own = log == context.app.logs.shown.id;
            if is_own && ui.button("Propose for the scale").clicked() {
                if let Some(pings) = context.app.logs.shown.stretch_around(ping) {
                    context.push(Command::ProposeStretch(pings));
                }
                ui.close();
            }
            place::include_entry(ui, context, log, ping);
            if ui.button("Show in the other views").clicked() {
                context.push(Command::RevealIn(log, LogPlace::ping(ping)));
                ui.close();
            }
        });
    }

    /// Shows the read-out, and the description of a numbered stretch under the pointer.
    fn show_under(
        &self,
        ui: &Ui,
        context: &ViewContext<'_>,
        scene: &MapScene<'_>,
        at: Pos2,
        near: Option<(LogId, usize)>,
    ) {
        let painter = ui.painter_at(scene.rect);
        let text = read_out(context.app, scene, at, near);
        let corner = scene.rect.left_top() + vec2(6.0, 34.0 + self.banner_height);
        let anchor = Align2::LEFT_TOP;
        let plate = legend::words(&painter, scene.options, corner, anchor, &text);
        if let Some((rank, spot)) = stretches::under(scene, at) {
            let below = plate.left_bottom() + vec2(0.0, 2.0);
            let text = stretches::describe(rank, spot, context.units());
            legend::words(&painter, scene.options, below, anchor, &text);
        }
    }
}

/// Adds to the menu the passes that saw a place, once they are found; a click on a pass shows it in
/// the other views.
fn passes_menu(ui: &mut Ui, context: &mut ViewContext<'_>, at: LonLat) {
    let passes = match context.app.passes_at(at) {
        // The frame that opened the menu has just requested the search.
        PassesFound::Searching | PassesFound::Unasked => {
            ui.label("Looking for passes over this place");
            return;
        }
        PassesFound::Stopped => {
            if ui.button("Look for passes over this place").clicked() {
                context.push(Command::FindPasses(at));
            }
            return;
        }
        PassesFound::Found([]) => {
            ui.label("No side-scan saw this place");
            return;
        }
        PassesFound::Found(passes) => passes,
    };
    let seen = text::plural(passes.len(), "pass", "passes");
    ui.menu_button(format!("Seen by {seen}"), |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            for (log, pass) in passes {
                let [first, last] = pass.pings;
                let away = context.units().measure(pass.range_m, 1);
                let side = pass.side.name();
                let ping = named_ping(context.app, (*log, first));
                let to = if first == last { String::new() } else { format!(" to {last}") };
                let name = format!("{ping}{to}, {side}, slant range {away}");
                if ui.button(name).clicked() {
                    context.push(Command::RevealIn(*log, mark_of(pass)));
                    ui.close();
                }
            }
        });
    });
}

/// Returns the nearest ping within [`REACH`] and its log.
fn nearest(scene: &MapScene<'_>, app: &App, at: Pos2) -> Option<(LogId, usize)> {
    let place = scene.transform.to_ground(scene.rect, at);
    let reach_m = f64::from(REACH) * scene.transform.metres_per_point;
    scene.track.nearest_ping(place, reach_m, app.logs.shown.id)
}

/// Names a ping, with the name of its log if more than one is open.
fn named_ping(app: &App, (log, ping): (LogId, usize)) -> String {
    match app.logs.get(log).filter(|_| app.logs.count() > 1) {
        Some(log) => format!("{}, ping {ping}", log.name()),
        None => format!("ping {ping}"),
    }
}

fn read_out(app: &App, scene: &MapScene<'_>, at: Pos2, near: Option<(LogId, usize)>) -> String {
    let [east_m, north_m] = scene.transform.to_ground(scene.rect, at);
    // In one line the text of a narrow map would reach under the north arrow or beyond the tile.
    let gap = |needed: f32| if scene.rect.width() < needed { "\n" } else { "   " };
    let units = app.view.options.units;
    let mut text = place::written(app, scene.position(at));
    if app.view.options.coordinates != CoordinateFormat::Utm {
        text += gap(TWO_PLACES);
        let [east, north] = [east_m, north_m].map(|metres| units.measure(metres, 1));
        text += &format!("E {east}  N {north}");
    }
    let depth_map = scene.depth_map.flatten();
    let at_place = |map: &Arc<DepthMap>| {
        let place = [east_m, north_m];
        Some((map.at(place)?, map.source_at(place).name()))
    };
    if let Some(((depth_m, distance_m), source)) = depth_map.and_then(at_place) {
        text += gap(ONE_LINE);
        let depth = units.measure(f64::from(depth_m), 2);
        let reference = place::reduction(app).reference_name();
        let away = units.measure(f64::from(distance_m), 1);
        text += &format!("depth {depth} {reference} ({source}, nearest {away} away)");
    }
    let residuals = scene.residuals.as_deref();
    let reach_m = f64::from(NEAR) * scene.transform.metres_per_point;
    if let Some(difference_m) = residuals.and_then(|layer| layer.at([east_m, north_m], reach_m)) {
        text += gap(ONE_LINE);
        text += &format!("residual {}", units.signed(difference_m, 3));
    }
    if let Some(near) = near {
        text += "   ";
        text += &named_ping(app, near);
        if let Some(why) = place::excluded_at(app, near.0, near.1) {
            text += &format!(", {why}");
        }
    }
    text
}
