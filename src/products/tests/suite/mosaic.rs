//! The mosaic of simulated surveys: objects at their true places, no holes, no seams, even levels.

use crate::detection_targets::trough;
use crate::truth::{KnownSurvey, Mission};
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::mosaic::{
    Gain, GainTable, MosaicLayout, MosaicLog, MosaicSettings, Overlap, TILE_CELLS, TileIndex,
    gain_table, joint_tile, window,
};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::pipeline::Products;
use bathyscope_simulation::{ObjectKind, ObjectPass, ObjectSettings, Scene};
use std::sync::Arc;

/// Places of the echoes of a survey in a plane.
pub(super) fn layout(
    survey: &Survey,
    products: &Products,
    settings: &MosaicSettings,
    plane: impl Fn([f64; 2]) -> [f64; 2],
) -> MosaicLayout {
    let Products { navigation, returns, calibration, .. } = products;
    MosaicLayout::new(survey, navigation, returns, calibration, settings, plane)
}

/// A mosaic with all its tiles.
struct Drawn {
    grid: Grid,
    levels: Vec<u8>,
}

impl Drawn {
    fn of(
        survey: &Survey,
        products: &Products,
        settings: &MosaicSettings,
        plane: impl Fn([f64; 2]) -> [f64; 2],
    ) -> Self {
        let layout = layout(survey, products, settings, plane);
        let grid = layout.grid(settings.cell_m).expect("something is shown");
        let gain = gain_table(survey, &layout, &Progress::new()).expect("nobody cancels");
        Self::on(survey, settings, &layout, grid, &gain)
    }

    fn on(
        survey: &Survey,
        settings: &MosaicSettings,
        layout: &MosaicLayout,
        grid: Grid,
        gain: &GainTable,
    ) -> Self {
        let index: TileIndex = layout.index(&grid);
        let (layout, gain) = (Arc::new(layout.clone()), gain.clone());
        let log = MosaicLog { survey: Arc::new(survey.clone()), layout, gain };
        let mut levels = vec![0; grid.columns * grid.rows];
        for (row, column) in index.tiles() {
            let drawn = joint_tile(&[(&log, &index)], &grid, settings, [row, column]);
            for (cell, &level) in drawn.iter().enumerate() {
                let y = row * TILE_CELLS + cell / TILE_CELLS;
                let x = column * TILE_CELLS + cell % TILE_CELLS;
                if x < grid.columns && y < grid.rows {
                    levels[y * grid.columns + x] = level;
                }
            }
        }
        Self { grid, levels }
    }

    fn at(&self, east_m: f64, north_m: f64) -> u8 {
        self.grid.index_at(east_m, north_m).map_or(0, |cell| self.levels[cell])
    }
}

/// A straight line over quiet, level ground.
fn quiet_line() -> Scene {
    let mut scene = Scene::gentle();
    scene.artefacts = Default::default();
    scene.track.lines = 1;
    scene.track.cross_lines = 0;
    scene
}

/// Middle of the brightest twentieth within 1.5 m of a place, metres from it.
fn echo_off_m(drawn: &Drawn, [east_m, north_m]: [f64; 2]) -> f64 {
    let steps = (1.5 / drawn.grid.cell_m) as i32;
    let mut near = Vec::new();
    for (dx, dy) in (-steps..=steps).flat_map(|dx| (-steps..=steps).map(move |dy| (dx, dy))) {
        let [x, y] = [dx, dy].map(|steps| f64::from(steps) * drawn.grid.cell_m);
        if x.hypot(y) <= 1.5 {
            near.push((drawn.at(east_m + x, north_m + y), x, y));
        }
    }
    near.sort_by_key(|cell| std::cmp::Reverse(cell.0));
    near.truncate(near.len() / 20);
    let mean =
        |value: fn(&(u8, f64, f64)) -> f64| near.iter().map(value).sum::<f64>() / near.len() as f64;
    f64::hypot(mean(|cell| cell.1), mean(|cell| cell.2))
}

/// The results with the pings around a sighting alone.
fn only(products: &Products, seen: &ObjectPass) -> Products {
    let mut products = products.clone();
    let mut navigation = (*products.navigation).clone();
    let shown = seen.first_ping.saturating_sub(40)..seen.last_ping + 40;
    for (ping, place) in Arc::make_mut(&mut navigation.pings).iter_mut().enumerate() {
        if !shown.contains(&ping) {
            place.heading_rad = f64::NAN;
        }
    }
    products.navigation = Arc::new(navigation);
    products
}

