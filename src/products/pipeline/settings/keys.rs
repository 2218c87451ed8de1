//! Finds settings by their keys: applies files and `--set`, makes the messages for keys that do not
//! exist, and the texts of all rows of the table: the help and the page of the manual.

use super::rows::ROWS;
use super::{Preset, SettingKind, SettingRow, Settings, SettingsError};
use std::fmt::Write as _;
use toml::{Table, Value};

/// Key of the bottom edits, which consist of strokes and have no row.
const BOTTOM: &str = "bottom";
/// Largest edit distance at which a key is suggested for an unknown one.
const SLIP: usize = 3;
/// Width of a line of the help, which `clap` indents, columns.
const COLUMNS: usize = 88;

/// Returns the row of a key; `None` if no setting has that key.
pub fn row(key: &str) -> Option<&'static SettingRow> {
    ROWS.iter().copied().find(|row| row.key == key)
}

impl Settings {
    /// Returns these settings with the values of a TOML text in place of theirs.
    ///
    /// # Errors
    /// A sentence that names the line or the key, when the text is not TOML, or a key or value is
    /// not allowed.
    pub fn with_toml(&self, text: &str) -> Result<Self, SettingsError> {
        let refused = |error| SettingsError(format!("settings: {error}"));
        let over: Table = (text.parse()).map_err(|error| refused(not_toml(&error, text)))?;
        self.with_overrides(over).map_err(|error| refused(error.0))
    }

    fn with_overrides(&self, mut over: Table) -> Result<Self, SettingsError> {
        rename_group(&mut over);
        if let Some(sentence) = unknown_in(&over) {
            return Err(SettingsError(sentence));
        }
        let mut table = Table::try_from(self).map_err(|error| SettingsError(error.to_string()))?;
        merge(&mut table, over.clone());
        table.try_into().map_err(|error: toml::de::Error| {
            let sentence = misfit_in(&over).unwrap_or_else(|| in_one_line(error.message()));
            SettingsError(sentence)
        })
    }

    /// Returns these settings with one `key=value` applied, for example
    /// `first_return.threshold=0.35`.
    ///
    /// # Errors
    /// A sentence that names the key, when the text is not `key=value`, or the key or value is not
    /// allowed.
    pub fn with_assignment(&self, assignment: &str) -> Result<Self, SettingsError> {
        let (key, value) = assignment.split_once('=').ok_or_else(|| {
            SettingsError(format!("a setting is written key=value; got `{assignment}`"))
        })?;
        let (key, value) = (key.trim(), value.trim());
        // A value that is not TOML, such as a bare word, is taken as a string.
        let quoted = Value::String(value.to_owned());
        let table = format!("{key} = {value}").parse::<Table>();
        let table = table.or_else(|_| format!("{key} = {quoted}").parse());
        let over = table.map_err(|error| {
            let reason = in_one_line(error.message());
            SettingsError(format!("`{key}` cannot be `{value}`: {reason}"))
        })?;
        self.with_overrides(over)
    }
}

pub(crate) fn in_one_line(text: &str) -> String {
    text.lines().collect::<Vec<_>>().join(" ")
}

/// Describes the part of a text that is not TOML, with its line.
fn not_toml(error: &toml::de::Error, text: &str) -> String {
    let reason = in_one_line(error.message());
    let before = error.span().and_then(|span| text.get(..span.start));
    let Some(before) = before else {
        return reason;
    };
    let line = before.matches('\n').count();
    let value = text.lines().nth(line).and_then(|text| text.split_once('='));
    let hint = value.and_then(|(_, value)| decimal_comma(value));
    format!("line {}: {reason}{}", line + 1, hint.unwrap_or_default())
}

/// Returns a hint if a number is written with a decimal comma.
fn decimal_comma(value: &str) -> Option<String> {
    let written = value.trim().replacen(',', ".", 1);
    let is_number = written != value.trim() && written.parse::<f64>().is_ok();
    is_number.then(|| format!("; write {written}: decimals take a point"))
}

/// Describes the first value that its setting cannot have.
fn misfit_in(over: &Table) -> Option<String> {
    flattened(over).into_iter().find_map(|(key, value)| {
        let row = row(&key)?;
        let mut alone = Table::new();
        insert(&mut alone, &key, value.clone());
        let error = alone.try_into::<Settings>().err()?;
        Some(misfit(row, value, error.message()))
    })
}

/// Returns the sentence that a setting cannot have a value, with the values that it may have;
/// `reason` is the error of the setting's own type.
fn misfit(row: &SettingRow, value: &Value, reason: &str) -> String {
    let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    // Serde's messages are for programmers; the messages of the settings' own types are for users.
    let is_serdes = ["invalid ", "unknown ", "missing ", "data did not match"]
        .iter()
        .any(|start| reason.starts_with(start));
    let hint = match row.kind {
        SettingKind::Number(_) => decimal_comma(&value).unwrap_or_default(),
        _ => String::new(),
    };
    let needed = if is_serdes { format!("it is {}", row.in_words()) } else { in_one_line(reason) };
    format!("`{}` cannot be `{value}`: {needed}{hint}", row.key)
}

