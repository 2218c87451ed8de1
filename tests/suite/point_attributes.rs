//! Tests the attributes of a point besides its place: the level of its echo and its slant range, in
//! the cloud, in files and in colours.

use crate::cli::run;
use crate::support::{demo_log, real_data};
use crate::truth::processed;
use crate::window::{app, demo_window, press};
use bathyscope::app::CloudColour;
use bathyscope_bottom::cloud::{CloudPoint, PointSource};

use bathyscope_log::survey::{Side, Survey};
use egui::{Key, Modifiers};
use std::path::{Path, PathBuf};

fn side(point: &CloudPoint) -> Option<Side> {
    match point.source {
        PointSource::DownScan | PointSource::Swath => None,
        PointSource::Port => Some(Side::Port),
        PointSource::Starboard => Some(Side::Starboard),
    }
}

/// The greatest sample of the recording in the 0.2 m beyond a place.
fn level(survey: &Survey, ping: usize, side: Side, sample: f32) -> u8 {
    let span = survey.span(ping, side).expect("a recorded side");
    let mut echoes = Vec::new();
    let samples = survey.samples(ping, side).expect("samples");
    samples.copy_outward(&mut echoes);
    let first = sample as usize;
    let length = (0.2 / span.metres_per_sample()) as usize;
    let beyond = echoes.iter().skip(first).take(length.max(1));
    beyond.copied().max().unwrap_or(0)
}

fn logs() -> Vec<PathBuf> {
    let data = real_data();
    let real = ["lowrance/glencanyon-transcoded.sl2", "xtf/000_1236.xtf"];
    let real = data.iter().flat_map(|data| real.map(|name| data.join(name)));
    std::iter::once(demo_log()).chain(real).collect()
}

#[test]
fn points_know_the_level_of_their_echo_and_their_range() {
    // A cloud of ten million points is no larger than it was.
    assert!(size_of::<CloudPoint>() <= 48, "{}", size_of::<CloudPoint>());
    for log in logs() {
        let (survey, products) = processed(&log);
        let reduction = products.reduction();
        let boats = &products.navigation.pings;
        let mut apart_m: f64 = 0.0;
        for point in products.cloud.points.iter() {
            let range_m = reduction.point_range_m(&survey, point);
            let ping = point.ping as usize;
            match side(point) {
                Some(side) => {
                    assert_eq!(point.level, level(&survey, ping, side, point.sample));
                    let boat = &boats[ping];
                    let across_m = (point.east_m - boat.east_m).hypot(point.north_m - boat.north_m);
                    // A point of the slope lies as far away as its echo came from.
                    apart_m = apart_m.max((across_m.hypot(point.z_m) - range_m).abs());
                }
                None => {
                    assert_eq!(point.level, 0);
                    assert!((range_m + point.z_m).abs() < 1e-6, "{range_m} {point:?}");
                }
            }
        }
        assert!(apart_m < 1e-6, "{apart_m}");
        let scales = products.scales;
        println!("{}: {scales:.2?}", log.display());
        let [low, high] = scales.level.expect("levels");
        assert!(low < high && high <= 255.0);
        let [near_m, far_m] = scales.range_m.expect("ranges");
        assert!(near_m > 0.0 && near_m < far_m);
    }
}

/// Level times 257, source, and slant range of the points of a LAS file.
fn las_points(path: &Path) -> Vec<(u16, u8, f32)> {
    let mut reader = las::Reader::from_path(path).expect("a LAS file");
    let points = reader.read_all().expect("points");
    let points = points.points().map(|point| point.expect("a point"));
    points
        .map(|point| {
            let range_m = point.extra_bytes.last_chunk::<4>().expect("a dimension");
            (point.intensity, point.user_data, f32::from_le_bytes(*range_m))
        })
        .collect()
}

