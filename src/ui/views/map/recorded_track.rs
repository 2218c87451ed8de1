//! The recorder's own track under another receiver's: thin, and joined to it where both were at the
//! same times.

use super::scene::MapScene;
use crate::app::{App, MapLayer};
use crate::ui::theme;
use egui::{Painter, Pos2, Shape, Stroke};

/// Least distance of the strokes that join the tracks, points.
const APART: f32 = 18.0;

/// Draws it while another track lies over it.
pub(super) fn paint(painter: &Painter, scene: &MapScene<'_>, app: &App) {
    if app.log.external.recorded.is_none() || !scene.shows(MapLayer::Track) {
        return;
    }
    let apart = &app.log.external.apart;
    let at = |place: &_| {
        let navigation = &scene.products.navigation;
        scene.at(navigation.to_plane(&scene.survey.track, *place))
    };
    let colour = theme::recorded_track_colour(scene.options);
    let line: Vec<_> = apart.line.iter().map(at).collect();
    painter.add(Shape::line(line, Stroke::new(1.2, colour)));
    let stroke = Stroke::new(0.8, colour);
    let mut last: Option<Pos2> = None;
    for pair in &apart.pairs {
        let ends = [at(&pair[0]), at(&pair[1])];
        if last.is_none_or(|last| last.distance(ends[1]) > APART) {
            painter.line_segment(ends, stroke);
            last = Some(ends[1]);
        }
    }
}
