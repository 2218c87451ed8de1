//! Draws the plot of a depth profile below the map.

use crate::app::{Action, App, ProfileLine, ViewOptions};
use crate::ui::views::{legend, ticks};
use crate::ui::{ViewContext, place, theme};
use bathyscope_bottom::bathymetry::TransectStation;
use bathyscope_bottom::presentation::units::Units;
use egui::{
    Align2, Button, Color32, FontId, Label, Mesh, Painter, Pos2, Rect, RichText, Role, Sense,
    Shape, Stroke, Ui, UiBuilder, WidgetInfo, pos2, vec2,
};

/// Height of the line of words and buttons, points.
const HEAD: f32 = 24.0;

/// Returns the part of the view for the map, and the part for the plot while it is shown.
pub(crate) fn split(whole: Rect, app: &App) -> (Rect, Option<Rect>) {
    let requested = app.map.measuring.shows_profile() && app.logs.shown.products.is_some();
    if !requested || whole.height() < 120.0 {
        return (whole, None);
    }
    let height = (0.36 * whole.height()).clamp(90.0, 240.0).min(0.6 * whole.height());
    let (map, plot) = whole.split_top_bottom_at_y(whole.bottom() - height);
    (map, Some(plot))
}

/// Returns the station nearest to a distance.
pub(super) fn nearest(stations: &[TransectStation], at_m: f64) -> Option<&TransectStation> {
    let after = stations.partition_point(|station| station.distance_m < at_m);
    let about = [after.checked_sub(1), Some(after)];
    let about = about.into_iter().flatten();
    let about = about.filter_map(|index| stations.get(index));
    about.min_by(|a, b| (a.distance_m - at_m).abs().total_cmp(&(b.distance_m - at_m).abs()))
}

/// Draws the words, the buttons and the curve; sets `hovered_m` to the distance under the pointer,
/// metres from the start of the line.
pub(super) fn ui(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    rect: Rect,
    hovered_m: &mut Option<f64>,
) {
    let app = context.app;
    let line = app.map.measuring.profile();
    let (stations, corners_m) =
        line.map_or((&[][..], &[][..]), |line| (&line.stations[..], &line.corners_m[..]));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, theme::canvas_colour(context.options()));
    let edge = ui.visuals().widgets.noninteractive.bg_stroke;
    painter.hline(rect.x_range(), rect.top(), edge);
    let (head, body) = rect.split_top_bottom_at_y(rect.top() + HEAD);
    let frame = ProfileTransform::new(body, stations);
    head_line(ui, context, head.shrink2(vec2(8.0, 2.0)), frame.as_ref());
    let response = ui.interact(body, ui.scope_id().with("depth profile"), Sense::hover());
    let Some(frame) = frame else {
        let words = lack(line);
        let colour = ui.visuals().weak_text_color();
        let (middle, font) = (egui::Align2::CENTER_CENTER, FontId::proportional(12.0));
        painter.text(body.center(), middle, words, font, colour);
        response.widget_info(|| {
            WidgetInfo::labeled(Role::Image, true, format!("Depth profile, empty: {words}"))
        });
        return;
    };
    if let Some(at) = response.hover_pos() {
        *hovered_m = Some(frame.distance_m(at.x));
    }
    frame.axes(&painter, context.options(), corners_m);
    curve(&painter, &frame, stations, context);
    let pointed = hovered_m.and_then(|at_m| nearest(stations, at_m));
    if let Some(station) = pointed {
        mark(&painter, &frame, station, context);
    }
    let units = context.units();
    let name = name(stations, pointed, units);
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
}

fn head_line(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    rect: Rect,
    frame: Option<&ProfileTransform>,
) {
    let line = context.app.map.measuring.profile();
    let units = context.units();
    ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let ready = !context.app.map.measuring.stations().is_empty();
            for (action, label) in [
                (Action::RemoveFigure, "Close"),
                (Action::SaveProfile, "Save CSV…"),
                (Action::CopyProfile, "Copy"),
            ] {
                let enabled = ready || action == Action::RemoveFigure;
                let button = ui.add_enabled(enabled, Button::new(RichText::new(label).small()));
                let button = button.accessible_name(format!("{label} (depth profile)"));
                context.button(button, action);
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let title = RichText::new("DEPTH PROFILE").size(12.0).strong();
                ui.add(Label::new(title).selectable(false));
                if let Some(frame) = frame {
                    let figures = figures(line.map_or(&[], |line| &line.stations), units);
                    let factor = frame.exaggeration();
                    let figures = format!("{figures}, ×{factor:.0} vertical");
                    ui.add(Label::new(RichText::new(figures).small()).truncate());
                }
            });
        });
    });
}

