//! The maps of tiles: parts of one map, to the bit, and made again only where their logs changed.

use super::{CORNER_M, ZONE, add, files, sail, scene, three_logs, zigzag};
use crate::cli::{refusal, run};
use bathyscope_bottom::bathymetry::{DepthPoint, Grid, Surface, local_surface};
use bathyscope_log::formats::parquet_table::{Values, read_parquet};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{Archive, Offsets, TILE_M, TileId, TileInputs, contents};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The points of a tile that count, as any reader of the rows sees them; with those of the halo or
/// without.
fn points(archive: &Archive, tile: TileId, halo: bool) -> Vec<DepthPoint> {
    let mut points = Vec::new();
    for log in archive.logs().expect("records") {
        let Some(rows) = log.rows_in(tile).filter(|rows| rows.points > 0) else {
            continue;
        };
        let path = archive.folder().join(&rows.files[0].file);
        let read = read_parquet(&path, &["x", "y", "depth_m", "weight", "sounding", "halo"]);
        let Ok(
            [
                Values::Double(x),
                Values::Double(y),
                Values::Double(depth_m),
                Values::Double(weight),
                Values::Whole(sounding),
                Values::Flag(is_halo),
            ],
        ) = <[Values; 6]>::try_from(read.expect("rows"))
        else {
            panic!("other columns");
        };
        for index in 0..x.len() {
            if weight[index] > 0.0 && (halo || !is_halo[index]) {
                points.push(DepthPoint {
                    weight: weight[index],
                    is_sounding: sounding[index].is_some(),
                    ..DepthPoint::of_sounding([x[index], y[index]], depth_m[index])
                });
            }
        }
    }
    points
}

/// Depths and spreads of a surface by the places of its cells, as bits.
fn cells(surface: &Surface) -> BTreeMap<[i64; 2], [u32; 3]> {
    let grid = &surface.grid;
    let known = (0..grid.len()).filter(|cell| !surface.depth_m[*cell].is_nan());
    let by_place = known.map(|cell| {
        let place = grid.centre(cell / grid.columns, cell % grid.columns);
        let values = [&surface.depth_m, &surface.spread_m, &surface.distance_m];
        (place.map(|metres| (4.0 * metres) as i64), values.map(|values| values[cell].to_bits()))
    });
    by_place.collect()
}

#[test]
fn tiles_are_parts_of_the_map_of_all_logs_and_agree_across_their_edges_to_the_bit() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    three_logs(folder);
    let archive = Archive::open(&folder.join("archive")).expect("an archive");
    let logs = archive.logs().expect("records");
    let tiles: Vec<TileId> = contents(&archive).expect("records").into_keys().collect();
    assert_eq!(tiles.len(), 4);
    let bounds = tiles.iter().map(TileId::bounds_m);
    let [west_m, _, _, north_m] = bounds
        .reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])])
        .expect("tiles");
    let side = (2.0 * TILE_M / 0.5) as usize;
    let whole = Grid { west_m, north_m, cell_m: 0.5, columns: side, rows: side };
    let progress = Progress::new();
    let all: Vec<DepthPoint> =
        tiles.iter().flat_map(|tile| points(&archive, *tile, false)).collect();
    let single = cells(&local_surface(&all, whole, 20.0, &progress).expect("nobody cancels"));
    let mut joined = BTreeMap::new();
    for tile in &tiles {
        let (archive, logs, offsets) = (&archive, &logs, &Offsets::default());
        let inputs = TileInputs { archive, tile: *tile, logs, offsets, progress: &progress };
        let of_tile = cells(&inputs.map().expect("a map").expect("depths").surface);
        assert!(of_tile.len() > 500, "{tile}: {}", of_tile.len());
        joined.extend(of_tile);
    }
    assert!(joined == single, "{} cells in tiles, {} in one map", joined.len(), single.len());

    // The ground along an edge, from the rows of either side alone.
    let strip = |tile: TileId, edge_m: f64| {
        let [_, _, _, north_m] = tile.bounds_m();
        let strip = Grid {
            west_m: edge_m - 8.0,
            north_m: north_m - 200.0,
            cell_m: 0.5,
            columns: 32,
            rows: (2.0 * (TILE_M - 200.0)) as usize,
        };
        cells(
            &local_surface(&points(&archive, tile, true), strip, 20.0, &progress)
                .expect("nobody cancels"),
        )
    };
    let neighbours = tiles.iter().flat_map(|west| tiles.iter().map(move |east| (west, east)));
    let beside = neighbours.filter(|(west, east)| {
        let (a, b) = (west.bounds_m(), east.bounds_m());
        a[2] == b[0] && a[1] == b[1]
    });
    let mut compared = 0;
    for (west, east) in beside {
        let edge_m = east.bounds_m()[0];
        let [of_west, of_east] = [*west, *east].map(|tile| strip(tile, edge_m));
        assert!(of_west == of_east, "along {edge_m} between {west} and {east}");
        compared += of_west.len();
    }
    assert!(compared > 500, "{compared}");
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

