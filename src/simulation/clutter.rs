//! Settings of what is mistaken for objects: ripples, pits, shoals of fish, clumps of weed.

use serde::{Deserialize, Serialize};

/// Ripples of sand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RippleSettings {
    /// Distance between crests, metres.
    pub wavelength_m: f64,
    /// Height of a crest above a trough, metres.
    pub height_m: f64,
    /// Direction across the crests, degrees clockwise from north.
    pub heading_deg: f64,
}

/// A round pit with a low rim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pit {
    /// Its centre, metres east.
    pub east_m: f64,
    /// Its centre, metres north.
    pub north_m: f64,
    /// Its radius without the rim, metres.
    pub radius_m: f64,
    /// Depth of its middle below the ground around, metres.
    pub depth_m: f64,
}

/// A round mound, or a hollow, without an edge: the ground rises by `height_m exp(-d^2 / (2
/// radius_m^2))` at the distance d.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mound {
    /// Its centre, metres east.
    pub east_m: f64,
    /// Its centre, metres north.
    pub north_m: f64,
    /// Distance from the centre at which it has 0.61 of its height and is steepest, metres.
    pub radius_m: f64,
    /// Height of its middle above the ground around, metres; below 0 for a hollow.
    pub height_m: f64,
}

/// A shoal of fish that keeps its place while the boat passes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shoal {
    /// Its centre, metres east.
    pub east_m: f64,
    /// Its centre, metres north.
    pub north_m: f64,
    /// Its centre, metres below the water surface.
    pub depth_m: f64,
    /// Radius that holds most of it, metres.
    pub radius_m: f64,
    /// Number of fish.
    pub count: u32,
    /// Strength of a fish over that of a level bottom's edge, dB.
    pub strength_db: f64,
}

/// A clump of water weed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeedClump {
    /// Its centre, metres east.
    pub east_m: f64,
    /// Its centre, metres north.
    pub north_m: f64,
    /// Its diameter, metres.
    pub diameter_m: f64,
}
