//! Draws isobaths: lines of equal depth with their depths written along them.
//!
//! Input: the isobaths of the survey. Output: lines and numbers on the map.

mod labels;

pub(crate) use labels::{IsobathLabels, octave};

use super::MapScene;
use super::lines::{LinePicture, MapLine, MapPen};
use crate::app::{DrawnIsobaths, ThemeChoice};
use crate::ui::render::{Specks, Uploader, Vertex};
use crate::ui::views::legend;
use bathyscope_bottom::bathymetry::isobaths::{DepthExtent, INDEX, IsobathSettings, NoIsobaths};
use bathyscope_bottom::presentation::units::{LengthUnit, Units};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::Isobaths;
use eframe::egui_wgpu::RenderState;
use egui::epaint::TextShape;
use egui::{Align2, Color32, Painter, Shape, Stroke, Vec2, vec2};
use std::sync::Arc;

/// Largest number of segments drawn in a frame, of the thin and of the thick lines: beyond it, a
/// coarser level is used.
const MOST_SEGMENTS: [u32; 2] = [5_000, 2_500];

/// Returns the pen of an isobath. Light lines in dark casings are visible on every colour of depth;
/// in the light theme lines are dark and casings light.
fn pen(theme: ThemeChoice, is_index: bool) -> MapPen {
    let (line, casing) = match theme {
        ThemeChoice::Dark => (Color32::from_gray(244), Color32::from_black_alpha(120)),
        ThemeChoice::Light => (Color32::from_gray(24), Color32::from_white_alpha(110)),
    };
    let width = if is_index { 1.7 } else { 0.9 };
    let strength = if is_index { 0.95 } else { 0.7 };
    MapPen {
        widths: [width + 1.3, width],
        colours: [Some(casing), Some(line.gamma_multiply(strength))],
        most_segments: MOST_SEGMENTS[usize::from(is_index)],
    }
}

/// Draws the lines, and their depths if there are labels for the shown zoom and layer.
pub(super) fn show(
    picture: &mut LinePicture<IsobathLayer>,
    painter: &Painter,
    state: Option<&RenderState>,
    scene: &MapScene<'_>,
    layer: &Arc<IsobathLayer>,
    labels: Option<&IsobathLabels>,
) {
    let Some(state) = state else {
        // The notice that there is no GPU is shown by the track.
        return;
    };
    let theme = scene.options.theme;
    let lines = [(&layer.thin, pen(theme, false)), (&layer.thick, pen(theme, true))];
    let view = (scene.rect, &scene.transform);
    picture.show(painter, state, view, layer, lines);
    let of_these = |labels: &&IsobathLabels| Arc::ptr_eq(&labels.layer, layer);
    // A small tile keeps the lines and leaves out the words.
    if let Some(labels) = labels.filter(of_these)
        && legend::has_room(scene.rect)
    {
        write(painter, scene, layer, labels);
    }
}

fn write(painter: &Painter, scene: &MapScene<'_>, layer: &IsobathLayer, labels: &IsobathLabels) {
    let frame = scene.rect.expand(30.0);
    let plate = crate::ui::theme::plate_colour(scene.options).gamma_multiply(0.8);
    let ink = crate::ui::theme::canvas_text_colour(scene.options);
    for label in &labels.labels {
        let [east_m, north_m] = label.place;
        let place = [layer.origin_m[0] + f64::from(east_m), layer.origin_m[1] + f64::from(north_m)];
        let at = scene.at(place);
        if !frame.contains(at) {
            continue;
        }
        let Some(line) = layer.lines.get(label.line) else {
            continue;
        };
        let galley = painter.layout_no_wrap(line.text.clone(), legend::font(), ink);
        let half = 0.5 * galley.size() + vec2(2.0, -0.5);
        let along = Vec2::angled(label.angle_rad);
        let beside = along.rot90();
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| at + x * half.x * along + y * half.y * beside);
        painter.add(Shape::convex_polygon(corners.to_vec(), plate, Stroke::NONE));
        let corner = Align2::CENTER_CENTER.anchor_size(at, galley.size()).min;
        let text = TextShape::new(corner, galley, ink);
        painter.add(text.with_angle_and_anchor(label.angle_rad, Align2::CENTER_CENTER));
    }
}

/// Number of vertices above which rings too small to be visible are left out of the coarser levels.
const MANY: usize = 20_000;

/// Isobaths used when there are none to draw.
static NONE: Isobaths =
    Isobaths { levels_m: Vec::new(), lines: Vec::new(), shoal_safe: false, clip: None };

/// A line of equal depth in the plane of the survey.
pub(crate) struct GroundLine {
    /// Depth of the line as text.
    pub text: String,
    /// True if the line is thick and labelled first.
    pub is_index: bool,
    /// Points east and north of the layer's origin, metres.
    pub points: Vec<[f32; 2]>,
}

/// The isobaths of a depth map.
pub(crate) struct IsobathLayer {
    /// Origin of the lines, metres.
    pub origin_m: [f64; 2],
    /// The lines with their depths.
    pub lines: Vec<GroundLine>,
    /// Note for the legend.
    pub note: String,
    thin: MapLine,
    thick: MapLine,
}

