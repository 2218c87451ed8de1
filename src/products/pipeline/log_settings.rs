//! Settings of several logs: the shared ones, and those of a single log.
//!
//! A log's settings are the shared ones with its own values in place of some
//! ([`LogSettings::compose`]); the pipeline uses the result like the settings of a single log. Keys
//! are those of `--set`: `draft_m`, `first_return.threshold`.

use super::settings::{
    ControlValue, SettingRow, SettingScope, flattened, in_one_line, insert, renamed, row,
};
use super::{Settings, SettingsError};
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_log::survey::{Gauge, Identity, Survey, WaterArea};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::sync::Arc;
use toml::{Table, Value};

/// Settings by their dotted keys.
pub type SettingValues = BTreeMap<String, Value>;

/// Key of the log to which excluded stretches belong.
const EXCLUDED_LOG: &str = "excluded.log";

/// Deserializes values written by any version; keys are converted to those of this version.
///
/// # Errors
/// When the input is not a table of values.
pub(crate) fn deserialize_values<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<SettingValues, D::Error> {
    let values = SettingValues::deserialize(from)?.into_iter();
    let current = |(key, value): (String, Value)| match renamed(&key) {
        Some(now) => (now.to_owned(), value),
        None => (key, value),
    };
    Ok(values.map(current).collect())
}

/// Returns true if a change of this key is stored with a single log, not with the settings that all
/// logs share; see [`SettingScope`].
pub(crate) fn is_of_one_log(key: &str) -> bool {
    row(key).is_some_and(|row| row.scope != SettingScope::Survey)
}

/// Returns all settings that have a value, by their keys, without the bottom edits.
pub fn setting_values(settings: &Settings) -> SettingValues {
    let table = table_of(settings);
    let values = flattened(&table).into_iter();
    values.map(|(key, value)| (key, shortest(value))).collect()
}

/// Returns the settings as a table. They are numbers, names and paths, which a table can hold; in a
/// path that is not Unicode, the invalid parts are replaced.
fn table_of(settings: &Settings) -> Table {
    let mut settings = settings.clone();
    let paths = [
        &mut settings.detector.model,
        &mut settings.isobaths.clip,
        &mut settings.track.file,
        &mut settings.water_level.file,
    ];
    for path in paths.into_iter().flatten() {
        *path = path.to_string_lossy().into_owned().into();
    }
    Table::try_from(settings).unwrap_or_default()
}

/// Returns a number with as few digits as it was given: a setting of 32 bits is `0.41`, not the
/// nearest value in 64 bits with all its digits.
fn shortest(value: &Value) -> Value {
    match value {
        Value::Float(number) if number.is_finite() && f64::from(*number as f32) == *number => {
            let text = (*number as f32).to_string();
            Value::Float(text.parse().unwrap_or(*number))
        }
        other => other.clone(),
    }
}

/// Returns the settings with the given values in place of theirs. Content loaded from a file is
/// kept if the path of the file is unchanged.
///
/// # Errors
/// A sentence that names the key, when the key does not exist or cannot have that value.
fn with_values(settings: &Settings, values: &SettingValues) -> Result<Settings, SettingsError> {
    if values.is_empty() {
        return Ok(settings.clone());
    }
    let mut table = table_of(settings);
    for (key, value) in values {
        insert(&mut table, key, value.clone());
    }
    let mut made: Settings = table
        .try_into()
        .map_err(|error: toml::de::Error| SettingsError(in_one_line(&error.to_string())))?;
    if made.water_level.file == settings.water_level.file {
        made.water_level.gauge = settings.water_level.gauge.clone();
    }
    if made.isobaths.clip == settings.isobaths.clip {
        made.isobaths.area = settings.isobaths.area.clone();
    }
    Ok(made)
}

/// Settings of one log only.
#[derive(Clone, Debug, Default)]
pub struct LogSettings {
    own: SettingValues,
    /// Bottom edits of this log.
    pub bottom: BottomSettings,
    /// Content of the log's own `water_level.file`, once it has been read. Not compared by `==`,
    /// since it follows from the key.
    pub gauge: Option<Arc<Gauge>>,
    /// Content of the log's own `isobaths.clip`, once it has been read; not compared by `==`
    /// either.
    pub area: Option<Arc<WaterArea>>,
}

impl PartialEq for LogSettings {
    fn eq(&self, other: &Self) -> bool {
        self.own == other.own && self.bottom == other.bottom
    }
}

