//! What `bathyscope process --products` chooses from.

use serde::{Deserialize, Serialize};

/// A group of files that `bathyscope process --products` chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Product {
    /// cloud.laz, cloud.ply, cloud.xyz
    Cloud,
    /// track.gpx, .geojson, .kmz, .shp; footprint.geojson, .kmz
    Track,
    /// depth.tif, uncertainty.tif, distance.tif, each with its colours for QGIS (.qml)
    Depth,
    /// depth.xyz: a line of text for each cell
    Xyz,
    /// isobaths.geojson, .kmz, .shp; depth_areas.geojson, storage.csv
    Isobaths,
    /// mosaic.tif
    Mosaic,
    /// residuals.json
    Residuals,
    /// report.html, which shows what was made
    Report,
}

impl Product {
    /// All of them.
    pub const ALL: [Product; 8] = [
        Product::Cloud,
        Product::Track,
        Product::Depth,
        Product::Xyz,
        Product::Isobaths,
        Product::Mosaic,
        Product::Residuals,
        Product::Report,
    ];

    /// The name that `--products` knows, and the files.
    pub fn told(self) -> (String, String) {
        let value = clap::ValueEnum::to_possible_value(&self);
        let files = value.as_ref().and_then(|value| value.get_help());
        let files = files.map(ToString::to_string).unwrap_or_default();
        (
            value.map_or_else(String::new, |value| value.get_name().to_owned()),
            files,
        )
    }
}
