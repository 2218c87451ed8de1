//! Height offsets between the logs of an archive, found from the rows in its tiles.

use super::{add, sail, zigzag};
use crate::cli::{refusal, run, stderr_of};
use bathyscope_test_support::Moments;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const LOGS: u32 = 30;
/// Logs that lie far from all others.
const APART: [u32; 2] = [7, 19];

/// Logs of known heights around the corner of four tiles; what each hangs higher over the ground,
/// metres.
fn sail_many(folder: &Path, count: u32) -> Vec<f64> {
    let mut moments = Moments(3);
    let mut higher_m = Vec::new();
    for log in 0..count {
        higher_m.push(3.0 * (moments.share() - 0.5));
        let (column, row) = (f64::from(log % 6), f64::from(log / 6));
        let middle = match APART.iter().position(|apart| *apart == log) {
            Some(rank) => [-600.0, 300.0 * rank as f64],
            None => [17.0 * (column - 2.5), 12.0 * (row - 2.0)],
        };
        sail(folder, log, &zigzag(log, middle, higher_m[log as usize]));
    }
    let names: Vec<String> = (0..count).map(|log| format!("log-{log}.sl2")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    add(folder, &names);
    higher_m
}

fn adjusted(folder: &Path) -> BTreeMap<String, Value> {
    let printed: Value =
        serde_json::from_str(&run(folder, &["adjust", "archive", "--json"])).expect("JSON");
    let rows = printed.as_array().expect("rows").iter();
    rows.map(|row| (row["name"].as_str().expect("a name").to_owned(), row.clone())).collect()
}

fn offset_m(rows: &BTreeMap<String, Value>, log: u32) -> f64 {
    rows[&format!("log-{log}")]["offset_m"].as_f64().expect("an offset")
}

#[test]
fn offsets_of_thirty_logs_are_found_where_tied_and_the_others_named() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let higher_m = sail_many(folder, LOGS);
    let warned = stderr_of(folder, &["adjust", "archive"]);
    assert!(warned.contains("nothing ties 2 logs to another log: log-19, log-7"), "{warned}");
    let rows = adjusted(folder);
    let tied: Vec<u32> = (0..LOGS).filter(|log| !APART.contains(log)).collect();
    let mean_m = tied.iter().map(|log| higher_m[*log as usize]).sum::<f64>() / tied.len() as f64;
    let off_m =
        tied.iter().map(|log| (offset_m(&rows, *log) - (higher_m[*log as usize] - mean_m)).abs());
    let mut off_m: Vec<f64> = off_m.collect();
    off_m.sort_by(f64::total_cmp);
    let close = off_m.iter().filter(|metres| **metres < 0.02).count();
    eprintln!(
        "{close} of {} within 2 cm, median {:.4} m, worst {:.4} m",
        off_m.len(),
        off_m[off_m.len() / 2],
        off_m[off_m.len() - 1]
    );
    assert!(close * 100 >= off_m.len() * 95, "{off_m:?}");
    for apart in APART {
        assert_eq!(offset_m(&rows, apart), 0.0);
        assert_eq!(rows[&format!("log-{apart}")]["ties"], 0);
    }
    // CoverageQuery again, the table stays as it is.
    let table = fs::read(folder.join("archive/offsets.csv")).expect("a table");
    adjusted(folder);
    assert_eq!(fs::read(folder.join("archive/offsets.csv")).expect("a table"), table);
}

#[test]
fn a_pinned_log_stays_and_a_damaged_table_is_refused() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    sail_many(folder, 4);
    let free = adjusted(folder);
    let path = folder.join("archive/offsets.csv");
    let table = fs::read_to_string(&path).expect("a table");
    let pinned: String = table
        .lines()
        .map(|line| {
            if !line.starts_with("log-2,") {
                format!("{line}\n")
            } else {
                let fields: Vec<&str> = line.split(',').collect();
                format!("log-2,{},1.25,,,,yes,,,,,\n", fields[1])
            }
        })
        .collect();
    fs::write(&path, pinned).expect("a table");
    let held = adjusted(folder);
    assert_eq!(offset_m(&held, 2), 1.25);
    assert_eq!(held["log-2"]["pinned"], true);
    for log in [0, 1, 3] {
        let moved_m = offset_m(&held, log) - offset_m(&free, log);
        let expected_m = 1.25 - offset_m(&free, 2);
        assert!((moved_m - expected_m).abs() < 0.005, "{log}: {moved_m} {expected_m}");
    }
    let column = |name: &str| {
        let head = table.lines().next().expect("a head");
        let found = head.split(',').position(|column| column == name);
        found.expect("a column")
    };
    for (name, text) in [("pinned", "maybe"), ("level_factor", "-1")] {
        let first = table.lines().nth(1).expect("a row");
        let mut fields: Vec<&str> = first.split(',').collect();
        fields[column(name)] = text;
        fs::write(&path, table.replace(first, &fields.join(","))).expect("a table");
        let refused = refusal(folder, &["adjust", "archive"], 1);
        assert!(refused.contains("line 2 of the table of offsets"), "{refused}");
    }
    fs::write(&path, "name,offset_m\n").expect("a table");
    assert!(refusal(folder, &["archive", "archive"], 1).contains("no column log"));
}

#[test]
fn a_log_that_is_added_moves_no_other() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    sail_many(folder, 5);
    let before = adjusted(folder);
    sail(folder, 40, &zigzag(40, [-10.0, -18.0], 1.1));
    add(folder, &["log-40.sl2"]);
    let after = adjusted(folder);
    for log in 0..5 {
        assert_eq!(offset_m(&before, log), offset_m(&after, log));
    }
    assert!(after["log-40"]["ties"].as_u64() > Some(0));
}
