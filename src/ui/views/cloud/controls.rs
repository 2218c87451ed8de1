//! Draws the buttons on the cloud, its vertical exaggeration and its legend.

use super::scene::CloudScene;
use crate::app::{Action, App, CloudColour, ViewOptions};
use crate::ui::controls::{keep_arrows, number_slider};
use crate::ui::text::count;
use crate::ui::views::legend::{self, LegendScale};
use crate::ui::{ViewContext, ViewRequest, place, theme};
use bathyscope_bottom::bathymetry::CellSource;
use bathyscope_bottom::cloud::{DepthReference, PointClass};
use bathyscope_bottom::presentation::colours::{
    SOURCES, distance_colour, share_colour, uncertainty_colour,
};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{Side, SideScanState, Survey};
use bathyscope_products::pipeline::{Bottom, BottomColour, Products};
use egui::{
    Align2, Color32, Key, Painter, Rect, Response, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, pos2,
    vec2,
};

/// Largest number of logs in the legend.
const MOST_LOGS: usize = 8;

/// Range of vertical exaggeration on the slider.
const EXAGGERATIONS: std::ops::RangeInclusive<f32> = 1.0..=50.0;

/// Radius of the disc of the light control, points.
const RADIUS: f32 = 11.0;
/// Least height of the light over the horizon, degrees.
const LOWEST_DEG: f32 = 5.0;
/// Step by which an arrow key moves the light, degrees.
const STEP_DEG: f32 = 5.0;

/// Shows "Fit" above, and exaggeration and light below; colours and directions are chosen in the
/// view's title.
pub(super) fn show(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    rect: Rect,
    request: &mut Option<ViewRequest>,
) {
    let mut options = context.options().clone();
    let top = Rect::from_min_size(rect.min + vec2(4.0, 4.0), vec2(120.0, 28.0));
    legend::framed(ui, context.options(), top, |ui| {
        let hint = format!("Shows the whole cloud ({}, or a double-click).", Action::Fit.key());
        if ui.button("Fit").on_hover_text(hint).clicked() {
            *request = Some(ViewRequest::Fit);
        }
    });
    let corner = pos2(rect.left() + 4.0, rect.bottom() - 30.0);
    let bottom = Rect::from_min_size(corner, vec2(rect.width() - 90.0, 26.0));
    legend::framed(ui, context.options(), bottom, |ui| {
        ui.horizontal(|ui| {
            exaggeration(ui, &mut options);
            if options.cloud.bottom {
                dial(ui, &mut options.cloud.light_deg);
            }
        });
    });
    context.show(options);
}

/// Writes the vertical exaggeration, for an exported picture.
pub(super) fn paint_exaggeration(painter: &Painter, rect: Rect, options: &ViewOptions) {
    let text = format!("elevations x{}", options.cloud.vertical_exaggeration);
    let corner = rect.left_bottom() + vec2(8.0, -8.0);
    legend::words(painter, options, corner, Align2::LEFT_BOTTOM, &text);
}

fn exaggeration(ui: &mut Ui, options: &mut ViewOptions) {
    let factor = &mut options.cloud.vertical_exaggeration;
    let slider = number_slider(factor, EXAGGERATIONS)
        .logarithmic(true)
        .max_decimals(1)
        .prefix("x")
        .text("vertical");
    ui.spacing_mut().slider_width = 90.0;
    ui.add(slider).on_hover_text("Vertical exaggeration of the 3D view.");
}

