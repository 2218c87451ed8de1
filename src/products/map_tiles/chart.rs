//! Draws isobaths with their depths over the colours of a tile, for plotters, which do not draw
//! lines themselves. The depths are numbers made of strokes, which can be rotated along a line.

use super::TILE_PIXELS;
use bathyscope_bottom::bathymetry::isobaths::{Isobath, IsobathSettings};

/// Pale pen under lines and numbers, so that they are visible on a dark background.
const HALO: TilePen = TilePen { width: 2.8, rgb: [255, 255, 255], opacity: 0.35 };
const LINE: TilePen = TilePen { width: 1.1, rgb: [16, 32, 64], opacity: 0.85 };
const NUMBER_HALO: TilePen = TilePen { width: 4.6, opacity: 0.85, ..HALO };
const NUMBER: TilePen = TilePen { width: 1.3, opacity: 1.0, ..LINE };
/// Length in the tile below which a line has no number, pixels.
const LEAST_LABELLED: f64 = 70.0;
/// Least distance between numbers, pixels.
const APART: f64 = 80.0;
/// Possible positions of a number along a line, as shares of its length.
const SHARES: [f64; 5] = [0.5, 0.35, 0.65, 0.2, 0.8];
/// Least distance between the ends of a line under a number, relative to its length: the line must
/// be nearly straight there.
const STRAIGHT: f64 = 0.92;

/// Width, colour and opacity of lines.
#[derive(Clone, Copy, Debug)]
struct TilePen {
    /// Width, pixels.
    width: f64,
    /// Colour: red, green, blue.
    rgb: [u8; 3],
    /// Opacity, 0 to 1.
    opacity: f64,
}

/// Draws lines, given in pixels of the tile, over its picture. Every number is placed wholly in its
/// tile, because the neighbouring tiles are drawn independently.
pub(super) fn draw_isobaths(picture: &mut [u8], lines: &[Isobath], settings: &IsobathSettings) {
    let points = || lines.iter().map(|line| line.points.as_slice());
    stroke(picture, points(), HALO);
    stroke(picture, points(), LINE);
    let numbers = numbers(lines, settings);
    let strokes = || numbers.iter().map(Vec::as_slice);
    stroke(picture, strokes(), NUMBER_HALO);
    stroke(picture, strokes(), NUMBER);
}

/// Returns the strokes of all numbers, those of the longest lines first.
fn numbers(lines: &[Isobath], settings: &IsobathSettings) -> Vec<Vec<[f64; 2]>> {
    let lengths = lines.iter().map(|line| (line.length_m(), line));
    let mut longest: Vec<(f64, &Isobath)> =
        lengths.filter(|(length, _)| *length >= LEAST_LABELLED).collect();
    longest.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut label_places, mut strokes): (Vec<[f64; 2]>, _) = (Vec::new(), Vec::new());
    for (length, line) in longest {
        let text = format!("{}", settings.in_unit(line.depth_m));
        let half = 0.5 * number_width(&text) + 2.0;
        let fits = |at: [f64; 2]| {
            let inside = at
                .iter()
                .all(|place| (half + 2.0..TILE_PIXELS as f64 - half - 2.0).contains(place));
            inside
                && label_places
                    .iter()
                    .all(|other| (other[0] - at[0]).hypot(other[1] - at[1]) > APART)
        };
        let place = SHARES.iter().find_map(|share| {
            let [before, middle, behind] =
                [-half, 0.0, half].map(|offset| at_length(&line.points, share * length + offset));
            let direction = [behind[0] - before[0], behind[1] - before[1]];
            let is_straight = direction[0].hypot(direction[1]) > STRAIGHT * 2.0 * half;
            (is_straight && fits(middle)).then_some((middle, direction))
        });
        if let Some((at, direction)) = place {
            label_places.push(at);
            strokes.extend(number_strokes(&text, at, direction));
        }
    }
    strokes
}

/// Number of pixels in a unit of the strokes below, which are six units high.
const SCALE: f64 = 1.4;
/// Distance between two figures, units.
const SPACE: f64 = 1.4;

