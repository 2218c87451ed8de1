//! The table of formats is what README.md, the flow for archives, the commands and the messages
//! say.

use crate::cli::run;
use bathyscope_log::formats::{self, FORMATS, FileRole, FormatEntry};
use bathyscope_log::support::progress::Progress;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

const BEGIN: &str =
    "<!-- The table of formats: src/log/formats/table.rs. A test compares them. -->\n";
const END: &str = "<!-- The end of the table of formats. -->\n";

/// A file of the project.
fn text(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(path).expect("a file of the project")
}

/// A row of the table in README.md.
fn row(format: &FormatEntry) -> String {
    let opened = format.opened_as(|name| format!("`{name}`"));
    let tried = match format.tried_on {
        Some(_) => "real recordings",
        None => "its specification",
    };
    format!("| {} | {opened} | {tried} |\n", format.recorders)
}

#[test]
fn the_table_in_the_readme_is_that_of_the_program() {
    let readme = text("README.md");
    let (_, after) = readme.split_once(BEGIN).expect("the first marker");
    let (shown, _) = after.split_once(END).expect("the last marker");
    let head = "| recorder | open | tried on |\n|---|---|---|\n";
    let made = FORMATS.iter().map(row);
    let made = head.to_owned() + &made.collect::<String>();
    assert_eq!(shown, made, "write this between the markers:\n{made}");
}

#[test]
fn the_flow_for_archives_opens_the_files_of_every_format() {
    let endings = FORMATS.iter().flat_map(|format| format.endings);
    // The parts of a recording are found beside its description, and a folder of an archive holds
    // other texts and tables too.
    let opened = endings.filter(|(_, role)| matches!(role, FileRole::Log | FileRole::Description));
    let names: Vec<String> =
        opened.map(|(ending, _)| format!("\".{}\"", ending.to_ascii_lowercase())).collect();
    let line = format!("\nENDINGS = {{{}}}\n", names.join(", "));
    let flow = text("assets/archive/Snakefile");
    assert!(flow.contains(&line), "write this into the Snakefile:{line}");
}

#[test]
fn each_format_is_fuzzed_and_the_installer_offers_its_logs() {
    let fuzzed = text("tests/fuzz/logs.rs");
    for format in FORMATS {
        let is_named = |(ending, _): &(&str, FileRole)| fuzzed.contains(&format!("\"{ending}\""));
        assert!(format.endings.iter().any(is_named), "tests/fuzz/logs.rs feeds no {}", format.name);
    }
    let targets = text("tests/fuzz/mod.rs");
    let functions = fuzzed.lines().filter_map(|line| line.strip_prefix("pub(super) fn "));
    for name in functions.filter_map(|line| line.strip_suffix("(bytes: &[u8]) {")) {
        let target = format!("logs::{name},");
        assert!(targets.contains(&target), "TARGETS of tests/fuzz/mod.rs calls no {target}");
    }
    let installer = text("assets/packaging/windows/installer.nsi");
    let (_, list) = installer.split_once("!macro EachEnding DO").expect("the endings");
    let (list, _) = list.split_once("!macroend").expect("the end of the list");
    let lines = list.lines().filter_map(|line| line.trim().strip_prefix("!insertmacro ${DO} "));
    let logs = FORMATS.iter().flat_map(FormatEntry::log_endings);
    assert_eq!(lines.map(str::to_owned).collect::<BTreeSet<_>>(), logs.collect());
}

#[test]
fn the_program_lists_its_formats() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = run(folder.path(), &["info", "--formats"]);
    let json = run(folder.path(), &["info", "--formats", "--json"]);
    let json: Value = serde_json::from_str(&json).expect("JSON");
    let rows = json.as_array().expect("a list");
    assert_eq!(rows.len(), FORMATS.len());
    for (format, row) in FORMATS.iter().zip(rows) {
        assert!(text.contains(&format!("{}\n  recorders      ", format.name)), "{text}");
        assert!(text.contains(format.tried()), "{text}");
        assert_eq!(row["name"].as_str(), Some(format.name));
        assert_eq!(row["tried_on"].as_str(), format.tried_on);
        let endings = row["endings"].as_array().expect("endings");
        assert_eq!(endings.len(), format.endings.len());
        assert_eq!(endings[0]["ending"].as_str(), Some(format.endings[0].0));
    }
}

#[test]
fn a_message_names_every_format_that_was_looked_for() {
    let bytes = b"no log at all".to_vec();
    let error = formats::open_bytes("log.sl2", bytes, &Progress::new()).unwrap_err();
    let folder = tempfile::tempdir().expect("a folder");
    let of_folder = formats::open(folder.path(), &Progress::new()).unwrap_err();
    for format in FORMATS {
        assert!(error.to_string().contains(format.name), "{error}");
        assert!(of_folder.to_string().contains(format.name), "{of_folder}");
    }
}
