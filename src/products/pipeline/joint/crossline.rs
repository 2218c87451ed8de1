//! Compares the depths of one log or several where tracks cross themselves and each other; finds
//! the height offsets of several logs, and soundings of a log that other logs show to be false.

use crate::pipeline::{LogLatency, ProcessedLog};
use bathyscope_bottom::bathymetry::crosslines::{
    Crossing, LEAST_ANGLE_DEG, REACH_M, TrackDepth, crossings,
};
use bathyscope_bottom::bathymetry::height_offsets::{self as offsets, Datum, HeightOffsets};
use bathyscope_bottom::bathymetry::position_offsets::{
    CorrectedLog, FoundShift, Shift, Wanted, settled_offsets, shifted,
};
use bathyscope_bottom::bathymetry::{Contradiction, CrossingError, contradicted};
use bathyscope_bottom::cloud::{PointSource, Residuals};
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::ends;
use bathyscope_log::survey::{LogPart, PositionShift};
use serde::Serialize;

/// Residuals at the crossings of all tracks with themselves and each other: the later pass minus
/// the earlier, or the second log minus the first, as elevations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrosslineAnalysis {
    /// Residuals of all crossings.
    pub all: Residuals,
    /// Residuals of the crossings between two logs; `None` if there are none.
    pub between_logs: Option<Residuals>,
    /// Residuals of the crossings of each log with itself, its repeatability; `None` for a log that
    /// never crosses itself.
    pub within_logs: Vec<Option<Residuals>>,
}

/// Returns the depths under the boat of a log in time order, corrected as in its cloud: the kept
/// soundings. For a log without any, returns the depths of its first returns.
pub(crate) fn track_depths(log: &ProcessedLog) -> Vec<TrackDepth> {
    let survey = &log.survey;
    let kept = log.products.kept_points();
    let soundings = kept.filter(|point| point.source == PointSource::DownScan);
    let depths = soundings.filter_map(|point| {
        let time_s = survey.soundings.get(point.sounding()?)?.time_s;
        let [east_m, north_m, z_m] = point.place();
        Some(TrackDepth::new(time_s, [east_m, north_m], -z_m))
    });
    let depths: Vec<TrackDepth> = depths.filter(is_finite).collect();
    if !depths.is_empty() {
        return depths;
    }
    let pings = survey.side_scan.iter().zip(log.products.depths.iter());
    let placed = pings.zip(log.products.navigation.pings.iter());
    let depths = placed.map(|((ping, depth), at)| {
        TrackDepth::new(ping.time_s, at.place(), f64::from(depth.depth_m))
    });
    depths.filter(is_finite).collect()
}

fn is_finite(depth: &TrackDepth) -> bool {
    [depth.east_m, depth.north_m, depth.depth_m].iter().all(|value| value.is_finite())
}

/// Computes the error of a depth from the crossings of all tracks; `None` if there are none.
///
/// # Errors
/// When the work was cancelled.
pub(crate) fn crossing_error(
    logs: &[ProcessedLog],
    progress: &Progress,
) -> Result<Option<CrossingError>, Cancelled> {
    let tracks: Vec<Vec<TrackDepth>> = logs.iter().map(track_depths).collect();
    Ok(CrossingError::of(&crossings(&tracks, progress)?, &tracks))
}

/// Analyses the crossings of all tracks; `None` if none crosses another or itself.
///
/// # Errors
/// When the work was cancelled.
pub fn crossline_analysis(
    logs: &[ProcessedLog],
    progress: &Progress,
) -> Result<Option<CrosslineAnalysis>, Cancelled> {
    let tracks: Vec<Vec<TrackDepth>> = logs.iter().map(track_depths).collect();
    let found = crossings(&tracks, progress)?;
    let within_logs =
        (0..logs.len()).map(|log| crossing_residuals(&found, |tracks| tracks == [log, log]));
    Ok(crossing_residuals(&found, |_| true).map(|all| CrosslineAnalysis {
        all,
        between_logs: crossing_residuals(&found, |[a, b]| a != b),
        within_logs: within_logs.collect(),
    }))
}

