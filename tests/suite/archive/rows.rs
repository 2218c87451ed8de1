//! The rows of logs in tiles: the same bytes however they came there, and no settings mixed.

use super::{add, files, sail, scene, three_logs};
use crate::cli::{refusal, run};
use bathyscope_log::formats::parquet_table::{Values, read_parquet};
use bathyscope_products::archive::{Archive, TileId};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn doubles(path: &Path, name: &str) -> Vec<f64> {
    match read_parquet(path, &[name]).expect("rows").pop() {
        Some(Values::Double(values)) => values,
        other => panic!("{name}: {other:?}"),
    }
}

fn flags(path: &Path, name: &str) -> Vec<bool> {
    match read_parquet(path, &[name]).expect("rows").pop() {
        Some(Values::Flag(values)) => values,
        other => panic!("{name}: {other:?}"),
    }
}

#[test]
fn one_by_one_or_together_again_or_renamed_the_rows_are_the_same_bytes() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    three_logs(folder);
    let together = files(&folder.join("archive"));
    assert!(together.keys().all(|name| !name.contains("part")));
    let again = add(folder, &["log-1.sl2"]);
    assert!(again.starts_with("up to date: "), "{again}");
    fs::copy(folder.join("log-1.sl2"), folder.join("other.sl2")).expect("a copy");
    let renamed = add(folder, &["other.sl2"]);
    assert!(renamed.starts_with("up to date: "), "{renamed}");
    assert_eq!(files(&folder.join("archive")), together);

    fs::rename(folder.join("archive"), folder.join("first")).expect("a folder");
    for log in ["log-2.sl2", "log-0.sl2", "log-1.sl2"] {
        add(folder, &[log]);
    }
    assert!(files(&folder.join("archive")) == together, "another order of logs");
    // What is missing is written again, and no other.
    let name = together.keys().find(|name| name.starts_with("pings/")).expect("rows");
    fs::remove_file(folder.join("archive").join(name)).expect("rows");
    let mended = add(folder, &["log-0.sl2", "log-1.sl2", "log-2.sl2"]);
    assert_eq!(mended.matches("wrote ").count(), 1, "{mended}");
    assert!(files(&folder.join("archive")) == together, "what was missing");
}

#[test]
fn every_point_is_in_one_core_and_in_the_halo_of_tiles_beside_it() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    three_logs(folder);
    let archive = Archive::open(&folder.join("archive")).expect("an archive");
    let halo_m = archive.record.halo_m;
    assert!(halo_m >= 25.0);
    for log in archive.logs().expect("records") {
        assert!(log.tiles.len() == 4, "around the corner of four tiles: {}", log.tiles.len());
        let mut cores = Vec::new();
        for rows in &log.tiles {
            let path = folder.join("archive").join(&rows.files[0].file);
            let (x, y, depth_m) =
                (doubles(&path, "x"), doubles(&path, "y"), doubles(&path, "depth_m"));
            let halo = flags(&path, "halo");
            assert_eq!([x.len(), halo.len()], [rows.points; 2]);
            for index in 0..x.len() {
                let place = [x[index], y[index]];
                assert!(rows.tile.holds(place, halo_m));
                assert_eq!(rows.tile.holds(place, 0.0), !halo[index]);
                if !halo[index] {
                    cores.push([x[index], y[index], depth_m[index]].map(f64::to_bits));
                }
            }
        }
        assert_eq!(cores.len(), log.points);
        let different: BTreeSet<_> = cores.into_iter().collect();
        // Two recorded at one place with one depth are few.
        assert!(different.len() > log.points * 9 / 10, "{}", different.len());
    }
}

#[test]
fn an_archive_refuses_other_settings_and_other_folders() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    sail(folder, 0, &scene(0, [3.0, -4.0], 0.0));
    let tiles = ["process", "log-0.sl2", "--products", "tiles"];
    let refused = |more: &[&str]| refusal(folder, &[&tiles, more].concat(), 1);
    assert!(refused(&[]).contains("-o DIR"));
    run(folder, &[&tiles[..], &["-o", "archive"]].concat());
    let gap = refused(&["-o", "archive", "--set", "surface.max_gap_m=10"]);
    assert!(gap.contains("surface.max_gap_m is 20.0 there, and 10.0 here"), "{gap}");
    // The draft is that of one boat.
    let draft = ["-o", "archive", "--set", "draft_m=0.3"];
    let written = run(folder, &[&tiles[..], &draft].concat());
    assert!(written.starts_with("wrote "), "{written}");
    let cell = refused(&["-o", "new", "--set", "surface.cell_m=0.3"]);
    assert!(cell.contains("0.125, 0.25, 0.5"), "{cell}");
    fs::create_dir(folder.join("full")).expect("a folder");
    fs::write(folder.join("full/notes.txt"), b"mine").expect("a file");
    assert!(refused(&["-o", "full"]).contains("holds notes.txt and no archive"));
    let both =
        refusal(folder, &["process", "log-0.sl2", "--products", "tiles,depth", "-o", "x"], 1);
    assert!(both.contains("--products tiles alone"), "{both}");
    assert!(!folder.join("x").exists() && !folder.join("new").exists());
    let adjust = refused(&["-o", "archive", "--adjust"]);
    assert!(adjust.contains("bathyscope adjust"), "{adjust}");
    assert!("17N_392192_3253760".parse::<TileId>().is_ok());
}

#[test]
fn a_log_that_cannot_be_used_keeps_no_other_out() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    sail(folder, 0, &scene(0, [3.0, -4.0], 0.0));
    fs::write(folder.join("bad.sl2"), b"no log").expect("a file");
    let args = ["process", "bad.sl2", "log-0.sl2", "-o", "archive", "--products", "tiles"];
    let output = std::process::Command::new(crate::support::program())
        .args(args)
        .current_dir(folder)
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(1));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("bad.sl2") && errors.contains("1 of 2 logs"), "{errors}");
    assert_eq!(
        Archive::open(&folder.join("archive")).expect("an archive").logs().expect("records").len(),
        1
    );
}
