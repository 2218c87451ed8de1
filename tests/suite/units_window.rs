//! The units of the window: nothing that it writes or says is left in metres, steps are round in
//! the unit that is shown, and controls take what is typed in it.

use crate::bottom::draw;
use crate::map_tools::click;
use crate::review::{detections, propose};
use crate::window::{
    Window, app, demo_window, drawn_window, open_section, open_step, press, settle,
};
use bathyscope::app::{Action, Command, LogPlace, MapLayer, WorkStep};
use bathyscope_bottom::presentation::units::{LengthUnit, SpeedUnit, Units};
use bathyscope_products::pipeline::settings::rows::ROWS;
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, Pos2, Rect, Shape, vec2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use std::collections::BTreeSet;

const FEET: Units = Units { length: LengthUnit::Feet, speed: SpeedUnit::Knots };

/// Returns true if a number with a metric unit of length, area or speed stands in a text.
fn is_metric(text: &str) -> bool {
    const METRIC: [&str; 9] = ["m", "m/s", "m²", "cm", "mm", "km", "ha", "km²", "metres"];
    let words: Vec<&str> = text.split_whitespace().collect();
    words.windows(2).any(|pair| {
        let is_figure = pair[0].ends_with(|c: char| c.is_ascii_digit());
        let unit = pair[1].trim_end_matches([',', '.', ';', ':', ')', ']', '…']);
        is_figure && METRIC.contains(&unit)
    })
}

/// Returns the texts of the accessibility tree: names, values and descriptions.
fn accessible_texts(window: &Window) -> Vec<String> {
    let nodes = window.query_all_by(|_| true);
    let words = nodes.flat_map(|node| {
        let node = node.accesskit_node();
        [node.label(), node.value(), node.description()]
    });
    words.flatten().collect()
}

/// Returns the texts that are painted, and their positions.
pub(crate) fn painted(window: &Window) -> Vec<(String, Pos2)> {
    fn take(shape: &Shape, into: &mut Vec<(String, Pos2)>) {
        match shape {
            Shape::Text(text) => into.push((text.galley.text().to_owned(), text.pos)),
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| take(shape, into)),
            _ => {}
        }
    }
    let mut texts = Vec::new();
    for clipped in &window.output().shapes {
        take(&clipped.shape, &mut texts);
    }
    texts
}

/// All texts that were seen so far.
#[derive(Default)]
struct Seen(BTreeSet<String>);

impl Seen {
    fn look(&mut self, window: &Window) {
        self.0.extend(accessible_texts(window));
        self.0.extend(painted(window).into_iter().map(|(text, _)| text));
    }

    /// Returns true if a text holds all of some words.
    fn holds(&self, words: &[&str]) -> bool {
        let all = |text: &String| words.iter().all(|word| text.contains(word));
        self.0.iter().any(all)
    }

    fn metric(&self) -> Vec<&String> {
        self.0.iter().filter(|text| is_metric(text)).collect()
    }
}

