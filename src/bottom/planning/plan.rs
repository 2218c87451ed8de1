//! Computes a plan from its lines: the way through them, and the uncertainty that remains after it.

use super::ground::PlanningGrid;
use super::route::link;
use super::turns::{Leg, turns};
use super::{PlanError, SeenObject, SurveyCoverage};
use crate::bathymetry::Grid;

/// Speed of a boat where neither the settings nor the survey determine it, metres a second.
const USUAL_SPEED_MPS: f64 = 1.5;
/// Distance between places on a straight piece of the way, metres: so long that a piece has no
/// places but its ends.
const STRAIGHT_M: f64 = 1e9;

/// Time, speed and limits that a plan is made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanSettings {
    /// Time from the start of the first line to the end of the last, minutes.
    pub minutes: f64,
    /// Speed over ground, metres a second; `None` for the usual speed of the survey.
    pub speed_mps: Option<f64>,
    /// Least turn radius of the boat, metres.
    pub turn_radius_m: f64,
    /// Distance between lines that is close enough, metres. `None`: lines come closer as long as
    /// that reduces the uncertainty most.
    pub spacing_m: Option<f64>,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self { minutes: 20.0, speed_mps: None, turn_radius_m: 5.0, spacing_m: None }
    }
}

impl PlanSettings {
    /// Checks that the numbers are possible for a boat.
    ///
    /// # Errors
    /// When a number is out of bounds: a sentence about the first one.
    pub fn check(&self) -> Result<(), PlanError> {
        let limits = [
            (Some(self.minutes), 0.1..=1440.0, "a plan takes 0.1 to 1440 minutes"),
            (self.speed_mps, 0.1..=20.0, "the boat's speed is 0.1 to 20 metres a second"),
            (Some(self.turn_radius_m), 0.5..=500.0, "the turn radius is 0.5 to 500 metres"),
            (self.spacing_m, 0.5..=1000.0, "lines are 0.5 to 1000 metres apart"),
        ];
        let wrong = limits
            .into_iter()
            .find(|(value, allowed, _)| value.is_some_and(|value| !allowed.contains(&value)));
        wrong.map_or(Ok(()), |(_, _, why)| Err(PlanError::Settings(why)))
    }

    /// Returns the speed in the settings, or else that of the survey if it is possible, or else a
    /// usual speed, metres a second.
    pub(super) fn speed_of(&self, known: &SurveyCoverage) -> f64 {
        let own = Some(known.speed_mps).filter(|speed| (0.1..=20.0).contains(speed));
        self.speed_mps.or(own).unwrap_or(USUAL_SPEED_MPS)
    }
}

/// Kind of a place on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaypointKind {
    /// The start of the line with this index.
    Start(usize),
    /// The end of the line with this index.
    End(usize),
    /// A corner of a turn between two lines.
    Turn,
}

/// Place on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Place, metres east and north.
    pub place: [f64; 2],
    /// Kind of the place.
    pub station: WaypointKind,
}

/// Uncertainty of the depths of the water, and its coverage by side-scan.
#[derive(Clone, Debug, PartialEq)]
pub struct WaterState {
    /// Predicted standard deviation of the depth of each cell, metres; NaN outside the water.
    pub sigma_m: Vec<f32>,
    /// Mean of the standard deviation over the water, metres.
    pub mean_sigma_m: f64,
    /// Area of the ground that no pass insonified, and of that which one pass did, square metres.
    pub looked_m2: [f64; 2],
    /// Number of objects seen from one side only.
    pub one_sided: usize,
}

/// Lines to sail, and their effect on the uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    ground: PlanningGrid,
    /// The lines in the order and direction of sailing.
    pub lines: Vec<Leg>,
    /// The way through the lines: their ends, and the corners of the turns between them.
    pub way: Vec<Waypoint>,
    /// Length of the lines alone, metres.
    pub lines_m: f64,
    /// Length of the way, metres.
    pub length_m: f64,
    /// Speed over ground, metres a second.
    pub speed_mps: f64,
    /// Least radius of the turns, metres.
    pub turn_radius_m: f64,
    /// Number of turns that leave the water: of lines drawn by hand, no turn may stay in it.
    pub turns_outside: usize,
    /// Area of the water, square metres.
    pub area_m2: f64,
    /// State of the water after the survey.
    pub before: WaterState,
    /// State of the water after the plan.
    pub after: WaterState,
}

