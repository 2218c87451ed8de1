//! Draws the graticule: lines at round degrees, or metres of the UTM zone, named along the lower
//! and the left edge.

use super::MapScene;
use crate::ui::theme;
use crate::ui::views::legend;
use bathyscope_bottom::presentation::graticule::{LineFamily, Net, NetBounds};
use bathyscope_log::support::geo::{LonLat, UtmZone};
use egui::{Align2, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};

/// Number of points along a line: enough to draw a curved meridian across the whole view.
const BENDS: usize = 9;
/// Largest diagonal of the view for which the graticule is drawn, metres: the plane of the survey
/// shows no more of the Earth.
const FARTHEST_M: f64 = 2e6;
/// Least distance between parallels, and room around the name of a meridian, points.
const BETWEEN: f32 = 64.0;
const MARGIN: f32 = 20.0;

/// Draws the lines and their names.
pub(super) fn paint(painter: &Painter, scene: &MapScene<'_>) {
    let [west, south, east, north] = scene.transform.visible(scene.rect);
    if (east - west).hypot(north - south) > FARTHEST_M {
        return;
    }
    let net = net(scene);
    let Some(bounds) = net.bounds(edge(scene)) else {
        return;
    };
    // Faint, over everything, so that positions can be read on the depth map, too.
    let stroke = Stroke::new(1.0, scene.text_colour().gamma_multiply(0.16));
    // No partly hidden names under the buttons and the scale bar.
    let (top, foot) = (scene.rect.left_top(), scene.rect.left_bottom());
    let mut covered = vec![
        Rect::from_min_size(top, vec2(200.0, 34.0)),
        Rect::from_min_max(foot - vec2(0.0, 46.0), foot + vec2(160.0, -18.0)),
    ];
    let [across, up] = distances(painter, scene, &net, bounds);
    for (family, least) in [(LineFamily::Upright, across), (LineFamily::Level, up)] {
        for line in net.lines(family, bounds, least) {
            let places = net.places(family, line.value, bounds, BENDS);
            let bent: Vec<Pos2> = places.map(|at| on_screen(scene, at)).collect();
            painter.add(Shape::line(bent.clone(), stroke));
            if let Some(at) = name_at(scene, family, &bent) {
                name(painter, scene, &mut covered, at, &line.label);
            }
        }
    }
}

fn net(scene: &MapScene<'_>) -> Net {
    let zone = UtmZone::of(scene.survey.track.frame.origin());
    let middle = scene.position(scene.rect.center());
    Net::new(scene.options.coordinates, zone, middle)
}

/// Returns positions along the edge of the view.
fn edge(scene: &MapScene<'_>) -> impl Iterator<Item = LonLat> {
    let rect = scene.rect;
    let shares = (0..BENDS).map(|bend| bend as f32 / (BENDS - 1) as f32);
    let around = shares.flat_map(move |share| {
        let x = egui::lerp(rect.x_range(), share);
        let y = egui::lerp(rect.y_range(), share);
        [pos2(x, rect.top()), pos2(x, rect.bottom()), pos2(rect.left(), y), pos2(rect.right(), y)]
    });
    around.map(|at| scene.position(at))
}

/// Returns the least distances between vertical and between horizontal lines, in degrees or metres
/// of the net.
fn distances(painter: &Painter, scene: &MapScene<'_>, net: &Net, bounds: NetBounds) -> [f64; 2] {
    let [west, south, east, north] = bounds;
    // Length on the axis that a point of the screen covers.
    let across = (east - west) / f64::from(scene.rect.width().max(1.0));
    let up = (north - south) / f64::from(scene.rect.height().max(1.0));
    // Names are longer with finer steps: a first guess gives their width.
    let guess = net.typical_label(bounds, across * f64::from(BETWEEN));
    let words = painter.layout_no_wrap(guess, legend::font(), egui::Color32::WHITE);
    let room = (words.size().x + MARGIN).max(BETWEEN);
    [across * f64::from(room), up * f64::from(BETWEEN)]
}

fn on_screen(scene: &MapScene<'_>, at: LonLat) -> Pos2 {
    let navigation = &scene.products.navigation;
    scene.at(navigation.to_plane(&scene.survey.track, at))
}

/// Returns the place of the name of a line: on the lower edge for vertical lines, on the left edge
/// for horizontal ones; in the lower left corner the lower edge has priority.
fn name_at(scene: &MapScene<'_>, family: LineFamily, line: &[Pos2]) -> Option<Pos2> {
    let rect = scene.rect;
    match family {
        LineFamily::Upright => {
            let foot = crossing(line, |at| at.y - rect.bottom())?;
            Some(pos2(foot.x + 3.0, rect.bottom() - 1.0))
        }
        LineFamily::Level => {
            let start = crossing(line, |at| at.x - rect.left())?;
            let has_room = rect.bottom() - start.y > 16.0;
            has_room.then(|| pos2(rect.left() + 3.0, start.y - 1.0))
        }
    }
}

/// Writes a name unless it would overlap another one or be cut off.
fn name(painter: &Painter, scene: &MapScene<'_>, covered: &mut Vec<Rect>, at: Pos2, text: &str) {
    let colour = scene.text_colour().gamma_multiply(0.75);
    let words = painter.layout_no_wrap(text.to_owned(), legend::font(), colour);
    let rect = Align2::LEFT_BOTTOM.anchor_size(at, words.size());
    let fits =
        scene.rect.contains_rect(rect) && !covered.iter().any(|other| other.intersects(rect));
    if fits {
        // The layers under the names may have any brightness.
        let plate = rect.expand2(vec2(2.0, 0.0));
        let ground = theme::plate_colour(scene.options).gamma_multiply(0.7);
        painter.rect_filled(plate, 2.0, ground);
        painter.galley(rect.min, words, colour);
        covered.push(rect.expand2(vec2(4.0, 0.0)));
    }
}

/// Returns the place where `side` is zero on a line, between two of its points.
fn crossing(line: &[Pos2], side: impl Fn(Pos2) -> f32) -> Option<Pos2> {
    line.windows(2).find_map(|ends| {
        let [from, to] = [side(ends[0]), side(ends[1])];
        let passes = (from <= 0.0) != (to <= 0.0);
        passes.then(|| ends[0].lerp(ends[1], from / (from - to)))
    })
}
