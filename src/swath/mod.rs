//! Depth between the lines: the brightness of the side-scan picture says how the bed slopes.
//!
//! An echo is brighter where the bed faces the boat and darker where it turns away. From two sides, as from neighbouring lines, slope
//! changes its sign and the bed's own brightness does not, so the two can be told apart (shape from shading). What is found is a
//! correction of the surface that the depths gave: none where a depth was measured, and small where the echoes say little. It is
//! inferred, not measured.
//!
//! `echoes` is what is read of a log and `layout` what is found of all of it: `level_scale` turns its levels into logarithms of power, `weed` says
//! where echoes are none of the bed. `tiling` parts a survey, or what a part of a larger map depends on. `pieces` averages the echoes on a `ground` and
//! `readings` are those as logarithms. `echo_law` says what a slope changes; `system` has the equations for the unknowns at the `nodes`, `elimination` the
//! order in which they are solved, `local_sigma` learns how large the correction may be, and
//! `correction` runs all of it in rounds.

mod correction;
mod echo_law;
mod echoes;
mod elimination;
mod ground;
mod layout;
mod level_scale;
mod local_sigma;
mod nodes;
mod pieces;
mod readings;
mod system;
mod tiling;
mod weed;

pub use correction::Correction;
pub use echoes::{Levels, LogEchoes, PingPlace, SideEchoes};
pub use layout::{Chunk, LaidOutLog};
pub use tiling::{PART_GROUND_M, PART_MOST_CELL_M, PART_PINGS_M, PART_STEP_M};

use crate::bathymetry::{CellSource, DepthPoint, Shading, Spread, Surface};
use crate::progress::{Cancelled, Progress};
use crate::statistics::median;
use correction::{Tiling, correction};
use ground::Ground;
use kiddo::{ImmutableKdTree, SquaredEuclidean};

/// Shares of the stated error that is left, of the correction that its own error is taken for, and of the size of the corrections around a cell
/// that is taken for what echoes do not say: where these are large, left-out depths did not show the relief between the lines. On simulated
/// ponds of seeds 101 to 105 they make of the cells between the lines those that the standard deviation promises.
const SPREAD_SHARE: f64 = 0.85;
const ERROR_SHARE: f64 = 0.6;
const AROUND_SHARE: f64 = 0.55;
/// Standard deviation of the window that the size of corrections is taken over, metres.
const AROUND_M: f64 = 8.0;
/// Share of the surface's stated error beyond [`BETWEEN_M`] from soundings that a correction usually has, and its bounds, metres.
const USUAL_SHARE: f64 = 0.7;
const USUAL_M: [f64; 2] = [0.008, 0.12];
const BETWEEN_M: f64 = 1.0;
/// The usual correction where the surface states no error, metres.
const USUAL_WITHOUT_M: f64 = 0.02;
/// Cells that the stated error is looked up in.
const CELLS_ASKED: usize = 50_000;

/// What became of a surface.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// Its depths were corrected.
    Shaded(Correction),
    /// It is as it was.
    Kept(Kept),
}

/// Why a surface was not corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// No log has side-scan echoes with places.
    NoSideScan,
    /// No depth was measured.
    NoDepths,
    /// The recorded levels are none of decibels, or too few to tell.
    NoDecibels,
    /// Fewer than 500 pieces of echoes lie on the surface.
    TooFewEchoes,
    /// It has more than 300 tiles of 58 by 58 m.
    TooLarge,
    /// The equations have no solution in numbers.
    NotSolved,
}

impl Kept {
    /// The reason in a sentence.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::NoSideScan => "no log has side-scan echoes with places",
            Self::NoDepths => "no depth was measured",
            Self::NoDecibels => "the recorded levels are none of decibels",
            Self::TooFewEchoes => "too few echoes lie on the surface",
            Self::TooLarge => "the survey is too large",
            Self::NotSolved => "the equations have no solution",
        }
    }
}

