//! The tools of the map, driven by keys and mouse.

use crate::printing::name_file;
use crate::window::{Window, app, demo_window, drawn_window, drop_file, press, settle};
use bathyscope::app::{Action, Command, LogPlace, MapLayer, Measure, View};
use bathyscope_log::support::geo::{CoordinateFormat, LonLat};
use bathyscope_test_support::base_map;
use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, pos2};
use egui_kittest::kittest::Queryable as _;

/// Runs a command by its name.
fn by_palette(window: &mut Window, name: &str) {
    press(window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text(name);
    window.run();
    press(window, Modifiers::NONE, Key::Enter);
}

/// The map of the demo survey alone.
fn map_window() -> Window {
    let mut window = drawn_window([900.0, 640.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    window.state_mut().show_alone(View::Map);
    settle(&mut window);
    window
}

#[test]
fn every_panel_writes_a_position_in_the_form_that_was_chosen() {
    let mut window = demo_window();
    let select = Command::Reveal(LogPlace::ping(400));
    window.state_mut().app.apply(select);
    window.run();
    assert!(window.query_all_by_label_contains("° W").next().is_some());
    for (name, format, sign) in [
        ("Coordinates: UTM metres", CoordinateFormat::Utm, "UTM 17N 3923"),
        ("Coordinates: degrees and minutes", CoordinateFormat::Minutes, "29° 24.6"),
        ("Coordinates: degrees, minutes and seconds", CoordinateFormat::Seconds, "29° 24' 3"),
    ] {
        by_palette(&mut window, name);
        assert_eq!(app(&window).view.options.coordinates, format);
        let written = window.query_all_by_label_contains(sign).count();
        assert_eq!(written, 2, "in the selection and the status line: {sign}");
    }
}

#[test]
fn the_graticule_follows_the_coordinates() {
    let mut window = map_window();
    window.state_mut().app.view.options.coordinates = CoordinateFormat::Seconds;
    settle(&mut window);
    window.snapshot("map_graticule_seconds");
    window.state_mut().app.view.options.coordinates = CoordinateFormat::Utm;
    press(&mut window, Modifiers::NONE, Key::L);
    settle(&mut window);
    window.snapshot("map_graticule_utm_light");
    let off = Command::Do(Action::Graticule);
    window.state_mut().app.apply(off);
    assert!(!app(&window).view.options.map.graticule);
}

/// A click with the main button.
pub(super) fn click(window: &mut Window, at: Pos2) {
    window.hover_at(at);
    window.run();
    for pressed in [true, false] {
        window.event(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }
    window.run();
    // The command of a click is carried out after its frame.
    window.step();
}

fn corners(window: &Window) -> Vec<LonLat> {
    let figure = app(window).map.measuring.figure.as_ref();
    figure.map_or_else(Vec::new, |figure| figure.measurement.corners.clone())
}

#[test]
fn a_distance_is_measured_by_mouse_and_taken_back() {
    let mut window = map_window();
    press(&mut window, Modifiers::NONE, Key::D);
    assert!(window.query_by_label_contains("Measure distance: click").is_some());
    click(&mut window, pos2(200.0, 400.0));
    click(&mut window, pos2(300.0, 400.0));
    click(&mut window, pos2(300.0, 300.0));
    let found = corners(&window);
    let survey = app(&window).logs.shown.survey.clone().unwrap();
    let places: Vec<[f64; 2]> = found.iter().map(|at| survey.track.frame.to_enu(*at)).collect();
    let legs: Vec<f64> =
        places.windows(2).map(|leg| (leg[1][0] - leg[0][0]).hypot(leg[1][1] - leg[0][1])).collect();
    assert!((legs[0] - legs[1]).abs() < 1e-3 * legs[0], "a hundred points each: {legs:?}");
    assert!(places[1][0] > places[0][0] && places[2][1] > places[1][1], "{places:?}");
    let distances_m = app(&window).map.measuring.figure.as_ref().unwrap().measurement.distances_m();
    assert!((distances_m[2] - legs[0] - legs[1]).abs() < 1e-6, "{distances_m:?}");
    assert_eq!(app(&window).view.selection, None, "the clicks select no ping");
    press(&mut window, Modifiers::NONE, Key::Backspace);
    assert_eq!(corners(&window), found[..2]);
    press(&mut window, Modifiers::NONE, Key::Enter);
    let text = format!("Distance {:.2} m", legs[0]);
    assert!(window.query_by_label_contains(&text).is_some(), "{text}");
    click(&mut window, pos2(500.0, 300.0));
    assert_eq!(corners(&window).len(), 1, "another line begins");
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).map.measuring.tool, None);
    assert_eq!(corners(&window).len(), 0, "one corner measures nothing");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(corners(&window).len(), 1, "undone");
    for _ in 0..2 {
        press(&mut window, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(corners(&window), found, "back to the third corner");
}

#[test]
fn an_area_is_drawn_by_keys_alone() {
    let mut window = map_window();
    press(&mut window, Modifiers::SHIFT, Key::D);
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    press(&mut window, Modifiers::NONE, Key::X);
    for _ in 0..10 {
        press(&mut window, Modifiers::NONE, Key::ArrowRight);
    }
    press(&mut window, Modifiers::NONE, Key::X);
    for _ in 0..20 {
        press(&mut window, Modifiers::NONE, Key::ArrowUp);
    }
    press(&mut window, Modifiers::NONE, Key::X);
    press(&mut window, Modifiers::NONE, Key::Enter);
    window.step();
    let figure = app(&window).map.measuring.figure.clone().expect("a figure");
    assert!(figure.done && figure.measurement.corners.len() == 3, "{figure:?}");
    let distances_m = figure.measurement.distances_m();
    let legs = [distances_m[1], distances_m[2] - distances_m[1]];
    assert!((legs[1] / legs[0] - 2.0).abs() < 1e-3, "{legs:?}");
    let area_m2 = figure.measurement.area_m2();
    assert!((area_m2 / (0.5 * legs[0] * legs[1]) - 1.0).abs() < 1e-3, "half of a rectangle");
    assert_eq!(app(&window).view.selection, None, "the arrows walk along no pings");
    assert!(window.query_by_label_contains(&format!("Area {area_m2:.1} m²")).is_some());
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).map.measuring.figure, None);
}

#[test]
fn a_depth_profile_is_plotted_marked_and_saved() {
    let mut window = map_window();
    press(&mut window, Modifiers::NONE, Key::P);
    window.step();
    click(&mut window, pos2(200.0, 180.0));
    click(&mut window, pos2(450.0, 260.0));
    click(&mut window, pos2(760.0, 120.0));
    press(&mut window, Modifiers::NONE, Key::Enter);
    press(&mut window, Modifiers::NONE, Key::Escape);
    settle(&mut window);
    let plot = window.get_by_label_contains("Depth profile, ").rect();
    window.hover_at(plot.center());
    window.run();
    assert!(window.query_by_label_contains("; at ").is_some());
    settle(&mut window);
    window.snapshot("map_profile");

    let stations = app(&window).map.measuring.stations().to_vec();
    let figure = app(&window).map.measuring.figure.clone().unwrap();
    let text = app(&window).profile_csv().expect("a profile");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("distance_m,lon,lat,east_m,north_m,depth_m"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), stations.len());
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>();
    assert!((number(rows.len() - 1, 0).unwrap() - figure.measurement.length_m()).abs() < 1e-3);
    assert!((1..rows.len()).all(|row| number(row, 0).unwrap() > number(row - 1, 0).unwrap()));
    let depths: Vec<f64> = (0..rows.len()).filter_map(|row| number(row, 5).ok()).collect();
    let gaps = rows.iter().filter(|row| row[5].is_empty()).count();
    assert!(gaps > 10 && depths.len() > 40 && gaps + depths.len() == rows.len());
    assert!(depths.iter().all(|depth_m| (1.2..2.8).contains(depth_m)));
    let end = figure.measurement.corners.last().unwrap();
    assert!((number(rows.len() - 1, 1).unwrap() - end.lon_deg).abs() < 1e-8);
}

#[test]
fn a_profile_is_written_where_the_path_field_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bed.csv");
    let mut window = demo_window();
    by_palette(&mut window, "Save the depth profile");
    assert!(window.query_by_label_contains("there is no depth profile yet").is_some());
    let origin = app(&window).logs.shown.survey.as_ref().unwrap().track.frame.origin();
    let app = &mut window.state_mut().app;
    app.apply(Command::Do(Action::DepthProfile));
    for north_deg in [0.0, 1e-4] {
        app.apply(Command::Measure(Measure::Corner(LonLat {
            lat_deg: origin.lat_deg + north_deg,
            ..origin
        })));
    }
    app.apply(Command::Do(Action::EndFigure));
    window.run();
    window.get_by_label("Save CSV… (depth profile)").click();
    window.run();
    let field = |window: &Window, act: &dyn Fn(egui_kittest::Node<'_>)| {
        act(window.get_by_role_and_label(Role::TextInput, "File to write"));
    };
    field(&window, &|field| field.focus());
    window.run();
    press(&mut window, Modifiers::COMMAND, Key::A);
    let written = path.display().to_string();
    field(&window, &|field| field.type_text(&written));
    window.run();
    window.get_by_label("Save").click();
    window.run();
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.lines().count() > 10, "{text}");
}