fn by_palette(window: &mut Window, name: &str) {
    press(window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text(name);
    window.run();
    press(window, Modifiers::NONE, Key::Enter);
}

fn view(window: &Window, name: &str) -> Rect {
    window.get_by_label_contains(name).rect()
}

fn look_at(window: &mut Window, seen: &mut Seen, at: Pos2) {
    window.hover_at(at);
    settle(window);
    // A hint comes when the pointer has rested.
    window.run_steps(4);
    seen.look(window);
}

/// Waterfall, map, cloud and all panels, of a window as tall as they are, with all layers on the
/// map.
fn feet_window() -> Window {
    let mut window = drawn_window([1700.0, 2600.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    window.run();
    by_palette(&mut window, "Units: feet");
    by_palette(&mut window, "Speeds: knots");
    assert_eq!(app(&window).view.options.units, FEET);
    let layers = &mut window.state_mut().app.view.options.map.layers;
    for layer in [MapLayer::Isobaths, MapLayer::Residuals, MapLayer::DepthMap] {
        if !layers.is_visible(layer) {
            layers.toggle(layer);
        }
    }
    let select = Command::Reveal(LogPlace::ping(400));
    window.state_mut().app.apply(select);
    settle(&mut window);
    window
}

#[test]
fn nothing_in_the_window_is_left_in_metres() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = feet_window();
    let found = detections(&window, 6);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    settle(&mut window);
    let mut seen = Seen::default();
    for step in WorkStep::ALL {
        open_step(&mut window, step);
        settle(&mut window);
        seen.look(&window);
    }
    for (step, title) in [
        (WorkStep::Correct, "Position"),
        (WorkStep::Correct, "Mounting"),
        (WorkStep::Correct, "Excluded"),
        (WorkStep::Map, "Mosaic"),
        (WorkStep::Map, "Cloud"),
        (WorkStep::Map, "Outliers"),
        (WorkStep::Map, "Survey planning"),
    ] {
        open_section(&mut window, step, title);
        seen.look(&window);
    }
    open_step(&mut window, WorkStep::Map);
    settle(&mut window);
    for name in ["Waterfall, pings", "Map, track", "3D point cloud"] {
        let rect = view(&window, name);
        for share in [0.35, 0.5, 0.62] {
            let at = rect.lerp_inside(vec2(share, 0.5));
            look_at(&mut window, &mut seen, at);
        }
    }
    // Over the ground, then with the channels that look down beside it.
    for action in [Action::GroundRange, Action::GroundRange, Action::NextChannel] {
        window.state_mut().app.apply(Command::Do(action));
        settle(&mut window);
        for name in ["Waterfall, pings", "Echogram, "] {
            let rect = window.query_all_by_label_contains(name).next().map(|node| node.rect());
            if let Some(rect) = rect {
                look_at(&mut window, &mut seen, rect.lerp_inside(vec2(0.4, 0.7)));
            }
        }
    }
    // On to the side-scan alone again.
    for _ in 0..8 {
        let echograms = window.query_all_by_label_contains("Echogram, ");
        if echograms.count() == 0 {
            break;
        }
        let next = Command::Do(Action::NextChannel);
        window.state_mut().app.apply(next);
        settle(&mut window);
        seen.look(&window);
    }
    // Lists that are folded at the start.
    for list in ["flat stretch", "warning"] {
        let folded = window.query_all_by_label_contains(list).next();
        if let Some(folded) = folded {
            folded.click_accesskit();
        }
    }
    window.run();
    seen.look(&window);
    let map = view(&window, "Map, track");
    let corners = [vec2(0.3, 0.5), vec2(0.5, 0.5), vec2(0.5, 0.35)];
    for (modifiers, key) in
        [(Modifiers::NONE, Key::D), (Modifiers::SHIFT, Key::D), (Modifiers::NONE, Key::P)]
    {
        window.hover_at(map.center());
        press(&mut window, modifiers, key);
        for corner in corners {
            click(&mut window, map.lerp_inside(corner));
        }
        seen.look(&window);
        press(&mut window, Modifiers::NONE, Key::Enter);
        settle(&mut window);
        seen.look(&window);
    }
    let plot = view(&window, "Depth profile, ").center();
    look_at(&mut window, &mut seen, plot);
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::Escape);
    let waterfall = view(&window, "Waterfall, pings");
    window.hover_at(waterfall.center());
    press(&mut window, Modifiers::NONE, Key::Num1);
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::H);
    draw(&mut window, Modifiers::NONE, (300.0, 6.0), (300.0, 7.5));
    seen.look(&window);
    press(&mut window, Modifiers::NONE, Key::Escape);
    // The speed of sound, and a change that the history names.
    open_step(&mut window, WorkStep::Correct);
    window.get_by_label("Correct the speed of sound").click_accesskit();
    settle(&mut window);
    press(&mut window, Modifiers::COMMAND, Key::H);
    seen.look(&window);

    for words in [
        &["ft below transducer"][..],
        &["Waterfall", "range", "ft"],
        &["Map, track", " ft below"],
        &["depth, ft"],
        &["residual, ft"],
        &["isobaths: ", " ft,"],
        &["elevation, ft"],
        &["Time line", " ft below"],
        &["Distance ", " ft"],
        &["Area ", " ft²"],
        &["Depth profile, ", " ft deep"],
        &["distance, ft"],
        &["Profile of ping", " ft"],
        &["Picture of box", " ft high"],
        &["Height from shadow: ", " ft"],
        &["E ", " ft  N "],
        &["range ", " ft\n", " on the ground"],
        &[" kn"],
        &["sound speed ", " ft/s"],
    ] {
        assert!(seen.holds(words), "{words:?} of {:#?}", seen.0);
    }
    println!("{} texts", seen.0.len());
    assert!(seen.metric().is_empty(), "{:#?}", seen.metric());
}

