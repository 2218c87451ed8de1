//! Tests which depths count: side-scan where the recorder lost the bottom, first returns by their
//! confidence, and depths above the recorded depth.

use crate::truth::{KnownSurvey, results};
use bathyscope_bottom::cloud::{
    ClassRules, DepthSource, PointClass, PointSource, TrackShare, classify,
};
use bathyscope_bottom::first_return::Method;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::SoundingFault;
use bathyscope_products::pipeline::{self, Preset, Report, Settings};
use bathyscope_simulation::Scene;
use std::sync::Arc;

/// A pond whose recorder loses the bottom in the last quarter.
fn pond_with_lost_bottom() -> KnownSurvey {
    let mut pond = KnownSurvey::new(&Scene::gentle(), 7);
    let pings = Arc::make_mut(&mut pond.survey.side_scan);
    let from = 3 * pings.len() / 4;
    let from_s = pings[from].time_s;
    for ping in &mut pings[from..] {
        ping.depth_fault = Some(SoundingFault::LostBottom);
        ping.depth_m *= 2.3;
    }
    for sounding in Arc::make_mut(&mut pond.survey.soundings) {
        sounding.fault = (sounding.time_s >= from_s).then_some(SoundingFault::LostBottom);
    }
    pond
}

#[test]
fn depth_comes_from_side_scan_where_the_recorder_lost_the_bottom() {
    let pond = pond_with_lost_bottom();
    let products = results(&pond.survey, &Settings::default());
    let depths = &products.depths;
    let from = 3 * depths.len() / 4;
    let of = |source| depths.iter().filter(|depth| depth.source == source).count();
    assert_eq!(of(DepthSource::Sounding), from);
    assert!(of(DepthSource::SideScan) > 95 * (depths.len() - from) / 100);
    let mut off_m: Vec<f64> = depths[from..]
        .iter()
        .zip(&pond.truth.pings[from..])
        .map(|(depth, truth)| (f64::from(depth.depth_m) - truth.depth_m).abs())
        .filter(|off_m| off_m.is_finite())
        .collect();
    off_m.sort_by(f64::total_cmp);
    // Weed and an object are in it.
    assert!(off_m[off_m.len() / 2] < 0.06, "{}", off_m[off_m.len() / 2]);
    assert!(off_m[9 * off_m.len() / 10] < 0.45);

    let share = TrackShare::of(depths, &products.navigation.pings);
    assert_eq!(share.sounding_pings, from);
    assert!(share.track_m > 150.0, "{share:?}");
    assert!((0.2..0.3).contains(&share.side_scan_only()), "{share:?}");
    let report = Report::new(&pond.survey, &products, &Progress::new()).expect("not cancelled");
    assert_eq!(report.track, share);
    assert!(report.summary().contains("comes from side-scan only over"), "{}", report.summary());
}

#[test]
fn points_of_unsure_first_returns_are_not_kept_and_counted() {
    let pond = KnownSurvey::new(&Scene::gentle(), 7);
    let mut settings = Settings::default();
    settings.first_return.method = Method::Threshold;
    let some = results(&pond.survey, &settings);
    let floor = settings.first_return.min_confidence;
    assert!(floor > 0.0);
    let unsure = some.cloud.points.iter().zip(some.classes.iter());
    let unsure = unsure.filter(|(point, _)| point.ground_confidence() < floor);
    assert!(unsure.clone().count() > 100, "no ring-down in half a metre");
    assert!(unsure.clone().all(|(_, class)| !class.is_kept()));
    let report = Report::new(&pond.survey, &some, &Progress::new()).expect("not cancelled");
    assert_eq!(report.counts.low_confidence, unsure.count());
    let counts = &report.counts;
    let lost = counts.classes.count(PointClass::NoBottom);
    let set_aside = counts.low_confidence + counts.outliers_removed + counts.above_bottom_left_out;
    assert_eq!(set_aside + lost, counts.points - counts.kept);
    assert_eq!(some.kept_points().count(), counts.kept);

    // Another floor finds nothing anew.
    settings.first_return.min_confidence = 0.0;
    let all = pipeline::run(&pond.survey, &settings, Some(&some), &Progress::new(), |_| ());
    let all = all.expect("not cancelled");
    assert!(Arc::ptr_eq(&all.cloud, &some.cloud));
    assert!(!all.classes.contains(&PointClass::Unclassified));
    assert!(all.kept_points().count() > some.kept_points().count());
    assert_eq!(Settings::preset(Preset::Published).first_return.min_confidence, 0.0);
}

#[test]
fn what_both_sides_see_above_the_depth_does_not_count_however_long_it_goes_on() {
    let mut scene = Scene::gentle();
    scene.track.lines = 1;
    scene.track.cross_lines = 0;
    scene.track.length_m = 90.0;
    scene.artefacts.weed_m = 0.0;
    scene.scattered_objects = 0;
    let mut pond = KnownSurvey::new(&scene, 9);
    let (long, short) = (60..400, 520..560);
    // The recorder sees the gaps between boulders that give the side-scan its first return.
    let pings = Arc::make_mut(&mut pond.survey.side_scan);
    for ping in long.clone().chain(short.clone()) {
        pings[ping].depth_m += 0.5;
    }
    let products = results(&pond.survey, &Settings::default());
    let settings = Settings::default();
    let usual = settings.class_rules();
    let counted = |pings: std::ops::Range<usize>, rules: ClassRules<'_>| {
        let classes = classify(&products.cloud, &rules, &Progress::new()).expect("not cancelled");
        let points = products.cloud.points.iter().zip(classes);
        let of = points.filter(|(point, _)| {
            point.source != PointSource::DownScan && pings.contains(&(point.ping as usize))
        });
        let (count, counted) = of.fold((0, 0), |(all, counted), (point, class)| {
            assert!(point.is_above_bottom());
            assert!(class.is_kept() || class == PointClass::AboveBottom);
            (all + 1, counted + usize::from(class.is_kept()))
        });
        counted as f64 / count as f64
    };
    for pings in [long, short] {
        assert_eq!(counted(pings.clone(), usual), 0.0, "{pings:?}");
        let all = ClassRules { above_bottom: true, ..usual };
        assert_eq!(counted(pings, all), 1.0);
    }
}

#[test]
fn depths_that_waves_lift_and_lower_differ_where_the_track_crosses_itself_and_that_is_said() {
    let mut pond = KnownSurvey::new(&Scene::demo(), 1);
    let steady = results(&pond.survey, &Settings::default());
    assert!(steady.repeatability.is_some_and(|found| found.n >= 6), "{:?}", steady.repeatability);
    assert_eq!(steady.repeatability_warning(), None);
    for sounding in Arc::make_mut(&mut pond.survey.soundings) {
        sounding.depth_m += 0.15 * (1.6 * sounding.time_s).sin() as f32;
    }
    let said = results(&pond.survey, &Settings::default()).repeatability_warning();
    assert!(said.is_some_and(|said| said.contains("crosses itself") && said.contains("waves")));
}
