//! Point files as elevations to compare: which plane they lie in, and which way is up.

use super::text_file::{KNOWN_NAMES, Wanted};
use super::{PointFileError, read_wanted, split_columns};
use std::ffi::OsStr;
use std::path::PathBuf;

/// Geographic columns come first: the metres of two surveys may count from different origins.
const GEOGRAPHIC_NAMES: [[&str; 3]; 4] = [
    ["lon", "lat", "z_m"],
    ["lon", "lat", "z"],
    ["longitude", "latitude", "elevation"],
    ["longitude", "latitude", "z"],
];

/// What the first two coordinates of a point are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// Metres (or the file's own units) east and north.
    Metres,
    /// Degrees of longitude and latitude.
    Degrees,
}

/// Points with elevations.
#[derive(Clone, Debug, PartialEq)]
pub struct Elevations {
    /// Which file.
    pub path: PathBuf,
    /// x, y, and z positive up.
    pub points: Vec<[f64; 3]>,
    /// What x and y are.
    pub plane: Plane,
    /// Lines left out because a coordinate is blank.
    pub blank: usize,
    /// What had to be guessed about the file, in one sentence.
    pub note: Option<String>,
}

/// Reads `FILE` or `FILE.csv:x,y,z`; `-z` is a column that counts downwards, a depth. Without names, columns of longitude,
/// latitude and elevation are taken where there are any. Columns named lon or longitude are degrees.
pub fn read_elevations(argument: &OsStr) -> Result<Elevations, PointFileError> {
    let (path, mut names) = split_columns(argument);
    let downwards = names
        .as_mut()
        .is_some_and(|[_, _, z]| match z.strip_prefix('-') {
            Some(name) => {
                *z = name.to_owned();
                true
            }
            None => false,
        });
    let known = [GEOGRAPHIC_NAMES.as_slice(), KNOWN_NAMES.as_slice()].concat();
    let wanted = Wanted {
        named: names.as_ref(),
        known: &known,
        skip_blank: true,
    };
    let file = read_wanted(&path, wanted)?;
    let degrees = file.names.as_ref().is_some_and(|[x, _, _]| {
        ["lon", "longitude"]
            .iter()
            .any(|name| x.eq_ignore_ascii_case(name))
    });
    let mut points = file.points;
    if downwards {
        for point in &mut points {
            point[2] = -point[2];
        }
    }
    Ok(Elevations {
        path,
        points,
        plane: if degrees {
            Plane::Degrees
        } else {
            Plane::Metres
        },
        blank: file.blank,
        note: file.note,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, columns: &str) -> Elevations {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        std::fs::write(&path, text).unwrap();
        let mut argument = path.into_os_string();
        argument.push(columns);
        read_elevations(&argument).unwrap()
    }

    #[test]
    fn degrees_are_taken_before_metres_of_an_unknown_origin() {
        let found = read("east_m,north_m,lon,lat,z_m\n1,2,-82.1,29.4,-3\n", "");
        assert_eq!(
            (found.plane, found.points[0]),
            (Plane::Degrees, [-82.1, 29.4, -3.0])
        );
        let found = read(
            "east_m,north_m,lon,lat,z_m\n1,2,-82.1,29.4,-3\n",
            ":east_m,north_m,z_m",
        );
        assert_eq!(
            (found.plane, found.points[0]),
            (Plane::Metres, [1.0, 2.0, -3.0])
        );
    }

    #[test]
    fn a_depth_is_turned_and_blank_lines_are_counted() {
        let found = read("x,y,d\n1,2,3\n1,,4\n5,6,\n7,8,9\n", ":x,y,-d");
        assert_eq!(found.points, [[1.0, 2.0, -3.0], [7.0, 8.0, -9.0]]);
        assert_eq!((found.blank, found.note), (2, None));
    }
}
