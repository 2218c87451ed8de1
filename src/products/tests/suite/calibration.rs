//! Scales and offsets on surveys whose truth is known, and on the river, of which three containers
//! of one recording must give one cloud.

use crate::truth::{KnownSurvey, processed, results};
use bathyscope_bottom::calibration::{
    Calibration, FlatSpot, PingRange, ScaleMode, calibrate, flat_spots,
};
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointSource, Residuals};
use bathyscope_bottom::first_return::{FirstReturns, Pick};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Projection, Side, Survey, navigate};
use bathyscope_products::pipeline::{self, Preset, Products, Settings};
use bathyscope_simulation::{Artefacts, Scene, Terrace};
use bathyscope_test_support::real_data;
use std::ops::Range;
use std::sync::Arc;

/// A survey whose range does not change.
fn pond(scene: Scene, seed: u64) -> KnownSurvey {
    let artefacts = Artefacts { range_change: 1.0, weed_m: 0.0, ..Artefacts::default() };
    KnownSurvey::new(&Scene { artefacts, ..scene }, seed)
}

/// Returns the first returns of a perfect detector, but `early_m` early.
fn true_returns(pond: &KnownSurvey, early_m: f64) -> FirstReturns {
    let picks = |side: Side| {
        let pings = pond.truth.pings.iter();
        pings
            .map(|ping| Pick {
                sample: ((ping.side(side).first_return_m - early_m) / ping.metres_per_sample)
                    as f32,
                confidence: 1.0,
                above_bottom: false,
            })
            .collect()
    };
    FirstReturns {
        port: Arc::new(picks(Side::Port)),
        starboard: Arc::new(picks(Side::Starboard)),
        ..FirstReturns::default()
    }
}

fn all_picks(returns: &mut FirstReturns) -> impl Iterator<Item = &mut Pick> {
    let sides = [&mut returns.port, &mut returns.starboard];
    sides.into_iter().flat_map(Arc::make_mut)
}

fn calibrated(pond: &KnownSurvey, returns: &FirstReturns, settings: &Settings) -> Calibration {
    let progress = Progress::new();
    let navigation =
        navigate(&pond.survey, &settings.heading, Projection::Enu, &progress).expect("a track");
    let spots = flat_spots(&pond.survey, &navigation, returns, 5, &progress).expect("spots");
    calibrate(&pond.survey, &navigation, returns, &spots, &settings.calibration, &progress)
        .expect("scales")
}

#[test]
fn the_flattest_stretch_lies_on_the_terrace() {
    let scene = Scene::steep();
    let terrace = scene.bed.terrace.clone().expect("a terrace");
    for seed in 0..3 {
        let pond = pond(scene.clone(), seed);
        let spots = ranked(&pond, &true_returns(&pond, 0.0));
        assert!(spots.len() >= 3);
        for (index, spot) in spots.iter().enumerate() {
            let apart = |other: &FlatSpot| {
                other.pings.end <= spot.pings.start || spot.pings.end <= other.pings.start
            };
            assert!(spots[..index].iter().all(apart), "{spots:?}");
        }
        let [x, y] = pond
            .truth
            .frame
            .to_enu(LonLat { lon_deg: scene.longitude_deg, lat_deg: scene.latitude_deg });
        let middle = (spots[0].pings.start + spots[0].pings.end) / 2;
        let at = &pond.truth.pings[middle];
        let (east_m, north_m) = (at.east_m - x - terrace.east_m, at.north_m - y - terrace.north_m);
        assert!(
            east_m.abs() < terrace.length_m / 2.0 + 3.0
                && north_m.abs() < terrace.width_m / 2.0 + 3.0,
            "seed {seed}: {east_m} {north_m} from the middle of the terrace, {:?}",
            spots[0]
        );
        assert!((spots[0].depth_m - terrace.depth_m).abs() < 0.1);
    }
}

