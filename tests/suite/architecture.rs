//! The borders between the modules: data flows one way, and the widgets and the GPU stay where they
//! belong.

mod imports;

use std::fs;
use std::path::{Path, PathBuf};

/// The crates under `src` beside the program's own.
const CRATES: [&str; 5] = ["log", "simulation", "bottom", "objects", "products"];

/// Modules of each crate in the order of the data; a module may name those in its own row, never
/// the others. Cargo guards the borders between crates.
const MAY_USE: &[(&str, &str, &[&str])] = &[
    ("log", "support", &[]),
    ("log", "survey", &["support"]),
    ("log", "formats", &["support", "survey"]),
    ("bottom", "vectors", &[]),
    ("bottom", "sparse", &[]),
    ("bottom", "nearest", &[]),
    ("bottom", "presentation", &[]),
    ("bottom", "first_return", &["vectors"]),
    ("bottom", "waterfall", &["first_return"]),
    ("bottom", "calibration", &["first_return"]),
    ("bottom", "cloud", &["first_return", "calibration"]),
    ("bottom", "bathymetry", &["cloud", "presentation", "sparse", "nearest"]),
    ("bottom", "planning", &["bathymetry", "nearest"]),
    ("bottom", "swath", &["bathymetry", "sparse", "nearest"]),
    ("bottom", "mosaic", &["vectors", "first_return", "calibration", "bathymetry", "presentation"]),
    ("bottom", "picture", &["vectors", "first_return", "calibration", "mosaic", "waterfall"]),
    ("products", "file_name", &[]),
    ("products", "file_in_use", &[]),
    ("products", "map_tiles", &[]),
    ("products", "export", &["file_in_use", "map_tiles"]),
    ("products", "pipeline", &[]),
    ("products", "html_report", &["export", "pipeline"]),
    (
        "products",
        "outputs",
        &["export", "file_in_use", "file_name", "html_report", "map_tiles", "pipeline"],
    ),
    ("products", "archive", &["export", "file_in_use", "file_name", "map_tiles", "pipeline"]),
    ("products", "project", &["export", "file_in_use", "pipeline"]),
    ("", "app", &[]),
    ("", "ui", &["app"]),
    ("", "ui::render", &[]),
];

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of the source tree").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found
}

fn source() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The folder of a crate; the program's own is the empty name.
fn folder_of(name: &str) -> PathBuf {
    source().join(name)
}

/// The files of a crate, without those of its integration tests and examples.
fn files_of(name: &str) -> Vec<PathBuf> {
    let folder = folder_of(name);
    let beside = |path: &PathBuf| {
        let inside = |other: &str| path.starts_with(folder.join(other));
        ["tests", "examples"].into_iter().any(inside)
            || name.is_empty() && CRATES.into_iter().any(inside)
    };
    rust_files(&folder).into_iter().filter(|path| !beside(path)).collect()
}

/// The code of a file without its line comments.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a readable source file");
    text.lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn modules_name_only_modules_before_them() {
    let mut offences = Vec::new();
    for (own, module, may_use) in MAY_USE {
        let others: Vec<&str> = MAY_USE
            .iter()
            .filter(|(other, ..)| other == own)
            .map(|(_, other, _)| *other)
            .chain(["cli"])
            .collect();
        let path = folder_of(own).join(module.replace("::", "/"));
        let files = if path.is_dir() { rust_files(&path) } else { vec![path.with_extension("rs")] };
        for path in files {
            // What a module says of itself names no other.
            let code = code(&path).replace(&format!("crate::{module}::"), "");
            for other in &others {
                let names_it = code.contains(&format!("crate::{other}::"))
                    || code.contains(&format!("crate::{other};"));
                if other != module && names_it && !may_use.contains(other) {
                    offences.push(format!("{} names crate::{other}", path.display()));
                }
            }
        }
    }
    assert!(offences.is_empty(), "{offences:#?}");
}

/// A crate that knew a later one could not be built, but for tests: their dependencies may go
/// round.
#[test]
fn crates_depend_on_crates_before_them() {
    for (at, name) in CRATES.iter().enumerate() {
        let manifest = fs::read_to_string(folder_of(name).join("Cargo.toml")).expect("a manifest");
        for later in &CRATES[at..] {
            let named = manifest.contains(&format!("\nbathyscope-{later}"));
            assert!(!named, "bathyscope-{name} names bathyscope-{later}");
        }
    }
}

#[test]
fn only_ui_names_egui_and_wgpu_and_render_names_no_egui() {
    let mut offences = Vec::new();
    for path in rust_files(&source()) {
        let relative =
            path.strip_prefix(source()).expect("a path below src").to_string_lossy().into_owned();
        let code = code(&path);
        let in_ui = relative.starts_with("ui/");
        let names_egui = ["egui::", "egui_tiles", "eframe::", "egui_wgpu"]
            .iter()
            .any(|name| code.contains(name));
        if names_egui && !in_ui {
            offences.push(format!("{relative} names egui"));
        }
        if code.contains("wgpu::") && !in_ui {
            offences.push(format!("{relative} names wgpu"));
        }
        if names_egui && relative.starts_with("ui/render/") {
            offences.push(format!("{relative} names egui"));
        }
    }
    assert!(offences.is_empty(), "{offences:#?}");
}

#[test]
fn the_pipeline_computes_and_writes_nothing() {
    let mut offences = Vec::new();
    for path in rust_files(&folder_of("products").join("pipeline")) {
        let code = code(&path);
        for name in ["write_aside", "fs::write", "create_dir", "File::create", "io::Write"] {
            if code.contains(name) {
                offences.push(format!("{} names {name}", path.display()));
            }
        }
    }
    assert!(offences.is_empty(), "{offences:#?}");
}