#[test]
fn an_object_seen_from_two_lines_lands_at_its_true_place_both_times() {
    let mut scene = quiet_line();
    scene.track.lines = 2;
    scene.track.spacing_m = 10.0;
    scene.objects = vec![ObjectSettings {
        kind: ObjectKind::Block,
        east_m: 2.0,
        north_m: 3.0,
        length_m: 0.6,
        width_m: 0.6,
        height_m: 0.25,
        heading_deg: 20.0,
        buried_m: 0.0,
        strength_db: Some(8.0),
    }];
    let Mission { known, products } = Mission::new(&scene, 5);
    let object = &known.truth.objects[0];
    let settings = MosaicSettings { cell_m: 0.05, ..MosaicSettings::default() };
    let mut sides = Vec::new();
    for seen in object.sightings.iter().filter(|seen| seen.last_ping > seen.first_ping + 3) {
        let drawn = Drawn::of(&known.survey, &only(&products, seen), &settings, |place| place);
        let off_m = echo_off_m(&drawn, [object.east_m, object.north_m]);
        println!(
            "{:?} at pings {}..{}: off by {off_m:.2} m",
            seen.side, seen.first_ping, seen.last_ping
        );
        assert!(off_m < 0.5, "{off_m}");
        sides.push(seen.side);
    }
    assert!(sides.len() >= 2, "{sides:?}");
    // Without the slant-range correction it does not.
    let slant = MosaicSettings { water_column: true, ..settings };
    let wrong = object.sightings.iter().map(|seen| {
        let drawn = Drawn::of(&known.survey, &only(&products, seen), &slant, |place| place);
        echo_off_m(&drawn, [object.east_m, object.north_m])
    });
    let farthest_m = wrong.fold(0.0, f64::max);
    assert!(farthest_m > 0.5, "{farthest_m}");
}

#[test]
fn echoes_of_a_bank_lie_where_it_is_and_not_where_a_level_bottom_has_them() {
    let Mission { known, products } = Mission::new(&trough(), 2);
    let level = layout(&known.survey, &products, &MosaicSettings::default(), |place| place);
    let measured = level.clone().with_relief(&products.relief);
    let [by_relief, by_level] = [measured, level].map(|layout| {
        let mut off_m = Vec::new();
        for object in &known.truth.objects {
            for seen in &object.sightings {
                let ping = usize::midpoint(seen.first_ping, seen.last_ping);
                // In a turn nothing is shown.
                let Some(ray) = layout.ray(ping, seen.side) else {
                    continue;
                };
                let sample = ray.sample_at(0.5 * (seen.near_m + seen.far_m));
                let beside = |ground_m: &f64| (ray.sample_of(*ground_m, false) - sample).abs();
                let steps = 0..(100.0 * ray.reach_m(false)) as u32;
                let ground_m = steps
                    .map(|step| 0.01 * f64::from(step))
                    .min_by(|a, b| beside(a).total_cmp(&beside(b)));
                let [east_m, north_m] = ray.place(ground_m.expect("a reach"));
                off_m.push(f64::hypot(east_m - object.east_m, north_m - object.north_m));
            }
        }
        off_m.sort_by(f64::total_cmp);
        println!("{off_m:.2?}");
        [off_m[off_m.len() / 2], off_m[9 * off_m.len() / 10]]
    });
    assert!(by_level[0] > 0.8, "{by_level:?}");
    assert!(by_relief[0] < 0.4 && by_relief[1] < 0.9, "{by_relief:?}");
}

#[test]
fn a_bend_leaves_no_holes() {
    let mut scene = quiet_line();
    scene.track.bend_deg_per_m = 2.0;
    let Mission { known, products } = Mission::new(&scene, 3);
    let settings = MosaicSettings::default();
    let drawn = Drawn::of(&known.survey, &products, &settings, |place| place);
    let seen = |x: usize, y: usize| drawn.levels[y * drawn.grid.columns + x] > 0;
    let (mut shown, mut holes) = (0, 0);
    for y in 1..drawn.grid.rows - 1 {
        for x in 1..drawn.grid.columns - 1 {
            shown += usize::from(seen(x, y));
            let ringed = seen(x - 1, y) && seen(x + 1, y) && seen(x, y - 1) && seen(x, y + 1);
            holes += usize::from(!seen(x, y) && ringed);
        }
    }
    assert!(shown > 10_000, "{shown}");
    assert_eq!(holes, 0);
}

