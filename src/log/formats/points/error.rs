//! Defines the errors of point files.

use crate::formats::geotiff::CellsError;
use crate::support::file_error::FileError;
use std::io;

/// Error of a point file that cannot be used.
pub type PointFileError = FileError<PointFault>;

/// Fault of a point file, as a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum PointFault {
    /// The ending of the name is that of no point file.
    #[error("a point file ends in .xyz, .csv, .txt, .ply, .las or .laz")]
    Ending,
    /// The user names columns, but the format has fixed ones; the field is the kind of file.
    #[error("the coordinates of a {0} are always x, y and z")]
    FixedColumns(&'static str),
    /// The operating system cannot read the file.
    #[error("cannot read the points: {0}")]
    Io(#[from] io::Error),
    /// A text file is no table of points.
    #[error(transparent)]
    Text(#[from] TextFault),
    /// A PLY file is damaged or of a kind that is not supported.
    #[error(transparent)]
    Ply(#[from] PlyFault),
    /// A LAS file is damaged or of a kind that is not supported.
    #[error(transparent)]
    Las(#[from] LasFault),
    /// A GeoTIFF cannot be read as heights.
    #[error(transparent)]
    Raster(#[from] CellsError),
    /// The GeoJSON is too long to be read into memory.
    #[error("the GeoJSON is longer than 1 GiB; write the points as CSV")]
    LongGeoJson,
    /// The file is no JSON.
    #[error("the points are no GeoJSON: {0}")]
    NotJson(#[from] serde_json::Error),
    /// The file is JSON, but no FeatureCollection.
    #[error("the GeoJSON is no FeatureCollection")]
    NoFeatures,
    /// The file contains no points.
    #[error("the file is empty: there is no point in it")]
    Empty,
    /// No line or feature has all three coordinates; the field is their number.
    #[error("none of the {0} lines or features has all three coordinates")]
    AllBlank(usize),
}

/// Fault of points in lines of text.
#[derive(Debug, thiserror::Error)]
pub enum TextFault {
    /// The requested name of a column is in the header several times, or was requested twice.
    #[error("`{0}` is named twice, so it does not say which column is meant")]
    NamedTwice(String),
    /// The header does not contain the requested names.
    #[error(
        "there are no columns `{}`, `{}` and `{}`; write FILE:x,y,z with three of {}",
        names[0], names[1], names[2], header.join(", ")
    )]
    NoColumns {
        /// Requested names.
        names: [String; 3],
        /// Names in the header.
        header: Vec<String>,
    },
    /// Columns are requested by name, but the first line is no header; the field is the requested
    /// names.
    #[error(
        "there is no header line that could name `{}`, `{}` and `{}`; write one, or name no columns: then the first three count",
        .0[0], .0[1], .0[2]
    )]
    NoHeader([String; 3]),
    /// A line is no point.
    #[error("line {line}: {what}")]
    Line {
        /// Line number, counted from 1.
        line: usize,
        /// Fault of the line.
        #[source]
        what: PointLineFault,
    },
}

/// Fault of a line of a text file.
#[derive(Debug, thiserror::Error)]
pub enum PointLineFault {
    /// The line of a table without a header has too few fields; the field is their number.
    #[error(
        "there are {}, and a point is x, y and z; put commas, semicolons or spaces between them, and name the columns in the first line where they are not the first three",
        in_fields(*.0)
    )]
    TooFewFields(usize),
    /// The line ends before a column of the header.
    #[error(
        "there are {}, so the column `{column}` of the header is missing; mend the line, or take it out",
        in_fields(*.fields)
    )]
    TooShort {
        /// Name of the column.
        column: String,
        /// Number of fields in the line.
        fields: usize,
    },
    /// A coordinate is no number.
    #[error(
        "`{field}` in column `{column}` is not a number; mend it, or leave it empty to pass over the line"
    )]
    NotANumber {
        /// The text that is no number.
        field: String,
        /// Name of the column.
        column: String,
    },
}

fn in_fields(count: usize) -> String {
    match count {
        1 => "1 field".to_owned(),
        count => format!("{count} fields"),
    }
}

/// Fault of a PLY file.
#[derive(Debug, thiserror::Error)]
pub enum PlyFault {
    /// The file does not begin as a PLY file.
    #[error("the file does not begin with `ply`")]
    NotPly,
    /// The header as a whole is damaged or not supported.
    #[error("the PLY header {0}")]
    Header(&'static str),
    /// A line of the header is damaged or not supported.
    #[error("line {line}: {what}: `{text}`")]
    HeaderLine {
        /// Line number, counted from 1.
        line: usize,
        /// Fault of the line.
        what: &'static str,
        /// Text of the line.
        text: String,
    },
    /// The vertex in this line, counted from 1, has no numbers for x, y and z.
    #[error("line {0}: this vertex has no numbers for x, y and z")]
    NoNumbers(usize),
    /// The file is truncated.
    #[error("the PLY file ends after {found} of {count} vertices")]
    TooShort {
        /// Number of vertices in the file.
        found: usize,
        /// Number of vertices that the header states.
        count: usize,
    },
}

/// Fault of a LAS file.
#[derive(Debug, thiserror::Error)]
pub enum LasFault {
    /// The operating system cannot read the file, or the header claims impossible sizes.
    #[error("the LAS file cannot be read: {0}")]
    Io(#[from] io::Error),
    /// The file is no LAS, or of a kind that is not supported.
    #[error("the LAS file cannot be read: {0}")]
    Las(#[from] las::Error),
    /// A point is damaged.
    #[error("the LAS file cannot be read: {source} after {read} points")]
    Point {
        /// Number of points before the damaged one.
        read: usize,
        /// Error of the decoder.
        source: las::Error,
    },
    /// The decoder panicked.
    #[error("the LAS file cannot be read: it is damaged")]
    Damaged,
}
