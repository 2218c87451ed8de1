//! Computes with outlines and boxes on a plane.

/// Returns true if a place is inside a closed outline, whose first corner is repeated as the last:
/// a ray from the place to the east crosses the outline an odd number of times.
pub fn goes_around(outline: &[[f64; 2]], place: [f64; 2]) -> bool {
    let steps = outline.windows(2);
    let crossed = steps.filter(|step| is_crossed([step[0], step[1]], place));
    crossed.count() % 2 == 1
}

/// Returns true if a ray from a place to the east crosses an edge.
pub fn is_crossed([[x0, y0], [x1, y1]]: [[f64; 2]; 2], [x, y]: [f64; 2]) -> bool {
    (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
}

/// Returns the edges of a ring that lists each corner once.
pub fn edges<T: Copy>(ring: &[T]) -> impl Iterator<Item = [T; 2]> {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(from, to)| [*from, *to])
}

/// Returns the place at a share (0 to 1) of the way from one place to another.
pub fn between(from: [f64; 2], to: [f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
}

/// The box (west, south, east, north) of no place, which meets no other box.
pub const NOWHERE: [f64; 4] = [f64::MAX, f64::MAX, f64::MIN, f64::MIN];

/// Returns west, south, east and north of some places in a plane; [`NOWHERE`] without places.
pub fn bounds(places: impl IntoIterator<Item = [f64; 2]>) -> [f64; 4] {
    let boxes = places.into_iter().map(|[x, y]| [x, y, x, y]);
    boxes.fold(NOWHERE, box_around)
}

/// Returns the smallest box around two boxes (west, south, east, north).
pub fn box_around(one: [f64; 4], other: [f64; 4]) -> [f64; 4] {
    [one[0].min(other[0]), one[1].min(other[1]), one[2].max(other[2]), one[3].max(other[3])]
}

/// Returns true if two boxes (west, south, east, north) share a place.
pub fn boxes_meet(one: [f64; 4], other: [f64; 4]) -> bool {
    one[0] <= other[2] && one[2] >= other[0] && one[1] <= other[3] && one[3] >= other[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outline_goes_around_what_is_inside_of_it() {
        let notched = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0], [0.0, 0.0]];
        let inside = [[1.0, 1.0], [3.0, 2.0], [2.0, 2.0], [5.0, 1.0], [-1.0, 1.0]];
        let found = inside.map(|place| goes_around(&notched, place));
        assert_eq!(found, [true, true, false, false, false]);
        assert!(!goes_around(&[], [0.0, 0.0]));
    }
}