impl LogSettings {
    /// Returns the log's own values, by key.
    pub fn own(&self) -> &SettingValues {
        &self.own
    }

    /// Returns true if the log has its own value of a setting.
    pub fn is_own(&self, key: &str) -> bool {
        self.own.contains_key(key)
    }

    /// Returns true if port and starboard of the log are exchanged: the log's own
    /// `mounting.swap_sides`, or the shared one.
    pub(crate) fn swaps_sides(&self, shared: &Settings) -> bool {
        let own = self.own.get("mounting.swap_sides").and_then(Value::as_bool);
        own.unwrap_or(shared.mounting.swap_sides)
    }

    /// Sets the log's own value of a setting.
    pub fn set(&mut self, key: &str, value: Value) {
        self.own.insert(key.to_owned(), value);
    }

    /// Removes the log's own value of a setting, so that the shared one applies.
    pub fn unset(&mut self, key: &str) {
        self.own.remove(key);
    }

    /// Returns the settings with which the log is processed: the shared ones with the log's own
    /// values in place of some. They include the log's own gauge and area if [`LogSettings::gauge`]
    /// and [`LogSettings::area`] are set; otherwise [`Settings::load_files`] reads them.
    ///
    /// # Errors
    /// A sentence that names the key, when one of the log's own values cannot be used.
    pub fn compose(&self, shared: &Settings) -> Result<Settings, SettingsError> {
        let mut settings = with_values(shared, &self.own)?;
        if self.is_own("water_level.file") {
            settings.water_level.gauge = self.gauge.clone();
        }
        if self.is_own("isobaths.clip") {
            settings.isobaths.area = self.area.clone();
        }
        settings.bottom = self.bottom.clone();
        Ok(settings)
    }

    /// Returns these settings with the content of the log's own files, taken from composed settings
    /// that were loaded ([`Settings::load_files`]): settings composed again then include the
    /// content.
    #[must_use]
    pub fn with_files_of(self, loaded: &Settings) -> Self {
        Self { gauge: loaded.water_level.gauge.clone(), area: loaded.isobaths.area.clone(), ..self }
    }

    /// Returns the shared settings and this log's own after the log's composed settings became
    /// `after`: a change of a key that belongs to one log, or that the log had as its own, is
    /// stored with the log; every other change is made in the shared settings.
    ///
    /// # Errors
    /// As [`LogSettings::compose`].
    pub fn change(
        &self,
        shared: &Settings,
        after: &Settings,
    ) -> Result<(Settings, LogSettings), SettingsError> {
        let (before, now) = (setting_values(&self.compose(shared)?), setting_values(after));
        let mut own = self.clone();
        let mut all = setting_values(shared);
        let keys = before.keys().chain(now.keys());
        for key in keys.filter(|key| before.get(*key) != now.get(*key)) {
            let stays = is_of_one_log(key) || self.is_own(key);
            let values = if stays { &mut own.own } else { &mut all };
            match now.get(key) {
                Some(value) => values.insert(key.clone(), value.clone()),
                None => values.remove(key),
            };
        }
        own.bottom = after.bottom.clone();
        let own = own.with_files_of(after);
        let mut changed = from_values(&all)?;
        if changed.water_level.file == shared.water_level.file {
            changed.water_level.gauge = shared.water_level.gauge.clone();
        }
        changed.isobaths.area = if own.is_own("isobaths.clip") {
            shared.isobaths.area.clone()
        } else {
            after.isobaths.area.clone()
        };
        Ok((changed, own))
    }

    /// Returns the shared settings and this log's own after a control gave a setting another value,
    /// and the log's composed settings became `after`: as [`LogSettings::change`], but without a
    /// comparison of all settings, which a drag would make at each step.
    pub fn set_by_control(
        &self,
        shared: &Settings,
        after: &Settings,
        (row, value): (&SettingRow, ControlValue),
    ) -> (Settings, LogSettings) {
        let (mut own, mut shared) = (self.clone(), shared.clone());
        if row.scope != SettingScope::Survey || self.is_own(row.key) {
            match setting_values(after).remove(row.key) {
                Some(value) => own.set(row.key, value),
                None => own.unset(row.key),
            }
        } else {
            row.set(&mut shared, value);
        }
        own.bottom = after.bottom.clone();
        (shared, own)
    }

