//! Triangulates soundings, and finds the depth between them.

use super::Node;
use super::nodes::sort_for_insertion;
use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{
    DelaunayTriangulation, HasPosition, LastUsedVertexHintGenerator, NaturalNeighbor, Point2,
    PositionInTriangulation, Triangulation as _,
};

impl HasPosition for Node {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.east_m, self.north_m)
    }
}

type Triangulation = DelaunayTriangulation<Node, (), (), (), LastUsedVertexHintGenerator>;

/// Delaunay triangles over nodes: the surface passes through every node, and ends at the hull. They
/// take some 150 bytes a node, two thirds of these for edges, so that nodes are moved in rather
/// than copied.
pub(crate) struct Tin {
    triangles: Triangulation,
    max_gap_m: f64,
    max_radius_m: f64,
}

/// Greatest length of the edges of triangles that are always kept, as a share of the gap: along a
/// single track they lie in a row, nearly flat, and their area across the track is negligible.
const SHORT_EDGES: f64 = 0.25;
/// Largest rounding error of the difference of two products in doubles, as a share of the sum of
/// their sizes (Shewchuk, "Adaptive Precision Floating-Point Arithmetic", 1997: `ccwerrboundA`,
/// 3.33e-16).
const ROUNDING: f64 = 4e-16;

/// Returns the radius of the circle around a triangle whose three edges are two gaps long, metres.
pub(super) fn largest_radius_m(max_gap_m: f64) -> f64 {
    2.0 * max_gap_m / 3f64.sqrt()
}

/// Method that finds the depth between the corners of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Between {
    /// Depth on the plane of the triangle.
    Linear,
    /// Sibson's natural neighbours: each node counts with the area that the place would take from
    /// its Voronoi cell.
    NaturalNeighbour,
}

/// Sampler of a [`Tin`] for one thread. Successive places that are near each other are found
/// fastest.
pub(crate) struct TinSampler<'a> {
    tin: &'a Tin,
    /// Triangle near the last place, and whether it is kept, once this is determined: spade's own
    /// hint is shared by all threads.
    last: Option<(FixedFaceHandle<InnerTag>, Option<bool>)>,
    natural: Option<NaturalNeighbor<'a, Triangulation>>,
    weights: Vec<(FixedVertexHandle, f64)>,
}

impl Tin {
    /// Triangulates nodes; `None` where they span no surface (fewer than three places, or all on
    /// one line), or when a coordinate cannot be triangulated (not finite, beyond 1e60 m).
    pub(crate) fn new(mut nodes: Vec<Node>) -> Option<Self> {
        for node in &mut nodes {
            for metres in [&mut node.east_m, &mut node.north_m] {
                // spade refuses numbers that are nearer to zero, as they cannot be multiplied.
                if metres.abs() < spade::MIN_ALLOWED_VALUE {
                    *metres = 0.0;
                }
            }
        }
        if !sort_for_insertion(&mut nodes) {
            return None;
        }
        let count = nodes.len();
        let mut triangles = Triangulation::with_capacity(count, 3 * count, 2 * count);
        for node in nodes {
            triangles.insert(node).ok()?;
        }
        Some(Self { triangles, max_gap_m: f64::INFINITY, max_radius_m: f64::INFINITY })
    }

    /// Leaves out triangles between nodes that are too far apart for anything to be known between
    /// them: those with an edge longer than two gaps, and those whose circumscribed circle, which
    /// holds no node, is larger than that of a triangle of three such edges. So the surface follows
    /// its nodes (an alpha shape): neither the bay of a winding track is filled from one bank of
    /// the bend to the other, nor the lens between a bend and its chord.
    pub(crate) fn with_max_gap(self, max_gap_m: f64) -> Self {
        Self { max_gap_m, ..self }
    }

    /// Leaves out every triangle whose circumscribed circle is larger than that of the largest
    /// triangle that [`Tin::with_max_gap`] keeps, including the nearly flat ones of short edges: no
    /// triangle that is left depends on a node farther from it than twice [`largest_radius_m`].
    pub(crate) fn with_local_triangles(self) -> Self {
        Self { max_radius_m: largest_radius_m(self.max_gap_m), ..self }
    }

