//! Predicts the level of a sample from the echo of a bed of given depth, slope and brightness, and
//! from the noise under the recorder's gain.
//!
//! The model is `ln P = ln(echo + noise)` with `ln echo = beam(phi) + f(t) + h ln(r / r0) +
//! brightness + gain`, where `phi` is the angle from straight down, `t = phi + atan(slope)` that
//! from the bed's normal and `f(t) = ln(cos^2 t / sin t)`: Lambert's law over the area that a pulse
//! covers; and `ln noise = n + m ln(r / r0) + b (r / r0 - 1)`: a floor that the gain raises with
//! range. The curve of the beam also corrects errors of the law.

use crate::sparse::solve_dense;
use bathyscope_log::support::statistics::{quantile, sorted};
use faer::Mat;

/// Angles from straight down at which the curve of the beam has a value, degrees: every 5 from 15
/// to 90.
const KNOTS: usize = 16;
const FIRST_KNOT_DEG: f64 = 15.0;
const KNOT_DEG: f64 = 5.0;
/// Number of parameters of the curves: values of the beam; the slope over range; level, slope and
/// bend of the noise; and the excess brightness of starboard, constant and by angle.
pub(super) const PARAMETERS: usize = KNOTS + 6;
const RANGE: usize = KNOTS;
const NOISE: usize = KNOTS + 1;
const NOISE_SLOPE: usize = KNOTS + 2;
const NOISE_BEND: usize = KNOTS + 3;
const SIDE: usize = KNOTS + 4;
const TILT: usize = KNOTS + 5;
/// Reference range of the curves, metres.
const REFERENCE_M: f64 = 6.0;
/// Angle at which a tilt is 0, and unit of the angle from it, degrees.
const TILT_DEG: [f64; 2] = [45.0, 15.0];
/// Bounds of the angle from the bed's normal in the law, radians: beyond these the law diverges.
const LAW_RAD: [f64; 2] = [0.05, 1.52];
/// Standard deviations of the second differences of the beam and of the slope over range; then
/// means and standard deviations of slope and bend of the noise, for a floor under a gain of 30 log
/// r with a little absorption.
const SD_BEAM_BEND: f64 = 0.12;
const SD_RANGE: f64 = 0.3;
const NOISE_PRIOR: [(usize, f64, f64); 2] = [(NOISE_SLOPE, 3.0, 0.5), (NOISE_BEND, 0.3, 0.15)];
/// Standard deviations of the excess brightness of starboard, and of its tilt.
const SD_SIDE: f64 = 0.5;
const SD_TILT: f64 = 0.3;

/// Standard deviation of the difference of the curves of one transducer between range settings.
const SD_TIE: f64 = 0.03;

/// Range and angle of a sample, and slope of the bed at its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Incidence {
    /// Slant range, metres.
    pub range_m: f64,
    /// Angle from straight down, radians.
    pub phi_rad: f64,
    /// Growth of the depth outward, metres for each metre.
    pub slope: f64,
    /// Side of the boat: -1 is port, 1 is starboard.
    pub side: f64,
}

/// Expected level of a sample, and its derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    /// Expected natural logarithm of power.
    pub ln_power: f64,
    /// Share of the echo in the power.
    pub share: f64,
    /// Change of the level for a unit of slope.
    pub per_slope: f64,
    /// Change of the level for a metre of depth at the same range.
    pub per_depth: f64,
}

/// Curves of one recorder at one range setting.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LawCurves(pub [f64; PARAMETERS]);

/// Returns `f(t)`, Lambert's law.
fn lambert(angle_rad: f64) -> f64 {
    let (sin, cos) = angle_rad.clamp(LAW_RAD[0], LAW_RAD[1]).sin_cos();
    (cos * cos / sin).ln()
}

/// Returns `f'(t)`; 0 beyond the bounds of the law.
fn lambert_slope(angle_rad: f64) -> f64 {
    if angle_rad > LAW_RAD[0] && angle_rad < LAW_RAD[1] {
        -2.0 * angle_rad.tan() - 1.0 / angle_rad.tan()
    } else {
        0.0
    }
}