/// Corrects the depths of a surface by the brightness of the echoes of its logs, in the surface's plane: depths become `p + c`, spreads
/// the root of the sum of the squares of 0.85 spread, 0.6 `c` and 0.55 times the root mean square of corrections around, where echoes say something. `measured` are the depths that the surface was made of. A surface that the echoes cannot support stays as
/// it is.
///
/// A tile of 8000 nodes takes some 100 MB, and as many tiles are solved at a time as there are threads.
///
/// # Errors
/// When the work was cancelled.
pub fn shade(
    surface: &mut Surface,
    logs: &[LogEchoes<'_>],
    measured: &[DepthPoint],
    progress: &Progress,
) -> Result<Outcome, Cancelled> {
    let has_echoes = |log: &LogEchoes<'_>| log.pings.iter().any(PingPlace::is_placed);
    if !logs.iter().any(has_echoes) {
        return Ok(Outcome::Kept(Kept::NoSideScan));
    }
    let anchors = anchors(measured);
    let ground = Ground::new(surface.grid, &surface.depth_m);
    let (Some(ground), false) = (ground, anchors.is_empty()) else {
        return Ok(Outcome::Kept(Kept::NoDepths));
    };
    let Some(tiling) = Tiling::of_survey(&surface.grid) else {
        return Ok(Outcome::Kept(Kept::TooLarge));
    };
    let usual_m = usual_correction_m(surface, measured);
    let laid_out = logs
        .iter()
        .map(|log| LaidOutLog::new(log.clone(), progress))
        .collect::<Result<Vec<_>, _>>()?;
    let found = match correction(&laid_out, &ground, &tiling, &anchors, usual_m, progress)? {
        Ok(found) => found,
        Err(kept) => return Ok(Outcome::Kept(kept)),
    };
    add(&found, surface);
    surface.hardness_db = hardness_db(&found, surface);
    surface.shading = Shading::Corrected;
    Ok(Outcome::Shaded(found))
}

/// As [`shade`], of a part of a larger map: `around` is its surface with [`PART_GROUND_M`] around the edges of the part, `logs` have the pings
/// within [`PART_PINGS_M`], `measured` are the depths on that surface, and the corrections are right within 32 m of the edges, the same to the
/// bit as those of a neighbouring part. Places count in a plane that all parts share, and the order of logs and depths must be the same for
/// all. Hardness is none: each part would count it from another zero.
///
/// # Errors
/// When the work was cancelled.
pub fn shade_part(
    around: &mut Surface,
    edges_m: [f64; 4],
    logs: &[LaidOutLog<'_>],
    measured: &[DepthPoint],
    progress: &Progress,
) -> Result<(), Cancelled> {
    let Some(ground) = Ground::new(around.grid, &around.depth_m) else {
        return Ok(());
    };
    let tiling = Tiling::of_part(edges_m);
    let anchors = anchors(measured);
    let found = correction(logs, &ground, &tiling, &anchors, USUAL_WITHOUT_M, progress)?;
    around.shading = match found {
        Ok(found) => {
            add(&found, around);
            Shading::Corrected
        }
        Err(kept) => Shading::Impossible(kept.in_words()),
    };
    Ok(())
}

/// The places of the depths that count.
fn anchors(measured: &[DepthPoint]) -> Vec<[f64; 2]> {
    let counting = measured.iter().filter(|point| point.weight > 0.0);
    counting
        .map(|point| [point.east_m, point.north_m])
        .collect()
}

/// Adds a correction to the depths of a surface, and says which of them rest on it.
fn add(found: &Correction, surface: &mut Surface) {
    let around_m = found.size_around_m(AROUND_M);
    let columns = surface.grid.columns.max(1);
    let depths = surface.depth_m.iter_mut().zip(&mut surface.spread_m);
    let cells = depths.zip(&mut surface.source).enumerate();
    for (cell, ((depth_m, spread_m), source)) in cells {
        if depth_m.is_nan() {
            continue;
        }
        let centre = surface.grid.centre(cell / columns, cell % columns);
        let added_m = found.at(centre);
        let is_seen = found.sees(centre);
        let share = if is_seen { SPREAD_SHARE } else { 1.0 };
        let around_m = found.nodes.value_at(&around_m, centre);
        *depth_m = (f64::from(*depth_m) + added_m) as f32;
        *spread_m = (share * f64::from(*spread_m))
            .hypot(ERROR_SHARE * added_m)
            .hypot(AROUND_SHARE * around_m) as f32;
        if *source == CellSource::Interpolated && is_seen {
            *source = CellSource::Shaded;
        }
    }
}

/// The brightness of the bed in the cells with a depth that echoes say something of, decibels over their median; `None` where that
/// is none.
fn hardness_db(found: &Correction, surface: &Surface) -> Option<Vec<f32>> {
    let columns = surface.grid.columns.max(1);
    let of_cell = |(cell, depth_m): (usize, &f32)| {
        let centre = surface.grid.centre(cell / columns, cell % columns);
        let is_known = !depth_m.is_nan() && found.sees(centre);
        let ln = is_known.then(|| found.nodes.value_at(&found.ln_brightness, centre));
        ln.map_or(f64::NAN, |ln| 10.0 * ln / std::f64::consts::LN_10)
    };
    let cells_db: Vec<f64> = surface.depth_m.iter().enumerate().map(of_cell).collect();
    let known = cells_db.iter().copied().filter(|value| !value.is_nan());
    let mut known: Vec<f64> = known.collect();
    if known.is_empty() {
        return None;
    }
    let usual_db = median(&mut known);
    let over = |value: f64| (value - usual_db) as f32;
    Some(cells_db.into_iter().map(over).collect())
}

/// The size that a correction usually has: a share of the median stated error between the lines, metres.
fn usual_correction_m(surface: &Surface, measured: &[DepthPoint]) -> f64 {
    let soundings: Vec<[f64; 2]> = (measured
        .iter()
        .filter(|point| point.is_sounding && point.weight > 0.0))
    .map(|point| [point.east_m, point.north_m])
    .collect();
    let (Spread::OfError, false) = (surface.spread_is, soundings.is_empty()) else {
        return USUAL_WITHOUT_M;
    };
    let Ok(tree) = ImmutableKdTree::<f64, 2>::new_from_slice(&soundings) else {
        return USUAL_WITHOUT_M;
    };
    let columns = surface.grid.columns.max(1);
    let step = surface.grid.len().div_ceil(CELLS_ASKED).max(1);
    let spread_between = |cell: usize| {
        let spread_m = surface
            .spread_m
            .get(cell)
            .filter(|spread_m| spread_m.is_finite())?;
        let centre = surface.grid.centre(cell / columns, cell % columns);
        let query = tree.query(&centre);
        let nearest = query.nearest_one::<SquaredEuclidean<f64>>().execute();
        (nearest.distance > BETWEEN_M * BETWEEN_M).then_some(f64::from(*spread_m))
    };
    let mut spreads_m: Vec<f64> = (0..surface.grid.len())
        .step_by(step)
        .filter_map(spread_between)
        .collect();
    match spreads_m.is_empty() {
        true => USUAL_WITHOUT_M,
        false => (USUAL_SHARE * median(&mut spreads_m)).clamp(USUAL_M[0], USUAL_M[1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::Grid;
    use crate::survey::Survey;

    #[test]
    fn a_surface_without_echoes_or_depths_stays_as_it_is() {
        let grid = Grid {
            west_m: 0.0,
            north_m: 10.0,
            cell_m: 1.0,
            columns: 10,
            rows: 10,
        };
        let mut surface = Surface::of_depths(grid, vec![2.0; 100]);
        let before = surface.clone();
        let survey = Survey::default();
        let measured = DepthPoint {
            east_m: 3.0,
            north_m: 3.0,
            depth_m: 2.0,
            weight: 1.0,
            is_sounding: true,
        };
        let side = SideEchoes {
            near_m: 0.0,
            step_m: 0.01,
            first_return: 200.0,
            above_bottom: false,
        };
        let ping = PingPlace {
            time_s: 0.0,
            place_m: [3.0, 3.0],
            starboard: [1.0, 0.0],
            transducer_m: 0.0,
            sides: [side; 2],
        };
        let of_pings = |pings: Vec<PingPlace>| LogEchoes {
            levels: &survey,
            pings,
        };
        let logs = [of_pings(Vec::new()), of_pings(vec![ping; 100])];
        let mut kept = |logs: &[LogEchoes<'_>], measured: &[DepthPoint]| match shade(
            &mut surface,
            logs,
            measured,
            &Progress::new(),
        ) {
            Ok(Outcome::Kept(why)) => why,
            other => panic!("{other:?}"),
        };
        assert_eq!(kept(&logs[..1], &[measured]), Kept::NoSideScan);
        assert_eq!(kept(&logs, &[]), Kept::NoDepths);
        // Pings without samples.
        assert_eq!(kept(&logs, &[measured]), Kept::NoDecibels);
        assert_eq!(surface, before);
    }
}