fn states(folder: &Path) -> BTreeMap<String, String> {
    let listed = json(&run(folder, &["tiles", "archive", "--json"]));
    let text = |value: &Value| value.as_str().expect("a text").to_owned();
    let all = listed.as_array().expect("a list").iter();
    all.map(|tile| (text(&tile["tile"]), text(&tile["map"]))).collect()
}

#[test]
fn isobaths_end_where_those_of_the_next_tile_begin() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    for log in 0..3 {
        sail(folder, log, &scene(log, [3.0, -4.0], 0.0));
    }
    let fine = ["--set", "isobaths.interval_m=0.1", "--set", "isobaths.smooth=2"];
    let to_archive =
        ["process", "log-0.sl2", "log-1.sl2", "log-2.sl2", "-o", "archive", "--products", "tiles"];
    run(folder, &[&to_archive[..], &fine].concat());
    run(folder, &["archive", "archive"]);
    // Ends of lines by their depth and place; one within the map belongs to one tile, one on an
    // edge to two.
    let mut ends: BTreeMap<(String, String), usize> = BTreeMap::new();
    for tile in states(folder).keys() {
        let text =
            fs::read_to_string(folder.join(format!("archive/tiles/{tile}/isobaths.geojson")));
        for line in json(&text.expect("lines"))["features"].as_array().expect("features") {
            let coordinates = line["geometry"]["coordinates"].as_array().expect("positions");
            let depth = line["properties"]["depth_m"].to_string();
            if line["properties"]["ring"] == false {
                for end in [coordinates.first(), coordinates.last()].into_iter().flatten() {
                    *ends.entry((depth.clone(), end.to_string())).or_default() += 1;
                }
            }
        }
    }
    let on_edges = ends.values().filter(|count| **count == 2).count();
    assert!(on_edges > 15, "{on_edges} of {}", ends.len());
}

#[test]
fn an_archive_is_brought_up_to_date_once_and_a_log_renews_its_own_tiles_only() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    three_logs(folder);
    assert!(states(folder).values().all(|state| state == "missing"));
    let first = run(folder, &["archive", "archive"]);
    assert!(first.contains("4 of 4 maps made"), "{first}");
    assert!(states(folder).values().all(|state| state == "up to date"));
    let there = files(&folder.join("archive"));
    for name in [
        "offsets.csv",
        "index/depth_17N.vrt",
        "index/depth_17N.qml",
        "index/uncertainty_17N.qml",
        "index/source_17N.qml",
        "index/collection.json",
    ] {
        assert!(there.contains_key(name), "{name}");
    }
    assert!(run(folder, &["archive", "archive"]).contains("0 of 4 maps made"));
    assert!(files(&folder.join("archive")) == there, "a second run changes nothing");
    // By hand, tile by tile, the maps are the same bytes.
    let tile = states(folder).into_keys().next().expect("a tile");
    fs::remove_dir_all(folder.join("archive/tiles").join(&tile)).expect("a map");
    assert_eq!(states(folder)[&tile], "missing");
    let made = run(folder, &["tile", "archive", &tile]);
    assert!(made.starts_with(&format!("wrote {tile}: ")), "{made}");
    assert!(files(&folder.join("archive")) == there, "a tile by itself");

    // Far enough from the corner that its rows lie in the two tiles to the north.
    sail(folder, 3, &zigzag(3, [14.0, 96.0], 0.0));
    add(folder, &["log-3.sl2"]);
    let stale: Vec<String> = states(folder)
        .into_iter()
        .filter(|(_, state)| state != "up to date")
        .map(|(tile, _)| tile)
        .collect();
    assert!(!stale.is_empty() && stale.len() < 4, "{stale:?}");
    let listed = run(folder, &["tiles", "archive", "--stale"]);
    assert!(stale.iter().all(|tile| listed.contains(tile)), "{listed}");
    let made = run(folder, &["archive", "archive"]);
    let renewed: Vec<&str> =
        made.lines().filter_map(|line| line.strip_prefix("wrote ")?.split(':').next()).collect();
    assert_eq!(renewed, stale);

    assert!(refusal(folder, &["tile", "archive", "17N_0_0"], 1).contains("no log of this archive"));
    assert!(refusal(folder, &["tile", "archive", "here"], 2).contains("names no tile"));
}