/// Returns the residuals of the crossings between the tracks for which `of` is true; `None` without
/// any.
fn crossing_residuals(found: &[Crossing], of: impl Fn([usize; 2]) -> bool) -> Option<Residuals> {
    let chosen = found.iter().filter(|crossing| of(crossing.passes.map(|pass| pass.track)));
    Residuals::of(&mut chosen.map(Crossing::difference_m).collect::<Vec<f64>>())
}

/// Differences at the crossings, and their statistics.
#[derive(Serialize)]
pub struct Crosslines {
    sign: &'static str,
    least_angle_deg: f64,
    reach_m: f64,
    #[serde(flatten)]
    residuals: Residuals,
    /// Residuals of the crossings between two logs; absent for one log.
    #[serde(skip_serializing_if = "Option::is_none")]
    between_logs: Option<Residuals>,
    /// Latency of the positions of each log, in the order of the logs; `None` where the crossings
    /// do not determine it.
    pub(crate) latencies: Vec<Option<LogLatency>>,
    /// Crossings in the order of logs and time, at most [`MOST_LISTED`].
    list: Vec<Listed>,
}

#[derive(Serialize)]
struct Listed {
    /// Names of the logs of both passes; absent for one log.
    #[serde(skip_serializing_if = "Option::is_none")]
    logs: Option<[String; 2]>,
    lon: f64,
    lat: f64,
    time_s: [f64; 2],
    depth_m: [f64; 2],
    difference_m: f64,
    angle_deg: f64,
}

const SIGN: &str =
    "elevation of the later pass minus that of the earlier, metres; positive is shallower";
const SIGN_OF_LOGS: &str = "elevation of the later pass minus that of the earlier, or of the second log minus that of the first, metres; \
     positive is shallower";
/// Most crossings in the list.
const MOST_LISTED: usize = 10_000;

/// Finds the crossings of the tracks of some logs, which are in one local coordinate frame; `names`
/// are the names of the logs. `None` if no track crosses itself or another where depths are known.
///
/// # Errors
/// When the work was cancelled.
pub fn crosslines(
    logs: &[ProcessedLog],
    names: &[String],
    progress: &Progress,
) -> Result<Option<Crosslines>, Cancelled> {
    let tracks: Vec<Vec<TrackDepth>> = logs.iter().map(track_depths).collect();
    let found = crossings(&tracks, progress)?;
    let is_of_several = logs.len() > 1;
    let listed = |crossing: &Crossing| {
        let [east_m, north_m] = crossing.place;
        let tracks = crossing.passes.map(|pass| pass.track);
        let ProcessedLog { survey, products } = logs.get(tracks[0])?;
        let at = products.navigation.to_lon_lat(&survey.track, east_m, north_m);
        let name = |log: usize| names.get(log).cloned().unwrap_or_default();
        Some(Listed {
            logs: is_of_several.then(|| tracks.map(name)),
            lon: at.lon_deg,
            lat: at.lat_deg,
            time_s: crossing.passes.map(|pass| pass.time_s),
            depth_m: crossing.passes.map(|pass| pass.depth_m),
            difference_m: crossing.difference_m(),
            angle_deg: crossing.angle_deg,
        })
    };
    let of_logs = match logs {
        [log] => vec![log.products.latency],
        _ => latencies(logs, progress)?,
    };
    Ok(crossing_residuals(&found, |_| true).map(|all| Crosslines {
        sign: if is_of_several { SIGN_OF_LOGS } else { SIGN },
        least_angle_deg: LEAST_ANGLE_DEG,
        reach_m: REACH_M,
        residuals: all,
        between_logs: crossing_residuals(&found, |[a, b]| a != b),
        latencies: of_logs,
        list: found.iter().take(MOST_LISTED).filter_map(listed).collect(),
    }))
}

