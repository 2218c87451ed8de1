//! Corrects depths between the lines from the levels of the side-scan echoes, which depend on the
//! slope of the bed.
//!
//! In: a surface, and the echo levels of the logs over it. Out: the same surface with corrected
//! depths between the lines, where levels predict these better.
//!
//! An echo is stronger where the bed faces the boat and weaker where it turns away. From two sides,
//! as from neighbouring lines, the effect of a slope changes its sign and that of the bed's own
//! brightness does not, so the two can be distinguished. Depths, brightness, gain, and the curves
//! of beam, range and noise are solved for together, and agree with the measured depths. The
//! resulting depths are inferred, not measured.
//!
//! `echoes` defines the data that is read of a log, and finds weed; `layout` determines the
//! properties of a whole log, such as its `law`, which converts levels into logarithms of power.
//! `observations` are averaged levels (looks) placed on the bed; `model` predicts their levels.
//! `depths` divides a survey, or a part of a larger map, into tiles of `nodes`, and runs the
//! rounds; `solve` solves a tile, and `gate` decides by left-out soundings whether levels are used.

mod depths;
mod echoes;
mod gate;
mod law;
mod layout;
mod model;
mod nodes;
mod observations;
mod solve;

pub use depths::{PART_DEPTHS_M, PART_PINGS_M, PART_STEP_M};
pub use echoes::{LogEchoes, PingPlace, SampleSource, SideEchoes};
pub use layout::{LaidOutLog, PingChunk};

use crate::bathymetry::{
    CellSource, DepthPoint, FromLevels, Grid, LevelsRefused, Spread, Surface, SwathDepth,
};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::median_of;
use depths::{NodeDepths, Resolution, Sample, SwathInput, Tiling};
use model::LawCurves;
use serde::{Deserialize, Serialize};
use solve::{Brightness, Prior};

/// Largest number of tiles on which curves are learnt and left-out soundings predicted.
const MOST_LEARNT: usize = 2;
/// Largest ratio of the error of left-out soundings with levels to that by triangles at which
/// levels are used. At each place the smaller error has the larger weight.
const MOST_RATIO: f64 = 0.95;
/// Largest number of sets of curves, one for each recorder and range setting, that `auto` learns:
/// the time grows with the square of their number.
const MOST_SETS: usize = 8;
/// Distances from a measured depth up to which levels have no weight, and from which on they have
/// full weight, metres.
const HELD_M: [f64; 2] = [0.5, 1.5];
/// Prior knowledge of a bed where no prior was tested by left-out soundings.
const UNTESTED: Prior = Prior { brightness: Brightness::Patches(0.35), relief_m: 0.15 };
/// Ratios of a standard deviation to the usual one from which on the weight of levels falls, and
/// from which on it is 0: at the edge of a survey, where one line looks and no depth was measured
/// beyond.
const UNSURE_SDS: [f64; 2] = [2.2, 3.2];
/// Ratios of the error without levels to the usual one between which a lower limit of the error
/// with levels rises to its full value. The limit, as a share of the error without levels, is the
/// ratio of both errors at left-out soundings.
const UNUSUAL_ERRORS: [f64; 2] = [1.5, 2.5];
/// Factors for the stated error of depths from levels. The first is on the geometric mean of the
/// errors of left-out soundings with levels and by triangles: this is valid on ponds of both
/// simulators. The second is on the standard deviation by the equations, where there was no test.
const STATED: f64 = 1.15;
const UNTESTED_SDS: f64 = 0.7;

/// Corrects the depths of a surface between the measured depths, from the levels of the echoes of
/// its logs in the surface's plane, and records the result in [`Surface::levels`]. `measured` are
/// the depths that the surface was made of.
///
/// # Errors
/// When the work was cancelled.
pub fn correct(
    surface: &mut Surface,
    logs: Vec<LogEchoes<'_>>,
    measured: &[DepthPoint],
    progress: &Progress,
    mode: SwathDepth,
) -> Result<(), Cancelled> {
    let laid_out = logs
        .into_iter()
        .map(|log| LaidOutLog::new(log, progress))
        .collect::<Result<Vec<_>, _>>()?;
    surface.levels = match found(surface, &laid_out, measured, progress, mode)? {
        Ok((found, left_out)) => {
            let stated = left_out.map_or(StatedByLevels::UNTESTED, |left_out| {
                let error_sds = STATED * left_out.error_sds;
                StatedByLevels { error_sds, least_share: left_out.with_m / left_out.without_m }
            });
            add(&found, stated, surface);
            surface.hardness_db = hardness_db(&found, surface);
            FromLevels::Used {
                left_out_m: left_out.map(|left_out| [left_out.without_m, left_out.with_m]),
            }
        }
        Err(why) => FromLevels::Refused(why),
    };
    Ok(())
}

