//! Points in lines of text: xyz, csv, txt.

use super::columns::{fields, is_comment, is_header, number, position, separator_of};
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
