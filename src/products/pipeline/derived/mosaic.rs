//! Makes the side-scan mosaic of a survey: the echoes of every log are placed on the bottom,
//! normalised in gain and matched to the levels of the other logs.

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

/// Finest level of detail: its cells are 2 to this power metres, about the length of a recorder's
/// sample.
pub const FINEST: i8 = -6;
/// Number of levels of detail, each twice as coarse as the one before: the coarsest shows a
/// continent.
const LEVELS: usize = 32;
/// Share of a cell: a level leaves out pings where neither the boat nor the ends of its swath move
/// farther than this.
const THINNED: f64 = 0.7;

/// Plane of a mosaic.
#[derive(Clone, PartialEq)]
pub enum MosaicPlane {
    /// Plane of the survey, for the map on the screen.
    Survey,
    /// Plane of a map.
    Map(MapPlane),
}

/// Inputs of a mosaic: equal keys give equal mosaics.
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
    /// Creates the key from the results of some logs. The size of the cells and the colours are not
    /// in the key: they are chosen when the mosaic is drawn.
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

/// Mosaic of a survey, ready to be drawn at any scale.
pub struct Mosaic {
    /// Logs that have side-scan, in the order of their recording.
    pub logs: Vec<MosaicLog>,
    /// Settings with which the mosaic is drawn.
    pub settings: MosaicSettings,
    /// West, south, east and north of the mosaic, metres.
    pub bounds: Bounds,
    /// Layouts of each log with the pings that each level shows, computed when the level is first
    /// drawn.
    thinned: Vec<[OnceLock<MosaicLayout>; LEVELS]>,
}

impl Mosaic {
    /// Creates the mosaic of the logs that have side-scan: their echoes are placed in a plane in
    /// the order of the recording, normalised by the gain of each log and matched to the levels of
    /// the other logs. Where logs overlap, `mosaic.overlap` selects what is shown: with `later` the
    /// later log. `None` if the mosaic would be empty.
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
        // Logs without a start time are the first, in their given order.
        let start_s = |log: &ProcessedLog| log.survey.start_unix_s.unwrap_or(f64::NEG_INFINITY);
        in_time.sort_by(|a, b| start_s(a).total_cmp(&start_s(b)));
        let mut made = Vec::with_capacity(in_time.len());
        for log in in_time {
            let ProcessedLog { survey, products } = log;
            let layout = match plane {
                MosaicPlane::Survey => results.layout(log, progress)?,
                MosaicPlane::Map(map) => Arc::new(mosaic_layout(survey, products, map)),
            };
            // A log without side-scan known to be on the bottom is not shown.
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

    /// Returns the levels of all cells of a grid, row by row: 0 without an echo, else 1 to 255. A
    /// coarse grid needs less work: pings that make no difference in its cells are left out.
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

/// Returns the layout with the fewest pings that cells of this size need.
fn thinned_layout<'a>(
    log: &'a MosaicLog,
    thinned: &'a [OnceLock<MosaicLayout>; LEVELS],
    cell_m: f64,
) -> &'a MosaicLayout {
    let level = cell_m.log2().floor() - f64::from(FINEST);
    // Also if the size of the cell is 0 or NaN.
    if level.is_nan() || level < 0.0 {
        return &log.layout;
    }
    let slot = (level as usize).min(LEVELS - 1);
    let of_level_m = 2f64.powi(i32::from(FINEST) + slot as i32);
    thinned[slot].get_or_init(|| log.layout.thinned(THINNED * of_level_m))
}
