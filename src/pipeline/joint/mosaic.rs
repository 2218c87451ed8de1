//! One mosaic of all logs.

use crate::geo::MapPlane;
use crate::mosaic::{Layout, MosaicLog, MosaicSettings, gain_table, match_levels};
use crate::pipeline::{ProcessedLog, mosaic_layout};
use crate::progress::{Cancelled, Progress};

/// The logs that have side-scan, laid out in the plane of a map, in the order of their recording, each normalised by itself and brought
/// to the levels of the others. Where they overlap, `mosaic.overlap` says what is shown: with `later` that is the later log.
///
/// # Errors
/// When the work was cancelled.
pub fn mosaic_logs(
    logs: &[ProcessedLog],
    map: &MapPlane,
    settings: &MosaicSettings,
    progress: &Progress,
) -> Result<Vec<MosaicLog>, Cancelled> {
    let lay_out = |log: &ProcessedLog| mosaic_layout(&log.survey, &log.products, map);
    mosaic_logs_by(logs, settings, lay_out, progress)
}

/// The same in the plane in which `lay_out` lays a log.
///
/// # Errors
/// When the work was cancelled.
pub fn mosaic_logs_by(
    logs: &[ProcessedLog],
    settings: &MosaicSettings,
    lay_out: impl Fn(&ProcessedLog) -> Layout,
    progress: &Progress,
) -> Result<Vec<MosaicLog>, Cancelled> {
    let mut in_time: Vec<&ProcessedLog> = logs
        .iter()
        .filter(|log| log.survey.has_side_scan())
        .collect();
    // A log that does not know the time stays where it is among the first.
    let start_s = |log: &ProcessedLog| log.survey.start_unix_s.unwrap_or(f64::NEG_INFINITY);
    in_time.sort_by(|a, b| start_s(a).total_cmp(&start_s(b)));
    let mut made = Vec::with_capacity(in_time.len());
    for log in in_time {
        let layout = lay_out(log);
        let gain = gain_table(&log.survey, &layout, progress)?;
        made.push(MosaicLog {
            survey: log.survey.clone(),
            layout,
            gain,
        });
    }
    match_levels(made, settings, progress)
}
