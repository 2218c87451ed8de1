//! Points and elevations of other programs.

use super::projects::held_as;
use super::{logs, rasters, say, scratch};
use bathyscope_log::formats::points::{self, PointFormat, read_elevations};
use bathyscope_log::formats::{ReferenceFile, open_reference};
use bathyscope_log::support::progress::Progress;
use std::path::Path;

/// Reads a file as points and as elevations.
fn read(path: &Path) {
    match points::read(path, None) {
        Ok(file) => {
            let flags = file.set_aside.len();
            assert!(flags == 0 || flags == file.points.len());
        }
        Err(error) => say(&error),
    }
    elevations(path);
}

fn elevations(path: &Path) {
    match read_elevations(path.as_os_str()) {
        Ok(file) => assert!(!file.points.is_empty()),
        Err(error) => say(&error),
    }
}

pub(super) fn text(bytes: &[u8]) {
    held_as("points.csv", bytes, read);
}

pub(super) fn text_seeds() -> Vec<Vec<u8>> {
    let texts = [
        "x,y,z\n1,2,-3.5\n1.5,2.5,-3.75\n",
        "# soundings\nlon;lat;depth_m;kept\n-82.11;29.41;3.5;1\n-82.12;29.42;;0\n",
        "1 2 3\n4 5 6\n",
        "Easting\tNorthing\tElevation\n500000.5\t4000000.25\t-1e1\n",
    ];
    texts.map(|text| text.as_bytes().to_vec()).into()
}

pub(super) fn ply(bytes: &[u8]) {
    held_as("points.ply", bytes, read);
}

/// The points of the seeds as files of a format.
fn stored(format: PointFormat, name: &str) -> Vec<u8> {
    let text = b"x,y,z\n1,2,-3.5\n1.5,2.5,-3.75\n2,4,-5\n";
    let points = held_as("points.csv", text, |path| points::read(path, None)).expect("points");
    scratch::written(name, |file| {
        points.write_kept(file, format, &[true; 3]).expect("a point file");
    })
}

pub(super) fn ply_seeds() -> Vec<Vec<u8>> {
    let text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\n\
        element face 0\nproperty list uchar int vertex_indices\nend_header\n1 2 3 4\n5 6 7 8\n";
    vec![stored(PointFormat::Ply, "points.ply"), text.as_bytes().to_vec()]
}

pub(super) fn las(bytes: &[u8]) {
    scratch::with_file("points.las", bytes, read);
}

pub(super) fn las_seeds() -> Vec<Vec<u8>> {
    vec![stored(PointFormat::Las, "points.las")]
}

pub(super) fn laz(bytes: &[u8]) {
    scratch::with_file("points.laz", bytes, read);
}

pub(super) fn laz_seeds() -> Vec<Vec<u8>> {
    vec![stored(PointFormat::Laz, "points.laz"), stored(PointFormat::Copc, "points.copc.laz")]
}

pub(super) fn geojson(bytes: &[u8]) {
    held_as("points.geojson", bytes, elevations);
}

pub(super) fn geojson_seeds() -> Vec<Vec<u8>> {
    let text = r#"{"type":"FeatureCollection","features":[{"type":"Feature","geometry":{"type":"Point","coordinates":[8.5,47.5,-3]},"properties":{}},
        {"type":"Feature","geometry":{"type":"Point","coordinates":[8.6,47.6]},"properties":{"depth_m":4.5,"note":"a"}}]}"#;
    vec![text.as_bytes().to_vec()]
}

/// A reference by its first byte: a table with named columns, a raster, GeoJSON, or a log.
pub(super) fn reference(bytes: &[u8]) {
    const NAMES: [&str; 4] = ["points.csv", "raster.tif", "points.json", "log.sl2"];
    let Some((first, rest)) = bytes.split_first() else {
        return;
    };
    let which = usize::from(*first) % NAMES.len();
    if which == 1 && !rasters::is_small(rest) {
        return;
    }
    scratch::with_file(NAMES[which], rest, |path| {
        let mut argument = path.as_os_str().to_owned();
        if which == 0 {
            argument.push(":x,y,-z");
        }
        match open_reference(&argument, &Progress::new()) {
            Ok(ReferenceFile::Points(elevations)) => assert!(!elevations.points.is_empty()),
            Ok(ReferenceFile::Log(survey)) => assert!(!survey.channels.is_empty()),
            Err(error) => say(&error),
        }
    });
}

pub(super) fn reference_seeds() -> Vec<Vec<u8>> {
    let files = [text_seeds(), rasters::cells_seeds(), geojson_seeds(), logs::sl2_seeds()];
    let with_first = |(which, files): (u8, Vec<Vec<u8>>)| {
        files.into_iter().map(move |file| [vec![which], file].concat())
    };
    (0..).zip(files).flat_map(with_first).collect()
}