#[test]
fn the_map_is_swiped_by_mouse_and_by_arrows() {
    let mut window = map_window();
    press(&mut window, Modifiers::NONE, Key::W);
    settle(&mut window);
    let swipe = |window: &Window| app(window).view.options.map.swipe.clone();
    assert!(swipe(&window).on);
    let layers = &app(&window).view.options.map.layers;
    assert!(layers.is_visible(MapLayer::Mosaic), "the left has something to show");
    window.snapshot("map_swipe");
    let divider = window.get_by_label("Divider of the map, percent").rect();
    let map = window.get_by_label_contains("Map, track of").rect();
    window.drag_at(divider.center());
    window.step();
    let to = pos2(map.left() + 0.25 * map.width(), divider.center().y);
    window.hover_at(to);
    window.step();
    window.drop_at(to);
    window.run();
    let dragged = swipe(&window).share;
    assert!((dragged - 0.25).abs() < 0.02, "{dragged}");
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    window.step();
    assert!((swipe(&window).share - dragged - 0.02).abs() < 1e-4);
    press(&mut window, Modifiers::SHIFT, Key::ArrowLeft);
    window.step();
    assert!((swipe(&window).share - dragged + 0.08).abs() < 1e-4);
    assert_eq!(app(&window).view.selection, None, "the arrows walk along no pings");
    press(&mut window, Modifiers::NONE, Key::W);
    assert!(!swipe(&window).on);
    assert!(window.query_by_label("Divider of the map, percent").is_none());
}

