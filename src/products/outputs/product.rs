//! Products that `bathyscope process --products` chooses from.

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
    /// The differences between depths of different sources and passes.
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
        self.words().0
    }

    /// Returns the name for people.
    pub fn title(self) -> &'static str {
        self.words().1
    }

    /// Name and title.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Product::Cloud => ("cloud", "Point cloud"),
            Product::Track => ("track", "Track and coverage"),
            Product::Depth => ("depth", "Depth map (GeoTIFF)"),
            Product::Xyz => ("xyz", "Depth grid as text (XYZ)"),
            Product::Bottom => ("bottom", "Bottom for 3D programs"),
            Product::Isobaths => ("isobaths", "Isobaths, depth areas, volumes"),
            Product::MapTiles => ("map-tiles", "Depth map for plotters and the web"),
            Product::Mosaic => ("mosaic", "Side-scan mosaic (GeoTIFF)"),
            Product::Residuals => ("residuals", "Residuals"),
            Product::Targets => ("targets", "Objects that were accepted"),
            Product::Geopackage => ("geopackage", "All lines and areas (GeoPackage)"),
            Product::Report => ("report", "Report (HTML)"),
        }
    }
}
