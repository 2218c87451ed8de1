//! The side-scan mosaic of a survey: every log laid out, its gain normalised and brought to that of
//! the others.

use super::Derived;
use super::side_scan::SideScanKey;
use crate::pipeline::{ProcessedLog, Same, mosaic_layout};
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::mosaic::{
    Bounds, GainTable, MosaicLayout, MosaicLog, MosaicSettings, joint_bounds, joint_window,
    match_levels,
};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Relief;
use std::sync::{Arc, OnceLock};

/// The finest level of detail worth drawing, 2 to this in metres: recorders' samples are about as
/// long.
pub const FINEST: i8 = -6;
/// Levels of detail, each twice as coarse as the one before, from the finest to what shows a
/// continent.
const LEVELS: usize = 32;
/// Pings are left out of a level where neither the boat nor the ends of its swath move farther than
/// this share of a cell.
const THINNED: f64 = 0.7;

/// The plane that a mosaic is laid out in.
#[derive(Clone, PartialEq)]
pub enum MosaicPlane {
    /// Plane of the survey, which the map on the screen uses.
    Survey,
    /// Plane of a map.
    Map(MapPlane),
}

/// Inputs of a mosaic; equal keys give equal mosaics.
#[derive(Clone, PartialEq)]
pub struct MosaicKey {
    plane: MosaicPlane,
    logs: Vec<MosaicLogKey>,
}

#[derive(Clone, PartialEq)]
struct MosaicLogKey {
    side_scan: SideScanKey,
    relief: Same<Relief>,
    settings: MosaicSettings,
}

impl MosaicKey {
    /// Creates the key from the results of some logs. Cells and colours do not matter: they are
    /// chosen when the mosaic is drawn.
    pub fn of(logs: &[ProcessedLog], plane: MosaicPlane) -> Self {
        let MosaicSettings { cell_m, colours, .. } = MosaicSettings::default();
        let key = |log: &ProcessedLog| MosaicLogKey {
            side_scan: SideScanKey::of(log),
            relief: Same(log.products.relief.clone()),
            settings: MosaicSettings { cell_m, colours, ..log.products.settings.mosaic.clone() },
        };
        Self { plane, logs: logs.iter().map(key).collect() }
    }
}

/// The mosaic of a survey, ready to be drawn at any scale.
pub struct Mosaic {
    /// The logs that have side-scan, in the order of their recording.
    pub logs: Vec<MosaicLog>,
    /// Settings that the mosaic is drawn with.
    pub settings: MosaicSettings,
    /// West, south, east and north of what is shown, metres.
    pub bounds: Bounds,
    /// Layouts of each log with as many pings as a level shows, made when the level is first drawn.
    thinned: Vec<[OnceLock<MosaicLayout>; LEVELS]>,
}

impl Mosaic {
    /// The logs that have side-scan, laid out in a plane in the order of their recording, each
    /// normalised by its own gain and brought to the levels of the others. Where they overlap,
    /// `mosaic.overlap` says what is shown: with `later` that is the later log. `None` where
    /// nothing is shown.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        logs: &[ProcessedLog],
        plane: &MosaicPlane,
        results: &Derived,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let Some(first) = logs.first() else {
            return Ok(None);
        };
        let settings = first.products.settings.mosaic.clone();
        let mut in_time: Vec<&ProcessedLog> = logs.iter().collect();
        in_time.retain(|log| log.survey.has_side_scan());
        // A log that does not know the time stays where it is among the first.
        let start_s = |log: &ProcessedLog| log.survey.start_unix_s.unwrap_or(f64::NEG_INFINITY);
        in_time.sort_by(|a, b| start_s(a).total_cmp(&start_s(b)));
        let mut made = Vec::with_capacity(in_time.len());
        for log in in_time {
            let ProcessedLog { survey, products } = log;
            let layout = match plane {
                MosaicPlane::Survey => results.layout(log, progress)?,
                MosaicPlane::Map(map) => Arc::new(mosaic_layout(survey, products, map)),
            };
            // A log of which nothing is known to lie on the ground shows nothing.
            if let Some(gain) = results.gain(log, progress)? {
                made.push(MosaicLog {
                    survey: survey.clone(),
                    layout,
                    gain: GainTable::clone(&gain),
                });
            }
        }
        let logs = match_levels(made, &settings, progress)?;
        let bounds = joint_bounds(&logs);
        Ok(bounds.map(|bounds| Self {
            thinned: logs.iter().map(|_| [const { OnceLock::new() }; LEVELS]).collect(),
            logs,
            settings,
            bounds,
        }))
    }

    /// Levels of all cells of a grid, row by row: 0 where nothing was seen, else 1 to 255. A coarse
    /// grid costs what it shows.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn levels(&self, grid: &Grid, progress: &Progress) -> Result<Vec<u8>, Cancelled> {
        let logs = self.logs.iter().zip(&self.thinned);
        let logs = logs.map(|(log, thinned)| {
            let layout = thinned_layout(log, thinned, grid.cell_m);
            (&*log.survey, layout, &log.gain)
        });
        joint_window(logs, grid, &self.settings, progress)
    }
}

/// The layout that shows all that cells of a size can show.
fn thinned_layout<'a>(
    log: &'a MosaicLog,
    thinned: &'a [OnceLock<MosaicLayout>; LEVELS],
    cell_m: f64,
) -> &'a MosaicLayout {
    let level = cell_m.log2().floor() - f64::from(FINEST);
    // Also where a cell has no size.
    if level.is_nan() || level < 0.0 {
        return &log.layout;
    }
    let slot = (level as usize).min(LEVELS - 1);
    let of_level_m = 2f64.powi(i32::from(FINEST) + slot as i32);
    thinned[slot].get_or_init(|| log.layout.thinned(THINNED * of_level_m))
}
