//! Draws planned lines on the map with the way through them; a click selects a line, a drag moves
//! one of its ends.

use super::MapScene;
use super::transform::MapTransform;
use crate::app::{Action, App, Command, PlanRequest, PlannedLines};
use crate::ui::views::{legend, tool};
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::planning::Leg;
use bathyscope_bottom::presentation::text;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::Products;
use egui::{
    Align2, CursorIcon, Painter, Pos2, Rect, Response, RichText, Shape, Stroke, Ui, pos2, vec2,
};

/// Greatest distance of the pointer from a line, or from the end of a line, points.
const REACH: f32 = 9.0;
/// Width of the map below which the buttons are below the words, points.
const ONE_ROW: f32 = 640.0;

/// Tool that drags the ends of planned lines; `None` while no end is dragged.
#[derive(Default)]
pub(super) struct PlanTool {
    drag: Option<Drag>,
}

#[derive(Clone, Copy)]
struct Drag {
    line: usize,
    /// 0 for the start of the line, 1 for its end.
    end: usize,
    at: Pos2,
}

/// Actions of the pointer that the planned lines have used in this frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PointerUse {
    /// True if a drag must not move the map.
    pub drag: bool,
    /// True if a click must have no other effect.
    pub click: bool,
}

/// Area of the map on the screen, and the log whose plane it is in.
pub(super) struct MapPlace<'a> {
    /// Part of the screen.
    pub rect: Rect,
    /// Transform from the plane to the screen.
    pub transform: MapTransform,
    /// Survey of the shown log.
    pub survey: &'a Survey,
    /// Results of the shown log.
    pub products: &'a Products,
}

impl MapPlace<'_> {
    /// Returns both ends of every line on the screen.
    fn lines(&self, planned: &PlannedLines) -> Vec<[Pos2; 2]> {
        let ends = |leg: &Leg| [leg.from, leg.to].map(|place| self.at(planned, place));
        planned.plan.lines.iter().map(ends).collect()
    }

    fn at(&self, planned: &PlannedLines, [east_m, north_m]: [f64; 2]) -> Pos2 {
        let position = planned.frame.to_lon_lat(east_m, north_m);
        let navigation = &self.products.navigation;
        let place = navigation.to_plane(&self.survey.track, position);
        self.transform.to_screen(self.rect, place)
    }
}

impl PlanTool {
    /// Handles clicks and drags on the lines, unless another tool uses the pointer; returns what
    /// was used.
    pub(super) fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        place: &MapPlace<'_>,
        context: &mut ViewContext<'_>,
    ) -> PointerUse {
        let app = context.app;
        let has_other_tool = app.map.measuring.tool.is_some() || super::stretches::is_in_hand(app);
        let Some(planned) = app.map.planning.lines.clone().filter(|_| !has_other_tool) else {
            self.drag = None;
            return PointerUse::default();
        };
        let lines = place.lines(&planned);
        if response.hover_pos().and_then(|at| end_under(&lines, at)).is_some() {
            ui.set_cursor_icon(CursorIcon::Grab);
        }
        if let Some(at) = tool::begun(ui, response)
            && let Some((line, end)) = end_under(&lines, at)
        {
            self.drag = Some(Drag { line, end, at });
        }
        if tool::is_given_up(ui, response) {
            self.drag = None;
        }
        if let Some(drag) = &mut self.drag {
            drag.at = response.interact_pointer_pos().unwrap_or(drag.at);
            let Drag { line, end, at } = *drag;
            if response.drag_stopped() {
                self.drag = None;
                let [east_m, north_m] = place.transform.to_ground(place.rect, at);
                let navigation = &place.products.navigation;
                let to = navigation.to_lon_lat(&place.survey.track, east_m, north_m);
                context.push(Command::Plan(PlanRequest::Move { line, end, to }));
            }
            return PointerUse { drag: true, click: false };
        }
        let clicked = response.clicked().then(|| response.interact_pointer_pos());
        let under = clicked.flatten().and_then(|at| line_under(&lines, at));
        if under.is_some() || response.clicked() && app.map.planning.selected.is_some() {
            context.push(Command::Plan(PlanRequest::Select(under)));
        }
        PointerUse { drag: false, click: under.is_some() }
    }

    /// Draws the lines, and describes their length and uncertainties.
    pub(super) fn ui(&self, ui: &mut Ui, context: &mut ViewContext<'_>, scene: &MapScene<'_>) {
        let Some(planned) = context.app.map.planning.lines.clone() else {
            return;
        };
        let place = MapPlace {
            rect: scene.rect,
            transform: scene.transform,
            survey: scene.survey,
            products: scene.products,
        };
        let mut lines = place.lines(&planned);
        if let Some(drag) = self.drag
            && let Some(line) = lines.get_mut(drag.line)
        {
            line[drag.end] = drag.at;
        }
        let way = planned.plan.way.iter();
        let way: Vec<Pos2> = way.map(|waypoint| place.at(&planned, waypoint.place)).collect();
        let painter = ui.painter_at(scene.rect);
        let selected = context.app.map.planning.selected;
        paint(&painter, scene, &way, &lines, selected);
        strip(ui, context, scene.rect, &planned);
    }
}

