//! The mosaics of tiles: that of `process`, cut at the tiles, whatever the order in which logs
//! came.

use super::{files, sail, scene};
use crate::cli::{refusal, run};
use bathyscope_products::archive::{Archive, TileId, contents};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

/// Cells of a mosaic that was written over the tiles of one zone.
struct Levels {
    /// West and north edge in whole cells of the zone.
    corner: [i64; 2],
    columns: usize,
    levels: Vec<u8>,
}

impl Levels {
    fn read(path: &Path, cell_m: f64) -> Self {
        let mut decoder = Decoder::new(File::open(path).expect("a mosaic")).expect("a TIFF");
        let tie = decoder.get_tag_f64_vec(Tag::ModelTiepointTag).expect("its place");
        let scale = decoder.get_tag_f64_vec(Tag::ModelPixelScaleTag).expect("its cells");
        assert!((scale[0] - cell_m).abs() < 1e-12 && scale[0] == scale[1]);
        let corner = [tie[3], tie[4]].map(|metres| {
            let cells = metres / cell_m;
            assert!((cells - cells.round()).abs() < 1e-6, "{cells}");
            cells.round() as i64
        });
        let (columns, _) = decoder.dimensions().expect("its size");
        let DecodingResult::U8(levels) = decoder.read_image().expect("levels") else {
            panic!("a grey mosaic has levels");
        };
        Self { corner, columns: columns as usize, levels }
    }

    /// Levels of what was seen by the column and row of its cell in the zone, rows southward.
    fn seen(&self) -> impl Iterator<Item = ([i64; 2], u8)> {
        let known = self.levels.iter().enumerate().filter(|(_, level)| **level > 0);
        known.map(|(cell, level)| {
            let (row, column) = (cell / self.columns, cell % self.columns);
            let [west, north] = self.corner;
            ([west + column as i64, north - row as i64], *level)
        })
    }
}

/// Reads the levels that all tiles of the archive show.
fn of_archive(archive: &Path, cell_m: f64) -> BTreeMap<[i64; 2], u8> {
    let opened = Archive::open(archive).expect("an archive");
    let tiles = contents(&opened).expect("records").into_keys();
    let mut all = BTreeMap::new();
    for tile in tiles {
        let path = archive.join(format!("tiles/{tile}/mosaic.tif"));
        let before = all.len();
        let levels = Levels::read(&path, cell_m);
        all.extend(levels.seen());
        assert_eq!(all.len() - before, levels.seen().count(), "{tile}: no cell lies in two tiles");
    }
    all
}

/// Cells that only one of both shows, that differ by one level, and by more.
fn differences(one: &BTreeMap<[i64; 2], u8>, other: &BTreeMap<[i64; 2], u8>) -> [usize; 3] {
    let mut found = [0; 3];
    for (cell, level) in one {
        match other.get(cell).map(|other| other.abs_diff(*level)) {
            None => found[0] += 1,
            Some(0) => {}
            Some(1) => found[1] += 1,
            Some(_) => found[2] += 1,
        }
    }
    found[0] += other.keys().filter(|cell| !one.contains_key(*cell)).count();
    found
}

/// Puts logs into an archive, makes its tiles, and processes the same by themselves; what both
/// show.
fn both(
    folder: &Path,
    name: &str,
    logs: &[&str],
    cell_m: f64,
    more: &[&str],
) -> [BTreeMap<[i64; 2], u8>; 2] {
    let (archive, alone) = (format!("{name}-archive"), format!("{name}-alone"));
    let cell = format!("mosaic.cell_m={cell_m}");
    let settings = [&["--set", cell.as_str()], more].concat();
    let process = |rest: &[&str]| {
        run(folder, &[&["process"], logs, rest, &settings].concat());
    };
    process(&["-o", &archive, "--products", "tiles"]);
    process(&["-o", &alone, "--products", "mosaic", "--no-objects"]);
    run(folder, &["archive", &archive]);
    let alone = Levels::read(&folder.join(alone).join("mosaic/mosaic.tif"), cell_m);
    [of_archive(&folder.join(archive), cell_m), alone.seen().collect()]
}

