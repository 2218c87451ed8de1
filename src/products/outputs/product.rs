//! What `bathyscope process --products` chooses from.

use serde::{Deserialize, Serialize};

/// A group of files that `bathyscope process --products` chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Product {
    /// The points.
    Cloud,
    /// The way of the boat, and the ground that it covers.
    Track,
    /// The depth map as rasters.
    Depth,
    /// The depth map as text.
    Xyz,
    /// The depth map as a body and as points for 3D programs.
    Bottom,
    /// Lines of equal depth, the areas between them and what lies below each.
    Isobaths,
    /// The depth map as tiles for plotters and the web, and as a page.
    MapTiles,
    /// The side-scan mosaic.
    Mosaic,
    /// How the depths agree.
    Residuals,
    /// The objects of the review.
    Targets,
    /// All lines, areas and objects in one file.
    Geopackage,
    /// The page that shows what was made.
    Report,
}

impl Product {
    /// All of them.
    pub const ALL: [Product; 12] = [
        Product::Cloud,
        Product::Track,
        Product::Depth,
        Product::Xyz,
        Product::Bottom,
        Product::Isobaths,
        Product::MapTiles,
        Product::Mosaic,
        Product::Residuals,
        Product::Targets,
        Product::Geopackage,
        Product::Report,
    ];

    /// The name that `--products` knows.
    pub fn name(self) -> &'static str {
        match self {
            Product::Cloud => "cloud",
            Product::Track => "track",
            Product::Depth => "depth",
            Product::Xyz => "xyz",
            Product::Bottom => "bottom",
            Product::Isobaths => "isobaths",
            Product::MapTiles => "map-tiles",
            Product::Mosaic => "mosaic",
            Product::Residuals => "residuals",
            Product::Targets => "targets",
            Product::Geopackage => "geopackage",
            Product::Report => "report",
        }
    }

    /// What people call it.
    pub fn title(self) -> &'static str {
        match self {
            Product::Cloud => "Point cloud",
            Product::Track => "Track and coverage",
            Product::Depth => "Depth map (GeoTIFF)",
            Product::Xyz => "Depth grid as text (XYZ)",
            Product::Bottom => "Bottom for 3D programs",
            Product::Isobaths => "Isobaths, depth areas, volumes",
            Product::MapTiles => "Depth map for plotters and the web",
            Product::Mosaic => "Side-scan mosaic (GeoTIFF)",
            Product::Residuals => "Residuals",
            Product::Targets => "Objects that were accepted",
            Product::Geopackage => "All lines and areas (GeoPackage)",
            Product::Report => "Report (HTML)",
        }
    }
}
