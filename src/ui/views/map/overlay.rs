//! Draws scale bar, north arrow, legends with their notes, and marks over the layers of the map,
//! and the graticule: lines at round degrees, or metres of the UTM zone, named along the lower and
//! the left edge.

use super::{MapScene, dots, grid_tiles};
use crate::app::{App, LogPlace, MapLayer};
use crate::ui::views::legend::{self, LegendScale};
use crate::ui::{place, theme};
use bathyscope_bottom::presentation::graticule::{LineFamily, Net, NetBounds};
use bathyscope_bottom::presentation::text::count;
use bathyscope_log::support::geo::{LonLat, UtmZone};
use egui::{Align2, Color32, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};

/// Height at the top right that is reserved for the north arrow, points.
const BELOW_ARROW: f32 = 66.0;

/// Draws scale bar, north arrow and legend; returns the areas that they cover.
pub(super) fn furniture(painter: &Painter, scene: &MapScene<'_>) -> Vec<Rect> {
    north_arrow(painter, scene);
    let mut covered = vec![scale_bar(painter, scene)];
    let mut corner = scene.rect.right_bottom() - vec2(8.0, 18.0);
    let scales = scales(painter, scene, corner);
    if let Some(last) = scales.last() {
        corner.y = last.top() - 3.0;
    }
    covered.extend(scales);
    covered.extend(log_names(painter, scene));
    let room = corner.y - scene.rect.top() - BELOW_ARROW;
    if let Some(text) = fitting_notes(painter, scene, room) {
        let anchor = Align2::RIGHT_BOTTOM;
        covered.push(legend::words(painter, scene.options, corner, anchor, &text));
    }
    covered
}

/// Largest number of logs in the legend.
const MOST_LOGS: usize = 12;

/// Draws the names of the logs beside their colours, where the tracks are coloured by log; returns
/// the covered areas.
fn log_names(painter: &Painter, scene: &MapScene<'_>) -> Vec<Rect> {
    if !scene.shows(MapLayer::Track) {
        return Vec::new();
    }
    let mut at = scene.rect.left_bottom() + vec2(22.0, -54.0);
    let logs = scene.track.logs.iter().take(MOST_LOGS).rev();
    let name = |(name, colour): &(String, [u8; 3])| {
        let plate = legend::words(painter, scene.options, at, Align2::LEFT_BOTTOM, name);
        let dot = plate.left_center() - vec2(8.0, 0.0);
        painter.circle_filled(dot, 4.0, theme::rgb(*colour));
        at.y = plate.top() - 1.0;
        plate
    };
    logs.map(name).collect()
}

/// Draws the scales of depths and of residuals, side by side from the right; returns the covered
/// areas.
fn scales(painter: &Painter, scene: &MapScene<'_>, mut corner: Pos2) -> Vec<Rect> {
    // Leaves room for the north arrow above, and for the title and the edge of the plate.
    let below_arrow = scene.rect.height() - BELOW_ARROW - 58.0;
    let height = (scene.rect.height() * 0.4).clamp(50.0, 160.0);
    let height = height.min(below_arrow).max(24.0);
    let coloured = scene.shows(MapLayer::DepthMap) || scene.shows(MapLayer::Track);
    let reference = scene.products.reduction().reference();
    let depths = scene.range_m().filter(|_| coloured);
    let depths =
        depths.map(|range_m| LegendScale::of_depth(range_m, reference, scene.options.units));
    let residuals = scene.residuals.as_deref();
    let residuals =
        residuals.map(|layer| LegendScale::of_residuals(layer.reach_m, scene.options.units));
    let mut covered = Vec::new();
    for scale in depths.into_iter().chain(residuals) {
        let plate = scale.show(painter, scene.options, corner, height);
        corner.x = plate.left() - 3.0;
        covered.push(plate);
    }
    covered
}

/// Draws the text about the work in progress for the map.
pub(super) fn under_way(painter: &Painter, scene: &MapScene<'_>, text: &str) {
    let at = scene.rect.center_bottom() - vec2(0.0, 20.0);
    legend::words(painter, scene.options, at, Align2::CENTER_BOTTOM, text);
}

fn north_arrow(painter: &Painter, scene: &MapScene<'_>) {
    let tip = scene.rect.right_top() + vec2(-20.0, 40.0);
    let colour = scene.text_colour();
    let left = vec![tip, tip + vec2(-6.0, 20.0), tip + vec2(0.0, 15.0)];
    let right = vec![tip, tip + vec2(6.0, 20.0), tip + vec2(0.0, 15.0)];
    painter.add(Shape::convex_polygon(left, colour, Stroke::NONE));
    painter.add(Shape::closed_line(right, Stroke::new(1.0, colour)));
    let at = tip - vec2(0.0, 2.0);
    painter.text(at, Align2::CENTER_BOTTOM, "N", legend::font(), colour);
}

