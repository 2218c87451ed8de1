//! Makes tables of the manual from the tables that the program itself uses.

use crate::app::Action;
use crate::app::key_scope::KeyScope;
use bathyscope_objects::objects::OBJECT_COLUMNS;
use bathyscope_products::outputs::{OUTPUT_FILES, When};
use std::fmt::Write as _;

/// Returns the table of all commands of the window with their keys.
pub(super) fn keys() -> String {
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

/// Returns the table of all settings: permitted values, value in both presets, and meaning.
pub(super) fn settings() -> String {
    bathyscope_products::pipeline::settings::markdown()
}

/// Returns the table of all columns of the table of objects.
pub(super) fn object_columns() -> String {
    let mut table = String::from("| column | what it is |\n|---|---|\n");
    for column in OBJECT_COLUMNS {
        writeln!(table, "| `{}` | {} |", column.name, column.meaning).ok();
    }
    table
}

/// Returns the table of all files of a run: when each is written, and what it contains.
pub(super) fn files() -> String {
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
