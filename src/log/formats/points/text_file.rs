//! Points in lines of text: xyz, csv, txt.
//!
//! Other tables find their columns with the same functions: what stands between them, what the
//! first line names them, and the numbers in them.

use super::{PointFault, PointLineFault, TextFault};
use crate::support::printable::one_line;
use crate::support::regular_file;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// The lines of a text file.
#[derive(Debug)]
pub(super) struct TextFile {
    /// Comments and the header line before the first point.
    preamble: Vec<String>,
    /// One line a point, as it was.
    lines: Vec<String>,
    /// Names of the columns that were taken for x, y, z without anybody saying so.
    guessed: Option<[String; 3]>,
    /// Names of the columns that were taken, where they have names.
    pub(super) names: Option<[String; 3]>,
    /// Lines left out because a coordinate is blank.
    pub(super) blank: usize,
    /// One flag a point where the header names a column `kept`: whether it holds 0.
    pub(super) set_aside: Vec<bool>,
}

/// Columns to read.
#[derive(Clone, Copy)]
pub(super) struct ColumnRequest<'a> {
    /// Names that the user gave.
    pub named: Option<&'a [String; 3]>,
    /// Names to look for when the user names none, in lower case; the first that are all there win.
    pub known: &'a [[&'a str; 3]],
    /// True if a line with a blank coordinate is left out instead of refused.
    pub skip_blank: bool,
}

/// Column names that are taken for coordinates when the user names none.
pub(super) const KNOWN_NAMES: [[&str; 3]; 4] = [
    ["x", "y", "z"],
    ["east_m", "north_m", "z_m"],
    ["easting", "northing", "elevation"],
    ["easting", "northing", "z"],
];

/// Reads lines of numbers, separated by commas, semicolons, tabs or spaces. Without a header line
/// the first three columns are x, y, z. Lines that begin with `#` or `//` are comments.
pub(super) fn read(
    path: &Path,
    requested: ColumnRequest<'_>,
) -> Result<(TextFile, Vec<[f64; 3]>), PointFault> {
    let text = regular_file::read_text(path, u64::MAX)?;
    let mut file = TextFile {
        preamble: Vec::new(),
        lines: Vec::new(),
        guessed: None,
        names: None,
        blank: 0,
        set_aside: Vec::new(),
    };
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
        let point = layout.point(line).map_err(|what| TextFault::Line { line: index + 1, what })?;
        points.push(point);
        file.set_aside.extend(layout.is_set_aside(line));
        file.lines.push(line.to_owned());
    }
    Ok((file, points))
}

impl TextFile {
    /// Returns a sentence about the columns that had to be guessed; `None` where none had to be.
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

/// Columns that hold the coordinates.
struct ColumnLayout {
    /// `None` for runs of spaces and tabs.
    separator: Option<char>,
    columns: [usize; 3],
    /// Column named `kept`.
    kept: Option<usize>,
    names: [String; 3],
    /// The first three names of a header that none of the known names is in.
    guessed: Option<[String; 3]>,
}

impl ColumnLayout {
    /// Determines the columns from the first line, which is a header unless it holds numbers only;
    /// also returns true if it is a header.
    fn of(line: &str, requested: ColumnRequest<'_>) -> Result<(Self, bool), TextFault> {
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
            return Err(TextFault::NamedTwice(name));
        }
        let found = match names {
            Some(names @ [x, y, z]) if is_header => {
                Some(find([x, y, z]).ok_or_else(|| TextFault::NoColumns {
                    names: names.clone(),
                    header: fields.iter().copied().map(str::to_owned).collect(),
                })?)
            }
            Some(names) => return Err(TextFault::NoHeader(names.clone())),
            None if is_header => requested.known.iter().copied().find_map(find),
            None => None,
        };
        let first = || {
            fields
                .get(..3)?
                .iter()
                .map(|&field| field.to_owned())
                .collect::<Vec<_>>()
                .try_into()
                .ok()
        };
        let guessed = if is_header && found.is_none() { first() } else { None };
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

    /// Returns true if a coordinate has a place in the line, but nothing stands there.
    fn is_blank(&self, line: &str) -> bool {
        let fields = fields(line, self.separator);
        let field = |column: usize| fields.get(column).copied();
        self.columns.iter().any(|&column| field(column) == Some(""))
    }

    /// Returns true if `kept` is 0; `None` where the header does not name it.
    fn is_set_aside(&self, line: &str) -> Option<bool> {
        let kept = self.kept?;
        Some(fields(line, self.separator).get(kept).copied() == Some("0"))
    }

    /// Fault of a line of so many fields that has no such column.
    fn too_short(&self, name: &str, fields: usize) -> PointLineFault {
        if self.names == ["1", "2", "3"] {
            PointLineFault::TooFewFields(fields)
        } else {
            PointLineFault::TooShort { column: name.to_owned(), fields }
        }
    }

    fn point(&self, line: &str) -> Result<[f64; 3], PointLineFault> {
        let fields = fields(line, self.separator);
        let mut point = [0.0; 3];
        for (axis, value) in point.iter_mut().enumerate() {
            let name = &self.names[axis];
            let field =
                fields.get(self.columns[axis]).ok_or_else(|| self.too_short(name, fields.len()))?;
            let read = number(field, self.separator);
            *value = read.ok_or_else(|| PointLineFault::NotANumber {
                field: (*field).to_owned(),
                column: name.clone(),
            })?;
        }
        Ok(point)
    }
}

/// Returns true if a line is no part of the table: it is empty, or begins with `#` or `//`.
pub(in crate::formats) fn is_comment(line: &str) -> bool {
    let line = line.trim_start();
    line.is_empty() || line.starts_with('#') || line.starts_with("//")
}

/// Returns the separator between the fields of a table with such a line; `None` for runs of spaces.
/// A comma between semicolons or tabs belongs to a number.
pub(in crate::formats) fn separator_of(line: &str) -> Option<char> {
    let stands = |separator: &char| {
        let mut quoted = false;
        line.chars().any(|letter| {
            quoted ^= letter == '"';
            letter == *separator && !quoted
        })
    };
    [';', '\t', ','].into_iter().find(stands)
}

/// The fields of a line, without quotes and outer spaces. A separator within quotes separates
/// nothing.
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

/// The number in a field; it may be written with a decimal comma where commas do not separate. It
/// may be infinite or no number.
pub(in crate::formats) fn number(field: &str, separator: Option<char>) -> Option<f64> {
    let number = field.parse().ok();
    let with_comma = || match separator {
        Some(',') => None,
        _ => field.replacen(',', ".", 1).parse().ok(),
    };
    number.or_else(with_comma)
}

/// Returns true if the fields of the first line name columns: one of them is no number.
pub(in crate::formats) fn is_header(fields: &[&str], separator: Option<char>) -> bool {
    let is_name = |field: &&str| !field.is_empty() && number(field, separator).is_none();
    fields.iter().any(is_name)
}

/// Returns the index of a name in a header, in letters of either case.
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
