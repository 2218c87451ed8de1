//! Tests that the constant that is taken off the ranges is the true one, on logs of any range,
//! depth, pulse and sounding.

use crate::Dice;
use crate::truth::KnownSurvey;
use bathyscope_bottom::calibration::{Calibration, calibrate};
use bathyscope_bottom::first_return::{FirstReturns, detect};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Projection, RangeSource, Side, Survey, navigate};
use bathyscope_products::pipeline::Settings;
use bathyscope_simulation::{
    Artefacts, BedKind, BedSettings, Curve, RecorderSettings, Scene, TrackSettings,
};
use std::sync::Arc;

/// Largest error of an offset in force, metres.
const WITHIN_M: f64 = 0.05;

/// Kind of the log's soundings.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Soundings {
    /// Soundings of the bottom under the boat.
    Right,
    /// Soundings of the bottom, with a draft that the log does not state, metres.
    Draft(f64),
    /// There are none.
    Absent,
    /// Soundings of something else: the recorded depth is that of the bottom times this factor.
    Scaled(f64),
    /// Soundings of a wreck under the second half of the line: its depth is that of the bottom
    /// times this factor.
    Wreck(f64),
}

/// A short line over a bed of any kind, by any recorder.
fn scene(index: u64) -> (Scene, Soundings) {
    let mut dice = Dice(index.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 77);
    dice.uniform();
    let range_m = 10.0 * 10_f64.powf(dice.uniform());
    let depth_m = range_m * dice.between(0.12, 0.5);
    let soundings = match index % 6 {
        0 | 1 => Soundings::Right,
        2 => Soundings::Draft(dice.of(&[0.1, 0.2, 0.5, -0.3])),
        3 => Soundings::Absent,
        4 => Soundings::Scaled(dice.of(&[1.0 / 1.37, 1.37, 0.9, 1.06, 0.97])),
        _ => Soundings::Wreck(dice.of(&[0.5, 0.8, 0.95])),
    };
    let [depth_scale, depth_offset_m] = match soundings {
        Soundings::Scaled(scale) => [scale, 0.0],
        Soundings::Draft(draft_m) => [1.0, draft_m],
        _ => [1.0, 0.0],
    };
    // Deep water is surveyed with lower frequencies and more power.
    let noise = (2.6 / depth_m).powi(4).min(1.0);
    let scene = Scene {
        bed: BedSettings {
            kind: dice.of(&[BedKind::Gentle, BedKind::Gentle, BedKind::Steep, BedKind::Rough]),
            mean_depth_m: depth_m,
            terrace: None,
            ..BedSettings::default()
        },
        track: TrackSettings {
            lines: 1,
            cross_lines: 0,
            length_m: dice.between(20.0, 60.0),
            ..TrackSettings::default()
        },
        duration_s: Some(9.0),
        recorder: RecorderSettings {
            range_m,
            samples_per_side: dice.of(&[700, 1000, 1400, 2000]),
            pulse_m: dice.between(0.008, 0.05),
            range_offset_m: dice.of(&[0.0, 0.0, 0.04, -0.04]),
            bytes_per_db: dice.between(1.8, 3.2),
            curve: dice.of(&[Curve::Decibel, Curve::Decibel, Curve::Amplitude]),
            tvg_limit_m: 0.6 * range_m,
            absorption_db_per_km: 45.6 * (2.6 / depth_m).min(1.0),
            electronic_noise: 4e-11 * noise,
            volume_noise: 6e-11 * noise,
            ..RecorderSettings::default()
        },
        artefacts: Artefacts {
            depth_scale,
            depth_offset_m,
            depth_noise_m: 0.01 + 0.003 * depth_m,
            range_change: 1.0,
            weed_m: 0.0,
            ..Artefacts::default()
        },
        scattered_objects: 0,
        ..Scene::default()
    };
    scene.check().expect("a scene");
    (scene, soundings)
}

/// The log as it is processed.
fn survey(pond: &KnownSurvey, soundings: Soundings) -> Survey {
    let mut survey = pond.survey.clone();
    let half_s = 0.5 * pond.truth.pings.last().map_or(0.0, |ping| ping.time_s);
    let recorded = |time_s: f64, depth_m: f32| match soundings {
        Soundings::Absent => f32::NAN,
        Soundings::Wreck(share) if time_s > half_s => share as f32 * depth_m,
        _ => depth_m,
    };
    let depths = Arc::make_mut(&mut survey.soundings);
    for sounding in &mut *depths {
        sounding.depth_m = recorded(sounding.time_s, sounding.depth_m);
    }
    depths.retain(|sounding| sounding.depth_m > 0.0);
    for ping in Arc::make_mut(&mut survey.side_scan) {
        ping.depth_m = recorded(ping.time_s, ping.depth_m);
    }
    survey
}

fn calibrated(survey: &Survey, settings: &Settings) -> (FirstReturns, Calibration) {
    let progress = Progress::new();
    let navigation =
        navigate(survey, &settings.heading, Projection::Enu, &progress).expect("a track");
    let returns =
        detect(survey, &settings.image, &settings.first_return, &progress).expect("picks");
    let how = &settings.calibration;
    let found = calibrate(survey, &navigation, &returns, &[], how, &progress).expect("scales");
    (returns, found)
}