/// The figures with their widths and their strokes, in units, y down. A nine is a six rotated by
/// half a turn.
const FIGURES: [(char, f64, &[[f64; 2]]); 11] = [
    (
        '0',
        4.0,
        &[
            [2.0, 0.0],
            [3.4, 0.5],
            [4.0, 2.0],
            [4.0, 4.0],
            [3.4, 5.5],
            [2.0, 6.0],
            [0.6, 5.5],
            [0.0, 4.0],
            [0.0, 2.0],
            [0.6, 0.5],
            [2.0, 0.0],
        ],
    ),
    ('1', 4.0, &[[0.5, 1.3], [2.2, 0.0], [2.2, 6.0]]),
    (
        '2',
        4.0,
        &[
            [0.2, 1.4],
            [0.8, 0.3],
            [2.0, 0.0],
            [3.3, 0.4],
            [3.8, 1.6],
            [3.4, 2.8],
            [0.0, 6.0],
            [4.0, 6.0],
        ],
    ),
    (
        '3',
        4.0,
        &[
            [0.2, 0.9],
            [1.0, 0.2],
            [2.0, 0.0],
            [3.3, 0.4],
            [3.7, 1.5],
            [3.2, 2.5],
            [1.8, 2.8],
            [3.3, 3.1],
            [4.0, 4.3],
            [3.4, 5.5],
            [2.0, 6.0],
            [0.8, 5.7],
            [0.0, 4.9],
        ],
    ),
    ('4', 4.0, &[[3.0, 6.0], [3.0, 0.0], [0.0, 4.2], [4.0, 4.2]]),
    (
        '5',
        4.0,
        &[
            [3.6, 0.0],
            [0.7, 0.0],
            [0.4, 2.7],
            [2.0, 2.2],
            [3.4, 2.7],
            [4.0, 4.0],
            [3.4, 5.5],
            [2.0, 6.0],
            [0.7, 5.6],
            [0.0, 4.8],
        ],
    ),
    (
        '6',
        4.0,
        &[
            [3.5, 0.6],
            [2.3, 0.0],
            [1.0, 0.6],
            [0.2, 2.2],
            [0.0, 4.0],
            [0.6, 5.5],
            [2.0, 6.0],
            [3.4, 5.5],
            [4.0, 4.1],
            [3.4, 2.8],
            [2.0, 2.4],
            [0.7, 2.9],
            [0.0, 4.0],
        ],
    ),
    ('7', 4.0, &[[0.0, 0.0], [4.0, 0.0], [1.5, 6.0]]),
    (
        '8',
        4.0,
        &[
            [2.0, 2.8],
            [0.7, 2.3],
            [0.3, 1.3],
            [0.8, 0.3],
            [2.0, 0.0],
            [3.2, 0.3],
            [3.7, 1.3],
            [3.3, 2.3],
            [2.0, 2.8],
            [0.6, 3.3],
            [0.0, 4.4],
            [0.6, 5.6],
            [2.0, 6.0],
            [3.4, 5.6],
            [4.0, 4.4],
            [3.4, 3.3],
            [2.0, 2.8],
        ],
    ),
    ('.', 0.7, &[[0.1, 5.4], [0.6, 5.4], [0.6, 5.9], [0.1, 5.9], [0.1, 5.4]]),
    ('-', 2.8, &[[0.2, 3.2], [2.6, 3.2]]),
];

/// Returns the strokes of a figure in units, y down, and its width; `None` for a letter that is no
/// part of a number.
fn figure(letter: char) -> Option<(Vec<[f64; 2]>, f64)> {
    let is_nine = letter == '9';
    let drawn = if is_nine { '6' } else { letter };
    let (_, width, points) = FIGURES.iter().find(|(name, ..)| *name == drawn)?;
    let turned = |[x, y]: [f64; 2]| {
        if is_nine { [4.0 - x, 6.0 - y] } else { [x, y] }
    };
    Some((points.iter().map(|point| turned(*point)).collect(), *width))
}

/// Returns the length of a number, pixels.
fn number_width(text: &str) -> f64 {
    let widths = text.chars().filter_map(figure).map(|(_, width)| width + SPACE);
    (widths.sum::<f64>() - SPACE).max(0.0) * SCALE
}

