//! Archives whose depths between the lines come from echo levels.

use super::{ZONE, files, sail, scene};
use crate::cli::{refusal, run};
use bathyscope_bottom::bathymetry::{CellSource, Grid, Surface};
use bathyscope_log::formats::geotiff::read_cells;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{Archive, Offsets, TileId, TileInputs, contents};
use bathyscope_simulation::{Mound, Scene, simulate};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use tiff::decoder::{Decoder, DecodingResult};

const LEVELS: [&str; 2] = ["--set", "surface.swath=always"];

/// Three logs around the corner of four tiles, in lines wider apart than those of other tests, in
/// an archive with depths from levels.
fn archive_from_levels(folder: &Path) {
    for log in 0..3 {
        sail(folder, log, &hilly(log));
    }
    add(folder, &LOGS);
}

const LOGS: [&str; 3] = ["log-0.sl2", "log-1.sl2", "log-2.sl2"];

/// A bed of mounds and hollows between lines that are 12 m apart and more.
fn hilly(log: u32) -> Scene {
    let places = (-4..=4).flat_map(|column| (-4..=4).map(move |row| (column, row)));
    let mounds = places.map(|(column, row)| Mound {
        east_m: 7.0 * f64::from(column) + 2.0,
        north_m: 6.0 * f64::from(row) + 3.0,
        radius_m: 2.0,
        height_m: if (column + row) % 2 == 0 { 0.4 } else { -0.3 },
    });
    let mut scene = scene(log, [3.0, -4.0], 0.0);
    scene.track.spacing_m = 12.0;
    scene.bed.mounds = mounds.collect();
    scene
}

fn add(folder: &Path, logs: &[&str]) {
    let to_archive = ["-o", "archive", "--products", "tiles"];
    run(folder, &[&["process"], logs, &to_archive, &LEVELS].concat());
}

/// A strip of 16 m on both sides of an edge.
fn strip(tile: TileId, edge_m: f64) -> Grid {
    let [_, south_m, _, north_m] = tile.bounds_m();
    Grid {
        west_m: edge_m - 16.0,
        north_m,
        cell_m: 0.5,
        columns: 64,
        rows: (2.0 * (north_m - south_m)) as usize,
    }
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

fn cells_from_levels(surface: &Surface) -> usize {
    let is_from_levels = |source: &&CellSource| **source == CellSource::FromLevels;
    surface.source.iter().filter(is_from_levels).count()
}

#[test]
fn tiles_from_levels_meet_to_the_bit_and_are_as_their_neighbours_change() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    archive_from_levels(folder);
    let archive = Archive::open(&folder.join("archive")).expect("an archive");
    let logs = archive.logs().expect("records");
    let tiles: Vec<TileId> = contents(&archive).expect("records").into_keys().collect();
    assert_eq!(tiles.len(), 4);
    let (offsets, progress) = (Offsets::default(), Progress::new());
    let mut compared = 0;
    for west in &tiles {
        let beside = |east: &&TileId| {
            let (a, b) = (west.bounds_m(), east.bounds_m());
            a[2] == b[0] && a[1] == b[1]
        };
        let Some(east) = tiles.iter().find(beside) else {
            continue;
        };
        let edge_m = east.bounds_m()[0];
        let [one, other] = [*west, *east].map(|tile| {
            let grid = strip(*west, edge_m);
            let (archive, logs, offsets) = (&archive, &logs, &offsets);
            let inputs = TileInputs { archive, tile, logs, offsets, progress: &progress };
            inputs.surface(grid).expect("a surface")
        });
        assert_eq!(bits(&one.depth_m), bits(&other.depth_m));
        assert_eq!(bits(&one.spread_m), bits(&other.spread_m));
        assert_eq!(one.source, other.source);
        compared += cells_from_levels(&one);
    }
    assert!(compared > 500, "{compared} cells from levels");

    // The maps are files, a neighbour's rows are what a tile is made from, and the same rows give
    // the same bytes.
    run(folder, &["archive", "archive"]);
    let made = files(&folder.join("archive/tiles"));
    fs::remove_dir_all(folder.join("archive/tiles")).expect("maps");
    run(folder, &["archive", "archive"]);
    assert!(made == files(&folder.join("archive/tiles")));
    let sources = folder.join(format!("archive/tiles/{}/source.tif", tiles[0]));
    let mut decoder = Decoder::new(File::open(sources).expect("a raster")).expect("a TIFF");
    let DecodingResult::U8(sources) = decoder.read_image().expect("classes") else {
        panic!("sources are classes");
    };
    let from_levels = CellSource::FromLevels as u8;
    assert!(sources.iter().filter(|source| **source == from_levels).count() > 100);
    let far = scene(7, [300.0, -300.0], 0.0);
    sail(folder, 7, &far);
    add(folder, &["log-7.sl2"]);
    let stale = run(folder, &["tiles", "archive", "--stale"]);
    for tile in &tiles {
        assert!(stale.contains(&tile.to_string()), "{tile} in {stale}");
    }
}

