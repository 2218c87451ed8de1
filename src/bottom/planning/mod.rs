//! Plans the lines to sail next: those that reduce the uncertainty of a survey most in a number of
//! minutes.
//!
//! In: survey coverage, and the water. Out: lines in the order of sailing, with the reduction of
//! the uncertainty.
//!
//! [`SurveyCoverage`] is what is known, `water` where a boat may sail. `ground` holds what each
//! cell of the water lacks: depths (by the distance to the nearest sounding, [`SigmaLaw`]), a first
//! or second look of the side-scan, a third pass where two disagree, another side of an object.
//! `candidates` finds straight lines over many headings, each with the stretch that reduces the
//! uncertainty most for its time. The best line, counted with the turns to it, is taken, and its
//! reduction is subtracted from the ground; this is repeated until the minutes are used or no line
//! is worth its time. `route` orders the lines, with `turns` that the boat can make and that stay
//! in the water. `plan` holds the resulting plan.

mod candidates;
mod ground;
mod plan;
mod route;
mod turns;
mod water;

pub use plan::{Plan, PlanSettings, WaterState, WaypointKind};
pub use turns::Leg;

use crate::bathymetry::SigmaByDistance;
use bathyscope_log::support::progress::{Cancelled, Progress};
use candidates::{CandidateLine, Limits, candidates};
use ground::PlanningGrid;
use route::{Insertion, Route};
use water::Water;

/// Distance to either side over which the outline of the sailed water closes gaps, in widest gaps
/// of the depth map: a strip of three gaps between two lines is water.
const CLOSED_GAPS: f64 = 1.5;
/// Number of candidates with a turn to them of which the best is chosen.
const LOOKED_AT: usize = 40;
/// Largest number of lines in a plan.
const MOST_LINES: usize = 400;
/// Least gain of a line for its length, as a share of that of the first line: the plan ends before
/// a line with less.
const WORTH: f64 = 0.03;

/// Reason why there is no plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// There is no log to plan from.
    #[error("there is no log to plan from")]
    NoLog,
    /// The survey has no soundings.
    #[error(
        "the survey has no depths to plan from; process logs that hold soundings or side-scan with positions"
    )]
    NoDepths,
    /// The time is too short for any line.
    #[error(
        "no line fits into the time; give more minutes, a faster boat or a smaller turn radius"
    )]
    NoTime,
    /// The polygon holds no water to sail on.
    #[error(
        "the area holds no water to sail on: it has no extent, or is narrower than a few metres everywhere"
    )]
    NoArea,
    /// The polygon is away from the survey.
    #[error("the area lies away from the survey; give one that the logs lie in or beside")]
    AreaElsewhere,
    /// The water has no room for a line.
    #[error(
        "no line fits into the water with room to turn at its ends; give a smaller turn radius or a larger area"
    )]
    NoRoom,
    /// Everything is known as well as it can be.
    #[error("there is nothing left to mend in the area")]
    NothingToMend,
    /// A setting is out of bounds.
    #[error("{0}")]
    Settings(&'static str),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl PlanError {
    /// Returns true if the error is about the area that was given.
    pub fn is_about_area(&self) -> bool {
        matches!(self, PlanError::NoArea | PlanError::AreaElsewhere)
    }
}

/// Plans the lines that reduce the uncertainty of a survey most in the time of the settings, in the
/// water within `area` (rings in the survey's plane, metres), or within the outline of the sailed
/// water if `area` is `None`.
///
/// The same input gives the same plan.
///
/// # Errors
/// [`PlanError`].
pub fn plan(
    known: &SurveyCoverage,
    area: Option<&[Vec<[f64; 2]>]>,
    settings: &PlanSettings,
    progress: &Progress,
) -> Result<Plan, PlanError> {
    settings.check()?;
    if known.soundings.is_empty() {
        return Err(PlanError::NoDepths);
    }
    let water = match area {
        Some(rings) => water_of(rings, known)?,
        None => Water::around(&known.soundings, CLOSED_GAPS * known.max_gap_m)
            .ok_or(PlanError::NoDepths)?,
    };
    progress.check()?;
    let speed_mps = settings.speed_of(known);
    let whole = PlanningGrid::new(known, water, settings.spacing_m);
    let legs = sailed(&whole, settings, speed_mps, progress)?;
    Ok(Plan::new(whole, legs, settings, speed_mps))
}

