//! Reads and writes point files of other programs: text, PLY, LAS, LAZ and COPC; reads GeoTIFF and
//! GeoJSON as elevations.
//!
//! In: a file of points, or points. Out: positions with elevations, or a file.
//!
//! A filtered file keeps all attributes of its points when it is written in the format of the
//! input; otherwise it has only the coordinates.

mod copc;
mod elevations;
mod las_file;
mod ply_file;
pub(super) mod text_file;

pub use copc::write_copc;
pub use elevations::{Elevations, PointPlane, read_elevations};
pub use las_file::{LasWriter, transforms};

use crate::support::file_error::{FaultText, FileError};
use copc::is_named_copc;
use las_file::LasFile;
use ply_file::PlyFile;
use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use text_file::{ColumnRequest, KNOWN_NAMES, TextFile};

/// A point file in memory.
#[derive(Debug)]
pub struct PointFile {
    /// x, y, z of each point, in the file's own units and order.
    pub points: Vec<[f64; 3]>,
    /// Remark about assumptions on the file, in one sentence; `None` where none was needed.
    pub note: Option<String>,
    /// Names of the columns of the coordinates; `None` where they have no names.
    pub names: Option<[String; 3]>,
    /// Number of lines left out because a coordinate is blank; 0 unless this was requested.
    pub blank: usize,
    /// True for each point that should not be used according to the file: "withheld" in LAS, 0 in a
    /// column `kept`. Empty where the file has no such information.
    pub set_aside: Vec<bool>,
    /// EPSG number of the file's coordinate system; `None` where the file names none.
    pub epsg: Option<u32>,
    rows: FormatFile,
}

/// Other content of the file, by format.
#[derive(Debug)]
enum FormatFile {
    Text(TextFile),
    Ply(PlyFile),
    Las(Box<LasFile>),
}

/// Format of a point file, by the ending of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointFormat {
    /// Lines of text, written with a header line that names the columns.
    Csv,
    /// Lines of text, written without a header line.
    Xyz,
    /// PLY.
    Ply,
    /// LAS.
    Las,
    /// Compressed LAS.
    Laz,
    /// Compressed LAS with an octree: `.copc.laz`.
    Copc,
}

impl PointFormat {
    /// Returns the format of a file, by the ending of its name.
    ///
    /// # Errors
    /// When the ending is that of no point file.
    pub fn of(path: &Path) -> Result<Self, FileError> {
        match suffix(path).as_str() {
            "csv" => Ok(Self::Csv),
            "xyz" | "txt" => Ok(Self::Xyz),
            "ply" => Ok(Self::Ply),
            "las" => Ok(Self::Las),
            "laz" if is_named_copc(path) => Ok(Self::Copc),
            "laz" => Ok(Self::Laz),
            _ => {
                let what = "a point file ends in .xyz, .csv, .txt, .ply, .las or .laz";
                Err(FileError::new(what.into(), path))
            }
        }
    }
}

/// Returns the ending of a file's name, in lower case.
fn suffix(path: &Path) -> String {
    let suffix = path.extension().unwrap_or_default();
    suffix.to_string_lossy().to_lowercase()
}

/// Splits `FILE.csv:x,y,z` into the file and the names of its three columns.
pub fn split_columns(argument: impl AsRef<OsStr>) -> (PathBuf, Option<[String; 3]>) {
    let argument = argument.as_ref();
    if let Some((file, names)) = argument.to_str().and_then(|text| text.rsplit_once(':')) {
        let names: Vec<String> = names.split(',').map(|name| name.trim().to_owned()).collect();
        if let Ok(names) = <[String; 3]>::try_from(names) {
            return (file.into(), Some(names));
        }
    }
    (argument.into(), None)
}

/// Returns true if an argument has the name of a file that [`read_elevations`] reads, with or
/// without columns.
pub fn is_named_as_elevations(argument: impl AsRef<OsStr>) -> bool {
    let (path, _) = split_columns(argument);
    let others = ["tif", "tiff", "geojson", "json"];
    PointFormat::of(&path).is_ok() || others.contains(&suffix(&path).as_str())
}

