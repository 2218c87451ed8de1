//! Analyses crosslines: compares depths where tracks cross themselves and each other.

use crate::pipeline::joint::{crossing_residuals, latencies, track_depths};
use crate::pipeline::{LogLatency, ProcessedLog};
use bathyscope_bottom::bathymetry::crosslines::{
    Crossing, LEAST_ANGLE_DEG, REACH_M, TrackDepth, crossings,
};
use bathyscope_bottom::cloud::Residuals;
use bathyscope_log::support::progress::{Cancelled, Progress};
use serde::Serialize;

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
    /// Latency of the positions of each log, in the order of the logs; null where the crossings do
    /// not determine it.
    latencies: Vec<Option<LogLatency>>,
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

impl Crosslines {
    /// Returns the latency of the positions of each log; `None` where the crossings do not
    /// determine it.
    pub fn latencies(&self) -> &[Option<LogLatency>] {
        &self.latencies
    }
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
