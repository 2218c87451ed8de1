//! Whole jobs in the window: the main one by keys alone, one log after another, logs with something
//! missing, work that is stopped and taken up again.

use crate::support::{demo_log, real_data};
use crate::window::{
    Window, app, demo_window, drop_file, empty_window, open_section, open_step, press, threshold,
    type_export_folder,
};
use bathyscope::app::{Action, Command, WorkStep};
use bathyscope_products::pipeline::Preset;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use std::path::{Path, PathBuf};

fn run_by_palette(window: &mut Window, letters: &str) {
    press(window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text(letters);
    window.run();
    press(window, Modifiers::NONE, Key::Enter);
}

/// The first half of the demo survey, as a log of its own.
fn half_of_the_demo(folder: &Path) -> PathBuf {
    let path = folder.join("half.sl2");
    let whole = std::fs::read(demo_log()).expect("the demo");
    std::fs::write(&path, &whole[..whole.len() / 2]).expect("a temporary file");
    path
}

#[test]
fn the_main_job_is_done_by_keys_alone() {
    let mut window = empty_window();
    run_by_palette(&mut window, "demo");
    assert!(app(&window).logs.shown.products.is_some());
    press(&mut window, Modifiers::NONE, Key::End);
    press(&mut window, Modifiers::SHIFT, Key::ArrowLeft);
    press(&mut window, Modifiers::NONE, Key::CloseBracket);
    press(&mut window, Modifiers::NONE, Key::C);
    assert_eq!(app(&window).logs.shown.settings.calibration.pings, None);
    assert!(app(&window).logs.shown.proposed_stretch().is_some());
    run_by_palette(&mut window, "use this scale");
    assert!(app(&window).logs.shown.settings.calibration.pings.is_some());
    press(&mut window, Modifiers::NONE, Key::Num3);
    press(&mut window, Modifiers::NONE, Key::O);
    assert!(app(&window).view.options.cloud.outlier_preview);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let into = folder.path().join("out");
    type_export_folder(&mut window, &into);
    press(&mut window, Modifiers::NONE, Key::Enter);
    let report = std::fs::read_to_string(into.join("report.json")).expect("a report");
    assert!(report.contains("0.31"), "the threshold of the settings");
}

#[test]
fn keys_belong_to_the_path_field_while_it_is_open() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::End);
    press(&mut window, Modifiers::NONE, Key::CloseBracket);
    press(&mut window, Modifiers::NONE, Key::Num3);
    press(&mut window, Modifiers::COMMAND, Key::E);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::NONE, Key::O);
    assert_eq!(threshold(&window), 0.31, "nothing is taken back behind it");
    assert!(!app(&window).view.options.cloud.outlier_preview);
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(threshold(&window), 0.30);
}

#[test]
fn recent_logs_are_found_from_another_folder_too() {
    let mut window = empty_window();
    // Tests run in the folder of the project.
    drop_file(&mut window, PathBuf::from("assets/demo.sl2"));
    assert_eq!(app(&window).recent, [demo_log()]);
}

#[test]
fn a_second_survey_takes_nothing_over_from_the_first() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let half = half_of_the_demo(folder.path());
    let mut fresh = empty_window();
    drop_file(&mut fresh, half.clone());

    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::End);
    press(&mut window, Modifiers::NONE, Key::C);
    run_by_palette(&mut window, "use this scale");
    assert!(app(&window).logs.shown.settings.calibration.pings.is_some());
    window.key_press(Key::Home);
    window.key_press(Key::Space);
    window.run_steps(4);
    window.state_mut().app.apply(Command::Open(half));
    window.run();
    assert_eq!(app(&window).view.selection, None, "it plays no more");
    assert_eq!(app(&window).logs.shown.settings.calibration.pings, None);
    assert_eq!(app(&window).document.history.undo_label(), None);
    assert_eq!(app(&window).logs.shown.figures, app(&fresh).logs.shown.figures);
    for preset in [Preset::Published, Preset::Recommended] {
        for each in [&mut window, &mut fresh] {
            each.state_mut().app.apply(Command::UsePreset(preset));
            each.run();
            // The index of running maxima is that of the open survey as well.
            press(each, Modifiers::NONE, Key::CloseBracket);
        }
        let returns = |window: &Window| {
            let products = app(window).logs.shown.products.as_ref().expect("results");
            // As text: no pick is a NaN, which is not equal to itself.
            format!("{:?}", products.returns)
        };
        assert_eq!(returns(&window), returns(&fresh), "{preset:?}");
        let maps = |window: &Window| {
            let map = window.get_by_label_contains("Map, track of");
            map.accesskit_node().label()
        };
        assert_eq!(maps(&window), maps(&fresh));
    }
}

