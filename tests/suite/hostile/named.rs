//! Tests inputs that once ended Bathyscope, ran for ever, or took more memory than a laptop has;
//! each with the sentence that it ends in.

use super::survives;
use crate::support;
use std::fs;
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn write(folder: &TempDir, name: &str, bytes: impl AsRef<[u8]>) {
    fs::write(folder.path().join(name), bytes).expect("a file");
}

/// Runs a line of arguments that hold no space; gives what it printed on stdout and as its last
/// line on stderr.
fn run(folder: &TempDir, line: &str, code: i32) -> (String, String) {
    let args: Vec<String> = line.split(' ').map(str::to_owned).collect();
    let outcome = survives(folder.path(), &args);
    assert_eq!(outcome.code, Some(code), "{line}: {}", outcome.stderr);
    let last = outcome.stderr.lines().last().unwrap_or_default();
    (outcome.stdout, last.to_owned())
}

fn refused(folder: &TempDir, line: &str, words: &[&str]) {
    let (_, sentence) = run(folder, line, 1);
    for word in words {
        assert!(sentence.contains(word), "{line}: {word} in {sentence}");
    }
}

/// The demo survey as `pond.sl2`.
fn with_pond() -> TempDir {
    let folder = folder();
    fs::copy(support::demo_log(), folder.path().join("pond.sl2")).expect("a log");
    folder
}

#[test]
fn points_that_las_cannot_hold_are_refused_and_far_ones_are_written() {
    let folder = folder();
    let rows = |value: &str| format!("{value},{value},{value}\n").repeat(9);
    write(&folder, "huge.csv", format!("x,y,z\n{}{}", rows("1e300"), rows("1e-300")));
    let filter = |input: &str, output: &str| {
        format!("filter {input} -o {output} --radius 1 --min-neighbors 3")
    };
    refused(&folder, &filter("huge.csv", "kept.laz"), &["1e300 along x", "LAS", "kept.laz"]);
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    run(&folder, &filter("huge.csv", "kept.csv"), 0);
    write(&folder, "far.csv", format!("x,y,z\n{}{}", rows("9000000"), rows("1")));
    run(&folder, &filter("far.csv", "kept.laz"), 0);
    run(&folder, &filter("kept.laz", "again.xyz"), 0);
    let again = fs::read_to_string(folder.path().join("again.xyz")).expect("points");
    let lines: Vec<&str> = again.lines().collect();
    assert_eq!((lines[0], lines[17]), ("9000000 9000000 9000000", "1 1 1"));
}

#[test]
fn a_laz_that_claims_gigabytes_is_refused() {
    let folder = with_pond();
    run(&folder, "process pond.sl2 -o out --no-objects --products cloud", 0);
    let mut laz = fs::read(folder.path().join("out/points/cloud.copc.laz")).expect("points");
    let points = u32::from_le_bytes(laz[96..100].try_into().expect("four bytes")) as usize;
    let record = usize::from(u16::from_le_bytes([laz[105], laz[106]]));
    // Behind the place of the table, the first point and the count comes the size of the first
    // layer.
    let layer = points + 8 + record + 4;
    laz[layer..layer + 4].copy_from_slice(&[0xF0, 0xFF, 0xFF, 0xFF]);
    write(&folder, "claims.laz", laz);
    let filter = "filter claims.laz -o kept.csv --radius 1 --min-neighbors 1";
    refused(&folder, filter, &["beyond their end", "claims.laz"]);
    run(&folder, "filter out/points/cloud.copc.laz -o kept.laz --radius 9 --min-neighbors 1", 0);
}