#[test]
fn tiles_meet_without_a_seam() {
    let Mission { known: KnownSurvey { survey, .. }, products } = Mission::new(&quiet_line(), 4);
    let settings = MosaicSettings::default();
    let whole = Drawn::of(&survey, &products, &settings, |place| place);
    // The same cells, cut into other tiles.
    let layout = layout(&survey, &products, &settings, |place| place);
    let gain = gain_table(&survey, &layout, &Progress::new()).expect("nobody cancels");
    let moved = Grid {
        west_m: whole.grid.west_m - 100.0 * whole.grid.cell_m,
        north_m: whole.grid.north_m + 37.0 * whole.grid.cell_m,
        columns: whole.grid.columns + 100,
        rows: whole.grid.rows + 37,
        ..whole.grid
    };
    let other = Drawn::on(&survey, &settings, &layout, moved, &gain);
    let mut differing = 0;
    for y in 0..whole.grid.rows {
        for x in 0..whole.grid.columns {
            let (a, b) = (
                whole.levels[y * whole.grid.columns + x],
                other.levels[(y + 37) * moved.columns + x + 100],
            );
            // Edges of cells are rounded differently in the two grids: a level, or a cell at the
            // very edge.
            differing += usize::from(a.abs_diff(b) > 1);
        }
    }
    assert!(differing * 1000 < whole.levels.len(), "{differing}");
}

/// Level of the whole cells of a window over a survey, with a layout thinned to `apart_m` between
/// pings.
fn seen_through_window(survey: &Survey, products: &Products, grid: &Grid, apart_m: f64) -> Vec<u8> {
    let (settings, progress) = (MosaicSettings::default(), Progress::new());
    let layout = layout(survey, products, &settings, |place| place);
    let gain = gain_table(survey, &layout, &progress).expect("nobody cancels");
    let layout = layout.thinned(apart_m);
    window(survey, &layout, grid, &gain, &settings, &progress).expect("nobody cancels")
}

#[test]
fn a_window_shows_what_the_tiles_show() {
    let Mission { known: KnownSurvey { survey, .. }, products } = Mission::new(&quiet_line(), 4);
    let whole = Drawn::of(&survey, &products, &MosaicSettings::default(), |place| place);
    let (first_row, first_column) = (whole.grid.rows / 3, whole.grid.columns / 4);
    let grid = Grid {
        west_m: whole.grid.west_m + first_column as f64 * whole.grid.cell_m,
        north_m: whole.grid.north_m - first_row as f64 * whole.grid.cell_m,
        columns: whole.grid.columns / 2,
        rows: whole.grid.rows / 3,
        ..whole.grid
    };
    let seen = seen_through_window(&survey, &products, &grid, 0.0);
    let mut differing = 0;
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let there = (row + first_row) * whole.grid.columns + column + first_column;
            let levels = [seen[row * grid.columns + column], whole.levels[there]];
            differing += usize::from(levels[0].abs_diff(levels[1]) > 1);
        }
    }
    assert!(differing * 1000 < seen.len(), "{differing} of {}", seen.len());
    assert!(seen.iter().filter(|level| **level > 0).count() * 3 > seen.len());
}

#[test]
fn a_coarse_window_needs_few_pings_and_shows_the_same_ground() {
    let Mission { known: KnownSurvey { survey, .. }, products } = Mission::new(&quiet_line(), 4);
    let fine = Drawn::of(&survey, &products, &MosaicSettings::default(), |place| place);
    // Cells of eight, whose mean level the few pings have to give.
    let grid = Grid {
        cell_m: 8.0 * fine.grid.cell_m,
        columns: fine.grid.columns / 8,
        rows: fine.grid.rows / 8,
        ..fine.grid
    };
    let seen = seen_through_window(&survey, &products, &grid, 0.7 * grid.cell_m);
    // One ping for each cell, as it happens to run through its middle.
    let picked = seen_through_window(&survey, &products, &grid, 0.0);
    let (mut holes, mut sum, mut count) = (0, 0.0, 0.0);
    let mut squares = [0.0; 2];
    for (cell, level) in seen.iter().enumerate() {
        let (row, column) = (cell / grid.columns, cell % grid.columns);
        let under = (0..64).map(|index| {
            let (y, x) = (8 * row + index / 8, 8 * column + index % 8);
            fine.levels[y * fine.grid.columns + x]
        });
        let known: Vec<f64> = under.filter(|&level| level > 0).map(f64::from).collect();
        if known.len() < 64 {
            continue;
        }
        holes += usize::from(*level == 0);
        let mean = known.iter().sum::<f64>() / 64.0;
        sum += f64::from(*level) - mean;
        for (square, level) in squares.iter_mut().zip([*level, picked[cell]]) {
            *square += (f64::from(level) - mean).powi(2);
        }
        count += 1.0;
    }
    assert!(count > 100.0 && holes == 0, "{holes} holes in {count}");
    assert!((sum / count).abs() < 4.0, "brighter by {}", sum / count);
    let [off, picked_off] = squares.map(|square| f64::sqrt(square / count));
    println!(
        "off the mean of the fine cells: {off:.1} levels, {picked_off:.1} when pings are picked"
    );
    assert!(off < 0.6 * picked_off, "{off} {picked_off}");
}

