//! Shows the selected ping with all its facts, which can be copied, and the height from a shadow
//! that was measured in the waterfall: its construction, and the quantities that it is computed
//! from.

use super::parts::{fact, remark};
use super::section::{Section, section};
use crate::app::{Action, App, Command, LogPlace};
use crate::ui::views::measured;
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_bottom::cloud::{PointClass, PointSource};
use bathyscope_log::survey::{Side, arm_in_words};
use bathyscope_objects::targets::ShadowHeight;
use bathyscope_products::project::MeasurementKind;
use egui::{Align2, FontId, Pos2, Rect, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};

/// Titles of the sections.
pub(super) const TITLE: &str = "Selection";
pub(super) const SHADOW_TITLE: &str = "Height from shadow";

/// Draws the section of the selected ping; draws nothing if none is selected.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if let Some(mark) = context.app.view.selection {
        section(ui, context, &Section::new(TITLE), |ui, context| selected(ui, context, mark));
    }
}

fn selected(ui: &mut Ui, context: &mut ViewContext<'_>, mark: LogPlace) {
    let units = context.units();
    let Some(survey) = context.app.logs.shown.survey.clone() else {
        return;
    };
    let Some(ping) = survey.side_scan.get(mark.ping) else {
        return;
    };
    ui.horizontal(|ui| {
        let title = RichText::new(format!("Ping {}", mark.ping));
        ui.label(title.heading().strong());
        ui.label(text::clock(survey.start_unix_s, ping.time_s));
    });
    if let Some(at) = place::lon_lat(context.app, mark) {
        ui.label(RichText::new(place::written(context.app, at)).monospace());
    }
    let hint = "Corrected depth under the boat: the sounding, or the first return where the recorder lost the bottom.";
    fact(ui, "Depth", hint, place::depth(context.app, mark.ping));
    if let Some(range) = place::range_m(context.app, mark) {
        let side = mark.side.map_or("", Side::name);
        let hint = "Calibrated slant range of the selected place.";
        let value = format!("{} {side}", units.measure(range, 2));
        fact(ui, "Range here", hint, value);
    }
    if let Some(stretch) = context.app.logs.excluded_at(context.app.logs.shown.id, mark.ping) {
        let hint = "Why the ping is excluded: no point, depth, echo or box comes from it.";
        fact(ui, "Excluded", hint, stretch.reason.name());
    }
    for side in Side::BOTH {
        first_return(ui, context, mark.ping, side);
    }
    heading(ui, context, mark.ping);
    mounting(ui, context, mark.ping);
    point(ui, context, mark);
    ui.add_space(2.0);
    let show = ui.button("Show in all views");
    if show.on_hover_text("Brings this place into the waterfall, the map and the cloud.").clicked()
    {
        context.push(Command::Reveal(mark));
    }
}

fn first_return(ui: &mut Ui, context: &ViewContext<'_>, ping: usize, side: Side) {
    let returns = context.app.logs.shown.returns();
    let pick = returns.and_then(|returns| returns.side(side).get(ping).copied());
    let pick = pick.filter(|pick| pick.is_some());
    let value = match pick {
        None => "no return".to_owned(),
        Some(pick) => {
            let mark =
                LogPlace { side: Some(side), sample: Some(pick.sample), ..LogPlace::ping(ping) };
            let range = place::range_m(context.app, mark).unwrap_or(f64::NAN);
            let above_bottom = if pick.above_bottom { " · above bottom" } else { "" };
            let range = context.units().measure(range, 2);
            let confidence = pick.confidence;
            format!("{range} · conf. {confidence:.2}{above_bottom}")
        }
    };
    let name = match side {
        Side::Port => "Port",
        Side::Starboard => "Starboard",
    };
    let colour = theme::side_colour(context.options(), side);
    let hint = "First return on this side: calibrated slant range and confidence from 0 to 1.";
    fact(ui, name, hint, RichText::new(value).color(colour));
}

fn heading(ui: &mut Ui, context: &ViewContext<'_>, ping: usize) {
    let Some(products) = &context.app.logs.shown.products else {
        return;
    };
    let Some(here) = products.navigation.pings.get(ping) else {
        return;
    };
    let value = place::heading(context.app, ping);
    let hint = "Clockwise from north, and where it comes from.";
    fact(ui, "Heading", hint, value);
    let hint = "Over ground.";
    fact(ui, "Speed", hint, context.units().speed(here.speed_mps, 1));
}

/// Draws the position of the transducer relative to the antenna at the ping, and a mark of
/// exchanged sides, if these differ from the recording.
fn mounting(ui: &mut Ui, context: &ViewContext<'_>, ping: usize) {
    let Some(products) = &context.app.logs.shown.products else {
        return;
    };
    let mounting = &products.settings.mounting;
    let is_apart = products.navigation.antenna.get(ping).is_some();
    if let Some(arm_m) = mounting.lever_arm_m().filter(|_| is_apart) {
        let units = context.units();
        let arm = arm_in_words(arm_m, |metres| units.measure(metres, 2));
        let hint = "Position of the transducer, which positions refer to.";
        fact(ui, "Transducer", hint, format!("{arm} of the antenna"));
    }
    if mounting.swap_sides {
        let hint = "Port and starboard of the recorder are exchanged (Mounting).";
        fact(ui, "Sides", hint, "exchanged");
    }
}

