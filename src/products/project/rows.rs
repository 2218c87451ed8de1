//! Converts a project to lines, and finds the lines that differ between two versions.

use super::log::ProjectLog;
use super::measurement::MeasurementRow;
use super::paths;
use super::row::{Key, Row, Rows, one_line};
use super::{Project, Unknown};
use crate::pipeline::{SettingValues, setting_values};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use toml::{Table, Value};

mod read;

pub(crate) use read::read;

/// Settings that are paths, which are written relative to the project's folder.
const PATH_KEYS: [&str; 4] = ["detector.model", "isobaths.clip", "track.file", "water_level.file"];
/// Fields of the row of a box.
const BOX_FIELDS: [&str; 16] = [
    "border_m",
    "class",
    "confidence",
    "edited",
    "far_m",
    "id",
    "model",
    "name",
    "near_m",
    "note",
    "object",
    "pings",
    "point",
    "score",
    "side",
    "state",
];
/// Fields of the row of a stretch of the bottom.
const BOTTOM_FIELDS: [&str; 3] = ["accepted", "corners", "last"];
/// Keys of the settings with the excluded stretches of a log, and with the log to which they
/// belong.
const EXCLUDED: &str = "excluded.stretches";
const EXCLUDED_LOG: &str = "excluded.log";
/// Units in which a stretch can be given.
const EXCLUDED_UNITS: [&str; 2] = ["pings", "time_s"];
/// Fields of the row of an excluded stretch.
const EXCLUDED_FIELDS: [&str; 2] = ["last", "reason"];
/// Fields of the row of a stretch that a model has searched.
const SEARCHED_FIELDS: [&str; 2] = ["end", "model"];

/// Returns all lines of a project in a folder.
pub(super) fn of(project: &Project, folder: &Path) -> Rows {
    differing(project, None, folder)
}

/// Returns the changes in the lines of a project from one version to another: rows that are new or
/// changed, and the keys of the removed ones. Parts that the versions share are not examined.
pub(super) fn changes(before: &Project, after: &Project, folder: &Path) -> (Rows, Vec<Key>) {
    let old = differing(before, Some(after), folder);
    let mut new = differing(after, Some(before), folder);
    let gone = old.keys().filter(|key| !new.contains_key(key)).cloned();
    let gone = gone.collect();
    new.retain(|key, row| old.get(key) != Some(row));
    (new, gone)
}

/// Returns the lines of those parts of a project that differ from `other`; of all parts without
/// `other`.
fn differing(project: &Project, other: Option<&Project>, folder: &Path) -> Rows {
    let mut rows = Rows::new();
    let mut put = |key: Key, value: &Value| {
        rows.insert(key, Row::new(value));
    };
    if other.is_none_or(|other| other.settings != project.settings) {
        let values = setting_values(&project.settings);
        put_settings(&mut put, &["settings"], &values, folder);
    }
    if let Some(origin) = project.origin
        && other.is_none_or(|other| other.origin != project.origin)
    {
        put(Key::new(["plane", "origin"]), &value_of(&[origin.lon_deg, origin.lat_deg]));
    }
    if other.is_none_or(|other| other.files != project.files) {
        for (name, path) in &project.files {
            let text = paths::to_text(path, folder);
            put(Key::new(["file", name]), &Value::String(text));
        }
    }
    for log in &project.logs {
        let same = other.and_then(|other| other.log(&log.key));
        if same.is_none_or(|same| !Arc::ptr_eq(same, log)) {
            put_log(&mut put, log, same.map(AsRef::as_ref), folder);
        }
    }
    if other.is_none_or(|other| other.measurements != project.measurements) {
        for (number, measurement) in &project.measurements {
            let row = value_of(&MeasurementRow::of(measurement));
            put(Key::new(["measure", &number.to_string()]), &row);
        }
    }
    if other.is_none_or(|other| other.views != project.views) {
        for (name, value) in &project.views {
            put(Key::new(["view", name]), value);
        }
    }
    add_unknown(&mut rows, project, other);
    rows
}

/// Converts a row's fields, which are numbers, texts and lists, whose serialization cannot fail.
fn value_of(row: &impl serde::Serialize) -> Value {
    Value::try_from(row).unwrap_or(Value::Table(Table::new()))
}

fn put_settings(
    put: &mut impl FnMut(Key, &Value),
    section: &[&str],
    values: &SettingValues,
    folder: &Path,
) {
    for (key, value) in values {
        let parts = section.iter().copied().chain(key.split('.'));
        match value {
            Value::String(path) if PATH_KEYS.contains(&key.as_str()) => {
                let text = paths::to_text(Path::new(path), folder);
                put(Key::new(parts), &Value::String(text));
            }
            value => put(Key::new(parts), value),
        }
    }
}

