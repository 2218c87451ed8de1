//! Logs whose headers say anything at all, through the whole pipeline: opened, processed, written
//! as every product. What comes out may be empty, but it is whole, holds numbers only, and nothing
//! panics.

use crate::truth::results;
use crate::written;
use bathyscope_bottom::cloud::Geometry;
use bathyscope_bottom::first_return::{Method, SampleMode};
use bathyscope_log::formats::{
    self,
    points::{self, PointFormat},
};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{HeadingSource, Projection, Survey};
use bathyscope_objects::objects::SurveyReview;
use bathyscope_products::export::kept_points;
use bathyscope_products::outputs::Product;
use bathyscope_products::pipeline::{Preset, ProcessedLog, Settings};
use bathyscope_test_support::handmade::{self, Frame};
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Numbers that headers should not hold, among some that they do.
fn wild() -> impl Strategy<Value = f32> {
    prop_oneof![
        3 => prop::sample::select(vec![
            0.0, -0.0, 1.0, -1.0, 5.0, 60.0, 500.0, 1e-30, 1e30, f32::MAX, f32::MIN, f32::NAN,
            f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE,
        ]),
        1 => any::<f32>(),
        1 => 0.0_f32..100.0,
    ]
}

/// Times that stand still, run backwards, jump, and span all that the field can say.
fn times() -> impl Strategy<Value = Vec<i32>> {
    let step = prop_oneof![
        6 => Just(50),
        1 => Just(0),
        1 => -5_000..5_000_i32,
        1 => Just(3_600_000),
        1 => any::<i32>(),
    ];
    prop::collection::vec(step, 0..60).prop_map(|steps| {
        let sum = |at: &mut i32, step: i32| {
            *at = at.wrapping_add(step);
            Some(*at)
        };
        steps.into_iter().scan(0, sum).collect()
    })
}

/// Positions that stand still, that move, at the poles, at the antimeridian (20 million Mercator
/// metres), anywhere.
fn place() -> impl Strategy<Value = (i32, i32)> {
    prop_oneof![
        Just((0, 0)),
        Just((-9_000_000, 3_400_000)),
        Just((i32::MAX, i32::MIN)),
        Just((0, 40_000_000)),
        (19_970_320..19_970_330_i32, -3..3_i32),
        any::<(i32, i32)>(),
    ]
}

#[derive(Clone, Debug)]
struct Ping {
    channel: u16,
    range_ft: (f32, f32),
    depth_ft: f32,
    keel_ft: f32,
    xy_m: (i32, i32),
    heading_rad: f32,
    samples: usize,
    level: u8,
}

/// Mostly sane pings, each field wild now and then.
fn ping() -> impl Strategy<Value = Ping> {
    let range_ft = prop_oneof![
        3 => Just((-60.0, 60.0)),
        1 => Just((0.0, 60.0)),
        1 => (wild(), wild()),
    ];
    (
        prop::sample::select(vec![0_u16, 2, 3, 4, 5, 5, 5, 9]),
        range_ft,
        prop_oneof![3 => 1.0_f32..30.0, 1 => wild()],
        prop_oneof![3 => Just(0.0), 1 => wild()],
        (0..40_i32, 0..40_i32),
        wild(),
        prop_oneof![4 => Just(400_usize), 1 => 0..8_usize],
        any::<u8>(),
    )
        .prop_map(
            |(channel, range_ft, depth_ft, keel_ft, xy_m, heading_rad, samples, level)| Ping {
                channel,
                range_ft,
                depth_ft,
                keel_ft,
                xy_m,
                heading_rad,
                samples,
                level,
            },
        )
}

fn frames() -> impl Strategy<Value = Vec<Frame>> {
    let alike = prop::option::weighted(0.4, prop::sample::select(vec![3_u16, 4, 5]));
    (times(), prop::collection::vec(ping(), 60), place(), alike).prop_map(
        |(times, pings, place, alike)| {
            let frame = |(time_ms, ping): (i32, Ping)| Frame {
                range_ft: ping.range_ft,
                depth_ft: ping.depth_ft,
                keel_ft: ping.keel_ft,
                xy_m: (place.0.wrapping_add(ping.xy_m.0), place.1.wrapping_add(ping.xy_m.1)),
                heading_rad: ping.heading_rad,
                data: (0..ping.samples)
                    .map(|index| (index as u8).wrapping_mul(ping.level))
                    .collect(),
                ..Frame::new(alike.unwrap_or(ping.channel), time_ms)
            };
            times.into_iter().zip(pings).map(frame).collect()
        },
    )
}

