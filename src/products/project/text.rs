//! Converts lines to the text of a project file and back, whatever their meaning; and converts
//! older projects, one version after the other.

use super::ProjectError;
use super::row::{Key, Row, Rows, one_line, parse_value, split};
use toml::Value;

/// Largest file that is read, bytes.
pub(super) const LONGEST: u64 = 256 << 20;
/// Most lines with a value that are read: a survey of fifty logs has some thousand.
const MOST_ROWS: usize = 2_000_000;
/// Longest line that is read, bytes.
const LONGEST_LINE: usize = 4 << 20;
/// Key of the line that marks the file as a project, whose value is the version of the layout.
const MARK: &str = "bathyscope";

const HEAD: &str = "# A survey of Bathyscope: one line is one decision. `bathyscope manual` tells what the lines mean.\n";
/// Version of the layout that is written.
pub(super) const VERSION: u32 = 1;

/// Function that converts rows of one version to those of the next.
type Step = fn(Rows) -> Rows;

/// Steps from each version to the next, that from 1 to 2 first: one step less than there are
/// versions. The tests contain a file of each version, which must always open.
const STEPS: [Step; VERSION as usize - 1] = [];

/// Returns the text of the file.
pub(super) fn write(rows: &Rows) -> String {
    let mut text = HEAD.to_owned();
    text.push_str(&format!("{MARK} = {VERSION}\n"));
    let mut section = String::new();
    for (key, row) in rows {
        let heading = key.section();
        if heading != section {
            text.push_str(&format!("\n[{heading}]\n"));
            section = heading;
        }
        // A blank line between two decisions: git merges changes of neighbouring lines only if
        // there is an unchanged line between them.
        text.push_str(&format!("\n{} = {}\n", key.name(), row.text));
    }
    text
}

/// Returns a row as one line of a journal, `full.key = value`.
pub(super) fn write_row(key: &Key, row: &Row) -> String {
    format!("{key} = {}", row.text)
}

/// Parses a line that [`write_row`] wrote; `None` if it is not valid.
pub(super) fn read_row(line: &str) -> Option<(Key, Row)> {
    let (parts, value) = split(line)?;
    let value = parse_value(value).ok()?;
    Some((Key::new(parts), Row::new(&value)))
}

/// Returns the rows as written in the file, and their version.
///
/// # Errors
/// When the text is not a valid project, or is of a newer version.
pub(super) fn read_as_written(text: &str) -> Result<(Rows, u32), ProjectError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // Checked first: the other lines of a newer file may not be valid in this version.
    let version = version(text)?;
    if version > VERSION {
        return Err(ProjectError::Newer { version });
    }
    let mut rows = Rows::new();
    let mut section: Vec<String> = Vec::new();
    for (line, number) in text.lines().zip(1..) {
        let line = line.trim();
        let wrong = |what: String| Err(ProjectError::line(number, what));
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        if ["<<<<<<<", "=======", ">>>>>>>", "|||||||"].iter().any(|mark| line.starts_with(mark)) {
            return wrong("two versions were merged and git could not decide here; keep the lines that are right and remove the marks".to_owned());
        }
        if line.len() > LONGEST_LINE {
            return wrong("the line is longer than 4 MiB".to_owned());
        }
        if let Some(heading) = line.strip_prefix('[') {
            let inside = heading.strip_suffix(']').and_then(Key::parse);
            let Some(parts) = inside else {
                return wrong("this is no heading; write [settings] or [log.NAME]".to_owned());
            };
            section = parts;
            continue;
        }
        let Some((parts, value)) = split(line) else {
            return wrong("this is no line of a project; write key = value".to_owned());
        };
        let value = match parse_value(value) {
            Ok(value) => value,
            Err(what) => return wrong(what),
        };
        let key = Key::new(section.iter().cloned().chain(parts));
        if key.to_string() == MARK {
            continue;
        }
        let row = Row { text: one_line(&value), line: number };
        if let Some(first) = rows.get(&key) {
            let first = first.line;
            return wrong(format!("`{key}` stands here and in line {first}; keep one of them"));
        }
        rows.insert(key, row);
        if rows.len() > MOST_ROWS {
            return wrong(format!("a project of more than {MOST_ROWS} lines is not read"));
        }
    }
    Ok((rows, version))
}

/// Returns the version of the layout, which is in the first line that is neither blank nor a
/// comment.
fn version(text: &str) -> Result<u32, ProjectError> {
    let lines = text.lines().zip(1..);
    let mut statements =
        lines.filter(|(line, _)| !line.trim().is_empty() && !line.starts_with('#'));
    let what =
        format!("this is no project of Bathyscope: it does not begin with `{MARK} = {VERSION}`");
    let no_project = |line| ProjectError::line(line, &what);
    let (line, number) = statements.next().ok_or_else(|| no_project(1))?;
    let value = line.split_once('=').filter(|(key, _)| key.trim() == MARK);
    let value = value.and_then(|(_, value)| parse_value(value.trim()).ok());
    match value {
        Some(Value::Integer(version)) if version >= 1 => {
            Ok(u32::try_from(version).unwrap_or(u32::MAX))
        }
        _ => Err(no_project(number)),
    }
}

/// Converts rows of one version to a later version.
pub(super) fn migrate(rows: Rows, from: u32, to: u32) -> Rows {
    through(&STEPS, rows, from, to)
}

fn through(steps: &[Step], rows: Rows, from: u32, to: u32) -> Rows {
    let steps = (from..to).filter_map(|version| steps.get(version as usize - 1));
    steps.fold(rows, |rows, step| step(rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn renamed(rows: Rows, from: &str, to: &str) -> Rows {
        let rename = |(key, row): (Key, Row)| {
            let key = if key.to_string() == from {
                Key::new(Key::parse(to).expect("a key"))
            } else {
                key
            };
            (key, row)
        };
        rows.into_iter().map(rename).collect()
    }

    #[test]
    fn each_version_takes_the_steps_that_it_lacks_in_their_order() {
        let steps: [Step; 2] = [
            |rows| renamed(rows, "settings.a", "settings.b"),
            |rows| renamed(rows, "settings.b", "settings.c"),
        ];
        for (from, to, name, expected) in [
            (1, 3, "a", "c"),
            (1, 2, "a", "b"),
            (2, 3, "b", "c"),
            (3, 3, "a", "a"),
            (2, 3, "a", "a"),
        ] {
            let key = Key::new(["settings", name]);
            let rows = Rows::from([(key, Row::new(&Value::Integer(7)))]);
            let after = through(&steps, rows, from, to);
            let keys: Vec<String> = after.keys().map(Key::to_string).collect();
            assert_eq!(keys, [format!("settings.{expected}")], "{from} to {to}");
        }
    }
}
