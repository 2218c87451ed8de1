//! Whether levels tell depths: stretches of the soundings are left out and predicted with levels and without.

use super::depths::{Input, LEARNING_ROUNDS};
use super::looks::Sides;
use super::nodes::Nodes;
use super::solve::{Anchor, Brightness, Prior, TileState};
use super::tiling::Tiling;
use crate::bathymetry::{Between, DepthPoint, Tin, merge_repeated};
use crate::progress::{Cancelled, Progress};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

/// Length of a stretch that is left out, metres, and of how many stretches one is.
const STRETCH_M: f64 = 8.0;
const ONE_OF: u64 = 3;
/// Soundings nearer than this to the end of a stretch have others beside them, metres.
const END_M: f64 = 1.0;
/// Least share of the ground that must be seen from two sides.
const LEAST_TWICE: f64 = 0.2;
/// Fewer left-out soundings tell nothing.
const LEAST_SOUNDINGS: usize = 40;
/// Side of the squares that measured depths are merged in, metres, and the least standard deviation of one.
pub const ANCHOR_M: f64 = 0.5;
const SD_ANCHOR_M: f64 = 0.025;
/// How the brightness of the bed may change: what is tried.
const TRIED: [Brightness; 3] = [
    Brightness::Slow(0.05),
    Brightness::Patches(0.35),
    Brightness::Patches(0.8),
];

/// How left-out soundings were predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// Root mean square of the errors of triangles, metres.
    pub without_m: f64,
    /// The same with levels.
    pub with_m: f64,
}

/// Whether enough of the ground in some tiles is seen from two sides: one alone cannot tell a slope from what the bed is made of.
pub fn is_seen_from_two_sides(input: &Input<'_>, tiling: &Tiling, tiles: &[usize]) -> bool {
    let (mut seen, mut twice) = (0, 0);
    for tile in tiles {
        let nodes = tiling.tiles[*tile].core_nodes();
        let mut from = vec![Sides::default(); nodes.len()];
        for look in &input.looks {
            let Some([near_m, far_m]) = look.within(&nodes) else {
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

/// The measured depths as anchors, one a square.
pub fn anchors(measured: &[DepthPoint]) -> Vec<Anchor> {
    let merged = merge_repeated(measured, ANCHOR_M);
    let anchor = |node: &crate::bathymetry::Node| Anchor {
        place_m: [node.east_m, node.north_m],
        depth_m: node.depth_m,
        sd_m: SD_ANCHOR_M.max(0.6 * node.spread_m),
    };
    merged.iter().map(anchor).collect()
}

/// What is left out and what stays.
struct Split {
    kept: Vec<DepthPoint>,
    asked: Vec<DepthPoint>,
}

impl Split {
    /// By the way of the boat up to the ping next to each depth.
    fn of(input: &Input<'_>, measured: &[DepthPoint]) -> Option<Self> {
        let (mut places, mut ways_m) = (Vec::new(), Vec::new());
        for log in input.logs {
            let mut way_m = 0.0;
            let mut last: Option<[f64; 2]> = None;
            for ping in log.echoes.pings.iter().filter(|ping| ping.is_placed()) {
                let step_m = last.map_or(0.0, |last| {
                    (ping.place_m[0] - last[0]).hypot(ping.place_m[1] - last[1])
                });
                way_m += step_m;
                last = Some(ping.place_m);
                places.push(ping.place_m);
                ways_m.push(way_m);
            }
        }
        let tree = ImmutableKdTree::<f64, 2>::new_from_slice(&places).ok()?;
        let mut split = Self {
            kept: Vec::new(),
            asked: Vec::new(),
        };
        for point in measured.iter().filter(|point| point.weight > 0.0) {
            let place = [point.east_m, point.north_m];
            let nearest = tree
                .query(&place)
                .nearest_one::<SquaredEuclidean<f64>>()
                .execute();
            let way_m = ways_m[nearest.item as usize];
            let along_m = way_m % STRETCH_M;
            if (way_m / STRETCH_M) as u64 % ONE_OF != 1 {
                split.kept.push(*point);
            } else if point.is_sounding && (END_M..STRETCH_M - END_M).contains(&along_m) {
                split.asked.push(*point);
            }
        }
        Some(split)
    }
}

/// Shares of the error of triangles that the relief between lines is taken for, and its bounds, metres.
const RELIEF_SHARE: f64 = 1.1;
const RELIEF_M: [f64; 2] = [0.15, 0.4];

/// What is known of the bed beforehand, as it predicts left-out soundings best, with how it does; `None` where too few can be left out.
pub fn choose(
    input: &Input<'_>,
    measured: &[DepthPoint],
    tiling: &Tiling,
    tiles: &[usize],
    progress: &Progress,
) -> Result<Option<(Prior, LeftOut)>, Cancelled> {
    let Some(split) = Split::of(input, measured) else {
        return Ok(None);
    };
    let Some(tin) = Tin::new(merge_repeated(&split.kept, ANCHOR_M)) else {
        return Ok(None);
    };
    let mut triangles = tin.sampler(Between::Linear);
    let parts: Vec<Nodes> = tiles
        .iter()
        .map(|tile| tiling.tiles[*tile].core_nodes())
        .collect();
    let mut asked: Vec<(DepthPoint, f64)> = Vec::new();
    for point in split.asked {
        let place = [point.east_m, point.north_m];
        if parts.iter().any(|nodes| nodes.holds(place)) {
            asked.extend(triangles.depth_at(place).map(|depth_m| (point, depth_m)));
        }
    }
    if asked.len() < LEAST_SOUNDINGS {
        return Ok(None);
    }
    progress.start((TRIED.len() * LEARNING_ROUNDS * tiles.len()) as u64);
    let anchors = anchors(&split.kept);
    let without_m = rms(asked.iter().map(|(point, depth_m)| depth_m - point.depth_m));
    let relief_m = (RELIEF_SHARE * without_m).clamp(RELIEF_M[0], RELIEF_M[1]);
    let mut best: Option<(Prior, LeftOut)> = None;
    for brightness in TRIED {
        let prior = Prior {
            brightness,
            relief_m,
        };
        let Some((_, states)) = input.learn(tiling, tiles, &anchors, prior, progress)? else {
            continue;
        };
        let predicted_m = |point: &DepthPoint| {
            let place = [point.east_m, point.north_m];
            let holds = |state: &&TileState| tiling.tiles[state.tile].core_nodes().holds(place);
            let bed = &states.iter().find(holds)?.bed;
            Some(bed.nodes.value_at(&bed.depth_m, place))
        };
        let errors: Vec<f64> = asked
            .iter()
            .map(|(point, triangles_m)| predicted_m(point).unwrap_or(*triangles_m) - point.depth_m)
            .collect();
        let found = LeftOut {
            without_m,
            with_m: rms(errors.into_iter()),
        };
        if best.is_none_or(|(_, best)| found.with_m < best.with_m) {
            best = Some((prior, found));
        }
    }
    Ok(best)
}

fn rms(errors: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = errors.len().max(1) as f64;
    (errors.map(|error| error * error).sum::<f64>() / count).sqrt()
}