#[test]
fn a_log_whose_record_is_removed_is_no_part_of_the_archive() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    sail(folder, 0, &scene(0, [3.0, -4.0], 0.0));
    add(folder, &["log-0.sl2"]);
    run(folder, &["archive", "archive"]);
    let map = "archive/tiles/17N_392192_3253760";
    assert!(folder.join(map).join("depth.tif").is_file());
    fs::remove_dir_all(folder.join("archive/logs")).expect("records");
    let made = run(folder, &["archive", "archive"]);
    assert!(made.contains("removed 17N_392192_3253760") && made.contains("0 of 0 maps"), "{made}");
    assert!(!folder.join(map).exists());
    assert!(run(folder, &["coverage", "archive", "-82.11,29.41,900"]).contains("no ping"));
    // Its rows are as they were, and are taken up again.
    add(folder, &["log-0.sl2"]);
    assert!(run(folder, &["archive", "archive"]).contains("wrote 17N_392192_3253760"));
}

#[test]
fn isobaths_of_a_archive_end_at_its_own_copy_of_the_area_and_another_one_is_refused() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    sail(folder, 0, &scene(0, [3.0, -4.0], 0.0));
    sail(folder, 1, &scene(1, [3.0, -4.0], 0.0));
    let corner = ZONE.to_lon_lat(CORNER_M);
    let write = |name: &str, reach_deg: f64| {
        let [east, north] = [corner.lon_deg + 1.0, corner.lat_deg + 1.0];
        let [west, south] = [corner.lon_deg - reach_deg, corner.lat_deg - 1.0];
        let ring = [[west, south], [east, south], [east, north], [west, north], [west, south]];
        let area = serde_json::json!({ "type": "Polygon", "coordinates": [ring] });
        fs::write(folder.join(name), area.to_string()).expect("an area");
    };
    // East of the corner alone.
    write("shore.geojson", 0.0);
    let added = |log: &'static str| {
        let to_archive = ["-o", "archive", "--products", "tiles"];
        let clip = ["--set", "isobaths.clip=shore.geojson"];
        [&["process", log][..], &to_archive, &clip].concat()
    };
    run(folder, &added("log-0.sl2"));
    run(folder, &["archive", "archive"]);
    let lines = |archive: &str| -> Vec<[f64; 2]> {
        let files = files(&folder.join(archive));
        let files = files.iter().filter(|(name, _)| name.ends_with("isobaths.geojson"));
        let lines = files.flat_map(|(_, bytes)| {
            let read: Value = serde_json::from_slice(bytes).expect("JSON");
            let features = read["features"].as_array().expect("features").clone();
            features.into_iter().flat_map(|feature| {
                let places = feature["geometry"]["coordinates"].clone();
                serde_json::from_value::<Vec<[f64; 2]>>(places).expect("places")
            })
        });
        lines.collect()
    };
    let cut = lines("archive");
    assert!(cut.len() > 20 && cut.iter().all(|at| at[0] > corner.lon_deg - 1e-7));

    // The same name and another content is another setting, and so is none; the same content under
    // another name is the same.
    write("shore.geojson", 0.5);
    let said = refusal(folder, &added("log-1.sl2"), 1);
    assert!(said.contains("isobaths.clip is a file of"), "{said}");
    let without = ["process", "log-1.sl2", "-o", "archive", "--products", "tiles"];
    let said = refusal(folder, &without, 1);
    assert!(said.contains("and not given here"), "{said}");
    fs::remove_file(folder.join("shore.geojson")).expect("the file");
    write("moved.geojson", 0.0);
    let moved = [&without[..], &["--set", "isobaths.clip=moved.geojson"]].concat();
    run(folder, &moved);
    run(folder, &["archive", "archive"]);
    assert!(lines("archive").iter().all(|at| at[0] > corner.lon_deg - 1e-7));
    // Without its copy the archive makes no map.
    fs::write(folder.join("archive/isobath_area.geojson"), "{}").expect("the copy");
    let tile =
        contents(&Archive::open(&folder.join("archive")).expect("an archive")).expect("records");
    let tile = tile.into_keys().next().expect("a tile").to_string();
    let said = refusal(folder, &["tile", "archive", &tile], 1);
    assert!(said.contains("isobath_area.geojson"), "{said}");
}