#[test]
fn the_mosaic_of_a_archive_of_one_log_is_that_of_the_log() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    sail(folder, 0, &scene(0, [3.0, -4.0], 0.0));
    // Places of cells of 0.125 m are the same numbers in both; those of 0.1 m are not to the last
    // bit, so that a cell at the end of a swath may be in one and not in the other.
    for (name, cell_m, overlap) in [
        ("later", 0.125, "later"),
        ("brighter", 0.125, "brighter"),
        ("middle", 0.125, "middle"),
        ("blend", 0.125, "blend"),
        ("usual", 0.1, "later"),
    ] {
        let overlap = format!("mosaic.overlap={overlap}");
        let [tiles, alone] = both(folder, name, &["log-0.sl2"], cell_m, &["--set", &overlap]);
        let [one_only, by_one, by_more] = differences(&tiles, &alone);
        eprintln!(
            "{name}: {} cells, {one_only} in one only, {by_one} off by a level, {by_more} by more",
            alone.len()
        );
        assert!(alone.len() > 50_000, "{name}: {}", alone.len());
        // Sums of samples begin elsewhere in windows that lie elsewhere: a level at the middle of
        // two may be rounded either way.
        assert!(1000 * by_one < alone.len(), "{name}: {by_one}");
        if cell_m == 0.125 {
            assert_eq!([one_only, by_more], [0; 2], "{name}");
        } else {
            assert!(10_000 * (one_only + by_more) < alone.len(), "{name}");
        }
    }
}

#[test]
fn the_mosaic_of_two_logs_is_that_of_both_in_the_order_of_their_recording() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    for log in 0..2 {
        sail(folder, log, &scene(log, [3.0, -4.0], 0.0));
    }
    // Processed together, levels of logs are matched, but not as they were recorded; and the relief
    // of a log's ground is taken on cells that count from the first log's origin, not from its own.
    let recorded = ["--set", "mosaic.gain=recorded", "--set", "surface.relief=false"];
    for overlap in ["later", "blend"] {
        let setting = format!("mosaic.overlap={overlap}");
        let settings = [&recorded[..], &["--set", &setting]].concat();
        let logs = ["log-0.sl2", "log-1.sl2"];
        let [tiles, alone] = both(folder, overlap, &logs, 0.25, &settings);
        let found = differences(&tiles, &alone);
        eprintln!("{overlap}: {} cells, {found:?}", alone.len());
        assert!(alone.len() > 20_000, "{}", alone.len());
        let [one_only, by_one, by_more] = found;
        assert!(10_000 * (one_only + by_more) < alone.len(), "{found:?}");
        // A mean of parts is one of whole levels.
        assert!(overlap == "blend" || 1000 * by_one < alone.len(), "{found:?}");

        // Whatever came first, the same bytes.
        let archive = format!("{overlap}-archive");
        let there = files(&folder.join(&archive));
        fs::remove_dir_all(folder.join(&archive)).expect("an archive");
        for log in ["log-1.sl2", "log-0.sl2"] {
            let to_archive = ["process", log, "-o", &archive, "--products", "tiles"];
            let cell = ["--set", "mosaic.cell_m=0.25"];
            run(folder, &[&to_archive[..], &cell, &settings].concat());
        }
        run(folder, &["archive", &archive]);
        assert!(files(&folder.join(&archive)) == there, "{overlap}");
    }
}

/// The rows of `offsets.csv` by log: its factor on levels, and how many blocks it was found from.
fn factors(archive: &Path) -> BTreeMap<String, (f64, usize)> {
    let table = fs::read_to_string(archive.join("offsets.csv")).expect("a table");
    let mut lines = table.lines();
    assert!(lines.next().expect("a head").ends_with(",level_factor,level_ties"));
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let [.., factor, ties] = fields[..] else {
            panic!("{line}");
        };
        let factor = factor.parse().expect("a factor");
        (fields[0].to_owned(), (factor, ties.parse().expect("a count")))
    };
    lines.map(row).collect()
}

#[test]
fn levels_of_logs_are_brought_to_each_other_and_known_logs_keep_theirs() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    for log in 0..3 {
        sail(folder, log, &scene(log, [3.0, -4.0], 0.0));
    }
    let level = ["--set", "surface.relief=false"];
    let logs = ["log-0.sl2", "log-1.sl2"];
    let [tiles, alone] = both(folder, "two", &logs, 0.25, &level);
    let of_two = factors(&folder.join("two-archive"));
    eprintln!("{of_two:?}");
    let product: f64 = of_two.values().map(|(factor, _)| factor).product();
    assert!((product - 1.0).abs() < 0.01, "{of_two:?}");
    assert!(of_two.values().all(|(_, ties)| *ties > 5), "{of_two:?}");
    // Factors are those of a survey of both, found in other cells of a metre.
    let ratios = tiles.iter().filter_map(|(cell, level)| {
        let other = alone.get(cell)?;
        let is_dim = *level < 200 && *other < 200 && *other > 20;
        is_dim.then(|| f64::from(*level) / f64::from(*other))
    });
    let (sum, count) = ratios.fold((0.0, 0.0), |(sum, count), ratio| (sum + ratio, count + 1.0));
    eprintln!("{} of {count} cells", sum / count);
    assert!((sum / count - 1.0).abs() < 0.02, "{}", sum / count);

    let archive = folder.join("two-archive");
    let there = files(&archive);
    let third = ["log-2.sl2", "-o", "two-archive", "--products", "tiles"];
    let settings = ["--set", "mosaic.cell_m=0.25"];
    run(folder, &[&["process"], &third[..], &settings, &level].concat());
    run(folder, &["archive", "two-archive"]);
    let of_three = factors(&archive);
    for log in ["log-0", "log-1"] {
        assert_eq!(of_three[log], of_two[log]);
    }
    assert!(of_three["log-2"].1 > 5);
    // Written by hand, a factor brightens the log's echoes.
    let table = fs::read_to_string(archive.join("offsets.csv")).expect("a table");
    let brighter = table.lines().map(|line| match line.strip_prefix("log-2,") {
        Some(rest) => {
            let fields: Vec<&str> = rest.split(',').collect();
            format!("log-2,{},2.5,{}\n", fields[..11].join(","), fields[12])
        }
        None => format!("{line}\n"),
    });
    fs::write(archive.join("offsets.csv"), brighter.collect::<String>()).expect("a table");
    let made = run(folder, &["archive", "two-archive"]);
    assert!(!made.contains("0 of "), "{made}");
    assert_eq!(factors(&archive)["log-2"].0, 2.5);
    assert!(files(&archive) != there);
}

