//! Where the boat was: the fixes as recorded.

use crate::geo::{LocalFrame, LonLat};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// One recorded position with what came with it. Recorders repeat the last fix for many pings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Seconds after the log's time zero.
    pub time_s: f64,
    /// WGS84 position.
    pub position: LonLat,
    /// Course over ground, radians clockwise from north; NaN when not recorded.
    pub cog_rad: f32,
    /// Compass heading, radians clockwise from north; NaN when not recorded (no compass).
    pub compass_rad: f32,
    /// Speed over ground, metres a second; NaN when not recorded.
    pub speed_mps: f32,
}

/// The boat's track. Position between fixes, and heading, come from [`super::navigate`].
#[derive(Clone, Debug)]
pub struct Track {
    /// One entry per record that carries a position, repeats included, in time order.
    pub fixes: Vec<Fix>,
    /// Local frame with its origin at the first fix. All `east_m`, `north_m` of the survey are in it.
    pub frame: LocalFrame,
    /// Whose track it is, when it is not the recorder's.
    pub external: Option<ExternalTrack>,
}

/// A track that another receiver recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct ExternalTrack {
    /// The file that it was read from.
    pub path: PathBuf,
    /// What was added to its times, seconds.
    pub offset_s: f64,
    /// Times of its first and last fix, seconds of the log: beyond them the boat's place is not known.
    pub span_s: [f64; 2],
}

/// `track.*` settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackSettings {
    /// The track that lies over the recorder's, CSV or GPX.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Added to the times of an external track, seconds: how far its clock is behind that of the recorder.
    pub offset_s: f64,
}

impl Default for Track {
    /// A track without a fix.
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl Track {
    /// The recorder's track through `fixes`, which the caller has put in time order.
    pub fn new(fixes: Vec<Fix>) -> Self {
        let origin = fixes.first().map_or(
            LonLat {
                lon_deg: 0.0,
                lat_deg: 0.0,
            },
            |fix| fix.position,
        );
        Self {
            fixes,
            frame: LocalFrame::new(origin),
            external: None,
        }
    }
}