#[test]
fn each_drag_of_a_slider_is_one_step_back() {
    for preset in [Preset::Recommended, Preset::Published] {
        let mut window = demo_window();
        window.state_mut().app.apply(Command::UsePreset(preset));
        window.run();
        let before = app(&window).logs.shown.settings.clone();
        open_section(&mut window, WorkStep::Map, "Outliers");
        for (step, name) in [
            (WorkStep::Bottom, "Threshold"),
            (WorkStep::Bottom, "Dead zone"),
            (WorkStep::Bottom, "Shallower by"),
            (WorkStep::Map, "Radius"),
            (WorkStep::Map, "Neighbours"),
        ] {
            open_step(&mut window, step);
            // The steps are longer than the window.
            window.get_by_role_and_label(Role::Slider, name).scroll_to_me();
            window.run();
            let slider = window.get_by_role_and_label(Role::Slider, name).rect();
            let at = |share: f32| slider.left_center() + egui::vec2(slider.width() * share, 0.0);
            window.drag_at(at(0.5));
            window.step();
            for share in [0.6, 0.7, 0.8] {
                window.hover_at(at(share));
                window.step();
            }
            window.drop_at(at(0.8));
            window.run();
            assert_ne!(app(&window).logs.shown.settings, before, "{name}");
            assert_eq!(app(&window).logs.shown.stale(), None, "{name}: results follow");
            press(&mut window, Modifiers::COMMAND, Key::Z);
            assert_eq!(app(&window).logs.shown.settings, before, "{name}");
            assert_eq!(app(&window).logs.shown.stale(), None, "{name}: and come back");
        }
    }
}

#[test]
fn what_was_stopped_is_marked_and_taken_up_again() {
    let mut window = demo_window();
    let app_now = &mut window.state_mut().app;
    app_now.apply(Command::UsePreset(Preset::Published));
    app_now.apply(Command::Do(Action::Cancel));
    window.run();
    assert!(app(&window).logs.shown.stale().is_some());
    window.get_by_label("Step 2 Bottom, out of date");
    open_step(&mut window, WorkStep::Map);
    window.get_by_label("Cloud section, out of date");
    open_step(&mut window, WorkStep::Export);
    window.get_by_label_contains("The last results are written");
    window.get_by_label("Update results").click();
    window.run();
    assert_eq!(app(&window).logs.shown.stale(), None);
    assert!(window.query_by_label("Update results").is_none());

    let app_now = &mut window.state_mut().app;
    app_now.apply(Command::UsePreset(Preset::Recommended));
    app_now.apply(Command::Do(Action::Cancel));
    press(&mut window, Modifiers::COMMAND, Key::R);
    assert_eq!(app(&window).logs.shown.stale(), None);
}

#[test]
fn the_published_formula_says_what_it_makes_of_the_depth() {
    let mut window = demo_window();
    let note = "is multiplied by cos(α2), -3.87 %";
    open_section(&mut window, WorkStep::Map, "Cloud");
    assert!(window.query_by_label_contains(note).is_none());
    open_section(&mut window, WorkStep::Logs, "Preset");
    window.get_by_label("Preset published").click();
    window.run();
    open_step(&mut window, WorkStep::Map);
    assert!(window.query_by_label_contains(note).is_some());
}

#[test]
fn logs_with_something_missing_say_what() {
    let Some(data) = real_data() else {
        return;
    };
    for (log, step, said) in [
        ("lowrance/river-downscan-only.sl2", WorkStep::Logs, "no side-scan in this log"),
        ("lowrance/hobart-20m.sl3", WorkStep::Logs, "no side-scan: range ±1.5 m"),
        ("lowrance/elite4-stray-bytes.sl2", WorkStep::Bottom, "This log has no side-scan."),
        ("xtf/000_1236.xtf", WorkStep::Correct, "records no depth"),
    ] {
        let mut window = empty_window();
        drop_file(&mut window, data.join(log));
        let notices = &app(&window).notices.shown();
        assert!(notices.is_empty(), "{log}: {notices:?}");
        assert!(app(&window).logs.shown.products.is_some(), "{log}");
        open_step(&mut window, step);
        assert!(window.query_all_by_label_contains(said).next().is_some(), "{log}");
        for key in [Key::End, Key::C, Key::O, Key::CloseBracket, Key::F, Key::Space] {
            press_some(&mut window, key);
        }
        assert!(app(&window).logs.shown.products.is_some(), "{log}");
    }
}

/// Presses a key and draws a few frames: what plays never comes to rest by itself.
fn press_some(window: &mut Window, key: Key) {
    window.key_press(key);
    window.run_steps(4);
}