/// Errors of the positions of a log, derived from crossings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogPositions {
    /// Position shift and latency that should be in force.
    pub found: FoundShift,
    /// Position shift and latency that are in force by the log's settings.
    pub in_force: Shift,
}

/// Least difference from the value in force for a correction to be applied, in standard errors.
const TELLING_SIGMAS: f64 = 2.0;

impl LogPositions {
    /// Returns the position shift to be applied, metres; `None` if the shift in force may be right.
    pub fn told_shift(&self) -> Option<PositionShift> {
        let Shift { east_m, north_m, .. } = self.found.shift;
        let off_m = (east_m - self.in_force.east_m).hypot(north_m - self.in_force.north_m);
        (off_m > TELLING_SIGMAS * self.found.shift_error_m).then_some(PositionShift {
            east_m: in_hundredths(east_m),
            north_m: in_hundredths(north_m),
        })
    }

    /// Returns the latency to be applied, seconds; `None` if the latency in force may be right.
    pub fn told_latency_s(&self) -> Option<f64> {
        let latency_s = self.found.shift.latency_s;
        let off_s = (latency_s - self.in_force.latency_s).abs();
        let tells = off_s > TELLING_SIGMAS * self.found.latency_error_s;
        tells.then(|| in_hundredths(latency_s))
    }

    /// Returns true if crossings determine the latency of positions, even if it is 0.
    pub(crate) fn is_latency_known(&self) -> bool {
        self.found.latency_error_s < TOLD_S
    }
}

/// Rounds to centimetres, or hundredths of a second: the values are not known better.
fn in_hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0 + 0.0
}

/// Finds the errors of the positions of each log from all crossings of the tracks with themselves
/// and each other. The values replace the corrections in force, so that a second search after
/// applying them gives about the same. `None` if the equations have no solution.
///
/// # Errors
/// When the work was cancelled.
pub fn position_offsets(
    logs: &[ProcessedLog],
    wanted: Wanted,
    progress: &Progress,
) -> Result<Option<Vec<LogPositions>>, Cancelled> {
    let tracks: Vec<Vec<TrackDepth>> = logs.iter().map(track_depths).collect();
    let found = settled_offsets(&vec![CorrectedLog::default(); logs.len()], wanted, |placed| {
        let moved = tracks.iter().zip(placed);
        let moved: Vec<Vec<TrackDepth>> =
            moved.map(|(track, placed)| shifted(track, &placed.shift)).collect();
        crossings(&moved, progress)
    })?;
    let of_log = |(log, found): (&ProcessedLog, FoundShift)| {
        let settings = &log.products.settings;
        let PositionShift { east_m, north_m } = settings.position_shift;
        let in_force = Shift { east_m, north_m, latency_s: settings.mounting.latency_s };
        LogPositions {
            found: FoundShift { shift: found.shift.plus(in_force.values()), ..found },
            in_force,
        }
    };
    Ok(found.map(|found| logs.iter().zip(found).map(of_log).collect()))
}

/// Standard error of a latency below which crossings are taken to determine it, seconds: a larger
/// one is no better than the error assumed of any recorder.
const TOLD_S: f64 = 0.5;

/// Returns the latency of each log from the crossings of all tracks with themselves and each other;
/// `None` for a log whose crossings do not determine it.
///
/// # Errors
/// When the work was cancelled.
pub fn latencies(
    logs: &[ProcessedLog],
    progress: &Progress,
) -> Result<Vec<Option<LogLatency>>, Cancelled> {
    let wanted = Wanted { shifts: false, latencies: true };
    let Some(found) = position_offsets(logs, wanted, progress)? else {
        return Ok(vec![None; logs.len()]);
    };
    let of_log = |log: LogPositions| {
        log.is_latency_known().then_some(LogLatency {
            latency_s: log.found.shift.latency_s,
            standard_error_s: log.found.latency_error_s,
            in_force_s: log.in_force.latency_s,
        })
    };
    Ok(found.into_iter().map(of_log).collect())
}

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