#[test]
fn a_flat_spot_gives_the_scale_though_a_third_of_its_picks_ran_into_the_limit() {
    let pond = pond(Scene::gentle(), 1);
    let mut returns = true_returns(&pond, 0.0);
    for (index, pick) in all_picks(&mut returns).enumerate() {
        if index % 3 == 0 {
            pick.sample = 800.0;
        }
    }
    let calibration = calibrated(&pond, &returns, &Settings::preset(Preset::Published));
    assert_eq!(calibration.mode, ScaleMode::FlatSpot);
    let ppd = calibration.ppd().expect("a scale");
    let truth = 1.0 / pond.truth.pings[0].metres_per_sample;
    assert!((ppd.px_per_m / truth - 1.0).abs() < 0.006, "{ppd:?}, truth {truth}");
    let spread = ppd.spread_px_per_m / truth;
    assert!((0.003..0.03).contains(&spread), "3 cm of depth noise in 2.5 m is 1.2 %: {spread}");
    // A slope across the track makes a first return nearer than the bottom below the boat is deep.
    let warnings = &calibration.warnings;
    let of_scale = |warning: &String| warning.starts_with("At the flat stretch");
    assert!(warnings.iter().all(of_scale), "{warnings:?}");
}

#[test]
fn the_lead_of_the_pulse_is_found_on_slopes_too() {
    for (scene, early_m) in
        [(Scene::gentle(), 0.05), (Scene::steep(), 0.05), (Scene::steep(), -0.1)]
    {
        let pond = pond(scene, 2);
        let calibration = calibrated(&pond, &true_returns(&pond, early_m), &Settings::default());
        assert!(
            (calibration.offset_m + early_m).abs() < 0.006,
            "{early_m}: {}",
            calibration.offset_m
        );
        let fit = calibration.fit.expect("a fit");
        assert!((fit.k - 1.0).abs() < 0.05, "{fit:?}");
    }
}

/// Over a level bed the recorded depths vary by their noise alone, which says nothing of a factor
/// between ranges and depths.
#[test]
fn a_level_bed_is_no_objection_to_an_offset() {
    let level = || {
        let mut scene = Scene::gentle();
        scene.bed.terrace = Some(Terrace {
            east_m: 0.0,
            north_m: 0.0,
            length_m: 1000.0,
            width_m: 1000.0,
            depth_m: 2.8,
            edge_m: 1.0,
        });
        scene.bed.bank = None;
        scene
    };
    for (seed, early_m) in [(5, 0.05), (6, 0.03), (7, 0.08), (8, 0.05)] {
        let pond = pond(level(), seed);
        let calibration = calibrated(&pond, &true_returns(&pond, early_m), &Settings::default());
        assert!(
            (calibration.offset_m + early_m).abs() < 0.01,
            "{early_m}: {} {:?} {:?}",
            calibration.offset_m,
            calibration.measured_offset,
            calibration.warnings
        );
    }
}

#[test]
fn scales_that_disagree_are_reported() {
    let pond = KnownSurvey::new(&Scene::gentle(), 3);
    let mut returns = true_returns(&pond, 0.0);
    let calibration = calibrated(&pond, &returns, &Settings::preset(Preset::Published));
    let text = calibration.warnings.join(" ");
    assert!(text.contains("range changes"), "{text}");
    for pick in all_picks(&mut returns) {
        pick.sample *= 1.1;
    }
    let chosen =
        Settings::default().with_assignment("calibration.pings=20..120").expect("a setting");
    let calibration = calibrated(&pond, &returns, &chosen);
    assert_eq!(calibration.flat_spot.map(|spot| spot.pings), Some(20..120));
    let text = calibration.warnings.join(" ");
    assert!(text.contains("cm greater than the soundings"), "{text}");
}

#[test]
fn the_published_preset_returns_its_own_calibration_depth_too_shallow() {
    for seed in 0..3 {
        let pond = pond(Scene::gentle(), seed);
        let settings = Settings::preset(Preset::Published);
        let products = results(&pond.survey, &settings);
        let spot = products.calibration.flat_spot.clone().expect("a flat spot");
        // Every ping of the spot, heading or not, whose pick may calibrate: what is left is the
        // formula alone.
        let mut ratios: Vec<f64> = Vec::new();
        for side in Side::BOTH {
            for ping in spot.pings.clone() {
                let pick = products.returns.side(side)[ping];
                if pick.above_bottom {
                    continue;
                }
                let Products { calibration, returns, .. } = &products;
                let range_m = calibration.first_return_m(&pond.survey, returns, ping, side);
                let bottom_point = bathyscope_bottom::cloud::fixed_bottom_point(
                    settings.cloud.geometry,
                    range_m,
                    settings.cloud.alpha2_deg,
                );
                ratios.push(
                    bottom_point.depth_m / f64::from(pond.survey.side_scan[ping].depth_m) - 1.0,
                );
            }
        }
        ratios.sort_by(f64::total_cmp);
        let percent = 100.0 * ratios[ratios.len() / 2];
        assert!((percent + 3.87).abs() < 0.05, "seed {seed}: {percent} %");
        assert!(products.cloud.points.iter().any(|point| point.source == PointSource::Port));
    }
}

