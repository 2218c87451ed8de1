//! Draws depths along a line: numbers made of strokes, which can be rotated.

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
pub(super) fn width(text: &str) -> f64 {
    let widths = text.chars().filter_map(figure).map(|(_, width)| width + SPACE);
    (widths.sum::<f64>() - SPACE).max(0.0) * SCALE
}

/// Returns the strokes of a number around its middle, rotated to the direction of a line but never
/// upside down; pixels.
pub(super) fn strokes(text: &str, [x, y]: [f64; 2], direction: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let length = direction[0].hypot(direction[1]).max(f64::MIN_POSITIVE);
    let sign = if direction[0] < 0.0 { -1.0 } else { 1.0 };
    let [cos, sin] = direction.map(|part| sign * part / length);
    let mut left = -0.5 * width(text);
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

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::statistics::ends;

    #[test]
    fn a_number_is_centred_turned_and_never_upside_down() {
        assert!(width("12.5") > width("1.5") && width("") == 0.0);
        let middle = |direction| {
            let points: Vec<[f64; 2]> = strokes("808", [100.0, 50.0], direction).concat();
            [0, 1].map(|axis| ends(points.iter().map(|point| point[axis])))
        };
        let [x, y] = middle([1.0, 0.0]);
        assert!(
            (0.5 * (x[0] + x[1]) - 100.0).abs() < 0.01 && (x[1] - x[0] - width("808")).abs() < 0.01
        );
        assert!((0.5 * (y[0] + y[1]) - 50.0).abs() < 0.01);
        let [x, y] = middle([0.0, 3.0]);
        assert!(y[1] - y[0] > x[1] - x[0]);
        let first = |direction| strokes("71", [0.0, 0.0], direction)[0][0];
        assert_eq!(first([1.0, 0.0]), first([-1.0, 0.0]));
        assert!(strokes("x", [0.0; 2], [1.0, 0.0]).is_empty());
    }
}