    /// Returns true if [`Tin::with_max_gap`] and [`Tin::with_local_triangles`] keep a triangle.
    fn is_known(&self, mut corners: [Point2<f64>; 3]) -> bool {
        // In a fixed order, so that the same triangle of another triangulation is rounded alike.
        corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        let [a, b, c] = corners;
        let edges_m = [a.distance_2(b), b.distance_2(c), c.distance_2(a)].map(f64::sqrt);
        let longest_m = edges_m.into_iter().fold(0.0, f64::max);
        let area_m2 = 0.5 * ((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)).abs();
        let radius_m = edges_m.iter().product::<f64>() / (4.0 * area_m2);
        let most_m = largest_radius_m(self.max_gap_m);
        let is_kept = longest_m <= SHORT_EDGES * self.max_gap_m
            || longest_m <= 2.0 * self.max_gap_m && radius_m <= most_m;
        is_kept && radius_m <= self.max_radius_m
    }

    /// Returns the nodes, one a place, in no order.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = Node> + '_ {
        self.triangles.vertices().map(|vertex| *vertex.data())
    }

    /// Creates a sampler.
    pub(crate) fn sampler(&self, between: Between) -> TinSampler<'_> {
        TinSampler {
            tin: self,
            last: None,
            natural: (between == Between::NaturalNeighbour)
                .then(|| self.triangles.natural_neighbor()),
            weights: Vec::with_capacity(16),
        }
    }

    /// Returns the depth at a place on the plane of its triangle, metres; `None` where there is no
    /// triangle.
    #[cfg(test)]
    pub(crate) fn depth_at(&self, east_m: f64, north_m: f64) -> Option<f64> {
        self.sampler(Between::Linear).depth_at([east_m, north_m])
    }
}