    /// Returns these settings for the same log after more of it was written: bottom edits and
    /// excluded stretches still apply to the log. `None` if nothing has to be changed.
    pub fn carried_to(&self, survey: &Survey) -> Option<LogSettings> {
        let own = Identity::of(survey);
        let mut carried = self.clone();
        let BottomSettings { log_bytes, pings, .. } = self.bottom;
        if !self.bottom.is_empty() && survey.was(log_bytes, pings) {
            carried.bottom.log_bytes = own.byte_count;
            carried.bottom.pings = own.pings;
        }
        let named = self.own.get(EXCLUDED_LOG).cloned();
        let named = named.and_then(|value| value.try_into::<Identity>().ok());
        if let Some(log) = named.filter(|log| survey.is_or_was(log))
            && let Ok(value) = Value::try_from(Identity { file: log.file, ..own })
        {
            carried.own.insert(EXCLUDED_LOG.to_owned(), value);
        }
        (carried != *self).then_some(carried)
    }

    /// Returns the settings after a key became the log's own, with the shared value, or after its
    /// own value was removed. `None` if nothing would change, or if the key cannot be shared: a
    /// flat spot, a track and a mounting do not apply to another log.
    pub fn owning(&self, shared: &Settings, key: &str, own: bool) -> Option<LogSettings> {
        let scope = row(key).map(|row| row.scope);
        if own == self.is_own(key) || (!own && scope == Some(SettingScope::OneLog)) {
            return None;
        }
        let mut changed = self.clone();
        if own {
            let value = setting_values(shared).remove(key)?;
            changed.own.insert(key.to_owned(), value);
        } else {
            changed.unset(key)
        }
        Some(changed)
    }
}

