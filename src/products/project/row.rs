//! Defines the lines of a project: keys in a fixed order, values on one line.

use super::ProjectError;
use crate::pipeline::settings::in_one_line;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Write as _};
use toml::Value;

/// Most parts of a key that is read.
const MOST_PARTS: usize = 16;
/// Most levels of tables and lists in one another.
const DEEPEST: usize = 16;

/// Full key of a line: `log.pond-3f9a2c41.box.17`. Lines are in the file in the order of their
/// keys, by section, numbers by their value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    parts: Vec<String>,
    /// Number of parts in the heading of the section.
    section: usize,
}

/// Value of a line, as text on one line, and the line where it was read.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Value as TOML.
    pub text: String,
    /// Line of the file, from 1; 0 if it was not read from the file.
    pub line: usize,
}

/// Two rows are equal if their values are, in any line.
impl PartialEq for Row {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

/// Lines of a project by their keys.
pub(super) type Rows = BTreeMap<Key, Row>;

impl Row {
    /// Creates a row that was not read from a file.
    pub(super) fn new(value: &Value) -> Self {
        Self { text: one_line(value), line: 0 }
    }

    /// Parses the value.
    ///
    /// # Errors
    /// When the text is not a value.
    pub(super) fn value(&self) -> Result<Value, ProjectError> {
        parse_value(&self.text).map_err(|what| self.wrong(what))
    }

    /// Returns the error that the line breaks a rule.
    pub(super) fn wrong(&self, what: impl Display) -> ProjectError {
        ProjectError::line(self.line, what)
    }
}

impl Key {
    /// Creates a key of these parts, with the name of an earlier version replaced by the present
    /// one: files, journals and histories are read with it.
    pub fn new<T: Into<String>>(parts: impl IntoIterator<Item = T>) -> Self {
        let mut parts: Vec<String> = parts.into_iter().map(Into::into).collect();
        let group = match parts.first().map(String::as_str) {
            Some("settings") => 1,
            Some("log") if parts.get(2).is_some_and(|part| part == "settings") => 3,
            Some("log") => 2,
            _ => usize::MAX,
        };
        if let Some(group) = parts.get_mut(group).filter(|group| *group == "left_out") {
            "excluded".clone_into(group);
        }
        let most = if parts.first().is_some_and(|first| first == "log") { 3 } else { 1 };
        let section = parts.len().saturating_sub(1).min(most);
        Self { parts, section }
    }

    /// Returns all parts of the key.
    pub fn parts(&self) -> Vec<&str> {
        self.parts.iter().map(String::as_str).collect()
    }

    /// Returns the heading of the key's section, without brackets; empty for keys before the first
    /// heading.
    pub fn section(&self) -> String {
        joined(&self.parts[..self.section])
    }

    /// Returns the part of the key before the `=`.
    pub fn name(&self) -> String {
        joined(&self.parts[self.section..])
    }

    /// Parses a dotted key; `None` if it is not valid.
    pub fn parse(text: &str) -> Option<Vec<String>> {
        let mut parts = Vec::new();
        let mut rest = text.trim();
        loop {
            let (part, after) = if rest.starts_with('"') { quoted(rest)? } else { bare(rest)? };
            parts.push(part);
            rest = after.trim_start();
            match rest.strip_prefix('.') {
                Some(next) if parts.len() < MOST_PARTS => rest = next.trim_start(),
                None if rest.is_empty() => return Some(parts),
                _ => return None,
            }
        }
    }
}

fn is_bare(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || letter == '_' || letter == '-'
}

fn bare(text: &str) -> Option<(String, &str)> {
    let end = text.find(|letter| !is_bare(letter)).unwrap_or(text.len());
    (end > 0).then(|| (text[..end].to_owned(), &text[end..]))
}

fn quoted(text: &str) -> Option<(String, &str)> {
    let end = closing_quote(text)?;
    let Ok(Value::String(part)) = parse_value(&text[..=end]) else {
        return None;
    };
    Some((part, &text[end + 1..]))
}

/// Returns the position of the closing quote of the string with which a text begins.
fn closing_quote(text: &str) -> Option<usize> {
    let mut is_escaped = false;
    for (at, letter) in text.char_indices().skip(1) {
        match letter {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '"' => return Some(at),
            _ => {}
        }
    }
    None
}

/// Splits a line at the `=` after its key.
pub(super) fn split(line: &str) -> Option<(Vec<String>, &str)> {
    let mut from = 0;
    // A quoted part of the key may contain `=`, too.
    while let Some(at) = line[from..].find(['=', '"']).map(|at| at + from) {
        if line[at..].starts_with('=') {
            return Some((Key::parse(&line[..at])?, line[at + 1..].trim()));
        }
        from = at + closing_quote(&line[at..])? + 1;
    }
    None
}

fn joined(parts: &[String]) -> String {
    let shown = parts.iter().map(|part| {
        let is_plain = !part.is_empty() && part.chars().all(is_bare);
        if is_plain { part.clone() } else { one_line(&Value::String(part.clone())) }
    });
    shown.collect::<Vec<_>>().join(".")
}

impl Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&joined(&self.parts))
    }
}

