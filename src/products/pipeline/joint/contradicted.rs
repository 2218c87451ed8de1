//! Finds soundings of a log that other logs show to be false.

use super::track_depths;
use crate::pipeline::ProcessedLog;
use bathyscope_bottom::bathymetry::crosslines::TrackDepth;
use bathyscope_bottom::bathymetry::height_offsets::{self as offsets, Datum, HeightOffsets};
use bathyscope_bottom::bathymetry::{Contradiction, contradicted};
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::ends;
use bathyscope_log::survey::LogPart;
use serde::Serialize;

/// Stretch of soundings that other logs contradict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContradictedSoundings {
    /// Index of the log.
    pub log: usize,
    /// Number of soundings.
    pub count: usize,
    /// First and last time, seconds of the log.
    pub time_s: [f64; 2],
    /// Least and greatest depth, metres.
    pub depth_m: [f64; 2],
    /// Depths that contradict the soundings, the nearest one of each other log.
    pub against: Vec<Contradiction>,
}

impl ContradictedSoundings {
    /// Returns the part of the log that contains the soundings.
    pub fn part(&self) -> LogPart {
        LogPart::Time(self.time_s)
    }

    /// Returns the number and times of the soundings as text.
    pub(super) fn which(&self) -> String {
        let count = text::plural(self.count, "sounding", "soundings");
        match self.time_s.map(|time_s| format!("{time_s:.0} s")) {
            [from, to] if from == to => format!("{count} at {from}"),
            [from, to] => format!("{count} between {from} and {to}"),
        }
    }

    /// Returns a sentence with the soundings and the reason why they are false; `names` are the
    /// names of the logs.
    pub fn summary(&self, names: &[String]) -> String {
        let name = |log: usize| names.get(log).map_or("", String::as_str);
        let depths = match self.depth_m.map(|depth_m| format!("{depth_m:.2}")) {
            [least, most] if least == most => format!("{least} m"),
            [least, most] => format!("{least} to {most} m"),
        };
        let against = self.against.iter().map(|contradiction| {
            let [own_m, other_m] = contradiction.depths_m;
            format!(
                "{} has {other_m:.2} m, {:.1} m away from a sounding of {own_m:.2} m",
                name(contradiction.track),
                contradiction.apart_m
            )
        });
        format!(
            "{}: {} ({depths}), false by other logs: {}",
            name(self.log),
            self.which(),
            against.collect::<Vec<_>>().join("; ")
        )
    }
}

/// Comparison of the heights of several logs.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightComparison {
    /// Soundings that other logs show to be false, which are left out for the offsets.
    pub contradicted: Vec<ContradictedSoundings>,
    /// Height offset of every log (`height_offset_m`). It replaces the offset in force and does not
    /// depend on it, so that a second comparison after applying it gives the same offset.
    pub offsets: HeightOffsets,
}

/// Compares the heights of logs where their tracks meet.
///
/// # Errors
/// When the work was cancelled.
pub fn compare_heights(
    logs: &[ProcessedLog],
    datum: Datum,
    progress: &Progress,
) -> Result<HeightComparison, Cancelled> {
    let without_offset = |log: &ProcessedLog| {
        let in_force_m = log.products.correction.height_offset_m();
        let mut depths = track_depths(log);
        for depth in &mut depths {
            depth.depth_m += in_force_m;
        }
        depths
    };
    let mut tracks: Vec<Vec<TrackDepth>> = logs.iter().map(without_offset).collect();
    let mut offsets = offsets::height_offsets(&tracks, datum, progress)?;
    let contradicted = contradicted_soundings(logs, &tracks, &offsets, progress)?;
    if !contradicted.is_empty() {
        for soundings in &contradicted {
            let [from_s, to_s] = soundings.time_s;
            tracks[soundings.log].retain(|depth| !(from_s..=to_s).contains(&depth.time_s));
        }
        offsets = offsets::height_offsets(&tracks, datum, progress)?;
    }
    Ok(HeightComparison { contradicted, offsets })
}

/// Returns the soundings that other logs contradict after all logs are levelled. In a log with
/// side-scan, first returns judge the soundings; in a trusted stretch, the analyst does: these are
/// not examined.
fn contradicted_soundings(
    logs: &[ProcessedLog],
    tracks: &[Vec<TrackDepth>],
    offsets: &HeightOffsets,
    progress: &Progress,
) -> Result<Vec<ContradictedSoundings>, Cancelled> {
    if logs.iter().all(|log| log.survey.has_side_scan()) {
        return Ok(Vec::new());
    }
    let may_be_false = |log: usize, depths: &[TrackDepth]| {
        let ProcessedLog { survey, products } = &logs[log];
        let span_s = ends(depths.iter().map(|depth| depth.time_s));
        !survey.has_side_scan() && !products.settings.excluded.trusts(survey, span_s)
    };
    let levelled = |(track, offset): (&Vec<TrackDepth>, &offsets::LogOffset)| {
        let offset_m = if offset.is_determined() { offset.offset_m } else { 0.0 };
        let mut depths = track.clone();
        depths.iter_mut().for_each(|depth| depth.depth_m -= offset_m);
        depths
    };
    let levelled: Vec<Vec<TrackDepth>> = tracks.iter().zip(&offsets.logs).map(levelled).collect();
    let found = contradicted(&levelled, &may_be_false, progress)?;
    let of_log = found.into_iter().map(|stretch| {
        let depths = &tracks[stretch.track][stretch.depths];
        ContradictedSoundings {
            log: stretch.track,
            count: depths.len(),
            time_s: ends(depths.iter().map(|depth| depth.time_s)),
            depth_m: ends(depths.iter().map(|depth| depth.depth_m)),
            against: stretch.against,
        }
    });
    Ok(of_log.collect())
}
