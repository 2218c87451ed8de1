//! Rounder lines, for those who prefer looks to exactness.

/// Cuts the corners of a line `passes` times (Chaikin 1974): each pass puts two points at a quarter and three quarters of every
/// step and leaves the corners out. The ends of an open line stay; a ring, which ends where it began, stays one. The line moves
/// by up to a quarter of a step.
pub fn smoothed(points: &[[f64; 2]], passes: u32) -> Vec<[f64; 2]> {
    let mut line = points.to_vec();
    for _ in 0..passes {
        line = cut_corners(&line);
    }
    line
}

fn cut_corners(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let (Some(&first), Some(&last)) = (line.first(), line.last()) else {
        return Vec::new();
    };
    if line.len() < 3 {
        return line.to_vec();
    }
    let between = |step: &[[f64; 2]], share: f64| {
        [0, 1].map(|axis| step[0][axis] + share * (step[1][axis] - step[0][axis]))
    };
    let cut = line
        .windows(2)
        .flat_map(|step| [between(step, 0.25), between(step, 0.75)]);
    if first == last {
        let mut ring: Vec<[f64; 2]> = cut.collect();
        ring.push(ring[0]);
        return ring;
    }
    // The first and last quarter point would lie on the line and change nothing.
    let inner = cut.skip(1).take(2 * line.len() - 4);
    std::iter::once(first).chain(inner).chain([last]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_stay_and_corners_go() {
        let bend = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]];
        let once = [[0.0, 0.0], [3.0, 0.0], [4.0, 1.0], [4.0, 4.0]];
        assert_eq!(smoothed(&bend, 1), once);
        assert_eq!(smoothed(&bend, 0), bend);
        assert_eq!(smoothed(&bend[..2], 5), bend[..2]);
    }

    #[test]
    fn a_ring_stays_closed_and_shrinks_to_the_known_area() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        let ring = smoothed(&square, 8);
        assert_eq!(ring.first(), ring.last());
        let area: f64 = ring
            .windows(2)
            .map(|s| 0.5 * (s[0][0] * s[1][1] - s[1][0] * s[0][1]))
            .sum();
        // Chaikin's curve is the quadratic B-spline: of a unit square, 5/6.
        assert!((area - 5.0 / 6.0).abs() < 1e-4, "{area}");
    }
}