impl TinSampler<'_> {
    /// Returns the depth at a place, metres; `None` where there is no triangle.
    pub(crate) fn depth_at(&mut self, place: [f64; 2]) -> Option<f64> {
        let nodes = self.nodes_at(place)?;
        Some(nodes.map(|(node, weight)| weight * node.depth_m).sum())
    }

    /// Returns the nodes that carry a place, with weights that sum to 1; `None` where there is no
    /// triangle.
    pub(crate) fn nodes_at(
        &mut self,
        [east_m, north_m]: [f64; 2],
    ) -> Option<impl Iterator<Item = (Node, f64)> + Clone + '_> {
        let place = Point2::new(east_m, north_m);
        self.find_corners(place);
        if !self.is_known() {
            return None;
        }
        match &self.natural {
            Some(natural) if self.weights.len() > 2 => {
                natural.get_weights(place, &mut self.weights)
            }
            _ => self.weigh_in_order(place),
        }
        Some(self.nodes())
    }

    /// Finds the nodes that carry a place: a node at the place, the ends of an edge through it, or
    /// the corners of the triangle around it. Their weights are not computed yet.
    fn find_corners(&mut self, place: Point2<f64>) {
        let triangles = &self.tin.triangles;
        self.weights.clear();
        let Some((start, _)) = self.last else {
            return self.carry(triangles.locate(place));
        };
        match walk(triangles, start, place) {
            WalkEnd::Inside(face) => self.carry(PositionInTriangulation::OnFace(face)),
            WalkEnd::Outside(face) => self.go_to(face),
            WalkEnd::NearEdge(face) => {
                let corner = triangles.face(face).vertices()[0].fix();
                self.go_to(face);
                self.carry(triangles.locate_with_hint(place, corner));
            }
        }
    }

    /// Stores the nodes that carry a place at this position, and a triangle near it.
    fn carry(&mut self, at: PositionInTriangulation) {
        let triangles = &self.tin.triangles;
        let beside = match at {
            PositionInTriangulation::OnVertex(node) => {
                self.weights.push((node, 1.0));
                let mut edges = triangles.vertex(node).out_edges();
                edges.find_map(|edge| edge.face().as_inner())
            }
            PositionInTriangulation::OnEdge(edge) => {
                let edge = triangles.directed_edge(edge);
                self.weights.extend(edge.vertices().map(|end| (end.fix(), 0.0)));
                edge.face().as_inner().or(edge.rev().face().as_inner())
            }
            PositionInTriangulation::OnFace(face) => {
                let face = triangles.face(face);
                let corners = face.vertices().map(|corner| (corner.fix(), 0.0));
                self.weights.extend(corners);
                Some(face)
            }
            PositionInTriangulation::OutsideOfConvexHull(edge) => {
                triangles.directed_edge(edge).rev().face().as_inner()
            }
            PositionInTriangulation::NoTriangulation => None,
        };
        if let Some(face) = beside {
            self.go_to(face.fix());
        }
    }

    /// Sets the triangle in which the next walk begins.
    fn go_to(&mut self, face: FixedFaceHandle<InnerTag>) {
        if self.last.is_none_or(|(last, _)| last != face) {
            self.last = Some((face, None));
        }
    }

    /// Weighs the corners in the order of their places: the order in which a triangle stores its
    /// corners depends on all nodes that were ever inserted, and with it the last bit of a weight,
    /// which would differ between maps that share the triangle.
    fn weigh_in_order(&mut self, place: Point2<f64>) {
        let triangles = &self.tin.triangles;
        let position = |corner: &(FixedVertexHandle, f64)| triangles.vertex(corner.0).position();
        self.weights.sort_by(|a, b| {
            let (a, b) = (position(a), position(b));
            a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
        });
        let way = |from: Point2<f64>, to: Point2<f64>| [to.x - from.x, to.y - from.y];
        let cross = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| ax * by - ay * bx;
        match self.weights.as_mut_slice() {
            [first, second] => {
                let (a, b) = (position(first), position(second));
                let ([x, y], [along_x, along_y]) = (way(a, b), way(a, place));
                second.1 = (x * along_x + y * along_y) / (x * x + y * y);
                first.1 = 1.0 - second.1;
            }
            [first, second, third] => {
                let [a, b, c] = [&*first, &*second, &*third].map(position);
                let area = cross(way(a, b), way(a, c));
                second.1 = cross(way(a, place), way(a, c)) / area;
                third.1 = cross(way(a, b), way(a, place)) / area;
                first.1 = 1.0 - second.1 - third.1;
            }
            _ => {}
        }
    }

    /// Returns the nodes that carry the last place, with their weights.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = (Node, f64)> + Clone + '_ {
        let triangles = &self.tin.triangles;
        let carried = self.weights.iter();
        carried.map(move |(corner, weight)| (*triangles.vertex(*corner).data(), *weight))
    }

    /// Returns the distance from a place in a triangle to the nearest node, metres; the place must
    /// be that of the last call of [`Self::nodes_at`].
    ///
    /// Goes from the nodes that carry the place to ever nearer neighbours: in Delaunay triangles
    /// every node but the nearest has a nearer neighbour.
    pub(crate) fn distance_m(&self, [east_m, north_m]: [f64; 2]) -> f64 {
        let place = Point2::new(east_m, north_m);
        let triangles = &self.tin.triangles;
        let squared = |corner: FixedVertexHandle| {
            let away_m2 = triangles.vertex(corner).position().distance_2(place);
            (away_m2, corner)
        };
        let nearest = |corners: &mut dyn Iterator<Item = FixedVertexHandle>| {
            corners.map(squared).min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let Some(mut here) = nearest(&mut self.weights.iter().map(|(corner, _)| *corner)) else {
            return f64::NAN;
        };
        loop {
            let edges = triangles.vertex(here.1).out_edges();
            match nearest(&mut edges.map(|edge| edge.to().fix())) {
                Some(next) if next.0 < here.0 => here = next,
                _ => return here.0.sqrt(),
            }
        }
    }

    /// Returns true if the last place lies in a triangle that counts, on the edge of one, or on a
    /// node.
    fn is_known(&mut self) -> bool {
        let triangles = &self.tin.triangles;
        let place = |index: usize| triangles.vertex(self.weights[index].0).position();
        match self.weights.len() {
            0 => false,
            1 => true,
            2 => {
                let ends = [self.weights[0].0, self.weights[1].0];
                let edge = triangles.get_edge_from_neighbors(ends[0], ends[1]);
                edge.is_some_and(|edge| {
                    let beside = [edge.face(), edge.rev().face()].into_iter();
                    let mut inner = beside.filter_map(|face| face.as_inner());
                    inner.any(|face| self.tin.is_known(face.positions()))
                })
            }
            _ => {
                let places = [place(0), place(1), place(2)];
                let (tin, asked) = (self.tin, self.last.as_mut().map(|(_, known)| known));
                match asked {
                    Some(known) => *known.get_or_insert_with(|| tin.is_known(places)),
                    None => tin.is_known(places),
                }
            }
        }
    }
}

