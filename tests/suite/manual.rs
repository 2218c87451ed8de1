//! The manual against the program: what it names exists, and what exists is in it; and the manual
//! in the window.

use crate::cli::{refusal, run};
use crate::window::{app, empty_window, press};
use bathyscope::app::Action;
use bathyscope::app::manual::{Topic, whole};
use bathyscope_bottom::cloud::PointClass;
use bathyscope_log::survey::SoundingFault;
use bathyscope_products::outputs::{OUTPUT_FILES, row_of};
use bathyscope_products::pipeline::settings::rows::ROWS;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::collections::BTreeSet;
use std::path::Path;

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The readable names of the program: code in backticks, outside of fenced code.
fn named(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (index, part) in text.split("```").enumerate() {
        if index % 2 == 0 {
            found.extend(part.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    found
}

/// Lines of fenced code that run the program, without their comments.
fn examples(text: &str) -> Vec<String> {
    let fenced = text.split("```").skip(1).step_by(2);
    let fenced = fenced.filter(|code| code.starts_with("sh\n"));
    let lines = fenced.flat_map(str::lines);
    let program = lines.filter(|line| line.starts_with("bathyscope "));
    program.map(|line| line.split(" #").next().unwrap_or_default().trim().to_owned()).collect()
}

/// Names at the start of the lines of a list in `--help`.
fn listed(help: &str, heading: &str) -> BTreeSet<String> {
    let lines = help.lines().skip_while(|line| !line.starts_with(heading));
    let list = lines.skip(1).take_while(|line| !line.is_empty());
    let names = list.filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next());
    names.map(str::to_owned).collect()
}

fn subcommands() -> BTreeSet<String> {
    let mut names = listed(&run(here(), &["--help"]), "Commands:");
    names.remove("help");
    assert!(names.len() > 8, "{names:?}");
    names
}

fn readme() -> String {
    std::fs::read_to_string(here().join("README.md")).expect("a README")
}

#[test]
fn every_subcommand_is_in_it_and_its_examples_have_options_that_exist() {
    let all = subcommands();
    let mut shown = BTreeSet::new();
    let examples = [examples(&whole()), examples(&readme())].concat();
    for line in &examples {
        let words: Vec<&str> = line.split_whitespace().collect();
        if !all.contains(words[1]) {
            assert!(words[1].contains('.'), "{line}: no such command");
            continue;
        }
        shown.insert(words[1].to_owned());
        let help = run(here(), &[words[1], "--help"]);
        for option in words.iter().filter(|word| word.starts_with("--")) {
            assert!(help.split_whitespace().any(|word| word == *option), "{line}: {option}");
        }
    }
    assert_eq!(shown, all, "commands of the manual and of the program");
}

#[test]
fn every_setting_is_in_it_and_every_setting_that_it_names_exists() {
    let all: BTreeSet<String> = ROWS.iter().map(|row| row.key.to_owned()).collect();
    let group = |key: &String| key.split_once('.').map(|(group, _)| group.to_owned());
    let groups: BTreeSet<String> = all.iter().filter_map(group).collect();
    let text = whole() + &readme();
    let keys: BTreeSet<String> = named(&text)
        .into_iter()
        .filter(|name| group(name).is_some_and(|group| groups.contains(&group)))
        .filter(|name| row_of(name).is_none() && !name.ends_with(".*"))
        .collect();
    let unknown: Vec<&String> = keys.difference(&all).collect();
    assert!(unknown.is_empty(), "no settings: {unknown:?}");
    let pages: BTreeSet<String> = named(&text);
    let missing: Vec<&String> = all.difference(&pages).collect();
    assert!(missing.is_empty(), "not in the manual: {missing:?}");
}

#[test]
fn every_file_of_a_run_is_in_it_and_every_record_that_it_names_exists() {
    let page = named(&Topic::Files.text());
    for row in OUTPUT_FILES {
        assert!(page.contains(row.name), "{} is not in the manual", row.name);
    }
    let endings = [".tif", ".laz", ".ply", ".csv", ".json", ".html", ".geojson"];
    let is_file = |name: &&String| {
        endings.iter().any(|ending| name.ends_with(ending) && name.len() > ending.len())
    };
    for name in page.iter().filter(is_file) {
        assert!(row_of(name).is_some(), "{name} is no file of a run");
    }
}

#[test]
fn every_class_of_points_and_every_fault_of_soundings_is_in_its_tables() {
    let page = Topic::Files.text();
    for class in PointClass::ALL {
        let row = format!("| {} {} |", class.code(), class.name());
        assert!(page.contains(&row), "{row}");
    }
    for fault in SoundingFault::ALL {
        let row = format!("| {} |", fault.name());
        assert!(page.contains(&row), "{row}");
    }
}

#[test]
fn every_key_that_it_names_is_one_of_the_window() {
    // Keys that act on a selected box, the bottom or the pointer, beyond those of the commands.
    let others = ["Ctrl", "Shift", "Alt", "Up", "Down", "1", "9"];
    let keys: BTreeSet<&str> = Action::ALL.iter().flat_map(|action| action.all_keys()).collect();
    let known = |name: &str| keys.contains(name) || others.contains(&name);
    let is_key = |name: &&String| {
        let last = name.rsplit('+').next().unwrap_or_default();
        let starts = last
            .chars()
            .next()
            .is_some_and(|sign| sign.is_ascii_uppercase() || sign.is_ascii_digit());
        let is_word =
            last.chars().skip(1).all(|sign| sign.is_ascii_lowercase() || sign.is_ascii_digit());
        starts
            && is_word
            && !last.is_empty()
            && (last.len() == 1
                || name.contains('+')
                || known(name)
                || last.starts_with('F') && last.len() < 4)
    };
    let text = Topic::Keys.text() + &readme() + &Topic::Bottom.text() + &Topic::Window.text();
    let shown: BTreeSet<String> = named(&text);
    for name in shown.iter().filter(is_key) {
        assert!(known(name), "{name} is no key of the window");
    }
    for key in keys {
        assert!(shown.contains(key), "{key} is not in the manual");
    }
}

#[test]
fn it_is_printed_whole_and_by_topic() {
    let all = run(here(), &["manual"]);
    for topic in Topic::ALL {
        assert!(all.contains(&format!("# {}\n", topic.title())), "{topic:?}");
        assert!(!topic.text().contains("{{"), "{topic:?} has a table that nothing fills");
    }
    let files = run(here(), &["manual", "files"]);
    assert!(files.starts_with("# Files\n") && files.contains("depth/depth.tif"));
    let refused = refusal(here(), &["manual", "nonsense"], 2);
    assert!(refused.contains("accuracy"), "{refused}");
}

#[test]
fn the_window_shows_every_command_with_its_key_and_finds_words_in_all_pages() {
    let mut window = empty_window();
    press(&mut window, Modifiers::NONE, Key::F1);
    for action in Action::ALL {
        assert!(
            window.query_all_by_label(action.hint()).next().is_some(),
            "{} is missing",
            action.label()
        );
    }
    window.get_by_label("Limits").click();
    window.run();
    assert!(window.query_by_label_contains("no search equipment").is_some());
    assert!(window.query_by_label(Action::Fit.hint()).is_none());
    let field = window.get_by_role_and_label(Role::TextInput, "Search the manual");
    field.focus();
    field.type_text("gain-normalised shadows");
    window.run();
    assert!(window.query_by_label_contains("puts every echo at its place").is_some());
    assert!(window.query_by_label_contains("no search equipment").is_none());
    window.get_by_role_and_label(Role::TextInput, "Search the manual").focus();
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(window.query_by_label_contains("puts every echo at its place").is_none());
    assert!(app(&window).logs.shown.survey.is_none());
}