/// Modules that make results: the window asks the state for these.
const MAKES_RESULTS: [&str; 9] = [
    "bathyscope_bottom::bathymetry",
    "bathyscope_bottom::calibration",
    "bathyscope_bottom::cloud",
    "bathyscope_bottom::first_return",
    "bathyscope_bottom::mosaic",
    "bathyscope_bottom::planning",
    "bathyscope_bottom::swath",
    "bathyscope_log::support::statistics",
    "bathyscope_products::pipeline",
];

/// The table of settings makes nothing.
const SETTINGS_TABLE: [&str; 2] = ["rows", "settings"];

/// Makers of results that are types.
const MAKERS: [&str; 6] =
    ["DepthMap::new", "Derived::", "Isobaths::new", "Light::suited", "Mosaic::new", "Surface::"];

/// Names that the code takes out of a module: `{a, b::C}` after `module::` gives `a` and `C`.
fn names_of(code: &str, module: &str) -> Vec<String> {
    let names_in = |text: &str| -> Vec<String> {
        let in_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let (path, rest) = text.split_at(text.find(|c| !in_path(c)).unwrap_or(text.len()));
        let listed = rest.strip_prefix('{').filter(|_| path.is_empty() || path.ends_with("::"));
        let names = listed.map_or(path, |rest| rest.split('}').next().unwrap_or(rest));
        let last = |name: &str| name.trim().rsplit("::").next().map(str::to_owned);
        names.split(',').filter_map(last).filter(|name| !name.is_empty()).collect()
    };
    let path = format!("{module}::");
    let mut found: Vec<String> = (code.split(&path).skip(1)).flat_map(names_in).collect();
    let whole = format!("use {module};");
    if code.contains(&whole) {
        let inline = format!("{}::", module.rsplit("::").next().unwrap_or(module));
        found.extend(code.split(&inline).skip(1).flat_map(names_in));
    }
    found
}

#[test]
fn ui_computes_no_result() {
    let is_function = |name: &String| {
        let is_module = name == "self" || SETTINGS_TABLE.contains(&name.as_str());
        name.starts_with(|first: char| first.is_lowercase()) && !is_module
    };
    let mut offences = Vec::new();
    for path in rust_files(&source().join("ui")) {
        let code = code(&path);
        // Tests compare what is drawn with results.
        let code = code.split("#[cfg(test)]").next().unwrap_or_default();
        for module in MAKES_RESULTS {
            for name in names_of(code, module).iter().filter(|name| is_function(name)) {
                offences.push(format!("{} takes {module}::{name}", path.display()));
            }
        }
        for maker in MAKERS.iter().filter(|maker| code.contains(**maker)) {
            offences.push(format!("{} names {maker}", path.display()));
        }
    }
    assert!(offences.is_empty(), "{offences:#?}");
    // The check itself: it sees functions however they are named.
    let seen = |code: &str| names_of(code, "bathyscope_bottom::bathymetry").iter().any(is_function);
    assert!(seen("use bathyscope_bottom::bathymetry::{Grid, hill_shade};"));
    assert!(seen("use bathyscope_bottom::bathymetry;\nlet x = bathymetry::depth_range(y);"));
    assert!(seen("let x = bathyscope_bottom::bathymetry::isobaths::smoothed(line, 2);"));
    assert!(!seen("use bathyscope_bottom::bathymetry::isobaths::IsobathSettings;"));
}

#[test]
fn no_files_import_each_other() {
    let mut found = 0;
    for name in CRATES.into_iter().chain([""]) {
        let imports = imports::imports(name);
        found += imports.values().map(|names| names.len()).sum::<usize>();
        let circles = imports::circles(&imports);
        assert!(circles.is_empty(), "{name}: {circles:#?}");
    }
    assert!(found > 2000, "only {found} imports were found");
    // The check itself: it sees a way back through a third file.
    let import_of = |name: &str| [(name.to_owned(), ["Item".to_owned()].into())].into();
    let three = [("a", "b"), ("b", "c"), ("c", "a"), ("d", "a")];
    let three = three.map(|(from, to)| (from.to_owned(), import_of(to)));
    assert_eq!(imports::circles(&three.into()).len(), 3);
}

#[test]
fn files_stay_small_enough_to_read() {
    let long: Vec<String> = rust_files(&source())
        .into_iter()
        .filter_map(|path| {
            let lines = fs::read_to_string(&path).expect("a readable source file").lines().count();
            (lines > 600).then(|| format!("{}: {lines} lines", path.display()))
        })
        .collect();
    assert!(long.is_empty(), "{long:#?}");
}

#[test]
fn controls_of_settings_have_their_range_from_the_table() {
    // The filter of boxes, the comparison and the plan of further lines have controls that move no
    // setting.
    const NO_SETTINGS: [&str; 3] = ["review/queue.rs", "panels/residuals.rs", "panels/plan.rs"];
    let panels = source().join("ui/panels");
    let parts = panels.join("parts.rs");
    let mut offences = Vec::new();
    for path in rust_files(&panels) {
        let other = NO_SETTINGS.iter().any(|name| path.ends_with(name));
        let code = code(&path);
        let makes_one = ["Slider::new", "DragValue::new", "number_slider(", "number_field("]
            .iter()
            .any(|control| code.contains(control));
        if makes_one && !other && path != parts {
            offences.push(format!("{} makes a control of its own", path.display()));
        }
    }
    let code = code(&parts);
    let before_ranges = code.split("..=").map(|before| before.chars().last());
    let literal = |last: Option<char>| last.is_some_and(|last| last.is_ascii_digit());
    if before_ranges.into_iter().any(literal) || !code.contains("number_slider(") {
        offences.push("parts.rs has a range of its own".to_owned());
    }
    assert!(offences.is_empty(), "{offences:#?}");
}
