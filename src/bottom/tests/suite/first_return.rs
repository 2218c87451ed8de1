//! First returns on made pictures, simulated ponds and real recordings.

mod ponds;

use bathyscope_bottom::first_return::{
    FirstReturnSettings, FirstReturns, ImageSettings, Method, Pick, SampleMode, ThresholdIndex,
    detect,
};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{
    Bytes, Encoding, SampleOrder, Side, SidePing, SideScanState, SideSpan, Survey,
};
use bathyscope_test_support as support;

/// A survey of composite rows (port far to near, then starboard near to far) over `far_m` of range
/// on each side.
fn composite(rows: &[Vec<u8>], far_m: f32, depth_m: f32) -> Survey {
    let half = rows[0].len() / 2;
    let span = |row: usize, side: Side| SideSpan {
        file: 0,
        encoding: Encoding::U8,
        order: if side == Side::Port { SampleOrder::FarToNear } else { SampleOrder::NearToFar },
        offset: (row * 2 * half + if side == Side::Port { 0 } else { half }) as u64,
        count: half as u32,
        near_m: 0.0,
        far_m,
    };
    let side_scan = (0..rows.len()).map(|row| SidePing {
        time_s: row as f64 * 0.05,
        depth_m,
        depth_fault: None,
        port: Some(span(row, Side::Port)),
        starboard: Some(span(row, Side::Starboard)),
    });
    Survey {
        side_scan: std::sync::Arc::new(side_scan.collect()),
        side_scan_state: SideScanState::Usable,
        bytes: vec![Bytes::Held(rows.concat().into())],
        ..Survey::default()
    }
}

/// A small generator, so that the pictures are the same on every machine.
struct Noise(u64);

impl Noise {
    fn byte(&mut self) -> u8 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 56) as u8
    }
}

/// Rows of noise up to `water`, and up to `water + bottom` from the edge on.
fn noisy_rows(
    count: usize,
    half: usize,
    edge: impl Fn(usize) -> usize,
    water: u8,
    bottom: u8,
) -> Vec<Vec<u8>> {
    let mut noise = Noise(7);
    (0..count)
        .map(|row| {
            let mut side = |at: usize| {
                let quiet = noise.byte() % water.max(1);
                if at >= edge(row) { quiet + noise.byte() % bottom + bottom / 2 } else { quiet }
            };
            let mut cells: Vec<u8> = (0..half).rev().map(&mut side).collect();
            cells.extend((0..half).map(&mut side));
            cells
        })
        .collect()
}

/// The paper's normalisation and threshold, written down plainly: over the row as stored, middle
/// zero, min-max, first hit.
fn by_definition(
    rows: &[Vec<u8>],
    samples: SampleMode,
    dead: usize,
    level: f64,
) -> Vec<[Option<usize>; 2]> {
    let word = match samples {
        SampleMode::Bytes => 1,
        SampleMode::Words => 4,
    };
    let pictures: Vec<Vec<f64>> = rows
        .iter()
        .map(|row| {
            let middle = row.len() / word / 2;
            row.chunks(word)
                .map(|bytes| match bytes {
                    [byte] => f64::from(*byte),
                    four => f64::from(i32::from_le_bytes(four.try_into().expect("four bytes"))),
                })
                .enumerate()
                .map(|(column, value)| {
                    let outward =
                        if column >= middle { column - middle } else { middle - 1 - column };
                    if outward * word < dead { 0.0 } else { value }
                })
                .collect()
        })
        .collect();
    let lowest = pictures.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    let highest = pictures.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
    pictures
        .iter()
        .map(|row| {
            let middle = row.len() / 2;
            let passes = |value: f64| (value - lowest) / (highest - lowest) >= level;
            let first = dead.div_ceil(word);
            let port = (first..middle).find(|&at| passes(row[middle - 1 - at]));
            let starboard = (first..middle).find(|&at| passes(row[middle + at]));
            [port.map(|at| at * word), starboard.map(|at| at * word)]
        })
        .collect()
}

fn sample(pick: &Pick) -> Option<usize> {
    pick.is_some().then_some(pick.sample as usize)
}

