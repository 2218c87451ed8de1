//! Errors of point files.

use crate::formats::geotiff::CellsError;
use crate::support::file_error::FileError;
use std::io;

/// Reason why a point file cannot be used.
pub type PointFileError = FileError<PointFault>;

/// Fault of a point file, as a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum PointFault {
    /// Its name does not say which format it is.
    #[error("a point file ends in .xyz, .csv, .txt, .ply, .las or .laz")]
    Ending,
    /// Columns are named, and the format has none.
    #[error("the coordinates of a {0} are always x, y and z")]
    FixedColumns(&'static str),
    /// The system does not give it.
    #[error("cannot read the points: {0}")]
    Io(#[from] io::Error),
    /// Its lines of text hold something else.
    #[error(transparent)]
    Text(#[from] TextFault),
    /// It is no PLY that is read.
    #[error(transparent)]
    Ply(#[from] PlyFault),
    /// It is no LAS.
    #[error(transparent)]
    Las(#[from] LasFault),
    /// It is no GeoTIFF of heights.
    #[error(transparent)]
    Raster(#[from] CellsError),
    /// It is a GeoJSON that is not taken into memory.
    #[error("the GeoJSON is longer than 1 GiB; write the points as CSV")]
    LongGeoJson,
    /// It is no JSON.
    #[error("the points are no GeoJSON: {0}")]
    NotJson(#[from] serde_json::Error),
    /// It is JSON of another kind.
    #[error("the GeoJSON is no FeatureCollection")]
    NoFeatures,
    /// It holds nothing.
    #[error("the file is empty: there is no point in it")]
    Empty,
    /// It holds so many lines or features, and no point.
    #[error("none of the {0} lines or features has all three coordinates")]
    AllBlank(usize),
}

/// Fault of points in lines of text.
#[derive(Debug, thiserror::Error)]
pub enum TextFault {
    /// A column is asked for by a name that several have, or twice.
    #[error("`{0}` is named twice, so it does not say which column is meant")]
    NamedTwice(String),
    /// The header does not name what is asked for.
    #[error(
        "there are no columns `{}`, `{}` and `{}`; write FILE:x,y,z with three of {}",
        names[0], names[1], names[2], header.join(", ")
    )]
    NoColumns {
        /// Names that are asked for.
        names: [String; 3],
        /// Names in the header.
        header: Vec<String>,
    },
    /// Columns are asked for by name, and the first line names none.
    #[error(
        "there is no header line that could name `{}`, `{}` and `{}`; write one, or name no columns: then the first three count",
        .0[0], .0[1], .0[2]
    )]
    NoHeader([String; 3]),
    /// A line is no point.
    #[error("line {line}: {what}")]
    Line {
        /// Counted from 1.
        line: usize,
        /// The fault.
        #[source]
        what: PointLineFault,
    },
}

/// Fault of a line of a text file.
#[derive(Debug, thiserror::Error)]
pub enum PointLineFault {
    /// It has so many fields, and no header says what they are.
    #[error(
        "there are {}, and a point is x, y and z; put commas, semicolons or spaces between them, and name the columns in the first line where they are not the first three",
        in_fields(*.0)
    )]
    TooFewFields(usize),
    /// It ends before a column of the header.
    #[error(
        "there are {}, so the column `{column}` of the header is missing; mend the line, or take it out",
        in_fields(*.fields)
    )]
    TooShort {
        /// The column.
        column: String,
        /// Fields that it has.
        fields: usize,
    },
    /// A coordinate is no number.
    #[error(
        "`{field}` in column `{column}` is not a number; mend it, or leave it empty to pass over the line"
    )]
    NotANumber {
        /// Text in place of a number.
        field: String,
        /// The column.
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
    /// It is another kind of file.
    #[error("the file does not begin with `ply`")]
    NotPly,
    /// The header as a whole.
    #[error("the PLY header {0}")]
    Header(&'static str),
    /// A line of the header.
    #[error("line {line}: {what}: `{text}`")]
    HeaderLine {
        /// Counted from 1.
        line: usize,
        /// The fault.
        what: &'static str,
        /// The line.
        text: String,
    },
    /// The vertex in this line of text has too few numbers.
    #[error("line {0}: this vertex has no numbers for x, y and z")]
    NoNumbers(usize),
    /// It is cut.
    #[error("the PLY file ends after {found} of {count} vertices")]
    TooShort {
        /// Vertices that it holds.
        found: usize,
        /// Vertices that the header speaks of.
        count: usize,
    },
}

/// Fault of a LAS file.
#[derive(Debug, thiserror::Error)]
pub enum LasFault {
    /// The system does not give it, or its header claims what cannot be.
    #[error("the LAS file cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is no LAS, or one of a kind that is not known.
    #[error("the LAS file cannot be read: {0}")]
    Las(#[from] las::Error),
    /// A point is damaged.
    #[error("the LAS file cannot be read: {source} after {read} points")]
    Point {
        /// Points before it.
        read: usize,
        /// Error of the decoder.
        source: las::Error,
    },
    /// The decoder gave up.
    #[error("the LAS file cannot be read: it is damaged")]
    Damaged,
}