fn put_log(
    put: &mut impl FnMut(Key, &Value),
    log: &ProjectLog,
    same: Option<&ProjectLog>,
    folder: &Path,
) {
    let key = log.key.as_str();
    let whole = |number: u64| Value::Integer(i64::try_from(number).unwrap_or(i64::MAX));
    let mut head = |name: &str, value: Value| put(Key::new(["log", key, name]), &value);
    head("file", Value::String(paths::to_text(&log.file.path, folder)));
    head("sha256", Value::String(log.file.sha256.clone()));
    head("bytes", whole(log.file.byte_count));
    head("pings", whole(log.file.pings as u64));
    head("name", Value::String(log.name.clone()));
    head("order", Value::Float(log.order));
    if let Some([red, green, blue]) = log.colour {
        let text = format!("#{red:02x}{green:02x}{blue:02x}");
        head("colour", Value::String(text));
    }
    if !log.is_visible {
        head("visible", Value::Boolean(false));
    }
    let classes = log.review.classes().iter().cloned();
    head("classes", Value::Array(classes.map(Value::String).collect()));
    let mut own = log.settings.own().clone();
    // The log of the excluded stretches is this one; each stretch has its own line.
    own.remove(EXCLUDED_LOG);
    if let Some(Value::Array(stretches)) = own.remove(EXCLUDED) {
        put_excluded(put, key, &stretches);
    }
    put_settings(put, &["log", key, "settings"], &own, folder);
    if same.is_none_or(|same| same.settings.bottom != log.settings.bottom) {
        for line in &log.settings.bottom.lines {
            let parts = ["log", key, "bottom", line.side.name(), &line.pings[0].to_string()];
            let corners = line.corners.iter();
            let corners = corners.map(|corner| Value::from(corner.to_vec()));
            let what = if line.accepted {
                ("accepted".to_owned(), Value::Boolean(true))
            } else {
                ("corners".to_owned(), Value::Array(corners.collect()))
            };
            let row = Table::from_iter([("last".to_owned(), whole(line.pings[1] as u64)), what]);
            put(Key::new(parts), &Value::Table(row));
        }
    }
    put_review(put, log, same);
}

/// Adds the excluded stretches, with keys of their unit and start; stretches with the same start
/// are numbered.
fn put_excluded(put: &mut impl FnMut(Key, &Value), log: &str, stretches: &[Value]) {
    let mut key_counts: BTreeMap<String, u32> = BTreeMap::new();
    for stretch in stretches.iter().filter_map(Value::as_table) {
        for unit in EXCLUDED_UNITS {
            let Some([first, last]) = stretch.get(unit).and_then(ends) else {
                continue;
            };
            let mut row = stretch.clone();
            row.remove(unit);
            row.insert("last".to_owned(), last.clone());
            let first = one_line(first);
            let count = key_counts.entry(format!("{unit} {first}")).or_default();
            *count += 1;
            let name = match *count {
                1 => first,
                count => format!("{first} {count}"),
            };
            let key = Key::new(["log", log, "excluded", unit, &name]);
            put(key, &Value::Table(row));
        }
    }
}

fn ends(span: &Value) -> Option<&[Value; 2]> {
    span.as_array()?.as_slice().try_into().ok()
}

fn put_review(put: &mut impl FnMut(Key, &Value), of: &ProjectLog, same: Option<&ProjectLog>) {
    let (log, review) = (of.key.as_str(), &of.review);
    for search in review.searched() {
        let row = Table::from_iter([
            ("end".to_owned(), Value::Integer(search.pings.end as i64)),
            ("model".to_owned(), Value::String(search.model.to_string())),
        ]);
        let parts = ["log", log, "searched", &search.pings.start.to_string()];
        put(Key::new(parts), &Value::Table(row));
    }
    // A class is written by its name, so with other classes every box may be written differently.
    let same = same.filter(|same| same.review.classes() == review.classes());
    for review_box in review.shared() {
        let object = of.object_numbers.get(&review_box.id);
        let is_same = same.is_some_and(|same| {
            let boxes = same.review.shared();
            let found = boxes.binary_search_by_key(&review_box.id, |known| known.id);
            found.is_ok_and(|index| Arc::ptr_eq(&boxes[index], review_box))
                && same.object_numbers.get(&review_box.id) == object
        });
        if is_same {
            continue;
        }
        let mut value = value_of(&review.row(review_box));
        if let Value::Table(fields) = &mut value {
            fields.remove("id");
            if let Some(number) = object {
                fields.insert("object".to_owned(), Value::Integer((*number).into()));
            }
            if let Some(score) = review_box.score {
                // The shortest number with the same value: converted to 64 bits, 0.91 would be
                // 0.9100000262260437.
                let shortest = score.to_string().parse().unwrap_or(f64::from(score));
                fields.insert("score".to_owned(), Value::Float(shortest));
            }
        }
        put(Key::new(["log", log, "box", &review_box.id.0.to_string()]), &value);
    }
}

/// Adds the content that this version does not know: whole lines, unless their log was removed, and
/// fields of known lines.
fn add_unknown(rows: &mut Rows, project: &Project, other: Option<&Project>) {
    let Unknown { rows: lines, fields } = &project.unknown;
    let is_there = |key: &Key| match key.parts().as_slice() {
        ["log", log, ..] => project.logs.iter().any(|known| known.key.as_str() == *log),
        _ => true,
    };
    let same = other.is_some_and(|other| {
        other.unknown.rows == *lines && other.logs.len() == project.logs.len()
    });
    if !same {
        for (key, row) in lines.iter().filter(|(key, _)| is_there(key)) {
            rows.entry(key.clone()).or_insert_with(|| row.clone());
        }
    }
    for (key, unknown) in fields {
        let Some(row) = rows.get_mut(key) else {
            continue;
        };
        if let Ok(Value::Table(mut fields)) = row.value() {
            for (name, value) in unknown {
                fields.entry(name).or_insert_with(|| value.clone());
            }
            *row = Row::new(&Value::Table(fields));
        }
    }
}
