//! The bottom line at the recorded depth: the picture follows it, the measurements do not, and what
//! was drawn stays.

use crate::support::{demo_log, real_data};
use crate::truth::processed;
use crate::window::{app, demo_window, press};
use bathyscope::app::Command;
use bathyscope_bottom::first_return::{BottomEdit, BottomLine, BottomSettings};
use bathyscope_bottom::mosaic::MosaicLayout;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::pipeline::{self, Products, Settings, mosaic_layout_by};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::path::PathBuf;
use std::sync::Arc;

fn with(settings: &Settings, line: BottomLine) -> Settings {
    let mut settings = settings.clone();
    settings.first_return.bottom_line = line;
    settings
}

fn run(survey: &Survey, settings: &Settings, previous: Option<&Products>) -> Products {
    pipeline::run(survey, settings, previous, &Progress::new(), |_| ()).expect("not cancelled")
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The demo, the river as Lowrance wrote it, the same as Humminbird recorded it, and a towed
/// survey-grade XTF.
fn logs() -> Vec<PathBuf> {
    let data = real_data();
    let real = [
        "lowrance/glencanyon-transcoded.sl2",
        "humminbird-glen-canyon/Rec00001.DAT",
        "xtf/000_1236.xtf",
    ];
    let real = data.iter().flat_map(|data| real.map(|name| data.join(name)));
    std::iter::once(demo_log()).chain(real).collect()
}

#[test]
fn it_lies_at_the_recorded_depth_and_moves_neither_points_nor_scales() {
    for path in logs() {
        let (survey, searched) = processed(&path);
        assert!(Arc::ptr_eq(&searched.bottom_line, &searched.returns));
        let settings = with(&searched.settings, BottomLine::Recorded);
        let recorded = run(&survey, &settings, Some(&searched));
        assert!(Arc::ptr_eq(&recorded.returns, &searched.returns));
        assert!(Arc::ptr_eq(&recorded.calibration, &searched.calibration));
        assert!(Arc::ptr_eq(&recorded.cloud, &searched.cloud));
        let from_scratch = run(&survey, &settings, None);
        let same = format!("{:?}", from_scratch.bottom_line);
        assert_eq!(same, format!("{:?}", recorded.bottom_line));

        let (reduction, mut apart_m, mut without) = (recorded.reduction(), Vec::new(), 0);
        for side in Side::BOTH {
            for ping in 0..survey.side_scan.len() {
                let Some(span) = survey.span(ping, side) else {
                    continue;
                };
                let line = recorded.bottom_line.side(side)[ping];
                let found = recorded.returns.side(side)[ping];
                let depth_m = f64::from(survey.good_depth_m(ping));
                let is_taken = line.sample.to_bits() != found.sample.to_bits();
                if !is_taken {
                    without += 1;
                    continue;
                }
                let line_m = reduction.range_m(span, f64::from(line.sample));
                let altitude_m = reduction.altitude_m(depth_m);
                assert!((line_m - altitude_m).abs() < 2e-3, "{line_m} {altitude_m}");
                if found.is_some() {
                    apart_m.push(reduction.range_m(span, f64::from(found.sample)) - line_m);
                }
            }
        }
        apart_m.sort_by(f64::total_cmp);
        let deepest_m = apart_m.get(apart_m.len() * 9 / 10).copied();
        let mut off_m: Vec<f64> = apart_m.iter().map(|apart| apart.abs()).collect();
        println!(
            "{}: first return less recorded depth: median {:+.3} m, 90th percentile {:+.3} m, median of the distance {:.3} m over {} places, {} searched; {:?}",
            path.file_name().expect("a name").to_string_lossy(),
            median(&mut apart_m),
            deepest_m.unwrap_or(f64::NAN),
            median(&mut off_m),
            apart_m.len(),
            without,
            recorded.bottom_line.warnings,
        );
        let warnings = recorded.bottom_line.warnings.iter();
        let warnings = warnings.filter(|text| text.contains("the bottom line is the first return"));
        assert_eq!(warnings.count(), usize::from(without > 0));
        // A bank or a boulder beside the boat comes first; over level ground both are of one
        // bottom: an offset of a keel or a draft would show here. The XTF has no depth at all.
        match deepest_m {
            Some(deepest_m) => assert!(deepest_m.abs() < 0.15, "{path:?}: {deepest_m}"),
            None => assert!(survey.soundings.is_empty() && without > 0, "{path:?}"),
        }
    }
}

/// Echoes of the log on the ground.
fn layout(survey: &Survey, products: &Products) -> MosaicLayout {
    mosaic_layout_by(survey, products, |place| place)
}

#[test]
fn the_mosaic_is_laid_out_by_it_and_edits_stay_on_top() {
    let (survey, searched) = processed(&demo_log());
    let mut settings = with(&searched.settings, BottomLine::Recorded);
    let recorded = run(&survey, &settings, Some(&searched));
    let by_search = format!("{:?}", layout(&survey, &searched));
    let by_depth = format!("{:?}", layout(&survey, &recorded));
    assert!(by_search != by_depth, "the mosaic follows the line");

    settings.bottom = BottomSettings::of(&survey).with(BottomEdit {
        side: Side::Port,
        pings: [200, 260],
        corners: vec![[200.0, 5.0]],
        accepted: false,
    });
    let drawn = run(&survey, &settings, Some(&recorded));
    let range_m = |side: Side, ping: usize| {
        let span = survey.span(ping, side).expect("a recorded side");
        span.range_m(f64::from(drawn.bottom_line.side(side)[ping].sample))
    };
    assert!((range_m(Side::Port, 230) - 5.0).abs() < 0.02);
    // What was drawn moves the measured offset of the ranges by less than a sample.
    let [drawn_at, before] = [&drawn, &recorded].map(|made| made.bottom_line.starboard[230].sample);
    assert!((drawn_at - before).abs() < 1.0, "{drawn_at} {before}");
    assert!(drawn.bottom_line.is_drawn(Side::Port, 230));
}

#[test]
fn it_is_chosen_in_the_window_for_a_log_and_taken_back() {
    let mut window = demo_window();
    window.get_by_label_contains(", first return shown");
    let before = app(&window).logs.shown.products.clone().expect("results");
    let settings = with(&app(&window).logs.shown.settings, BottomLine::Recorded);
    let change =
        Command::Change { settings: Box::new(settings), label: "bottom line", live: false };
    window.state_mut().app.apply(change);
    window.run();
    window.get_by_label_contains("bottom line at the recorded depth shown");
    let products = app(&window).logs.shown.products.as_ref().expect("results");
    assert!(!Arc::ptr_eq(&products.bottom_line, &products.returns));
    assert!(Arc::ptr_eq(&products.cloud, &before.cloud));
    let drawn = app(&window).logs.shown.bottom_line().expect("a line");
    assert!(Arc::ptr_eq(drawn, &products.bottom_line));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    window.run();
    window.get_by_label_contains(", first return shown");
    let products = app(&window).logs.shown.products.as_ref().expect("results");
    assert!(Arc::ptr_eq(&products.bottom_line, &products.returns));
}
