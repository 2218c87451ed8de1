//! First returns against the truth of simulated ponds.

use bathyscope_bottom::first_return::{
    FirstReturnSettings, FirstReturns, ImageSettings, Method, Normalisation, SampleMode, detect,
    track_range,
};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_simulation::{PingTruth, Scene, simulate};

/// A pond with what is true about it.
struct Pond {
    survey: Survey,
    truth: Vec<PingTruth>,
}

impl Pond {
    fn new(scene: &Scene, seed: u64) -> Self {
        let progress = Progress::new();
        let simulated = simulate(scene, seed, &progress).expect("not cancelled");
        let survey = formats::open_bytes("pond.sl2", simulated.sl2_bytes(), &progress);
        let pond = Self { survey: survey.expect("a readable log"), truth: simulated.pings };
        assert_eq!(pond.survey.side_scan.len(), pond.truth.len());
        pond
    }
}

/// Range errors of picks, metres, weed excluded.
#[derive(Default)]
struct Errors {
    of_picks: Vec<f64>,
    without_pick: usize,
}

impl Errors {
    fn add(&mut self, pond: &Pond, returns: &FirstReturns) {
        for side in Side::BOTH {
            for (truth, pick) in pond.truth.iter().zip(returns.side(side)) {
                let side = truth.side(side);
                if side.weed || side.first_return_m.is_nan() {
                    continue;
                }
                if pick.is_some() {
                    let range_m = f64::from(pick.sample) * truth.metres_per_sample;
                    self.of_picks.push(range_m - side.first_return_m);
                } else {
                    self.without_pick += 1;
                }
            }
        }
    }

    fn summary(&self) -> Summary {
        let mut errors = self.of_picks.clone();
        errors.sort_by(f64::total_cmp);
        let median = errors[errors.len() / 2];
        let near: Vec<f64> =
            errors.iter().copied().filter(|error| (error - median).abs() < GROSS_M).collect();
        let bias_m = near.iter().sum::<f64>() / near.len() as f64;
        let mut absolute: Vec<f64> = errors.iter().map(|error| (error - bias_m).abs()).collect();
        absolute.sort_by(f64::total_cmp);
        let count = absolute.len() as f64;
        Summary {
            bias_m,
            mae_m: absolute.iter().sum::<f64>() / count,
            p95_m: absolute[(0.95 * count) as usize],
            gross: absolute.iter().filter(|&&error| error > GROSS_M).count() as f64 / count,
            without_pick: self.without_pick as f64 / (self.without_pick as f64 + count),
        }
    }
}

/// An error that is no longer a matter of precision.
const GROSS_M: f64 = 0.25;

/// Errors after the constant bias (mean of the errors that are not gross) is taken off.
struct Summary {
    bias_m: f64,
    mae_m: f64,
    p95_m: f64,
    gross: f64,
    without_pick: f64,
}

impl std::fmt::Display for Summary {
    fn fmt(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(
            out,
            "bias {:+7.2} cm  MAE {:6.2} cm  p95 {:6.2} cm  gross {:6.2} %  no pick {:6.2} %",
            100.0 * self.bias_m,
            100.0 * self.mae_m,
            100.0 * self.p95_m,
            100.0 * self.gross,
            100.0 * self.without_pick
        )
    }
}