#[test]
fn hints_of_settings_are_turned_too() {
    assert!(is_metric("within 25 cm.") && is_metric("0.5 m/s") && !is_metric("22 px/m, 3 made"));
    let hints = ROWS.iter().map(|row| row.meaning());
    let metric: Vec<String> = hints.filter(|hint| is_metric(hint)).collect();
    assert!(metric.len() > 2, "hints with figures: {metric:?}");
    for hint in metric {
        let turned = FEET.sentence(&hint);
        assert!(!is_metric(&turned), "{turned}");
    }
}

#[test]
fn a_number_typed_in_feet_sets_metres() {
    let mut window = demo_window();
    window.state_mut().app.view.options.units = FEET;
    window.run();
    open_step(&mut window, WorkStep::Correct);
    window.get_by_role_and_label(Role::SpinButton, "Water level").focus();
    window.run();
    window.event(Event::Text("10".to_owned()));
    press(&mut window, Modifiers::NONE, Key::Enter);
    let level_m = app(&window).logs.shown.settings.water_level_m;
    assert!((level_m - 3.048).abs() < 1e-12, "{level_m}");
    window.get_by_role_and_label(Role::Slider, "Draft").set_value_accesskit(1.5);
    window.run();
    let draft_m = app(&window).logs.shown.settings.draft_m;
    assert!((draft_m - 0.4572).abs() < 1e-12, "{draft_m}");
    let label = app(&window).document.history.undo_label().map(|label| FEET.sentence(label));
    assert_eq!(label.as_deref(), Some("draft 1.50 ft"));
    // The greatest draft, 20 m, is no whole hundredth of a foot.
    window.get_by_role_and_label(Role::Slider, "Draft").set_value_accesskit(1000.0);
    window.run();
    assert_eq!(app(&window).logs.shown.settings.draft_m, 20.0);
    // Shown in metres again, nothing has changed.
    let before = app(&window).logs.shown.settings.clone();
    window.state_mut().app.apply(Command::Do(Action::UnitsMetres));
    window.run();
    assert_eq!(app(&window).logs.shown.settings, before);
}

/// 1, 2 or 5 times a power of ten.
fn is_round(value: f64) -> bool {
    let digit = value / 10f64.powi(value.log10().floor() as i32);
    [1.0, 2.0, 5.0, 10.0].iter().any(|round| (digit - round).abs() < 1e-6)
}

#[test]
fn range_lines_scale_bar_and_isobaths_are_round_in_feet() {
    let window = feet_window();
    let alone = |text: &str| text.strip_suffix(" ft")?.parse::<f64>().ok();
    let figures_in = |name: &str| -> Vec<f64> {
        let rect = view(&window, name);
        let texts = painted(&window).into_iter();
        let inside = texts.filter(|(_, at)| rect.contains(*at));
        inside.filter_map(|(text, _)| alone(&text)).collect()
    };
    let mut ranges = figures_in("Waterfall, pings");
    ranges.sort_by(f64::total_cmp);
    ranges.dedup();
    println!("range lines {ranges:?} ft");
    assert!(ranges.len() > 2 && is_round(ranges[0]), "{ranges:?}");
    for (index, range) in ranges.iter().enumerate() {
        assert!((range - (index + 1) as f64 * ranges[0]).abs() < 1e-9);
    }
    let bar = figures_in("Map, track");
    println!("scale bar {bar:?} ft");
    assert!(bar.len() == 1 && is_round(bar[0]), "{bar:?}");
    let levels_m = &app(&window).pipeline.deriving.isobaths().expect("isobaths").isobaths;
    let levels_m = &levels_m.as_ref().expect("levels").levels_m;
    let step_ft = (levels_m[1] - levels_m[0]) / 0.3048;
    println!("isobaths every {step_ft} ft");
    assert!(is_round(step_ft), "{step_ft}");
}

#[test]
fn the_window_in_feet_looks_as_it_did() {
    let mut window = drawn_window([1200.0, 760.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    let options = &mut window.state_mut().app.view.options;
    options.units = FEET;
    if !options.map.layers.is_visible(MapLayer::Isobaths) {
        options.map.layers.toggle(MapLayer::Isobaths);
    }
    window.run();
    let select = Command::Reveal(LogPlace::ping(400));
    window.state_mut().app.apply(select);
    settle(&mut window);
    window.snapshot("window_feet");
}
