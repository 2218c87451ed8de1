//! Input that is made to harm, or was harmed: logs, settings, tables, rasters, pictures, models,
//! tracks and reviews, through the program itself. Whatever they hold, it ends with exit code 0, 1
//! or 2, says why in one printable line, leaves no half file, and takes less than ten seconds of
//! processor time and 500 MB.
//!
//! `named` are those that once did otherwise, each by itself. `kinds` makes as many more as are
//! asked for: a few here, and with
//!
//! ```text
//! BATHYSCOPE_HOSTILE=2000 cargo test --release --test suite hostile::recorded -- --ignored --nocapture
//! ```
//!
//! two thousand, of which the worst are printed. `BATHYSCOPE_HOSTILE_FROM=N` begins with case N: a
//! failure names its number.

mod kinds;
mod mutate;
mod named;
mod run;

use kinds::Seeds;
use run::{Outcome, fault, program};
use std::collections::BTreeMap;
use std::path::Path;

/// Seconds of processor time that any input may take.
const MOST_CPU_S: f64 = 10.0;
/// Memory that any input may take.
const MOST_MIB: u64 = 500;
/// Cases that are run with all other tests.
const FEW: usize = 45;

/// Runs the program and holds the outcome to all that can be asked of it but its time.
fn survives(folder: &Path, args: &[String]) -> Outcome {
    let outcome = program(folder, args);
    if let Some(fault) = fault(&outcome, folder) {
        panic!("{args:?}: {fault}");
    }
    assert!(outcome.peak_mib < MOST_MIB, "{args:?} takes {} MiB", outcome.peak_mib);
    outcome
}

#[test]
fn whatever_a_file_holds_it_is_read_or_refused() {
    let seeds = Seeds::new();
    for number in 0..FEW {
        let case = seeds.case(number);
        survives(case.folder.path(), &case.args);
    }
}

/// Runs apart from the others: two thousand runs take half an hour of processor time.
#[test]
#[ignore = "thousands of runs; see the head of this file"]
fn recorded() {
    let number = |name: &str, otherwise: usize| {
        let set = std::env::var(name).ok();
        set.map_or(otherwise, |text| text.parse().expect("a number"))
    };
    let count = number("BATHYSCOPE_HOSTILE", 2000);
    let from = number("BATHYSCOPE_HOSTILE_FROM", 0);
    let seeds = Seeds::new();
    let mut codes: BTreeMap<(&str, Option<i32>), usize> = BTreeMap::new();
    let (mut slowest, mut largest) = ((0.0, String::new()), (0, String::new()));
    let mut faults = Vec::new();
    for number in from..from + count {
        let case = seeds.case(number);
        let outcome = program(case.folder.path(), &case.args);
        let named = format!("case {number}, {}: {:?}", case.kind, case.args);
        *codes.entry((case.kind, outcome.code)).or_default() += 1;
        let mut wrong: Vec<String> = fault(&outcome, case.folder.path()).into_iter().collect();
        if outcome.cpu_s > MOST_CPU_S {
            wrong.push(format!("{:.1} s", outcome.cpu_s));
        }
        if outcome.peak_mib >= MOST_MIB {
            wrong.push(format!("{} MiB", outcome.peak_mib));
        }
        for what in wrong {
            println!("{named}: {what}");
            faults.push(number);
        }
        if outcome.cpu_s > slowest.0 {
            slowest = (outcome.cpu_s, named.clone());
        }
        if outcome.peak_mib > largest.0 {
            largest = (outcome.peak_mib, named);
        }
    }
    println!("{count} cases from {from}");
    for ((kind, code), count) in codes {
        println!("{kind:<20} exit {code:?}: {count}");
    }
    println!("slowest {:.1} s: {}", slowest.0, slowest.1);
    println!("largest {} MiB: {}", largest.0, largest.1);
    assert!(faults.is_empty(), "{faults:?}");
}