impl IsobathLayer {
    /// Prepares the isobaths for drawing; `None` when cancelled.
    pub(crate) fn new(
        drawn: &DrawnIsobaths,
        units: Units,
        uploader: Option<&Uploader>,
        progress: &Progress,
    ) -> Option<Self> {
        let grid = &drawn.depth_map.surface.grid;
        let settings = &drawn.settings;
        let middle = grid.centre(grid.rows / 2, grid.columns / 2);
        let origin_m = drawn.depth_map.to_survey(middle);
        let isobaths = drawn.isobaths.as_deref().unwrap_or(&NONE);
        let levels_m = &isobaths.levels_m;
        let note = match &drawn.isobaths {
            Ok(made) => {
                let clip_note = made.clip.as_ref().map_or("", |_| "\nwithin their area");
                note(settings, levels_m, drawn.depth_map.extent(), units) + clip_note
            }
            Err(NoIsobaths::TooMany { .. }) => "no isobaths:\ninterval too small".to_owned(),
            Err(NoIsobaths::AreaNotRead { .. }) => "no isobaths:\narea not read".to_owned(),
            Err(NoIsobaths::AreaElsewhere { .. }) => "no isobaths:\narea elsewhere".to_owned(),
        };
        let is_listed = !settings.depths_m.is_empty();
        let step_m = (!is_listed).then(|| settings.interval_m(drawn.depth_map.extent()));
        let decimals = decimals(levels_m, units);
        let from_origin =
            |place: &[f64; 2]| [0, 1].map(|axis| (place[axis] - origin_m[axis]) as f32);
        let lines: Vec<GroundLine> = (isobaths.lines.iter().zip(&drawn.on_ground))
            .map(|(line, places)| GroundLine {
                text: format!("{:.decimals$}", units.in_unit(line.depth_m) + 0.0),
                is_index: step_m
                    .is_some_and(|step_m| IsobathSettings::is_index(line.depth_m, step_m)),
                points: places.iter().map(from_origin).collect(),
            })
            .collect();
        progress.check().ok()?;
        let [thin, thick] = [false, true].map(|is_index| {
            let vertices = vertices(&lines, is_index);
            let specks = if vertices.len() > MANY { Specks::Dropped } else { Specks::Kept };
            MapLine::new(origin_m, vertices, specks, uploader)
        });
        Some(Self { origin_m, lines, note, thin, thick })
    }
}

fn vertices(lines: &[GroundLine], is_index: bool) -> Vec<Vertex> {
    let chosen = lines.iter().filter(|line| line.is_index == is_index);
    chosen
        .flat_map(|line| {
            let places = line.points.iter().map(|place| Vertex { place: *place, colour: [255; 4] });
            std::iter::once(Vertex::BREAK).chain(places)
        })
        .collect()
}

/// Returns the number of decimals that distinguish the levels: at most three, and two if levels
/// that are round in metres are not shown in metres.
fn decimals(levels_m: &[f64], units: Units) -> usize {
    let most = match units.length {
        LengthUnit::Metres => 3,
        LengthUnit::Feet | LengthUnit::Fathoms => 2,
    };
    let needs = |level_m: &f64| {
        let fits = |digits: &i32| {
            let scaled = units.in_unit(*level_m) * 10f64.powi(*digits);
            (scaled - scaled.round()).abs() < 1e-6
        };
        (0..most).find(fits).unwrap_or(most) as usize
    };
    levels_m.iter().map(needs).max().unwrap_or(0)
}

fn note(settings: &IsobathSettings, levels_m: &[f64], depths: DepthExtent, units: Units) -> String {
    if levels_m.is_empty() {
        return "no isobath in\nthese depths".to_owned();
    }
    if settings.depths_m.is_empty() {
        let step_m = settings.interval_m(depths);
        let decimals = decimals(&[step_m], units);
        let [thin, thick] = [1.0, INDEX].map(|times| units.in_unit(times * step_m));
        let unit = units.symbol();
        let error = if depths.allows(step_m) { "" } else { ",\nfiner than the error" };
        format!("isobaths: {thin:.decimals$} {unit},\nthick {thick:.decimals$} {unit}{error}")
    } else {
        "isobaths at\nlisted depths".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_the_decimals_that_tell_them_apart() {
        let decimals = |levels_m: &[f64]| decimals(levels_m, Units::default());
        assert_eq!(decimals(&[1.0, 2.0]), 0);
        assert_eq!(decimals(&[1.0, 1.2, 1.4]), 1);
        assert_eq!(decimals(&[0.25, 0.5]), 2);
        assert_eq!(decimals(&[1.0 / 3.0]), 3);
    }

    #[test]
    fn the_legend_tells_the_interval() {
        let every = |interval_m| IsobathSettings {
            interval_m: Some(interval_m),
            ..IsobathSettings::default()
        };
        let mut settings = every(0.2);
        let levels_m = [2.0, 2.2, 2.4];
        let metres = Units::default();
        let depths = DepthExtent { range_m: [2.0, 2.5], error_m: 0.1 };
        assert!(note(&settings, &levels_m, depths, metres).ends_with("0.2 m,\nthick 1.0 m"));
        let unsure = DepthExtent { error_m: 0.11, ..depths };
        assert!(note(&settings, &levels_m, unsure, metres).ends_with("finer than the error"));
        let feet = Units { length: LengthUnit::Feet, ..metres };
        let levels_ft = [3.048, 4.572];
        assert!(note(&every(1.524), &levels_ft, depths, feet).contains("5 ft,\nthick 25 ft"));
        settings.depths_m = levels_m.to_vec();
        assert!(note(&settings, &levels_m, depths, metres).contains("listed"));
    }
}