#[test]
fn a_chosen_range_of_pings_is_written_as_a_setting() {
    let range = PingRange::try_from("400..600".to_owned()).expect("a range");
    assert_eq!((range.start, range.end), (400, 600));
    for text in ["600..400", "4", "a..b", "-1..5"] {
        assert!(PingRange::try_from(text.to_owned()).is_err(), "{text}");
    }
}

/// The classes of points, where those of other pings do not count.
fn of_pings(products: &Products, is_meant: impl Fn(u32) -> bool) -> Vec<PointClass> {
    let classed = products.cloud.points.iter().zip(products.classes.iter());
    let class = |(point, class): (&CloudPoint, &PointClass)| {
        if is_meant(point.ping) { *class } else { PointClass::Unclassified }
    };
    classed.map(class).collect()
}

#[test]
fn the_rivers_side_scan_agrees_with_its_depths_where_the_recorder_had_the_bottom() {
    let Some(data) = real_data() else { return };
    let (survey, products) = processed(&data.join("humminbird-glen-canyon/Rec00001.DAT"));
    assert_eq!(products.navigation.zero_heading, 0);
    // Boulders stand on the first half of the river's bed; the sand after them is smooth.
    let sand = of_pings(&products, |ping| (1700..2300).contains(&ping));
    let agreement = |classes: &[PointClass]| {
        bathyscope_bottom::cloud::residuals(&survey, &products.cloud, &products.correction, classes)
            .expect("residuals")
    };
    let (all, sand) = (agreement(&products.classes), agreement(&sand));
    println!("river: all {all:?}, sand {sand:?}");
    // What both sides see of the boulders does not count.
    assert!(all.n > 2000 && all.median_m.abs() < 0.10, "{all:?}");
    assert!(sand.n > 1000 && sand.median_m.abs() < 0.1, "{sand:?}");
}

/// The ranked stretches of a pond for some picks.
fn ranked(pond: &KnownSurvey, returns: &FirstReturns) -> Vec<FlatSpot> {
    let progress = Progress::new();
    let heading = Default::default();
    let navigation = navigate(&pond.survey, &heading, Projection::Enu, &progress).expect("a track");
    flat_spots(&pond.survey, &navigation, returns, 6, &progress).expect("spots")
}

#[test]
fn a_stretch_whose_first_returns_are_flagged_or_scattered_on_one_side_falls_behind() {
    let pond = pond(Scene::gentle(), 4);
    let plain = true_returns(&pond, 0.0);
    let first = ranked(&pond, &plain)[0].clone();
    assert_eq!(first.picks, [first.pings.len(); 2]);
    let spoil: [fn(usize, &mut Pick); 2] = [
        // Two in three are nearer than the margin allows, as over boulders.
        |index, pick| pick.above_bottom = index % 3 != 0,
        |index, pick| pick.sample *= [0.95, 1.05][index % 2],
    ];
    for spoil in spoil {
        for side in Side::BOTH {
            let mut returns = plain.clone();
            let picks = match side {
                Side::Port => &mut returns.port,
                Side::Starboard => &mut returns.starboard,
            };
            for index in first.pings.clone() {
                spoil(index, &mut Arc::make_mut(picks)[index]);
            }
            let best = ranked(&pond, &returns)[0].pings.clone();
            let shared =
                best.end.min(first.pings.end).saturating_sub(best.start.max(first.pings.start));
            assert!(4 * shared < first.pings.len(), "{side:?}: {best:?} for {:?}", first.pings);
        }
    }
}

