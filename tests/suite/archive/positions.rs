//! Positions of the logs of an archive that are off or late, found from crossings over a bottom
//! that slopes.

use super::{add, sail, zigzag};
use crate::cli::{refusal, run};
use bathyscope_log::formats::lowrance::{FILE_HEADER, frame::Sl2Header};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{Archive, Offsets, TileInputs, contents};
use bathyscope_simulation::{BedSettings, Mound, Scene};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::mem::offset_of;
use std::path::{Path, PathBuf};

/// Errors of the positions of each log: metres to the east and north, and latency, seconds. Shifts
/// have a mean of zero, since a shift that all share shows nowhere.
pub(crate) const TRUTH: [[f64; 3]; 4] =
    [[1.5, -1.0, 0.0], [0.0, 0.0, 1.2], [-1.5, 1.0, 0.0], [0.0, 0.0, 0.0]];

/// A bed of mounds and hollows, and a boat that goes over them in all directions.
fn hilly(log: u32) -> Scene {
    let middle = [f64::from(log % 2) * 6.0 - 3.0, f64::from(log / 2) * 5.0 - 2.5];
    let scene = zigzag(log, middle, 0.2 * f64::from(log));
    let places = (-4..=4).flat_map(|column| (-4..=4).map(move |row| (column, row)));
    let mounds = places.map(|(column, row)| Mound {
        east_m: 8.0 * f64::from(column),
        north_m: 8.0 * f64::from(row),
        radius_m: 2.5,
        height_m: if (column + row) % 2 == 0 { 0.7 } else { -0.5 },
    });
    Scene { bed: BedSettings { mounds: mounds.collect(), ..scene.bed.clone() }, ..scene }
}

/// Writes another log whose positions are off and late: a frame's place is that of some seconds
/// before, without the shift.
fn spoil(from: &Path, to: &Path, [east_m, north_m, latency_s]: [f64; 3]) {
    let mut log = fs::read(from).expect("a log");
    let integer = |log: &[u8], at: usize| i32::from_le_bytes(log[at..at + 4].try_into().unwrap());
    let mut frames = Vec::new();
    let mut at = FILE_HEADER;
    while at + offset_of!(Sl2Header, frame_size) + 2 < log.len() {
        let size = at + offset_of!(Sl2Header, frame_size);
        frames.push(at);
        at += usize::from(u16::from_le_bytes([log[size], log[size + 1]]));
    }
    let fixes: Vec<[f64; 3]> = frames
        .iter()
        .map(|frame| {
            [offset_of!(Sl2Header, time_ms), offset_of!(Sl2Header, x_m), offset_of!(Sl2Header, y_m)]
                .map(|field| f64::from(integer(&log, frame + field)))
        })
        .collect();
    // Lowrance's metres are those of the equator; the water lies at 29.4 degrees.
    let stretch = 1.0 / 29.4_f64.to_radians().cos();
    for (frame, [time_ms, ..]) in frames.iter().zip(&fixes) {
        let before_ms = time_ms - 1000.0 * latency_s;
        let [_, x, y] = fixes[fixes.partition_point(|fix| fix[0] < before_ms).min(fixes.len() - 1)];
        for (field, metres) in [
            (offset_of!(Sl2Header, x_m), x - stretch * east_m),
            (offset_of!(Sl2Header, y_m), y - stretch * north_m),
        ] {
            let stored = (metres.round() as i32).to_le_bytes();
            log[frame + field..][..4].copy_from_slice(&stored);
        }
    }
    fs::write(to, log).expect("a log");
}

/// Four logs as they should be in the folder `right`, and as they were recorded in `off`.
pub(crate) fn write_four(folder: &Path) -> [PathBuf; 2] {
    let [right, off] = ["right", "off"].map(|name| folder.join(name));
    for made in [&right, &off] {
        fs::create_dir(made).expect("a folder");
    }
    for log in 0..4 {
        sail(&right, log, &hilly(log));
        let name = format!("log-{log}.sl2");
        spoil(&right.join(&name), &off.join(&name), TRUTH[log as usize]);
    }
    [right, off]
}

pub(crate) const LOGS: [&str; 4] = ["log-0.sl2", "log-1.sl2", "log-2.sl2", "log-3.sl2"];

/// The same, each folder with its archive.
fn sail_four(folder: &Path) -> [PathBuf; 2] {
    let made = write_four(folder);
    for made in &made {
        add(made, &LOGS);
    }
    made
}

