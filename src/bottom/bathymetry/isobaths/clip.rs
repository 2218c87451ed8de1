//! Cuts lines at the edges of tiles, and joins them again.

use super::lines::{Isobath, join};
use std::collections::HashMap;

/// Least length of a part, metres: shorter parts, rounded to the millimetre of the files, are no
/// lines any more.
pub(super) const LEAST_LENGTH_M: f64 = 0.01;

/// Returns the parts of a line that lie in a box (west, south, east, north). Where a line leaves a
/// box and enters the next one, the place is exactly the same in both.
pub fn clipped(line: &Isobath, bounds: [f64; 4]) -> Vec<Isobath> {
    let mut parts: Vec<Vec<[f64; 2]>> = Vec::new();
    for step in line.points.windows(2) {
        let Some([from, to]) = clipped_step([step[0], step[1]], bounds) else {
            continue;
        };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    let parts = parts.into_iter().map(|mut points| {
        points.dedup();
        Isobath { depth_m: line.depth_m, points }
    });
    parts.filter(|part| part.length_m() > LEAST_LENGTH_M).collect()
}

/// Returns the part of a step in a box (Liang and Barsky 1984); `None` where they do not meet.
fn clipped_step(
    [from, to]: [[f64; 2]; 2],
    [west, south, east, north]: [f64; 4],
) -> Option<[[f64; 2]; 2]> {
    // Most steps lie beyond one edge.
    let lies_beyond = |axis: usize, low: f64, high: f64| {
        from[axis].max(to[axis]) < low || from[axis].min(to[axis]) > high
    };
    if lies_beyond(0, west, east) || lies_beyond(1, south, north) {
        return None;
    }
    let way = [to[0] - from[0], to[1] - from[1]];
    // Shares of the step at which it enters and leaves, and the edges there.
    let mut entry: (f64, Option<(usize, f64)>) = (0.0, None);
    let mut exit: (f64, Option<(usize, f64)>) = (1.0, None);
    for (axis, low, high) in [(0, west, east), (1, south, north)] {
        if way[axis] == 0.0 {
            if !(low..=high).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let (near, far) = if way[axis] > 0.0 { (low, high) } else { (high, low) };
        let share = |edge: f64| (edge - from[axis]) / way[axis];
        if share(near) > entry.0 {
            entry = (share(near), Some((axis, near)));
        }
        if share(far) < exit.0 {
            exit = (share(far), Some((axis, far)));
        }
    }
    let at = |(share, edge): (f64, Option<(usize, f64)>), end: [f64; 2]| match edge {
        None => end,
        Some((axis, edge)) => {
            let mut place = [0, 1].map(|axis| from[axis] + share * way[axis]);
            place[axis] = edge;
            place
        }
    };
    (entry.0 < exit.0).then(|| [at(entry, from), at(exit, to)])
}

/// Depth and place of the start or end of a piece, as bits.
type End = [u64; 3];

/// Joins pieces to lines: a piece that ends where another piece of its depth begins continues with
/// it. A piece that begins where an earlier one of its depth does stays apart.
pub fn joined(pieces: Vec<Isobath>) -> Vec<Isobath> {
    let end = |depth_m: f64, [x, y]: [f64; 2]| -> End { [depth_m, x, y].map(f64::to_bits) };
    let (mut by_begin, mut links, mut lines) = (HashMap::new(), Vec::new(), Vec::new());
    for piece in pieces {
        let (Some(&first), Some(&last)) = (piece.points.first(), piece.points.last()) else {
            continue;
        };
        let [begin, end] = [first, last].map(|place| end(piece.depth_m, place));
        if begin == end || by_begin.contains_key(&begin) {
            lines.push(piece)
        } else {
            links.push([begin, end]);
            by_begin.insert(begin, piece);
        }
    }
    for ends in join(&links) {
        let mut parts = ends.iter().filter_map(|begin| by_begin.remove(begin));
        let Some(mut line) = parts.next() else {
            continue;
        };
        for part in parts {
            line.points.extend(part.points.into_iter().skip(1));
        }
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leaves_one_tile_enters_the_next_at_the_same_place() {
        let line = Isobath {
            depth_m: 2.0,
            points: vec![[1.0, 1.0], [9.3, 4.7], [11.7, 5.9], [8.0, 8.0], [7.0, 12.0], [6.0, 9.0]],
        };
        let west = clipped(&line, [0.0, 0.0, 10.0, 10.0]);
        let east = clipped(&line, [10.0, 0.0, 20.0, 10.0]);
        assert_eq!(west.len(), 3);
        assert_eq!(east.len(), 1);
        assert_eq!(west[0].points.last(), east[0].points.first());
        assert_eq!(east[0].points.last(), west[1].points.first());
        assert_eq!(east[0].points[0][0], 10.0);
        assert_eq!(west[1].points.last().map(|at| at[1]), Some(10.0));
        assert_eq!(clipped(&line, [20.0, 0.0, 30.0, 10.0]), []);
        assert_eq!(clipped(&line, [0.0, 0.0, 20.0, 20.0]), [line]);
        let short = Isobath { depth_m: 2.0, points: vec![[1.0, 1.0], [1.001, 1.0]] };
        assert_eq!(clipped(&short, [0.0, 0.0, 20.0, 20.0]), []);
    }

    #[test]
    fn what_was_cut_is_joined_again() {
        let line = Isobath {
            depth_m: 2.0,
            points: vec![[1.0, 1.0], [9.3, 4.7], [21.7, 5.9], [8.0, 8.0], [7.0, 9.0]],
        };
        let ring = Isobath {
            depth_m: 2.0,
            points: vec![[3.0, 3.0], [17.0, 3.0], [17.0, 7.0], [3.0, 3.0]],
        };
        let boxes = [[20.0, 0.0, 30.0, 10.0], [0.0, 0.0, 10.0, 10.0], [10.0, 0.0, 20.0, 10.0]];
        let cut = |line: &Isobath| -> Vec<Isobath> {
            boxes.iter().flat_map(|tile| clipped(line, *tile)).collect()
        };
        let pieces = cut(&line);
        assert_eq!(pieces.len(), 5);
        let back = joined(pieces);
        assert_eq!(back.len(), 1);
        assert!((back[0].length_m() - line.length_m()).abs() < 1e-9);
        assert_eq!((back[0].points[0], back[0].points.last()), ([1.0, 1.0], Some(&[7.0, 9.0])));
        let back = joined(cut(&ring));
        assert_eq!(back.len(), 1);
        assert!(back[0].is_ring() && (back[0].length_m() - ring.length_m()).abs() < 1e-9);
        let other = Isobath { depth_m: 3.0, points: vec![[7.0, 9.0], [1.0, 9.0]] };
        assert_eq!(joined(vec![line.clone(), other.clone(), ring.clone()]).len(), 3);
        assert_eq!(joined(vec![line.clone(), line]).len(), 2);
    }
}
