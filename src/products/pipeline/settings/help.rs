//! Makes the texts of all rows of the table of settings: the help and the page of the manual; also
//! finds the row of a key.

use super::rows::ROWS;
use super::table::{SettingKind, SettingRow};
use super::{Preset, Settings};
use std::fmt::Write as _;

/// Returns the row of a key; `None` if no setting has that key.
pub fn row(key: &str) -> Option<&'static SettingRow> {
    ROWS.iter().copied().find(|row| row.key == key)
}

/// Width of a line of the help, which `clap` indents, columns.
const COLUMNS: usize = 88;

/// Returns all keys with their values, default and meaning, for `--help`.
pub fn help() -> String {
    let mut text = String::from(
        "One setting, for example first_return.threshold=0.35; may be given again. All settings, with their values and defaults:\n",
    );
    for row in ROWS {
        let default = match value_in(row, Preset::Recommended) {
            Some(value) => format!("default {value}"),
            None => "without a default".to_owned(),
        };
        // Writing to a string cannot fail.
        write!(text, "\n{} = {}, {default}\n", row.key, row.values()).ok();
        write_wrapped(&mut text, "    ", &row.meaning());
        if let SettingKind::Choice(choice) = &row.kind {
            for name in choice.names {
                let meaning = format!("{}: {}", name.value, name.meaning);
                write_wrapped(&mut text, "      ", &meaning);
            }
        }
    }
    text
}

/// Adds words in lines of at most [`COLUMNS`], each with an indent.
fn write_wrapped(text: &mut String, indent: &str, words: &str) {
    let mut line = String::new();
    for word in words.split_whitespace() {
        if !line.is_empty()
            && indent.len() + line.chars().count() + 1 + word.chars().count() > COLUMNS
        {
            *text += &format!("{indent}{line}\n");
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    *text += &format!("{indent}{line}\n");
}

/// Returns the table as Markdown, for the manual: a part for each group of keys, a line for each
/// key.
pub fn markdown() -> String {
    let mut text = String::new();
    let mut last = None;
    for row in ROWS {
        let group = row.key.split_once('.').map_or("", |(group, _)| group);
        if last != Some(group) {
            let title = match group {
                "" => "Settings of the survey".to_owned(),
                group => format!("`{group}.*`"),
            };
            // Writing to a string cannot fail.
            write!(text, "\n### {title}\n\n| key | values | recommended | published | meaning |\n|---|---|---|---|---|\n").ok();
            last = Some(group);
        }
        let [recommended, published] = [Preset::Recommended, Preset::Published]
            .map(|preset| value_in(row, preset).unwrap_or_else(|| "–".to_owned()));
        let mut meaning = row.meaning();
        if let SettingKind::Choice(choice) = &row.kind {
            for name in choice.names {
                write!(meaning, " `{}`: {}", name.value, name.meaning).ok();
            }
        }
        let cells = [row.values(), recommended, published, meaning];
        // A bar would end the cell.
        let [values, recommended, published, meaning] = cells.map(|cell| cell.replace('|', "\\|"));
        writeln!(text, "| `{}` | {values} | {recommended} | {published} | {meaning} |", row.key)
            .ok();
    }
    text.trim_start().to_owned()
}

/// Returns the value of a setting in a preset; `None` if it has none.
fn value_in(row: &SettingRow, preset: Preset) -> Option<String> {
    let settings = Settings::preset(preset);
    match &row.kind {
        SettingKind::Number(number) => (number.get)(&settings).map(|value| value.to_string()),
        SettingKind::Choice(choice) => Some((choice.get)(&settings)),
        SettingKind::Numbers { .. } | SettingKind::Text(_) => text_value(&settings, row.key),
    }
}

fn text_value(settings: &Settings, key: &str) -> Option<String> {
    let table = toml::Table::try_from(settings).ok()?;
    let mut value = &toml::Value::Table(table);
    for part in key.split('.') {
        value = value.get(part)?;
    }
    match value {
        toml::Value::String(text) => Some(text.clone()),
        toml::Value::Array(items) if items.is_empty() => None,
        other => Some(other.to_string()),
    }
}