/// Writes the properties of the point under the pointer, beside the button above.
pub(super) fn paint_read_out(
    painter: &Painter,
    rect: Rect,
    app: &App,
    survey: &Survey,
    products: &Products,
) {
    let index = app.view.hover.and_then(|mark| mark.point);
    let Some(point) = index.and_then(|index| products.cloud.points.get(index)) else {
        return;
    };
    let class = index.and_then(|index| products.classes.get(index));
    let class = class.filter(|class| !class.is_kept());
    let class = class.map_or(String::new(), |class| format!(", {}", class.name()));
    let units = app.view.options.units;
    // The value that the colour shows; there is no room for all that is known.
    let coloured = match app.view.options.cloud.colour {
        CloudColour::Level if point.source.is_side_scan() => {
            format!(", level {}", point.level)
        }
        CloudColour::Range => {
            let range_m = products.reduction().point_range_m(survey, point);
            format!(", range {}", units.measure(range_m, 2))
        }
        _ => String::new(),
    };
    let sample = if point.source.is_side_scan() {
        format!(", sample {:.0}", point.sample)
    } else {
        String::new()
    };
    let navigation = &products.navigation;
    let position = navigation.to_lon_lat(&survey.track, point.east_m, point.north_m);
    let text = format!(
        "{}, ping {}{sample}: {} {}{coloured}, {}{class}",
        point.source.name(),
        point.ping,
        units.measure(-point.z_m, 2),
        products.reduction().reference_name(),
        place::written(app, position),
    );
    let at = rect.left_top() + vec2(50.0, 9.0);
    legend::words(painter, &app.view.options, at, Align2::LEFT_TOP, &text);
}

/// Returns the reason why there are no side-scan points; `None` if there are some.
fn lack(survey: &Survey, units: Units) -> Option<String> {
    match survey.side_scan_state {
        SideScanState::Usable => None,
        SideScanState::Absent if !survey.swath.is_empty() => {
            Some("no side-scan in this log".to_owned())
        }
        SideScanState::Absent => Some("no side-scan in this log: soundings only".to_owned()),
        SideScanState::Noise { range_m } => Some(format!(
            "no side-scan: range ±{}, noise; soundings only",
            units.measure(f64::from(range_m), 1)
        )),
    }
}

/// Draws the meaning of the colours, with the number of points of each; returns the areas of its
/// lines and scales.
pub(super) fn paint_legend(
    painter: &Painter,
    rect: Rect,
    options: &ViewOptions,
    survey: &Survey,
    (scene, bottom): (&CloudScene, Option<&Bottom>),
    reference: DepthReference,
) -> Vec<Rect> {
    let mut at = rect.left_top() + vec2(8.0, 36.0);
    let mut covered = Vec::new();
    let mut lines = if options.cloud.points { lines(options, scene) } else { Vec::new() };
    if bottom.is_some_and(|bottom| bottom.colour == BottomColour::Source) {
        let sources = CellSource::KNOWN.iter().zip(SOURCES);
        lines
            .extend(sources.map(|(source, colour)| {
                (format!("bottom: {}", source.name()), theme::rgb(colour))
            }));
    }
    if bottom.is_some_and(|bottom| bottom.colour == BottomColour::Hardness && bottom.ends.is_none())
    {
        let text = "bottom: no hardness without depths from echo levels";
        lines.push((text.to_owned(), theme::OUTLIER_COLOUR));
    }
    for (text, colour) in lines {
        let beside = at + vec2(12.0, 0.0);
        let plate = legend::words(painter, options, beside, Align2::LEFT_TOP, &text);
        painter.circle_filled(pos2(at.x + 5.0, plate.center().y), 4.0, colour);
        at.y = plate.bottom() + 1.0;
        covered.push(plate);
    }
    let mut note = |text: &str, colour: Color32| {
        let plate = legend::plate(painter, options, at, Align2::LEFT_TOP, text, colour);
        at.y = plate.bottom() + 1.0;
        covered.push(plate);
    };
    if bottom.is_some_and(|bottom| bottom.has_flat_extrapolation) {
        let text = "mosaic on a level bed where no depth is known";
        note(text, theme::canvas_text_colour(options));
    }
    if let Some(text) = lack(survey, options.units) {
        note(&text, theme::OUTLIER_COLOUR);
    }
    let shown = options.cloud.points;
    let of_points = shown.then(|| scale(options, scene, reference)).flatten();
    let of_bottom = bottom.and_then(|bottom| bottom_scale(bottom, reference, options.units));
    let by_depth = options.cloud.colour == CloudColour::Depth;
    let is_one = by_depth && bottom.is_some_and(|bottom| bottom.colour == BottomColour::Depth);
    let mut corner = rect.right_bottom() - vec2(8.0, 8.0);
    let height = (rect.height() * 0.4).clamp(50.0, 160.0);
    for scale in of_bottom.into_iter().chain(of_points.filter(|_| !is_one)) {
        let shown = scale.show(painter, options, corner, height);
        corner.x = shown.left() - 4.0;
        covered.push(shown);
    }
    covered
}