fn settings() -> impl Strategy<Value = Settings> {
    let geometry = prop::sample::select(vec![
        Geometry::Published,
        Geometry::SelfConsistent,
        Geometry::Nadir,
        Geometry::Slope,
    ]);
    let source = prop::sample::select(vec![
        HeadingSource::Steps,
        HeadingSource::TrackFit,
        HeadingSource::Cog,
        HeadingSource::Compass,
    ]);
    let preset = prop::sample::select(vec![Preset::Published, Preset::Recommended]);
    (preset, geometry, source, any::<[bool; 3]>(), prop::sample::select(vec![1e-300, 0.5, 1e300]))
        .prop_map(|(preset, geometry, source, [words, tracker, mercator], radius_m)| {
            let mut settings = Settings::preset(preset);
            settings.cloud.geometry = geometry;
            settings.heading.source = source;
            settings.outliers.radius_m = radius_m;
            if words {
                settings.image.samples = SampleMode::Words;
            }
            if tracker {
                settings.first_return.method = Method::Tracker;
            }
            if mercator {
                settings.projection = Projection::Mercator;
            }
            settings
        })
}

/// Bytes written over a log: where (a share of its length) and what.
fn scars() -> impl Strategy<Value = Vec<(f64, [u8; 4])>> {
    let bytes = prop_oneof![
        Just([0; 4]),
        Just([255; 4]),
        wild().prop_map(f32::to_le_bytes),
        any::<[u8; 4]>(),
    ];
    prop::collection::vec((0.0..1.0_f64, bytes), 1..200)
}

fn scarred(mut bytes: Vec<u8>, scars: &[(f64, [u8; 4])]) -> Vec<u8> {
    for (share, scar) in scars {
        let at = (share * bytes.len() as f64) as usize;
        for (byte, &new) in bytes.iter_mut().skip(at).zip(scar) {
            *byte = new;
        }
    }
    bytes
}

/// Runs everything and looks at every product; a log that is refused is refused in one line.
fn process(opened: Result<Survey, formats::OpenError>, settings: &Settings) {
    let survey = match opened {
        Ok(survey) => survey,
        Err(error) => return assert_eq!(error.to_string().lines().count(), 1, "{error}"),
    };
    let products = results(&survey, settings);
    let folder = tempfile::tempdir().expect("a folder");
    let log = ProcessedLog { survey: Arc::new(survey), products };
    let (survey, products) = (&log.survey, &log.products);
    let (logs, review) = (std::slice::from_ref(&log), SurveyReview::default());
    let written = written(logs, &[Product::Cloud], &review, folder.path());
    let rows = |name: &str, columns: usize| {
        let text = fs::read_to_string(folder.path().join(name)).expect("a table");
        for line in text.lines() {
            assert_eq!(line.split(',').count(), columns, "{name}: {line}");
            assert!(!line.contains("NaN") && !line.contains("inf"), "{name}: {line}");
        }
        text.lines().count() - 1
    };
    assert_eq!(rows("points/first_returns.csv", 15), survey.side_scan.len());
    assert_eq!(rows("points/cloud.csv", 12), products.cloud.points.len());
    let all = products.cloud.points.len();
    for name in ["points/cloud.ply", "points/cloud.copc.laz"] {
        if products.kept_points().next().is_none() {
            assert!(!folder.path().join(name).exists(), "{name}");
            continue;
        }
        let points = points::read(&folder.path().join(name), None).expect("points");
        assert_eq!(points.points.len(), all, "{name}");
    }
    assert!(!written.report.summary().contains("NaN"));
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases) }
}

proptest! {
    #![proptest_config(config(400))]

    #[test]
    fn wild_headers_never_stop_the_pipeline(frames in frames(), settings in settings()) {
        let log = handmade::sl2(&frames);
        process(formats::open_bytes("wild.sl2", log, &Progress::new()), &settings);
    }

    #[test]
    fn scarred_logs_never_stop_the_pipeline(kind in 0..4_usize, scars in scars(), settings in settings()) {
        let mut files: Vec<(PathBuf, Vec<u8>)> = match kind {
            0 => vec![("scarred.sl2".into(), handmade::sl2(&handmade::survey_frames(30)))],
            1 => vec![("scarred.sl3".into(), handmade::sl3(&handmade::survey_frames(30), 168))],
            2 => vec![("scarred.xtf".into(), handmade::xtf(30, 2, 3, (-111.5, 36.9), 4.0))],
            _ => handmade::humminbird(40, false, false),
        };
        for (_, bytes) in &mut files {
            *bytes = scarred(std::mem::take(bytes), &scars);
        }
        process(formats::open_files(files, &Progress::new()), &settings);
    }
}