#[test]
fn threshold_is_the_paper_s_for_every_level_and_both_pictures() {
    let rows = noisy_rows(40, 400, |row| 150 + row, 90, 80);
    let survey = composite(&rows, 4.0, f32::NAN);
    for samples in [SampleMode::Bytes, SampleMode::Words] {
        let image = ImageSettings { samples };
        let index =
            ThresholdIndex::build(&survey, &image, 0.5, &Progress::new()).expect("not cancelled");
        for level in [0.05, 0.2, 0.301, 0.5, 0.6, 0.77, 0.99, 1.0] {
            let found = index.detect(&survey, level, 0.15);
            let expected = by_definition(&rows, samples, 50, f64::from(level) - 1e-6);
            for (ping, [port, starboard]) in expected.iter().enumerate() {
                assert_eq!(sample(&found.port[ping]), *port, "{samples:?} {level} port {ping}");
                assert_eq!(
                    sample(&found.starboard[ping]),
                    *starboard,
                    "{samples:?} {level} starboard {ping}"
                );
            }
        }
    }
}

#[test]
fn tracker_follows_a_slope_under_noise() {
    let edge = |row: usize| 300 + row / 2;
    let rows = noisy_rows(300, 800, edge, 60, 90);
    let survey = composite(&rows, 8.0, 3.5);
    let settings = FirstReturnSettings { method: Method::Tracker, ..Default::default() };
    let found = detect(&survey, &ImageSettings::default(), &settings, &Progress::new())
        .expect("not cancelled");
    for side in Side::BOTH {
        for (ping, pick) in found.side(side).iter().enumerate() {
            let off = f64::from(pick.sample) - edge(ping) as f64;
            assert!(off.abs() < 4.0, "{side:?} {ping}: off by {off} samples");
        }
    }
}

#[test]
fn tracker_follows_a_bank_that_the_boat_runs_up() {
    // 15 cm a ping: 33 degrees at 1.8 m a second and eight pings a second.
    let ends = [100, 140];
    let edge = |row: usize| 900 - 15 * (row.clamp(ends[0], ends[1]) - ends[0]);
    let rows = noisy_rows(240, 1000, edge, 60, 90);
    let survey = composite(&rows, 10.0, f32::NAN);
    let settings = FirstReturnSettings { method: Method::Tracker, ..Default::default() };
    let found = detect(&survey, &ImageSettings::default(), &settings, &Progress::new())
        .expect("not cancelled");
    for side in Side::BOTH {
        for (ping, pick) in found.side(side).iter().enumerate() {
            // Where the bank begins and ends, the trend is that of the pings before or behind: up
            // to three pings are off.
            let is_end = ends.iter().any(|end| ping.abs_diff(*end) < 6);
            let off = f64::from(pick.sample) - edge(ping) as f64;
            assert!(off.abs() < if is_end { 45.0 } else { 4.0 }, "{side:?} {ping}: {off} samples");
            assert!(is_end || pick.confidence > 0.6, "{side:?} {ping}: {}", pick.confidence);
        }
    }
}

#[test]
fn words_that_go_negative_are_warned_of() {
    let quiet = noisy_rows(20, 400, |_| 150, 40, 50);
    let loud = noisy_rows(20, 400, |_| 150, 40, 100);
    let words = ImageSettings { samples: SampleMode::Words };
    let settings = FirstReturnSettings { method: Method::Threshold, ..Default::default() };
    for (rows, warnings) in [(quiet, 0), (loud, 1)] {
        let survey = composite(&rows, 4.0, f32::NAN);
        let found = detect(&survey, &words, &settings, &Progress::new()).expect("not cancelled");
        assert_eq!(found.warnings.len(), warnings, "{:?}", found.warnings);
    }
}

#[test]
fn empty_and_silent_surveys_have_no_picks() {
    let silent = composite(&vec![vec![0; 800]; 30], 4.0, f32::NAN);
    let mut none = composite(&[vec![0; 800]], 4.0, f32::NAN);
    none.side_scan = Default::default();
    for method in [Method::Threshold, Method::Tracker] {
        let settings = FirstReturnSettings { method, ..Default::default() };
        for survey in [&silent, &none] {
            let found = detect(survey, &ImageSettings::default(), &settings, &Progress::new());
            let found = found.expect("not cancelled");
            assert_eq!(found.port.len(), survey.side_scan.len());
            assert!(found.port.iter().chain(found.starboard.iter()).all(|pick| !pick.is_some()));
        }
    }
}

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
