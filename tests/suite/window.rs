//! The window, driven through its accessibility tree as a screen reader or an analyst would,
//! without a display.

use crate::support::{demo_log, manifest_entry, snapshot_options};
use bathyscope::app::{Action, App, Command, Jobs, LogPlace, ThemeChoice, WorkStep};
use bathyscope::ui::Shell;
use bathyscope_log::support::geo::CrsChoice;
use bathyscope_products::outputs::Product;
use bathyscope_products::pipeline::Preset;
use bathyscope_products::pipeline::Settings;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub(crate) type Window = Harness<'static, Shell>;

pub(crate) fn empty_window() -> Window {
    let mut window = Harness::builder()
        .with_size([1400.0, 1000.0])
        .with_max_steps(24)
        .build_eframe(|_| Shell::new(App::new(Jobs::Inline)));
    window.run();
    window
}

pub(crate) fn demo_window() -> Window {
    let mut window = empty_window();
    window.get_by_label("Open the demo survey").click();
    window.run();
    // The button is where a view is now: the pointer leaves it.
    window.event(egui::Event::PointerGone);
    window.run();
    window
}

pub(crate) fn app(window: &Window) -> &App {
    &window.state().app
}

pub(crate) fn threshold(window: &Window) -> f32 {
    app(window).logs.shown.settings.first_return.threshold
}

pub(crate) fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run();
}

/// Opens a step of the work by its key.
pub(crate) fn open_step(window: &mut Window, step: WorkStep) {
    let keys = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6];
    press(window, Modifiers::ALT, keys[step as usize]);
    assert_eq!(app(window).view.options.panels.step, step);
}

