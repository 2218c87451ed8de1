//! Writes all lines, areas and objects of a survey to one file.

use super::content::{FileContent, FileResult, Need};
use super::depth::contours::DrawnContours;
use super::object_files::targets;
use super::results::Results;
use crate::Error;
use crate::export::{self, MapGeometry};
use bathyscope_bottom::presentation::colours::depth_colour;
use std::path::Path;

/// Writes `survey.gpkg`, in the coordinate system of the map, with those layers of track,
/// footprint, isobaths, depth areas, soundings and objects that exist. Map programs draw the layers
/// in the order in which they are added here, the first at the bottom.
pub(super) fn write(results: &Results<'_>, path: &Path) -> FileResult {
    let map = &results.plane.map;
    let placed = MapGeometry::new(map);
    let has = |need| Ok::<bool, Error>(results.missing(need)?.is_none());
    let mut layers = Vec::new();
    if has(Need::Surface)? && has(Need::Levels)? {
        let drawn = DrawnContours::of(results)?;
        let contours = drawn.contours;
        layers.push(export::depth_area_layer(&placed, &contours.areas, drawn.ground, depth_colour));
        layers.push(export::isobath_layer(&placed, &drawn.lines(), drawn.ground.sqrt()));
    }
    if has(Need::Footprint)? {
        let ground = results.ground()?;
        layers.push(export::footprint_layer(
            &placed,
            &results.name(),
            &ground.shapes,
            ground.area_m2,
        ));
    }
    if has(Need::Surface)? && has(Need::Area)? {
        let settings = &results.products.settings.isobaths;
        layers.push(export::spot_sounding_layer(&placed, results.spot_soundings()?, settings));
    }
    layers.push(export::track_layer(&placed, results.track()));
    if results.objects()?.is_some() {
        let position = |at| placed.position(at);
        let [points, outlines] = export::object_layers(&targets(results)?, position);
        layers.extend([outlines, points]);
    }
    let time_s = results.start_unix_s().unwrap_or(0.0);
    let summary = export::geopackage(path, &map.crs, time_s, &layers)?;
    Ok(FileContent::in_system(&map.crs, summary))
}
