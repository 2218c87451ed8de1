//! Reads point files as elevations for comparison: finds the plane of their coordinates, and
//! whether their values count up or down.

use super::text_file::{ColumnRequest, KNOWN_NAMES};
use super::{PointFile, read_columns, split_columns, suffix, unreadable};
use crate::formats::geotiff;
use crate::support::file_error::{FaultText, FileError};
use crate::support::geo::UtmZone;
use crate::support::regular_file;
use serde_json::Value;
use std::ffi::OsStr;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Columns that are tried if the user names none; geographic columns first, because the metres of
/// two surveys may have different origins.
const GEOGRAPHIC_NAMES: [[&str; 3]; 4] = [
    ["lon", "lat", "z_m"],
    ["lon", "lat", "z"],
    ["longitude", "latitude", "elevation"],
    ["longitude", "latitude", "z"],
];
/// Properties that are used as a height when the user names none and a point has no third
/// coordinate; true for depths.
const KNOWN: [(&str, bool); 6] = [
    ("z_m", false),
    ("z", false),
    ("elevation", false),
    ("elevation_m", false),
    ("depth_m", true),
    ("depth", true),
];
/// Size of the largest GeoJSON file that is read, bytes; enough for any table of soundings.
const LONGEST: u64 = 1 << 30;

/// Meaning of the first two coordinates of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointPlane {
    /// Metres (or the file's own units) to the east and north.
    Metres,
    /// Degrees of longitude and latitude.
    Degrees,
    /// Metres of a UTM zone that the file names.
    Utm(UtmZone),
    /// Coordinates of another system, by the EPSG number in the file.
    Epsg(u16),
}

impl PointPlane {
    /// Returns the plane of a file that names a system by its EPSG number; metres where it names
    /// none, or a private number.
    fn of_epsg(epsg: Option<u32>) -> Self {
        // First private number; the meaning of private numbers is defined elsewhere in the file.
        const PRIVATE: u16 = 32_767;
        const WGS84: u16 = 4326;
        match epsg.map(|number| (UtmZone::from_epsg(number), u16::try_from(number))) {
            Some((Some(zone), _)) => PointPlane::Utm(zone),
            Some((None, Ok(WGS84))) => PointPlane::Degrees,
            Some((None, Ok(number @ 1..PRIVATE))) => PointPlane::Epsg(number),
            _ => PointPlane::Metres,
        }
    }
}

/// Points with elevations.
#[derive(Clone, Debug, PartialEq)]
pub struct Elevations {
    /// Path of the file.
    pub path: PathBuf,
    /// x, y, and z; z is positive up.
    pub points: Vec<[f64; 3]>,
    /// Meaning of x and y.
    pub plane: PointPlane,
    /// Number of lines or features that were left out because a coordinate is missing.
    pub blank: usize,
    /// Remark about assumptions on the file, in one sentence; `None` where none was needed.
    pub note: Option<String>,
}

/// Reads `FILE` or `FILE.csv:x,y,z`; `-z` names a column that counts downwards, a depth. Without
/// names, columns of longitude, latitude and elevation are used if there are any. Columns named lon
/// or longitude are degrees. Points that the file sets aside are skipped.
///
/// The cells of a GeoTIFF become points with their values as `z`; values that are stated to be
/// depths change their sign, unless names are given. In GeoJSON the third name is a property. LAS
/// and GeoTIFF state their coordinate system themselves.
///
/// # Errors
/// When the file cannot be read or is of an unknown kind, has no such columns, or contains no
/// point.
pub fn read_elevations(argument: &OsStr) -> Result<Elevations, FileError> {
    let file = read(argument)?;
    if !file.points.is_empty() {
        return Ok(file);
    }
    let what = match file.blank {
        0 => "the file is empty: there is no point in it".into(),
        count => format!("none of the {count} lines or features has all three coordinates").into(),
    };
    Err(FileError::new(what, &file.path))
}

