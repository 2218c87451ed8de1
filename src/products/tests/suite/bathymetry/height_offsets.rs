//! Height offsets of logs against what scipy makes of the same overlaps (`make_height_offsets.py`).

use crate::Dice;
use bathyscope_bottom::bathymetry::crosslines::TrackDepth;
use bathyscope_bottom::bathymetry::height_offsets::{
    Datum, HeightOffsets, LogOffset, LogOverlap, OverlapKind, adjust, height_offsets,
};
use bathyscope_log::support::progress::Progress;
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    count: usize,
    /// First log, second log, difference and slope.
    #[serde(rename = "meetings")]
    log_overlaps: Vec<(usize, usize, f64, f64)>,
    truth_m: Vec<f64>,
    offsets_m: Vec<f64>,
    errors_m: Vec<f64>,
}

fn cases() -> Vec<Case> {
    serde_json::from_str(include_str!("height_offsets.json")).expect("cases")
}

fn crossing(logs: [usize; 2], difference_m: f64, slope: f64) -> LogOverlap {
    LogOverlap::new(logs, OverlapKind::Crossing, [0.0; 2], difference_m, slope)
}

fn log_overlaps(case: &Case) -> Vec<LogOverlap> {
    let log_overlap =
        |&(first, second, difference_m, slope)| crossing([first, second], difference_m, slope);
    case.log_overlaps.iter().map(log_overlap).collect()
}

#[test]
fn offsets_and_their_errors_are_those_of_scipy() {
    for case in cases() {
        let found = adjust(case.count, &log_overlaps(&case), Datum::Mean);
        assert_eq!(found.groups(), 1);
        let sum_m: f64 = found.logs.iter().map(|log| log.offset_m).sum();
        assert!(sum_m.abs() < 1e-9, "{sum_m}");
        for (index, log) in found.logs.iter().enumerate() {
            let (expected_m, error_m) = (case.offsets_m[index], case.errors_m[index]);
            assert!((log.offset_m - expected_m).abs() < 2e-6, "{index}: {log:?} {expected_m}");
            // Larger only where the pairs disagree by more than their overlaps scatter, which is
            // chance here.
            let share = log.standard_error_m / error_m;
            assert!((0.999..1.3).contains(&share), "{index}: {share}");
            let off_m = (log.offset_m - case.truth_m[index]).abs();
            assert!(off_m < 4.0 * log.standard_error_m, "{index}: {off_m} {log:?}");
        }
        for pair in &found.pairs {
            let [a, b] = pair.logs.map(|log| found.logs[log].offset_m);
            assert!((pair.residual_m - (pair.difference_m - (a - b))).abs() < 1e-12);
        }
    }
}

#[test]
fn the_datum_may_be_one_log_and_differences_stay() {
    for case in cases() {
        let met = log_overlaps(&case);
        let [mean, fixed] =
            [Datum::Mean, Datum::Log(2)].map(|datum| adjust(case.count, &met, datum));
        assert_eq!(fixed.logs[2].offset_m, 0.0);
        assert_eq!(fixed.logs[2].standard_error_m, 0.0);
        let moved_m = mean.logs[2].offset_m;
        for (one, other) in mean.logs.iter().zip(&fixed.logs) {
            assert!((one.offset_m - other.offset_m - moved_m).abs() < 1e-9);
        }
        assert_eq!(mean.pairs.len(), fixed.pairs.len());
    }
}

#[test]
fn what_is_not_connected_is_said() {
    let log_overlap =
        |first, second, difference_m| crossing([first, second], difference_m, f64::NAN);
    // Logs 0 and 3 meet, so do 1 and 4; log 2 meets none, and 5 only on a place without a depth.
    let met = [
        log_overlap(0, 3, 0.2),
        log_overlap(1, 4, -0.5),
        log_overlap(1, 4, -0.5),
        log_overlap(2, 5, f64::NAN),
    ];
    let found = adjust(6, &met, Datum::Log(0));
    let groups: Vec<usize> = found.logs.iter().map(|log| log.group).collect();
    assert_eq!(groups, [0, 1, 2, 0, 1, 3]);
    assert_eq!(found.groups(), 4);
    let offsets: Vec<f64> = found.logs.iter().map(|log| log.offset_m).collect();
    for (found_m, expected_m) in offsets.iter().zip([0.0, -0.25, 0.0, -0.2, 0.25, 0.0]) {
        assert!((found_m - expected_m).abs() < 1e-9, "{offsets:?}");
    }
    assert!(found.logs[2].standard_error_m.is_nan() && found.logs[2].log_overlaps == 0);
    assert!(found.logs[3].standard_error_m > 0.0);
    assert_eq!(adjust(0, &[], Datum::Mean).groups(), 0);
}

#[test]
fn overlaps_that_contradict_each_other_by_metres_determine_no_offset() {
    let log_overlap = |difference_m| crossing([0, 1], difference_m, 0.1);
    let false_depths = [6.1, -5.2, 0.3, 12.0].map(log_overlap);
    let found = adjust(2, &false_depths, Datum::Mean);
    for log in &found.logs {
        assert!(!log.is_determined() && log.offset_m == 0.0, "{log:?}");
        assert_eq!(log.log_overlaps, 4);
    }
    let agreeing = [6.1, 6.2, 6.15, 6.12].map(log_overlap);
    let found = adjust(2, &agreeing, Datum::Mean);
    assert!(found.logs.iter().all(|log| log.is_determined() && log.offset_m.abs() > 3.0));
}

