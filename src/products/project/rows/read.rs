//! Converts lines to a project, and checks every line.

use super::super::log::{LogFile, LogKey, ProjectLog};
use super::super::measurement::MeasurementRow;
use super::super::row::{Key, Row, Rows, parse_value};
use super::super::{Project, ProjectError, Unknown, paths};
use super::{
    BOTTOM_FIELDS, BOX_FIELDS, EXCLUDED, EXCLUDED_FIELDS, EXCLUDED_LOG, PATH_KEYS, SEARCHED_FIELDS,
    value_of,
};
use crate::pipeline::settings::{self, in_one_line, renamed};
use crate::pipeline::{LogSettings, SettingValues, Settings, from_values};
use bathyscope_bottom::first_return::{BottomEdit, BottomSettings};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::{ExclusionSettings, Identity, Side, Stretch};
use bathyscope_objects::NAMELESS_CLASS;
use bathyscope_objects::review::{BoxId, BoxRow, Review, ReviewRows, SearchRow};
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use toml::{Table, Value};

/// Most logs in a project.
const MOST_LOGS: usize = 10_000;
/// Most letters of a name.
const LONGEST_NAME: usize = 200;
/// Number of digits of a SHA-256.
const SHA256_DIGITS: usize = 64;

/// Line with the rest of its key, after the parts of the section.
type Line = (Vec<String>, Row);

/// State of the reading so far.
struct RowReading<'a> {
    folder: &'a Path,
    unknown: Unknown,
}

/// Lines of one log.
#[derive(Default)]
struct LogLines {
    /// First line of the log, for errors about the whole log.
    line: usize,
    head: BTreeMap<String, Row>,
    settings: Vec<Line>,
    bottom: Vec<Line>,
    excluded: Vec<Line>,
    searched: Vec<Line>,
    boxes: Vec<Line>,
}

/// Creates the project of these lines in a folder.
///
/// # Errors
/// A sentence that names the line that is not valid.
pub(crate) fn read(rows: Rows, folder: &Path) -> Result<Project, ProjectError> {
    let mut reading = RowReading { folder, unknown: Unknown::default() };
    let mut project = Project::default();
    let mut settings = Vec::new();
    let mut logs: BTreeMap<String, LogLines> = BTreeMap::new();
    for (key, row) in rows {
        let parts = key.parts();
        let rest = |from: usize| parts[from..].iter().map(|part| (*part).to_owned()).collect();
        match parts.as_slice() {
            ["settings", ..] if parts.len() > 1 => settings.push((rest(1), row)),
            ["plane", "origin"] => {
                let [lon_deg, lat_deg] = as_is(&row)?;
                let origin = LonLat { lon_deg, lat_deg };
                if !origin.is_on_earth() {
                    let what = "the origin is no longitude and latitude in degrees";
                    return Err(row.wrong(what));
                }
                project.origin = Some(origin);
            }
            ["file", name] => {
                let path = paths::from_text(&as_is::<String>(&row)?, folder);
                project.files.insert((*name).to_owned(), path);
            }
            ["log", log, section @ ..] if !section.is_empty() => {
                let lines = logs.entry((*log).to_owned()).or_default();
                if !lines.take(section, rest(3.min(parts.len())), &row) {
                    reading.unknown.rows.insert(key, row);
                }
            }
            ["measure", number] if is_number(number) => {
                let number = number.parse().unwrap_or_default();
                let known: MeasurementRow = reading.fields(&key, &row, &MeasurementRow::FIELDS)?;
                let read = known.read().map_err(|what| row.wrong(what))?;
                project.measurements.insert(number, read);
            }
            ["view", name] => {
                project.views.insert((*name).to_owned(), row.value()?);
            }
            _ => {
                reading.unknown.rows.insert(key, row);
            }
        }
    }
    let values = reading.values("settings", &settings);
    project.settings = from_values(&values).map_err(|error| at(&settings, &error.0))?;
    (project.settings.check()).map_err(|error| at(&settings, &error.0))?;
    if logs.len() > MOST_LOGS {
        let line = logs.values().map(|log| log.line).max().unwrap_or(0);
        return Err(ProjectError::line(
            line,
            format!("a project of more than {MOST_LOGS} logs is not read"),
        ));
    }
    for (key, lines) in logs {
        let log = reading.log(&key, lines, &project.settings)?;
        project.logs.push(Arc::new(log));
    }
    project.put_in_order();
    project.unknown = reading.unknown;
    Ok(project)
}