fn read(argument: &OsStr) -> Result<Elevations, FileError> {
    let (path, mut names) = split_columns(argument);
    let downwards = names.as_mut().is_some_and(|[_, _, z]| match z.strip_prefix('-') {
        Some(name) => {
            *z = name.to_owned();
            true
        }
        None => false,
    });
    let fail = FileError::<FaultText>::at(&path);
    match suffix(&path).as_str() {
        "tif" | "tiff" => return of_raster(&path, names.as_ref(), downwards).map_err(fail),
        "geojson" | "json" => return of_geojson(&path, names.as_ref(), downwards).map_err(fail),
        _ => (),
    }
    let known = [GEOGRAPHIC_NAMES.as_slice(), KNOWN_NAMES.as_slice()].concat();
    let requested = ColumnRequest { named: names.as_ref(), known: &known, skip_blank: true };
    let mut file = read_columns(&path, requested)?;
    let passed_over = take_out_set_aside(&mut file);
    let degrees = file.names.as_ref().is_some_and(|[x, _, _]| {
        ["lon", "longitude"].iter().any(|name| x.eq_ignore_ascii_case(name))
    });
    let depths = names.is_none() && counts_depths(&file);
    let turning = depths
        .then(|| "the third column is named a depth, so it is turned into elevations".to_owned());
    let notes = file.note.into_iter().chain(turning).chain(passed_over);
    let notes: Vec<String> = notes.collect();
    Ok(Elevations {
        path,
        points: turned(file.points, downwards || depths),
        plane: if degrees { PointPlane::Degrees } else { PointPlane::of_epsg(file.epsg) },
        blank: file.blank,
        note: (!notes.is_empty()).then(|| notes.join("; ")),
    })
}

/// Removes the points that the file sets aside; returns a remark with their number, if any.
fn take_out_set_aside(file: &mut PointFile) -> Option<String> {
    let before = file.points.len();
    let mut set_aside = file.set_aside.iter();
    file.points.retain(|_| set_aside.next().is_none_or(|is_set_aside| !is_set_aside));
    match before - file.points.len() {
        0 => None,
        1 => Some("1 point that the file sets aside is passed over".to_owned()),
        count => Some(format!("{count} points that the file sets aside are passed over")),
    }
}

/// Returns true if the third column is named a depth and counts downwards.
fn counts_depths(file: &PointFile) -> bool {
    let named = file.names.as_ref();
    let is_depth = named.is_some_and(|[_, _, z]| z.to_ascii_lowercase().contains("depth"));
    let below = file.points.iter().filter(|point| point[2] > 0.0).count();
    is_depth && 2 * below > file.points.len()
}

fn turned(mut points: Vec<[f64; 3]>, downwards: bool) -> Vec<[f64; 3]> {
    for point in points.iter_mut().filter(|_| downwards) {
        point[2] = -point[2];
    }
    points
}

fn of_raster(
    path: &Path,
    names: Option<&[String; 3]>,
    downwards: bool,
) -> Result<Elevations, FaultText> {
    if names.is_some_and(|names| names != &["x", "y", "z"]) {
        return Err("the coordinates of a GeoTIFF are always x, y and z".into());
    }
    let raster = geotiff::read_cells(path).map_err(|error| error.to_string())?;
    let depths = raster.downwards && names.is_none();
    let note =
        depths.then(|| "the raster holds depths, which are turned into elevations".to_owned());
    Ok(Elevations {
        path: path.to_owned(),
        points: turned(raster.points, downwards || depths),
        plane: if raster.is_degrees {
            PointPlane::Degrees
        } else {
            PointPlane::of_epsg(raster.projected.map(u32::from))
        },
        blank: 0,
        note,
    })
}

/// Reads the points of a GeoJSON file (RFC 7946): longitude, latitude, and a height from the third
/// coordinate or a property, which the third of `names` names. Without names, values of depth
/// properties change their sign. Features that are no point, or have no height, are left out.
fn of_geojson(
    path: &Path,
    names: Option<&[String; 3]>,
    downwards: bool,
) -> Result<Elevations, FaultText> {
    let text = regular_file::read(path, LONGEST).map_err(|error| match error.kind() {
        ErrorKind::FileTooLarge => {
            "the GeoJSON is longer than 1 GiB; write the points as CSV".into()
        }
        _ => unreadable(&error),
    })?;
    let root: Value = serde_json::from_slice(&text)
        .map_err(|error| format!("the points are no GeoJSON: {error}"))?;
    let features = root["features"].as_array().ok_or("the GeoJSON is no FeatureCollection")?;
    let height = names.map(|[_, _, height]| height.as_str());
    let points: Vec<[f64; 3]> =
        features.iter().filter_map(|feature| point(feature, height)).collect();
    Ok(Elevations {
        path: path.to_owned(),
        blank: features.len() - points.len(),
        points: turned(points, downwards),
        plane: PointPlane::Degrees,
        note: None,
    })
}