#[test]
fn a_mosaic_is_stale_when_a_part_of_it_changes_and_goes_with_the_last() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    for log in 0..2 {
        sail(folder, log, &scene(log, [3.0, -4.0], 0.0));
    }
    // As they were recorded, levels of one log do not hang on those of another.
    let add = |log: &str| {
        let to_archive = ["process", log, "-o", "archive", "--products", "tiles"];
        run(folder, &[&to_archive[..], &["--set", "mosaic.gain=recorded"]].concat());
    };
    add("log-0.sl2");
    run(folder, &["archive", "archive"]);
    let tile: TileId = "17N_392192_3253760".parse().expect("a tile");
    let mosaic = format!("archive/tiles/{tile}/mosaic.tif");
    let alone = fs::read(folder.join(&mosaic)).expect("a mosaic");
    let listed = || run(folder, &["tiles", "archive", "--stale"]);
    assert!(!listed().contains(&tile.to_string()));
    add("log-1.sl2");
    assert!(listed().contains(&tile.to_string()));
    let made = run(folder, &["archive", "archive"]);
    assert!(made.contains(", mosaic of "), "{made}");
    assert!(fs::read(folder.join(&mosaic)).expect("a mosaic") != alone);
    let vrt = fs::read_to_string(folder.join("archive/index/mosaic_17N.vrt")).expect("an index");
    assert!(vrt.contains(&format!("../tiles/{tile}/mosaic.tif")) && vrt.contains("Byte"));
    let item = fs::read_to_string(folder.join(format!("archive/index/{tile}.json")));
    assert!(item.expect("an item").contains(&format!("../tiles/{tile}/mosaic.tif")));

    // Without its record the second log is no part of the archive, and the first is as it was.
    let archive = Archive::open(&folder.join("archive")).expect("an archive");
    let logs = archive.logs().expect("records");
    let second = logs.iter().find(|log| log.name.contains("log-1")).expect("both");
    fs::remove_file(folder.join(format!("archive/logs/{}.json", second.log))).expect("a record");
    run(folder, &["archive", "archive"]);
    assert!(fs::read(folder.join(&mosaic)).expect("a mosaic") == alone);

    // A part that cannot be read is named, and leaves no mosaic that would be taken for whole.
    let first = logs.iter().find(|log| log.name.contains("log-0")).expect("both");
    let part = folder.join(format!("archive/mosaic/tile={tile}/{}.tif", first.log));
    let length = fs::read(&part).expect("a part").len();
    fs::write(&part, vec![0; length]).expect("a part");
    let refused = refusal(folder, &["tile", "archive", &tile.to_string()], 1);
    assert!(refused.contains("process its log again"), "{refused}");
    assert!(listed().contains(&tile.to_string()));
}

#[test]
fn cells_that_do_not_divide_a_tile_are_refused() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    sail(folder, 0, &scene(0, [3.0, -4.0], 0.0));
    let to_archive = ["process", "log-0.sl2", "-o", "archive", "--products", "tiles"];
    let with = |setting| [&to_archive[..], &["--set", setting]].concat();
    let refused = refusal(folder, &with("mosaic.cell_m=0.3"), 1);
    assert!(refused.contains("does not divide the 512 m"), "{refused}");
    assert!(!folder.join("archive").exists());
    run(folder, &with("mosaic.cell_m=0.5"));
    let refused = refusal(folder, &to_archive, 1);
    assert!(refused.contains("mosaic.cell_m is 0.5 there, and 0.1 here"), "{refused}");
    // How mosaics are coloured is not the archive's.
    let colours = ["--set", "mosaic.cell_m=0.5", "--set", "mosaic.colours=copper"];
    run(folder, &[&to_archive[..], &colours].concat());
}