/// Opens a step of the work, and in it a section that begins folded.
pub(crate) fn open_section(window: &mut Window, step: WorkStep, title: &str) {
    open_step(window, step);
    window.get_by_label(&format!("{title} section")).click_accesskit();
    window.run();
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &std::path::Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

pub(crate) fn drop_file(window: &mut Window, path: PathBuf) {
    drop_files(window, [path]);
}

pub(crate) fn drop_files(window: &mut Window, paths: impl IntoIterator<Item = PathBuf>) {
    for path in paths {
        window.input_mut().dropped_files.push(Arc::new(Dropped(path)));
    }
    window.run();
}

#[test]
fn the_demo_is_one_click_away_and_its_summary_is_shown() {
    let window = demo_window();
    let survey = app(&window).logs.shown.survey.as_ref().expect("the demo is open");
    assert!(app(&window).logs.shown.products.is_some());
    let pings = survey.side_scan.len();
    assert!(pings > 1000);
    assert!(window.query_by_label_contains("pings · 1:5").is_some());
    assert!(window.query_by_label("Survey section").is_some());
    assert!(window.query_by_label_contains("Step 4 Map, done").is_some());
}

#[test]
fn steps_are_opened_by_key_and_click_and_say_what_needs_a_look() {
    let mut window = demo_window();
    let shows =
        |window: &Window, title: &str| window.query_by_label(&format!("{title} section")).is_some();
    open_step(&mut window, WorkStep::Correct);
    assert!(shows(&window, "Depth correction") && !shows(&window, "Survey"));
    let state = "Step 3 Calibrate and correct, needs a look: Draft and water level are not given";
    window.get_by_label(state);
    for name in ["Draft", "Water level"] {
        let field = window.get_all_by_role_and_label(Role::SpinButton, name).next();
        field.expect("a field").set_value_accesskit(0.4);
        window.run();
    }
    window.get_by_label("Step 3 Calibrate and correct, done");
    window.get_by_label("Step 5 Objects, not begun").click();
    window.run();
    assert!(shows(&window, "Objects") && !shows(&window, "Depth correction"));
    let shown = window.query_by_label_contains("Waterfall, pings").is_some();
    assert!(shown && window.query_by_label_contains("There are no objects yet").is_some());
    // Another survey begins with the first step.
    window.state_mut().app.apply(Command::OpenDemo);
    window.run();
    assert!(shows(&window, "Survey"));
}

#[test]
fn a_dropped_log_opens_and_is_remembered() {
    let mut window = empty_window();
    drop_file(&mut window, demo_log());
    assert!(app(&window).logs.shown.survey.is_some());
    assert_eq!(app(&window).recent, [demo_log()]);
}

#[test]
fn a_dropped_file_that_is_no_log_is_reported_and_can_be_dismissed() {
    let mut window = demo_window();
    let serial = app(&window).view.survey_serial;
    let this_file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    drop_file(&mut window, this_file);
    assert_eq!(app(&window).view.survey_serial, serial, "the open survey stays");
    assert!(window.query_by_label_contains("not a sonar log").is_some());
    window.get_by_label("Dismiss").click();
    window.run();
    assert!(app(&window).notices.shown().is_empty());
}

#[test]
fn the_first_return_follows_the_threshold_while_it_is_dragged_and_the_drag_is_one_undo_step() {
    for preset in [Preset::Recommended, Preset::Published] {
        let mut window = demo_window();
        window.state_mut().app.apply(Command::UsePreset(preset));
        window.run();
        let before =
            app(&window).logs.shown.products.as_ref().map(|products| products.returns.clone());
        open_step(&mut window, WorkStep::Bottom);
        let slider = window.get_by_role_and_label(Role::Slider, "Threshold").rect();
        let at = |share: f32| slider.left_center() + egui::vec2(slider.width() * share, 0.0);
        window.drag_at(at(0.30));
        window.step();
        for share in [0.40, 0.50, 0.60] {
            window.hover_at(at(share));
            window.step();
            window.step();
        }
        let dragged = threshold(&window);
        assert!((0.5..0.7).contains(&dragged), "{dragged}");
        let preview = app(&window).logs.shown.preview.clone().expect("a preview while dragging");
        assert_ne!(Some(&preview), before.as_ref(), "{preset:?}: the line moved");
        window.drop_at(at(0.60));
        window.run();
        let products = app(&window).logs.shown.products.as_ref().expect("results");
        assert_eq!(products.settings.first_return.threshold, dragged);
        assert!(app(&window).logs.shown.preview.is_none());
        let seen = app(&window).view.visible.clone();
        assert!(seen.len() > 100);
        // As text: no pick is a NaN, which is not equal to itself.
        assert_eq!(
            format!("{:?}", &products.returns.port[seen.clone()]),
            format!("{:?}", &preview.port[seen]),
            "{preset:?}: the preview was the result"
        );
        press(&mut window, Modifiers::COMMAND, Key::Z);
        assert_eq!(threshold(&window), 0.30);
        press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
        assert_eq!(threshold(&window), dragged);
    }
}

#[test]
fn presets_are_one_click_back_and_can_be_undone() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::End);
    press(&mut window, Modifiers::NONE, Key::CloseBracket);
    assert_eq!(threshold(&window), 0.31);
    open_section(&mut window, WorkStep::Logs, "Preset");
    assert!(window.query_by_label_contains("Some settings differ").is_some());
    window.get_by_label("Preset published").click();
    window.run();
    assert_eq!(app(&window).logs.shown.settings.matching_preset(), Some(Preset::Published));
    assert!(app(&window).logs.shown.stale().is_none(), "the results follow");
    window.get_by_label("Preset recommended").click();
    window.run();
    assert_eq!(app(&window).logs.shown.settings.matching_preset(), Some(Preset::Recommended));
    window.get_by_label("Undo button").click();
    window.run();
    assert_eq!(app(&window).logs.shown.settings.matching_preset(), Some(Preset::Published));
}

#[test]
fn outliers_are_shown_before_they_go() {
    let mut window = demo_window();
    open_section(&mut window, WorkStep::Map, "Outliers");
    window.get_by_role_and_label(Role::CheckBox, "Outlier preview").click_accesskit();
    window.run();
    assert!(app(&window).view.options.cloud.outlier_preview);
    press(&mut window, Modifiers::NONE, Key::Num3);
    press(&mut window, Modifiers::NONE, Key::O);
    assert!(!app(&window).view.options.cloud.outlier_preview);
}

#[test]
fn the_time_line_and_the_keys_move_along_the_survey() {
    let mut window = demo_window();
    let line = window.get_by_label_contains("Time line, ping").rect();
    let middle = line.center();
    window.hover_at(middle);
    window.step();
    assert!(app(&window).view.hover.is_some(), "hovering marks all views");
    window.drag_at(middle);
    window.drop_at(middle);
    window.run();
    let ping = app(&window).view.selection.expect("a selection").ping;
    let pings = app(&window).logs.shown.survey.as_ref().map_or(0, |survey| survey.side_scan.len());
    assert!((pings / 3..2 * pings / 3).contains(&ping), "{ping} of {pings}");
    assert!(window.query_by_label(&format!("Ping {ping}")).is_some());
    press(&mut window, Modifiers::SHIFT, Key::ArrowRight);
    press(&mut window, Modifiers::NONE, Key::ArrowLeft);
    assert_eq!(app(&window).view.selection.map(|mark| mark.ping), Some(ping + 24));
    press(&mut window, Modifiers::NONE, Key::End);
    assert_eq!(app(&window).view.selection.map(|mark| mark.ping), Some(pings - 1));
}