type Kind = (&'static str, fn() -> Scene);

const KINDS: [Kind; 3] =
    [("gentle", Scene::gentle), ("steep", Scene::steep), ("rough", Scene::rough)];

fn detector(
    method: Method,
    samples: SampleMode,
    threshold: f32,
    dead_zone_m: f64,
) -> (ImageSettings, FirstReturnSettings) {
    let settings =
        FirstReturnSettings { method, threshold, dead_zone_m, ..FirstReturnSettings::default() };
    (ImageSettings { samples }, settings)
}

fn measure(
    scene: &Scene,
    seeds: std::ops::Range<u64>,
    detectors: &[(ImageSettings, FirstReturnSettings)],
) -> Vec<Summary> {
    let mut errors: Vec<Errors> = detectors.iter().map(|_| Errors::default()).collect();
    for seed in seeds {
        let pond = Pond::new(scene, seed);
        for ((image, settings), errors) in detectors.iter().zip(&mut errors) {
            let returns = detect(&pond.survey, image, settings, &Progress::new());
            errors.add(&pond, &returns.expect("not cancelled"));
        }
    }
    errors.iter().map(Errors::summary).collect()
}

#[test]
fn tracker_stays_within_a_centimetre_on_ponds_of_every_kind() {
    let tracker = (ImageSettings::default(), FirstReturnSettings::default());
    for (kind, scene) in KINDS {
        let found = &measure(&scene(), 0..2, std::slice::from_ref(&tracker))[0];
        println!("{kind}: {found}");
        assert!(found.mae_m <= 0.010, "{kind}: {found}");
        assert!(found.p95_m <= 0.030, "{kind}: {found}");
        assert!(found.gross <= 0.002, "{kind}: {found}");
        assert!(found.without_pick <= 0.01, "{kind}: {found}");
    }
}

/// The tracker with its defaults.
fn tracked(survey: &Survey) -> FirstReturns {
    let settings = FirstReturnSettings::default();
    detect(survey, &ImageSettings::default(), &settings, &Progress::new()).expect("not cancelled")
}

#[test]
fn part_of_a_log_is_tracked_as_in_the_whole() {
    let pond = Pond::new(&Scene::steep(), 11);
    let whole = tracked(&pond.survey);
    let settings = FirstReturnSettings::default();
    let (image, progress) = (ImageSettings::default(), Progress::new());
    let scale = Normalisation::measure(&pond.survey, &image, settings.dead_zone_m, &progress);
    let scale = scale.expect("not cancelled");
    for pings in [0..1, 0..700, 500..520, 510..1100, 1000..pond.truth.len()] {
        let part = track_range(&pond.survey, &scale, &settings, pings.clone(), &progress);
        let part = part.expect("not cancelled");
        for side in Side::BOTH {
            // Picks hold NaN where there is none, so they are compared as text.
            let (part, whole) = (part.side(side), &whole.side(side)[pings.clone()]);
            assert_eq!(format!("{part:?}"), format!("{whole:?}"), "{side:?} {pings:?}");
        }
    }
}

#[test]
fn missing_and_wrong_depths_do_not_lead_the_tracker_astray() {
    for change in [|_| f32::NAN, |depth_m| 2.1 * depth_m, |depth_m| 0.4 * depth_m] {
        let mut pond = Pond::new(&Scene::gentle(), 3);
        for ping in std::sync::Arc::make_mut(&mut pond.survey.side_scan) {
            ping.depth_m = change(ping.depth_m);
        }
        let mut errors = Errors::default();
        errors.add(&pond, &tracked(&pond.survey));
        let found = errors.summary();
        assert!(found.mae_m <= 0.010 && found.gross <= 0.005, "{found}");
    }
}

#[test]
fn weed_is_flagged_and_open_ground_is_not() {
    let pond = Pond::new(&Scene::gentle(), 5);
    let returns = tracked(&pond.survey);
    let mut flagged = [(0, 0); 2];
    for side in Side::BOTH {
        for (truth, pick) in pond.truth.iter().zip(returns.side(side)) {
            let (above_bottom, all) = &mut flagged[usize::from(truth.side(side).weed)];
            *above_bottom += usize::from(pick.above_bottom);
            *all += 1;
        }
    }
    let share = |(above_bottom, all): (usize, usize)| above_bottom as f64 / f64::from(all as u32);
    assert!(share(flagged[0]) < 0.03, "open ground: {flagged:?}");
    assert!(share(flagged[1]) > 0.6, "weed: {flagged:?}");
}

/// Weed counts: its canopy is not within 25 cm of the ground. `cargo bench -- confidence` prints
/// the shares over many ponds.
#[test]
fn a_sure_first_return_is_right_and_an_unsure_one_seldom() {
    let ways = [
        detector(Method::Tracker, SampleMode::Bytes, 0.30, 0.5),
        // In half a metre the ring-down still reaches the threshold.
        detector(Method::Threshold, SampleMode::Bytes, 0.30, 0.5),
        detector(Method::Threshold, SampleMode::Words, 0.30, 0.815),
    ];
    // Picks and right ones, unsure and sure.
    let mut counts = [[[0_usize; 2]; 2]; 3];
    for (_, scene) in KINDS {
        let pond = Pond::new(&scene(), 201);
        for ((image, settings), counts) in ways.iter().zip(&mut counts) {
            let returns = detect(&pond.survey, image, settings, &Progress::new());
            let returns = returns.expect("not cancelled");
            for side in Side::BOTH {
                for (truth, pick) in pond.truth.iter().zip(returns.side(side)) {
                    let range_m = f64::from(pick.sample) * truth.metres_per_sample;
                    let off_m = (range_m - truth.side(side).first_return_m).abs();
                    let level = match pick.confidence {
                        confidence if confidence >= 0.9 => 1,
                        confidence if confidence < 0.1 => 0,
                        _ => continue,
                    };
                    if off_m.is_finite() {
                        counts[level][0] += 1;
                        counts[level][1] += usize::from(off_m <= 0.25);
                    }
                }
            }
        }
    }
    for [unsure, sure] in counts {
        let share = |[picks, right]: [usize; 2]| right as f64 / picks.max(1) as f64;
        assert!(sure[0] > 2000 && share(sure) >= 0.97, "{counts:?}");
        assert!(unsure[0] > 100 && share(unsure) <= 0.1, "{counts:?}");
    }
    assert!(counts[1][0][0] > 2000, "no ring-down was met: {counts:?}");
}

#[test]
fn the_slider_acts_on_the_tracker() {
    let pond = Pond::new(&Scene::gentle(), 2);
    let found = |threshold| {
        let settings = FirstReturnSettings { threshold, ..FirstReturnSettings::default() };
        let returns = detect(&pond.survey, &ImageSettings::default(), &settings, &Progress::new());
        let returns = returns.expect("not cancelled");
        let sides = Side::BOTH.into_iter().flat_map(|side| returns.side(side));
        sides.filter(|pick| pick.is_some()).count()
    };
    let counts = [0.2, 0.9, 0.97, 1.0].map(found);
    assert!(counts.is_sorted_by(|a, b| a >= b), "{counts:?}");
    // Most bottoms reach the recorder's ceiling somewhere; many do not.
    assert!(20 * counts[3] < 19 * counts[0], "{counts:?}");
}

#[test]
fn a_cancelled_search_stops() {
    let pond = Pond::new(&Scene::gentle(), 2);
    for method in [Method::Threshold, Method::Tracker] {
        let settings = FirstReturnSettings { method, ..FirstReturnSettings::default() };
        let progress = Progress::new();
        progress.cancel();
        assert!(detect(&pond.survey, &ImageSettings::default(), &settings, &progress).is_err());
    }
}

/// The table that the choice of the detector rests on: `cargo
/// test --release -- --ignored --nocapture every_detector`.
/// `FIRST_POND=101` takes other ponds, to develop on.
#[test]
#[ignore = "a table over 60 ponds, minutes long"]
fn every_detector_on_twenty_ponds_of_every_kind() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let first: u64 = number("FIRST_POND").unwrap_or(1);
    let seeds = first..first + number("PONDS").unwrap_or(20);
    let detectors = [
        ("published words 0.30", detector(Method::Threshold, SampleMode::Words, 0.30, 0.82)),
        ("bytes threshold 0.30", detector(Method::Threshold, SampleMode::Bytes, 0.30, 0.5)),
        ("bytes threshold 0.50", detector(Method::Threshold, SampleMode::Bytes, 0.50, 0.5)),
        ("tracker on words 0.30", detector(Method::Tracker, SampleMode::Words, 0.30, 0.82)),
        ("tracker 0.10", detector(Method::Tracker, SampleMode::Bytes, 0.10, 0.5)),
        ("tracker 0.30", detector(Method::Tracker, SampleMode::Bytes, 0.30, 0.5)),
        ("tracker 0.50", detector(Method::Tracker, SampleMode::Bytes, 0.50, 0.5)),
    ];
    let settings: Vec<_> = detectors.iter().map(|(_, settings)| settings.clone()).collect();
    for (kind, scene) in KINDS {
        for ((name, _), found) in detectors.iter().zip(measure(&scene(), seeds.clone(), &settings))
        {
            println!("{kind:7} {name:22} {found}");
        }
    }
}
