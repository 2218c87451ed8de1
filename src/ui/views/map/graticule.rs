//! The graticule: lines at round degrees, or metres of the UTM zone, named along the lower and the left edge.

use super::overlay::Scene;
use crate::geo::{Axis, CoordinateFormat, Graticule, LonLat, UtmZone};
use crate::ui::theme;
use crate::ui::views::{legend, ticks};
use egui::{Align2, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};

/// Points along a line: a meridian that is bent over the whole view is still drawn bent.
const BENDS: usize = 9;
/// The plane of the survey shows no more of the Earth than this, metres along the diagonal.
const FARTHEST_M: f64 = 2e6;
/// Least distance between parallels, points, and room about the name of a meridian.
const BETWEEN: f32 = 64.0;
const MARGIN: f32 = 20.0;

/// What the lines are lines of.
enum Net {
    /// Longitude and latitude; longitudes are counted on from that of the middle, so that the date line is no gap.
    Degrees { middle_deg: f64 },
    /// Easting and northing of a zone.
    Utm(UtmZone),
}

/// One family of lines with their names.
struct Lines {
    values: Vec<f64>,
    labels: Vec<String>,
}

/// Draws the lines and their names.
pub fn paint(painter: &Painter, scene: &Scene<'_>) {
    let [west, south, east, north] = scene.transform.visible(scene.rect);
    if (east - west).hypot(north - south) > FARTHEST_M {
        return;
    }
    let net = Net::of(scene);
    let Some(bounds) = net.bounds(scene) else {
        return;
    };
    let [upright, level] = net.lines(painter, scene, bounds);
    // Faint over everything: the place is read across the depth map too.
    let stroke = Stroke::new(1.0, scene.text_colour().gamma_multiply(0.16));
    // No half names under the buttons and the scale bar.
    let (top, foot) = (scene.rect.left_top(), scene.rect.left_bottom());
    let mut covered = vec![
        Rect::from_min_size(top, vec2(200.0, 34.0)),
        Rect::from_min_max(foot - vec2(0.0, 46.0), foot + vec2(160.0, -18.0)),
    ];
    for (value, label) in upright.values.iter().zip(&upright.labels) {
        let line = net.line(scene, |share| {
            [*value, between(bounds[1], bounds[3], share)]
        });
        painter.add(Shape::line(line.clone(), stroke));
        let foot = crossing(&line, |at| at.y - scene.rect.bottom());
        if let Some(foot) = foot {
            let at = pos2(foot.x + 3.0, scene.rect.bottom() - 1.0);
            name(painter, scene, &mut covered, at, label);
        }
    }
    for (value, label) in level.values.iter().zip(&level.labels) {
        let line = net.line(scene, |share| {
            [between(bounds[0], bounds[2], share), *value]
        });
        painter.add(Shape::line(line.clone(), stroke));
        let start = crossing(&line, |at| at.x - scene.rect.left());
        // The lower edge belongs to the others.
        if let Some(start) = start.filter(|start| scene.rect.bottom() - start.y > 16.0) {
            let at = pos2(scene.rect.left() + 3.0, start.y - 1.0);
            name(painter, scene, &mut covered, at, label);
        }
    }
}

fn between(from: f64, to: f64, share: f64) -> f64 {
    from + (to - from) * share
}

/// Writes a name unless another one stands there, or it would be cut off.
fn name(painter: &Painter, scene: &Scene<'_>, covered: &mut Vec<Rect>, at: Pos2, text: &str) {
    let colour = scene.text_colour().gamma_multiply(0.75);
    let words = painter.layout_no_wrap(text.to_owned(), legend::font(), colour);
    let rect = Align2::LEFT_BOTTOM.anchor_size(at, words.size());
    let fits =
        scene.rect.contains_rect(rect) && !covered.iter().any(|other| other.intersects(rect));
    if fits {
        // Layers of any brightness lie under them.
        let plate = rect.expand2(vec2(2.0, 0.0));
        painter.rect_filled(
            plate,
            2.0,
            theme::plate_colour(scene.options).gamma_multiply(0.7),
        );
        painter.galley(rect.min, words, colour);
        covered.push(rect.expand2(vec2(4.0, 0.0)));
    }
}

/// Where a line passes the zero of `side`, between two of its points.
fn crossing(line: &[Pos2], side: impl Fn(Pos2) -> f32) -> Option<Pos2> {
    line.windows(2).find_map(|ends| {
        let [from, to] = [side(ends[0]), side(ends[1])];
        let passes = (from <= 0.0) != (to <= 0.0);
        passes.then(|| ends[0].lerp(ends[1], from / (from - to)))
    })
}

