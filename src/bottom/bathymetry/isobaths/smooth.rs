//! Rounder lines, for those who prefer looks to exactness.

use bathyscope_log::support::outline::between;

/// Settings for cutting the corners of lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Smoothing {
    /// Number of passes.
    pub passes: u32,
    /// True if a corner is cut only where this moves the line toward deeper water, so that nothing
    /// shallower comes to lie beyond it.
    pub toward_deep: bool,
}

/// Cuts the corners of a line (Chaikin 1974): each pass puts two points at a quarter and three
/// quarters of every step and leaves the corners out. The ends of an open line stay; a ring, which
/// ends where it began, stays one. The line moves by up to a quarter of a step.
pub fn smoothed(points: &[[f64; 2]], smoothing: Smoothing) -> Vec<[f64; 2]> {
    let mut line = points.to_vec();
    for _ in 0..smoothing.passes {
        line = cut_corners(&line, smoothing.toward_deep);
    }
    line
}

fn cut_corners(line: &[[f64; 2]], toward_deep: bool) -> Vec<[f64; 2]> {
    let count = line.len();
    if count < 3 {
        return line.to_vec();
    }
    let is_ring = line[0] == line[count - 1];
    let mut cut = Vec::with_capacity(2 * count);
    let mut corner = |before: [f64; 2], at: [f64; 2], after: [f64; 2]| {
        // The deeper side is on the left: cutting a turn to the left moves the line that way.
        if !toward_deep || turns_left(before, at, after) {
            cut.extend([between(before, at, 0.75), between(at, after, 0.25)])
        } else {
            cut.push(at)
        }
    };
    if is_ring {
        // The last point is the first one, whose corner lies between the last step and the first.
        corner(line[count - 2], line[0], line[1]);
    }
    line.windows(3).for_each(|three| corner(three[0], three[1], three[2]));
    let ends = if is_ring { [cut[0]; 2] } else { [line[0], line[count - 1]] };
    if !is_ring {
        cut.insert(0, ends[0]);
    }
    cut.push(ends[1]);
    cut
}

fn turns_left(before: [f64; 2], at: [f64; 2], after: [f64; 2]) -> bool {
    let [come, go] = [[before, at], [at, after]].map(|[a, b]| [b[0] - a[0], b[1] - a[1]]);
    come[0] * go[1] - come[1] * go[0] > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(passes: u32) -> Smoothing {
        Smoothing { passes, toward_deep: false }
    }

    fn area(ring: &[[f64; 2]]) -> f64 {
        let steps = ring.windows(2);
        steps.map(|s| 0.5 * (s[0][0] * s[1][1] - s[1][0] * s[0][1])).sum()
    }

    #[test]
    fn ends_stay_and_corners_go() {
        let bend = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]];
        let once = [[0.0, 0.0], [3.0, 0.0], [4.0, 1.0], [4.0, 4.0]];
        assert_eq!(smoothed(&bend, passes(1)), once);
        assert_eq!(smoothed(&bend, passes(0)), bend);
        assert_eq!(smoothed(&bend[..2], passes(5)), bend[..2]);
    }

    #[test]
    fn a_ring_stays_closed_and_shrinks_to_the_known_area() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        let ring = smoothed(&square, passes(8));
        assert_eq!(ring.first(), ring.last());
        // Chaikin's curve is the quadratic B-spline: of a unit square, 5/6.
        assert!((area(&ring) - 5.0 / 6.0).abs() < 1e-4);
    }

    #[test]
    fn toward_deep_water_a_hole_shrinks_and_a_shoal_only_grows() {
        let safe = Smoothing { passes: 3, toward_deep: true };
        // Deeper on the left: counter-clockwise around a hole, clockwise around a shoal.
        let hole = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        assert!(area(&smoothed(&hole, safe)) < 0.9);
        let shoal: Vec<[f64; 2]> = hole.into_iter().rev().collect();
        assert_eq!(smoothed(&shoal, safe), shoal);
        // Of a line to the east with a bend to the left and one to the right, the water south of it
        // is shallow: it moves north alone.
        let line = [[0.0, 0.0], [4.0, 0.0], [8.0, 4.0], [12.0, 4.0]];
        let moved = smoothed(&line, safe);
        assert!(moved.contains(&[8.0, 4.0]) && !moved.contains(&[4.0, 0.0]), "{moved:?}");
        assert_eq!([moved[0], moved[moved.len() - 1]], [line[0], line[3]]);
    }
}