/// Returns the strokes of a number around its middle, rotated to the direction of a line but never
/// upside down; pixels.
fn number_strokes(text: &str, [x, y]: [f64; 2], direction: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let length = direction[0].hypot(direction[1]).max(f64::MIN_POSITIVE);
    let sign = if direction[0] < 0.0 { -1.0 } else { 1.0 };
    let [cos, sin] = direction.map(|part| sign * part / length);
    let mut left = -0.5 * number_width(text);
    let drawn = text.chars().filter_map(figure).map(|(points, width)| {
        let placed = points.iter().map(|[right, down]| {
            let (along, across) = (left + SCALE * right, SCALE * (down - 3.0));
            [x + along * cos - across * sin, y + along * sin + across * cos]
        });
        let placed = placed.collect();
        left += SCALE * (width + SPACE);
        placed
    });
    drawn.collect()
}

/// Returns the place at a distance along a line; an end of the line for distances outside of it.
fn at_length(points: &[[f64; 2]], mut along: f64) -> [f64; 2] {
    for step in points.windows(2) {
        let way = [step[1][0] - step[0][0], step[1][1] - step[0][1]];
        let length = way[0].hypot(way[1]);
        if along <= length && length > 0.0 {
            let share = (along / length).max(0.0);
            return [0, 1].map(|axis| step[0][axis] + share * way[axis]);
        }
        along -= length;
    }
    points.last().copied().unwrap_or_default()
}

/// Draws lines with smooth edges, given in pixels of the tile, over its picture (red, green, blue,
/// opacity). A pixel that several lines cover is drawn only once.
fn stroke<'a>(picture: &mut [u8], lines: impl Iterator<Item = &'a [[f64; 2]]>, pen: TilePen) {
    let mut covered = vec![0.0_f64; TILE_PIXELS * TILE_PIXELS];
    for line in lines {
        for step in line.windows(2) {
            cover(&mut covered, [step[0], step[1]], 0.5 * pen.width);
        }
    }
    for (pixel, covered) in picture.chunks_exact_mut(4).zip(covered) {
        blend(pixel, pen.rgb, pen.opacity * covered);
    }
}

/// Marks the share of each pixel that a step covers.
fn cover(covered: &mut [f64], [from, to]: [[f64; 2]; 2], half_width: f64) {
    let reach = half_width + 1.0;
    let span = |axis: usize| {
        let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
        let first = (low - reach).floor().max(0.0) as usize;
        let end = (high + reach).ceil().clamp(0.0, TILE_PIXELS as f64) as usize;
        first..end
    };
    for row in span(1) {
        for column in span(0) {
            let middle = [column as f64 + 0.5, row as f64 + 0.5];
            let share = (half_width + 0.5 - distance(middle, from, to)).clamp(0.0, 1.0);
            let pixel = &mut covered[row * TILE_PIXELS + column];
            *pixel = pixel.max(share);
        }
    }
}

fn distance(at: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length2 = way[0] * way[0] + way[1] * way[1];
    let along = (at[0] - from[0]) * way[0] + (at[1] - from[1]) * way[1];
    let share = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
    let away = [0, 1].map(|axis| at[axis] - from[axis] - share * way[axis]);
    (away[0] * away[0] + away[1] * away[1]).sqrt()
}