#[test]
fn absurd_water_and_positions_are_refused_or_left_out_with_their_place() {
    let folder = with_pond();
    let process = |more: &str| format!("process pond.sl2 -o out --no-objects {more}");
    refused(&folder, &process("--set water_level_m=1e9"), &["water_level_m", "10000"]);
    write(&folder, "level.csv", "time,level_m\n1600000000,1\n1700000000,1e9\n");
    refused(&folder, &process("--set water_level.file=level.csv"), &["line 3", "1e9"]);
    let track = |place: &dyn Fn(usize) -> [f64; 2]| {
        let row = |i: usize| {
            let [lon, lat] = place(i);
            format!("{},{lon},{lat}\n", i as f64 * 0.5)
        };
        format!("time,lon,lat\n{}", (0..400).map(row).collect::<String>())
    };
    let near = |i: usize| [10.0 + 1e-5 * i as f64, 50.0];
    let far = |i: usize| [-120.0 + 1e-5 * i as f64, -40.0];
    let tracks: [(&str, String); 3] = [
        ("one.csv", track(&|i| if i == 100 { far(i) } else { near(i) })),
        ("half.csv", track(&|i| if i < 200 { near(i) } else { far(i) })),
        ("round.csv", track(&|i| [-170.0 + 0.8 * i as f64, -80.0 + 0.4 * i as f64])),
    ];
    for (name, text) in tracks {
        write(&folder, name, text);
        let args: Vec<String> =
            process(&format!("--track {name}")).split(' ').map(str::to_owned).collect();
        let outcome = survives(folder.path(), &args);
        assert_eq!(outcome.code, Some(0), "{name}: {}", outcome.stderr);
        assert!(outcome.stderr.contains("hundreds of kilometres"), "{name}: {}", outcome.stderr);
        assert!(name != "one.csv" || outcome.stderr.contains("the position at 50.0 s"));
    }
}

#[test]
fn logs_that_jump_are_processed() {
    let folder = with_pond();
    let sound = fs::read(support::demo_log()).expect("a log");
    for seed in 0..3 {
        let log = super::mutate::jumping_sl2(&mut super::mutate::Random(seed), &sound);
        write(&folder, "jumps.sl2", log);
        // One search is enough: it costs as much as all else.
        let no_objects = (seed > 0).then_some("--no-objects");
        let args = ["process", "jumps.sl2", "-o", "out"].into_iter().chain(no_objects);
        let args: Vec<String> = args.map(str::to_owned).collect();
        let outcome = survives(folder.path(), &args);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    }
}

#[test]
fn a_surface_of_points_on_one_line_is_none() {
    let folder = folder();
    let line = |i: usize| format!("{},{},-3\n", 0.125 * i as f64, 0.25 * i as f64);
    let line: String = (0..40_000).map(line).collect();
    write(&folder, "line.csv", format!("x,y,z\n{line}"));
    write(&folder, "beside.csv", format!("x,y,z\n{line}100,900,-3\n"));
    write(&folder, "measured.csv", format!("x,y,z\n{line}100,210,-4\n"));
    let compare =
        |reference: &str| format!("compare measured.csv {reference} --by surface --max-gap 800");
    refused(&folder, &compare("line.csv"), &["no measured point has a reference"]);
    // All but the ends, where a triangle's long edge or round-off decides.
    let (table, _) = run(&folder, &compare("beside.csv"), 0);
    assert!(table.contains("of 40001 points"), "{table}");
}

#[test]
fn rasters_and_pictures_that_unpack_to_gigabytes_are_refused() {
    let folder = folder();
    write(&folder, "measured.csv", "x,y,z\n1,1,-3\n");
    write(&folder, "zeros.tif", zeros_tif(7000));
    refused(&folder, "compare measured.csv zeros.tif", &["4000000 cells", "coarser", "zeros.tif"]);
    let picture = |width: u32, height: u32, depth: u8, colour: u8| {
        let mut bytes = Vec::new();
        let mut info = png_chunk(
            b"IHDR",
            &[&width.to_be_bytes()[..], &height.to_be_bytes(), &[depth, colour, 0, 0, 0]].concat(),
        );
        let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        let row = 1 + width as usize * usize::from(depth / 8) * if colour == 2 { 3 } else { 1 };
        for _ in 0..height {
            std::io::Write::write_all(&mut packed, &vec![0; row]).expect("memory");
        }
        bytes.extend(b"\x89PNG\r\n\x1a\n");
        bytes.append(&mut info);
        bytes.extend(png_chunk(b"IDAT", &packed.finish().expect("memory")));
        bytes.extend(png_chunk(b"IEND", &[]));
        bytes
    };
    write(&folder, "deep.png", picture(12_000, 12_000, 16, 0));
    refused(&folder, "detect deep.png -o out", &["12000 by 12000", "8 bits", "deep.png"]);
    write(&folder, "wide.png", picture(40_000, 3_000, 8, 2));
    refused(&folder, "detect wide.png -o out", &["40000 by 3000", "pieces"]);
    // What fits is read: of these nothing is left of the limit.
    write(&folder, "large.png", picture(40_000, 2_500, 8, 2));
    run(&folder, "detect large.png -o out", 0);
}