/// Median of the picks' recorded ranges less the true ones, metres.
fn true_offset_m(pond: &KnownSurvey, survey: &Survey, returns: &FirstReturns) -> f64 {
    let mut leads: Vec<f64> = Vec::new();
    for (ping, truth) in pond.truth.pings.iter().enumerate() {
        for side in Side::BOTH {
            let pick = returns.side(side)[ping];
            if let Some(span) = survey.span(ping, side).filter(|_| pick.is_some()) {
                leads.push(span.range_m(f64::from(pick.sample)) - truth.side(side).first_return_m);
            }
        }
    }
    leads.sort_by(f64::total_cmp);
    leads[leads.len() / 2]
}

#[test]
fn an_offset_in_force_is_the_true_one_on_logs_of_any_range_depth_pulse_and_sounding() {
    let (mut applied, mut wrong) = ([0; 2], Vec::new());
    // More for a recorded run: BATHYSCOPE_OFFSETS=300.
    let logs = std::env::var("BATHYSCOPE_OFFSETS").ok();
    let logs = logs.and_then(|count| count.parse().ok()).unwrap_or(60);
    for index in 0..logs {
        let (scene, soundings) = scene(index);
        let pond = KnownSurvey::new(&scene, index);
        let survey = survey(&pond, soundings);
        let (returns, found) = calibrated(&survey, &Settings::default());
        let draft_m = match soundings {
            Soundings::Draft(draft_m) => draft_m,
            _ => 0.0,
        };
        let truth_m = true_offset_m(&pond, &survey, &returns) - draft_m;
        let is_right = matches!(soundings, Soundings::Right);
        applied[0] += usize::from(is_right && found.offset_note.is_none());
        applied[1] += usize::from(is_right);
        let line = format!(
            "{index}: {soundings:?}, range {:.0} m, depth {:.1} m, {} samples, pulse {:.0} mm, {:?} {:?}: truth {truth_m:+.3}, in force {:+.3} {:?}, measured {:?} {:?}",
            scene.recorder.range_m,
            scene.bed.mean_depth_m,
            scene.recorder.samples_per_side,
            1e3 * scene.recorder.pulse_m,
            scene.bed.kind,
            scene.recorder.curve,
            found.offset_m,
            found.offset_note,
            found.measured_offset,
            found.warnings,
        );
        println!("{line}");
        if found.offset_note.is_none() && (found.offset_m - truth_m).abs() > WITHIN_M {
            wrong.push(line);
        }
    }
    println!("in force on {} of {} logs with right soundings", applied[0], applied[1]);
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    assert!(3 * applied[0] >= applied[1], "{applied:?} in force where the soundings are right");
}

/// A level pond with soundings that are `scale` times the depth and `offset_m` more.
fn pond(scale: f64, offset_m: f64) -> KnownSurvey {
    let scene = Scene {
        track: TrackSettings { lines: 1, cross_lines: 0, ..TrackSettings::default() },
        artefacts: Artefacts {
            depth_scale: scale,
            depth_offset_m: offset_m,
            range_change: 1.0,
            weed_m: 0.0,
            ..Artefacts::default()
        },
        scattered_objects: 0,
        ..Scene::default()
    };
    KnownSurvey::new(&scene, 5)
}

#[test]
fn an_offset_that_no_instrument_causes_is_refused_with_its_figure_and_the_reason() {
    // As over the wreck of a survey-grade line: r = 1.37 d + 0.6.
    let pond = pond(1.0 / 1.37, -0.6 / 1.37);
    let (_, found) = calibrated(&pond.survey, &Settings::default());
    assert_eq!(found.offset_m, 0.0);
    assert_eq!(found.offset_note, Some("refused"));
    let [warning] = found.warnings.as_slice() else {
        panic!("one sentence: {:?}", found.warnings);
    };
    let measured = found.measured_offset.expect("an offset");
    assert!(measured.offset_m > 1.0, "{measured:?}");
    let figure = format!("{:.2} m beyond the recorded depths", measured.offset_m);
    assert!(warning.contains(&figure), "{warning}");
    assert!(warning.contains("more than a pulse"), "{warning}");
    let span = pond.survey.span(10, Side::Port).expect("a side");
    assert_eq!(found.range_m(span, 300.0), span.range_m(300.0));
}

#[test]
fn ranges_of_a_survey_recorder_are_trusted_unless_asked_not_to() {
    let pond = pond(1.0, 0.0);
    let (_, fish_finder) = calibrated(&pond.survey, &Settings::default());
    assert!(fish_finder.offset_m < -0.02, "{fish_finder:?}");
    let mut survey = pond.survey.clone();
    survey.range_source = RangeSource::SurveyRecorder;
    let (_, trusted) = calibrated(&survey, &Settings::default());
    assert_eq!(trusted.offset_m, 0.0);
    assert_eq!(trusted.offset_note, Some("survey-grade ranges"));
    assert_eq!(trusted.measured_offset, fish_finder.measured_offset);
    let asked = Settings::default().with_assignment("calibration.offset=fit").expect("a setting");
    let (_, fitted) = calibrated(&survey, &asked);
    assert_eq!(fitted.offset_m, fish_finder.offset_m);
    // Five centimetres stay in all depths, and that is said.
    let said = trusted.warnings.join(" ");
    assert!(said.contains("cm less than the soundings"), "{said}");
    // Depths of something else are reported there too.
    let wrong = self::pond(1.0 / 1.37, 0.0);
    let mut survey = wrong.survey.clone();
    survey.range_source = RangeSource::SurveyRecorder;
    let (_, trusted) = calibrated(&survey, &Settings::default());
    assert_eq!(trusted.offset_m, 0.0);
    let said = trusted.warnings.join(" ");
    assert!(said.contains("something else"), "{said}");
}
