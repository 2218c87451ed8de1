//! Each point has one class: the map, every file of points, the report and its page count them
//! alike.

use crate::truth::{KnownSurvey, results};
use crate::written;
use bathyscope_bottom::cloud::{ClassCounts, PointClass, PointSource};
use bathyscope_bottom::presentation::text::typeset_count;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::SoundingFault;
use bathyscope_objects::objects::SurveyReview;
use bathyscope_products::outputs::Product;
use bathyscope_products::pipeline::{Derived, Preset, ProcessedLog, Settings, joint_depth_points};
use bathyscope_simulation::Scene;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// Points by the code of their class.
type Counted = BTreeMap<u8, usize>;

/// A pond with weed, where the recorder once lost the bottom, processed.
fn pond(settings: &Settings) -> (KnownSurvey, ProcessedLog) {
    let mut scene = Scene::gentle();
    scene.track.lines = 3;
    scene.track.length_m = 60.0;
    scene.artefacts.weed_m = 12.0;
    let mut pond = KnownSurvey::new(&scene, 6);
    for sounding in &mut Arc::make_mut(&mut pond.survey.soundings)[20..40] {
        sounding.fault = Some(SoundingFault::LostBottom);
    }
    let products = results(&pond.survey, settings);
    let log = ProcessedLog { survey: Arc::new(pond.survey.clone()), products };
    (pond, log)
}

fn counted(codes: impl Iterator<Item = u8>) -> Counted {
    let mut counts = Counted::new();
    codes.for_each(|code| *counts.entry(code).or_default() += 1);
    counts
}

/// Classes of `cloud.csv`, where `kept` says the same.
fn of_table(path: &Path) -> Counted {
    let text = fs::read_to_string(path).expect("a table");
    counted(text.lines().skip(1).map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        let code: u8 = fields[8].parse().expect("a class");
        assert_eq!(fields[7] == "1", code == 40, "{line}");
        code
    }))
}

/// Classes of a LAS file, whose header names them; those that do not count are withheld.
fn of_las(path: &Path) -> Counted {
    let mut reader = las::Reader::from_path(path).expect("a LAS file");
    let names = reader.header().vlrs().iter();
    let names = names.filter(|vlr| vlr.user_id == "LASF_Spec" && vlr.record_id == 0);
    let names = names.map(|vlr| vlr.data.clone()).next().expect("names");
    assert_eq!(&names[64 * 16..][..13], b"\x40above bottom");
    let points = reader.read_all().expect("points");
    counted(points.points().map(|point| {
        let point = point.expect("a point");
        let code = u8::from(point.classification);
        assert_eq!(point.is_withheld, code != 40);
        code
    }))
}

/// Classes of `cloud.ply`.
fn of_ply(path: &Path) -> Counted {
    const VERTEX: usize = 24 + 3 + 1 + 1 + 4;
    let bytes = fs::read(path).expect("a PLY file");
    let end = b"end_header\n";
    let begin = bytes.windows(end.len()).position(|text| text == end);
    let vertices = &bytes[begin.expect("a header") + end.len()..];
    counted(vertices.chunks_exact(VERTEX).map(|vertex| vertex[28]))
}

#[test]
fn every_file_counts_points_alike_and_weed_is_not_kept() {
    let mut settings = Settings::default();
    settings.first_return.min_confidence = 0.79;
    settings.outliers.radius_m = 0.25;
    settings.outliers.min_neighbors = 5;
    let (pond, log) = pond(&settings);
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path().join("out");
    let logs = std::slice::from_ref(&log);
    let requested = [Product::Cloud, Product::Depth, Product::Report];
    let written = written(logs, &requested, &SurveyReview::default(), &folder);

    let products = &log.products;
    let classes = counted(products.classes.iter().map(|class| class.code()));
    println!("{classes:?}");
    for class in [7, 18, 40, 45, 64, 1] {
        assert!(classes.contains_key(&class), "no point of {class}");
    }
    let points = folder.join("points");
    assert_eq!(of_table(&points.join("cloud.csv")), classes);
    assert_eq!(of_las(&points.join("cloud.copc.laz")), classes);
    assert_eq!(of_ply(&points.join("cloud.ply")), classes);
    let xyz = fs::read_to_string(points.join("cloud.xyz")).expect("lines");
    let kept = classes[&40];
    assert_eq!(xyz.lines().count(), kept);
    let record = serde_json::to_value(&written.report).expect("JSON");
    let counts = &record["counts"];
    let of_report: Counted =
        serde_json::from_value(counts["classes"].clone()).expect("points by class");
    assert_eq!(of_report, classes);
    assert_eq!(counts["kept"], kept);
    let said = format!("{kept} count for the depth map");
    let summary = written.report.summary();
    assert!(summary.contains(&said), "{said}: {summary}");
    let page = fs::read_to_string(folder.join("report.html")).expect("a page");
    let said = format!("of which {} count for the depth map", typeset_count(kept));
    assert!(page.contains(&said), "{said}");
    let progress = Progress::new();
    let map = Derived::default().depth_map(logs, &progress);
    let map = map.expect("not cancelled").expect("a depth map").map.clone();
    let mapped = joint_depth_points(logs, &map, &progress).expect("not cancelled");
    assert_eq!(mapped.len(), kept);

    // Of what lies a quarter of a metre above the bed in weed, next to nothing counts.
    let in_weed = products.cloud.points.iter().zip(products.classes.iter());
    let in_weed = in_weed.filter(|(point, _)| {
        let truth = &pond.truth.pings[point.ping as usize];
        let side = match point.source {
            PointSource::DownScan | PointSource::Swath => return false,
            PointSource::Port => truth.side(bathyscope_log::survey::Side::Port),
            PointSource::Starboard => truth.side(bathyscope_log::survey::Side::Starboard),
        };
        let bed_m = pond.truth.bed_depth_m(point.east_m, point.north_m);
        side.weed && bed_m + point.z_m > 0.25
    });
    let in_weed: Vec<bool> = in_weed.map(|(_, class)| class.is_kept()).collect();
    let kept_in_weed = in_weed.iter().filter(|kept| **kept).count();
    println!("weed: {kept_in_weed} of {} kept", in_weed.len());
    assert!(in_weed.len() > 100 && 20 * kept_in_weed < in_weed.len());
}

#[test]
fn by_the_papers_settings_the_outlier_filter_alone_takes_points_out() {
    let settings = Settings::preset(Preset::Published);
    let (_, log) = pond(&settings);
    let ProcessedLog { products, .. } = &log;
    let is_expected = |class: &PointClass| {
        matches!(class, PointClass::Bottom | PointClass::LowNoise | PointClass::HighNoise)
    };
    assert!(products.classes.iter().all(is_expected));
    let flagged = products.kept_points().filter(|point| point.is_above_bottom());
    assert!(flagged.count() > 0, "weed counts");
    let counts = ClassCounts::of(&products.cloud, &products.classes);
    assert_eq!(counts.kept() + counts.noise(), counts.all());
    // What counts is part of the preset.
    assert_eq!(settings.matching_preset(), Some(Preset::Published));
    let without = settings.with_assignment("surface.above_bottom=false");
    assert_eq!(without.expect("a setting").matching_preset(), None);
    let coarser = settings.with_assignment("surface.cell_m=2");
    let coarser = coarser.expect("a setting").matching_preset();
    assert_eq!(coarser, Some(Preset::Published));
}