/// All depths of an archive's maps by the places of cells in half metres.
fn depths_m(folder: &Path) -> BTreeMap<[i64; 2], f32> {
    let archive = Archive::open(&folder.join("archive")).expect("an archive");
    let (logs, offsets) =
        (archive.logs().expect("records"), Offsets::read(&archive).expect("a table"));
    let mut found = BTreeMap::new();
    for tile in contents(&archive).expect("records").into_keys() {
        let (archive, logs, offsets, progress) = (&archive, &logs, &offsets, &Progress::new());
        let inputs = TileInputs { archive, tile, logs, offsets, progress };
        let Some(map) = inputs.map().expect("a map") else { continue };
        let grid = map.surface.grid;
        for (cell, depth_m) in map.surface.depth_m.iter().enumerate() {
            let place = grid.centre(cell / grid.columns, cell % grid.columns);
            found.insert(place.map(|metres| (2.0 * metres).floor() as i64), *depth_m);
        }
    }
    found
}

/// Root mean square of the differences between two maps, without their mean, metres.
fn rms_m(first: &BTreeMap<[i64; 2], f32>, second: &BTreeMap<[i64; 2], f32>) -> f64 {
    let both = first.iter().filter_map(|(place, depth_m)| {
        let difference = f64::from(depth_m - second.get(place)?);
        difference.is_finite().then_some(difference)
    });
    let both: Vec<f64> = both.collect();
    assert!(both.len() > 1000, "{}", both.len());
    let mean_m = both.iter().sum::<f64>() / both.len() as f64;
    let squares = both.iter().map(|metres| (metres - mean_m).powi(2));
    (squares.sum::<f64>() / both.len() as f64).sqrt()
}

#[test]
fn positions_that_are_off_and_late_are_found_and_the_map_is_made_where_the_boats_were() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let [right, off] = sail_four(temporary.path());
    run(&right, &["adjust", "archive"]);
    run(&off, &["adjust", "archive"]);
    let truth = depths_m(&right);
    let before_m = rms_m(&depths_m(&off), &truth);
    let stale = |folder: &Path| run(folder, &["tiles", "archive", "--stale"]).lines().count();
    run(&off, &["archive", "archive"]);
    let none = stale(&off);

    let printed = run(&off, &["adjust", "archive", "--positions", "--latency", "--json"]);
    let rows: Value = serde_json::from_str(&printed).expect("JSON");
    for (row, truth) in rows.as_array().expect("rows").iter().zip(TRUTH) {
        let found =
            ["east_m", "north_m", "latency_s"].map(|name| row[name].as_f64().expect("a number"));
        let [shift_error_m, latency_error_s] =
            ["shift_error_m", "latency_error_s"].map(|name| row[name].as_f64().expect("a number"));
        eprintln!("{truth:?} {found:?} {shift_error_m} {latency_error_s}");
        let off_m = (found[0] - truth[0]).hypot(found[1] - truth[1]);
        assert!(off_m < 0.6 && shift_error_m < 0.5, "{row}");
        assert!((found[2] - truth[2]).abs() < 0.4 && latency_error_s < 0.4, "{row}");
    }
    assert!(stale(&off) > none, "maps of other positions are stale");
    let after_m = rms_m(&depths_m(&off), &truth);
    eprintln!("map against that of right positions: {before_m:.3} m, corrected {after_m:.3} m");
    assert!(after_m < 0.75 * before_m, "{before_m} {after_m}");

    // CoverageQuery for heights alone, and for all once more, positions stay as they are.
    let table = fs::read_to_string(off.join("archive/offsets.csv")).expect("a table");
    run(&off, &["adjust", "archive"]);
    run(&off, &["adjust", "archive", "--positions", "--latency"]);
    let again = fs::read_to_string(off.join("archive/offsets.csv")).expect("a table");
    let shifts = |table: &str| -> Vec<String> {
        let lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
        lines.map(|fields| [fields[7], fields[8], fields[10]].join(",")).collect()
    };
    assert_eq!(shifts(&again), shifts(&table));
    fs::write(off.join("archive/offsets.csv"), table.replace(",0,", ",0,9")).expect("a table");
    let refused = refusal(&off, &["adjust", "archive"], 1);
    assert!(refused.contains("east_m and north_m metres up to 6"), "{refused}");
}
