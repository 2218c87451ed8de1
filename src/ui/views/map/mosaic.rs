//! The side-scan mosaic, painted in tiles as the export paints it: the same places, gain and order of passes.

use super::tiles::{SIDE, TileKey, TileSource};
use super::transform::GroundBounds;
use crate::app::ShownLog;
use crate::bathymetry::Grid;
use crate::calibration::Calibration;
use crate::first_return::FirstReturns;
use crate::mosaic::{Layout, MosaicLog, MosaicSettings, Overlap, joint_window};
use crate::pipeline::joint::mosaic_logs_by;
use crate::pipeline::{ProcessedLog, mosaic_layout_by};
use crate::progress::Progress;
use crate::survey::{LeftOut, Navigation, Survey};
use crate::pipeline::Same;
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
pub struct MosaicKey(Vec<LogKey>);

#[derive(Clone, PartialEq)]
struct LogKey {
    survey: Same<Survey>,
    navigation: Same<Navigation>,
    returns: Same<FirstReturns>,
    calibration: Same<Calibration>,
    left_out: Same<LeftOut>,
    range_factor: f64,
    settings: MosaicSettings,
}

impl MosaicKey {
    /// Of the last results of some logs. The cell of the file does not matter: tiles are as fine as the screen.
    pub fn of(logs: &[ShownLog]) -> Self {
        let fresh = MosaicSettings::default();
        let key = |shown: &ShownLog| {
            let ProcessedLog { survey, products } = &shown.log;
            LogKey {
                survey: Same(survey.clone()),
                navigation: Same(products.navigation.clone()),
                returns: Same(products.returns.clone()),
                calibration: Same(products.calibration.clone()),
                left_out: Same(products.left_out.clone()),
                range_factor: products.correction.range_factor(),
                settings: MosaicSettings {
                    cell_m: fresh.cell_m,
                    ..products.settings.mosaic.clone()
                },
            }
        };
        Self(logs.iter().map(key).collect())
    }
}

/// Lays the logs out and evens their gain; inner `None` where there is nothing to show, outer when cancelled.
pub fn source(logs: &[ShownLog], progress: &Progress) -> Option<Option<Arc<dyn TileSource>>> {
    let Some(first) = logs.first() else {
        return Some(None);
    };
    let settings = first.log.products.settings.mosaic.clone();
    let processed: Vec<ProcessedLog> = logs.iter().map(|shown| shown.log.clone()).collect();
    let lay_out = |log: &ProcessedLog| mosaic_layout_by(&log.survey, &log.products, |place| place);
    let laid_out = mosaic_logs_by(&processed, &settings, lay_out, progress).ok()?;
    let bounds = laid_out.iter().filter_map(|log| log.layout.bounds());
    let Some(bounds) = bounds.reduce(|[west, south, east, north], [w, s, e, n]| {
        [west.min(w), south.min(s), east.max(e), north.max(n)]
    }) else {
        return Some(None);
    };
    let thinnable = |log: MosaicLog| Thinned {
        log,
        layouts: std::array::from_fn(|_| OnceLock::new()),
    };
    Some(Some(Arc::new(MosaicTiles {
        logs: laid_out.into_iter().map(thinnable).collect(),
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

/// A log of the mosaic.
struct Thinned {
    log: MosaicLog,
    /// The layout with as many pings as a level shows, from the finest level; made when the level is first seen.
    layouts: [OnceLock<Layout>; LEVELS],
}

impl Thinned {
    fn layout(&self, slot: usize, texel_m: f64) -> &Layout {
        match self.layouts.get(slot) {
            Some(made) => made.get_or_init(|| self.log.layout.thinned(THINNED * texel_m)),
            None => &self.log.layout,
        }
    }
}

struct MosaicTiles {
    logs: Vec<Thinned>,
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
        let [west_m, north_m] = key.corner();
        let grid = Grid {
            west_m,
            north_m,
            cell_m: texel_m,
            columns: SIDE,
            rows: SIDE,
        };
        let logs = self.logs.iter();
        let logs = logs.map(|one| (&*one.log.survey, one.layout(slot, texel_m), &one.log.gain));
        let levels = joint_window(logs, &grid, &self.settings, progress).ok()?;
        let seen = levels.iter().any(|level| *level > 0);
        seen.then(|| {
            let colour = |level: &u8| self.palette[usize::from(*level)];
            levels.iter().map(colour).collect()
        })
    }
}
