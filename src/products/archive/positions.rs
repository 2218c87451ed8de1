//! Computes corrections of position and latency of the logs of an archive, from crossings of tracks
//! within tiles.

use super::log_overlaps::OverlapSearch;
use super::log_record::LogRecord;
use super::offsets::{Offsets, as_written};
use super::record::{Archive, MOST_MOVED_M};
use crate::Error;
use bathyscope_bottom::bathymetry::crosslines::{Crossing, crossings};
use bathyscope_bottom::bathymetry::position_offsets::{
    CorrectedLog, FoundShift, Shift, Wanted, settled_offsets,
};
use bathyscope_log::support::progress::Progress;

/// Change below which a known correction is kept, metres to the east or north, and seconds: a log
/// that is added must not make every map stale.
const KEPT_SHIFT_M: f64 = 0.1;
const KEPT_LATENCY_S: f64 = 0.05;

/// Returns the corrections of the positions of the logs: those of the table and, as far as
/// `wanted`, those from crossings.
pub(super) fn shifts(
    archive: &Archive,
    logs: &[LogRecord],
    known: &Offsets,
    pinned: &[Option<f64>],
    wanted: Wanted,
    progress: &Progress,
) -> Result<Vec<FoundShift>, Error> {
    let found_before =
        |log: &LogRecord| known.row(&log.log).map_or(FoundShift::NONE, |row| row.found);
    let before: Vec<FoundShift> = logs.iter().map(found_before).collect();
    if !wanted.is_anything() {
        return Ok(before);
    }
    let relabelled = |mut crossing: Crossing, inside: &[usize]| {
        for pass in &mut crossing.passes {
            pass.track = inside[pass.track];
        }
        crossing
    };
    let placed = before
        .iter()
        .zip(pinned)
        .map(|(before, pinned_m)| CorrectedLog { shift: before.shift, pinned_m: *pinned_m });
    let placed: Vec<CorrectedLog> = placed.collect();
    let found = settled_offsets(&placed, wanted, |placed| {
        let shifts = placed.iter().map(|placed| placed.shift).collect();
        let search = OverlapSearch::new(archive, logs, shifts, wanted.latencies, progress);
        let mut found = search.in_tiles(
            |_| true,
            |tracks, inside| {
                let found = crossings(tracks, &Progress::new())?.into_iter();
                Ok(found.map(|crossing| relabelled(crossing, inside)).collect())
            },
            |crossing: &Crossing| crossing.place,
        )?;
        found.sort_by_key(|crossing| crossing.passes.map(|pass| pass.track));
        Ok::<_, Error>(found)
    })?;
    let mut found = found
        .ok_or_else(|| "the equations for the positions of the logs have no solution".to_owned())?;
    for (found, before) in found.iter_mut().zip(&before) {
        found.shift = kept_shift(before, as_written(found.shift));
        found.keep_errors_of(before);
    }
    Ok(found)
}

/// Returns a place with its correction, metres of the zone; the place moves by no more than
/// [`MOST_MOVED_M`], for which the halo has room.
pub(super) fn moved(place: [f64; 2], shift: Shift, velocity_mps: [f64; 2]) -> [f64; 2] {
    let [x, y] = shift.at(velocity_mps);
    let share = (MOST_MOVED_M / x.hypot(y).max(MOST_MOVED_M)).min(1.0);
    [place[0] + share * x, place[1] + share * y]
}

/// Returns the known correction of positions if the new one differs little from it, otherwise the
/// new one.
fn kept_shift(known: &FoundShift, found: Shift) -> Shift {
    let is_known = !(known.shift_error_m.is_nan() && known.latency_error_s.is_nan());
    let [east_m, north_m, latency_s] = known.shift.values();
    let moved_m = (found.east_m - east_m).abs().max((found.north_m - north_m).abs());
    let is_near = moved_m <= KEPT_SHIFT_M && (found.latency_s - latency_s).abs() <= KEPT_LATENCY_S;
    if is_known && is_near { known.shift } else { found }
}