/// Returns the reason why there is no curve.
fn lack(line: Option<&ProfileLine>) -> &'static str {
    match line {
        None => "Click the corners of a line on the map.",
        Some(line) if line.lacks_map() => "There is no depth map yet.",
        Some(_) => "No depth is known along this line.",
    }
}

/// Describes the length, the depths, and the share of the line without a depth.
fn figures(stations: &[TransectStation], units: Units) -> String {
    let length_m = stations.last().map_or(0.0, |last| last.distance_m);
    let depths = || stations.iter().filter_map(|station| station.depth_m);
    let mut text = units.ground_length(length_m);
    if let (Some(shallow_m), Some(deep_m)) = (depths().reduce(f32::min), depths().reduce(f32::max))
    {
        let depths_m = [shallow_m, deep_m].map(f64::from);
        text += &format!(", {} deep", units.span(depths_m, 2));
    }
    let unknown = stations.len() - depths().count();
    if unknown > 0 {
        text += &format!(", {:.0} % unknown", 100.0 * unknown as f64 / stations.len() as f64);
    }
    text
}

fn name(stations: &[TransectStation], pointed: Option<&TransectStation>, units: Units) -> String {
    let at = pointed.map_or_else(String::new, |station| format!("; {}", words(station, units)));
    format!("Depth profile, {}{at}", figures(stations, units))
}

fn words(station: &TransectStation, units: Units) -> String {
    let depth = station.depth_m.map_or_else(
        || "no depth".to_owned(),
        |depth_m| format!("{} deep", units.measure(f64::from(depth_m), 2)),
    );
    format!("at {}: {depth}", units.ground_length(station.distance_m))
}

/// Draws the bed as a line with the ground below filled, interrupted where no depth is known.
fn curve(
    painter: &Painter,
    frame: &ProfileTransform,
    stations: &[TransectStation],
    context: &ViewContext<'_>,
) {
    let colour = theme::MEASURE_COLOUR;
    for run in stations.split(|station| station.depth_m.is_none()) {
        let line: Vec<Pos2> = run.iter().filter_map(|station| frame.at(station)).collect();
        let fill = colour.gamma_multiply(0.18);
        painter.add(ground(&line, frame.area.bottom(), fill));
        match line[..] {
            [] => {}
            [alone] => {
                painter.circle_filled(alone, 1.5, colour);
            }
            _ => {
                painter.add(Shape::line(line, Stroke::new(1.8, colour)));
            }
        }
    }
    let ink = theme::plot_ink(context.options());
    let corner = frame.area.left_top() + vec2(4.0, 2.0);
    let font = legend::font();
    let title = place::reduction(context.app).reference();
    let title = title.title(context.units().symbol());
    painter.text(corner, egui::Align2::LEFT_TOP, title, font, ink);
}

fn ground(line: &[Pos2], bottom: f32, colour: Color32) -> Shape {
    let mut mesh = Mesh::default();
    for (index, at) in line.iter().enumerate() {
        mesh.colored_vertex(*at, colour);
        mesh.colored_vertex(pos2(at.x, bottom), colour);
        if index > 0 {
            let left = 2 * index as u32 - 2;
            mesh.add_triangle(left, left + 1, left + 2);
            mesh.add_triangle(left + 1, left + 2, left + 3);
        }
    }
    Shape::mesh(mesh)
}

/// Marks the station under the pointer.
fn mark(
    painter: &Painter,
    frame: &ProfileTransform,
    station: &TransectStation,
    context: &ViewContext<'_>,
) {
    let options = context.options();
    let x = frame.x(station.distance_m);
    let stroke = Stroke::new(1.0, theme::HOVER_COLOUR);
    painter.vline(x, frame.area.y_range(), stroke);
    if let Some(at) = frame.at(station) {
        painter.circle_filled(at, 3.5, theme::HOVER_COLOUR);
    }
    let foot = pos2(x, frame.area.bottom() - 4.0);
    let (shift, anchor) = legend::beside(foot, frame.area, 8.0);
    let at = pos2(x + shift.x, foot.y);
    let words = words(station, options.units);
    legend::words(painter, options, at, anchor, &words);
}

/// Room for the numbers of depth (left) and of distance (below), points.
const ROOM: [f32; 2] = [40.0, 18.0];