impl Plan {
    pub(super) fn new(
        ground: PlanningGrid,
        lines: Vec<Leg>,
        settings: &PlanSettings,
        speed_mps: f64,
    ) -> Self {
        let before = WaterState::of(&ground);
        let plan = Self {
            area_m2: ground.cell_m2() * ground.cells.len() as f64,
            after: before.clone(),
            before,
            ground,
            lines: Vec::new(),
            way: Vec::new(),
            lines_m: 0.0,
            length_m: 0.0,
            speed_mps,
            turn_radius_m: settings.turn_radius_m,
            turns_outside: 0,
        };
        plan.with_lines(lines)
    }

    /// Returns the plan with other lines, in their order.
    #[must_use]
    pub fn with_lines(&self, lines: Vec<Leg>) -> Self {
        let radius_m = self.turn_radius_m;
        let waypoint = |place, station| Waypoint { place, station };
        let mut way = Vec::new();
        let (mut turns_m, mut turns_outside) = (0.0, 0);
        for (number, leg) in lines.iter().enumerate() {
            if let Some(before) = number.checked_sub(1).map(|before| lines[before]) {
                let (from, to) = (before.end(), leg.start());
                let inside = link(&self.ground.water, from, to, radius_m);
                turns_outside += usize::from(inside.is_none());
                let shortest = || turns(from, to, radius_m).into_iter().next();
                if let Some(turn) = inside.or_else(shortest) {
                    turns_m += turn.length_m();
                    let corners = turn.places(STRAIGHT_M).into_iter();
                    way.extend(corners.map(|place| waypoint(place, WaypointKind::Turn)));
                }
            }
            way.push(waypoint(leg.from, WaypointKind::Start(number)));
            way.push(waypoint(leg.to, WaypointKind::End(number)));
        }
        let mut ground = self.ground.clone();
        for pair in way.windows(2) {
            let is_line = matches!(pair[0].station, WaypointKind::Start(_));
            ground.sail(pair[0].place, pair[1].place, is_line);
        }
        let lines_m = lines.iter().map(Leg::length_m).sum();
        Self {
            after: WaterState::of(&ground),
            lines_m,
            length_m: lines_m + turns_m,
            turns_outside,
            lines,
            way,
            ..self.clone()
        }
    }

    /// Returns the time from the start of the first line to the end of the last, minutes.
    pub fn minutes(&self) -> f64 {
        self.length_m / self.speed_mps / 60.0
    }

    /// Returns the grid of the cells of [`WaterState::sigma_m`].
    pub fn grid(&self) -> &Grid {
        &self.ground.water.grid
    }

    /// Returns true if a place is in the water of the plan.
    pub fn is_water(&self, place: [f64; 2]) -> bool {
        self.ground.water.holds(place)
    }
}

impl WaterState {
    fn of(ground: &PlanningGrid) -> Self {
        let mut sigma_m = vec![f32::NAN; ground.water.grid.len()];
        let mut looked_m2 = [0.0; 2];
        let mut sum_m = 0.0;
        for ((index, _), cell) in ground.water.cells().zip(&ground.cells) {
            let cell_sigma_m = ground.sigma_m(cell);
            sigma_m[index] = cell_sigma_m;
            sum_m += f64::from(cell_sigma_m);
            if let Some(looked_m2) = looked_m2.get_mut(usize::from(cell.looks)) {
                *looked_m2 += ground.cell_m2();
            }
        }
        let seen_once = |object: &&SeenObject| object.crossing() < ONE_SIDED;
        Self {
            sigma_m,
            mean_sigma_m: sum_m / ground.cells.len().max(1) as f64,
            looked_m2,
            one_sided: ground.objects.iter().filter(seen_once).count(),
        }
    }
}

/// Crossing of the headings below which an object counts as seen from one side only: the sine
/// squared of 30 degrees.
const ONE_SIDED: f64 = 0.25;