fn png_chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut checksum = flate2::Crc::new();
    checksum.update(name);
    checksum.update(data);
    let length = (data.len() as u32).to_be_bytes();
    [&length[..], name, data, &checksum.sum().to_be_bytes()].concat()
}

/// A GeoTIFF of f32 zeros at a metre a cell, deflated in one strip of 64 rows that all strips
/// share.
fn zeros_tif(side: u32) -> Vec<u8> {
    const ROWS: u32 = 64;
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, &vec![0; (4 * side * ROWS) as usize]).expect("memory");
    let strip = packed.finish().expect("memory");
    let strips = side.div_ceil(ROWS);
    let mut bytes = b"II*\0\0\0\0\0".to_vec();
    let put = |bytes: &mut Vec<u8>, data: &[u8]| {
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        let at = bytes.len() as u32;
        bytes.extend(data);
        at
    };
    let longs = |value: u32| value.to_le_bytes().repeat(strips as usize);
    let doubles =
        |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let at = put(&mut bytes, &strip);
    let offsets = put(&mut bytes, &longs(at));
    let counts = put(&mut bytes, &longs(strip.len() as u32));
    let scale = put(&mut bytes, &doubles(&[1.0, 1.0, 0.0]));
    let tie = put(&mut bytes, &doubles(&[0.0, 0.0, 0.0, 0.0, f64::from(side), 0.0]));
    let entries: [(u16, u16, u32, u32); 12] = [
        (256, 4, 1, side),
        (257, 4, 1, side),
        (258, 3, 1, 32),
        (259, 3, 1, 8),
        (262, 3, 1, 1),
        (273, 4, strips, offsets),
        (277, 3, 1, 1),
        (278, 4, 1, ROWS),
        (279, 4, strips, counts),
        (339, 3, 1, 3),
        (33_550, 12, 3, scale),
        (33_922, 12, 6, tie),
    ];
    let mut directory = (entries.len() as u16).to_le_bytes().to_vec();
    for (tag, kind, count, value) in entries {
        directory.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
        directory.extend([count.to_le_bytes(), value.to_le_bytes()].concat());
    }
    directory.extend([0; 4]);
    let first = put(&mut bytes, &directory);
    bytes[4..8].copy_from_slice(&first.to_le_bytes());
    bytes
}

#[test]
fn models_of_tensors_with_a_thousand_axes_are_refused() {
    let folder = with_pond();
    image::GrayImage::from_fn(64, 64, |x, y| image::Luma([(x * y) as u8]))
        .save(folder.path().join("small.png"))
        .expect("a picture");
    for axes in [33, 1000, 5000] {
        write(&folder, "deep.onnx", onnx_adding(axes));
        let words = [format!("`w` has {axes} axes"), "deep.onnx".to_owned()];
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        refused(&folder, "detect small.png -o out --model deep.onnx", &words);
    }
}

