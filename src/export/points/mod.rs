//! Point files of other programs, for `bathyscope filter` and `compare`: text, PLY, LAS and LAZ; for `compare` also GeoTIFF and
//! GeoJSON.
//!
//! A filtered file keeps all that the input said about a point when it is written in the input's own format; between
//! formats only the coordinates go over.

mod elevations;
mod geojson_file;
mod las_claims;
mod las_file;
mod ply_file;
mod raster_file;
mod text_file;

pub use elevations::{Elevations, Plane, read_elevations};

use super::write_aside;
use las_file::LasFile;
use ply_file::PlyFile;
use std::ffi::OsStr;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use text_file::{KNOWN_NAMES, TextFile, Wanted};

/// Why a point file cannot be used: one sentence, the path last.
#[derive(Debug, thiserror::Error)]
#[error("{what}: {path}")]
pub struct PointFileError {
    /// What is wrong, with the line or the byte where it is known.
    pub what: String,
    /// Which file.
    pub path: PathBuf,
}

/// A point file in memory.
#[derive(Debug)]
pub struct PointFile {
    /// x, y, z of each point, in the file's own units and order.
    pub points: Vec<[f64; 3]>,
    /// What had to be guessed about the file, in one sentence.
    pub note: Option<String>,
    /// Names of the columns that the coordinates are from, where they have names.
    pub names: Option<[String; 3]>,
    /// Lines left out because a coordinate is blank; none unless that was asked for.
    pub blank: usize,
    /// EPSG number of the system that the file names, where it does.
    pub epsg: Option<u32>,
    rows: Rows,
}

/// What else the file says about its points.
#[derive(Debug)]
enum Rows {
    Text(TextFile),
    Ply(PlyFile),
    Las(Box<LasFile>),
}

/// The format that a file name asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Text,
    Ply,
    Las,
}

impl Kind {
    fn of(path: &Path) -> Result<Self, String> {
        let suffix = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        match suffix.as_str() {
            "csv" | "xyz" | "txt" => Ok(Kind::Text),
            "ply" => Ok(Kind::Ply),
            "las" | "laz" => Ok(Kind::Las),
            _ => Err("a point file ends in .xyz, .csv, .txt, .ply, .las or .laz".to_owned()),
        }
    }
}

/// Splits `FILE.csv:x,y,z` into the file and the names of its three columns.
pub fn split_columns(argument: impl AsRef<OsStr>) -> (PathBuf, Option<[String; 3]>) {
    let argument = argument.as_ref();
    if let Some((file, names)) = argument.to_str().and_then(|text| text.rsplit_once(':')) {
        let names: Vec<String> = names
            .split(',')
            .map(|name| name.trim().to_owned())
            .collect();
        if let Ok(names) = <[String; 3]>::try_from(names) {
            return (file.into(), Some(names));
        }
    }
    (argument.into(), None)
}

/// Whether something is named as the files are whose elevations [`read_elevations`] reads, perhaps with its columns.
pub fn is_named_as_elevations(argument: impl AsRef<OsStr>) -> bool {
    let (path, _) = split_columns(argument);
    let suffix = path.extension().unwrap_or_default().to_string_lossy();
    let others = ["tif", "tiff", "geojson", "json"];
    Kind::of(&path).is_ok()
        || others
            .iter()
            .any(|other| suffix.eq_ignore_ascii_case(other))
}

/// Refuses a name that no point file has, before the work.
pub fn check_name(path: &Path) -> Result<(), PointFileError> {
    match Kind::of(path) {
        Ok(_) => Ok(()),
        Err(what) => Err(PointFileError {
            what,
            path: path.to_path_buf(),
        }),
    }
}

/// Reads a point file; `columns` names the coordinates of a text file with a header line.
pub fn read(path: &Path, columns: Option<&[String; 3]>) -> Result<PointFile, PointFileError> {
    read_wanted(
        path,
        Wanted {
            named: columns,
            known: &KNOWN_NAMES,
            skip_blank: false,
        },
    )
}

fn read_wanted(path: &Path, wanted: Wanted<'_>) -> Result<PointFile, PointFileError> {
    Kind::of(path)
        .and_then(|kind| read_kind(kind, path, wanted))
        .map_err(|what| PointFileError {
            what,
            path: path.to_path_buf(),
        })
}

fn read_kind(kind: Kind, path: &Path, wanted: Wanted<'_>) -> Result<PointFile, String> {
    let named_otherwise = wanted.named.is_some_and(|names| names != &["x", "y", "z"]);
    if kind != Kind::Text && named_otherwise {
        return Err("the coordinates of a PLY or LAS file are always x, y and z".to_owned());
    }
    let bare = |rows, points| PointFile {
        points,
        note: None,
        names: None,
        blank: 0,
        epsg: None,
        rows,
    };
    Ok(match kind {
        Kind::Text => {
            let (file, points) = text_file::read(path, wanted)?;
            PointFile {
                note: file.note(),
                names: file.names.clone(),
                blank: file.blank,
                ..bare(Rows::Text(file), points)
            }
        }
        Kind::Ply => {
            let (file, points) = ply_file::read(path)?;
            bare(Rows::Ply(file), points)
        }
        Kind::Las => {
            let (file, points) = las_file::read(path)?;
            PointFile {
                epsg: file.epsg(),
                ..bare(Rows::Las(Box::new(file)), points)
            }
        }
    })
}

impl PointFile {
    /// Writes the points whose flag is set, in the format that the path asks for.
    pub fn write_kept(&self, path: &Path, kept: &[bool]) -> Result<(), PointFileError> {
        let fail = |what: String| PointFileError {
            what,
            path: path.to_path_buf(),
        };
        let kind = Kind::of(path).map_err(fail)?;
        let kept_points = || {
            self.points
                .iter()
                .zip(kept)
                .filter(|(_, kept)| **kept)
                .map(|(point, _)| point)
        };
        write_aside(path, |file| match (&self.rows, kind) {
            (Rows::Text(rows), Kind::Text) => rows.write_kept(file, kept),
            (Rows::Ply(rows), Kind::Ply) => rows.write_kept(file, kept),
            (Rows::Las(rows), Kind::Las) => rows.write_kept(file, kept, is_laz(path)),
            (_, Kind::Text) => {
                let mut out = BufWriter::new(file);
                let separator = if path.extension().is_some_and(|suffix| suffix == "csv") {
                    writeln!(out, "x,y,z")?;
                    ','
                } else {
                    ' '
                };
                for [x, y, z] in kept_points() {
                    writeln!(out, "{x}{separator}{y}{separator}{z}")?;
                }
                out.flush()
            }
            (_, Kind::Ply) => ply_file::write(file, kept_points()),
            (_, Kind::Las) => las_file::write(file, kept_points(), is_laz(path)),
        })
        .map_err(|error| fail(format!("cannot write the file: {}", error.source)))
    }
}

fn is_laz(path: &Path) -> bool {
    path.extension()
        .is_some_and(|suffix| suffix.eq_ignore_ascii_case("laz"))
}
