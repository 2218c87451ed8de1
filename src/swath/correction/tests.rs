//! A mound on an inclined bed, between two lines, whose echoes are those of the law without any noise.

use super::*;
use crate::bathymetry::Grid;
use crate::swath::echo_law::{AtSlope, ln_power};
use crate::swath::pieces::Piece;
use crate::swath::tiling::{CORE, HALO, MOST_NODES, NODE_M};

const LINES_M: [f64; 2] = [4.0, 12.0];
const MOUND_M: [f64; 2] = [12.0, 8.3];
const HEIGHT_M: f64 = 0.3;
const RADIUS_M: f64 = 1.5;

/// Depth as the soundings have it: the incline without the mound.
fn plain_m([_, north_m]: [f64; 2]) -> f64 {
    2.6 + 0.05 * north_m
}

fn mound_m([east_m, north_m]: [f64; 2]) -> f64 {
    let away = (east_m - MOUND_M[0]).hypot(north_m - MOUND_M[1]) / RADIUS_M;
    -HEIGHT_M * (-away * away).exp()
}

fn bed_m(place: [f64; 2]) -> f64 {
    plain_m(place) + mound_m(place)
}

/// What a piece reads on a surface of some depths: the echo at its slant range comes from where the bed is.
fn reading(
    depth_m: impl Fn([f64; 2]) -> f64,
    line: usize,
    chunk: u32,
    side: Side,
    ground_m: f64,
) -> Reading {
    let boat = [0.25 * f64::from(chunk) + 0.125, LINES_M[line]];
    let sign = if side == Side::Port { 1.0 } else { -1.0 };
    let at = |ground_m: f64| [boat[0], boat[1] + sign * ground_m];
    let range_m = ground_m.hypot(depth_m(at(ground_m)));
    let slope_of = |depth_m: &dyn Fn([f64; 2]) -> f64, ground_m: f64| {
        (depth_m(at(ground_m + 0.1)) - depth_m(at(ground_m - 0.1))) / 0.2
    };
    // Slant range to the bed, inverted by halving.
    let (mut near_m, mut far_m) = (0.0, 2.0 * ground_m);
    for _ in 0..60 {
        let middle_m = 0.5 * (near_m + far_m);
        match middle_m.hypot(bed_m(at(middle_m))) < range_m {
            true => near_m = middle_m,
            false => far_m = middle_m,
        }
    }
    let bed_angle_rad = near_m.atan2(bed_m(at(near_m)));
    let slope = slope_of(&bed_m, near_m);
    let of_bed = AtSlope::new(bed_angle_rad, slope).ln_over_level + ln_power(bed_angle_rad);
    let beam = -0.4 * bed_angle_rad.powi(2);
    Reading {
        piece: Piece {
            chunk: ChunkId {
                log: line as u32,
                number: chunk,
            },
            range_setting: 0,
            side,
            samples: 120,
            level: 50.0,
            noise_level: 5.0,
            ground_m,
            phi_rad: ground_m.atan2(depth_m(at(ground_m))),
            range_m,
            place_m: at(ground_m),
            outward: [0.0, sign],
            slope: slope_of(&depth_m, ground_m),
        },
        ln_level: of_bed + beam,
        share: 1.0,
    }
}

/// The pieces of both lines on the incline as corrected so far.
fn readings(nodes: &Nodes, state: &State) -> Vec<Reading> {
    let corrected_m = |place| plain_m(place) + nodes.value_at(&state.correction_m, place);
    let mut found = Vec::new();
    for line in 0..2 {
        for chunk in 0..96 {
            for side in Side::BOTH {
                let across = (0..20).map(|bin| 1.25 + 0.5 * f64::from(bin));
                found.extend(
                    across.map(|ground_m| reading(corrected_m, line, chunk, side, ground_m)),
                );
            }
        }
    }
    let inside = |reading: &Reading| {
        let phi_deg = reading.piece.phi_rad.to_degrees();
        nodes.holds(reading.piece.place_m) && (20.0..70.0).contains(&phi_deg)
    };
    found.retain(inside);
    found
}