/// Returns the water of an area; an error if the survey is not in or near it.
fn water_of(rings: &[Vec<[f64; 2]>], known: &SurveyCoverage) -> Result<Water, PlanError> {
    let water = Water::within(rings).ok_or(PlanError::NoArea)?;
    let near_m = known.sigma.reach_m().max(known.max_gap_m);
    let [across_m, down_m] =
        [water.grid.columns, water.grid.rows].map(|cells| cells as f64 * water.grid.cell_m);
    let is_near = |place: &[f64; 2]| {
        let [east, north] = [place[0] - water.grid.west_m, water.grid.north_m - place[1]];
        (-near_m..across_m + near_m).contains(&east) && (-near_m..down_m + near_m).contains(&north)
    };
    if known.soundings.iter().any(is_near) { Ok(water) } else { Err(PlanError::AreaElsewhere) }
}

/// Chooses the lines, and returns them in the order of sailing.
fn sailed(
    whole: &PlanningGrid,
    settings: &PlanSettings,
    speed_mps: f64,
    progress: &Progress,
) -> Result<Vec<Leg>, PlanError> {
    let radius_m = settings.turn_radius_m;
    let budget_m = 60.0 * settings.minutes * speed_mps;
    if budget_m < 2.0 * radius_m {
        return Err(PlanError::NoTime);
    }
    let mut ground = whole.clone();
    let mut route = Route::new(&whole.water, radius_m);
    progress.start(budget_m as u64);
    let mut used_m = 0.0;
    let mut first_rate = None;
    for _ in 0..MOST_LINES {
        let ends: Vec<[f64; 2]> = route.legs().iter().flat_map(|leg| [leg.from, leg.to]).collect();
        let limits = Limits { speed_mps, radius_m, most_m: budget_m - used_m };
        let found = candidates(&ground, &ends, &limits, progress)?;
        if found.is_empty() && ends.is_empty() {
            return Err(why_none(&ground, &limits));
        }
        let Some((rate, insertion, leg)) = best(&found, &mut route, budget_m - used_m, &limits)
        else {
            // A better order may save enough length for one more line.
            if route.improve() < 0.5 * radius_m {
                break;
            }
            used_m = route.length_m();
            continue;
        };
        if rate < WORTH * *first_rate.get_or_insert(rate) {
            break;
        }
        ground.sail(leg.from, leg.to, true);
        route.insert(insertion);
        let before_m = used_m;
        used_m = route.length_m();
        progress.advance((used_m - before_m).max(0.0) as u64);
    }
    route.improve();
    let legs = route.legs();
    if legs.is_empty() { Err(PlanError::NoTime) } else { Ok(legs) }
}

/// Returns the reason why not even a first line was found.
fn why_none(ground: &PlanningGrid, limits: &Limits) -> PlanError {
    let is_mendable = |cell: &ground::WaterCell| {
        let sigma_m = ground.sigma_m(cell);
        ground.mended_by(cell, sigma_m, 0.0) > 0.0
    };
    match ground.cells.iter().any(is_mendable) {
        false => PlanError::NothingToMend,
        true if limits.most_m < limits.least_m() + ground.water.grid.cell_m => PlanError::NoTime,
        true => PlanError::NoRoom,
    }
}

/// Returns the candidate that reduces the uncertainty most for its length, counted with the turns
/// to it, with its gain for each metre and its place in the route; `None` if no candidate fits into
/// the remaining length. Candidates are shortened where they must be.
fn best(
    found: &[CandidateLine],
    route: &mut Route<'_>,
    rest_m: f64,
    limits: &Limits,
) -> Option<(f64, Insertion, Leg)> {
    let mut best: Option<(f64, Insertion, Leg)> = None;
    let fitting = found.iter().filter_map(|candidate| fitted(candidate, route, rest_m, limits));
    for (growth_m, insertion, candidate) in fitting.take(LOOKED_AT) {
        let rate = candidate.gain / growth_m.max(limits.least_m());
        if best.as_ref().is_none_or(|(most, _, _)| rate > *most) {
            best = Some((rate, insertion, candidate.leg()));
        }
    }
    best
}

/// Largest number of times that a line is shortened to fit into the remaining length.
const SHORTENED: usize = 4;

fn fitted(
    candidate: &CandidateLine,
    route: &mut Route<'_>,
    rest_m: f64,
    limits: &Limits,
) -> Option<(f64, Insertion, CandidateLine)> {
    let mut candidate = candidate.clone();
    for _ in 0..SHORTENED {
        let (growth_m, insertion) = route.growth(candidate.leg())?;
        if growth_m <= rest_m {
            return Some((growth_m, insertion, candidate));
        }
        candidate = candidate.shortened(growth_m - rest_m, limits.least_m())?;
    }
    None
}

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