/// Returns the knot before an angle, and the share of the next knot.
fn knot(phi_rad: f64) -> (usize, f64) {
    let at = (phi_rad.to_degrees() - FIRST_KNOT_DEG) / KNOT_DEG;
    let at = at.clamp(0.0, KNOTS as f64 - 1.001);
    (at as usize, at.fract())
}

fn tilt(incidence: &Incidence) -> f64 {
    incidence.side * (incidence.phi_rad.to_degrees() - TILT_DEG[0]) / TILT_DEG[1]
}

impl LawCurves {
    /// Returns the expected level of a sample over a bed that is brighter by `brightness`.
    pub(super) fn expected(&self, at: &Incidence, brightness: f64) -> Expected {
        let Self(c) = self;
        let (below, share) = knot(at.phi_rad);
        let beam = c[below] + share * (c[below + 1] - c[below]);
        let ln_range = (at.range_m / REFERENCE_M).ln();
        let from_normal_rad = at.phi_rad + at.slope.atan();
        let echo = beam
            + lambert(from_normal_rad)
            + c[RANGE] * ln_range
            + at.side * c[SIDE]
            + tilt(at) * c[TILT]
            + brightness;
        let noise =
            c[NOISE] + c[NOISE_SLOPE] * ln_range + c[NOISE_BEND] * (at.range_m / REFERENCE_M - 1.0);
        let most = echo.max(noise);
        let ln_power = most + ((echo - most).exp() + (noise - most).exp()).ln();
        let share = (echo - ln_power).exp();
        let of_law = lambert_slope(from_normal_rad);
        let of_beam = (c[below + 1] - c[below]) / KNOT_DEG.to_radians();
        let of_tilt = at.side * c[TILT] / TILT_DEG[1].to_radians();
        Expected {
            ln_power,
            share,
            per_slope: share * of_law / (1.0 + at.slope * at.slope),
            // cos phi = depth / range.
            per_depth: -share * (of_law + of_beam + of_tilt)
                / (at.range_m * at.phi_rad.sin()).max(0.1),
        }
    }

    /// Adds the derivatives of the level of a sample by each parameter to `sums`; `share` is the
    /// share of the echo in the power.
    pub(super) fn add_derivatives(at: &Incidence, share: f64, sums: &mut [f64; PARAMETERS]) {
        let (below, right) = knot(at.phi_rad);
        let ln_range = (at.range_m / REFERENCE_M).ln();
        sums[below] += share * (1.0 - right);
        sums[below + 1] += share * right;
        sums[RANGE] += share * ln_range;
        sums[NOISE] += 1.0 - share;
        sums[NOISE_SLOPE] += (1.0 - share) * ln_range;
        sums[NOISE_BEND] += (1.0 - share) * (at.range_m / REFERENCE_M - 1.0);
        sums[SIDE] += share * at.side;
        sums[TILT] += share * tilt(at);
    }

    /// Adds the prior knowledge of the parameters to a system of normal equations for a step of
    /// them.
    pub(super) fn add_prior(
        &self,
        normal: &mut Mat<f64>,
        right: &mut [f64],
        first: usize,
        looseness: f64,
    ) {
        let mut add = |terms: &[(usize, f64)], goal: f64, sd: f64| {
            let weight = 1.0 / (sd * sd);
            let now: f64 = terms.iter().map(|(at, factor)| factor * self.0[*at]).sum();
            for (row, factor) in terms {
                right[first + row] += weight * factor * (goal - now);
                for (column, other) in terms {
                    normal[(first + row, first + column)] += weight * factor * other;
                }
            }
        };
        for middle in 1..KNOTS - 1 {
            add(&[(middle - 1, 1.0), (middle, -2.0), (middle + 1, 1.0)], 0.0, SD_BEAM_BEND);
        }
        add(&[(RANGE, 1.0)], 0.0, SD_RANGE);
        for (parameter, usual, sd) in NOISE_PRIOR {
            add(&[(parameter, 1.0)], usual, looseness * sd);
        }
        add(&[(SIDE, 1.0)], 0.0, SD_SIDE);
        add(&[(TILT, 1.0)], 0.0, SD_TILT);
    }