fn end_under(lines: &[[Pos2; 2]], at: Pos2) -> Option<(usize, usize)> {
    let ends = lines.iter().enumerate().flat_map(|(line, ends)| {
        let away = move |end: usize| (ends[end].distance(at), (line, end));
        [0, 1].map(away)
    });
    let near = ends.filter(|(away, _)| *away <= REACH);
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, end)| end)
}

fn line_under(lines: &[[Pos2; 2]], at: Pos2) -> Option<usize> {
    let away = |[from, to]: &[Pos2; 2]| {
        let way = *to - *from;
        let share = ((at - *from).dot(way) / way.length_sq().max(1e-6)).clamp(0.0, 1.0);
        (*from + share * way).distance(at)
    };
    let each = lines.iter().map(away).enumerate();
    let near = each.filter(|(_, away)| *away <= REACH);
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(line, _)| line)
}

/// Draws the way as a thin line, and over it the lines with an arrow and their number.
fn paint(
    painter: &Painter,
    scene: &MapScene<'_>,
    way: &[Pos2],
    lines: &[[Pos2; 2]],
    selected: Option<usize>,
) {
    let casing = theme::canvas_colour(scene.options);
    let faint = scene.text_colour().gamma_multiply(0.6);
    painter.add(Shape::line(way.to_vec(), Stroke::new(1.0, faint)));
    for (number, [from, to]) in lines.iter().enumerate() {
        let colour =
            if selected == Some(number) { theme::SELECTION_COLOUR } else { theme::MEASURE_COLOUR };
        let stroke = Stroke::new(2.0, colour);
        let under = Stroke::new(4.0, casing.gamma_multiply(0.7));
        painter.line_segment([*from, *to], under);
        painter.line_segment([*from, *to], stroke);
        let ahead = (*to - *from).normalized();
        let middle = from.lerp(*to, 0.5);
        for side in [-1.0, 1.0] {
            let back = -8.0 * ahead + side * 4.0 * ahead.rot90();
            painter.line_segment([middle, middle + back], stroke);
        }
        for (end, radius) in [(from, 4.0), (to, 3.0)] {
            painter.circle(*end, radius, colour, Stroke::new(1.0, casing));
        }
        let at = *from + vec2(6.0, -6.0);
        let text = format!("{}", number + 1);
        painter.text(at, Align2::LEFT_BOTTOM, text, legend::font(), colour);
    }
}

/// Draws the strip of the planned lines: their length, duration and uncertainties, with the
/// buttons.
fn strip(ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect, planned: &PlannedLines) {
    let (foot, right) = (rect.left_bottom(), rect.right() - 84.0);
    let is_narrow = right - foot.x < ONE_ROW;
    let height = if is_narrow { 66.0 } else { 28.0 };
    let bar = Rect::from_min_max(foot + vec2(6.0, -84.0 - height), pos2(right, foot.y - 84.0));
    let words = RichText::new(words(context.app, planned)).size(11.5);
    legend::framed(ui, context.options(), bar, |ui| {
        if is_narrow {
            ui.label(words);
            ui.horizontal(|ui| buttons(ui, context));
        } else {
            ui.horizontal(|ui| {
                ui.label(words);
                buttons(ui, context);
            });
        }
    });
}

/// Draws the buttons for the lines; none in a picture.
fn buttons(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if context.app.view.is_picture {
        return;
    }
    ui.spacing_mut().item_spacing.x = 4.0;
    let is_selected = context.app.map.planning.selected.is_some();
    for (action, name) in [
        (Action::SavePlan, "Save…"),
        (Action::RemoveLine, "Remove line"),
        (Action::RemovePlan, "Remove all"),
    ] {
        if action == Action::RemoveLine && !is_selected {
            continue;
        }
        context.named_button(ui.small_button(name), action);
    }
}

/// Describes a plan as `14 lines, 2310 m with turns, 19.8 min; sigma 0.210 m, then 0.130 m`.
fn words(app: &App, planned: &PlannedLines) -> String {
    let (plan, units) = (&planned.plan, app.view.options.units);
    let lines = text::plural(plan.lines.len(), "line", "lines");
    let outside = match plan.turns_outside {
        0 => String::new(),
        count => format!("; {} outside the survey", text::plural(count, "turn", "turns")),
    };
    let (length, minutes) = (units.measure(plan.length_m, 0), plan.minutes());
    let sigmas = [&plan.before, &plan.after].map(|worth| worth.mean_sigma_m);
    let [before, after] = sigmas.map(|sigma_m| units.measure(sigma_m, 3));
    let sigmas = format!("sigma {before}, then {after}");
    format!("{lines}, {length} with turns, {minutes:.1} min; {sigmas}{outside}")
}