/// Returns the scale of the bottom's colours; `None` if they do not show a number.
fn bottom_scale(bottom: &Bottom, reference: DepthReference, units: Units) -> Option<LegendScale> {
    let ends = bottom.ends?;
    let lengths =
        |name: &str, colour: fn(f32) -> [u8; 3]| LegendScale::of_lengths(name, ends, units, colour);
    Some(match bottom.colour {
        BottomColour::Mosaic | BottomColour::Source => return None,
        BottomColour::Depth => LegendScale::of_depth(ends, reference, units),
        BottomColour::Uncertainty => lengths("uncertainty", uncertainty_colour),
        BottomColour::Distance => lengths("to a depth", distance_colour),
        BottomColour::Hardness => LegendScale::of_hardness(ends),
    })
}

/// Returns the scale of the points' colours; `None` if they do not show a number.
fn scale(
    options: &ViewOptions,
    scene: &CloudScene,
    reference: DepthReference,
) -> Option<LegendScale> {
    let (ends, units) = (&scene.ends, options.units);
    match options.cloud.colour {
        CloudColour::Source | CloudColour::Log => None,
        CloudColour::Depth => {
            (ends.depth_m).map(|ends| LegendScale::of_depth(ends, reference, units))
        }
        CloudColour::Level => ends.scales.level.map(LegendScale::of_levels),
        CloudColour::Range => (ends.scales.range_m)
            .map(|ends| LegendScale::of_lengths("slant range", ends, units, share_colour)),
    }
}

fn lines(options: &ViewOptions, scene: &CloudScene) -> Vec<(String, Color32)> {
    let counts = &scene.counts;
    let mut lines = Vec::new();
    let mut kind = |points: usize, name: &str, colour: Color32| {
        if points > 0 {
            lines.push((format!("{name} {}", count(points)), colour));
        }
    };
    match options.cloud.colour {
        CloudColour::Source => {
            let down_scan = theme::down_scan_colour(options);
            kind(counts.down_scan, "down-scan", down_scan);
            kind(counts.port, "port", theme::side_colour(options, Side::Port));
            let starboard = theme::side_colour(options, Side::Starboard);
            kind(counts.starboard, "starboard", starboard);
            kind(counts.swath, "swath", theme::SWATH_COLOUR);
        }
        CloudColour::Depth | CloudColour::Range => {
            kind(counts.kept(), "points", theme::canvas_text_colour(options));
        }
        CloudColour::Level => {
            let first_returns = counts.port + counts.starboard;
            // First returns have the colour of the middle of the scale; soundings have the colour
            // of its text.
            kind(first_returns, "first returns", theme::rgb(share_colour(0.5)));
            let down_scan = theme::down_scan_colour(options);
            kind(counts.down_scan, "down-scan, no level", down_scan);
            kind(counts.swath, "swath, no level", theme::SWATH_COLOUR);
        }
        CloudColour::Log => {
            for (name, colour, kept) in scene.by_log().take(MOST_LOGS) {
                kind(kept, name, theme::rgb(colour));
            }
        }
    }
    let (verb, colour) = if options.cloud.outlier_preview {
        ("to be removed", theme::OUTLIER_COLOUR)
    } else {
        ("removed", theme::OUTLIER_COLOUR.gamma_multiply(0.4))
    };
    let classes = scene.classes;
    if classes.noise() > 0 {
        let (noise, share) = (count(classes.noise()), 100.0 * classes.noise_share());
        lines.push((format!("outliers {verb} {noise} ({share:.1} %)"), colour));
    }
    let others = [PointClass::AboveBottom, PointClass::Unclassified, PointClass::NoBottom];
    for class in others.into_iter().filter(|class| classes.count(*class) > 0) {
        let text = format!("{} {}", class.name(), count(classes.count(class)));
        lines.push((text, colour));
    }
    lines
}