#[test]
fn gain_makes_the_ground_even_across_the_track() {
    let Mission { known, products } = Mission::new(&quiet_line(), 6);
    let uneven = |gain: Gain| {
        let settings =
            MosaicSettings { gain, overlap: Overlap::Later, ..MosaicSettings::default() };
        let drawn = Drawn::of(&known.survey, &products, &settings, |place| place);
        // Mean level by distance from the line, which runs east through the middle.
        let middle_m = drawn.grid.north_m - 0.5 * drawn.grid.rows as f64 * drawn.grid.cell_m;
        let mut bands: Vec<[f64; 2]> = vec![[0.0; 2]; 10];
        let half_m = 0.45 * drawn.grid.rows as f64 * drawn.grid.cell_m;
        for (cell, &level) in drawn.levels.iter().enumerate().filter(|(_, level)| **level > 0) {
            let north_m =
                drawn.grid.north_m - (cell / drawn.grid.columns) as f64 * drawn.grid.cell_m;
            let band = ((north_m - middle_m).abs() / half_m * 10.0) as usize;
            if (1..10).contains(&band) {
                bands[band] = [bands[band][0] + f64::from(level), bands[band][1] + 1.0];
            }
        }
        let means: Vec<f64> = bands[1..].iter().map(|band| band[0] / band[1]).collect();
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        let spread = means.iter().map(|band| (band - mean).abs()).fold(0.0, f64::max);
        spread / mean
    };
    let (recorded, even) = (uneven(Gain::Recorded), uneven(Gain::Empirical));
    println!(
        "largest departure of a band from the mean: {recorded:.3} recorded, {even:.3} gain-normalised"
    );
    assert!(even < 0.1 && even < 0.5 * recorded, "{recorded} {even}");
}

#[test]
fn a_turned_plane_turns_the_mosaic() {
    let Mission { known, products } = Mission::new(&quiet_line(), 4);
    let settings = MosaicSettings::default();
    let straight = Drawn::of(&known.survey, &products, &settings, |place| place);
    // A quarter turn, and away: what lay at (x, y) lies at (1000 - y, x).
    let turned = Drawn::of(&known.survey, &products, &settings, |[x, y]| [1000.0 - y, x]);
    let (mut same, mut all) = (0, 0);
    for y in (3..straight.grid.rows - 3).step_by(5) {
        for x in (3..straight.grid.columns - 3).step_by(5) {
            let level = straight.levels[y * straight.grid.columns + x];
            let east_m = straight.grid.west_m + (x as f64 + 0.5) * straight.grid.cell_m;
            let north_m = straight.grid.north_m - (y as f64 + 0.5) * straight.grid.cell_m;
            if level > 0 {
                all += 1;
                same += usize::from(turned.at(1000.0 - north_m, east_m).abs_diff(level) <= 1);
            }
        }
    }
    assert!(all > 1000 && same * 100 > all * 98, "{same} of {all}");
}

#[test]
fn ranges_follow_the_speed_of_sound() {
    let Mission { known: KnownSurvey { survey, .. }, products } = Mission::new(&quiet_line(), 4);
    let layout = layout(&survey, &products, &MosaicSettings::default(), |place| place);
    let slower = layout.clone().with_range_factor(0.97);
    let mut seen = 0;
    for ping in 0..survey.side_scan.len() {
        let rays = [&layout, &slower].map(|layout| layout.ray(ping, Side::Port));
        let [Some(before), Some(after)] = rays else {
            continue;
        };
        seen += 1;
        let near = |found: f64, expected: f64| (found - expected).abs() < 1e-4;
        assert!(near(after.altitude_m, 0.97 * before.altitude_m));
        assert!(near(after.reach_m(false), 0.97 * before.reach_m(false)));
        assert!(near(after.range_m(100.0), 0.97 * before.range_m(100.0)));
        assert_eq!(after.at, before.at);
    }
    assert!(seen > 50);
    let width = |layout: &MosaicLayout| {
        let [west, south, east, north] = layout.bounds().expect("ground");
        (east - west).min(north - south)
    };
    assert!(width(&slower) < width(&layout));
}