    /// Adds to a system of normal equations that two sets of curves are of one transducer: the beam
    /// has the same shape, and starboard the same excess brightness.
    pub(super) fn add_tie(
        one: (&Self, usize),
        other: (&Self, usize),
        normal: &mut Mat<f64>,
        right: &mut [f64],
    ) {
        let mut add = |terms: &[(usize, f64)]| {
            let weight = 1.0 / (SD_TIE * SD_TIE);
            let at = |(curves, first): (&Self, usize), sign: f64| {
                let terms = terms.iter();
                terms
                    .map(|(at, factor)| (first + at, sign * factor, curves.0[*at]))
                    .collect::<Vec<_>>()
            };
            let all = [at(one, 1.0), at(other, -1.0)].concat();
            let now: f64 = all.iter().map(|(_, factor, value)| factor * value).sum();
            for (row, factor, _) in &all {
                right[*row] -= weight * factor * now;
                for (column, other, _) in &all {
                    normal[(*row, *column)] += weight * factor * other;
                }
            }
        };
        for knot in 1..KNOTS {
            add(&[(knot, 1.0), (knot - 1, -1.0)]);
        }
        for parameter in [RANGE, SIDE, TILT] {
            add(&[(parameter, 1.0)]);
        }
    }

    /// Returns the curves after a step of their parameters.
    #[must_use]
    pub(super) fn stepped(&self, step: &[f64]) -> Self {
        Self(std::array::from_fn(|at| self.0[at] + step[at]))
    }

    /// Fits curves to the mean levels of some places with many samples, by a damped Gauss-Newton
    /// method with robust weights; `None` without places or a solution.
    pub(super) fn fit(places: &[FitPlace]) -> Option<Self> {
        let levels = sorted(places.iter().map(|place| place.ln_power));
        let at = |share: f64| Some(quantile(&levels, share));
        let mut curves = Self(std::array::from_fn(|_| 0.0));
        curves.0[..KNOTS].fill(at(0.5).filter(|_| !levels.is_empty())?);
        curves.0[NOISE] = at(0.05)?;
        for (parameter, usual, _) in NOISE_PRIOR {
            curves.0[parameter] = usual;
        }
        let mut damping = 1.0;
        let mut cost = curves.cost(places);
        for _ in 0..FIT_STEPS {
            let mut step = curves.fit_step(places, damping)?;
            for step in &mut step {
                *step = step.clamp(-MOST_FIT_STEP, MOST_FIT_STEP);
            }
            let tried = curves.stepped(&step);
            let tried_cost = tried.cost(places);
            if tried_cost < cost {
                let gain = 1.0 - tried_cost / cost;
                (curves, cost) = (tried, tried_cost);
                damping *= 0.3;
                if gain < 1e-5 {
                    break;
                }
            } else {
                damping *= 10.0;
            }
        }
        Some(curves)
    }

    fn cost(&self, places: &[FitPlace]) -> f64 {
        let of_place = |place: &FitPlace| {
            let over = (place.ln_power - self.expected(&place.at, 0.0).ln_power) / place.sd;
            2.0 * ((1.0 + (over / SOFT).powi(2)).sqrt() - 1.0) * SOFT * SOFT
        };
        places.iter().map(of_place).sum::<f64>()
    }

    fn fit_step(&self, places: &[FitPlace], damping: f64) -> Option<Vec<f64>> {
        let mut normal = Mat::<f64>::zeros(PARAMETERS, PARAMETERS);
        let mut right = vec![0.0; PARAMETERS];
        for place in places {
            let expected = self.expected(&place.at, 0.0);
            let over = place.ln_power - expected.ln_power;
            let robust = 1.0 / (1.0 + (over / place.sd / SOFT).powi(2)).sqrt();
            let weight = robust / (place.sd * place.sd);
            let mut derivatives = [0.0; PARAMETERS];
            Self::add_derivatives(&place.at, expected.share, &mut derivatives);
            for (row, by) in derivatives.iter().enumerate().filter(|(_, by)| **by != 0.0) {
                right[row] += weight * by * over;
                for (column, other) in derivatives.iter().enumerate() {
                    normal[(row, column)] += weight * by * other;
                }
            }
        }
        self.add_prior(&mut normal, &mut right, 0, FIT_LOOSENESS);
        for at in 0..PARAMETERS {
            normal[(at, at)] += damping * (normal[(at, at)] * 1e-2 + 1e-3);
        }
        solve_dense(&normal, &right)
    }
}

