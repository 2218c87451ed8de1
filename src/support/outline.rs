//! Outlines on a plane.

/// Whether a closed outline, whose first corner is its last one too, goes around a place: a ray to the east crosses it an odd number of times.
pub(crate) fn goes_around(outline: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let crosses = |step: &&[[f64; 2]]| {
        let [[x0, y0], [x1, y1]] = [step[0], step[1]];
        (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
    };
    outline.windows(2).filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outline_goes_around_what_is_inside_of_it() {
        let notched = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [2.0, 1.0],
            [0.0, 4.0],
            [0.0, 0.0],
        ];
        let inside = [[1.0, 1.0], [3.0, 2.0], [2.0, 2.0], [5.0, 1.0], [-1.0, 1.0]];
        let found = inside.map(|place| goes_around(&notched, place));
        assert_eq!(found, [true, true, false, false, false]);
        assert!(!goes_around(&[], [0.0, 0.0]));
    }
}
