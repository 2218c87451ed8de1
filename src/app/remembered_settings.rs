//! Remembers the last settings of each log that is in no project: they belong to that log, and to
//! no other.
//!
//! A new survey starts from the preset. When a log is opened again, its own settings are restored
//! as one undo step.

use super::{Action, App, LogId, OpenLog};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_products::pipeline::{
    SettingValues, Settings, deserialize_values, is_of_one_log, setting_values, settings::row,
    with_values,
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Number of logs whose settings are remembered.
const KEPT: usize = 300;
/// Number of settings that a sentence names; further ones are counted.
const NAMED: usize = 3;
/// Key of the file of another receiver's track, which is read separately.
const TRACK_FILE: &str = "track.file";

/// A log, and those of its settings that differ from the preset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct RememberedLog {
    log: Identity,
    #[serde(deserialize_with = "deserialize_values")]
    values: SettingValues,
}

/// The last settings of each log, beginning with the log that was used last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RememberedSettings(Vec<RememberedLog>);

impl RememberedSettings {
    /// Remembers the settings of a log; a log with the settings of the preset is removed from the
    /// list.
    fn remember(&mut self, survey: &Survey, settings: &Settings) {
        self.0.retain(|remembered| !is_of(remembered, survey));
        let usual = setting_values(&Settings::default());
        let mut values = setting_values(settings);
        values.retain(|key, value| usual.get(key) != Some(value));
        if !values.is_empty() {
            let log = Identity::of(survey);
            self.0.insert(0, RememberedLog { log, values });
            self.0.truncate(KEPT);
        }
    }

    /// Returns the remembered settings of a log.
    fn of(&self, survey: &Survey) -> Option<&SettingValues> {
        let remembered = self.0.iter().find(|remembered| is_of(remembered, survey))?;
        Some(&remembered.values)
    }
}

fn is_of(remembered: &RememberedLog, survey: &Survey) -> bool {
    remembered.log.file == Identity::of(survey).file && survey.is_or_was(&remembered.log)
}

impl App {
    /// Returns the last settings of each log, including the open logs, to be kept between runs.
    pub fn remembered_settings(&self) -> RememberedSettings {
        let mut remembered = self.document.remembered.clone();
        if self.project_path().is_none() {
            // The shown log is the newest.
            let logs = self.logs.others.iter().chain([&self.log]);
            for (survey, settings) in logs.filter_map(to_remember) {
                remembered.remember(&survey, &settings);
            }
        }
        remembered
    }

    /// Sets the remembered settings of logs at the start of the program.
    pub fn use_remembered_settings(&mut self, remembered: RememberedSettings) {
        self.document.remembered = remembered;
    }

    /// Remembers the settings of a log that is being closed.
    pub(super) fn remember_settings(&mut self, id: LogId) {
        if self.project_path().is_none()
            && let Some((survey, settings)) = self.open_log(id).and_then(to_remember)
        {
            self.document.remembered.remember(&survey, &settings);
        }
    }

    /// Restores the last settings of a log that was just opened: all of them if it is the only log,
    /// its own ones if it joins others. Settings that the program was started with stay.
    pub(super) fn take_up_settings(&mut self, id: LogId) {
        let Some(log) = self.open_log(id) else {
            return;
        };
        let survey = log.survey.as_ref();
        let Some(values) = survey.and_then(|survey| self.document.remembered.of(survey)) else {
            return;
        };
        let (usual, start) =
            (setting_values(&Settings::default()), setting_values(&self.document.start));
        let is_first = self.log_count() == 1;
        let mut values = values.clone();
        values
            .retain(|key, _| (is_first || is_of_one_log(key)) && usual.get(key) == start.get(key));
        let names = named(&values);
        let track = values.remove(TRACK_FILE);
        let made = with_values(&log.settings, &values).and_then(|mut settings| {
            settings.load_files()?;
            settings.check()?;
            Ok(settings)
        });
        let name = quoted(&log.name());
        match made {
            Ok(settings) if settings != *log.settings => {
                self.change_of(id, settings, "last settings of the log", false);
                let text = format!("{name} opened with its last settings: {names}");
                self.offer(text, Action::Undo);
            }
            Ok(_) => {}
            Err(error) => {
                let text = format!(
                    "{name} opened with the settings of the preset; its last settings cannot be used: {error}"
                );
                self.warn(text);
            }
        }
        if let Some(track) = track.as_ref().and_then(toml::Value::as_str) {
            let receiver = super::external::Instrument::Receiver;
            self.read_external(id, track.into(), Some(receiver));
        }
    }
}

/// Returns the recording and the settings of a log to remember; `None` for the demo survey, which
/// has no file.
fn to_remember(log: &OpenLog) -> Option<(Arc<Survey>, Arc<Settings>)> {
    let survey = log.as_read.as_ref().or(log.survey.as_ref());
    let survey = survey.filter(|survey| !survey.source.files.is_empty())?;
    Some((survey.clone(), log.settings.clone()))
}

/// Returns the names of some settings for a sentence.
fn named(values: &SettingValues) -> String {
    let name = |key: &String| row(key).map_or(key.clone(), |row| row.name.to_owned());
    let mut names: Vec<String> = values.keys().take(NAMED).map(name).collect();
    if let Some(more) = values.len().checked_sub(NAMED).filter(|more| *more > 0) {
        names.push(format!("{more} more"));
    }
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(file: &str) -> Survey {
        let mut survey = Survey::default();
        survey.source.files = vec![file.into()];
        survey.source.byte_count = 10;
        survey
    }

    #[test]
    fn only_the_log_itself_has_its_settings_again() {
        let mut remembered = RememberedSettings::default();
        let settings = Settings { draft_m: 0.4, ..Settings::default() };
        remembered.remember(&log("a.sl2"), &settings);
        assert!(remembered.of(&log("b.sl2")).is_none());
        let values = remembered.of(&log("a.sl2")).cloned().unwrap_or_default();
        assert_eq!(values.len(), 1);
        assert_eq!(named(&values), "draft");
        remembered.remember(&log("a.sl2"), &Settings::default());
        assert!(remembered.of(&log("a.sl2")).is_none());
    }

    #[test]
    fn what_is_remembered_is_bounded_and_is_read_again() {
        let mut remembered = RememberedSettings::default();
        let mut settings = Settings::default();
        settings.first_return.threshold = 0.41;
        for number in 0..2 * KEPT {
            remembered.remember(&log(&format!("{number}.sl2")), &settings);
        }
        assert_eq!(remembered.0.len(), KEPT);
        let text = serde_json::to_string(&remembered).expect("it can be written");
        let read: RememberedSettings = serde_json::from_str(&text).expect("it can be read");
        assert_eq!(read, remembered);
    }
}
