//! Settings by their keys: files and `--set` laid over others, and what to say of a key that is none.

use super::rows::ROWS;
use super::table::row;
use super::{Settings, SettingsError};

/// Key of the bottom edits, which are made of strokes and have no row.
const BOTTOM: &str = "bottom";
/// So many letters off, and a key is still taken for a slip of the pen.
const SLIP: usize = 3;

impl Settings {
    /// Lays the keys of a TOML text over these settings.
    ///
    /// # Errors
    /// A sentence that names the line or the key.
    pub fn with_toml(&self, text: &str) -> Result<Self, SettingsError> {
        let refused = |reason: String| SettingsError(format!("settings: {reason}"));
        let over: toml::Table = (text.parse()).map_err(|error| refused(one_line(&error, text)))?;
        if let Some(sentence) = unknown_in(&over) {
            return Err(refused(sentence));
        }
        (self.with_overrides(over)).map_err(|error| refused(one_line(&error, text)))
    }

    fn with_overrides(&self, over: toml::Table) -> Result<Self, toml::de::Error> {
        let mut table = toml::Table::try_from(self).map_err(serde::de::Error::custom)?;
        merge(&mut table, over);
        table.try_into()
    }

    /// Applies one `key=value`, for example `first_return.threshold=0.35`.
    ///
    /// # Errors
    /// A sentence that names the key.
    pub fn with_assignment(&self, assignment: &str) -> Result<Self, SettingsError> {
        let (key, value) = assignment.split_once('=').ok_or_else(|| {
            SettingsError(format!(
                "a setting is written key=value; got `{assignment}`"
            ))
        })?;
        let (key, value) = (key.trim(), value.trim());
        // A bare word is a string; numbers and booleans stay what TOML says they are.
        let quoted = toml::Value::String(value.to_owned());
        let table = format!("{key} = {value}").parse::<toml::Table>();
        let table = table.or_else(|_| format!("{key} = {quoted}").parse());
        let cannot = |error: toml::de::Error| {
            let reason = error.message().lines().collect::<Vec<_>>().join(" ");
            SettingsError(format!("`{key}` cannot be `{value}`: {reason}"))
        };
        let over = table.map_err(cannot)?;
        match unknown_in(&over) {
            Some(sentence) => Err(SettingsError(sentence)),
            None => self.with_overrides(over).map_err(cannot),
        }
    }
}

/// What is wrong with the TOML, with its line where it is not TOML at all, else with the key's name.
fn one_line(error: &toml::de::Error, text: &str) -> String {
    let before = error.span().and_then(|span| text.get(..span.start));
    match before {
        Some(before) => {
            let line = before.matches('\n').count() + 1;
            let reason = error.message().lines().collect::<Vec<_>>().join(" ");
            format!("line {line}: {reason}")
        }
        None => error.to_string().lines().collect::<Vec<_>>().join(" "),
    }
}

fn merge(base: &mut toml::Table, over: toml::Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(value)) => merge(inner, value),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// What to say of the first key that is no setting.
fn unknown_in(table: &toml::Table) -> Option<String> {
    let mut keys = Vec::new();
    flatten("", table, &mut keys);
    let is_known = |key: &String| {
        let group = format!("{key}.");
        // A group that is given a value is refused with its type.
        row(key).is_some() || ROWS.iter().any(|row| row.key.starts_with(&group))
    };
    keys.iter()
        .find(|key| !is_known(key))
        .map(|key| no_setting(key))
}

fn flatten(prefix: &str, table: &toml::Table, keys: &mut Vec<String>) {
    for (name, value) in table {
        let key = format!("{prefix}{name}");
        match value {
            _ if key == BOTTOM => {}
            toml::Value::Table(inner) if row(&key).is_none() => {
                flatten(&format!("{key}."), inner, keys);
            }
            _ => keys.push(key),
        }
    }
}

/// Settings that were called otherwise in an earlier version: then and now.
const RENAMED: [(&str, &str); 2] = [
    ("picture.swap_sides", "picture.starboard_first"),
    ("water_level.clock_offset_s", "mounting.clock_offset_s"),
];

/// What a setting of an earlier version is called now; `None` where no version had one of this name.
pub fn renamed(key: &str) -> Option<&'static str> {
    let found = RENAMED.iter().find(|(then, _)| *then == key);
    found.map(|(_, now)| *now)
}

/// That a key is none, and which it may have been meant for.
fn no_setting(key: &str) -> String {
    if let Some(now) = renamed(key) {
        return format!("`{key}` is called `{now}` now");
    }
    let near = ROWS.iter().map(|row| (slips(row.key, key), row.key));
    if let Some((_, near)) = near.min().filter(|(slips, _)| *slips <= SLIP) {
        return format!("there is no setting `{key}`; is `{near}` meant?");
    }
    let group = key.split_once('.').map_or(key, |(group, _)| group);
    let of_group: Vec<&str> = (ROWS.iter().map(|row| row.key))
        .filter(|key| key.split_once('.').is_some_and(|(first, _)| first == group))
        .collect();
    match of_group.is_empty() {
        true => format!("there is no setting `{key}`; process --help lists all"),
        false => format!(
            "there is no setting `{key}`; those of `{group}` are {}",
            of_group.join(", ")
        ),
    }
}

/// Letters to change, insert or drop between two words (Levenshtein).
fn slips(from: &str, to: &str) -> usize {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::first_return::Method;

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
        assert_eq!(
            settings.calibration.pings.map(String::from),
            Some("400..600".to_owned())
        );
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
        assert!(refused("nothing_alike=3").contains("--help"));
        assert!(refused("cloud.geometry=flat").contains("flat"));
        assert!(refused("cloud=3").contains("`cloud` cannot be `3`"));
        assert!(refused("nonsense").contains("key=value"));
        let file = Settings::default().with_toml("[surface]\nmax_gap = 3\n");
        assert_eq!(
            file.unwrap_err().0,
            "settings: there is no setting `surface.max_gap`; is `surface.max_gap_m` meant?"
        );
        assert!(
            Settings::default()
                .with_toml("[bottom]\npings = 4\n")
                .is_ok()
        );
    }

    #[test]
    fn slips_are_counted_in_letters() {
        assert_eq!(slips("draft_m", "draft_m"), 0);
        assert_eq!(slips("draft_m", "draugth_m"), 3);
        assert_eq!(slips("", "abc"), 3);
    }
}
