//! The text of a project file: lines to and from the file, without their meaning; and older
//! projects: what each version changed, step by step.

use super::ProjectError;
use super::row::{Key, Row, Rows, one_line, parse_value, split};
use toml::Value;

/// Bytes of the longest file that is read.
pub(super) const LONGEST: u64 = 256 << 20;
/// Lines with a value that are read at most: a survey of fifty logs has some thousand.
const MOST_ROWS: usize = 2_000_000;
/// Bytes of the longest line that is read.
const LONGEST_LINE: usize = 4 << 20;
/// The line that makes the file a project, with the number of its layout.
const MARK: &str = "bathyscope";

const HEAD: &str = "# A survey of Bathyscope: one line is one decision. `bathyscope manual` tells what the lines mean.\n";
/// The version that is written.
pub(super) const VERSION: u32 = 1;

/// Makes rows of one version those of the next.
type Step = fn(Rows) -> Rows;

/// Steps from each version to the next, that from 1 to 2 first: one step less than there are
/// versions. Each version has a file in the tests that opens for ever.
const STEPS: [Step; VERSION as usize - 1] = [];

/// The file's text.
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
        // A blank line between two decisions: git merges changes of neighbours only with a line
        // between them that nobody changed.
        text.push_str(&format!("\n{} = {}\n", key.name(), row.text));
    }
    text
}

/// One line of a journal, `full.key = value`.
pub(super) fn write_row(key: &Key, row: &Row) -> String {
    format!("{key} = {}", row.text)
}

/// Reads what [`write_row`] wrote.
pub(super) fn read_row(line: &str) -> Option<(Key, Row)> {
    let (parts, value) = split(line)?;
    let value = parse_value(value).ok()?;
    Some((Key::new(parts), Row::new(&value)))
}

/// Reads a file, of this version or an older one, whose rows become those of this version.
///
/// # Errors
/// A sentence with the line that cannot be read, or that a newer program is needed.
pub(super) fn read(text: &str) -> Result<Rows, ProjectError> {
    let (rows, version) = read_as_written(text)?;
    Ok(migrate(rows, version, VERSION))
}

/// The rows as they stand in the file, and the version that they are of.
///
/// # Errors
/// When the text is no project, or one of a newer version.
pub(super) fn read_as_written(text: &str) -> Result<(Rows, u32), ProjectError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // First of all: of a newer file nothing else need make sense here.
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
            Err(error) => return wrong(error.to_string()),
        };
        let key = Key::new(section.iter().cloned().chain(parts));
        if key.to_string() == MARK {
            continue;
        }
        let text = one_line(&value);
        let row = Row { text, line: number };
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

/// The number of the layout, which stands in the first line that says something.
fn version(text: &str) -> Result<u32, ProjectError> {
    let lines = text.lines().zip(1..);
    let mut said = lines.filter(|(line, _)| !line.trim().is_empty() && !line.starts_with('#'));
    let no_project = |line| {
        ProjectError::line(
            line,
            format!(
                "this is no project of Bathyscope: it does not begin with `{MARK} = {VERSION}`"
            ),
        )
    };
    let (line, number) = said.next().ok_or_else(|| no_project(1))?;
    let value = line.split_once('=').filter(|(key, _)| key.trim() == MARK);
    let value = value.and_then(|(_, value)| parse_value(value.trim()).ok());
    match value {
        Some(Value::Integer(version)) if version >= 1 => {
            Ok(u32::try_from(version).unwrap_or(u32::MAX))
        }
        _ => Err(no_project(number)),
    }
}

/// Rows of one version as those of a later one.
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
