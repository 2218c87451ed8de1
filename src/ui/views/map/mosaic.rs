//! The side-scan mosaic, painted in tiles as the export paints it: the same places, gain and order of passes.

use super::tiles::{SIDE, TileKey, TileSource};
use super::transform::GroundBounds;
use crate::bathymetry::Grid;
use crate::calibration::Calibration;
use crate::first_return::FirstReturns;
use crate::mosaic::{GainTable, Layout, MosaicSettings, Overlap, gain_table, window};
use crate::pipeline::Products;
use crate::progress::Progress;
use crate::survey::{Navigation, Survey};
use crate::ui::views::background::Same;
use egui::Color32;
use std::sync::{Arc, OnceLock};

/// The finest level worth painting, 2 to this in metres: recorders' samples are about as long.
const FINEST: i8 = -6;
/// Levels from the finest to what shows a continent.
const LEVELS: usize = 32;
/// Pings are left out where neither the boat nor the ends of its swath move farther than this share of a texel.
const THINNED: f64 = 0.7;

/// What the tiles of a mosaic are made of.
#[derive(Clone, PartialEq)]
pub struct MosaicKey {
    survey: Same<Survey>,
    navigation: Same<Navigation>,
    returns: Same<FirstReturns>,
    calibration: Same<Calibration>,
    range_factor: f64,
    settings: MosaicSettings,
}

impl MosaicKey {
    /// Of the last results. The cell of the file does not matter: tiles are as fine as the screen.
    pub fn of(survey: &Arc<Survey>, products: &Products) -> Self {
        let fresh = MosaicSettings::default();
        Self {
            survey: Same(survey.clone()),
            navigation: Same(products.navigation.clone()),
            returns: Same(products.returns.clone()),
            calibration: Same(products.calibration.clone()),
            range_factor: products.correction.range_factor(),
            settings: MosaicSettings {
                cell_m: fresh.cell_m,
                ..products.settings.mosaic.clone()
            },
        }
    }
}

/// Lays the survey out and evens its gain; inner `None` where there is nothing to show, outer when cancelled.
pub fn source(
    survey: &Arc<Survey>,
    products: &Products,
    progress: &Progress,
) -> Option<Option<Arc<dyn TileSource>>> {
    let settings = products.settings.mosaic.clone();
    let layout = Layout::new(
        survey,
        &products.navigation,
        &products.returns,
        &products.calibration,
        &settings,
        |place| place,
    )
    .with_range_factor(products.correction.range_factor())
    .without(&products.left_out);
    let Some(bounds) = layout.bounds() else {
        return Some(None);
    };
    let gain = gain_table(survey, &layout, progress).ok()?;
    Some(Some(Arc::new(MosaicTiles {
        survey: survey.clone(),
        layout,
        thinned: std::array::from_fn(|_| OnceLock::new()),
        gain,
        palette: std::array::from_fn(|level| {
            let [r, g, b, a] = settings.colours.rgba(level as u8);
            Color32::from_rgba_unmultiplied(r, g, b, a)
        }),
        settings,
        bounds,
    })))
}

/// What the legend says.
pub fn note(settings: &MosaicSettings) -> &'static str {
    match settings.overlap {
        Overlap::Later => "mosaic: later\npass on top",
        Overlap::Brighter => "mosaic: brighter\npass on top",
        Overlap::Middle => "mosaic: middle\nof the swath on top",
        Overlap::Blend => "mosaic: passes\nblended",
    }
}

struct MosaicTiles {
    survey: Arc<Survey>,
    layout: Layout,
    /// The layout with as many pings as a level shows, from the finest level; made when the level is first seen.
    thinned: [OnceLock<Layout>; LEVELS],
    gain: GainTable,
    settings: MosaicSettings,
    /// Colour of every level of the echo.
    palette: [Color32; 256],
    bounds: GroundBounds,
}

impl TileSource for MosaicTiles {
    fn bounds(&self) -> GroundBounds {
        self.bounds
    }

    fn finest(&self) -> i8 {
        FINEST
    }

    fn paint(&self, key: TileKey, progress: &Progress) -> Option<Vec<Color32>> {
        let texel_m = key.texel_m();
        let slot = usize::try_from(key.level - FINEST).unwrap_or(0);
        let layout = match self.thinned.get(slot) {
            Some(made) => made.get_or_init(|| self.layout.thinned(THINNED * texel_m)),
            None => &self.layout,
        };
        let [west_m, north_m] = key.corner();
        let grid = Grid {
            west_m,
            north_m,
            cell_m: texel_m,
            columns: SIDE,
            rows: SIDE,
        };
        let levels = window(
            &self.survey,
            layout,
            &grid,
            &self.gain,
            &self.settings,
            progress,
        )
        .ok()?;
        let seen = levels.iter().any(|level| *level > 0);
        seen.then(|| {
            let colour = |level: &u8| self.palette[usize::from(*level)];
            levels.iter().map(colour).collect()
        })
    }
}