const GRID: Grid = Grid {
    west_m: 0.0,
    north_m: 16.0,
    cell_m: 0.25,
    columns: 96,
    rows: 64,
};

/// Both lines' depths.
fn anchors() -> Vec<[f64; 2]> {
    (0..96)
        .flat_map(|step| LINES_M.map(|north_m| [0.25 * f64::from(step) + 0.125, north_m]))
        .collect()
}

/// All rounds over the mound, with at most `most` nodes solved for together and cores of `core` a side.
fn solved(nodes: Nodes, anchors: &[[f64; 2]], most: usize, core: usize) -> State {
    let depth_m: Vec<f32> = (0..GRID.len())
        .map(|cell| plain_m(GRID.centre(cell / 96, cell % 96)) as f32)
        .collect();
    let ground = Ground::new(GRID, &depth_m).unwrap();
    let given = Given {
        logs: &[],
        ground: &ground,
        anchors,
        usual_m: 0.05,
        weed: Weed::of(&[]),
        nodes,
    };
    let tiles = nodes.tiles(most, core, HALO);
    let mut state = State::new(&nodes, tiles.len(), given.usual_m);
    let steps = BTreeSet::new();
    let all: Vec<usize> = (0..tiles.len()).collect();
    let due = Due {
        tiles: &tiles,
        solved: &all,
    };
    for _ in 0..ROUNDS {
        let found = readings(&nodes, &state);
        let solved = state.solve(&given, &due, &found, &steps, SAMPLES, &Progress::new());
        assert!(solved.unwrap());
    }
    let progress = Progress::new();
    progress.cancel();
    let found = readings(&nodes, &state);
    let cancelled = state.solve(&given, &due, &found, &steps, SAMPLES, &progress);
    assert!(cancelled.is_err());
    state
}

#[test]
fn a_mound_between_two_lines_is_found_and_measured_depths_stay() {
    let nodes = Nodes::over(&GRID, NODE_M);
    let anchors = anchors();
    let state = solved(nodes, &anchors, MOST_NODES, CORE);
    let at = |place: [f64; 2]| nodes.value_at(&state.correction_m, place);
    let (mut before, mut after) = (0.0, 0.0);
    for cell in 0..GRID.len() {
        let place = GRID.centre(cell / 96, cell % 96);
        before += mound_m(place).powi(2);
        after += (at(place) - mound_m(place)).powi(2);
    }
    let left = (after / before).sqrt();
    // The stated noise and two looks from opposite sides leave some of it: a slope along both lines is not seen.
    assert!(left < 0.5, "{left} of the mound is left");
    let top_m = at(MOUND_M);
    assert!((-HEIGHT_M..-0.5 * HEIGHT_M).contains(&top_m), "{top_m}");
    let moved_m = anchors
        .iter()
        .map(|place| at(*place).abs())
        .fold(0.0, f64::max);
    assert!(moved_m < 0.03, "{moved_m}");
}

#[test]
fn tiles_find_what_one_solution_of_all_finds() {
    let nodes = Nodes::over(&GRID, NODE_M);
    let anchors = anchors();
    let [whole, tiled] = [(MOST_NODES, CORE), (1, 12)].map(|(most, core)| {
        assert!((nodes.tiles(most, core, HALO).len() == 1) == (core == CORE));
        solved(nodes, &anchors, most, core).correction_m
    });
    let apart_m = whole
        .iter()
        .zip(&tiled)
        .map(|(one, other)| (one - other).abs());
    let most_m = apart_m.fold(0.0, f64::max);
    // Cores of a sixth of the usual side, so that the mound lies across their edges; each tile draws its own samples.
    assert!(most_m < 0.015, "{most_m}");
}