/// Returns the settings with exactly these values: an optional key that is missing has no value.
///
/// # Errors
/// A sentence that names the key, when the key does not exist or cannot have that value.
pub(crate) fn from_values(values: &SettingValues) -> Result<Settings, SettingsError> {
    with_values(&Settings::default(), values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::Preset;
    use crate::pipeline::settings::SettingKind;
    use crate::pipeline::settings::rows::ROWS;
    use bathyscope_bottom::first_return::BottomEdit;
    use bathyscope_log::survey::{ExclusionReason, Side, Stretch};

    fn settings(assignments: &[&str]) -> Settings {
        let apply = |settings: Settings, text: &&str| settings.with_assignment(text);
        let made = assignments.iter().try_fold(Settings::default(), apply);
        made.expect("settings")
    }

    #[test]
    fn values_of_an_earlier_version_have_the_keys_of_this_one() {
        #[derive(Deserialize)]
        struct Record(#[serde(deserialize_with = "deserialize_values")] SettingValues);
        let json = r#"{ "draft_m": 0.5, "left_out.min_duration_s": 4.0 }"#;
        let Record(values) = serde_json::from_str(json).unwrap();
        let keys: Vec<&str> = values.keys().map(String::as_str).collect();
        assert_eq!(keys, ["draft_m", "excluded.min_duration_s"]);
        let settings = from_values(&values).unwrap();
        assert_eq!(settings.excluded.min_duration_s, 4.0);
    }

    #[test]
    fn a_change_goes_to_the_log_or_to_all_by_what_it_belongs_to() {
        let shared = Settings::preset(Preset::Recommended);
        let mut own = LogSettings::default();
        own.set("first_return.threshold", Value::Float(0.4));
        let before = own.compose(&shared).expect("settings");
        assert_eq!(before.first_return.threshold, 0.4);
        let mut after = before.clone();
        after.draft_m = 0.25;
        after.first_return.threshold = 0.5;
        after.outliers.min_neighbors = 3;
        after.surface.cell_m = Some(0.5);
        after.bottom.lines.push(BottomEdit {
            side: Side::Port,
            pings: [1, 2],
            corners: Vec::new(),
            accepted: false,
        });
        after.excluded.log = Some(Identity {
            file: "pond.sl2".to_owned(),
            byte_count: 9,
            pings: 5,
            swapped_sides: false,
        });
        after.excluded.stretches.push(Stretch {
            pings: Some([2, 3]),
            time_s: None,
            reason: Some(ExclusionReason::Drawn),
            trusted: false,
        });
        let (all, changed) = own.change(&shared, &after).expect("settings");
        assert_eq!(changed.compose(&all).expect("settings"), after);
        assert!(all.excluded.is_empty() && all.excluded.log.is_none());
        assert_eq!(
            changed.own().keys().collect::<Vec<_>>(),
            ["draft_m", "excluded.log", "excluded.stretches", "first_return.threshold"]
        );
        assert_eq!((all.draft_m, all.outliers.min_neighbors), (0.0, 3));
        assert_eq!(all.surface.cell_m, Some(0.5));
        assert_eq!(all.first_return.threshold, shared.first_return.threshold);
        assert!(all.bottom.is_empty());
        // The optional value is removed again.
        let mut back = after.clone();
        back.surface.cell_m = None;
        let (all, _) = changed.change(&all, &back).expect("settings");
        assert_eq!(all.surface.cell_m, None);
    }

    /// Another value of a setting's control; `None` if it has no control.
    fn other(row: &SettingRow, settings: &Settings) -> Option<ControlValue> {
        match &row.kind {
            SettingKind::Number(number) => {
                let [least, most] = number.range;
                let now = (number.get)(settings).unwrap_or(least);
                let next = [now + number.step, now - number.step];
                let next = next.into_iter().find(|value| (least..=most).contains(value));
                next.map(|next| ControlValue::Number(Some(next)))
            }
            SettingKind::Choice(choice) => {
                let now = (choice.get)(settings);
                let name = choice.names.iter().find(|name| name.value != now);
                name.map(|name| ControlValue::Name(name.value))
            }
            SettingKind::Numbers { .. } | SettingKind::Text(_) => None,
        }
    }

    #[test]
    fn a_control_changes_what_a_comparison_of_all_settings_finds() {
        let mut compared = 0;
        for row in ROWS {
            let mut shared = Settings::default();
            let mut owning = LogSettings::default();
            if let Some(value) = setting_values(&shared).remove(row.key) {
                owning.set(row.key, value);
            }
            for own in [LogSettings::default(), owning] {
                let before = own.compose(&shared).expect("settings");
                let Some(value) = other(row, &before) else {
                    continue;
                };
                let mut after = before.clone();
                row.set(&mut after, value);
                let expected = own.change(&shared, &after).expect("settings");
                let changed = own.set_by_control(&shared, &after, (row, value));
                assert_eq!(changed, expected, "{}", row.key);
                (shared, compared) = (changed.0, compared + 1);
            }
        }
        assert!(compared > ROWS.len(), "{compared}");
    }

    #[test]
    fn a_setting_is_made_a_logs_own_and_left_to_all_again() {
        let shared = settings(&["outliers.min_neighbors=7", "draft_m=0.3"]);
        let none = LogSettings::default();
        let own = none.owning(&shared, "outliers.min_neighbors", true);
        let own = own.expect("a change");
        assert!(own.is_own("outliers.min_neighbors"));
        let changed = settings(&["outliers.min_neighbors=9", "draft_m=0.3"]);
        assert_eq!(own.compose(&changed).expect("settings").outliers.min_neighbors, 7);
        assert_eq!(own.owning(&shared, "outliers.min_neighbors", true), None);
        let back = own.owning(&shared, "outliers.min_neighbors", false);
        assert_eq!(back, Some(none.clone()));
        let mut tracked = none;
        tracked.set("track.offset_s", Value::Float(2.0));
        assert_eq!(tracked.owning(&shared, "track.offset_s", false), None);
    }

    #[test]
    fn an_own_value_that_cannot_be_is_named() {
        let mut own = LogSettings::default();
        own.set("cloud.geometry", Value::String("flat".to_owned()));
        let error = own.compose(&Settings::default()).expect_err("no geometry");
        assert!(error.0.contains("flat"), "{error}");
    }

    #[test]
    fn the_area_of_the_isobaths_comes_along_and_another_content_is_another_setting() {
        let of = |sha256: &str| {
            let mut settings = settings(&["isobaths.clip=shore.kml"]);
            settings.isobaths.area = Some(Arc::new(WaterArea {
                path: "shore.kml".into(),
                sha256: sha256.to_owned(),
                ..WaterArea::default()
            }));
            settings
        };
        let (one, other) = (of("1"), of("2"));
        assert_ne!(one, other);
        let mut own = LogSettings::default();
        own.set("draft_m", Value::Float(0.3));
        assert_eq!(own.compose(&one).unwrap().isobaths.area, one.isobaths.area);
        let mut after = own.compose(&one).unwrap();
        after.isobaths.area = other.isobaths.area.clone();
        let (shared, own) = own.change(&one, &after).unwrap();
        assert_eq!(shared.isobaths.area, other.isobaths.area);
        after.isobaths.clip = None;
        after.isobaths.area = None;
        let (shared, _) = own.change(&shared, &after).unwrap();
        assert_eq!((shared.isobaths.clip, shared.isobaths.area), (None, None));
    }
}