type Refusable<T> = Result<T, LevelsRefused>;

fn found(
    surface: &Surface,
    logs: &[LaidOutLog<'_>],
    measured: &[DepthPoint],
    progress: &Progress,
    mode: SwathDepth,
) -> Result<Refusable<(NodeDepths, Option<gate::LeftOut>)>, Cancelled> {
    if !logs.iter().any(|log| log.echoes.pings.iter().any(PingPlace::is_placed)) {
        return Ok(Err(LevelsRefused::NoSideScan));
    }
    if logs.iter().all(|log| log.law.is_none()) {
        return Ok(Err(LevelsRefused::NoLaw));
    }
    let Some(tiling) = Tiling::of_survey(&surface.grid) else {
        return Ok(Err(LevelsRefused::TooLarge));
    };
    let learning = Tiling::at(&surface.grid, tiling.resolution.of_learning());
    let recorders = law::recorders(logs.iter().map(|log| log.law));
    let input = SwathInput::new(
        logs,
        &recorders,
        (measured, surface.bends),
        learning.resolution,
        progress,
    )?;
    let tiles = input.busiest(&learning, MOST_LEARNT);
    if tiles.is_empty() || input.measured.is_empty() {
        return Ok(Err(LevelsRefused::TooFewEchoes));
    }
    if mode == SwathDepth::Auto && input.sets.len() > MOST_SETS {
        return Ok(Err(LevelsRefused::TooManySettings));
    }
    if mode == SwathDepth::Auto && !gate::is_seen_from_two_sides(&input, &learning, &tiles) {
        return Ok(Err(LevelsRefused::OneSide));
    }
    let choice = gate::choose(&input, measured, &learning, &tiles, progress)?;
    let left_out = choice.as_ref().map(|choice| choice.left_out);
    if mode == SwathDepth::Auto {
        match left_out {
            None => return Ok(Err(LevelsRefused::NoTest)),
            Some(left_out) if left_out.with_m > MOST_RATIO * left_out.without_m => {
                return Ok(Err(LevelsRefused::NoBetter {
                    without_m: left_out.without_m,
                    with_m: left_out.with_m,
                }));
            }
            Some(_) => {}
        }
    }
    let (prior, curves) = match choice {
        Some(choice) => (choice.prior, Some(choice.curves)),
        None => (UNTESTED, None),
    };
    let mut sample = Sample::new(&input, &learning, &tiles, &input.measured, curves);
    if !sample.learn(&input, prior, progress)? {
        return Ok(Err(LevelsRefused::TooFewEchoes));
    }
    let found = input.find(&tiling, &sample.curves, prior, progress)?;
    Ok(found.map(|found| (found, left_out)).ok_or(LevelsRefused::NotSolved))
}

/// Law and curves of the levels of a log: a part of a map needs nothing else of the whole log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntLevels {
    /// Law by which the recorder writes an echo.
    pub law: law::Law,
    /// The curves of each range setting.
    curves: Vec<(i32, Vec<f64>)>,
}

impl LearntLevels {
    /// Learns the law and the curves from a whole log and its measured depths; `None` where its
    /// levels cannot be used.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn of(
        log: &LaidOutLog<'_>,
        measured: &[DepthPoint],
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let grid = Grid::over(measured, Resolution::COARSE.node_m, usize::MAX);
        let (Some(law), Some(grid)) = (log.law, grid) else {
            return Ok(None);
        };
        let logs = std::slice::from_ref(log);
        let tiling = Tiling::at(&grid, Resolution::COARSE);
        let input = SwathInput::new(logs, &[0], (measured, None), tiling.resolution, progress)?;
        let tiles = input.busiest(&tiling, MOST_LEARNT);
        let mut sample = Sample::new(&input, &tiling, &tiles, &input.measured, None);
        if !sample.learn(&input, UNTESTED, progress)? {
            return Ok(None);
        }
        let of_set =
            |(set, curves): (&(u32, i32), Option<LawCurves>)| Some((set.1, curves?.0.to_vec()));
        let curves: Vec<_> = input.sets.iter().zip(sample.curves).filter_map(of_set).collect();
        Ok((!curves.is_empty()).then_some(Self { law, curves }))
    }

    fn of_setting(&self, setting: i32) -> Option<LawCurves> {
        let (_, curves) = self.curves.iter().find(|(of, _)| *of == setting)?;
        Some(LawCurves(curves.as_slice().try_into().ok()?))
    }
}