#[test]
fn a_dropped_picture_lies_under_the_map() {
    let mut window = map_window();
    drop_file(&mut window, base_map("utm_rgb.tif"));
    settle(&mut window);
    let map = app(&window).map.base_map.clone().expect("a base map");
    assert_eq!(map.size, [200, 150]);
    assert!(app(&window).logs.shown.survey.is_some(), "the survey stays open");
    assert!(app(&window).notices.shown()[0].text.starts_with(
        "Opened the base map of 200 by 150 pixels of 0.30 m, EPSG:32617 (WGS 84 / UTM zone 17N): "
    ));
    let layers = &mut window.state_mut().app.view.options.map.layers;
    layers.set_visible(MapLayer::DepthMap, false);
    layers.set_visible(MapLayer::HillShade, false);
    settle(&mut window);
    window.snapshot("map_base_map");
    drop_file(&mut window, base_map("british.tif"));
    assert!(app(&window).notices.shown().last().is_some_and(|notice| notice.is_error));
    assert!(app(&window).map.base_map.is_some(), "the one before stays");
    let close = Command::Do(Action::CloseBaseMap);
    window.state_mut().app.apply(close);
    settle(&mut window);
    assert!(app(&window).map.base_map.is_none());
}

#[test]
fn a_base_map_is_opened_by_its_command() {
    let mut window = demo_window();
    by_palette(&mut window, "Open base map");
    window
        .get_by_role_and_label(Role::TextInput, "Path of a GeoTIFF")
        .type_text(&base_map("mercator_palette.tif").to_string_lossy());
    window.run();
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_eq!(app(&window).map.base_map.as_ref().map(|map| map.place.crs.epsg()), Some(3857));
}

