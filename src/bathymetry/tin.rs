//! A triangulated surface through the soundings.

use super::DepthPoint;
use spade::handles::FixedVertexHandle;
use spade::{
    DelaunayTriangulation, FloatTriangulation as _, HasPosition, LastUsedVertexHintGenerator,
    Point2,
};

struct Node {
    place: Point2<f64>,
    depth_m: f64,
}

impl HasPosition for Node {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.place
    }
}

type Triangulation = DelaunayTriangulation<Node, (), (), (), LastUsedVertexHintGenerator>;

/// Delaunay triangles over soundings, depth linear within each; honours every sounding and invents nothing beyond the hull.
pub struct Tin {
    triangles: Triangulation,
    max_edge_m: f64,
}

impl Tin {
    /// Triangulates; `None` when a coordinate is none that can be triangulated (not finite, beyond 1e60 m).
    pub fn new(points: &[DepthPoint]) -> Option<Self> {
        use spade::Triangulation as _;
        let nodes = points
            .iter()
            .map(|point| Node {
                place: Point2::new(point.east_m, point.north_m),
                depth_m: point.depth_m,
            })
            .collect();
        let triangles = Triangulation::bulk_load(nodes).ok()?;
        Some(Self {
            triangles,
            max_edge_m: f64::INFINITY,
        })
    }

    /// Leaves out triangles with an edge longer than this: between soundings so far apart nothing is known. Without it the
    /// bays of a winding track are filled from one bank of the bend to the other.
    pub fn with_max_edge(self, max_edge_m: f64) -> Self {
        Self { max_edge_m, ..self }
    }

    /// Fills `depths_m` with the depth at each place; NaN where there is no triangle. Near places in a row are found fastest.
    pub fn depths(&self, places: impl Iterator<Item = [f64; 2]>, depths_m: &mut Vec<f64>) {
        let surface = self.triangles.barycentric();
        let mut weights = Vec::with_capacity(3);
        depths_m.clear();
        depths_m.extend(places.map(|[east_m, north_m]| {
            surface.get_weights(Point2::new(east_m, north_m), &mut weights);
            self.weighted(&weights)
        }));
    }

    fn weighted(&self, weights: &[(FixedVertexHandle, f64)]) -> f64 {
        use spade::Triangulation as _;
        let place = |index: usize| self.triangles.vertex(weights[index].0).position();
        let too_long = (0..weights.len()).any(|index| {
            let edge = [place(index), place((index + 1) % weights.len())];
            edge[0].distance_2(edge[1]) > self.max_edge_m * self.max_edge_m
        });
        if weights.is_empty() || too_long {
            return f64::NAN;
        }
        let depth = |(node, weight): &(FixedVertexHandle, f64)| {
            weight * self.triangles.vertex(*node).data().depth_m
        };
        weights.iter().map(depth).sum()
    }

    /// The depth at one place, metres; `None` where there is no triangle.
    pub fn depth_at(&self, east_m: f64, north_m: f64) -> Option<f64> {
        let mut depths = Vec::with_capacity(1);
        self.depths(std::iter::once([east_m, north_m]), &mut depths);
        depths.first().copied().filter(|depth| depth.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sixty scattered soundings of a smooth bed; the depths below are scipy's and GDAL's linear interpolation.
    #[test]
    fn linear_depths_agree_with_scipy_and_gdal() {
        let points: Vec<DepthPoint> = (0..60)
            .map(|i| {
                let x = (0.5 + 0.754_877_666_246_692_7 * f64::from(i)).fract() * 10.0;
                let y = (0.5 + 0.569_840_290_998_053_2 * f64::from(i)).fract() * 10.0;
                DepthPoint {
                    east_m: x,
                    north_m: y,
                    depth_m: 3.0 + 0.5 * (x / 2.0).sin() + 0.3 * (y / 1.7).cos(),
                }
            })
            .collect();
        let tin = Tin::new(&points).unwrap();
        for (x, y, depth_m) in [
            (2.5, 2.5, 3.496619061),
            (5.05, 4.9, 3.000069591),
            (7.3, 4.1, 2.548652625),
            (4.2, 8.0, 3.416673559),
            (6.6, 1.9, 3.058094229),
        ] {
            let found = tin.depth_at(x, y).unwrap();
            assert!((found - depth_m).abs() < 1e-9, "{x}, {y}: {found}");
        }
        assert_eq!(tin.depth_at(-5.0, 5.0), None);
        let near = tin.with_max_edge(0.5);
        assert_eq!(near.depth_at(2.5, 2.5), None);
    }
}