fn merge(base: &mut Table, over: Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(inner)), Value::Table(value)) => merge(inner, value),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// Returns the sentence about the first key that does not exist.
fn unknown_in(table: &Table) -> Option<String> {
    let unknown = flattened(table).into_iter().find(|(key, _)| row(key).is_none());
    unknown.map(|(key, _)| no_setting(&key))
}

/// Returns the values of a table of settings by their dotted keys, without the bottom edits.
pub(crate) fn flattened(table: &Table) -> Vec<(String, &Value)> {
    let mut values = Vec::new();
    flatten("", table, &mut values);
    values
}

fn flatten<'a>(prefix: &str, table: &'a Table, values: &mut Vec<(String, &'a Value)>) {
    for (name, value) in table {
        let key = format!("{prefix}{name}");
        match value {
            _ if key == BOTTOM => {}
            // The log of the excluded stretches is a setting whose value is a table.
            Value::Table(inner) if row(&key).is_none() => {
                flatten(&format!("{key}."), inner, values);
            }
            _ => values.push((key, value)),
        }
    }
}

/// Sets the value of a dotted key in a table of settings.
pub(crate) fn insert(table: &mut Table, key: &str, value: Value) {
    let Some((first, rest)) = key.split_once('.') else {
        table.insert(key.to_owned(), value);
        return;
    };
    let inner = table.entry(first).or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(inner) = inner {
        insert(inner, rest, value);
    }
}

/// Group of settings that is also read under the name of an earlier version: old name and present
/// name.
const RENAMED_GROUP: (&str, &str) = ("left_out", "excluded");

/// Renames the group to its present name, unless the table has that one as well.
fn rename_group(table: &mut Table) {
    let (then, now) = RENAMED_GROUP;
    if !table.contains_key(now)
        && let Some(group) = table.remove(then)
    {
        table.insert(now.to_owned(), group);
    }
}

/// Settings that had another name in an earlier version: old name and present name.
const RENAMED: [(&str, &str); 7] = [
    ("left_out.log", "excluded.log"),
    ("left_out.max_turn_deg_s", "excluded.max_turn_deg_s"),
    ("left_out.min_duration_s", "excluded.min_duration_s"),
    ("left_out.min_speed_mps", "excluded.min_speed_mps"),
    ("left_out.stretches", "excluded.stretches"),
    ("picture.swap_sides", "picture.starboard_first"),
    ("water_level.clock_offset_s", "mounting.clock_offset_s"),
];

/// Returns the present name of a setting of an earlier version; `None` where no version had a
/// setting of this name.
pub fn renamed(key: &str) -> Option<&'static str> {
    let found = RENAMED.iter().find(|(then, _)| *then == key);
    found.map(|(_, now)| *now)
}

/// Returns the sentence that a key does not exist, with the key that may have been meant.
fn no_setting(key: &str) -> String {
    if let Some(now) = renamed(key) {
        return format!("`{key}` is called `{now}` now");
    }
    let group = key.split_once('.').map_or(key, |(group, _)| group);
    let of_group: Vec<&str> = (ROWS.iter().map(|row| row.key))
        .filter(|key| key.split_once('.').is_some_and(|(first, _)| first == group))
        .collect();
    let listed = of_group.join(", ");
    if key == group && !of_group.is_empty() {
        return format!("`{key}` is no setting but a group of them: {listed}");
    }
    let near = ROWS.iter().map(|row| (slips(row.key, key), row.key));
    if let Some((_, near)) = near.min().filter(|(slips, _)| *slips <= SLIP) {
        return format!("there is no setting `{key}`; is `{near}` meant?");
    }
    if of_group.is_empty() {
        format!("there is no setting `{key}`; process --help lists all")
    } else {
        format!("there is no setting `{key}`; those of `{group}` are {listed}")
    }
}

