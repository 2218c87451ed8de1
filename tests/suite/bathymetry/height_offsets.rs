//! Height offsets of logs against what scipy makes of the same meetings (`make_height_offsets.py`).

use bathyscope::bathymetry::height_offsets::{Datum, Meeting, MeetingKind, adjust};
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    count: usize,
    /// First log, second log, difference and slope.
    meetings: Vec<(usize, usize, f64, f64)>,
    truth_m: Vec<f64>,
    offsets_m: Vec<f64>,
    errors_m: Vec<f64>,
}

fn cases() -> Vec<Case> {
    serde_json::from_str(include_str!("height_offsets.json")).expect("cases")
}

fn meetings(case: &Case) -> Vec<Meeting> {
    let meeting = |&(first, second, difference_m, slope)| Meeting {
        logs: [first, second],
        kind: MeetingKind::Crossing,
        place: [0.0, 0.0],
        difference_m,
        slope,
    };
    case.meetings.iter().map(meeting).collect()
}

#[test]
fn offsets_and_their_errors_are_those_of_scipy() {
    for case in cases() {
        let found = adjust(case.count, &meetings(&case), Datum::Mean);
        assert_eq!(found.groups(), 1);
        let sum_m: f64 = found.logs.iter().map(|log| log.offset_m).sum();
        assert!(sum_m.abs() < 1e-9, "{sum_m}");
        for (index, log) in found.logs.iter().enumerate() {
            let (expected_m, error_m) = (case.offsets_m[index], case.errors_m[index]);
            assert!(
                (log.offset_m - expected_m).abs() < 2e-6,
                "{index}: {log:?} {expected_m}"
            );
            // Larger only where the pairs disagree by more than their meetings scatter, which is chance here.
            let share = log.standard_error_m / error_m;
            assert!((0.999..1.3).contains(&share), "{index}: {share}");
            let off_m = (log.offset_m - case.truth_m[index]).abs();
            assert!(
                off_m < 4.0 * log.standard_error_m,
                "{index}: {off_m} {log:?}"
            );
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
        let met = meetings(&case);
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
    let meeting = |first, second, difference_m| Meeting {
        logs: [first, second],
        kind: MeetingKind::Crossing,
        place: [0.0, 0.0],
        difference_m,
        slope: f64::NAN,
    };
    // Logs 0 and 3 meet, so do 1 and 4; log 2 meets none, and 5 only on a place without a depth.
    let met = [
        meeting(0, 3, 0.2),
        meeting(1, 4, -0.5),
        meeting(1, 4, -0.5),
        meeting(2, 5, f64::NAN),
    ];
    let found = adjust(6, &met, Datum::Log(0));
    let groups: Vec<usize> = found.logs.iter().map(|log| log.group).collect();
    assert_eq!(groups, [0, 1, 2, 0, 1, 3]);
    assert_eq!(found.groups(), 4);
    let offsets: Vec<f64> = found.logs.iter().map(|log| log.offset_m).collect();
    for (found_m, expected_m) in offsets.iter().zip([0.0, -0.25, 0.0, -0.2, 0.25, 0.0]) {
        assert!((found_m - expected_m).abs() < 1e-9, "{offsets:?}");
    }
    assert!(found.logs[2].standard_error_m.is_nan() && found.logs[2].meetings == 0);
    assert!(found.logs[3].standard_error_m > 0.0);
    assert_eq!(adjust(0, &[], Datum::Mean).groups(), 0);
}
