//! The workflow that makes a release calls scripts of this repository, for the targets that the
//! release script has. tests/packaging/run checks the packages.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

const WORKFLOW: &str = ".github/workflows/release.yml";

fn of_project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn text(path: &str) -> String {
    fs::read_to_string(of_project(path)).expect("a file of the project")
}

/// The words of a text that name a target: `x86_64-pc-windows-gnu`.
fn targets(text: &str) -> BTreeSet<&str> {
    let between = |letter: char| !letter.is_ascii_alphanumeric() && !"_-".contains(letter);
    let target = |word: &&str| word.starts_with("x86_64-") || word.starts_with("aarch64-");
    text.split(between).filter(target).collect()
}

#[test]
fn each_step_of_the_workflow_runs_a_script() {
    let workflow = text(WORKFLOW);
    let keys = workflow.lines().map(|line| line.trim_start_matches([' ', '-']));
    let steps: Vec<&str> = keys.filter_map(|key| key.strip_prefix("run:")).collect();
    assert!(!steps.is_empty());
    for step in steps {
        let script = step.split_whitespace().next().expect("a command");
        let metadata = fs::metadata(of_project(script));
        let runs = |file: fs::Metadata| file.is_file() && file.permissions().mode() & 0o100 != 0;
        assert!(metadata.is_ok_and(runs), "no script is called:{step}");
    }
}

#[test]
fn the_workflow_makes_the_targets_of_the_release_script() {
    let (workflow, script) = (text(WORKFLOW), text("assets/packaging/release"));
    assert_eq!(targets(&workflow), targets(&script));
    assert_eq!(targets(&workflow).len(), 5);
}
