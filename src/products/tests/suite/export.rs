//! Files that other programs open, read back; point files of other programs, filtered.

use bathyscope_log::formats::points::{self, PointFormat};
use bathyscope_products::export::kept_points;
use std::fs;
use std::path::{Path, PathBuf};

/// Four points around the origin and one far away.
const POINTS: [[f64; 3]; 5] = [
    [0.0, 0.0, -2.0],
    [0.5, 0.0, -2.25],
    [0.0, 0.5, -2.5],
    [80.0, 0.0, -2.0],
    [0.25, 0.25, -2.125],
];
const KEPT: [bool; 5] = [true, true, true, false, true];

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn read(path: &Path) -> points::PointFile {
    points::read(path, None).unwrap_or_else(|error| panic!("{error}"))
}

fn write(file: &points::PointFile, path: &Path, kept: &[bool]) {
    let format = PointFormat::of(path).expect("a known ending");
    kept_points(path, format, file, kept).expect("written");
}

fn refusal(path: &Path, bytes: &[u8]) -> String {
    fs::write(path, bytes).expect("a written file");
    points::read(path, None).expect_err("a refusal").to_string()
}

#[test]
fn points_survive_every_pair_of_formats() {
    let folder = folder();
    let names = ["a.xyz", "a.csv", "a.ply", "a.las", "a.laz", "a.copc.laz"];
    let first = folder.path().join("first.csv");
    let lines = POINTS.map(|[x, y, z]| format!("{x},{y},{z}\n"));
    fs::write(&first, format!("x,y,z\n{}", lines.concat())).expect("a written file");
    let source = read(&first);
    assert_eq!(source.points, POINTS);
    for from in names {
        let from = folder.path().join(from);
        write(&source, &from, &[true; 5]);
        let file = read(&from);
        assert_eq!(file.points, POINTS, "{}", from.display());
        for to in names {
            let is_old = ["a.las", "a.laz"].iter().any(|old| from.ends_with(old));
            let is_copc = to == "a.copc.laz";
            let to = folder.path().join(format!("kept-{to}"));
            if is_old && is_copc {
                let refused = kept_points(&to, PointFormat::Copc, &file, &KEPT);
                let refused = refused.expect_err("an old format").to_string();
                assert!(refused.contains("these have format 0; write .laz"), "{refused}");
                continue;
            }
            write(&file, &to, &KEPT);
            let kept = read(&to).points;
            let expected: Vec<[f64; 3]> =
                POINTS.into_iter().zip(KEPT).filter_map(|(p, kept)| kept.then_some(p)).collect();
            assert_eq!(kept, expected, "{} to {}", from.display(), to.display());
        }
    }
}

#[test]
fn a_text_file_keeps_its_columns_comments_and_order() {
    let folder = folder();
    let path = folder.path().join("survey.csv");
    let text = "# survey of 2022\nId;Easting;Northing;\"Elevation\";Code\n1;4;5;-1.5;\"a;b\"\n2;6;7;-2.5;c\n";
    fs::write(&path, text).expect("a written file");
    let file = read(&path);
    assert_eq!(file.points, [[4.0, 5.0, -1.5], [6.0, 7.0, -2.5]]);
    let kept = folder.path().join("kept.csv");
    write(&file, &kept, &[true, false]);
    let expected = "# survey of 2022\nId;Easting;Northing;\"Elevation\";Code\n1;4;5;-1.5;\"a;b\"\n";
    assert_eq!(fs::read_to_string(&kept).expect("text"), expected);
    let (file, columns) = points::split_columns("survey.csv:Northing, Easting,Id");
    assert_eq!(file, PathBuf::from("survey.csv"));
    let named = points::read(&path, columns.as_ref()).expect("points");
    assert_eq!(named.points, [[5.0, 4.0, 1.0], [7.0, 6.0, 2.0]]);
}

#[test]
fn a_ply_file_keeps_its_colours() {
    let folder = folder();
    let path = folder.path().join("a.ply");
    let mut bytes = b"ply\nformat binary_big_endian 1.0\nelement vertex 2\nproperty uchar red\nproperty float x\n\
        property short y\nproperty double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n".to_vec();
    for (red, x, y, z) in [(7_u8, 1.5_f32, -2_i16, 3.25_f64), (9, 2.5, 300, -4.0)] {
        bytes.push(red);
        bytes.extend(x.to_be_bytes());
        bytes.extend(y.to_be_bytes());
        bytes.extend(z.to_be_bytes());
    }
    bytes.extend([1, 0, 0, 0, 0]);
    fs::write(&path, &bytes).expect("a written file");
    let file = read(&path);
    assert_eq!(file.points, [[1.5, -2.0, 3.25], [2.5, 300.0, -4.0]]);
    let kept = folder.path().join("kept.ply");
    write(&file, &kept, &[false, true]);
    assert_eq!(read(&kept).points, [[2.5, 300.0, -4.0]]);
    let written = fs::read(&kept).expect("bytes");
    assert_eq!(written[written.len() - 15], 9, "red goes with its point");
    assert!(!String::from_utf8_lossy(&written).contains("face"));
}

#[test]
fn unusable_point_files_are_refused_in_a_sentence() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let text = refusal(&path("a.csv"), b"x,y,z\n1,2,3\n1,two,3\n");
    assert!(text.starts_with("line 3: `two` in column `y` is not a number; mend it"), "{text}");
    let text = refusal(&path("b.xyz"), b"1 2 3\n4 5\n");
    assert!(text.starts_with("line 2: there are 2 fields, and a point is x, y and z"), "{text}");
    let text = refusal(&path("c.ply"), b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
    assert!(text.starts_with("the PLY file ends after 0 of 4000000000 vertices"), "{text}");
    let text = refusal(&path("d.las"), b"LASF but nothing else");
    assert!(text.starts_with("the LAS file cannot be read"), "{text}");
    let text = refusal(&path("e.doc"), b"");
    assert!(text.starts_with("a point file ends in"), "{text}");
    let missing = points::read(&path("none.xyz"), None).expect_err("a refusal").to_string();
    assert!(missing.starts_with("cannot read the points"), "{missing}");
    let unnamed = points::read(&path("a.csv"), Some(&["e", "n", "h"].map(str::to_owned)));
    let unnamed = unnamed.expect_err("a refusal").to_string();
    assert!(
        unnamed.starts_with(
            "there are no columns `e`, `n` and `h`; write FILE:x,y,z with three of x, y, z"
        ),
        "{unnamed}"
    );
}