/// Corrects depths as [`correct`] does, for a part of a larger map. `around` is the surface of the
/// part with its surroundings, and `edges_m` are the edges of the part. `logs` have the pings
/// within [`PART_PINGS_M`], `learnt` the law and curves of each log, and `measured` are the depths
/// within [`PART_DEPTHS_M`]. Depths up to 32 m outside the edges are valid too, and equal to the
/// bit to those of the neighbouring part. All parts share a plane, and must have logs and depths in
/// the same order. Hardness is not computed, since it would have another zero in each part.
///
/// # Errors
/// When the work was cancelled.
pub fn correct_part(
    around: &mut Surface,
    edges_m: [f64; 4],
    logs: &[LaidOutLog<'_>],
    learnt: &[&LearntLevels],
    measured: &[DepthPoint],
    progress: &Progress,
) -> Result<(), Cancelled> {
    let tiling = Tiling::of_part(edges_m);
    let each: Vec<u32> = (0..logs.len() as u32).collect();
    let input =
        SwathInput::new(logs, &each, (measured, around.bends), tiling.resolution, progress)?;
    let of_set = |(log, setting): &(u32, i32)| learnt.get(*log as usize)?.of_setting(*setting);
    let curves: Vec<Option<LawCurves>> = input.sets.iter().map(of_set).collect();
    around.levels = match input.find(&tiling, &curves, UNTESTED, progress)? {
        Some(found) => {
            add(&found, StatedByLevels::UNTESTED, around);
            FromLevels::Used { left_out_m: None }
        }
        None => FromLevels::Refused(LevelsRefused::TooFewEchoes),
    };
    Ok(())
}

/// Returns a smooth step from 0 at the first of two values to 1 at the second.
fn rise(value: f64, [from, to]: [f64; 2]) -> f64 {
    let along = ((value - from) / (to - from)).clamp(0.0, 1.0);
    along * along * (3.0 - 2.0 * along)
}

/// Stated error of depths from levels.
#[derive(Clone, Copy)]
struct StatedByLevels {
    /// Error of the depths in standard deviations by the equations.
    error_sds: f64,
    /// Least stated error, as a share of the error without levels, where the latter is far above
    /// the usual: there, levels do not reduce the error more than they do at left-out soundings.
    /// The equations predict too small an error if the bed bends more between the lines than they
    /// assume.
    least_share: f64,
}

impl StatedByLevels {
    /// Stated error where no left-out soundings tested the levels.
    const UNTESTED: Self = Self { error_sds: UNTESTED_SDS, least_share: 0.0 };
}

/// Merges the depths from levels into a surface; their weight grows with the ratio of the surface's
/// own error to theirs.
fn add(found: &NodeDepths, stated: StatedByLevels, surface: &mut Surface) {
    let nodes = &found.nodes;
    let both = found.sd_m.iter().zip(&found.seen);
    let seen = both.filter(|(_, seen)| **seen > 0.5);
    let usual_sd_m = median_of(seen.map(|(sd_m, _)| *sd_m));
    let usual_without_m = usual_between_m(surface);
    for cell in 0..surface.depth_m.len() {
        let without_m = f64::from(surface.depth_m[cell]);
        if without_m.is_nan() {
            continue;
        }
        let centre = surface.grid.centre_of(cell);
        let sd_m = nodes.value_at(&found.sd_m, centre);
        let without_error_m = f64::from(surface.spread_m[cell]);
        let unusual = rise(without_error_m / usual_without_m, UNUSUAL_ERRORS);
        let least_m = unusual * stated.least_share * without_error_m;
        let error_m = (stated.error_sds * sd_m).max(least_m);
        let mut share = rise(f64::from(surface.distance_m[cell]), HELD_M)
            * (1.0 - rise(sd_m / usual_sd_m, UNSURE_SDS))
            * nodes.value_at(&found.seen, centre);
        if surface.spread_is == Spread::OfError {
            let [own, other] = [without_error_m, error_m].map(|error_m| error_m * error_m);
            // Depths from levels depend on the triangles already: their own error has half weight.
            share *= own / (own + 0.5 * other);
        }
        if share.is_nan() || share <= 0.0 {
            continue;
        }
        let depth_m = nodes.value_at(&found.depth_m, centre);
        surface.depth_m[cell] = (without_m + share * (depth_m - without_m)) as f32;
        surface.spread_m[cell] = (share * error_m + (1.0 - share) * without_error_m) as f32;
        if surface.source[cell] == CellSource::Interpolated && share > 0.5 {
            surface.source[cell] = CellSource::FromLevels;
        }
    }
}

/// Returns the median spread of the cells where levels have full weight by their distance, metres;
/// NaN where there are none.
fn usual_between_m(surface: &Surface) -> f64 {
    let cells = surface.spread_m.iter().zip(&surface.distance_m);
    let far =
        cells.filter(|(spread_m, away_m)| !spread_m.is_nan() && f64::from(**away_m) >= HELD_M[1]);
    median_of(far.map(|(spread_m, _)| f64::from(*spread_m)))
}

/// Returns the brightness of the bed in each cell with a depth and observations, decibels over the
/// median; NaN in other cells; `None` where there are no such cells.
fn hardness_db(found: &NodeDepths, surface: &Surface) -> Option<Vec<f32>> {
    let nodes = &found.nodes;
    let of_cell = |(cell, depth_m): (usize, &f32)| {
        let centre = surface.grid.centre_of(cell);
        let is_known = !depth_m.is_nan() && found.seen[nodes.nearest(centre)] > 0.5;
        let ln = is_known.then(|| nodes.value_at(&found.ln_brightness, centre));
        ln.map_or(f64::NAN, |ln| 10.0 * ln / std::f64::consts::LN_10)
    };
    let cells_db: Vec<f64> = surface.depth_m.iter().enumerate().map(of_cell).collect();
    let usual_db = median_of(cells_db.iter().copied().filter(|value| !value.is_nan()));
    let of_usual = |value: f64| (value - usual_db) as f32;
    (!usual_db.is_nan()).then(|| cells_db.into_iter().map(of_usual).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::Survey;

    fn grid() -> Grid {
        Grid::at([0.0, 10.0], 1.0, [10, 10])
    }

    #[test]
    fn a_surface_without_echoes_stays_as_it_is_and_says_why() {
        let before = Surface::of_depths(grid(), vec![2.0; 100]);
        let measured = DepthPoint::of_sounding([3.0, 3.0], 2.0);
        let side =
            SideEchoes { near_m: 0.0, step_m: 0.01, first_return: 200.0, above_bottom: false };
        let ping = PingPlace {
            time_s: 0.0,
            place_m: [3.0, 3.0],
            starboard: [1.0, 0.0],
            transducer_m: 0.0,
            sides: [side; 2],
        };
        let survey = Survey::default();
        for (pings, why) in [
            (Vec::new(), LevelsRefused::NoSideScan),
            // Pings without samples.
            (vec![ping; 100], LevelsRefused::NoLaw),
        ] {
            let mut surface = before.clone();
            let logs = vec![LogEchoes { levels: &survey, pings }];
            correct(&mut surface, logs, &[measured], &Progress::new(), SwathDepth::Auto).unwrap();
            assert_eq!(surface.levels, FromLevels::Refused(why));
            assert_eq!(surface.depth_m, before.depth_m);
        }
    }

    #[test]
    fn the_smaller_error_counts_more() {
        let nodes = nodes::Nodes::over(&grid(), 1.0);
        let all = |value: f64| vec![value; nodes.len()];
        let found = NodeDepths {
            nodes,
            depth_m: all(3.0),
            ln_brightness: all(0.0),
            sd_m: all(0.05),
            seen: all(1.0),
        };
        let depth_m = |triangles_error_m: f32| {
            let mut surface = Surface::of_depths(grid(), vec![2.0; 100]);
            surface.spread_is = Spread::OfError;
            surface.spread_m.fill(triangles_error_m);
            surface.distance_m.fill(3.0);
            add(
                &found,
                StatedByLevels { error_sds: 1.0, ..StatedByLevels::UNTESTED },
                &mut surface,
            );
            surface.depth_m[55]
        };
        assert!((depth_m(0.005) - 2.02).abs() < 1e-3, "{}", depth_m(0.005));
        assert!((depth_m(0.5) - 2.995).abs() < 1e-3, "{}", depth_m(0.5));
    }

    #[test]
    fn levels_count_for_nothing_beside_a_measured_depth_and_in_full_away_from_it() {
        assert_eq!(rise(0.4, HELD_M), 0.0);
        assert_eq!(rise(1.6, HELD_M), 1.0);
        assert!((rise(1.0, HELD_M) - 0.5).abs() < 1e-12);
    }
}
