//! Position and heading of every side-scan ping, from one of four sources.

use super::{Survey, Track};
use crate::progress::{Cancelled, Progress};
use serde::{Deserialize, Serialize};

/// Where the heading comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeadingSource {
    /// `h_i = p_(i+1) - p_i` of the paper: consecutive recorded positions; zero steps give no heading.
    Steps,
    /// A straight line fitted to the fixes in a time window around the ping.
    TrackFit,
    /// The recorded course over ground.
    Cog,
    /// The recorded compass heading.
    Compass,
}

/// `heading.*` settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HeadingSettings {
    /// Where the heading comes from.
    pub source: HeadingSource,
    /// Width of the window that the line is fitted over, seconds (plus and minus half of it).
    pub window_s: f64,
}

impl Default for HeadingSettings {
    fn default() -> Self {
        Self {
            source: HeadingSource::TrackFit,
            window_s: 6.0,
        }
    }
}

/// The plane that the cloud is built in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Metres on the ground in the survey's local east-north frame.
    #[default]
    Enu,
    /// Spherical pseudo-Mercator metres relative to the first fix, as published: stretched by 1 / cos(latitude).
    Mercator,
}

/// Position and heading of one ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PingNav {
    /// Metres east of the survey's origin, in the chosen projection; NaN without any fix.
    pub east_m: f64,
    /// Metres north of the survey's origin, in the chosen projection; NaN without any fix.
    pub north_m: f64,
    /// Radians clockwise from north; NaN when there is none.
    pub heading_rad: f64,
    /// Speed over ground, metres a second; NaN when unknown.
    pub speed_mps: f64,
}

/// Position and heading of every side-scan ping ([`Survey::side_scan`]) and every sounding ([`Survey::soundings`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Navigation {
    /// One entry per side-scan ping.
    pub pings: Vec<PingNav>,
    /// One entry per sounding.
    pub soundings: Vec<PingNav>,
    /// The plane that the metres are in.
    pub projection: Projection,
    /// Pings without a heading.
    pub zero_heading: usize,
    /// Pings at which the boat moves (faster than 0.2 m/s by the fitted track).
    pub moving: usize,
}

impl Navigation {
    /// The WGS84 position of a place in this navigation's plane.
    pub fn to_lon_lat(&self, track: &Track, east_m: f64, north_m: f64) -> crate::geo::LonLat {
        match self.projection {
            Projection::Enu => track.frame.to_lon_lat(east_m, north_m),
            Projection::Mercator => {
                let [x0, y0] = crate::geo::web_mercator(track.frame.origin());
                crate::geo::web_mercator_inverse(x0 + east_m, y0 + north_m)
            }
        }
    }
}

/// Places every ping and sounding of the survey on the ground.
pub fn navigate(
    _survey: &Survey,
    _settings: &HeadingSettings,
    _projection: Projection,
    _progress: &Progress,
) -> Result<Navigation, Cancelled> {
    todo!()
}
