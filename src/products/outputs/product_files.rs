//! Describes the files of each product before they are written: their names in words, and estimates
//! of their sizes.

use super::order::{Product, When};
use super::registry::{OUTPUT_FILES, OutputFile};
use crate::pipeline::{DepthMap, ProcessedLog};
use bathyscope_log::survey::ChannelKind;
use clap::builder::PossibleValue;

/// The ending of a style for QGIS.
const STYLE: &str = ".qml";

impl Product {
    /// Lists the files of the product: `track/track.gpx, .geojson; track/footprint.geojson`.
    pub fn files(self) -> String {
        let rows = OUTPUT_FILES.iter();
        files_in_words(rows.filter(|row| row.when == When::Chosen(self)))
    }
}

/// Lists the names of some files: `track/track.gpx, .geojson; track/footprint.geojson`. The
/// companions of a shapefile are not listed.
pub fn files_in_words<'a>(rows: impl Iterator<Item = &'a OutputFile>) -> String {
    let with_colours = |row: &'a OutputFile| {
        let colours = row.companions.iter().filter(|name| name.ends_with(STYLE));
        std::iter::once(row.name).chain(colours.copied())
    };
    let (mut words, mut stem_before) = (String::new(), "");
    for name in rows.flat_map(with_colours) {
        let (stem, ending) = name.split_at(name.find('.').unwrap_or(name.len()));
        words += &match (words.is_empty(), stem == stem_before) {
            (true, _) => name.to_owned(),
            (false, true) => format!(", {ending}"),
            (false, false) => format!("; {name}"),
        };
        stem_before = stem;
    }
    if let Some(at) = words.rfind(STYLE) {
        words.insert_str(at + STYLE.len(), " (colours for QGIS)");
    }
    words
}

impl clap::ValueEnum for Product {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(self.files()))
    }
}

/// Quantities that the sizes of files are estimated from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Amounts {
    /// Number of points of the cloud.
    points: f64,
    /// Number of side-scan pings.
    pings: f64,
    /// Number of cells of the depth map with a depth.
    depth_cells: f64,
    /// Number of cells of the mosaic that a ping reaches.
    mosaic_cells: f64,
}

impl Amounts {
    /// Counts the quantities of some logs and of their depth map, where it has been computed
    /// already.
    pub fn of(logs: &[ProcessedLog], depth_map: Option<&DepthMap>) -> Self {
        let mut amounts = Self::default();
        for ProcessedLog { survey, products } in logs {
            amounts.points += products.cloud.points.len() as f64;
            amounts.pings += survey.side_scan.len() as f64;
            let across_m = survey.channels.iter().filter(|channel| {
                let kind = channel.kind;
                matches!(kind, ChannelKind::Port | ChannelKind::Starboard | ChannelKind::Composite)
            });
            let reach_m = across_m
                .filter_map(|channel| channel.range_m)
                .map(|(_, far_m)| f64::from(far_m))
                .fold(0.0, f64::max);
            let cell_m = products.settings.mosaic.cell_m;
            let places = products.navigation.pings.windows(2);
            let steps_m = places.map(|pair| {
                let [from, to] = [&pair[0], &pair[1]];
                (to.east_m - from.east_m).hypot(to.north_m - from.north_m)
            });
            let length_m: f64 = steps_m.filter(|step_m| step_m.is_finite()).sum();
            amounts.mosaic_cells += 2.0 * reach_m * length_m / (cell_m * cell_m);
        }
        let known = |map: &DepthMap| {
            let depths_m = map.surface.depth_m.iter();
            depths_m.filter(|depth_m| depth_m.is_finite()).count() as f64
        };
        amounts.depth_cells = depth_map.map_or(0.0, known);
        amounts
    }
}

/// Estimates the bytes of the files of a product, or (for `None`) of those that every run writes,
/// within a factor of two for surveys of a few lines. The coefficients are from the demo survey, a
/// Humminbird river log and an XTF log, written with the default settings.
pub fn about_bytes(product: Option<Product>, amounts: &Amounts) -> u64 {
    let [base, point, ping, depth_cell, mosaic_cell] = match product {
        None => [40e3, 80.0, 107.0, 0.0, 0.0],
        Some(product) => product.description().2,
    };
    let Amounts { points, pings, depth_cells, mosaic_cells } = amounts;
    (base + point * points + ping * pings + depth_cell * depth_cells + mosaic_cell * mosaic_cells)
        as u64
}
