//! The ground that the side-scan of a run covers.

use bathyscope_bottom::bathymetry::isobaths::Polygon;
use bathyscope_log::support::geo::MapPlane;

/// The ground that the side-scan covers.
pub(super) struct SideScanCoverage {
    /// Its outlines, in the plane of the map; empty without side-scan.
    pub shapes: Vec<Polygon>,
    /// Its area on the ground, square metres.
    pub area_m2: f64,
}

impl SideScanCoverage {
    /// Creates the coverage from outlines in the plane of a map.
    pub(super) fn new(shapes: Vec<Polygon>, map: &MapPlane) -> Self {
        // A shape without a point covers nothing that could be drawn.
        let Some(first) = shapes.first().and_then(|shape| shape.outline.first()).copied() else {
            return Self { shapes: Vec::new(), area_m2: 0.0 };
        };
        let on_map_m2: f64 = shapes.iter().map(|shape| shape.area_m2()).sum();
        Self { shapes, area_m2: on_map_m2 / map.area_scale_at(first) }
    }
}