impl LogLines {
    /// Adds a line; returns false if this version does not know the line.
    fn take(&mut self, section: &[&str], rest: Vec<String>, row: &Row) -> bool {
        self.line = match self.line {
            0 => row.line,
            line => line.min(row.line),
        };
        let lines = match section {
            [
                "file" | "sha256" | "bytes" | "pings" | "name" | "order" | "colour" | "visible"
                | "classes",
            ] => {
                self.head.insert(section[0].to_owned(), row.clone());
                return true;
            }
            ["settings", _, ..] => &mut self.settings,
            ["bottom", "port" | "starboard", ping] if is_number(ping) => &mut self.bottom,
            ["excluded", "pings" | "time_s", _] => &mut self.excluded,
            ["searched", ping] if is_number(ping) => &mut self.searched,
            ["box", number] if is_number(number) => &mut self.boxes,
            _ => return false,
        };
        lines.push((rest, row.clone()));
        true
    }

    fn optional<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, ProjectError> {
        self.head.get(name).map(as_is).transpose()
    }

    fn required<T: DeserializeOwned>(&self, key: &str, name: &str) -> Result<T, ProjectError> {
        let missing = || ProjectError::line(self.line, format!("the log `{key}` has no `{name}`"));
        self.optional(name)?.ok_or_else(missing)
    }

    /// Returns the error that a line of the head breaks a rule.
    fn wrong(&self, name: &str, what: &str) -> ProjectError {
        let line = self.head.get(name).map_or(self.line, |row| row.line);
        ProjectError::line(line, format!("`{name}` {what}"))
    }
}