#[test]
fn a_stretch_tells_its_first_returns() {
    let pond = pond(Scene::steep(), 1);
    let mut returns = true_returns(&pond, 0.05);
    for pick in Arc::make_mut(&mut returns.starboard).iter_mut().step_by(5) {
        pick.above_bottom = true;
    }
    for spot in ranked(&pond, &returns) {
        let mut ratios: Vec<f64> = Vec::new();
        let mut counts = [0; 2];
        for (side, count) in Side::BOTH.into_iter().zip(&mut counts) {
            for ping in spot.pings.clone() {
                let pick = returns.side(side)[ping];
                if !pick.above_bottom {
                    *count += 1;
                    let depth_m = f64::from(pond.survey.side_scan[ping].depth_m);
                    ratios.push(f64::from(pick.sample) / depth_m);
                }
            }
        }
        assert_eq!(spot.picks, counts);
        ratios.sort_by(f64::total_cmp);
        let ppd = spot.ppd.expect("a scale");
        assert_eq!(ppd.picks, ratios.len());
        let near = |share: usize| ratios[ratios.len() * share / 100];
        assert!((near(49)..=near(51)).contains(&ppd.px_per_m), "{ppd:?}");
        // Of noise alike to both sides of the middle, half lies within 0.674 standard deviations.
        let half = (near(75) - near(25)) / 2.0 / 0.6745;
        assert!((0.7..1.4).contains(&(ppd.spread_px_per_m / half)), "{ppd:?}, {half}");
        let factor = spot.factor.expect("a factor");
        let header = 1.0 / pond.truth.pings[0].metres_per_sample;
        assert!((factor * ppd.px_per_m / header - 1.0).abs() < 1e-3, "{factor}");
    }
}

#[test]
fn the_ranking_follows_track_and_picks_only() {
    let pond = pond(Scene::gentle(), 5);
    let run = |assignment: &str, previous: Option<&Products>| {
        let settings = Settings::default().with_assignment(assignment).expect("a setting");
        pipeline::run(&pond.survey, &settings, previous, &Progress::new(), |_| ())
            .expect("products")
    };
    let products = run("projection=enu", None);
    for (assignment, again) in [
        ("calibration.pings=20..120", false),
        ("calibration.mode=flat_spot", false),
        ("cloud.alpha2_deg=10", false),
        ("first_return.above_bottom_margin_m=0.01", true),
        ("heading.source=steps", true),
    ] {
        let changed = run(assignment, Some(&products));
        let kept = Arc::ptr_eq(&changed.flat_spots, &products.flat_spots);
        assert_eq!(!kept, again, "{assignment}");
        let fresh = run(assignment, None);
        assert_eq!(changed.flat_spots, fresh.flat_spots, "{assignment}");
        assert_eq!(changed.calibration, fresh.calibration, "{assignment}");
    }
}

/// Depth errors where the recorder was on another range than at the flat spot: bias and 95th
/// percentile, metres.
fn errors_after_range_change(pond: &KnownSurvey, reach: &str) -> Residuals {
    let settings = Settings::default()
        .with_assignment("calibration.mode=flat_spot")
        .and_then(|settings| settings.with_assignment(reach))
        .expect("settings");
    let mut products = results(&pond.survey, &settings);
    let spot = products.calibration.flat_spot.clone().expect("a flat spot");
    let range_at = |ping: usize| pond.truth.pings[ping].metres_per_sample;
    let there = range_at(spot.pings.start);
    let warned = products.calibration.warnings.join(" ").contains("range changes");
    assert_eq!(warned, reach.ends_with("constant"), "{:?}", products.calibration.warnings);
    let other = of_pings(&products, |ping| (range_at(ping as usize) / there - 1.0).abs() > 0.1);
    products.classes = Arc::new(other);
    Residuals::of(&mut pond.depth_errors_m(&products)).expect("points")
}

#[test]
fn a_flat_spots_scale_survives_a_change_of_range() {
    for (scene, p95_m) in [(Scene::gentle(), 0.06), (Scene::steep(), 0.15), (Scene::rough(), 0.15)]
    {
        for seed in 0..3 {
            let pond = KnownSurvey::new(&scene, seed);
            let factor = errors_after_range_change(&pond, "calibration.ppd=factor");
            let constant = errors_after_range_change(&pond, "calibration.ppd=constant");
            println!("factor {factor:?}\nconstant {constant:?}");
            assert!(factor.n > 100 && factor.p95_m <= p95_m, "seed {seed}: {factor:?}");
            assert!(factor.mean_m.abs() < 0.03, "seed {seed}: {factor:?}");
            // A quarter more metres a sample, or a fifth fewer.
            assert!(constant.mean_m.abs() > 0.25, "seed {seed}: {constant:?}");
        }
    }
}

