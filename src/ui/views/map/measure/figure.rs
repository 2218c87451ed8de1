//! What is drawn to measure, on the map and in words.

use crate::app::App;
use crate::bathymetry::Station;
use crate::geo::{course_rad, distance_m};
use crate::project::{Measurement, MeasurementKind};
use crate::ui::views::legend;
use crate::ui::views::map::overlay::Scene;
use crate::ui::{text, theme};
use egui::{Align2, Painter, Pos2, Shape, Stroke, vec2};

/// Line, corners, and the numbers beside the last one.
pub fn paint(painter: &Painter, scene: &Scene<'_>, figure: &Measurement) {
    let navigation = &scene.products.navigation;
    let place = |at: &crate::geo::LonLat| scene.at(navigation.to_plane(&scene.survey.track, *at));
    let corners: Vec<Pos2> = figure.corners.iter().map(place).collect();
    let colour = theme::measure_colour();
    let casing = theme::canvas_colour(scene.options);
    let mut line = corners.clone();
    if figure.kind == MeasurementKind::Area && corners.len() > 2 {
        line.push(corners[0]);
    }
    painter.add(Shape::line(
        line.clone(),
        Stroke::new(4.0, casing.gamma_multiply(0.7)),
    ));
    painter.add(Shape::line(line, Stroke::new(2.0, colour)));
    for at in &corners {
        painter.circle(*at, 3.5, colour, Stroke::new(1.0, casing));
    }
    if let (Some(at), Some(words)) = (corners.last(), beside(figure)) {
        let ink = theme::canvas_text_colour(scene.options);
        let (shift, anchor) = match at.x < scene.rect.center().x {
            true => (vec2(10.0, -10.0), Align2::LEFT_BOTTOM),
            false => (vec2(-10.0, -10.0), Align2::RIGHT_BOTTOM),
        };
        legend::plate(painter, scene.options, *at + shift, anchor, &words, ink);
    }
}

/// The cross that the arrow keys move.
pub fn cross(painter: &Painter, scene: &Scene<'_>, place: [f64; 2]) {
    let at = scene.at(place);
    let stroke = Stroke::new(1.5, theme::measure_colour());
    for arm in [vec2(9.0, 0.0), vec2(0.0, 9.0)] {
        painter.line_segment([at - arm, at - 0.3 * arm], stroke);
        painter.line_segment([at + 0.3 * arm, at + arm], stroke);
    }
}

/// The place that the pointer is at in the plot.
pub fn station(painter: &Painter, scene: &Scene<'_>, station: &Station) {
    let at = scene.at(station.place);
    painter.circle_stroke(
        at,
        6.0,
        Stroke::new(4.0, theme::canvas_colour(scene.options)),
    );
    painter.circle_stroke(at, 6.0, Stroke::new(2.0, theme::hover_colour()));
}

/// The whole, and the last leg with its course.
fn beside(figure: &Measurement) -> Option<String> {
    let [.., from, to] = figure.corners[..] else {
        return None;
    };
    let whole = measured(figure)?;
    if figure.corners.len() == 2 || figure.kind == MeasurementKind::Area {
        return Some(whole);
    }
    let leg = text::length(distance_m(from, to));
    let course = text::and_course(course_rad(from, to));
    Some(format!("{whole}\nleg {leg}{course}"))
}

/// What is measured; `None` while there is nothing between the corners.
fn measured(figure: &Measurement) -> Option<String> {
    let length = text::length(figure.length_m());
    match (figure.kind, &figure.corners[..]) {
        (_, [] | [_]) => None,
        (MeasurementKind::Area, [_, _]) => Some(text::length(0.5 * figure.length_m())),
        (MeasurementKind::Area, _) => Some(format!(
            "{}, around it {length}",
            text::area(figure.area_m2())
        )),
        (_, &[from, to]) => {
            let course = text::and_course(course_rad(from, to));
            Some(format!("{length}{course}"))
        }
        _ => Some(length),
    }
}

/// What is measured, or else what the tool waits for.
pub fn words(app: &App, shown: Option<&Measurement>) -> Option<String> {
    let measured = shown.and_then(|figure| Some((figure.kind, measured(figure)?)));
    if let Some((kind, measured)) = measured {
        return Some(match kind {
            MeasurementKind::Distance => format!("Distance {measured}"),
            MeasurementKind::Area => format!("Area {measured}"),
            MeasurementKind::Profile => format!("Depth profile over {measured}"),
        });
    }
    app.measuring.tool.map(|kind| {
        let what = match kind {
            MeasurementKind::Distance => "Measure distance: click the corners of a line.",
            MeasurementKind::Area => "Measure area: click its corners.",
            MeasurementKind::Profile => "Depth profile: click the corners of a line.",
        };
        what.to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::LonLat;

    #[test]
    fn a_corner_on_the_last_one_has_no_course() {
        let at = |lon_deg: f64| LonLat {
            lon_deg,
            lat_deg: 36.9,
        };
        let figure = |corners: &[LonLat]| Measurement {
            kind: MeasurementKind::Distance,
            corners: corners.to_vec(),
            note: String::new(),
        };
        let (here, there) = (at(-111.5), at(-111.4999));
        assert_eq!(beside(&figure(&[here, here])).as_deref(), Some("0.00 m"));
        let words = beside(&figure(&[here, there, there])).expect("words");
        assert!(words.ends_with("\nleg 0.00 m"), "{words}");
        let words = beside(&figure(&[there, here, there])).expect("words");
        assert!(words.ends_with(", 90°"), "{words}");
    }
}
