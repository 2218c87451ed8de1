//! Draws the measuring figures on the map.

use crate::app::App;
use crate::ui::theme;
use crate::ui::views::map::scene::MapScene;
use crate::ui::views::{legend, measured};
use bathyscope_bottom::bathymetry::TransectStation;
use bathyscope_products::project::{Measurement, MeasurementKind};
use egui::{Align2, Painter, Pos2, Shape, Stroke, vec2};

/// Line, corners, and the numbers beside the last one.
pub(super) fn paint(painter: &Painter, scene: &MapScene<'_>, app: &App, figure: &Measurement) {
    let navigation = &scene.products.navigation;
    let place = |at: &bathyscope_log::support::geo::LonLat| {
        scene.at(navigation.to_plane(&scene.survey.track, *at))
    };
    let corners: Vec<Pos2> = figure.corners.iter().map(place).collect();
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
        let (shift, anchor) = if at.x < scene.rect.center().x {
            (vec2(10.0, -10.0), Align2::LEFT_BOTTOM)
        } else {
            (vec2(-10.0, -10.0), Align2::RIGHT_BOTTOM)
        };
        legend::words(painter, scene.options, *at + shift, anchor, &words);
    }
}

/// The cross that the arrow keys move.
pub(super) fn cross(painter: &Painter, scene: &MapScene<'_>, place: [f64; 2]) {
    measured::cross(painter, scene.at(place));
}

/// The place that the pointer is at in the plot.
pub(super) fn station(painter: &Painter, scene: &MapScene<'_>, station: &TransectStation) {
    let at = scene.at(station.place);
    let around = Stroke::new(4.0, theme::canvas_colour(scene.options));
    painter.circle_stroke(at, 6.0, around);
    painter.circle_stroke(at, 6.0, Stroke::new(2.0, theme::HOVER_COLOUR));
}