impl RowReading<'_> {
    /// Reads the known fields of a line, and keeps the others as unknown.
    fn fields<T: DeserializeOwned>(
        &mut self,
        key: &Key,
        row: &Row,
        known: &[&str],
    ) -> Result<T, ProjectError> {
        let mut fields: Table = as_is(row)?;
        let unknown = fields.keys().filter(|field| !known.contains(&field.as_str()));
        for name in unknown.cloned().collect::<Vec<_>>() {
            if let Some(value) = fields.remove(&name) {
                let kept = self.unknown.fields.entry(key.clone()).or_default();
                kept.insert(name, value);
            }
        }
        into(Value::Table(fields), row.line)
    }

    /// Returns the settings in the lines; lines that this version does not know are kept as
    /// unknown.
    fn values(&mut self, section: &str, lines: &[Line]) -> SettingValues {
        let mut values = SettingValues::new();
        for (parts, row) in lines {
            let mut key = parts.join(".");
            if let Some(now) = renamed(&key) {
                now.clone_into(&mut key);
            }
            match row.value() {
                Ok(Value::String(path)) if PATH_KEYS.contains(&key.as_str()) => {
                    let path = paths::from_text(&path, self.folder);
                    let text = path.to_string_lossy().into_owned();
                    values.insert(key, Value::String(text));
                }
                Ok(value) if settings::row(&key).is_some() => {
                    values.insert(key, value);
                }
                _ => {
                    let section = Key::parse(section).unwrap_or_default();
                    let whole = Key::new(section.into_iter().chain(parts.clone()));
                    self.unknown.rows.insert(whole, row.clone());
                }
            }
        }
        values
    }

    fn log(
        &mut self,
        key: &str,
        lines: LogLines,
        shared: &Settings,
    ) -> Result<ProjectLog, ProjectError> {
        let path: String = lines.required(key, "file")?;
        let sha256: String = lines.required(key, "sha256")?;
        if sha256.len() != SHA256_DIGITS || !sha256.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return Err(lines.wrong("sha256", "is 64 hexadecimal digits"));
        }
        let file = LogFile {
            path: paths::from_text(&path, self.folder),
            sha256: sha256.to_ascii_lowercase(),
            byte_count: lines.required(key, "bytes")?,
            pings: lines.required(key, "pings")?,
        };
        let mut log = ProjectLog::new(file);
        log.key = LogKey::from_text(key);
        if let Some(name) = lines.optional::<String>("name")? {
            if name.chars().count() > LONGEST_NAME {
                return Err(lines.wrong("name", "is longer than 200 letters"));
            }
            log.name = name;
        }
        if let Some(text) = lines.optional::<String>("colour")? {
            let wrong = || lines.wrong("colour", "is written \"#d95f02\"");
            log.colour = Some(colour_of(&text).ok_or_else(wrong)?);
        }
        log.is_visible = lines.optional("visible")?.unwrap_or(true);
        log.order = match lines.optional("order")? {
            None => 0.0,
            Some(Value::Integer(order)) => order as f64,
            Some(Value::Float(order)) if order.is_finite() => order,
            Some(_) => return Err(lines.wrong("order", "is a number")),
        };
        log.settings = self.log_settings(key, &lines, &log, shared)?;
        // The sides of boxes in a project are those with the mounting stored in it.
        let of =
            Identity { swapped_sides: log.settings.swaps_sides(shared), ..log.file.identity() };
        let (review, numbers) = self.review(key, &lines, &of)?;
        log.review = Arc::new(review);
        log.object_numbers = Arc::new(numbers);
        Ok(log)
    }

    fn log_settings(
        &mut self,
        key: &str,
        lines: &LogLines,
        log: &ProjectLog,
        shared: &Settings,
    ) -> Result<LogSettings, ProjectError> {
        let mut settings = LogSettings::default();
        let section = Key::new(["log", key, "settings", ""]).section();
        for (name, value) in self.values(&section, &lines.settings) {
            settings.set(&name, value);
        }
        let of = Identity { swapped_sides: settings.swaps_sides(shared), ..log.file.identity() };
        settings.bottom = self.bottom(key, &lines.bottom, &of)?;
        let excluded = self.excluded(key, &lines.excluded)?;
        if !excluded.is_empty() {
            settings.set(EXCLUDED, Value::Array(excluded));
            settings.set(EXCLUDED_LOG, value_of(&log.file.identity()));
        }
        let composed = settings.compose(shared).and_then(|composed| composed.check());
        composed.map_err(|error| at(&lines.settings, &error.0))?;
        Ok(settings)
    }

    /// Returns the excluded stretches in the form of the settings.
    fn excluded(&mut self, log: &str, lines: &[Line]) -> Result<Vec<Value>, ProjectError> {
        let mut stretches = Vec::with_capacity(lines.len());
        for (parts, row) in lines {
            let start = ["log", log, "excluded"].map(str::to_owned);
            let key = Key::new(start.into_iter().chain(parts.iter().cloned()));
            let mut fields: Table = self.fields(&key, row, &EXCLUDED_FIELDS)?;
            let [unit, first] = parts.as_slice() else {
                continue;
            };
            // The second of two stretches that begin at 30 has the key `30 2`.
            let first = first.split(' ').next().unwrap_or_default();
            let first = parse_value(first).map_err(|what| row.wrong(what))?;
            let missing = || row.wrong("a stretch that is excluded has no `last`");
            let last = fields.remove("last").ok_or_else(missing)?;
            fields.insert(unit.clone(), Value::Array(vec![first, last]));
            let value = Value::Table(fields);
            // Checked one by one first, so that an error names the line.
            let stretch: Stretch = into(value.clone(), row.line)?;
            let alone =
                ExclusionSettings { stretches: vec![stretch], ..ExclusionSettings::default() };
            alone.check().map_err(|what| row.wrong(what))?;
            stretches.push(value);
        }
        Ok(stretches)
    }

    fn bottom(
        &mut self,
        log_key: &str,
        lines: &[Line],
        of: &Identity,
    ) -> Result<BottomSettings, ProjectError> {
        #[derive(serde::Deserialize)]
        struct Stretch {
            last: usize,
            #[serde(default)]
            corners: Vec<[f64; 2]>,
            #[serde(default)]
            accepted: bool,
        }
        let mut all = BottomSettings {
            log_bytes: of.byte_count,
            pings: of.pings,
            swapped_sides: of.swapped_sides,
            lines: Vec::with_capacity(lines.len()),
        };
        for (parts, row) in lines {
            let [side, first] = parts.as_slice() else {
                continue;
            };
            let key = Key::new(["log", log_key, "bottom", side, first]);
            let Stretch { last, corners, accepted } = self.fields(&key, row, &BOTTOM_FIELDS)?;
            let side = Side::BOTH.into_iter().find(|known| known.name() == side);
            let line = BottomEdit {
                side: side.unwrap_or(Side::Port),
                pings: [first.parse().unwrap_or(usize::MAX), last],
                corners,
                accepted,
            };
            let meets =
                |before: &&BottomEdit| before.side == line.side && before.pings[1] >= line.pings[0];
            if all.lines.last().filter(meets).is_some() {
                let what =
                    "this stretch of the bottom lies over the one before; change one of them";
                return Err(row.wrong(what));
            }
            let alone = BottomSettings { lines: vec![line], ..all };
            alone.check().map_err(|what| row.wrong(what))?;
            all.lines.extend(alone.lines);
        }
        let line = lines.last().map_or(0, |(_, row)| row.line);
        all.check().map_err(|what| ProjectError::line(line, what))?;
        if all.is_empty() { Ok(BottomSettings::default()) } else { Ok(all) }
    }

    fn review(
        &mut self,
        key: &str,
        lines: &LogLines,
        of: &Identity,
    ) -> Result<(Review, BTreeMap<BoxId, u32>), ProjectError> {
        #[derive(serde::Deserialize)]
        struct Stretch {
            model: String,
            end: usize,
        }
        let classes = lines.optional("classes")?;
        let mut rows = ReviewRows {
            classes: classes.unwrap_or_else(|| vec![NAMELESS_CLASS.to_owned()]),
            ..ReviewRows::default()
        };
        for (parts, row) in &lines.searched {
            let key = Key::new(["log", key, "searched", &parts[0]]);
            let Stretch { model, end } = self.fields(&key, row, &SEARCHED_FIELDS)?;
            let pings = [parts[0].parse().unwrap_or(usize::MAX), end];
            rows.searched.push(SearchRow { model, pings });
        }
        let (mut line_of, mut numbers) = (BTreeMap::new(), BTreeMap::new());
        for (parts, row) in &lines.boxes {
            let key = Key::new(["log", key, "box", &parts[0]]);
            let mut fields: Table = self.fields(&key, row, &BOX_FIELDS)?;
            let number: u32 = parts[0].parse().unwrap_or(u32::MAX);
            fields.insert("id".to_owned(), Value::Integer(number.into()));
            if let Some(object) = fields.remove("object") {
                numbers.insert(BoxId(number), into(object, row.line)?);
            }
            let box_row: BoxRow = into(Value::Table(fields), row.line)?;
            line_of.insert(box_row.id, row.line);
            rows.boxes.push(box_row);
        }
        let review = Review::from_rows(rows, of).map_err(|error| {
            let line = error.id.and_then(|id| line_of.get(&id));
            ProjectError::line(*line.unwrap_or(&lines.line), error.to_string())
        })?;
        Ok((review, numbers))
    }
}