/// Reads a point file; `columns` names the coordinates of a text file with a header line.
///
/// # Errors
/// When the ending is that of no point file, or the file cannot be read.
pub fn read(path: &Path, columns: Option<&[String; 3]>) -> Result<PointFile, FileError> {
    read_columns(path, ColumnRequest { named: columns, known: &KNOWN_NAMES, skip_blank: false })
}

fn read_columns(path: &Path, requested: ColumnRequest<'_>) -> Result<PointFile, FileError> {
    read_format(PointFormat::of(path)?, path, requested).map_err(FileError::at(path))
}

fn read_format(
    format: PointFormat,
    path: &Path,
    requested: ColumnRequest<'_>,
) -> Result<PointFile, FaultText> {
    let named_otherwise = requested.named.is_some_and(|names| names != &["x", "y", "z"]);
    if !matches!(format, PointFormat::Csv | PointFormat::Xyz) && named_otherwise {
        return Err("the coordinates of a PLY or LAS file are always x, y and z".into());
    }
    let bare = |rows, points| PointFile {
        points,
        note: None,
        names: None,
        blank: 0,
        set_aside: Vec::new(),
        epsg: None,
        rows,
    };
    Ok(match format {
        PointFormat::Csv | PointFormat::Xyz => {
            let (file, points) = text_file::read(path, requested)?;
            PointFile {
                note: file.note(),
                names: file.names.clone(),
                blank: file.blank,
                set_aside: file.set_aside.clone(),
                ..bare(FormatFile::Text(file), points)
            }
        }
        PointFormat::Ply => {
            let (file, points) = ply_file::read(path)?;
            bare(FormatFile::Ply(file), points)
        }
        PointFormat::Las | PointFormat::Laz | PointFormat::Copc => {
            let (file, points) = las_file::read(path)?;
            PointFile {
                epsg: file.epsg(),
                set_aside: file.withheld(),
                ..bare(FormatFile::Las(Box::new(file)), points)
            }
        }
    })
}

/// Returns the fault of a point file that the system cannot read.
fn unreadable(error: &io::Error) -> FaultText {
    format!("cannot read the points: {error}").into()
}

impl PointFile {
    /// Writes the points whose flag is set into an open file: with all attributes in the format of
    /// the input, with only their coordinates in another.
    ///
    /// # Errors
    /// When writing fails, or the format cannot store the points.
    pub fn write_kept(&self, out: File, format: PointFormat, kept: &[bool]) -> io::Result<()> {
        let kept_points = || {
            let points = self.points.iter().zip(kept);
            points.filter(|(_, kept)| **kept).map(|(point, _)| point)
        };
        match (&self.rows, format) {
            (FormatFile::Text(rows), PointFormat::Csv | PointFormat::Xyz) => {
                rows.write_kept(out, kept)
            }
            (FormatFile::Ply(rows), PointFormat::Ply) => rows.write_kept(out, kept),
            (FormatFile::Las(rows), PointFormat::Las | PointFormat::Laz | PointFormat::Copc) => {
                rows.write_kept(out, kept, format)
            }
            (_, PointFormat::Csv | PointFormat::Xyz) => {
                write_lines(out, format == PointFormat::Csv, kept_points())
            }
            (_, PointFormat::Ply) => ply_file::write(out, kept_points()),
            (_, PointFormat::Las | PointFormat::Laz | PointFormat::Copc) => {
                las_file::write(out, kept_points(), format)
            }
        }
    }
}

fn write_lines<'a>(
    out: File,
    is_csv: bool,
    points: impl Iterator<Item = &'a [f64; 3]>,
) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let separator = if is_csv { ',' } else { ' ' };
    if is_csv {
        writeln!(out, "x,y,z")?;
    }
    for [x, y, z] in points {
        writeln!(out, "{x}{separator}{y}{separator}{z}")?;
    }
    out.flush()
}
