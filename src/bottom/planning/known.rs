//! Defines the survey coverage that a plan needs. All places are in one plane, metres east and
//! north.

use crate::bathymetry::SigmaByDistance;

/// Survey coverage: places of the soundings, and results from them.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyCoverage {
    /// Places of the soundings.
    pub soundings: Vec<[f64; 2]>,
    /// Standard deviation of a depth by the distance from the nearest sounding.
    pub sigma: SigmaLaw,
    /// Ground that side-scan pings insonified.
    pub looks: Vec<InsonifiedSide>,
    /// Objects with the headings at which they were detected.
    pub objects: Vec<SeenObject>,
    /// Places where passes disagree about the depth.
    pub doubts: Vec<Doubt>,
    /// Usual depth, metres.
    pub depth_m: f64,
    /// Usual slant range of the side-scan, metres; 0 without side-scan.
    pub range_m: f64,
    /// Usual speed of the boat, metres a second; NaN where it is not known.
    pub speed_mps: f64,
    /// Widest gap between soundings that the depth map closes (`surface.max_gap_m`), metres.
    pub max_gap_m: f64,
}

/// Ground that one ping insonified on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InsonifiedSide {
    /// Place below the boat.
    pub from: [f64; 2],
    /// Place at the end of the range.
    pub to: [f64; 2],
    /// Number of the pass, the same for all its pings.
    pub pass: u32,
}

/// Object on the bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenObject {
    /// Place of the object.
    pub place: [f64; 2],
    /// Headings of the boat when the object was detected, radians.
    pub headings_rad: Vec<f64>,
}

/// Place where two passes differ in depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// Place where the passes cross.
    pub place: [f64; 2],
    /// Difference of the depths of both passes, metres.
    pub difference_m: f64,
}

impl SeenObject {
    /// Returns how well the headings at which the object was detected complement each other: the
    /// largest sine squared of an angle between two of them, 1 at right angles, 0 with one heading
    /// only.
    pub fn crossing(&self) -> f64 {
        let each = self.headings_rad.iter().enumerate();
        each.map(|(index, heading)| crossed(&self.headings_rad[..index], *heading))
            .fold(0.0, f64::max)
    }

    /// Returns [`SeenObject::crossing`] with one more heading.
    pub(crate) fn crossing_with(&self, heading_rad: f64) -> f64 {
        self.crossing().max(crossed(&self.headings_rad, heading_rad))
    }
}

fn crossed(headings_rad: &[f64], other_rad: f64) -> f64 {
    let sines = headings_rad.iter().map(|heading| (heading - other_rad).sin());
    sines.map(|sine| sine * sine).fold(0.0, f64::max)
}

/// Standard deviation of the error of a depth by the distance to the nearest sounding, up to the
/// limit where nothing is known.
#[derive(Clone, Debug, PartialEq)]
pub struct SigmaLaw {
    /// Standard deviations at multiples of [`STEP_M`]; the last one applies to all larger
    /// distances.
    steps_m: Vec<f32>,
}

/// Distance between the steps of a law, metres.
const STEP_M: f64 = 0.1;
/// Farthest distance of any law, metres.
const FARTHEST_M: f64 = 500.0;
/// Standard deviation at a sounding, metres, and its rise for each metre from it, for a survey with
/// too few soundings for a cross-validation. The ponds of `cargo bench -- surface` have 0.01 to
/// 0.06 for each metre.
const USUAL_SIGMA_M: f64 = 0.05;
const USUAL_RISE: f64 = 0.04;
/// Least limit of a law, metres; the limit is the standard deviation of a guess of the mean depth.
const LEAST_LIMIT_M: f64 = 0.1;

impl SigmaLaw {
    /// Creates the law from left-out soundings; without them (`None`), from a usual rise. It is
    /// nowhere more than `limit_m`, the spread of the depths of the survey, which is the error of
    /// the mean depth.
    pub fn new(left_out: Option<&SigmaByDistance>, limit_m: f64) -> Self {
        let at = |distance_m: f64| match left_out {
            Some(left_out) => left_out.at(distance_m),
            None => USUAL_SIGMA_M.hypot(USUAL_RISE * distance_m),
        };
        let limit_m = limit_m.max(LEAST_LIMIT_M).max(1.5 * at(0.0));
        let steps = (0..=(FARTHEST_M / STEP_M) as u32).map(|step| at(STEP_M * f64::from(step)));
        let mut steps_m: Vec<f32> =
            steps.take_while(|sigma_m| *sigma_m < limit_m).map(|sigma_m| sigma_m as f32).collect();
        steps_m.push(limit_m as f32);
        Self { steps_m }
    }

    /// Returns the standard deviation at a distance, metres.
    pub fn at(&self, distance_m: f32) -> f32 {
        let step = (distance_m * (1.0 / STEP_M) as f32 + 0.5) as usize;
        self.steps_m[step.min(self.steps_m.len() - 1)]
    }

    /// Returns the standard deviation where nothing is known, metres.
    pub(crate) fn limit_m(&self) -> f32 {
        self.steps_m[self.steps_m.len() - 1]
    }

    /// Returns the distance beyond which a sounding adds no information, metres.
    pub fn reach_m(&self) -> f64 {
        STEP_M * (self.steps_m.len() - 1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_rises_to_its_limit_and_no_further() {
        let law = SigmaLaw::new(None, 0.5);
        assert!((law.at(0.0) - 0.05).abs() < 1e-6);
        assert!((law.at(5.0) - 0.05_f32.hypot(0.2)).abs() < 1e-3);
        assert_eq!(law.at(400.0), 0.5);
        assert_eq!(law.limit_m(), 0.5);
        assert!((law.reach_m() - 12.4).abs() < 0.2, "{}", law.reach_m());
    }

    #[test]
    fn two_looks_at_right_angles_are_worth_most() {
        let mut object = SeenObject { place: [0.0, 0.0], headings_rad: vec![0.2] };
        assert_eq!(object.crossing(), 0.0);
        let right = std::f64::consts::FRAC_PI_2;
        assert!((object.crossing_with(0.2 + right) - 1.0).abs() < 1e-12);
        assert!(
            object.crossing_with(0.2 + 2.0 * right) < 1e-12,
            "the other way along the same line"
        );
        object.headings_rad.push(0.2 + 0.5 * right);
        assert!((object.crossing() - 0.5).abs() < 1e-12);
    }
}
