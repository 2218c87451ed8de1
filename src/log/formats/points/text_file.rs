//! Reads and writes points in lines of text: xyz, csv, txt.
//!
//! Readers of other tables use the same functions to find the separator, the header and the numbers
//! in the columns.

use super::unreadable;
use crate::support::file_error::FaultText;
use crate::support::printable::one_line;
use crate::support::regular_file;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// Lines of a text file.
#[derive(Debug, Default)]
pub(super) struct TextFile {
    /// Comments and the header line before the first point.
    preamble: Vec<String>,
    /// Line of each point, unchanged.
    lines: Vec<String>,
    /// Names of the first three columns, where these are used because no known names are in the
    /// header.
    guessed: Option<[String; 3]>,
    /// Names of the columns that are used; `None` where they have no names.
    pub(super) names: Option<[String; 3]>,
    /// Number of lines left out because a coordinate is blank.
    pub(super) blank: usize,
    /// True for each point with 0 in a column `kept`; empty where the header names no such column.
    pub(super) set_aside: Vec<bool>,
}

/// Columns to read.
#[derive(Clone, Copy)]
pub(super) struct ColumnRequest<'a> {
    /// Names that the user gave; `None` where the user gave none.
    pub named: Option<&'a [String; 3]>,
    /// Groups of three names that are tried if the user gave none: the first group whose names are
    /// all in the header is used.
    pub known: &'a [[&'a str; 3]],
    /// True if a line with a blank coordinate is left out instead of refused.
    pub skip_blank: bool,
}

/// Names of columns that are used as coordinates if the user gave none.
pub(super) const KNOWN_NAMES: [[&str; 3]; 4] = [
    ["x", "y", "z"],
    ["east_m", "north_m", "z_m"],
    ["easting", "northing", "elevation"],
    ["easting", "northing", "z"],
];

/// Reads lines of numbers that are separated by commas, semicolons, tabs or spaces. Without a
/// header line the first three columns are x, y, z. Lines that begin with `#` or `//` are comments.
pub(super) fn read(
    path: &Path,
    requested: ColumnRequest<'_>,
) -> Result<(TextFile, Vec<[f64; 3]>), FaultText> {
    let text = regular_file::read_text(path, u64::MAX).map_err(|error| unreadable(&error))?;
    let mut file = TextFile::default();
    let mut points = Vec::new();
    let mut layout: Option<ColumnLayout> = None;
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        if is_comment(line) {
            if points.is_empty() {
                file.preamble.push(line.to_owned());
            }
            continue;
        }
        let layout = match &layout {
            Some(layout) => layout,
            None => {
                let (found, is_header) = ColumnLayout::of(line, requested)?;
                let found = layout.insert(found);
                if is_header {
                    file.guessed = found.guessed.clone();
                    file.names = Some(found.guessed.clone().unwrap_or_else(|| found.names.clone()));
                    file.preamble.push(line.to_owned());
                    continue;
                }
                found
            }
        };
        if requested.skip_blank && layout.is_blank(line) {
            file.blank += 1;
            continue;
        }
        let point = layout.point(line);
        let point = point.map_err(|what| format!("line {}: {what}", index + 1))?;
        points.push(point);
        file.set_aside.extend(layout.is_set_aside(line));
        file.lines.push(line.to_owned());
    }
    Ok((file, points))
}

impl TextFile {
    /// Returns a sentence about columns that had to be guessed; `None` where none had to be.
    pub(super) fn note(&self) -> Option<String> {
        let [x, y, z] = self.guessed.as_ref()?;
        Some(one_line(&format!(
            "the header names no x, y and z, so the columns `{x}`, `{y}` and `{z}` are taken; write FILE:x,y,z to name others"
        )))
    }

    pub(super) fn write_kept(&self, file: File, kept: &[bool]) -> io::Result<()> {
        let mut out = BufWriter::new(file);
        let lines = self.lines.iter().zip(kept).filter(|(_, kept)| **kept).map(|(line, _)| line);
        for line in self.preamble.iter().chain(lines) {
            writeln!(out, "{line}")?;
        }
        out.flush()
    }
}

/// Columns of a table with the coordinates.
struct ColumnLayout {
    /// Separator between fields; `None` for runs of spaces and tabs.
    separator: Option<char>,
    columns: [usize; 3],
    /// Index of the column named `kept`.
    kept: Option<usize>,
    names: [String; 3],
    /// First three names of a header that contains none of the known names.
    guessed: Option<[String; 3]>,
}

impl ColumnLayout {
    /// Determines the columns from the first line, which is a header if one of its fields is
    /// neither empty nor a number; the second value is true if it is a header.
    fn of(line: &str, requested: ColumnRequest<'_>) -> Result<(Self, bool), String> {
        let names = requested.named;
        let separator = separator_of(line);
        let fields = fields(line, separator);
        let is_header = is_header(&fields, separator);
        let position = |name: &str| position(&fields, name);
        let find = |names: [&str; 3]| {
            let [x, y, z] = names.map(position);
            Some(([x?, y?, z?], names.map(str::to_owned)))
        };
        let twice = |names: &[String; 3]| {
            let times = |name: &&String| {
                let same = fields.iter().filter(|field| field.eq_ignore_ascii_case(name));
                same.count() + names.iter().filter(|other| other == name).count()
            };
            names.iter().find(|name| times(name) > 2).cloned()
        };
        if let Some(name) = names.and_then(twice) {
            return Err(format!(
                "`{name}` is named twice, so it does not say which column is meant"
            ));
        }
        let found = match names {
            Some([x, y, z]) if is_header => Some(find([x, y, z]).ok_or_else(|| {
                let header = fields.join(", ");
                format!(
                    "there are no columns `{x}`, `{y}` and `{z}`; write FILE:x,y,z with three of {header}"
                )
            })?),
            Some([x, y, z]) => {
                return Err(format!(
                    "there is no header line that could name `{x}`, `{y}` and `{z}`; write one, or name no columns: then the first three count"
                ));
            }
            None if is_header => requested.known.iter().copied().find_map(find),
            None => None,
        };
        let guessed = fields.first_chunk::<3>().filter(|_| is_header && found.is_none());
        let guessed = guessed.map(|first| first.map(str::to_owned));
        let (columns, names) =
            found.unwrap_or_else(|| ([0, 1, 2], ["1", "2", "3"].map(str::to_owned)));
        Ok((
            Self {
                separator,
                columns,
                kept: position("kept").filter(|_| is_header),
                names,
                guessed,
            },
            is_header,
        ))
    }

