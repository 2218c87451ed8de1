//! Draws the height from a shadow that was measured in the waterfall: its construction, and the
//! quantities that it is computed from.

use super::parts::{fact, remark};
use super::section::{Section, section};
use crate::app::Action;
use crate::ui::views::measured;
use crate::ui::{ViewContext, theme};
use bathyscope_objects::targets::ShadowHeight;
use bathyscope_products::project::MeasurementKind;
use egui::{Align2, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

/// Height of the drawing, points.
const DRAWING_HEIGHT: f32 = 110.0;

/// Draws the section; draws nothing if no height is measured.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let measuring = &context.app.map.measuring;
    let figure = measuring.figure.as_deref();
    let is_height = |kind| kind == MeasurementKind::Height;
    if !figure.is_some_and(|figure| is_height(figure.measurement.kind)) {
        return;
    }
    let found = context.app.measured_height();
    section(ui, context, Section::new("Height from shadow"), |ui, context| match found {
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
