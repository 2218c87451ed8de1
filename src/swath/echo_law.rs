//! How strong the echo of a bed is that faces the boat more or less.
//!
//! The law assumed is that of Lambert for a bed that scatters `cos^2 t` at the angle `t` from its own normal, over the area
//! `1 / sin t` that a pulse covers of it: `f(t) = ln(cos^2 t / sin t)`. A law that is not the bed's is taken up by the curves over the
//! angle; only how it changes with slope counts.

/// Angles from the bed's normal that the law is taken at, radians: beyond them it would run away.
const ANGLES_RAD: [f64; 2] = [0.05, 1.5];
/// Greatest sensitivity that is believed, natural logarithm a radian.
const MOST_SENSITIVE: f64 = 8.0;

/// `f(t)`: natural logarithm of the power that a bed sends back at an angle from its normal, radians.
pub fn ln_power(angle_rad: f64) -> f64 {
    let t = angle_rad.clamp(ANGLES_RAD[0], ANGLES_RAD[1]);
    2.0 * t.cos().ln() - t.sin().ln()
}

/// `-f'(t) = 2 tan t + cot t`: what the logarithm gains for each radian that the bed turns towards the boat.
fn sensitivity(angle_rad: f64) -> f64 {
    let t = angle_rad.clamp(ANGLES_RAD[0], ANGLES_RAD[1]);
    (2.0 * t.tan() + 1.0 / t.tan()).clamp(0.0, MOST_SENSITIVE)
}

/// The law at a slope.
#[derive(Clone, Copy, Debug)]
pub struct AtSlope {
    /// Natural logarithm of the power over that of a level bed, `f(phi - beta) - f(phi)`.
    pub ln_over_level: f64,
    /// What the logarithm loses for each unit that the slope of depth outward grows, `S cos^2 beta`.
    pub per_slope: f64,
}

impl AtSlope {
    /// At an angle `phi` from straight down, radians, over a bed whose depth grows by `slope` metres a metre outward: `tan beta = -slope`.
    pub fn new(phi_rad: f64, slope: f64) -> Self {
        let beta_rad = (-slope).atan();
        let from_normal_rad = phi_rad - beta_rad;
        Self {
            ln_over_level: ln_power(from_normal_rad) - ln_power(phi_rad),
            per_slope: sensitivity(from_normal_rad) * beta_rad.cos().powi(2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sensitivity_is_what_a_small_slope_changes() {
        for phi_deg in [25.0_f64, 40.0, 50.0, 60.0] {
            for slope in [-0.3, 0.0, 0.2] {
                let phi_rad = phi_deg.to_radians();
                let step = 1e-5;
                let [less, more] =
                    [-step, step].map(|step| AtSlope::new(phi_rad, slope + step).ln_over_level);
                let found = -(more - less) / (2.0 * step);
                let expected = AtSlope::new(phi_rad, slope).per_slope;
                assert!(
                    (found - expected).abs() < 1e-4 * expected,
                    "{phi_deg} {slope}: {found} {expected}"
                );
            }
        }
    }
}