/// Largest number of steps of a fit, and largest change of a parameter in a step.
const FIT_STEPS: usize = 60;
const MOST_FIT_STEP: f64 = 2.0;
/// Misfit above which the weight of observations falls, in standard deviations.
const SOFT: f64 = 2.0;
/// Factor on the standard deviations of the noise prior in the first fit.
const FIT_LOOSENESS: f64 = 4.0;

/// Mean level of many samples at about the same range and angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct FitPlace {
    /// Mean range, angle and slope of the samples.
    pub at: Incidence,
    /// Mean logarithm of power of the samples.
    pub ln_power: f64,
    /// Standard deviation of the mean.
    pub sd: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curves() -> LawCurves {
        let beam = |knot: usize| 1.0 - 0.02 * (knot as f64 - 6.0).powi(2);
        let others = [0.2, -3.0, 3.0, 0.3, 0.1, -0.05];
        LawCurves(std::array::from_fn(|at| match at.checked_sub(KNOTS) {
            None => beam(at),
            Some(other) => others[other],
        }))
    }

    fn at(depth_m: f64, range_m: f64, slope: f64) -> Incidence {
        Incidence { range_m, phi_rad: (depth_m / range_m).acos(), slope, side: 1.0 }
    }

    #[test]
    fn derivatives_are_what_small_changes_change() {
        let curves = curves();
        for (depth_m, range_m, slope) in [(2.0, 3.0, 0.1), (2.0, 7.0, -0.2), (3.0, 4.2, 0.0)] {
            let here = curves.expected(&at(depth_m, range_m, slope), 0.3);
            let level =
                |depth_m, slope| curves.expected(&at(depth_m, range_m, slope), 0.3).ln_power;
            let step = 1e-6;
            let per_slope =
                (level(depth_m, slope + step) - level(depth_m, slope - step)) / (2.0 * step);
            let per_depth =
                (level(depth_m + step, slope) - level(depth_m - step, slope)) / (2.0 * step);
            assert!((here.per_slope - per_slope).abs() < 1e-5, "{per_slope} {here:?}");
            assert!((here.per_depth - per_depth).abs() < 1e-5, "{per_depth} {here:?}");
            let mut derivatives = [0.0; PARAMETERS];
            LawCurves::add_derivatives(&at(depth_m, range_m, slope), here.share, &mut derivatives);
            for (parameter, expected) in derivatives.into_iter().enumerate() {
                let mut step_on = [0.0; PARAMETERS];
                step_on[parameter] = step;
                let moved = curves.stepped(&step_on);
                let found = (moved.expected(&at(depth_m, range_m, slope), 0.3).ln_power
                    - here.ln_power)
                    / step;
                assert!((found - expected).abs() < 1e-4, "{parameter}: {found} {expected}");
            }
        }
    }

    #[test]
    fn curves_are_found_from_the_levels_that_they_make() {
        let curves = curves();
        let places: Vec<FitPlace> = (0..400)
            .map(|index| {
                let (depth_m, out) = (1.5 + 0.1 * f64::from(index % 20), f64::from(index / 20));
                let at = Incidence {
                    side: if index % 2 == 0 { 1.0 } else { -1.0 },
                    ..at(depth_m, depth_m.hypot(1.0 + 0.5 * out), 0.0)
                };
                FitPlace { at, ln_power: curves.expected(&at, 0.0).ln_power, sd: 0.1 }
            })
            .collect();
        let found = LawCurves::fit(&places).unwrap();
        for place in &places {
            let level = found.expected(&place.at, 0.0).ln_power;
            assert!((level - place.ln_power).abs() < 0.1, "{level} {place:?}");
        }
    }
}
