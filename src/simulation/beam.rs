//! The side beam: its gain by direction, and the rays that stand for it.

use super::arithmetic::exp;
use super::scene::RecorderSettings;
use std::f64::consts::{FRAC_PI_2, LN_2};

/// The side beam in numbers that the rays need.
///
/// One way, its gain is `G = 2^-((phi - axis) / half width)^2`, with `phi` the angle from the
/// vertical.
pub(super) struct Beam {
    /// Angle of the axis from the vertical, radians.
    axis_rad: f64,
    half_width_rad: f64,
    /// Half-power width along the track, radians.
    pub azimuth_rad: f64,
    /// Distance along the track from the middle ray to an outer one, per metre of distance to the
    /// ground.
    spread: f64,
    /// Distances from the track of the points at which the ground is sampled, metres, from 0
    /// outward.
    pub steps_m: Vec<f64>,
}

/// First step, metres, and its growth per metre of distance.
const STEP_M: (f64, f64) = (0.012, 0.002);
/// Half-power width of a normal curve in standard deviations.
const HALF_POWER: f64 = 2.354_82;

impl Beam {
    /// Weights of the three rays along the track, with the nodes 0 and +-sqrt(3) standard
    /// deviations (Gauss-Hermite).
    pub(super) const RAY_WEIGHTS: [f64; 3] = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];

    /// The beam of a recorder that listens up to `range_m`.
    pub(super) fn new(recorder: &RecorderSettings, range_m: f64) -> Self {
        let azimuth_rad = recorder.beam_azimuth_deg.to_radians();
        let mut steps_m = vec![0.0];
        let mut at = 0.0;
        while at < range_m {
            at += STEP_M.0 + STEP_M.1 * at;
            steps_m.push(at);
        }
        Self {
            axis_rad: FRAC_PI_2 - recorder.beam_axis_deg.to_radians(),
            half_width_rad: 0.5 * recorder.beam_width_deg.to_radians(),
            azimuth_rad,
            spread: 3f64.sqrt() * azimuth_rad / HALF_POWER,
            steps_m,
        }
    }

    /// Two-way gain in a direction from the vertical.
    pub(super) fn two_way_gain(&self, phi_rad: f64) -> f64 {
        let off = (phi_rad - self.axis_rad) / self.half_width_rad;
        exp(-2.0 * LN_2 * off * off)
    }

    /// Standard deviation of the two-way beam along the track at a slant range, metres.
    pub(super) fn spread_at_m(&self, range_m: f64) -> f64 {
        self.azimuth_rad / HALF_POWER * range_m
    }

    /// Distance along the track between the middle and an outer ray where they meet the ground,
    /// metres.
    pub(super) fn outer_ray_m(&self, across_m: f64, depth_m: f64) -> f64 {
        self.spread * (across_m * across_m + depth_m * depth_m).sqrt()
    }
}