/// Result of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WalkEnd {
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
///
/// From a triangle near a place, a walk is faster than a search where places lie in rows, as the
/// exact tests of a search are needed only next to an edge.
fn walk<T>(triangles: &T, from: FixedFaceHandle<InnerTag>, place: Point2<f64>) -> WalkEnd
where
    T: spade::Triangulation,
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
    use crate::bathymetry::testing::{GOLDEN, golden_nodes};

    #[test]
    fn linear_depths_agree_with_scipy_and_gdal() {
        let tin = Tin::new(golden_nodes()).unwrap();
        for golden in &GOLDEN {
            let [x, y] = golden.place;
            let found = tin.depth_at(x, y).unwrap();
            assert!((found - golden.linear).abs() < 1e-9, "{x}, {y}: {found}");
        }
        assert_eq!(tin.depth_at(-5.0, 5.0), None);
        let near = tin.with_max_gap(0.25);
        assert_eq!(near.depth_at(2.5, 2.5), None);
    }

    #[test]
    fn natural_neighbours_agree_with_exact_voronoi_areas() {
        let tin = Tin::new(golden_nodes()).unwrap();
        let mut sampler = tin.sampler(Between::NaturalNeighbour);
        for golden in &GOLDEN {
            let nodes = sampler.nodes_at(golden.place).unwrap();
            let found: f64 = nodes.map(|(node, weight)| weight * node.depth_m).sum();
            assert!((found - golden.natural).abs() < 1e-9, "{found}");
        }
    }

    #[test]
    fn the_nearest_node_is_that_of_a_search_through_all() {
        let nodes = golden_nodes();
        let tin = Tin::new(nodes.clone()).unwrap();
        let mut sampler = tin.sampler(Between::Linear);
        let mut found = 0;
        for cell in 0..10_000 {
            let place = [0.1 * f64::from(cell % 100), 0.1 * f64::from(cell / 100)];
            if sampler.nodes_at(place).is_some() {
                let away_m = |node: &Node| (node.east_m - place[0]).hypot(node.north_m - place[1]);
                let brute_m = nodes.iter().map(away_m).fold(f64::MAX, f64::min);
                assert!((sampler.distance_m(place) - brute_m).abs() < 1e-12);
                found += 1;
            }
        }
        assert!(found > 7000, "{found}");
    }

    #[test]
    fn a_node_is_honoured_by_both() {
        let nodes = golden_nodes();
        let tin = Tin::new(nodes.clone()).unwrap();
        for between in [Between::Linear, Between::NaturalNeighbour] {
            let mut sampler = tin.sampler(between);
            for node in &nodes {
                let at = sampler.nodes_at(node.place()).unwrap();
                let depth_m: f64 = at.map(|(node, weight)| weight * node.depth_m).sum();
                assert!((depth_m - node.depth_m).abs() < 1e-9);
            }
        }
    }

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