/// A model that adds a number of so many axes to its picture, as protobuf.
fn onnx_adding(axes: usize) -> Vec<u8> {
    let field = |number: u8, data: &[u8]| {
        let mut length = data.len();
        let mut bytes = vec![number << 3 | 2];
        while length >= 0x80 {
            bytes.push(length as u8 | 0x80);
            length >>= 7;
        }
        bytes.push(length as u8);
        bytes.extend(data);
        bytes
    };
    let shape: Vec<u8> = [1, 3, 64, 64].iter().flat_map(|size| field(1, &[0x08, *size])).collect();
    let picture = field(2, &field(1, &[&[0x08, 1][..], &field(2, &shape)].concat()));
    let value = |name: &[u8], kind: &[u8]| [field(1, name), kind.to_vec()].concat();
    let sizes = [0x08, 1].repeat(axes);
    let weight = [sizes, vec![0x10, 1], field(4, &1.0_f32.to_le_bytes()), field(8, b"w")].concat();
    let node = [field(1, b"x"), field(1, b"w"), field(2, b"y"), field(4, b"Add")].concat();
    let graph = [
        field(1, &node),
        field(2, b"g"),
        field(5, &weight),
        field(11, &value(b"x", &picture)),
        field(12, &value(b"y", &field(2, &field(1, &[0x08, 1])))),
    ];
    let version = field(8, &[0x10, 13]);
    [vec![0x08, 8], field(7, &graph.concat()), version].concat()
}

#[test]
fn what_files_hold_reaches_the_terminal_as_text() {
    let folder = folder();
    let mut xtf = bathyscope_test_support::handmade::xtf(40, 1, 3, (-73.6, 42.7), 5.0);
    // The name of the first channel: 16 bytes from the 12th of its description.
    xtf[256 + 12..256 + 28].copy_from_slice(b"\x1b[31mPORT\x07\x1b[2J\0\0");
    write(&folder, "pond.xtf", &xtf);
    let (text, _) = run(&folder, "info pond.xtf", 0);
    assert!(text.contains("\\u{1b}[31mPORT"), "{text}");
    let (json, _) = run(&folder, "info pond.xtf --json", 0);
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let names: Vec<&str> = json["channels"]
        .as_array()
        .expect("channels")
        .iter()
        .filter_map(|channel| channel["recorder_name"].as_str())
        .collect();
    assert!(names.iter().any(|name| name.starts_with("\u{1b}[31mPORT\u{7}")), "{names:?}");

    write(&folder, "mine.toml", format!("draft_m = \"\u{1b}]0;x\u{7}{}\"\n", "A".repeat(900_000)));
    refused(&folder, "process pond.xtf -o out --settings mine.toml", &["mine.toml"]);
    write(&folder, "names.csv", format!("{}\u{1b}[2J,b,c\n1,2,3\n", "x".repeat(100_000)));
    refused(
        &folder,
        "filter names.csv:x,y,z -o out.csv --radius 1 --min-neighbors 1",
        &["`x`", "names.csv"],
    );
    write(&folder, "bad.jpg", [&[0xFF, 0xD8, 0xFF, 0xDB, 0, 4, 1, 2][..], &[0x1B; 300]].concat());
    refused(&folder, "detect bad.jpg -o out", &["bad.jpg"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_whatever_is_written() {
    let folder = folder();
    let mut random = super::mutate::Random(1);
    let rows: String = (0..3000)
        .map(|_| {
            let [x, y, z] = [9999, 9999, 9].map(|limit| random.below(limit));
            format!("{x},{y},{z}\n")
        })
        .collect();
    write(&folder, "points.csv", format!("x,y,z\n{rows}"));
    // A file of a limited size is what a full disk looks like from within.
    let full = |output: &str| {
        let program = crate::support::program();
        let program = program.display();
        let line = format!(
            "ulimit -f 4; trap '' XFSZ; exec '{program}' filter points.csv -o {output} --radius 5000 --min-neighbors 1"
        );
        let outcome = std::process::Command::new("bash")
            .args(["-c", &line])
            .current_dir(folder.path())
            .output();
        let outcome = outcome.expect("a shell");
        let text = String::from_utf8_lossy(&outcome.stderr).into_owned();
        assert_eq!(outcome.status.code(), Some(1), "{text}");
        let last = text.lines().last().unwrap_or_default();
        assert!(last.contains(output) && last.contains("large"), "{text}");
    };
    full("kept.csv");
    full("kept.laz");
    full("kept.las");
    assert!(leftovers(folder.path()).is_empty());
}

#[cfg(target_os = "linux")]
fn leftovers(folder: &std::path::Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| name != "points.csv").collect()
}
