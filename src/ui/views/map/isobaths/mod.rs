//! Isobaths: lines of equal depth with their depths written along them.

mod labels;

pub use labels::{Labels, octave};

use super::lines::{LinePicture, MapLine, Pen};
use super::overlay::Scene;
use crate::app::{DrawnIsobaths, ThemeChoice};
use crate::bottom::bathymetry::isobaths::{INDEX, IsobathSettings, NoIsobaths};
use crate::pipeline::Isobaths;
use crate::support::presentation::units::{LengthUnit, Units};
use crate::support::progress::Progress;
use crate::ui::render::{Specks, Uploader, Vertex};
use crate::ui::views::legend;
use eframe::egui_wgpu::RenderState;
use egui::epaint::TextShape;
use egui::{Align2, Color32, Painter, Shape, Stroke, Vec2, vec2};
use std::sync::Arc;

/// Most segments drawn in a frame, of the thin and of the thick lines: beyond, coarser levels are taken.
const MOST_SEGMENTS: [u32; 2] = [5_000, 2_500];

/// Vertices from which on rings too small to be seen are left out of the coarser levels.
const MANY: usize = 20_000;

/// What is drawn where the settings give no depths.
static NONE: Isobaths = Isobaths {
    levels_m: Vec::new(),
    lines: Vec::new(),
    shoal_safe: false,
    clip: None,
};

/// A line of equal depth in the plane of the survey.
pub struct GroundLine {
    /// Its depth in words.
    pub text: String,
    /// Thick, and the first to be labelled.
    pub is_index: bool,
    /// East and north of the layer's origin, metres.
    pub points: Vec<[f32; 2]>,
}

/// The isobaths of a depth map.
pub struct IsobathLayer {
    /// What the lines are relative to, metres.
    pub origin_m: [f64; 2],
    /// The lines with their depths.
    pub lines: Vec<GroundLine>,
    /// What the legend says of them.
    pub note: String,
    thin: MapLine,
    thick: MapLine,
}

impl IsobathLayer {
    /// Makes them ready to draw; `None` when cancelled.
    pub fn new(
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
                let within = made.clip.as_ref().map_or("", |_| "\nwithin their area");
                note(settings, levels_m, units) + within
            }
            Err(NoIsobaths::TooMany { .. }) => "no isobaths:\ninterval too small".to_owned(),
            Err(NoIsobaths::AreaNotRead { .. }) => "no isobaths:\narea not read".to_owned(),
            Err(NoIsobaths::AreaElsewhere { .. }) => "no isobaths:\narea elsewhere".to_owned(),
        };
        let step_m = settings.step_m(levels_m);
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
            let specks = match vertices.len() > MANY {
                true => Specks::Dropped,
                false => Specks::Kept,
            };
            MapLine::new(origin_m, vertices, specks, uploader)
        });
        Some(Self {
            origin_m,
            lines,
            note,
            thin,
            thick,
        })
    }
}

fn vertices(lines: &[GroundLine], is_index: bool) -> Vec<Vertex> {
    let chosen = lines.iter().filter(|line| line.is_index == is_index);
    chosen
        .flat_map(|line| {
            let places = line.points.iter().map(|place| Vertex {
                place: *place,
                colour: [255; 4],
            });
            std::iter::once(Vertex::BREAK).chain(places)
        })
        .collect()
}

/// Digits after the point that distinguish the levels: at most three, and two where levels that are round in metres are not shown in
/// metres.
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

fn note(settings: &IsobathSettings, levels_m: &[f64], units: Units) -> String {
    if levels_m.is_empty() {
        return "no isobath in\nthese depths".to_owned();
    }
    match settings.step_m(levels_m) {
        Some(step_m) => {
            let decimals = decimals(&[step_m], units);
            let [thin, thick] = [1.0, INDEX].map(|times| units.in_unit(times * step_m));
            let unit = units.symbol();
            format!("isobaths: {thin:.decimals$} {unit},\nthick {thick:.decimals$} {unit}")
        }
        None => "isobaths at\nlisted depths".to_owned(),
    }
}

/// Light lines in dark casings show on every colour of depth; in the light theme it is the other way round.
fn pen(theme: ThemeChoice, is_index: bool) -> Pen {
    let (line, casing) = match theme {
        ThemeChoice::Dark => (Color32::from_gray(244), Color32::from_black_alpha(120)),
        ThemeChoice::Light => (Color32::from_gray(24), Color32::from_white_alpha(110)),
    };
    let width = if is_index { 1.7 } else { 0.9 };
    let strength = if is_index { 0.95 } else { 0.7 };
    Pen {
        widths: [width + 1.3, width],
        colours: [Some(casing), Some(line.gamma_multiply(strength))],
        most_segments: MOST_SEGMENTS[usize::from(is_index)],
    }
}

/// Draws the lines, and their depths where the labels for about this zoom are there.
pub fn show(
    picture: &mut LinePicture<IsobathLayer>,
    painter: &Painter,
    state: Option<&RenderState>,
    scene: &Scene<'_>,
    layer: &Arc<IsobathLayer>,
    labels: Option<&Labels>,
) {
    let Some(state) = state else {
        // The track says that there is no GPU.
        return;
    };
    let theme = scene.options.theme;
    let lines = [
        (&layer.thin, pen(theme, false)),
        (&layer.thick, pen(theme, true)),
    ];
    picture.show(painter, state, scene, layer, lines);
    let of_these = |labels: &&Labels| Arc::ptr_eq(&labels.layer, layer);
    // A small tile keeps the lines and drops the words.
    if let Some(labels) = labels.filter(of_these)
        && legend::has_room(scene.rect)
    {
        write(painter, scene, layer, labels);
    }
}

fn write(painter: &Painter, scene: &Scene<'_>, layer: &IsobathLayer, labels: &Labels) {
    let frame = scene.rect.expand(30.0);
    let plate = crate::ui::theme::plate_colour(scene.options).gamma_multiply(0.8);
    let ink = crate::ui::theme::canvas_text_colour(scene.options);
    for label in &labels.labels {
        let [east_m, north_m] = label.place;
        let place = [
            layer.origin_m[0] + f64::from(east_m),
            layer.origin_m[1] + f64::from(north_m),
        ];
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
        let mut settings = IsobathSettings::default();
        let levels_m = [2.0, 2.2, 2.4];
        let metres = Units::default();
        assert!(note(&settings, &levels_m, metres).contains("0.2 m,\nthick 1.0 m"));
        let feet = Units {
            length: LengthUnit::Feet,
            ..metres
        };
        let levels_ft = [3.048, 4.572];
        assert!(note(&settings, &levels_ft, feet).contains("5 ft,\nthick 25 ft"));
        settings.depths_m = levels_m.to_vec();
        assert!(note(&settings, &levels_m, metres).contains("listed"));
    }
}