/// Reads the depths of a raster, by squares of half a metre.
fn depths(path: &Path) -> BTreeMap<[i64; 2], f64> {
    let points = read_cells(path).expect("a raster of depths").points;
    let square = |[x, y, depth_m]: [f64; 3]| ([x, y].map(|m| (2.0 * m).floor() as i64), depth_m);
    points.into_iter().map(square).collect()
}

#[test]
fn an_archive_from_levels_is_corrected_as_the_same_logs_processed_together() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    archive_from_levels(folder);
    let truth = simulate(&hilly(0), 100, &Progress::new()).expect("nobody cancels");
    let to_archive = ["-o", "plain-archive", "--products", "tiles"];
    run(folder, &[&["process"], &LOGS[..], &to_archive].concat());
    let mut maps = Vec::new();
    for (name, swath) in [("levels", "surface.swath=always"), ("plain", "surface.swath=off")] {
        let mut args = [&["process"], &LOGS[..], &["-o", name, "--products", "depth"]].concat();
        for setting in ["surface.method=linear", "surface.cell_m=0.5", swath] {
            args.extend(["--set", setting]);
        }
        run(folder, &args);
        maps.push(depths(&folder.join(format!("{name}/depth/depth.tif"))));
    }
    for name in ["archive", "plain-archive"] {
        run(folder, &["archive", name]);
        let mut all = BTreeMap::new();
        let tiles = folder.join(format!("{name}/tiles"));
        for (file, _) in files(&tiles) {
            if file.ends_with("/depth.tif") {
                all.extend(depths(&tiles.join(file)));
            }
        }
        maps.push(all);
    }
    // Depths of all four maps where all know one, with that of the bed.
    let cells = maps[0].iter().filter_map(|(place, depth_m)| {
        let [plain, archive, plain_archive] = [1, 2, 3].map(|map: usize| maps[map].get(place));
        let at = ZONE.to_lon_lat(place.map(|cell| 0.5 * cell as f64 + 0.25));
        let [east_m, north_m] = truth.frame.to_enu(at);
        let bed_m = truth.bed_depth_m(east_m, north_m);
        Some([*depth_m, *plain?, *archive?, *plain_archive?, bed_m])
    });
    let cells: Vec<[f64; 5]> = cells.collect();
    assert!(cells.len() > 5000, "{}", cells.len());
    let error_m = |map: usize| {
        let squares = cells.iter().map(|cell| (cell[map] - cell[4]).powi(2));
        (squares.sum::<f64>() / cells.len() as f64).sqrt()
    };
    let errors_m = [0, 1, 2, 3].map(error_m);
    let sum = |of: &dyn Fn(&[f64; 5]) -> f64| cells.iter().map(of).sum::<f64>();
    let together = |cell: &[f64; 5]| cell[0] - cell[1];
    let of_archive = |cell: &[f64; 5]| cell[2] - cell[3];
    let correlation = sum(&|cell| together(cell) * of_archive(cell))
        / (sum(&|cell| together(cell).powi(2)) * sum(&|cell| of_archive(cell).powi(2))).sqrt();
    println!("errors {errors_m:.4?} m, corrections correlate {correlation:.3}");
    // The corner of four tiles lies in the middle: each has a quarter of the echoes. An archive
    // learns the curves of each log alone.
    assert!(correlation > 0.6, "{correlation}");
    assert!(errors_m[0] < 0.7 * errors_m[1], "{errors_m:?}");
    assert!(errors_m[2] < 0.95 * errors_m[3], "{errors_m:?}");
}

#[test]
fn an_archive_from_levels_of_large_cells_is_refused() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    sail(folder, 0, &scene(0, [3.0, -4.0], 0.0));
    let args = ["process", "log-0.sl2", "-o", "archive", "--products", "tiles"];
    let with = |setting: &'static str| [&args[..], &LEVELS, &["--set", setting]].concat();
    let refused = refusal(folder, &with("surface.cell_m=4"), 1);
    assert!(refused.contains("2 m at most"), "{refused}");
    let refused = refusal(folder, &with("surface.max_gap_m=195"), 1);
    assert!(refused.contains("at most 190"), "{refused}");
}