/// Returns an error with the number of the line to which a sentence about settings belongs: the
/// first whose key is in the sentence, else the first of which the last part of the key is, else
/// the first line.
fn at(lines: &[Line], what: &str) -> ProjectError {
    let whole = |(parts, _): &&Line| what.contains(&parts.join("."));
    let last = |(parts, _): &&Line| parts.last().is_some_and(|last| what.contains(last.as_str()));
    let named = lines.iter().find(whole).or_else(|| lines.iter().find(last));
    let place = named.or(lines.first());
    ProjectError::line(place.map_or(0, |(_, row)| row.line), what)
}

fn as_is<T: DeserializeOwned>(row: &Row) -> Result<T, ProjectError> {
    into(row.value()?, row.line)
}

fn into<T: DeserializeOwned>(value: Value, line: usize) -> Result<T, ProjectError> {
    value
        .try_into()
        .map_err(|error: toml::de::Error| ProjectError::line(line, in_one_line(error.message())))
}

fn is_number(text: &str) -> bool {
    // Only numbers in the form in which they are written: `07` would be written back as `7`.
    text.parse::<u32>().is_ok_and(|number| number.to_string() == text)
}

fn colour_of(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let part = |from: usize| u8::from_str_radix(&digits[from..from + 2], 16).ok();
    Some([part(0)?, part(2)?, part(4)?])
}