#[test]
fn playing_runs_along_the_survey_and_stops() {
    let mut window = demo_window();
    window.key_press(Key::Space);
    window.run_steps(6);
    let ping = app(&window).view.selection.expect("a selection").ping;
    assert!(ping > 0);
    window.state_mut().app.apply(Command::Select(Some(LogPlace::ping(900))));
    window.run_steps(3);
    let ping = app(&window).view.selection.expect("a selection").ping;
    assert!((901..1000).contains(&ping), "it goes on from the click: {ping}");
    window.key_press(Key::Space);
    window.run_steps(4);
    let stopped = app(&window).view.selection.map(|mark| mark.ping);
    window.run_steps(4);
    assert_eq!(app(&window).view.selection.map(|mark| mark.ping), stopped);
}

#[test]
fn the_palette_finds_a_command_by_a_few_letters() {
    let mut window = demo_window();
    press(&mut window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text("light");
    window.run();
    assert_eq!(
        app(&window).view.options.theme,
        ThemeChoice::Dark,
        "letters are text here, not keys"
    );
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_eq!(app(&window).view.options.theme, ThemeChoice::Light);
    assert!(window.query_by_label("Command").is_none(), "the palette closes");
    press(&mut window, Modifiers::NONE, Key::L);
    assert_eq!(app(&window).view.options.theme, ThemeChoice::Dark);
}

#[test]
fn views_are_maximised_and_arranged() {
    let mut window = demo_window();
    assert!(window.query_by_label("Map").is_some());
    // A pointer that lies still over another view does not outdo a view that was chosen by key.
    window.event(egui::Event::PointerMoved(egui::pos2(400.0, 200.0)));
    window.run();
    press(&mut window, Modifiers::NONE, Key::Num3);
    press(&mut window, Modifiers::SHIFT, Key::F11);
    assert!(window.query_by_label("Map").is_none(), "the cloud has the whole centre");
    assert!(window.query_by_label("3D cloud").is_some());
    press(&mut window, Modifiers::SHIFT, Key::F11);
    assert!(window.query_by_label("Map").is_some());
}

/// Opens the path field of the export by its key and types a folder.
pub(super) fn type_export_folder(window: &mut Window, into: &Path) {
    press(window, Modifiers::COMMAND, Key::E);
    window
        .get_by_role_and_label(Role::TextInput, "Folder to write into")
        .type_text(&into.to_string_lossy());
    window.run();
}

#[test]
fn products_are_written_where_the_path_field_says() {
    let mut window = demo_window();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let into = folder.path().join("out");
    type_export_folder(&mut window, &into);
    window.get_by_label("Export").click();
    window.run();
    for product in ["report.json", "depth/depth.tif", "mosaic/mosaic.tif", "report.html"] {
        assert!(into.join(product).is_file(), "{product}");
    }
    assert!(window.query_by_label_contains("Wrote ").is_some());
}

#[test]
fn what_is_unticked_is_not_written_and_the_system_is_the_one_chosen() {
    let mut window = demo_window();
    let mut settings = Settings::clone(&window.state().app.logs.shown.settings);
    settings.crs = CrsChoice::Wgs84;
    window.state_mut().app.apply(Command::Change {
        settings: Box::new(settings),
        label: "System",
        live: false,
    });
    let folder = tempfile::tempdir().expect("a temporary folder");
    let into = folder.path().join("out");
    type_export_folder(&mut window, &into);
    for product in [Product::Mosaic, Product::Report, Product::Isobaths] {
        let tick = window.get_by_role_and_label(Role::CheckBox, product.title());
        tick.click_accesskit();
        window.run();
    }
    window.get_by_label("Export").click();
    window.run();
    for (product, made) in [
        ("report.json", true),
        ("depth/depth.tif", true),
        ("track/track.gpx", true),
        ("mosaic/mosaic.tif", false),
        ("isobaths/isobaths.geojson", false),
        ("report.html", false),
    ] {
        assert_eq!(into.join(product).is_file(), made, "{product}");
    }
    let record = manifest_entry(&into, "depth/depth.tif");
    assert_eq!(record["crs"]["epsg"], 4326, "{record}");
}

#[derive(Default)]
struct Store(std::collections::HashMap<String, String>);

impl eframe::Storage for Store {
    fn get_string(&self, key: &str) -> Option<String> {
        self.0.get(key).cloned()
    }

    fn set_string(&mut self, key: &str, value: String) {
        self.0.insert(key.to_owned(), value);
    }

    fn remove_string(&mut self, key: &str) {
        self.0.remove(key);
    }

    fn flush(&mut self) {}
}

#[test]
fn options_and_arrangement_come_back_but_no_setting_of_a_survey() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::L);
    let app = &mut window.state_mut().app;
    app.apply(Command::Select(Some(LogPlace::ping(400))));
    app.apply(Command::Do(Action::Calibrate));
    app.apply(Command::Do(Action::UseScale));
    press(&mut window, Modifiers::NONE, Key::CloseBracket);
    assert_ne!(*window.state().app.logs.shown.settings, Settings::default());
    let mut store = Store::default();
    eframe::App::save(window.state_mut(), &mut store);

    let mut next = Shell::new(App::new(Jobs::Inline));
    next.restore(&store);
    assert_eq!(next.app.view.options.theme, ThemeChoice::Light);
    assert_eq!(*next.app.logs.shown.settings, Settings::default());

    for text in store.0.values_mut() {
        text.truncate(text.len() / 2);
    }
    let mut fresh = Shell::new(App::new(Jobs::Inline));
    fresh.restore(&store);
    assert_eq!(fresh.app.view.options.theme, ThemeChoice::Dark, "half a file is no file");
}