/// Returns the number of letters to change, insert or drop between two words (Levenshtein).
pub fn slips(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (index, letter) in from.chars().enumerate() {
        let mut corner = row[0];
        row[0] = index + 1;
        for (column, other) in to.iter().enumerate() {
            let changed = corner + usize::from(letter != *other);
            corner = row[column + 1];
            row[column + 1] = changed.min(corner + 1).min(row[column] + 1);
        }
    }
    row[to.len()]
}

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
        let [recommended, published] =
            Preset::ALL.map(|preset| value_in(row, preset).unwrap_or_else(|| "–".to_owned()));
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
    let table = Table::try_from(settings).ok()?;
    let (_, value) = flattened(&table).into_iter().find(|(of, _)| of == key)?;
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Array(items) if items.is_empty() => None,
        other => Some(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_bottom::first_return::Method;

    #[test]
    fn assignments_take_bare_words_numbers_and_ranges() {
        let settings = Settings::default()
            .with_assignment("first_return.method=threshold")
            .and_then(|s| s.with_assignment("first_return.threshold = 0.41"))
            .and_then(|s| s.with_assignment("calibration.pings=400..600"))
            .and_then(|s| s.with_assignment("outliers.min_neighbors=4"))
            .unwrap();
        assert_eq!(settings.first_return.method, Method::Threshold);
        assert_eq!(settings.first_return.threshold, 0.41);
        assert_eq!(settings.calibration.pings.map(String::from), Some("400..600".to_owned()));
        assert_eq!(settings.outliers.min_neighbors, 4);
    }

    #[test]
    fn unknown_keys_and_bad_values_are_named() {
        let refused = |assignment| {
            let result = Settings::default().with_assignment(assignment);
            result.unwrap_err().0
        };
        assert_eq!(
            refused("first_return.treshold=0.3"),
            "there is no setting `first_return.treshold`; is `first_return.threshold` meant?"
        );
        assert_eq!(
            refused("cloud.colour=3"),
            "there is no setting `cloud.colour`; those of `cloud` are cloud.geometry, cloud.alpha2_deg, cloud.down_scan"
        );
        assert_eq!(
            refused("water_level.clock_offset_s=3"),
            "`water_level.clock_offset_s` is called `mounting.clock_offset_s` now"
        );
        assert!(RENAMED.iter().all(|(_, now)| row(now).is_some()));
        let settings = Settings::default().with_assignment("left_out.min_duration_s=4");
        assert_eq!(settings.map(|settings| settings.excluded.min_duration_s), Ok(4.0));
        let file = Settings::default().with_toml("[left_out]\nmin_duration_s = 5.0\n");
        assert_eq!(file.map(|settings| settings.excluded.min_duration_s), Ok(5.0));
        assert!(refused("nothing_alike=3").contains("--help"));
        assert_eq!(
            refused("cloud=3"),
            "`cloud` is no setting but a group of them: cloud.geometry, cloud.alpha2_deg, cloud.down_scan"
        );
        assert!(refused("nonsense").contains("key=value"));
        let file = Settings::default().with_toml("[surface]\nmax_gap = 3\n");
        assert_eq!(
            file.unwrap_err().0,
            "settings: there is no setting `surface.max_gap`; is `surface.max_gap_m` meant?"
        );
        assert!(Settings::default().with_toml("[bottom]\npings = 4\n").is_ok());
    }

    #[test]
    fn a_value_that_does_not_fit_is_refused_in_an_analysts_words() {
        for (assignment, expected) in [
            (
                "draft_m=1,5",
                "`draft_m` cannot be `1,5`: it is a number, 0 to 20 m; write 1.5: decimals take a point",
            ),
            ("draft_m=deep", "`draft_m` cannot be `deep`: it is a number, 0 to 20 m"),
            (
                "outliers.min_neighbors=2.5",
                "`outliers.min_neighbors` cannot be `2.5`: it is a whole number, 1 to 10000",
            ),
            (
                "outliers.min_neighbors=-3",
                "`outliers.min_neighbors` cannot be `-3`: it is a whole number, 1 to 10000",
            ),
            (
                "isobaths.depths_m=2",
                "`isobaths.depths_m` cannot be `2`: it is a list of numbers, [A, B, ...], each -10000 to 12000 m",
            ),
            ("projection=flat", "`projection` cannot be `flat`: it is enu | mercator"),
            ("points.las=perhaps", "`points.las` cannot be `perhaps`: it is false | true"),
            ("track.file=3", "`track.file` cannot be `3`: it is a file, CSV or GPX"),
            ("source.crs=33", "`source.crs` cannot be `33`: it is EPSG:NUMBER"),
        ] {
            let refused = Settings::default().with_assignment(assignment);
            assert_eq!(refused.unwrap_err().0, expected);
        }
        for (file, expected) in [
            (
                "[surface]\nmax_side = \"big\"\n",
                "settings: `surface.max_side` cannot be `big`: it is a whole number, 16 to 32768",
            ),
            ("\ndraft_m = 1,5\n", "; write 1.5: decimals take a point"),
        ] {
            let refused = Settings::default().with_toml(file).unwrap_err().0;
            assert!(refused.ends_with(expected), "{refused}");
        }
    }

    #[test]
    fn slips_are_counted_in_letters() {
        assert_eq!(slips("draft_m", "draft_m"), 0);
        assert_eq!(slips("draft_m", "draugth_m"), 3);
        assert_eq!(slips("", "abc"), 3);
    }
}
