//! Isobaths in the window: the controls of their settings, and the area that they end at.

use crate::window::{Window, app, demo_window, open_step, press, settle};
use bathyscope::app::{Action, Command, FileToOpen, WorkStep};
use bathyscope_bottom::presentation::units::LengthUnit;
use bathyscope_log::support::geo::LonLat;
use bathyscope_products::pipeline::Preset;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;

/// Returns the places of the points of the drawn isobaths.
fn places(window: &Window) -> Vec<LonLat> {
    let app = app(window);
    let drawn = app.pipeline.deriving.isobaths().expect("isobaths");
    let log = &app.logs.shown;
    let (survey, products) = log.survey.as_ref().zip(log.products.as_ref()).expect("results");
    let to_lon_lat = |at: &[f64; 2]| products.navigation.to_lon_lat(&survey.track, at[0], at[1]);
    drawn.on_ground.iter().flatten().map(to_lon_lat).collect()
}

#[test]
fn isobaths_end_at_the_area_that_is_opened_and_undo_takes_it_back() {
    let mut window = demo_window();
    settle(&mut window);
    let whole = places(&window);
    let middle_deg = {
        let longitudes = || whole.iter().map(|at| at.lon_deg);
        let least = longitudes().fold(f64::MAX, f64::min);
        0.5 * (least + longitudes().fold(f64::MIN, f64::max))
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shore.kml");
    let south = whole[0].lat_deg - 1.0;
    let corners = [[-1.0, 0.0], [0.0, 0.0], [0.0, 2.0], [-1.0, 2.0]]
        .map(|[east, north]| format!("{},{}", middle_deg + east, south + north));
    let kml = format!(
        "<kml><Polygon><outerBoundaryIs><LinearRing><coordinates>{}</coordinates></LinearRing></outerBoundaryIs></Polygon></kml>",
        corners.join(" ")
    );
    std::fs::write(&path, kml).expect("a file");

    window.state_mut().app.apply(Command::OpenFile(FileToOpen::IsobathArea(path.clone())));
    settle(&mut window);
    assert_eq!(app(&window).logs.shown.settings.isobaths.clip.as_ref(), Some(&path));
    let west = places(&window);
    assert!(!west.is_empty() && west.len() < whole.len());
    // The plane of the map is bent against that of the window, by far less than a millimetre here.
    assert!(west.iter().all(|at| at.lon_deg < middle_deg + 1e-8));
    open_step(&mut window, WorkStep::Map);
    assert!(window.query_by_label_contains("shore.kml").is_some());

    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(app(&window).logs.shown.settings.isobaths.clip, None);
    assert_eq!(places(&window).len(), whole.len());
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut window);
    assert_eq!(places(&window).len(), west.len());
    // A preset leaves the shore of this water, and another survey has none of it.
    window.state_mut().app.apply(Command::UsePreset(Preset::Published));
    settle(&mut window);
    let clip = &app(&window).logs.shown.settings.isobaths.clip;
    assert_eq!(clip.as_ref(), Some(&path));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    window.state_mut().app.apply(Command::Do(Action::RemoveIsobathArea));
    settle(&mut window);
    assert_eq!(places(&window).len(), whole.len());

    // What is no area is said, and leaves all as it was.
    std::fs::write(&path, "<kml/>").expect("a file");
    window.state_mut().app.apply(Command::OpenFile(FileToOpen::IsobathArea(path)));
    settle(&mut window);
    assert!(window.query_by_label_contains("no polygon").is_some());
    assert_eq!(app(&window).logs.shown.settings.isobaths.clip, None);
}

#[test]
fn the_panel_has_a_control_for_each_setting_of_the_isobaths() {
    let mut window = demo_window();
    open_step(&mut window, WorkStep::Map);
    settle(&mut window);
    // High enough for the whole panel.
    window.set_size(egui::vec2(1400.0, 3200.0));
    settle(&mut window);
    for name in ["Interval", "Smoothing", "Spot soundings"] {
        let found = window.query_by_role_and_label(Role::Slider, name);
        assert!(found.is_some(), "{name}");
    }
    for (list, name) in [("Unit", "feet"), ("Shoals", "shoal-safe")] {
        window.get_by_role_and_label(Role::ComboBox, list).click();
        window.run();
        window.get_by_label(name).click();
        settle(&mut window);
    }
    let settings = &app(&window).logs.shown.settings.isobaths;
    assert_eq!((settings.unit, settings.shoal_safe), (LengthUnit::Feet, true));
    assert!(
        app(&window).pipeline.deriving.isobaths().is_some_and(|drawn| drawn.settings.shoal_safe)
    );
    for action in [Action::OpenIsobathArea, Action::IsobathLayer] {
        assert!(window.query_by_label(action.label()).is_some(), "{action:?}");
    }
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(!app(&window).logs.shown.settings.isobaths.shoal_safe);
}