#[test]
fn a_measured_area_is_saved_as_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = demo_window();
    let origin = app(&window).logs.shown.survey.as_ref().unwrap().track.frame.origin();
    let app_now = &mut window.state_mut().app;
    app_now.apply(Command::Do(Action::MeasureArea));
    for [east_deg, north_deg] in [[0.0, 0.0], [0.0, 1e-4], [1e-4, 1e-4], [1e-4, 0.0]] {
        app_now.apply(Command::Measure(Measure::Corner(LonLat {
            lon_deg: origin.lon_deg + east_deg,
            lat_deg: origin.lat_deg + north_deg,
        })));
    }
    app_now.apply(Command::Do(Action::EndFigure));
    app_now.apply(Command::Do(Action::LeaveTool));
    window.run();
    let figure = app(&window).map.measuring.figure.clone().unwrap();
    for name in ["area.geojson", "area.csv", "area.txt"] {
        window.get_by_label("Save the measurement…").click();
        window.run();
        let path = folder.path().join(name);
        name_file(&mut window, "File to write, .geojson or .csv", &path, "Save");
    }
    let text = std::fs::read(folder.path().join("area.geojson")).unwrap();
    let read: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let properties = &read["features"][0]["properties"];
    assert_eq!(properties["measured"], "area");
    let area_m2 = properties["area_m2"].as_f64().unwrap();
    assert!((area_m2 - figure.measurement.area_m2()).abs() < 1e-3, "{area_m2}");
    let ring = read["features"][0]["geometry"]["coordinates"][0].as_array();
    assert_eq!(ring.unwrap().len(), 5);
    let table = std::fs::read_to_string(folder.path().join("area.csv")).unwrap();
    assert_eq!(table.lines().count(), 6, "{table}");
    assert!(!folder.path().join("area.txt").exists());
    let last = app(&window).notices.shown().last().unwrap();
    assert!(last.is_error && last.text.contains(".geojson or .csv"), "{}", last.text);
}

#[test]
fn the_plot_of_a_profile_moves_no_ground_under_the_pointer() {
    let mut window = map_window();
    let at = pos2(320.0, 260.0);
    press(&mut window, Modifiers::NONE, Key::D);
    click(&mut window, at);
    let before = corners(&window)[0];
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::P);
    assert!(window.query_by_label_contains("Depth profile, empty").is_some());
    click(&mut window, at);
    let with_plot = corners(&window)[0];
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::D);
    click(&mut window, at);
    for place in [with_plot, corners(&window)[0]] {
        assert!((place.lat_deg - before.lat_deg).abs() < 1e-9, "{place:?}");
        assert!((place.lon_deg - before.lon_deg).abs() < 1e-9, "{place:?}");
    }
}

#[test]
fn a_file_that_is_to_be_named_has_the_keyboard() {
    use egui_kittest::kittest::NodeT as _;
    let mut window = map_window();
    press(&mut window, Modifiers::NONE, Key::D);
    click(&mut window, pos2(200.0, 400.0));
    click(&mut window, pos2(300.0, 400.0));
    press(&mut window, Modifiers::NONE, Key::Enter);
    let mut window = {
        let figure = app(&window).map.measuring.figure.clone();
        let mut whole = demo_window();
        whole.state_mut().app.map.measuring.figure = figure;
        whole
    };
    window.run();
    by_palette(&mut window, "Save the measurement");
    let field = window.get_by_role_and_label(Role::TextInput, "File to write, .geojson or .csv");
    assert!(field.accesskit_node().is_focused(), "typing goes there");
    assert!(field.accesskit_node().value().is_some_and(|path| path.ends_with(".geojson")));
}