#[test]
fn files_of_points_have_level_and_range_and_plain_las_is_written_where_it_is_asked_for() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let log = demo_log();
    let log = log.to_str().expect("a path");
    let process = ["process", log, "--no-objects", "--products", "cloud", "-o"];
    run(folder, &[&process[..], &["packed"]].concat());
    assert!(!folder.join("packed/points/cloud.las").exists());
    run(folder, &[&process[..], &["out", "--set", "points.las=true"]].concat());
    let points = folder.join("out/points");
    let packed = las_points(&points.join("cloud.copc.laz"));
    let plain = las_points(&points.join("cloud.las"));
    // The points of a COPC file lie in the order of its octree.
    let sorted = |mut points: Vec<(u16, u8, f32)>| {
        points.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        points
    };
    assert_eq!(sorted(packed), sorted(plain.clone()));
    let size = |name: &str| points.join(name).metadata().expect("a file").len();
    let [laz, las] = [size("cloud.copc.laz"), size("cloud.las")];
    println!("LAZ {laz} bytes, LAS {las} bytes, {:.1} times", las as f64 / laz as f64);

    let (survey, products) = processed(&demo_log());
    let reduction = products.reduction();
    let expected: Vec<(u16, u8, f32)> = (products.cloud.points.iter())
        .map(|point| {
            let range_m = reduction.point_range_m(&survey, point) as f32;
            (u16::from(point.level) * 257, point.source as u8, range_m)
        })
        .collect();
    assert_eq!(plain, expected);

    let table = std::fs::read_to_string(points.join("cloud.csv")).expect("a table");
    let mut lines = table.lines();
    assert_eq!(
        lines.next(),
        Some("source,ping,lon,lat,east_m,north_m,z_m,kept,class,level,range_m,fault")
    );
    for (line, point) in lines.zip(products.cloud.points.iter()) {
        let fields: Vec<&str> = line.split(',').collect();
        let level = match side(point) {
            Some(_) => point.level.to_string(),
            None => String::new(),
        };
        assert_eq!(fields[9], level);
        let range_m: f64 = fields[10].parse().expect("a number");
        assert!((range_m - reduction.point_range_m(&survey, point)).abs() < 6e-4);
    }

    let ply = std::fs::read(points.join("cloud.ply")).expect("a PLY file");
    let begin = ply.windows(11).position(|text| text == b"end_header\n").expect("a header") + 11;
    let header = String::from_utf8_lossy(&ply[..begin]);
    assert!(
        header.contains(
            "property uchar intensity\nproperty uchar classification\nproperty float range_m\n"
        ),
        "{header}"
    );
    let vertices = ply[begin..].chunks_exact(24 + 3 + 1 + 1 + 4);
    assert_eq!(vertices.len(), expected.len());
    for (vertex, (level, _, range_m)) in vertices.zip(&expected) {
        assert_eq!(u16::from(vertex[27]) * 257, *level);
        let read_m = f32::from_le_bytes(*vertex.last_chunk::<4>().expect("a float"));
        assert_eq!(read_m, *range_m);
    }
}

#[test]
fn colours_of_points_go_round_by_key_and_a_picture_is_drawn_in_each() {
    let mut window = demo_window();
    let mut seen = vec![app(&window).view.options.cloud.colour];
    press(&mut window, Modifiers::NONE, Key::Num3);
    for _ in 0..4 {
        press(&mut window, Modifiers::SHIFT, Key::C);
        seen.push(app(&window).view.options.cloud.colour);
    }
    // One log: nothing to tell apart by logs.
    let expected = [
        CloudColour::Source,
        CloudColour::Depth,
        CloudColour::Level,
        CloudColour::Range,
        CloudColour::Source,
    ];
    assert_eq!(seen, expected);
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let mut pictures = Vec::new();
    for colours in ["side", "depth", "level", "range", "log"] {
        let name = format!("{colours}.png");
        let snapshot = ["snapshot", "-o", &name, "--view", "cloud", "--size", "300x240"];
        run(folder, &[&snapshot[..], &["--colours", colours]].concat());
        pictures.push(image::open(folder.join(&name)).expect("a picture").to_rgb8());
    }
    for (index, picture) in pictures.iter().enumerate() {
        for other in &pictures[index + 1..] {
            let pairs = picture.pixels().zip(other.pixels());
            let differing = pairs.filter(|(a, b)| a != b).count();
            assert!(differing > 300, "picture {index}: {differing}");
        }
    }
}