fn point(ui: &mut Ui, context: &ViewContext<'_>, mark: LogPlace) {
    let Some(products) = &context.app.logs.shown.products else {
        return;
    };
    let Some(index) = mark.point else {
        return;
    };
    let Some(point) = products.cloud.points.get(index) else {
        return;
    };
    let source = match point.source {
        PointSource::DownScan => "down-scan",
        PointSource::Port => "port",
        PointSource::Starboard => "starboard",
        PointSource::Swath => "swath (StructureScan 3D)",
    };
    let level = if point.source.is_side_scan() {
        format!(" · level {}", point.level)
    } else {
        String::new()
    };
    let class = products.classes.get(index).filter(|class| !class.is_kept());
    let class = class.map_or(String::new(), |class| format!(" · {}", PointClass::name(*class)));
    let hint = "The selected point of the cloud: its source, depth and echo level (0 to 255).";
    let depth = context.units().measure(-point.z_m, 2);
    let value = format!("{source} · {depth} deep{level}{class}");
    fact(ui, "Point", hint, value);
}

/// Height of the drawing, points.
const DRAWING_HEIGHT: f32 = 110.0;

/// Returns true if a height is measured from a shadow.
pub(super) fn is_height_measured(app: &App) -> bool {
    let figure = app.map.measuring.figure.as_deref();
    figure.is_some_and(|figure| figure.measurement.kind == MeasurementKind::Height)
}

/// Draws the section; draws nothing if no height is measured.
pub(super) fn shadow(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if !is_height_measured(context.app) {
        return;
    }
    let found = context.app.measured_height();
    section(ui, context, &Section::new(SHADOW_TITLE), |ui, context| match found {
        None => remark(ui, "Drag in the waterfall to the end of the shadow."),
        Some(Err(error)) => {
            let why = context.units().sentence(&error.to_string());
            remark(ui, format!("There is no height: {why}."));
        }
        Some(Ok(shadow)) => inputs(ui, context, &shadow),
    });
}

fn inputs(ui: &mut Ui, context: &mut ViewContext<'_>, shadow: &ShadowHeight) {
    let units = context.units();
    drawing(ui, context, shadow);
    let hint = "h = H (e - t) / e. The standard deviation includes pulse length, sample size, 5 % of the altitude and 2 degrees of bottom slope.";
    fact(ui, "Height h", hint, measured::height(&Ok(*shadow), units));
    let hint = "Height of the transducer above the bottom, the median of 13 pings.";
    fact(ui, "Altitude H", hint, units.measure(shadow.altitude_m, 2));
    let hint = "Slant range of the top of the object, where the shadow begins.";
    fact(ui, "Top t", hint, units.measure(shadow.top_m, 2));
    let hint = "Slant range of the end of the shadow.";
    fact(ui, "End e", hint, units.measure(shadow.end_m, 2));
    if shadow.is_least {
        remark(ui, "The shadow ends beyond the recorded range, so the height is a minimum.");
    }
    ui.horizontal(|ui| {
        for (action, label) in [
            (Action::UseShadow, "Use for the box"),
            (Action::SaveFigure, "Save…"),
            (Action::RemoveFigure, "Remove"),
        ] {
            context.button(ui.button(label), action);
        }
    });
}

/// Draws a section across the track: transducer, bottom, object, and the ray over its top to the
/// end of its shadow.
fn drawing(ui: &mut Ui, context: &ViewContext<'_>, shadow: &ShadowHeight) {
    let (area, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), DRAWING_HEIGHT), Sense::hover());
    let height = measured::height(&Ok(*shadow), context.units());
    let spoken = format!("Construction: height {height}");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &spoken));
    let painter = ui.painter_at(area);
    let ink = ui.visuals().text_color();
    let weak = ui.visuals().weak_text_color();
    let inner = Rect::from_min_max(area.min + vec2(18.0, 12.0), area.max - vec2(14.0, 18.0));
    let [top_m, end_m] = shadow.ground_m();
    // Over shallow water heights are drawn at a larger scale than distances: the drawing explains
    // the method, not the sizes.
    let at = |ground_m: f64, height_m: f64| -> Pos2 {
        let x = (ground_m / end_m.max(1e-6)) as f32;
        let y = (height_m / shadow.altitude_m) as f32;
        pos2(inner.left() + x * inner.width(), inner.bottom() - y * inner.height())
    };
    let [boat, below, end] = [at(0.0, shadow.altitude_m), at(0.0, 0.0), at(end_m, 0.0)];
    let [top, foot] = [at(top_m, shadow.height_m()), at(top_m, 0.0)];
    painter.line_segment([below, end], Stroke::new(1.5, ink));
    let (shadow, fill) = (vec![foot, top, end], ink.gamma_multiply(0.18));
    painter.add(Shape::convex_polygon(shadow, fill, Stroke::NONE));
    let thin = Stroke::new(1.0, weak);
    painter.add(Shape::dashed_line(&[boat, below], thin, 3.0, 3.0));
    painter.line_segment([boat, end], thin);
    painter.line_segment([foot, top], Stroke::new(3.0, theme::MEASURE_COLOUR));
    painter.circle_filled(boat, 3.0, theme::accent_colour(context.theme()));
    let font = FontId::proportional(theme::SMALL);
    let left = (vec2(-4.0, 0.0), Align2::RIGHT_CENTER);
    let above = (vec2(4.0, -2.0), Align2::LEFT_BOTTOM);
    let under = (vec2(0.0, 3.0), Align2::CENTER_TOP);
    for (from, to, (aside, anchor), word) in [
        (below, boat, left, "H"),
        (foot, top, left, "h"),
        (boat, top, above, "t"),
        (top, end, above, "to e"),
        (foot, end, under, "shadow"),
    ] {
        let at = from.lerp(to, 0.5) + aside;
        painter.text(at, anchor, word, font.clone(), ink);
    }
}