impl Net {
    fn of(scene: &Scene<'_>) -> Self {
        let middle = scene.position(scene.rect.center());
        let zone = UtmZone::of(scene.survey.track.frame.origin());
        match scene.options.coordinates {
            CoordinateFormat::Utm if middle.lat_deg.abs() < 80.0 => Self::Utm(zone),
            _ => Self::Degrees {
                middle_deg: middle.lon_deg,
            },
        }
    }

    fn of_position(&self, at: LonLat) -> [f64; 2] {
        match self {
            Self::Degrees { middle_deg } => {
                let beyond = at.lon_deg - middle_deg;
                let turns = (beyond / 360.0).round();
                [middle_deg + beyond - 360.0 * turns, at.lat_deg]
            }
            Self::Utm(zone) => zone.to_metres(at),
        }
    }

    fn to_position(&self, [x, y]: [f64; 2]) -> LonLat {
        match self {
            Self::Degrees { .. } => LonLat {
                lon_deg: x,
                lat_deg: y,
            },
            Self::Utm(zone) => zone.to_lon_lat([x, y]),
        }
    }

    /// West, south, east and north of what the view shows.
    fn bounds(&self, scene: &Scene<'_>) -> Option<[f64; 4]> {
        let rect = scene.rect;
        let edge = (0..BENDS).map(|bend| bend as f32 / (BENDS - 1) as f32);
        let around = edge.flat_map(|share| {
            let x = egui::lerp(rect.x_range(), share);
            let y = egui::lerp(rect.y_range(), share);
            [
                pos2(x, rect.top()),
                pos2(x, rect.bottom()),
                pos2(rect.left(), y),
                pos2(rect.right(), y),
            ]
        });
        let nowhere = [
            f64::INFINITY,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NEG_INFINITY,
        ];
        let bounds = around
            .map(|at| self.of_position(scene.position(at)))
            .fold(nowhere, |[w, s, e, n], [x, y]| {
                [w.min(x), s.min(y), e.max(x), n.max(y)]
            });
        bounds.iter().all(|edge| edge.is_finite()).then_some(bounds)
    }

    /// The meridians and the parallels of the view, or the lines of easting and of northing.
    fn lines(&self, painter: &Painter, scene: &Scene<'_>, bounds: [f64; 4]) -> [Lines; 2] {
        let [west, south, east, north] = bounds;
        // How much of the axis a point of the screen covers.
        let across = (east - west) / f64::from(scene.rect.width().max(1.0));
        let up = (north - south) / f64::from(scene.rect.height().max(1.0));
        let wide = |label: &str| {
            let words =
                painter.layout_no_wrap(label.to_owned(), legend::font(), egui::Color32::WHITE);
            f64::from((words.size().x + MARGIN).max(BETWEEN))
        };
        match self {
            Self::Degrees { .. } => {
                let format = scene.options.coordinates;
                let lines = |graticule: Graticule, low, high, axis| {
                    let values: Vec<f64> = graticule.lines(low, high).collect();
                    let labels = values.iter().map(|value| graticule.label(*value, axis));
                    Lines {
                        labels: labels.collect(),
                        values,
                    }
                };
                // Names grow with finer steps: the first guess tells how wide they are.
                let guess = Graticule::new(format, across * f64::from(BETWEEN));
                let room = wide(&guess.label(0.5 * (west + east), Axis::Longitude));
                let upright = Graticule::new(format, across * room);
                let level = Graticule::new(format, up * f64::from(BETWEEN));
                [
                    lines(upright, west, east, Axis::Longitude),
                    lines(level, south, north, Axis::Latitude),
                ]
            }
            Self::Utm(_) => {
                let lines = |room: f64, low: f64, high: f64, letter: char| {
                    let step = ticks::round_step(room, 1.0);
                    let values: Vec<f64> = ticks::multiples(low, high, step).collect();
                    let label = |value: &f64| format!("{} {letter}", ticks::label(*value, step));
                    Lines {
                        labels: values.iter().map(label).collect(),
                        values,
                    }
                };
                let room = wide("500000.0 E");
                [
                    lines(across * room, west, east, 'E'),
                    lines(up * f64::from(BETWEEN), south, north, 'N'),
                ]
            }
        }
    }

    /// A line of the net on the screen.
    fn line(&self, scene: &Scene<'_>, at: impl Fn(f64) -> [f64; 2]) -> Vec<Pos2> {
        let shares = (0..BENDS).map(|bend| bend as f64 / (BENDS - 1) as f64);
        let navigation = &scene.products.navigation;
        let place = |share| {
            let position = self.to_position(at(share));
            scene.at(navigation.to_plane(&scene.survey.track, position))
        };
        shares.map(place).collect()
    }
}