/// The small and the odd, each by name, so that a failure says which.
#[test]
fn odd_logs_are_processed_or_refused() {
    let frame = |ping: i32| Frame::new(5, ping * 50);
    let alone = |channel: u16| (0..40).map(|ping| Frame::new(channel, ping * 50)).collect();
    let still = |ping: i32| Frame { xy_m: (-9_000_000, 3_400_000), ..frame(ping) };
    let backwards = |ping: i32| Frame::new(5, 100_000 - ping * 50);
    let silent = |ping: i32| Frame { data: Vec::new(), ..frame(ping) };
    let odd: [(&str, Vec<Frame>); 10] = [
        ("all at one time", (0..60).flat_map(|_| [Frame::new(0, 0), Frame::new(5, 0)]).collect()),
        ("no ping", Vec::new()),
        ("one ping", vec![frame(0)]),
        ("two pings", vec![frame(0), frame(1)]),
        ("port only", alone(3)),
        ("starboard only", alone(4)),
        ("at rest", (0..40).map(still).collect()),
        ("backwards", (0..40).map(backwards).collect()),
        ("without samples", (0..40).map(silent).collect()),
        (
            "with a gap of a day",
            (0..40).map(|ping| frame(ping % 20 + ping / 20 * 1_728_000)).collect(),
        ),
    ];
    for (name, frames) in odd {
        println!("{name}");
        for preset in [Preset::Published, Preset::Recommended] {
            let log = handmade::sl2(&frames);
            let opened = formats::open_bytes(name, log, &Progress::new());
            process(opened, &Settings::preset(preset));
        }
    }
}

/// Five feet of noise is no picture and no bottom, whatever the preset; a log without side-scan has
/// nothing to say of one.
#[test]
fn noise_and_absence_give_no_side_scan_points() {
    let noise = |ping: i32| Frame { range_ft: (-5.0, 5.0), ..Frame::new(5, ping * 50) };
    let logs: [Vec<Frame>; 2] =
        [(0..40).map(noise).collect(), (0..40).map(|ping| Frame::new(0, ping * 50)).collect()];
    for frames in logs {
        for preset in [Preset::Published, Preset::Recommended] {
            let log = handmade::sl2(&frames);
            let survey = formats::open_bytes("log.sl2", log, &Progress::new()).expect("a log");
            let products = results(&survey, &Settings::preset(preset));
            let pings = survey.side_scan.len();
            assert_eq!(
                (products.returns.port.len(), products.returns.starboard.len()),
                (pings, pings)
            );
            let beside = products.cloud.points.iter().filter(|point| point.sounding().is_none());
            assert_eq!(beside.count(), 0);
            assert!(products.returns.warnings.is_empty(), "{:?}", products.returns.warnings);
        }
    }
}

/// Point files of other programs with damaged heads: read or refused, never worse.
#[test]
fn damaged_point_files_are_read_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = folder.path().join("whole.csv");
    let lines: String = (0..300).map(|i| format!("{i}.5,{},-2.25\n", i % 7)).collect();
    fs::write(&whole, lines).expect("points");
    let source = points::read(&whole, None).expect("points");
    for kind in ["ply", "las", "laz"] {
        let sound = folder.path().join(format!("sound.{kind}"));
        let format = PointFormat::of(&sound).expect("a format");
        kept_points(&sound, format, &source, &[true; 300]).expect("points");
        let sound = fs::read(&sound).expect("points");
        let damaged = folder.path().join(format!("damaged.{kind}"));
        for at in (0..sound.len().min(900)).step_by(5) {
            for wrong in [[0x00; 4], [0xFF; 4], [0xF0, 0x00, 0x00, 0x7F]] {
                let mut bytes = sound.clone();
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&wrong[..end - at]);
                fs::write(&damaged, &bytes).expect("points");
                refused_in_one_line(&damaged);
            }
            fs::write(&damaged, &sound[..at]).expect("points");
            refused_in_one_line(&damaged);
        }
    }
}

fn refused_in_one_line(path: &Path) {
    if let Err(error) = points::read(path, None) {
        assert_eq!(error.to_string().lines().count(), 1, "{error}");
    }
}
