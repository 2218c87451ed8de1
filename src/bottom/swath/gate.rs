//! Tests whether levels determine depths, by cross-validation: stretches of the soundings are left
//! out and predicted with and without levels.

use super::depths::{LEARNING_ROUNDS, Sample, SwathInput, Tiling, merged};
use super::model::LawCurves;
use super::observations::{Bed, SeenOctants};
use super::solve::{Brightness, Prior, TileSolution};
use crate::bathymetry::{BentSampler, DepthPoint, Tin};
use crate::nearest::Nearest;
use bathyscope_log::support::progress::{Cancelled, Progress};

/// Length of a stretch, metres, and number of consecutive stretches of which one is left out.
const STRETCH_M: f64 = 8.0;
const ONE_OF: u64 = 3;
/// Distance from the ends of a left-out stretch within which soundings are not tested, metres: kept
/// soundings are too near.
const END_M: f64 = 1.0;
/// Least share of the seen ground that must be seen from two sides.
const LEAST_TWICE: f64 = 0.2;
/// Least number of left-out soundings for a test.
const LEAST_SOUNDINGS: usize = 40;
/// Priors of the change of the bed's brightness that are tried.
const TRIED: [Brightness; 3] =
    [Brightness::Slow(0.05), Brightness::Patches(0.35), Brightness::Patches(0.8)];

/// Errors in the prediction of left-out soundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LeftOut {
    /// Root mean square of the errors without levels, by triangles, metres.
    pub without_m: f64,
    /// Root mean square of the errors with levels, metres.
    pub with_m: f64,
    /// Geometric mean of both errors, in standard deviations of the depth by the equations at these
    /// soundings.
    pub error_sds: f64,
}

/// Returns true if enough of the ground in some tiles is seen from two sides: one side alone cannot
/// distinguish a slope from the material of the bed.
pub(super) fn is_seen_from_two_sides(
    input: &SwathInput<'_>,
    tiling: &Tiling,
    tiles: &[usize],
) -> bool {
    let (mut seen, mut twice) = (0, 0);
    for tile in tiles {
        let nodes = tiling.tiles[*tile].core_nodes();
        let mut from = vec![SeenOctants::default(); nodes.len()];
        for look in &input.looks {
            let Some([near_m, far_m]) = look.ranges_within(&nodes) else {
                continue;
            };
            let steps = ((far_m - near_m) / nodes.step_m) as usize;
            for step in 0..=steps {
                let place = look.at(near_m + step as f64 * nodes.step_m);
                from[nodes.nearest(place)].add(look.outward);
            }
        }
        seen += from.iter().filter(|from| from.is_any()).count();
        twice += from.iter().filter(|from| from.are_two()).count();
    }
    twice as f64 >= LEAST_TWICE * seen as f64
}

/// Divides the depths, by the distance that the boat had sailed up to the ping nearest to each,
/// into those that are kept and those that are left out and predicted; `None` without placed pings.
fn split(input: &SwathInput<'_>, measured: &[DepthPoint]) -> Option<[Vec<DepthPoint>; 2]> {
    let (mut places, mut ways_m) = (Vec::new(), Vec::new());
    for log in input.logs {
        let mut way_m = 0.0;
        let mut last: Option<[f64; 2]> = None;
        for ping in log.echoes.pings.iter().filter(|ping| ping.is_placed()) {
            let step_m = last
                .map_or(0.0, |last| (ping.place_m[0] - last[0]).hypot(ping.place_m[1] - last[1]));
            way_m += step_m;
            last = Some(ping.place_m);
            places.push(ping.place_m);
            ways_m.push(way_m);
        }
    }
    let nearest = Nearest::of(&places)?;
    let (mut kept, mut asked) = (Vec::new(), Vec::new());
    for point in measured.iter().filter(|point| point.weight > 0.0) {
        let (ping, _) = nearest.at(point.place());
        let way_m = ways_m[ping];
        let along_m = way_m % STRETCH_M;
        if (way_m / STRETCH_M) as u64 % ONE_OF != 1 {
            kept.push(*point);
        } else if point.is_sounding && (END_M..STRETCH_M - END_M).contains(&along_m) {
            asked.push(*point);
        }
    }
    Some([kept, asked])
}

