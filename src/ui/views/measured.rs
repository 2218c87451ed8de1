//! Describes a measurement in words, and provides the parts of measuring that the views share: the
//! strip with the result and the keys of the cross.

use super::legend;
use crate::app::{Action, App};
use crate::ui::{ViewContext, text, theme};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::support::geo::{course_rad, distance_m};
use bathyscope_objects::targets::{ShadowError, ShadowHeight};
use bathyscope_products::project::{Measurement, MeasurementKind};
use egui::{FocusDirection, Key, Modifiers, Painter, Pos2, Rect, RichText, Stroke, Ui, pos2, vec2};

/// Points that an arrow key moves the cross, and with Shift.
const STEPS: [f64; 2] = [10.0, 1.0];

/// Describes the whole figure, and its last leg with the course; `None` with fewer than two
/// corners.
pub(crate) fn beside(app: &App, figure: &Measurement) -> Option<String> {
    let [.., from, to] = figure.corners[..] else {
        return None;
    };
    let whole = measured(app, figure)?;
    if figure.corners.len() == 2 || figure.kind == MeasurementKind::Area {
        return Some(whole);
    }
    let leg = app.view.options.units.ground_length(distance_m(from, to));
    let course = text::and_course(course_rad(from, to));
    Some(format!("{whole}\nleg {leg}{course}"))
}

/// Describes the result of a measurement; `None` while there are too few corners.
fn measured(app: &App, figure: &Measurement) -> Option<String> {
    let units = app.view.options.units;
    let length = units.ground_length(figure.length_m());
    match (figure.kind, &figure.corners[..]) {
        (_, [] | [_]) => None,
        (MeasurementKind::Height, _) => {
            let (top, recorded_m) = figure.shadow()?;
            Some(height(&app.logs.shadow_height(top, recorded_m)?, units))
        }
        (MeasurementKind::Area, [_, _]) => Some(units.ground_length(0.5 * figure.length_m())),
        (MeasurementKind::Area, _) => {
            Some(format!("{}, around it {length}", units.area(figure.area_m2())))
        }
        (_, &[from, to]) => {
            let course = text::and_course(course_rad(from, to));
            Some(format!("{length}{course}"))
        }
        _ => Some(length),
    }
}

/// Describes the result of a measurement with its name; `None` while there are too few corners.
fn words(app: &App, figure: &Measurement) -> Option<String> {
    let measured = measured(app, figure)?;
    Some(match figure.kind {
        MeasurementKind::Distance => format!("Distance {measured}"),
        MeasurementKind::Area => format!("Area {measured}"),
        MeasurementKind::Profile => format!("Depth profile over {measured}"),
        MeasurementKind::Height => format!("Height from shadow: {measured}"),
    })
}

/// Describes a height with its standard deviation, or the reason why there is none.
pub(crate) fn height(found: &Result<ShadowHeight, ShadowError>, units: Units) -> String {
    match found {
        Ok(shadow) => {
            let least = if shadow.is_least { "at least " } else { "" };
            let height = units.measure(shadow.height_m(), 2);
            let sigma = units.measure(shadow.sigma_m(), 2);
            format!("{least}{height} ± {sigma}")
        }
        Err(error) => units.sentence(&error.to_string()),
    }
}

/// Draws the result of a measurement and the buttons for it. The banner of the tool explains how to
/// measure.
pub(crate) fn strip(ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect, shown: &Measurement) {
    let Some(text) = words(context.app, shown) else {
        return;
    };
    let is_drawing = context.app.map.measuring.is_drawing();
    let foot = rect.left_bottom();
    let right = rect.right() - 84.0;
    let bar = Rect::from_min_max(foot + vec2(6.0, -78.0), pos2(right, foot.y - 50.0));
    legend::framed(ui, context.options(), bar, |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            ui.label(RichText::new(&text).size(11.5));
            if is_drawing || context.app.view.is_picture {
                return;
            }
            let copy = ui.small_button("Copy").accessible_name("Copy the measurement");
            if copy.clicked() {
                ui.copy_text(text);
            }
            let save = Action::SaveFigure;
            context.named_button(ui.small_button("Save…"), save);
            let action = Action::RemoveFigure;
            context.named_button(ui.small_button("Remove"), action);
        });
    });
}

/// Draws the cross that the arrow keys move.
pub(crate) fn cross(painter: &Painter, at: Pos2) {
    let stroke = Stroke::new(1.5, theme::MEASURE_COLOUR);
    for arm in [vec2(9.0, 0.0), vec2(0.0, 9.0)] {
        painter.line_segment([at - arm, at - 0.3 * arm], stroke);
        painter.line_segment([at + 0.3 * arm, at + arm], stroke);
    }
}

/// Returns the points by which the arrow keys move the cross: to the right, and up.
pub(crate) fn arrows(ui: &mut Ui) -> [f64; 2] {
    if ui.text_edit_focused() || ui.memory(|memory| memory.focused().is_some()) {
        return [0.0; 2];
    }
    let keys = [
        (Key::ArrowLeft, [-1.0, 0.0]),
        (Key::ArrowRight, [1.0, 0.0]),
        (Key::ArrowUp, [0.0, 1.0]),
        (Key::ArrowDown, [0.0, -1.0]),
    ];
    let mut moved = [0.0; 2];
    for (key, way) in keys {
        // A plain arrow would match with Shift held, too.
        for (modifiers, step) in [(Modifiers::SHIFT, STEPS[1]), (Modifiers::NONE, STEPS[0])] {
            let pressed = ui.input_mut(|input| input.count_and_consume_key(modifiers, key));
            if pressed > 0 {
                // egui has handled the key too, and would move the keyboard to another control.
                ui.memory_mut(|memory| memory.move_focus(FocusDirection::None));
            }
            for axis in 0..2 {
                moved[axis] += pressed as f64 * step * way[axis];
            }
        }
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::App;
    use bathyscope_log::support::geo::LonLat;

    #[test]
    fn a_corner_on_the_last_one_has_no_course() {
        let at = |lon_deg: f64| LonLat { lon_deg, lat_deg: 36.9 };
        let figure = |corners: &[LonLat]| Measurement {
            corners: corners.to_vec(),
            ..Measurement::new(MeasurementKind::Distance)
        };
        let app = App::new(crate::app::Jobs::Inline);
        let (here, there) = (at(-111.5), at(-111.4999));
        assert_eq!(beside(&app, &figure(&[here, here])).as_deref(), Some("0.00 m"));
        let words = beside(&app, &figure(&[here, there, there])).expect("words");
        assert!(words.ends_with("\nleg 0.00 m"), "{words}");
        let words = beside(&app, &figure(&[there, here, there])).expect("words");
        assert!(words.ends_with(", 90°"), "{words}");
    }
}