#[test]
fn the_base_map_comes_back_or_is_said_to_be_gone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("aerial.tif");
    let picture = bathyscope_test_support::base_map("utm_rgb.tif");
    std::fs::copy(picture, &path).expect("a copy");
    let mut window = demo_window();
    drop_file(&mut window, path.clone());
    assert!(app(&window).map.base_map.is_some());
    let mut store = Store::default();
    eframe::App::save(window.state_mut(), &mut store);
    let again = |store: &Store| {
        let mut next = Shell::new(App::new(Jobs::Inline));
        next.restore(store);
        next.app.poll();
        next.app
    };
    let next = again(&store);
    assert_eq!(next.map.base_map.map(|map| map.path.clone()), Some(path.clone()));
    assert!(next.notices.shown().is_empty());
    std::fs::write(&path, "no picture any more").expect("another file");
    let next = again(&store);
    assert!(next.map.base_map.is_none() && !next.notices.shown()[0].is_error);
    std::fs::remove_file(&path).expect("a file less");
    let next = again(&store);
    assert!(next.map.base_map.is_none());
    assert!(next.notices.shown()[0].text.contains("is missing"), "{:?}", next.notices.shown());
}

/// A window with a GPU: lavapipe where there is no other.
pub(crate) fn drawn_window(size: [f32; 2]) -> Window {
    let mut window = Harness::builder()
        .with_size(size)
        .with_max_steps(24)
        .with_options(snapshot_options())
        .with_render_cursor(false)
        .wgpu()
        .build_eframe(|cc| {
            assert!(cc.wgpu_render_state.is_some(), "the views need a GPU");
            Shell::new(App::new(Jobs::Inline))
        });
    window.run();
    window
}

/// Draws frames until tiles and layers have arrived.
pub(crate) fn settle(window: &mut Window) {
    for () in bathyscope_test_support::attempts() {
        window.step();
        window.render().expect("a picture");
        if window.state().is_settled() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    window.run();
    assert!(window.state().is_settled());
}

#[test]
fn the_whole_window_looks_as_it_did() {
    let mut window = drawn_window([1024.0, 680.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    window.run();
    window.state_mut().app.apply(Command::Reveal(LogPlace::ping(400)));
    settle(&mut window);
    window.snapshot("window");
}

#[test]
fn the_empty_window_and_the_palette_look_as_they_did() {
    let mut window = drawn_window([900.0, 600.0]);
    window.snapshot("window_empty");
    press(&mut window, Modifiers::NONE, Key::L);
    press(&mut window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text("preset");
    window.run();
    window.snapshot("window_palette_light");
}
