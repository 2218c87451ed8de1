//! Contains the manual: pages of Markdown that are compiled in, with tables that are derived from
//! the program. `bathyscope manual` prints the pages, F1 shows them; `markdown` parses the part of
//! Markdown that they use.

pub mod markdown;

use super::action::{Action, KeyScope};
use bathyscope_objects::objects::OBJECT_COLUMNS;
use bathyscope_products::outputs::{OUTPUT_FILES, When};
use bathyscope_products::pipeline::settings;
use std::fmt::Write as _;

bathyscope_log::listed! {
    /// All pages, in the order of the manual.
    const ALL;

    /// A page of the manual.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum)]
    pub enum Topic {
        /// The desktop program and its panels
        Window,
        /// Gain, levels, ranges and channels of the waterfall
        Waterfall,
        /// Many logs in one survey
        Survey,
        /// An archive of many logs: one map of all of them, kept up to date in a folder
        #[value(alias = "lake")]
        Archive,
        /// The project file
        Project,
        /// Layers, coordinates, measuring, printing
        Map,
        /// First return, bottom edits, calibration, presets
        Bottom,
        /// Depth maps, corrections, residuals, comparison
        Depth,
        /// Planning of survey lines
        Plan,
        /// The side-scan mosaic
        Mosaic,
        /// Detector, review, a YOLO of your own
        Objects,
        /// The command line
        Commands,
        /// All settings
        Settings,
        /// All files that are written
        Files,
        /// Accuracy, speed and memory
        Accuracy,
        /// Limits of the program
        Limits,
        /// Mouse, keys and commands
        Keys,
    }
}

impl Topic {
    fn source(self) -> &'static str {
        match self {
            Topic::Window => include_str!("../../../assets/manual/window.md"),
            Topic::Waterfall => include_str!("../../../assets/manual/waterfall.md"),
            Topic::Survey => include_str!("../../../assets/manual/survey.md"),
            Topic::Archive => include_str!("../../../assets/manual/archive.md"),
            Topic::Project => include_str!("../../../assets/manual/project.md"),
            Topic::Map => include_str!("../../../assets/manual/map.md"),
            Topic::Bottom => include_str!("../../../assets/manual/bottom.md"),
            Topic::Depth => include_str!("../../../assets/manual/depth.md"),
            Topic::Plan => include_str!("../../../assets/manual/plan.md"),
            Topic::Mosaic => include_str!("../../../assets/manual/mosaic.md"),
            Topic::Objects => include_str!("../../../assets/manual/objects.md"),
            Topic::Commands => include_str!("../../../assets/manual/commands.md"),
            Topic::Settings => include_str!("../../../assets/manual/settings.md"),
            Topic::Files => include_str!("../../../assets/manual/files.md"),
            Topic::Accuracy => include_str!("../../../assets/manual/accuracy.md"),
            Topic::Limits => include_str!("../../../assets/manual/limits.md"),
            Topic::Keys => include_str!("../../../assets/manual/keys.md"),
        }
    }

    /// Returns the title of the page.
    pub fn title(self) -> &'static str {
        let first = self.source().lines().next().unwrap_or_default();
        first.trim_start_matches('#').trim()
    }

    /// Returns the page as Markdown with its tables.
    pub fn text(self) -> String {
        self.source()
            .replace("{{keys}}", &key_table())
            .replace("{{settings}}", &settings::markdown())
            .replace("{{files}}", &file_table())
            .replace("{{object_columns}}", &column_table())
    }
}

/// Returns all pages as one text of Markdown.
pub fn whole() -> String {
    let pages: Vec<String> = Topic::ALL.into_iter().map(Topic::text).collect();
    pages.join("\n")
}

/// Returns the table of all commands of the window with their keys.
fn key_table() -> String {
    let mut table = String::from("| command | key | acts in | does |\n|---|---|---|---|\n");
    for action in Action::ALL {
        let keys: Vec<String> = action.all_keys().map(|keys| format!("`{keys}`")).collect();
        let keys = keys.join(" or ");
        let (label, hint) = (action.label(), action.hint());
        let scope = action.key_scope().map_or("", KeyScope::name);
        // Writing to a string cannot fail.
        writeln!(table, "| {label} | {keys} | {scope} | {hint} |").ok();
    }
    table
}

/// Returns the table of all columns of the table of objects.
fn column_table() -> String {
    let mut table = String::from("| column | what it is |\n|---|---|\n");
    for column in OBJECT_COLUMNS {
        writeln!(table, "| `{}` | {} |", column.name, column.meaning).ok();
    }
    table
}

/// Returns the table of all files of a run: when each is written, and what it contains.
fn file_table() -> String {
    let mut table = String::from("| file | written | what it is |\n|---|---|---|\n");
    for row in OUTPUT_FILES {
        let when = match row.when {
            When::Always => "always".to_owned(),
            When::Chosen(product) => format!("with `--products {}`", product.name()),
            When::Compared => "with a reference".to_owned(),
            When::Searched => "with a search for objects".to_owned(),
            When::Listed => "with a search for objects or a review".to_owned(),
        };
        writeln!(table, "| `{}` | {when} | {} |", row.name, row.brief).ok();
    }
    table
}