#[test]
fn heights_that_differ_beyond_their_error_are_named_until_they_are_levelled_or_held() {
    let log_overlap = |first, second, difference_m| crossing([first, second], difference_m, 0.02);
    // Elevations of log 1 are 0.35 m above those of log 0, and those of log 2 below.
    let met = [0.349, 0.351, 0.350, 0.348].map(|difference_m| log_overlap(0, 1, difference_m));
    let more = [-0.051, -0.049, -0.050].map(|difference_m| log_overlap(0, 2, difference_m));
    let mut found = adjust(3, &[&met[..], &more].concat(), Datum::Mean);
    let differs = found.unlevelled(&[0.0; 3]).expect("they differ");
    assert_eq!(differs.logs, [2, 1]);
    assert!((differs.difference_m - 0.4).abs() < 0.002, "{differs:?}");
    let applied = |found: &HeightOffsets| -> Vec<f64> {
        found.logs.iter().map(LogOffset::applied_m).collect()
    };
    assert_eq!(found.unlevelled(&applied(&found)), None);
    // Log 1 is held 0.1 m above where it was recorded.
    found = adjust(3, &[&met[..], &more].concat(), Datum::Log(1));
    found.raise(1, 0.1);
    let held = applied(&found);
    assert!((held[1] - 0.1).abs() < 1e-9 && (held[0] - 0.45).abs() < 0.002, "{held:?}");
    assert_eq!(found.unlevelled(&held), None);
    // Half of it is chance where a few centimetres of noise are left.
    let noisy = [0.05, -0.04, 0.06].map(|difference_m| log_overlap(0, 1, difference_m));
    assert_eq!(adjust(2, &noisy, Datum::Mean).unlevelled(&[0.0; 2]), None);
}

/// Position errors of simulated logs: of a whole log, and of each line, metres.
#[derive(Clone, Copy, Debug)]
struct PositionErrors {
    of_log_m: f64,
    of_line_m: f64,
}

/// The logs of a pond, each of parallel lines in a direction of its own, and their true offsets
/// with a mean of zero.
fn simulated(
    logs: usize,
    errors: PositionErrors,
    dice: &mut Dice,
) -> (Vec<Vec<TrackDepth>>, Vec<f64>) {
    let phases: Vec<f64> = (0..3).map(|_| std::f64::consts::TAU * dice.uniform()).collect();
    let bed_m = |[east_m, north_m]: [f64; 2]| {
        let broad = (east_m / 23.0 + phases[0]).sin() * (north_m / 29.0 + phases[1]).cos();
        2.6 + 0.7 * broad + 0.35 * (north_m / 13.0 + phases[2]).sin()
    };
    let raised_m: Vec<f64> = (0..logs).map(|_| dice.normal(0.15)).collect();
    let mean_m = raised_m.iter().sum::<f64>() / logs as f64;
    let truth_m = raised_m.iter().map(|raised_m| mean_m - raised_m).collect();
    let tracks = raised_m.iter().enumerate().map(|(log, raised_m)| {
        let azimuth = log as f64 * std::f64::consts::PI / logs as f64 + dice.uniform();
        let along = [azimuth.sin(), azimuth.cos()];
        let of_log = [0, 1].map(|_| dice.normal(errors.of_log_m));
        let mut depths = Vec::new();
        for line in 0..5 {
            let of_line = [0, 1].map(|_| dice.normal(errors.of_line_m));
            let across_m = 12.0 * f64::from(line - 2) + dice.normal(1.0);
            let turned = if line % 2 == 0 { 1.0 } else { -1.0 };
            for sounding in 0..180 {
                let along_m = turned * (0.45 * f64::from(sounding) - 40.0);
                let place = [
                    along_m * along[0] + across_m * along[1],
                    along_m * along[1] - across_m * along[0],
                ];
                depths.push(TrackDepth {
                    time_s: 60.0 * f64::from(line) + f64::from(sounding) / 6.0,
                    east_m: place[0] + of_log[0] + of_line[0],
                    north_m: place[1] + of_log[1] + of_line[1],
                    depth_m: bed_m(place) - raised_m + dice.normal(0.02),
                });
            }
        }
        depths
    });
    (tracks.collect(), truth_m)
}

#[test]
fn a_stated_standard_error_is_how_far_an_offset_is_from_the_truth() {
    for logs in [2, 3, 4] {
        for (of_log_m, of_line_m) in [(0.0, 0.0), (0.0, 0.3), (0.5, 0.0), (0.3, 0.3)] {
            let errors = PositionErrors { of_log_m, of_line_m };
            let mut dice = Dice(7);
            let mut off_sigmas = Vec::new();
            let mut squares_m2 = 0.0;
            for _ in 0..120 {
                let (tracks, truth_m) = simulated(logs, errors, &mut dice);
                let found =
                    height_offsets(&tracks, Datum::Mean, &Progress::new()).expect("offsets");
                // The offsets of all logs are zero together.
                for (log, truth_m) in found.logs.iter().zip(&truth_m).skip(1) {
                    let off_m = log.offset_m - truth_m;
                    squares_m2 += off_m * off_m;
                    off_sigmas.push((off_m / log.standard_error_m).abs());
                }
            }
            let count = off_sigmas.len() as f64;
            let share =
                |most: f64| off_sigmas.iter().filter(|off| **off < most).count() as f64 / count;
            let (one, two) = (share(1.0), share(2.0));
            println!(
                "{logs} logs, {errors:?}: RMS error {:.4} m, {one:.2} within one standard error, {two:.2} within two",
                (squares_m2 / count).sqrt()
            );
            assert!((0.56..0.85).contains(&one), "{logs} logs, {errors:?}: {one}");
            assert!(two > 0.87, "{logs} logs, {errors:?}: {two}");
        }
    }
}
