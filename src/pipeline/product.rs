//! What `bathyscope process --products` chooses from.

/// A group of files that `bathyscope process --products` chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Product {
    /// cloud.laz, cloud.ply, cloud.xyz
    Cloud,
    /// track.gpx, .geojson, .kmz, .shp; footprint.geojson, .kmz
    Track,
    /// depth.tif, uncertainty.tif, distance.tif
    Depth,
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
    pub const ALL: [Product; 7] = [
        Product::Cloud,
        Product::Track,
        Product::Depth,
        Product::Isobaths,
        Product::Mosaic,
        Product::Residuals,
        Product::Report,
    ];
}