/// Blends a colour over a pixel, which may be transparent.
fn blend(pixel: &mut [u8], rgb: [u8; 3], opacity: f64) {
    if opacity <= 0.0 {
        return;
    }
    let below = f64::from(pixel[3]) / 255.0 * (1.0 - opacity);
    let all = opacity + below;
    for (part, colour) in pixel.iter_mut().zip(rgb) {
        let mixed = (f64::from(colour) * opacity + f64::from(*part) * below) / all;
        *part = mixed.round() as u8;
    }
    pixel[3] = (255.0 * all).round() as u8;
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_bottom::presentation::units::LengthUnit;
    use bathyscope_log::support::statistics::ends;

    fn line(points: &[[f64; 2]]) -> Isobath {
        Isobath { depth_m: 2.5, points: points.to_vec() }
    }

    #[test]
    fn a_long_line_has_a_number_that_lies_in_the_tile() {
        let straight = line(&[[0.0, 100.0], [256.0, 130.0]]);
        let metres = IsobathSettings::default();
        let drawn = numbers(std::slice::from_ref(&straight), &metres);
        assert_eq!(drawn.len(), 3);
        let feet = IsobathSettings { unit: LengthUnit::Feet, ..metres.clone() };
        // 3.048 m is ten feet: two figures without a point.
        let ten_feet = Isobath { depth_m: 3.048, ..straight.clone() };
        assert_eq!(numbers(&[ten_feet], &feet).len(), 2);
        let inside = |place: &f64| (0.0..256.0).contains(place);
        assert!(drawn.iter().flatten().flatten().all(inside));
        assert!(
            numbers(&[line(&[[100.0, 100.0], [140.0, 100.0]])], &metres).is_empty(),
            "too short"
        );
        assert!(numbers(&[line(&[[0.0, 3.0], [256.0, 3.0]])], &metres).is_empty(), "at the edge");
        let beside = line(&[[0.0, 145.0], [256.0, 175.0]]);
        // The second number is placed elsewhere along its line, farther from the first.
        assert_eq!(numbers(&[straight, beside], &metres).len(), 6);
    }

    #[test]
    fn a_line_changes_the_pixels_that_it_crosses() {
        let mut picture = [200, 200, 200, 255].repeat(TILE_PIXELS * TILE_PIXELS);
        let line = line(&[[0.0, 10.5], [60.0, 10.5]]);
        draw_isobaths(&mut picture, &[line], &IsobathSettings::default());
        let at = |column: usize, row: usize| picture[4 * (row * TILE_PIXELS + column)];
        assert!(at(30, 10) < 60 && at(30, 20) == 200 && at(80, 10) == 200);
        assert!(at(30, 11) > at(30, 10));
    }

    #[test]
    fn a_line_covers_its_pixels_once_and_shows_on_a_clear_picture() {
        let mut picture = vec![0; 4 * TILE_PIXELS * TILE_PIXELS];
        let pen = TilePen { width: 2.0, rgb: [200, 100, 0], opacity: 0.5 };
        let lines = [[[10.0, 20.0], [40.0, 20.0]], [[40.0, 20.0], [10.0, 20.0]]];
        stroke(&mut picture, lines.iter().map(<[[f64; 2]; 2]>::as_slice), pen);
        let at = |column: usize, row: usize| &picture[4 * (row * TILE_PIXELS + column)..][..4];
        assert_eq!(at(20, 19), [200, 100, 0, 128]);
        assert_eq!(at(20, 20), [200, 100, 0, 128]);
        assert_eq!(at(20, 22), [0; 4]);
        assert_eq!(at(50, 20), [0; 4]);
        let mut full = [0, 0, 0, 255];
        blend(&mut full, [200, 100, 0], 0.5);
        assert_eq!(full, [100, 50, 0, 255]);
    }

    #[test]
    fn a_number_is_centred_turned_and_never_upside_down() {
        assert!(number_width("12.5") > number_width("1.5") && number_width("") == 0.0);
        let middle = |direction| {
            let points: Vec<[f64; 2]> = number_strokes("808", [100.0, 50.0], direction).concat();
            [0, 1].map(|axis| ends(points.iter().map(|point| point[axis])))
        };
        let [x, y] = middle([1.0, 0.0]);
        assert!(
            (0.5 * (x[0] + x[1]) - 100.0).abs() < 0.01
                && (x[1] - x[0] - number_width("808")).abs() < 0.01
        );
        assert!((0.5 * (y[0] + y[1]) - 50.0).abs() < 0.01);
        let [x, y] = middle([0.0, 3.0]);
        assert!(y[1] - y[0] > x[1] - x[0]);
        let first = |direction| number_strokes("71", [0.0, 0.0], direction)[0][0];
        assert_eq!(first([1.0, 0.0]), first([-1.0, 0.0]));
        assert!(number_strokes("x", [0.0; 2], [1.0, 0.0]).is_empty());
    }
}
