//! Draws antenna and transducer at the selected ping, while they are apart.

use super::scene::MapScene;
use crate::app::App;
use crate::ui::theme;
use crate::ui::views::legend;
use egui::{Align2, Painter, Pos2, Shape, Stroke, vec2};

/// Half of the antenna's triangle, points.
const HALF: f32 = 5.0;
/// Least distance between them at which each is labelled, points.
const NAMED: f32 = 34.0;

/// Places of antenna and transducer at the selected ping, metres east and north; `None` while they
/// are at one place.
fn places(scene: &MapScene<'_>, app: &App) -> Option<[[f64; 2]; 2]> {
    let ping = app.view.selection?.ping;
    let navigation = &scene.products.navigation;
    let antenna = *navigation.antenna.get(ping)?;
    let transducer = navigation.pings.get(ping)?;
    let places = [antenna, [transducer.east_m, transducer.north_m]];
    let mut metres = places.as_flattened().iter();
    metres.all(|metres| metres.is_finite()).then_some(places)
}

/// Draws the antenna as a triangle and the transducer as a disc, joined by a line.
pub(super) fn paint(painter: &Painter, scene: &MapScene<'_>, app: &App) {
    let Some([antenna, transducer]) =
        places(scene, app).map(|places| places.map(|at| scene.at(at)))
    else {
        return;
    };
    let colour = theme::SELECTION_COLOUR;
    painter.line_segment([antenna, transducer], Stroke::new(1.5, colour));
    let corners = [vec2(0.0, -HALF), vec2(HALF, HALF), vec2(-HALF, HALF)];
    let corners = corners.map(|corner| antenna + corner).to_vec();
    let fill = theme::canvas_colour(scene.options);
    let edge = Stroke::new(1.5, colour);
    painter.add(Shape::convex_polygon(corners, fill, edge));
    painter.circle_filled(transducer, 3.0, colour);
    if antenna.distance(transducer) < NAMED {
        return;
    }
    let name = |at: Pos2, other: Pos2, text: &str| {
        let (anchor, aside) = if at.x < other.x {
            (Align2::RIGHT_CENTER, vec2(-12.0, 0.0))
        } else {
            (Align2::LEFT_CENTER, vec2(12.0, 0.0))
        };
        legend::words(painter, scene.options, at + aside, anchor, text);
    };
    name(antenna, transducer, "antenna");
    name(transducer, antenna, "transducer");
}

/// Text for screen readers, after the name of the map.
pub(super) fn name(app: &App) -> String {
    let products = app.log.products.as_ref();
    let apart = products
        .zip(app.view.selection)
        .is_some_and(|(products, mark)| products.navigation.antenna.get(mark.ping).is_some());
    if apart { ", antenna and transducer of the selected ping".to_owned() } else { String::new() }
}
