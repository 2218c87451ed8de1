//! The tiles of the side-scan mosaic.

use super::tiles::{MapTileKey, SIDE, TilePainter};
use super::transform::GroundBounds;
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::mosaic::{MosaicSettings, Overlap};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::{FINEST, Mosaic};
use egui::Color32;
use std::sync::Arc;

/// Note for the legend.
pub(super) fn note(settings: &MosaicSettings) -> &'static str {
    match settings.overlap {
        Overlap::Later => "mosaic: later\npass on top",
        Overlap::Brighter => "mosaic: brighter\npass on top",
        Overlap::Middle => "mosaic: middle\nof the swath on top",
        Overlap::Blend => "mosaic: passes\nblended",
    }
}

/// The tiles of a mosaic in its colours.
pub(super) struct MosaicTiles {
    mosaic: Arc<Mosaic>,
    /// Colour of every level of the echo.
    palette: [Color32; 256],
}

impl MosaicTiles {
    /// Creates the tiles of a mosaic in the plane of the survey, in the colours of `settings`.
    pub(super) fn new(mosaic: Arc<Mosaic>, settings: &MosaicSettings) -> Self {
        let colour = |level: usize| {
            let [r, g, b, a] = settings.colours.rgba(level as u8);
            Color32::from_rgba_unmultiplied(r, g, b, a)
        };
        Self { mosaic, palette: std::array::from_fn(colour) }
    }
}

impl TilePainter for MosaicTiles {
    fn bounds(&self) -> GroundBounds {
        self.mosaic.bounds
    }

    fn finest(&self) -> i8 {
        FINEST
    }

    fn paint(&self, key: MapTileKey, progress: &Progress) -> Option<Vec<Color32>> {
        let [west_m, north_m] = key.corner();
        let grid = Grid { west_m, north_m, cell_m: key.texel_m(), columns: SIDE, rows: SIDE };
        let levels = self.mosaic.levels(&grid, progress).ok()?;
        let seen = levels.iter().any(|level| *level > 0);
        seen.then(|| {
            let colour = |level: &u8| self.palette[usize::from(*level)];
            levels.iter().map(colour).collect()
        })
    }
}
