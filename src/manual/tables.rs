//! Tables of the manual that are derived from the tables that the program itself works by.

use crate::app::Action;
use crate::outputs::{OUTPUT_FILES, When};
use crate::pipeline::{Preset, Settings, is_of_one_log, setting_keys, setting_values};
use std::fmt::Write as _;
use toml::Value;

/// Every command of the window, with its key.
pub(super) fn keys() -> String {
    let mut table = String::from("| command | key | does |\n|---|---|---|\n");
    for action in Action::ALL {
        let keys = action.keys();
        let keys = keys.map_or(String::new(), |keys| format!("`{keys}`"));
        let (label, hint) = (action.label(), action.hint());
        // Writing to a string cannot fail.
        writeln!(table, "| {label} | {keys} | {hint} |").ok();
    }
    table
}

/// Every setting with its value in both presets, and whether it belongs to one log.
pub(super) fn settings() -> String {
    let [recommended, published] = [Preset::Recommended, Preset::Published]
        .map(|preset| setting_values(&Settings::preset(preset)));
    let mut table =
        String::from("| setting | recommended | published | belongs to |\n|---|---|---|---|\n");
    for key in setting_keys() {
        let [here, there] = [&recommended, &published].map(|preset| match preset.get(&key) {
            Some(Value::String(text)) => text.clone(),
            Some(value) => value.to_string(),
            None => "not given".to_owned(),
        });
        let there = if there == here { "the same" } else { &there };
        let whose = if is_of_one_log(&key) {
            "one log"
        } else {
            "all logs"
        };
        writeln!(table, "| `{key}` | {here} | {there} | {whose} |").ok();
    }
    table
}

/// Every file of a run: the group of `--products` that it belongs to, and what it is.
pub(super) fn files() -> String {
    let mut table = String::from("| file | written | what it is |\n|---|---|---|\n");
    for row in OUTPUT_FILES {
        let when = match row.when {
            When::Always => "always".to_owned(),
            When::Chosen(product) => format!("with `--products {}`", product.name()),
            When::Compared => "with a reference".to_owned(),
            When::Searched => "with a search for objects".to_owned(),
        };
        writeln!(table, "| `{}` | {when} | {} |", row.name, row.brief).ok();
    }
    table
}