/// Draws a control for the direction of the light on the bottom: a disc seen from above, north up,
/// with the light at its direction. `light_deg` is the direction clockwise from north and the
/// height over the horizon, degrees. A drag moves the light, the arrow keys turn and raise it.
fn dial(ui: &mut Ui, light_deg: &mut [f32; 2]) -> Response {
    let size = Vec2::splat(2.0 * RADIUS);
    let (rect, mut response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let before = *light_deg;
    if let Some(at) = response.interact_pointer_pos() {
        response.request_focus();
        *light_deg = light_at((at - rect.center()) / RADIUS, light_deg[0]);
    }
    if response.has_focus() {
        keep_arrows(ui.ctx(), response.id, true, true);
        let pressed = |key| ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, key));
        let [left, right, up, down] =
            [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown].map(pressed);
        let step = |more: bool, less: bool| STEP_DEG * (f32::from(more) - f32::from(less));
        let [azimuth_deg, altitude_deg] = *light_deg;
        *light_deg = [
            (azimuth_deg + step(right, left)).rem_euclid(360.0),
            (altitude_deg + step(up, down)).clamp(LOWEST_DEG, 90.0),
        ];
    }
    if *light_deg != before {
        response.mark_changed();
    }
    paint_light(ui, &response, *light_deg);
    let [azimuth_deg, altitude_deg] = *light_deg;
    let name = format!("Light from {azimuth_deg:.0} degrees, {altitude_deg:.0} degrees high");
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, ui.is_enabled(), &name));
    let key = Action::TurnLight.key();
    response.on_hover_text(format!("{name}. Drag the light, or turn it (arrow keys, {key})."))
}

/// Returns the direction of the light at a place of the disc, azimuth and height in degrees:
/// overhead in the middle, at the horizon on the rim. Very close to the middle the azimuth does not
/// change.
fn light_at(place: Vec2, azimuth_deg: f32) -> [f32; 2] {
    let altitude_deg = 90.0 * (1.0 - place.length()).clamp(0.0, 1.0);
    let turned_deg = if place.length() > 0.05 {
        place.x.atan2(-place.y).to_degrees().rem_euclid(360.0)
    } else {
        azimuth_deg
    };
    [turned_deg.round(), altitude_deg.max(LOWEST_DEG).round()]
}

fn paint_light(ui: &Ui, response: &Response, [azimuth_deg, altitude_deg]: [f32; 2]) {
    let visuals = ui.style().interact(response);
    let (centre, painter) = (response.rect.center(), ui.painter());
    painter.circle(centre, RADIUS, visuals.bg_fill, visuals.fg_stroke);
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    let at = centre + vec2(sin, -cos) * RADIUS * (1.0 - altitude_deg / 90.0);
    let colour = visuals.fg_stroke.color;
    painter.line_segment([centre, at], Stroke::new(1.0, colour));
    painter.circle_filled(at, 3.0, colour);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_light_stands_where_the_disc_shows_it() {
        assert_eq!(light_at(vec2(0.0, -0.5), 0.0), [0.0, 45.0]);
        assert_eq!(light_at(vec2(0.5, 0.0), 0.0), [90.0, 45.0]);
        assert_eq!(light_at(vec2(-3.0, 3.0), 0.0), [225.0, 5.0]);
        assert_eq!(light_at(vec2(0.0, 0.0), 315.0), [315.0, 90.0]);
    }
}
