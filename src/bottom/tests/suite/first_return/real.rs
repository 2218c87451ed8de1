//! First returns on real recordings, against what can be known of them without truth.

use bathyscope_bottom::first_return::{FirstReturnSettings, FirstReturns, ImageSettings, detect};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_test_support as support;

fn tracked(file: &str) -> Option<(Survey, FirstReturns)> {
    let path = support::real_data()?.join(file);
    let progress = Progress::new();
    let survey = formats::open(&path, &progress).expect("a readable log");
    let settings = FirstReturnSettings::default();
    let returns = detect(&survey, &ImageSettings::default(), &settings, &progress);
    Some((survey, returns.expect("not cancelled")))
}

fn range_m(survey: &Survey, returns: &FirstReturns, ping: usize, side: Side) -> Option<f64> {
    let span = survey.side_scan.get(ping)?.side(side)?;
    let pick = returns.side(side).get(ping)?;
    pick.is_some().then(|| span.range_m(f64::from(pick.sample)))
}

/// Mean byte from `from_m` to `to_m` beyond the pick, over the ping and two neighbours to each
/// side.
fn brightness(survey: &Survey, ping: usize, side: Side, from_m: f64, to_m: f64) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for ping in ping.saturating_sub(2)..(ping + 3).min(survey.side_scan.len()) {
        let span = survey.side_scan[ping].side(side)?;
        let samples = survey.samples(ping, side)?;
        let index = |metres: f64| (span.sample_at(metres).max(0.0) as usize).min(samples.len());
        for at in index(from_m)..index(to_m) {
            sum += f64::from(samples.get(at));
            count += 1;
        }
    }
    (count > 0).then(|| sum / f64::from(count))
}

/// The line lies on an edge: darker before it (20 cm, and everything from 0.8 m on) than beyond it,
/// on nearly all pings.
#[test]
fn river_line_lies_on_the_bottom_edge_along_the_whole_log() {
    let Some((survey, returns)) = tracked("humminbird-glen-canyon/Rec00001.DAT") else {
        return;
    };
    assert_eq!(survey.side_scan.len(), 3453);
    for side in Side::BOTH {
        let on_edge = (0..survey.side_scan.len()).filter(|&ping| {
            let Some(edge_m) = range_m(&survey, &returns, ping, side) else {
                return false;
            };
            let mean =
                |from_m, to_m| brightness(&survey, ping, side, edge_m + from_m, edge_m + to_m);
            let (Some(beyond), Some(before)) = (mean(0.04, 0.24), mean(-0.28, -0.08)) else {
                return false;
            };
            let water = brightness(&survey, ping, side, 0.8, edge_m - 0.1).unwrap_or(before);
            beyond - before > 20.0 && beyond - water > 20.0
        });
        let share = on_edge.count() as f64 / 3453.0;
        assert!(share > 0.96, "{side:?}: {share:.3} of the pings");
    }
}

/// The line follows boulders that lie before a brighter bottom. Verified in the waterfall: their
/// edges are plain to see.
#[test]
fn river_line_follows_faint_boulders() {
    let Some((survey, returns)) = tracked("humminbird-glen-canyon/Rec00001.DAT") else {
        return;
    };
    for (side, pings, edge_m) in [
        (Side::Port, 1558..1577, 4.60),
        (Side::Port, 1675..1705, 4.95),
        (Side::Port, 659..668, 3.45),
        (Side::Starboard, 812..828, 3.70),
    ] {
        let ranges = pings.clone().filter_map(|ping| range_m(&survey, &returns, ping, side));
        let mut ranges: Vec<f64> = ranges.collect();
        ranges.sort_by(f64::total_cmp);
        let median_m = ranges[ranges.len() / 2];
        // Before, it ran along the ground behind them, 0.5 to 1.3 m farther.
        assert!((median_m - edge_m).abs() < 0.20, "{side:?} {pings:?}: {median_m:.2} m");
    }
}

/// The transcoded log holds the same picture on another grid of samples: the line must be the same
/// in metres.
#[test]
fn transcoded_river_gives_the_same_line() {
    let Some((survey, returns)) = tracked("humminbird-glen-canyon/Rec00001.DAT") else {
        return;
    };
    let Some((other_survey, other_returns)) = tracked("lowrance/glencanyon-transcoded.sl2") else {
        return;
    };
    for side in Side::BOTH {
        let mut apart_m: Vec<f64> = (0..survey.side_scan.len())
            .filter_map(|ping| {
                let one = range_m(&survey, &returns, ping, side)?;
                let other = range_m(&other_survey, &other_returns, ping, side)?;
                Some((one - other).abs())
            })
            .collect();
        apart_m.sort_by(f64::total_cmp);
        let at = |share: f64| apart_m[(share * apart_m.len() as f64) as usize];
        assert!(apart_m.len() > 3400, "{side:?}: {}", apart_m.len());
        println!("{side:?}: median {:.3} m, 90 % {:.3} m", at(0.5), at(0.9));
        assert!(at(0.5) < 0.03 && at(0.9) < 0.15, "{side:?}: {} {}", at(0.5), at(0.9));
    }
}