fn scale_bar(painter: &Painter, scene: &MapScene<'_>) -> Rect {
    let least_m = 48.0 * scene.transform.metres_per_point;
    let (length_m, text) = scene.options.units.scale_bar(least_m);
    let length = (length_m / scene.transform.metres_per_point) as f32;
    let start = scene.rect.left_bottom() + vec2(40.0, -26.0);
    let end = start + vec2(length, 0.0);
    let plate = Rect::from_two_pos(start + vec2(-8.0, 5.0), end + vec2(8.0, -18.0));
    painter.rect_filled(plate, 3.0, theme::plate_colour(scene.options));
    let stroke = Stroke::new(1.5, scene.text_colour());
    painter.line_segment([start, end], stroke);
    for at in [start, end] {
        painter.line_segment([at, at - vec2(0.0, 5.0)], stroke);
    }
    let middle = start + vec2(0.5 * length, -4.0);
    let (above, font) = (Align2::CENTER_BOTTOM, legend::font());
    painter.text(middle, above, text, font, stroke.color);
    plate
}

/// Marks the selected place by a ring with the boat's heading, and the hovered place by a
/// cross-hair; a line joins an across-track place to its boat.
pub(super) fn marks(painter: &Painter, scene: &MapScene<'_>, app: &App) {
    if let Some(mark) = app.view.selection {
        let stroke = Stroke::new(2.0, theme::SELECTION_COLOUR);
        if let Some(at) = mark_at(painter, scene, app, mark, stroke) {
            painter.circle_stroke(at, 7.0, stroke);
        }
        heading_tick(painter, scene, mark.ping, stroke);
    }
    if let Some(mark) = app.view.hover {
        let stroke = Stroke::new(1.0, theme::HOVER_COLOUR.gamma_multiply(0.8));
        if let Some(at) = mark_at(painter, scene, app, mark, stroke) {
            painter.vline(at.x, scene.rect.y_range(), stroke);
            painter.hline(scene.rect.x_range(), at.y, stroke);
            painter.circle_stroke(at, 4.0, stroke);
        }
    }
}

/// Draws the line from the boat to a mark, and returns the place of the mark on the screen.
fn mark_at(
    painter: &Painter,
    scene: &MapScene<'_>,
    app: &App,
    mark: LogPlace,
    stroke: Stroke,
) -> Option<Pos2> {
    let at = scene.at(place::east_north(app, mark)?);
    if let Some(boat) = place::east_north(app, LogPlace::ping(mark.ping)) {
        painter.line_segment([scene.at(boat), at], stroke);
    }
    Some(at)
}

fn heading_tick(painter: &Painter, scene: &MapScene<'_>, ping: usize, stroke: Stroke) {
    let boat = scene.products.navigation.pings.get(ping);
    if let Some(boat) = boat.filter(|boat| (boat.heading_rad + boat.east_m).is_finite()) {
        let at = scene.at([boat.east_m, boat.north_m]);
        let (sin, cos) = boat.heading_rad.sin_cos();
        let ahead = vec2(sin as f32, -cos as f32);
        painter.line_segment([at + 7.0 * ahead, at + 18.0 * ahead], stroke);
    }
}

/// Returns the lines that fit into a height, the most important ones first; `None` if none fits.
fn fitting_notes(painter: &Painter, scene: &MapScene<'_>, height: f32) -> Option<String> {
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
        notes.push(dots::point_note(scene.options, scene.has_swath));
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

/// Number of points along a line: enough to draw a curved meridian across the whole view.
const BENDS: usize = 9;
/// Largest diagonal of the view for which the graticule is drawn, metres: the plane of the survey
/// shows no more of the Earth.
const FARTHEST_M: f64 = 2e6;
/// Least distance between parallels, and room around the name of a meridian, points.
const BETWEEN: f32 = 64.0;
const MARGIN: f32 = 20.0;

/// Draws the lines and their names.
pub(super) fn graticule(painter: &Painter, scene: &MapScene<'_>) {
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
            let bent: Vec<Pos2> = places.map(|at| scene.at_position(at)).collect();
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
    let words = painter.layout_no_wrap(guess, legend::font(), Color32::WHITE);
    let room = (words.size().x + MARGIN).max(BETWEEN);
    [across * f64::from(room), up * f64::from(BETWEEN)]
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