#[test]
fn the_rivers_best_flat_stretch_lies_on_its_sand() {
    let Some(data) = real_data() else { return };
    let (_, products) = processed(&data.join("humminbird-glen-canyon/Rec00001.DAT"));
    for (rank, spot) in products.flat_spots.iter().enumerate() {
        println!("{rank}: {spot:?}");
    }
    // Boulders before ping 1750; from 2350 on the recorder has lost the bottom.
    let best = &products.flat_spots[0];
    assert!(best.pings.start >= 1800 && best.pings.end <= 2300, "{best:?}");
    assert!(best.picks.iter().all(|&picks| 10 * picks > 8 * best.pings.len()), "{best:?}");
    let ppd = best.ppd.expect("a scale");
    assert!(ppd.spread_px_per_m / ppd.px_per_m < 0.03, "{ppd:?}");
}

/// Calibrated range of the first return, per ping; NaN without one.
fn ranges(survey: &Survey, products: &Products, side: Side) -> Vec<f64> {
    let Products { calibration, returns, .. } = products;
    let pings = 0..survey.side_scan.len();
    pings.map(|ping| calibration.first_return_m(survey, returns, ping, side)).collect()
}

fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share) as usize]
}

#[test]
fn the_transcoded_logs_give_the_recorded_cloud() {
    let Some(data) = real_data() else { return };
    let (survey, products) = processed(&data.join("humminbird-glen-canyon/Rec00001.DAT"));
    assert_eq!(survey.side_scan.len(), 3453);
    for name in ["glencanyon-transcoded.sl2", "glencanyon-transcoded.sl3"] {
        let (other, others) = processed(&data.join("lowrance").join(name));
        assert_eq!(other.side_scan.len(), 3453, "{name}");
        assert_eq!(other.soundings.len(), survey.soundings.len(), "{name}");
        for side in Side::BOTH {
            let pairs = ranges(&survey, &products, side);
            let pairs = pairs.into_iter().zip(ranges(&other, &others, side));
            let mut apart: Vec<f64> =
                pairs.map(|(a, b)| (a - b).abs()).filter(|apart| apart.is_finite()).collect();
            assert!(apart.len() > 3400, "{name} {side:?}: {} pings in both", apart.len());
            // The transcoding resampled 1479 to 1550 samples of 1.9 cm to 1400 of 2.0 cm: half a
            // sample is its limit.
            let (median, p95) = (quantile(&mut apart, 0.5), quantile(&mut apart, 0.95));
            eprintln!("{name} {side:?}: median {median:.3} m, p95 {p95:.3} m apart");
            assert!(median < 0.02, "{name} {side:?}: median {median} m apart");
            assert!(p95 < 0.25, "{name} {side:?}: p95 {p95} m apart");
        }
    }
}

/// Range of the deeper side minus recorded depth over some pings, sorted: on a slope the upper side
/// detects the bank first, and the recorder's own depth is that of the water under the boat.
fn deeper_side_minus_depth(survey: &Survey, products: &Products, pings: Range<usize>) -> Vec<f64> {
    let [port, starboard] = Side::BOTH.map(|side| ranges(survey, products, side));
    let mut apart: Vec<f64> = pings
        .map(|ping| port[ping].max(starboard[ping]) - f64::from(survey.good_depth_m(ping)))
        .filter(|apart| apart.is_finite())
        .collect();
    apart.sort_by(f64::total_cmp);
    apart
}

#[test]
fn the_line_agrees_with_the_recorded_depth() {
    let Some(data) = real_data() else { return };
    let (survey, products) = processed(&data.join("humminbird-glen-canyon/Rec00001.DAT"));
    // The whole log as far as the recorder had the bottom: boulders as tall as the boat is far from
    // them.
    let mut all = deeper_side_minus_depth(&survey, &products, 0..3453);
    eprintln!("whole log: n {}, median {:+.3} m", all.len(), quantile(&mut all, 0.5));
    assert!(all.len() > 2200, "{} pings", all.len());
    assert!(quantile(&mut all, 0.5).abs() < 0.40, "{}", quantile(&mut all, 0.5));
    // Pings 1910 to 2300: smooth sand between the last boulders, at 1852 to 1902 on both sides, and
    // the place where the recorder loses the bottom. It rounds to 0.1 m.
    let mut sand = deeper_side_minus_depth(&survey, &products, 1910..2300);
    let (low, median, high) =
        (quantile(&mut sand, 0.05), quantile(&mut sand, 0.5), quantile(&mut sand, 0.95));
    eprintln!("sand: n {}, {low:+.3} {median:+.3} {high:+.3} m", sand.len());
    assert!(median.abs() < 0.05 && low > -0.20 && high < 0.20, "{low:+.3} {median:+.3} {high:+.3}");
}