fn point(feature: &Value, height: Option<&str>) -> Option<[f64; 3]> {
    let geometry = &feature["geometry"];
    let at = geometry["coordinates"].as_array().filter(|_| geometry["type"] == "Point")?;
    let coordinate = |axis: usize| at.get(axis)?.as_f64();
    let property = |name: &str| feature["properties"][name].as_f64();
    let known = || {
        KNOWN.iter().find_map(|(name, downwards)| {
            let value = property(name)?;
            Some(if *downwards { -value } else { value })
        })
    };
    let z = match height {
        Some(name) => property(name),
        None => coordinate(2).or_else(known),
    };
    Some([coordinate(0)?, coordinate(1)?, z?])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, columns: &str) -> Elevations {
        try_read(text, columns).unwrap()
    }

    fn try_read(text: &str, columns: &str) -> Result<Elevations, FileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        std::fs::write(&path, text).unwrap();
        let mut argument = path.into_os_string();
        argument.push(columns);
        read_elevations(&argument)
    }

    #[test]
    fn a_file_without_points_is_said_to_be_empty() {
        for (text, words) in [
            ("", "is empty"),
            ("lon,lat,z_m\n", "is empty"),
            ("lon,lat,z_m\n1,,3\n", "none of the 1 lines"),
        ] {
            let refused = try_read(text, "").unwrap_err().to_string();
            assert!(refused.contains(words), "{refused}");
        }
    }

    #[test]
    fn degrees_are_taken_before_metres_of_an_unknown_origin() {
        let found = read("east_m,north_m,lon,lat,z_m\n1,2,-82.1,29.4,-3\n", "");
        assert_eq!((found.plane, found.points[0]), (PointPlane::Degrees, [-82.1, 29.4, -3.0]));
        let found = read("east_m,north_m,lon,lat,z_m\n1,2,-82.1,29.4,-3\n", ":east_m,north_m,z_m");
        assert_eq!((found.plane, found.points[0]), (PointPlane::Metres, [1.0, 2.0, -3.0]));
    }

    #[test]
    fn a_column_that_is_named_a_depth_is_one_unless_it_counts_upwards() {
        let found = read("lon,lat,Depth_m\n1,2,3\n1,3,4\n", "");
        assert_eq!(found.points[0], [1.0, 2.0, -3.0]);
        let note = found.note.unwrap();
        assert!(note.contains("depth") && note.contains("`lat`"), "{note}");
        let upwards = read("lon,lat,Depth_m\n1,2,-3\n1,3,-4\n", "");
        assert_eq!(upwards.points[0], [1.0, 2.0, -3.0]);
        let named = read("lon,lat,Depth_m\n1,2,3\n", ":lon,lat,Depth_m");
        assert_eq!(named.points[0], [1.0, 2.0, 3.0]);
    }

    #[test]
    fn points_that_are_not_kept_are_passed_over() {
        let found = read("x,y,z,kept\n1,2,-3,1\n4,5,-6,0\n7,8,-9,1\n", "");
        assert_eq!(found.points, [[1.0, 2.0, -3.0], [7.0, 8.0, -9.0]]);
        let note = found.note.unwrap();
        assert!(note.starts_with("1 point that"), "{note}");
    }

    #[test]
    fn a_depth_is_turned_and_blank_lines_are_counted() {
        let found = read("x,y,d\n1,2,3\n1,,4\n5,6,\n7,8,9\n", ":x,y,-d");
        assert_eq!(found.points, [[1.0, 2.0, -3.0], [7.0, 8.0, -9.0]]);
        assert_eq!((found.blank, found.note), (2, None));
    }
}
