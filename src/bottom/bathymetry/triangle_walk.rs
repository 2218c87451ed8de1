//! The triangle of a place, by a walk from one near it: quicker than a search where places lie in
//! rows, as the exact tests of a search are needed only next to an edge.

use spade::handles::{FixedFaceHandle, InnerTag};
use spade::{HasPosition, Point2, Triangulation};

/// End of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WalkEnd {
    /// The place lies in this triangle, and on none of its edges.
    Inside(FixedFaceHandle<InnerTag>),
    /// The place lies outside the hull, beyond an edge of this triangle.
    Outside(FixedFaceHandle<InnerTag>),
    /// The place lies on an edge of this triangle, or so near to one that rounding decides.
    NearEdge(FixedFaceHandle<InnerTag>),
}

/// Walks from a triangle towards a place, each time across an edge that the place lies beyond.
///
/// Such a walk ends in any Delaunay triangulation (De Floriani and others, "On sorting triangles in
/// a Delaunay tessellation", 1991).
pub(super) fn walk<T>(triangles: &T, from: FixedFaceHandle<InnerTag>, place: Point2<f64>) -> WalkEnd
where
    T: Triangulation,
    T::Vertex: HasPosition<Scalar = f64>,
{
    let mut face = triangles.face(from);
    let mut entered = None;
    // No walk meets a triangle twice.
    for _ in 0..triangles.num_inner_faces() {
        let (mut is_near_edge, mut beyond) = (false, None);
        for edge in face.adjacent_edges() {
            if Some(edge.fix()) == entered {
                continue;
            }
            match side(edge.positions(), place) {
                Some(true) => {}
                Some(false) => {
                    beyond = Some(edge.rev());
                    break;
                }
                None => is_near_edge = true,
            }
        }
        let Some(edge) = beyond else {
            return if is_near_edge {
                WalkEnd::NearEdge(face.fix())
            } else {
                WalkEnd::Inside(face.fix())
            };
        };
        let Some(next) = edge.face().as_inner() else {
            return WalkEnd::Outside(face.fix());
        };
        (face, entered) = (next, Some(edge.fix()));
    }
    WalkEnd::NearEdge(face.fix())
}

/// Share of the sum of both products that their difference may be off by in doubles (Shewchuk,
/// "Adaptive Precision Floating-Point Arithmetic", 1997: `ccwerrboundA`, 3.33e-16).
const ROUNDING: f64 = 4e-16;

/// Returns true if a place lies to the left of an edge; `None` where rounding decides.
fn side([from, to]: [Point2<f64>; 2], place: Point2<f64>) -> Option<bool> {
    let left = (from.x - place.x) * (to.y - place.y);
    let right = (from.y - place.y) * (to.x - place.x);
    let twice_area = left - right;
    let is_clear = twice_area.abs() > ROUNDING * (left.abs() + right.abs());
    is_clear.then_some(twice_area > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use spade::{DelaunayTriangulation, PositionInTriangulation};

    #[test]
    fn a_walk_ends_where_a_search_does() {
        let mut triangles = DelaunayTriangulation::<Point2<f64>>::new();
        let scattered = |index: u32| {
            let share = |factor: f64| (f64::from(index) * factor).fract();
            Point2::new(10.0 * share(0.618_033_988_7), share(0.754_877_666_2))
        };
        for index in 0..400 {
            triangles.insert(scattered(index)).unwrap();
        }
        let corner = triangles.vertex(spade::handles::FixedVertexHandle::from_index(7));
        let (corner, start) = (corner.position(), triangles.inner_faces().next().unwrap());
        let mut from = start.fix();
        let (mut inside, mut outside) = (0, 0);
        for index in 0..5000 {
            let Point2 { x, y } = scattered(1000 + index);
            let place = Point2::new(1.2 * x - 1.0, 1.2 * y - 0.1);
            let found = triangles.locate(place);
            match walk(&triangles, from, place) {
                WalkEnd::Inside(face) => {
                    assert_eq!(found, PositionInTriangulation::OnFace(face));
                    (from, inside) = (face, inside + 1);
                }
                WalkEnd::Outside(face) => {
                    let is_outside =
                        matches!(found, PositionInTriangulation::OutsideOfConvexHull(_));
                    assert!(is_outside, "{found:?}");
                    (from, outside) = (face, outside + 1);
                }
                WalkEnd::NearEdge(_) => panic!("{place:?} lies on no edge"),
            }
        }
        assert!(inside > 3000 && outside > 500, "{inside} {outside}");
        let at_corner = walk(&triangles, start.fix(), corner);
        assert!(matches!(at_corner, WalkEnd::NearEdge(_)), "{at_corner:?}");
    }
}
