//! Results that are made of a log's tail are those of the whole log, but for what is measured over
//! all of it.

use crate::support::{demo_log, real_data};
use bathyscope_log::formats::{open_bytes, open_growing, open_tail};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Bytes, Side, Survey, SurveyVersions};
use bathyscope_products::pipeline::{GrowingResults, Preset, Products, Settings, extend, run};
use std::path::PathBuf;
use std::sync::Arc;

/// Steps that the rest of the log comes in.
const STEPS: usize = 9;

fn bytes(whole: &[u8], end: usize) -> Vec<(PathBuf, Bytes)> {
    let bytes = Bytes::Held(Arc::new(whole[..end].to_vec()));
    vec![(PathBuf::from("log.sl2"), bytes)]
}

/// The log and its results after it grew from a share on, and those of the whole log.
fn grow(whole: &[u8], share: f64, settings: &Settings) -> [(Survey, Products); 2] {
    let progress = Progress::new();
    let all = |survey: &Survey| run(survey, settings, None, &progress, |_| ()).expect("results");
    let begin = (whole.len() as f64 * share) as usize;
    let mut survey = open_growing(bytes(whole, begin), &progress).expect("a log");
    let mut products = all(&survey);
    let mut results = GrowingResults::measure(&survey, settings, &progress).expect("a scale");
    let mut versions = SurveyVersions::default();
    let settings_of = Arc::new(settings.clone());
    for step in 1..=STEPS {
        let end = begin + (whole.len() - begin) * step / STEPS;
        let seam = survey.seam().expect("a seam");
        let tail = open_tail(&survey, &seam, bytes(whole, end), &progress).expect("a tail");
        survey = survey.extended(tail, &seam, &mut versions).expect("it goes on");
        let unchanged = survey.side_scan.partition_point(|ping| ping.time_s < seam.time_s);
        let made = extend(&survey, unchanged, &products, &settings_of, &mut results, &progress);
        products = made.expect("results");
        assert_eq!(products.navigation.pings.len(), survey.side_scan.len());
        assert_eq!(products.navigation.soundings.len(), survey.soundings.len());
        assert_eq!(products.found.port.len(), survey.side_scan.len());
        assert_eq!(products.depths.len(), survey.side_scan.len());
        assert_eq!(products.classes.len(), products.cloud.points.len());
    }
    let finished = open_bytes("log.sl2", whole.to_vec(), &progress).expect("a log");
    let expected = all(&finished);
    [(survey, products), (finished, expected)]
}

/// Shares of picks, places and points that agree, and how many more points there are than there
/// should be.
fn agreement([(survey, made), (finished, expected)]: &[(Survey, Products); 2]) -> [f64; 4] {
    assert!(format!("{:?}", survey.side_scan) == format!("{:?}", finished.side_scan));
    let pings = finished.side_scan.len();
    let same_pick = |side: Side| {
        let pairs = made.returns.side(side).iter().zip(expected.returns.side(side));
        let same = pairs.enumerate().filter(|(ping, (a, b))| {
            let step_m = finished.span(*ping, side).map_or(0.0, |span| span.metres_per_sample());
            let apart_m = f64::from((a.sample - b.sample).abs()) * step_m;
            (a.sample.is_nan() && b.sample.is_nan()) || apart_m < 0.02
        });
        same.count() as f64 / pings as f64
    };
    let places = made.navigation.pings.iter().zip(expected.navigation.pings.iter());
    let near = places.filter(|(a, b)| {
        (a.east_m - b.east_m).hypot(a.north_m - b.north_m) < 0.05 || a.east_m.is_nan()
    });
    let count = |products: &Products| products.kept_points().count() as f64;
    [
        same_pick(Side::Port),
        same_pick(Side::Starboard),
        near.count() as f64 / pings as f64,
        count(made) / count(expected) - 1.0,
    ]
}

fn assert_agrees(name: &str, figures: [f64; 4]) {
    let [port, starboard, near, more] = figures;
    eprintln!(
        "{name}: picks within 2 cm {:.2} % and {:.2} %, places within 5 cm {:.2} %, {:+.2} % kept points",
        100.0 * port,
        100.0 * starboard,
        100.0 * near,
        100.0 * more
    );
    // Results of a tail are provisional: the tracker sees no pings behind them, and scale and
    // stretches are those of a shorter log. What the whole log gives in the end is held to the byte
    // elsewhere.
    assert!(port > 0.98 && starboard > 0.98, "picks of {name}");
    assert!(near > 0.99, "places of {name}");
    assert!(more.abs() < 0.05, "points of {name}");
}

#[test]
fn results_of_the_tail_agree_with_those_of_the_whole_log() {
    let demo = std::fs::read(demo_log()).expect("the demo");
    for preset in [Preset::Recommended, Preset::Published] {
        let mut settings = Settings::preset(preset);
        // Excluded stretches are found anew over all pings.
        settings.excluded.max_turn_deg_s = Some(8.0);
        let both = grow(&demo, 0.5, &settings);
        assert_agrees(&format!("the demo, {}", preset.name()), agreement(&both));
        let [(_, made), (_, expected)] = &both;
        let ends = |products: &Products| products.exclusions.stretches.len();
        assert!(ends(made).abs_diff(ends(expected)) <= 1);
        let points = made.cloud.points.iter().map(|point| (point.source, point.ping));
        assert!(points.is_sorted(), "the order of the cloud");
    }
}

#[test]
fn results_of_the_tail_of_a_real_recording_agree_with_those_of_the_whole_log() {
    let Some(data) = real_data() else {
        return;
    };
    let path = data.join("lowrance/glencanyon-transcoded.sl2");
    let whole = std::fs::read(path).expect("a recording");
    let both = grow(&whole, 0.6, &Settings::default());
    assert_agrees("the river", agreement(&both));
}