/// Relief between the lines as a multiple of the error of triangles, and its bounds, metres.
const RELIEF_SHARE: f64 = 1.1;
const RELIEF_M: [f64; 2] = [0.15, 0.4];

/// Prior that predicts left-out soundings best, with its results.
pub(super) struct PriorChoice {
    /// Prior knowledge of the bed.
    pub prior: Prior,
    /// Errors of the prediction of left-out soundings.
    pub left_out: LeftOut,
    /// Curves that were learnt with this prior.
    pub curves: Vec<Option<LawCurves>>,
}

/// Returns the best of the priors that are tried; `None` where too few soundings can be left out,
/// or no curves can be learnt.
pub(super) fn choose(
    input: &SwathInput<'_>,
    measured: &[DepthPoint],
    tiling: &Tiling,
    tiles: &[usize],
    progress: &Progress,
) -> Result<Option<PriorChoice>, Cancelled> {
    let Some([kept, left_out]) = split(input, measured) else {
        return Ok(None);
    };
    let kept = merged(&kept);
    let mut sample = Sample::new(input, tiling, tiles, &kept, None);
    let slopes = input.bends.map(|bends| bends.slopes(&kept));
    let Some(tin) = Tin::new(kept) else {
        return Ok(None);
    };
    let mut triangles = BentSampler::new(&tin, slopes.as_ref());
    let mut asked: Vec<Asked> = Vec::new();
    for point in left_out {
        let place = point.place();
        let is_in_core = |state: &TileSolution| tiling.tiles[state.tile].core_nodes().holds(place);
        if let Some(state) = sample.states.iter().position(is_in_core) {
            asked.extend(triangles.depth_at(place).map(|triangles_m| Asked {
                place,
                depth_m: point.depth_m,
                triangles_m,
                state,
            }));
        }
    }
    if asked.len() < LEAST_SOUNDINGS {
        return Ok(None);
    }
    let without_m = rms(asked.iter().map(|sounding| sounding.triangles_m - sounding.depth_m));
    let relief_m = (RELIEF_SHARE * without_m).clamp(RELIEF_M[0], RELIEF_M[1]);
    let [first, further] = LEARNING_ROUNDS;
    let rounds = first + (TRIED.len() - 1) * further;
    progress.start((rounds * tiles.len()) as u64);
    let mut best: Option<PriorChoice> = None;
    for brightness in TRIED {
        let prior = Prior { brightness, relief_m };
        if !sample.learn(input, prior, progress)? {
            break;
        }
        let at = |sounding: &Asked, values: fn(&Bed) -> &[f64]| {
            let bed = &sample.states[sounding.state].bed;
            bed.nodes.value_at(values(bed), sounding.place)
        };
        let with_m =
            rms(asked.iter().map(|sounding| at(sounding, |bed| &bed.depth_m) - sounding.depth_m));
        let sd_m = rms(asked.iter().map(|sounding| at(sounding, |bed| &bed.sd_m)));
        let left_out = LeftOut { without_m, with_m, error_sds: (with_m * without_m).sqrt() / sd_m };
        let before = best.as_ref().map(|best| best.left_out.with_m);
        if before.is_none_or(|before| with_m < before) {
            best = Some(PriorChoice { prior, left_out, curves: sample.curves.clone() });
        }
    }
    Ok(best)
}

/// Left-out sounding to predict.
struct Asked {
    place: [f64; 2],
    depth_m: f64,
    /// Depth by the triangles between the kept depths, metres.
    triangles_m: f64,
    /// Index of the tile of the sample whose core holds the sounding.
    state: usize,
}

fn rms(errors: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = errors.len() as f64;
    (errors.map(|error| error * error).sum::<f64>() / count).sqrt()
}