    /// Returns true if the field of a coordinate is empty.
    fn is_blank(&self, line: &str) -> bool {
        let fields = fields(line, self.separator);
        let field = |column: usize| fields.get(column).copied();
        self.columns.iter().any(|&column| field(column) == Some(""))
    }

    /// Returns true if the field `kept` of the line is 0; `None` where the header does not name it.
    fn is_set_aside(&self, line: &str) -> Option<bool> {
        let kept = self.kept?;
        Some(fields(line, self.separator).get(kept).copied() == Some("0"))
    }

    /// Returns the fault of a line with `fields` fields that has no field for the column `name`.
    fn too_short(&self, name: &str, fields: usize) -> String {
        let fields = if fields == 1 { "1 field".to_owned() } else { format!("{fields} fields") };
        if self.names == ["1", "2", "3"] {
            format!(
                "there are {fields}, and a point is x, y and z; put commas, semicolons or spaces between them, and name the columns in the first line where they are not the first three"
            )
        } else {
            format!(
                "there are {fields}, so the column `{name}` of the header is missing; mend the line, or take it out"
            )
        }
    }

    fn point(&self, line: &str) -> Result<[f64; 3], String> {
        let fields = fields(line, self.separator);
        let mut point = [0.0; 3];
        for (axis, value) in point.iter_mut().enumerate() {
            let name = &self.names[axis];
            let field =
                fields.get(self.columns[axis]).ok_or_else(|| self.too_short(name, fields.len()))?;
            let read = number(field, self.separator);
            *value = read.ok_or_else(|| {
                format!(
                    "`{field}` in column `{name}` is not a number; mend it, or leave it empty to pass over the line"
                )
            })?;
        }
        Ok(point)
    }
}

/// Returns true if a line is no row of the table: it is empty, or begins with `#` or `//`.
pub(in crate::formats) fn is_comment(line: &str) -> bool {
    let line = line.trim_start();
    line.is_empty() || line.starts_with('#') || line.starts_with("//")
}

/// Returns the separator of a table that contains this line; `None` for runs of spaces. A comma
/// in a line with semicolons or tabs is part of a number.
pub(in crate::formats) fn separator_of(line: &str) -> Option<char> {
    let occurs = |separator: &char| {
        let mut quoted = false;
        line.chars().any(|letter| {
            quoted ^= letter == '"';
            letter == *separator && !quoted
        })
    };
    [';', '\t', ','].into_iter().find(occurs)
}

/// Returns the fields of a line, without quotes and outer spaces. A separator within quotes is part
/// of the field. Fields that are separated by spaces keep their quotes, and a space within quotes
/// divides them.
pub(in crate::formats) fn fields(line: &str, separator: Option<char>) -> Vec<&str> {
    let Some(separator) = separator else {
        return line.split_whitespace().collect();
    };
    let mut quoted = false;
    line.split(|c| {
        quoted ^= c == '"';
        c == separator && !quoted
    })
    .map(|field| field.trim().trim_matches('"').trim())
    .collect()
}

/// Parses the number in a field; a decimal comma is accepted where commas are not the separator.
/// The result may be infinite or NaN.
pub(in crate::formats) fn number(field: &str, separator: Option<char>) -> Option<f64> {
    let number = field.parse().ok();
    let with_comma = || match separator {
        Some(',') => None,
        _ => field.replacen(',', ".", 1).parse().ok(),
    };
    number.or_else(with_comma)
}

/// Returns true if the first line is a header: one of its fields is neither empty nor a number.
pub(in crate::formats) fn is_header(fields: &[&str], separator: Option<char>) -> bool {
    let is_name = |field: &&str| !field.is_empty() && number(field, separator).is_none();
    fields.iter().any(is_name)
}

/// Returns the index of a name in a header, ignoring upper and lower case.
fn position(header: &[&str], name: &str) -> Option<usize> {
    header.iter().position(|field| field.eq_ignore_ascii_case(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_commas_stand_between_other_separators() {
        for (line, separator, expected) in [
            ("1.5,2", Some(','), [1.5, 2.0]),
            ("1,5;2", Some(';'), [1.5, 2.0]),
            ("1,5\t2,25", Some('\t'), [1.5, 2.25]),
            ("\"1;5\",2", Some(','), [f64::NAN, 2.0]),
            ("1,5", Some(','), [1.0, 5.0]),
            ("1.5 2", None, [1.5, 2.0]),
        ] {
            assert_eq!(separator_of(line), separator, "{line}");
            for (field, expected) in fields(line, separator).iter().zip(expected) {
                let found = number(field, separator);
                assert_eq!(found, Some(expected).filter(|number| !number.is_nan()), "{line}");
            }
        }
        assert!(is_header(&["lon", "2"], Some(',')) && !is_header(&["1,5", ""], Some(';')));
    }
}