impl Ord for Key {
    fn cmp(&self, other: &Self) -> Ordering {
        let (section, name) = self.parts.split_at(self.section);
        let (other_section, other_name) = other.parts.split_at(other.section);
        let place = |section: &[String]| match section.first().map(String::as_str) {
            None => 0,
            Some("settings") => 1,
            Some("plane") => 2,
            Some("file") => 3,
            Some("log") => 4,
            Some("measure") => 5,
            Some("view") => 6,
            Some(_) => 7,
        };
        (place(section).cmp(&place(other_section)))
            .then_with(|| by_parts(section, other_section))
            .then_with(|| by_parts(name, other_name))
    }
}

impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

fn by_parts(one: &[String], other: &[String]) -> Ordering {
    let parts = one.iter().zip(other);
    let first = parts.map(|(one, other)| by_part(one, other));
    let first = first.into_iter().find(|order| *order != Ordering::Equal);
    first.unwrap_or_else(|| one.len().cmp(&other.len()))
}

/// Orders parts: numbers by their value, before words.
fn by_part(one: &str, other: &str) -> Ordering {
    let number = |text: &str| {
        let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        is_number.then(|| text.parse::<u64>().ok()).flatten()
    };
    match (number(one), number(other)) {
        (Some(one_number), Some(number)) => one_number.cmp(&number).then_with(|| one.cmp(other)),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => one.cmp(other),
    }
}

/// Parses a value that is on one line.
///
/// # Errors
/// When the text is not TOML, or has too many levels.
pub(super) fn parse_value(text: &str) -> Result<Value, String> {
    // The parser of TOML is recursive.
    let opened = text.bytes().scan(0_usize, |depth, byte| {
        match byte {
            b'[' | b'{' => *depth += 1,
            b']' | b'}' => *depth = depth.saturating_sub(1),
            _ => {}
        }
        Some(*depth)
    });
    if opened.max().unwrap_or(0) > DEEPEST {
        return Err("it holds lists within lists".to_owned());
    }
    text.parse().map_err(|error: toml::de::Error| in_one_line(error.message()))
}

/// Returns a value as TOML on one line; equal values give equal texts.
pub(super) fn one_line(value: &Value) -> String {
    let mut text = String::new();
    write_value(&mut text, value);
    text
}

fn write_value(text: &mut String, value: &Value) {
    match value {
        Value::String(string) => write_string(text, string),
        Value::Float(number) if number.is_nan() => text.push_str("nan"),
        // Writing to a string cannot fail.
        Value::Float(number) => write!(text, "{number:?}").unwrap_or_default(),
        Value::Integer(number) => write!(text, "{number}").unwrap_or_default(),
        Value::Boolean(is_true) => write!(text, "{is_true}").unwrap_or_default(),
        Value::Datetime(time) => write!(text, "{time}").unwrap_or_default(),
        Value::Array(values) => {
            text.push('[');
            for (index, value) in values.iter().enumerate() {
                text.push_str(if index > 0 { ", " } else { "" });
                write_value(text, value);
            }
            text.push(']');
        }
        Value::Table(table) => {
            text.push('{');
            for (index, (key, value)) in table.iter().enumerate() {
                text.push_str(if index > 0 { ", " } else { " " });
                text.push_str(&joined(std::slice::from_ref(key)));
                text.push_str(" = ");
                write_value(text, value);
            }
            text.push_str(if table.is_empty() { "}" } else { " }" });
        }
    }
}

