//! The seeds, and what the fuzzer once found, through the same functions.

use super::TARGETS;
use std::fs;
use std::path::Path;

#[test]
fn seeds_are_read() {
    for target in TARGETS {
        let seeds = (target.seeds)();
        assert!(!seeds.is_empty(), "{}", target.name);
        for seed in &seeds {
            assert!(seed.len() <= target.longest, "{}: {}", target.name, seed.len());
            (target.run)(seed);
            // Cut and changed, as the fuzzer begins.
            for at in (0..seed.len()).step_by(seed.len() / 24 + 1) {
                (target.run)(&seed[..at]);
                let mut changed = seed.clone();
                changed[at] = changed[at].wrapping_add(0x7F);
                (target.run)(&changed);
            }
        }
    }
}

#[test]
fn what_was_found_stays_mended() {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/found");
    let folders = fs::read_dir(found).expect("a folder of what was found");
    for folder in folders.flatten().map(|entry| entry.path()) {
        let name = folder.file_name().unwrap_or_default();
        let target = TARGETS.iter().find(|target| name == target.name);
        let target = target.unwrap_or_else(|| panic!("{} is no reader", folder.display()));
        for input in fs::read_dir(&folder).expect("inputs").flatten() {
            (target.run)(&fs::read(input.path()).expect("an input"));
        }
    }
}