/// Transform between metres and the screen.
struct ProfileTransform {
    /// Area of the curve.
    pub area: Rect,
    length_m: f64,
    /// Depths at the upper and the lower edge, metres.
    depths_m: [f64; 2],
}

impl ProfileTransform {
    /// Creates a transform that shows a whole line, with room above and below its depths; `None` if
    /// no depth on the line is known, or if `rect` is too small.
    fn new(rect: Rect, stations: &[TransectStation]) -> Option<Self> {
        let length_m = stations.last()?.distance_m;
        let depths = || {
            let depths = stations.iter().filter_map(|station| station.depth_m);
            depths.map(f64::from)
        };
        let [shallow_m, deep_m] = [depths().reduce(f64::min)?, depths().reduce(f64::max)?];
        let margin_m = (0.1 * (deep_m - shallow_m)).max(0.05);
        let corner = rect.min + vec2(ROOM[0], 4.0);
        let area = Rect::from_min_max(corner, rect.max - vec2(12.0, ROOM[1]));
        (area.is_positive() && length_m > 0.0).then_some(Self {
            area,
            length_m,
            depths_m: [shallow_m - margin_m, deep_m + margin_m],
        })
    }

    /// Returns the screen x of a distance.
    fn x(&self, distance_m: f64) -> f32 {
        self.area.left() + (distance_m / self.length_m) as f32 * self.area.width()
    }

    /// Returns the distance at a screen x, limited to the line; inverse of [`ProfileTransform::x`].
    fn distance_m(&self, x: f32) -> f64 {
        let share = (x - self.area.left()) / self.area.width();
        f64::from(share.clamp(0.0, 1.0)) * self.length_m
    }

    /// Returns the screen y of a depth.
    fn y(&self, depth_m: f64) -> f32 {
        let [top_m, bottom_m] = self.depths_m;
        self.area.top() + ((depth_m - top_m) / (bottom_m - top_m)) as f32 * self.area.height()
    }

    /// Returns the place of a station on the screen; `None` without a depth.
    fn at(&self, station: &TransectStation) -> Option<Pos2> {
        Some(pos2(self.x(station.distance_m), self.y(f64::from(station.depth_m?))))
    }

    /// Returns the vertical exaggeration of the plot.
    fn exaggeration(&self) -> f64 {
        let [top_m, bottom_m] = self.depths_m;
        let down = f64::from(self.area.height()) / (bottom_m - top_m);
        down * self.length_m / f64::from(self.area.width())
    }

    /// Draws the axes with their lines and numbers, and a line at each corner.
    fn axes(&self, painter: &Painter, options: &ViewOptions, corners_m: &[f64]) {
        let ink = theme::plot_ink(options);
        let faint = Stroke::new(1.0, ink.gamma_multiply(0.2));
        let write = |at: Pos2, anchor: Align2, text: String| {
            painter.text(at, anchor, text, legend::font(), ink);
        };
        let [top_m, bottom_m] = self.depths_m;
        let units = options.units;
        let most = f64::from(self.area.height() / 24.0).max(1.0);
        let step_m = units.round_step_m(bottom_m - top_m, most);
        for depth_m in ticks::multiples(top_m, bottom_m, step_m) {
            let y = self.y(depth_m);
            painter.hline(self.area.x_range(), y, faint);
            let at = pos2(self.area.left() - 4.0, y);
            write(at, Align2::RIGHT_CENTER, units.tick(depth_m, step_m));
        }
        let most = f64::from(self.area.width() / 70.0).max(1.0);
        let step_m = units.round_step_m(self.length_m, most);
        // The unit is written once, at the end of the axis.
        let last_m = self.distance_m(self.area.right() - 78.0);
        for distance_m in ticks::multiples(0.0, last_m, step_m) {
            let x = self.x(distance_m);
            painter.vline(x, self.area.bottom()..=self.area.bottom() + 3.0, (1.0, ink));
            let at = pos2(x, self.area.bottom() + 4.0);
            write(at, Align2::CENTER_TOP, units.tick(distance_m, step_m));
        }
        let end = pos2(self.area.right(), self.area.bottom() + 4.0);
        let unit = format!("distance, {}", units.symbol());
        write(end, Align2::RIGHT_TOP, unit);
        for corner_m in corners_m {
            painter.vline(self.x(*corner_m), self.area.y_range(), faint);
        }
        painter.hline(self.area.x_range(), self.area.bottom(), (1.0, ink));
        painter.vline(self.area.left(), self.area.y_range(), (1.0, ink));
    }
}