fn write_string(text: &mut String, string: &str) {
    text.push('"');
    for letter in string.chars() {
        match letter {
            '"' => text.push_str("\\\""),
            '\\' => text.push_str("\\\\"),
            '\n' => text.push_str("\\n"),
            '\t' => text.push_str("\\t"),
            // Characters that end a line for some programs, or change the direction of writing, are
            // escaped, so that the value is one line for every reader.
            letter if letter.is_control() || is_hidden(letter) => {
                write!(text, "\\u{:04X}", u32::from(letter)).unwrap_or_default();
            }
            letter => text.push(letter),
        }
    }
    text.push('"');
}

fn is_hidden(letter: char) -> bool {
    matches!(letter, '\u{2028}' | '\u{2029}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn keys_lie_in_the_order_of_the_file() {
        let texts = [
            "bathyscope",
            "zebra",
            "settings.cloud.alpha2_deg",
            "settings.draft_m",
            "file.base_map",
            "log.a.file",
            "log.a.order",
            "log.a.box.2",
            "log.a.box.10",
            "log.a.box.new",
            "log.a.settings.draft_m",
            "log.b.file",
            "measure.1",
            "view.map",
            "camera.x",
        ];
        let keys = texts.map(|text| Key::new(Key::parse(text).expect("a key")));
        assert!(keys.windows(2).all(|pair| pair[0] < pair[1]), "{keys:?}");
        let sections = keys.each_ref().map(Key::section);
        assert_eq!(sections[2], "settings");
        assert_eq!(keys[2].name(), "cloud.alpha2_deg");
        assert_eq!([&sections[5], &sections[7]], ["log.a", "log.a.box"]);
    }

    #[test]
    fn a_group_of_an_earlier_version_has_its_present_name() {
        for (then, now) in [
            ("log.a.left_out.pings.30", "log.a.excluded.pings.30"),
            ("log.a.settings.left_out.log", "log.a.settings.excluded.log"),
            ("settings.left_out.log", "settings.excluded.log"),
            ("log.left_out.file", "log.left_out.file"),
        ] {
            let key = Key::new(Key::parse(then).expect("a key"));
            assert_eq!(key.to_string(), now);
        }
    }

    #[test]
    fn odd_keys_are_refused_and_quoted_ones_are_read() {
        for text in ["", ".", "a.", "a b", "\"a", "a=b", "a\u{e9}"] {
            assert_eq!(Key::parse(text), None, "{text}");
        }
        assert_eq!(Key::parse(&["a"; 17].join(".")), None);
        let (key, value) = split("\"a = \\\" b\".c = \"x = y\"").expect("a line");
        assert_eq!((key, value), (vec!["a = \" b".to_owned(), "c".to_owned()], "\"x = y\""));
        assert_eq!(split("\"a"), None);
        assert_eq!(split("a b"), None);
        assert!(parse_value(&"[".repeat(100_000)).is_err());
    }

    fn any_value() -> impl Strategy<Value = Value> {
        let leaf = prop_oneof![
            any::<String>().prop_map(Value::String),
            any::<i64>().prop_map(Value::Integer),
            any::<f64>().prop_map(Value::Float),
            any::<bool>().prop_map(Value::Boolean),
        ];
        leaf.prop_recursive(3, 24, 4, |inner| {
            prop_oneof![
                prop::collection::vec(inner.clone(), 0..4).prop_map(Value::Array),
                prop::collection::btree_map(any::<String>(), inner, 0..4)
                    .prop_map(|table| Value::Table(table.into_iter().collect())),
            ]
        })
    }

    proptest! {
        #[test]
        fn any_value_is_one_line_and_comes_back(value in any_value()) {
            let text = one_line(&value);
            prop_assert!(!text.contains(['\n', '\r']));
            let read = parse_value(&text).expect("a value");
            prop_assert_eq!(one_line(&read), text);
        }

        #[test]
        fn any_key_comes_back(parts in prop::collection::vec(any::<String>(), 1..6)) {
            let key = Key::new(parts.clone());
            let text = key.to_string();
            prop_assert_eq!(Key::parse(&text), Some(parts.clone()));
            let line = format!("{text} = 1");
            prop_assert_eq!(split(&line), Some((parts, "1")));
        }
    }
}
