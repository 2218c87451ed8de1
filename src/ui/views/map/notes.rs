//! Writes notes that complete the colour scale: a few short lines for each layer that is drawn.

use super::scene::MapScene;
use super::{grid_tiles, points};
use crate::app::MapLayer;
use crate::ui::views::legend;
use bathyscope_bottom::presentation::text::count;
use egui::Painter;

/// Returns the lines that fit into a height, the most important ones first; `None` if none fits.
pub(super) fn fitting(painter: &Painter, scene: &MapScene<'_>, height: f32) -> Option<String> {
    let mut notes = notes(scene);
    while !notes.is_empty() {
        let text = notes.join("\n");
        if legend::plate_size(painter, &text).y <= height {
            return Some(text);
        }
        notes.pop();
    }
    None
}

fn notes(scene: &MapScene<'_>) -> Vec<String> {
    let explained = legend::has_room(scene.rect);
    let shows = |layer| scene.shows(layer) && explained;
    let mut notes: Vec<String> = grey_track(scene).map(str::to_owned).into_iter().collect();
    if let Some(pings) = scene.made_of.filter(|_| {
        let made = [MapLayer::DepthMap, MapLayer::HillShade, MapLayer::Isobaths, MapLayer::Mosaic];
        made.into_iter().any(|layer| scene.shows(layer))
    }) {
        notes.push(format!("layers: first\n{} pings", count(pings)));
    }
    if scene.has_excluded && scene.shows(MapLayer::Track) {
        notes.push("fine dashes:\nexcluded".to_owned());
    }
    if let Some(depth_map) = scene.depth_map.filter(|_| shows(MapLayer::DepthMap)) {
        notes.push(match depth_map {
            Some(made) => {
                let decimals = usize::from(made.gap_m < 10.0);
                let gap = scene.options.units.measure(made.gap_m, decimals);
                format!("faded: between\ndepths, to {gap}")
            }
            None => "no depth map:\nall on one line".to_owned(),
        });
    }
    if let Some(isobaths) = scene.isobaths.as_deref().filter(|_| explained) {
        notes.push(isobaths.note.clone());
    }
    if shows(MapLayer::Mosaic) {
        notes.push(grid_tiles::mosaic_note(&scene.products.settings.mosaic).to_owned());
    }
    if shows(MapLayer::Points) {
        notes.push(points::note(scene.options, scene.has_swath));
    }
    if let Some(residuals) = scene.residuals.as_deref().filter(|_| explained) {
        notes.push(residuals.note());
    }
    let made = scene.depth_map.flatten();
    if let Some(made) = made.filter(|_| shows(MapLayer::HillShade)) {
        let light = &made.light;
        notes.push(format!(
            "relief x{}, light\n{}°, {}° up",
            light.exaggeration, light.azimuth_deg, light.altitude_deg
        ));
    }
    notes
}

/// Returns the reason why some of the track is grey.
fn grey_track(scene: &MapScene<'_>) -> Option<&'static str> {
    match scene.track.range_m {
        // Where tracks are coloured by log, grey does not mean a missing depth.
        _ if !scene.shows(MapLayer::Track) || !scene.track.logs.is_empty() => None,
        None => Some("grey track:\nno depth"),
        Some(_) if scene.track.side_scan_only => Some("grey dashes: depth\nby side-scan only"),
        Some(_) if scene.has_faults => Some("grey track:\nfalse depth"),
        Some(_) => None,
    }
}
