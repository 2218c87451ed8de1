//! A window that stays out of the way: room for the views in a small one, notices that are kept,
//! banners of tools, knobs that say what they stand for.

use crate::review::{detections, propose};
use crate::support::snapshot_options;
use crate::units_window::painted;
use crate::window::{
    Window, app, demo_window, drop_file, empty_window, open_section, open_step, press, settle,
};
use bathyscope::app::{Action, App, Command, Jobs, ThemeChoice, View, WorkStep};
use bathyscope::ui::Shell;
use bathyscope_bottom::presentation::units::{LengthUnit, Units};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{By, NodeT as _, Queryable as _};

/// A window of so many pixels, with so many of them to a point.
pub(crate) fn window_of(pixels: [f32; 2], pixels_per_point: f32, draws: bool) -> Window {
    let builder = Harness::builder()
        .with_pixels_per_point(pixels_per_point)
        .with_size(pixels.map(|side| side / pixels_per_point))
        .with_max_steps(24)
        .with_options(snapshot_options())
        .with_render_cursor(false);
    let shell = |_: &mut eframe::CreationContext<'_>| Shell::new(App::new(Jobs::Inline));
    let mut window =
        if draws { builder.wgpu().build_eframe(shell) } else { builder.build_eframe(shell) };
    window.run();
    window.state_mut().app.apply(Command::OpenDemo);
    window.run();
    window
}

/// Returns the area of the views, with their titles.
fn views(window: &Window) -> Rect {
    let names = ["Waterfall, pings", "Map, track of", "3D point cloud"];
    let nodes = names.into_iter().flat_map(|name| {
        let nodes = window.query_all_by_label_contains(name);
        nodes.map(|node| node.rect()).collect::<Vec<_>>()
    });
    let all = nodes.reduce(Rect::union).expect("a view");
    all.with_min_y(all.top() - 26.0)
}

/// Labels and controls that reach beyond the right edge of the window or of their panel.
fn cut_off(window: &Window) -> Vec<(String, Rect)> {
    let width = window.ctx.content_rect().width();
    let height = window.ctx.content_rect().height();
    let inner = |name: &str| window.query_by_label(name).map(|node| node.rect());
    let panels: Vec<Rect> =
        ["Survey section", "Selection section"].into_iter().filter_map(inner).collect();
    let nodes = window.query_all_by(|_| true);
    let named = nodes.filter_map(|node| {
        let accesskit = node.accesskit_node();
        let roles = [Role::Window, Role::GenericContainer, Role::Pane, Role::ScrollBar];
        if roles.contains(&accesskit.role()) {
            return None;
        }
        let name = accesskit.label().or(accesskit.value())?;
        // The table of objects is scrolled sideways.
        let is_cell = name.starts_with("Sort objects") || name.starts_with("Object ");
        Some((name, node.rect())).filter(|_| !is_cell)
    });
    let is_cut = |rect: &Rect| {
        let is_in_sight = rect.top() < height && rect.bottom() > 0.0;
        // Between the bars of menus and steps and the lines of depths and of the place under the
        // pointer.
        let is_in_panel = rect.top() > 26.0 + 24.0 && rect.bottom() < height - 24.0 - 19.0;
        let panel = panels.iter().find(|panel| {
            let begins = panel.left() - 1.0..panel.right();
            is_in_panel && begins.contains(&rect.left())
        });
        let edge = panel.map_or(width, |panel| panel.right());
        is_in_sight && rect.right() > edge + 1.5
    };
    named.filter(|(_, rect)| is_cut(rect)).collect()
}

#[test]
fn a_small_window_leaves_half_of_it_to_the_views_and_cuts_nothing_off() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (pixels, scale) in [([1280.0, 720.0], 1.0), ([1920.0, 1080.0], 2.0), ([1280.0, 720.0], 2.0)]
    {
        let mut window = window_of(pixels, scale, false);
        let found = detections(&window, 6);
        propose(&mut window, &found, folder.path());
        window.state_mut().app.notices.clear();
        press(&mut window, Modifiers::NONE, Key::Tab);
        let whole = window.ctx.content_rect();
        // A view has its name when its picture is there, which comes from a thread of its own.
        for () in bathyscope_test_support::attempts() {
            if views(&window).area() >= 0.5 * whole.area() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(50));
            window.run();
        }
        let share = views(&window).area() / whole.area();
        println!("{pixels:?} at {scale}: views have {:.0} %", 100.0 * share);
        assert!(share >= 0.5, "{pixels:?} at {scale}: {share}");
        // With either panel, and what a busy bar says.
        for key in [None, Some(Key::F7), Some(Key::F8)] {
            if let Some(key) = key {
                press(&mut window, Modifiers::NONE, key);
            }
            let cut = cut_off(&window);
            assert!(cut.is_empty(), "{pixels:?} at {scale}, {key:?}: {cut:#?}");
        }
        // Every menu is reached, and the palette and the manual lie in the window.
        for menu in ["File", "Edit", "View", "Survey", "Review", "Help"] {
            let button = window.get_by_role_and_label(Role::Button, menu).rect();
            assert!(button.right() < whole.right(), "{menu} at {button}");
        }
        press(&mut window, Modifiers::COMMAND, Key::P);
        let field = window.get_by_label("Command").rect();
        assert!(whole.contains_rect(field), "{field} in {whole}");
        press(&mut window, Modifiers::NONE, Key::Escape);
    }
}

#[test]
fn the_panels_go_and_come_by_key_and_stay_so() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    window.get_by_label("Selection section");
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).view.selection, None);
    window.run_steps(10);
    assert!(window.query_by_label("Selection section").is_none(), "the views have its room");
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    let before = views(&window).width();
    press(&mut window, Modifiers::NONE, Key::F7);
    assert!(window.query_by_label("Survey section").is_none());
    press(&mut window, Modifiers::NONE, Key::F8);
    assert!(window.query_by_label("Selection section").is_none());
    assert!(views(&window).width() > before + 450.0);
    // As the window keeps it between runs.
    let text = serde_json::to_string(&app(&window).view.options).expect("text");
    let kept: bathyscope::app::ViewOptions = serde_json::from_str(&text).expect("options");
    let mut next = demo_window();
    next.state_mut().app.view.options = kept;
    next.run();
    assert!(next.query_by_label("Survey section").is_none());
    let button = Action::StepsPanel.label();
    next.get_by_role_and_label(Role::Button, button).click();
    next.run();
    next.run();
    assert!(next.query_by_label("Survey section").is_some());
    // A section folds by a click on its title.
    open_step(&mut next, WorkStep::Bottom);
    let knob = |window: &Window| {
        let knobs = window.query_all_by_role_and_label(Role::Slider, "Dead zone");
        knobs.count()
    };
    assert_eq!(knob(&next), 1);
    next.get_by_label("First return section").click();
    next.run();
    assert_eq!(knob(&next), 0);
}

#[test]
fn notices_are_kept_in_a_list_and_lie_over_no_time_line() {
    let mut window = demo_window();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let missing = folder.path().join("lake 5 m deep.sl2");
    window.state_mut().app.view.options.units =
        Units { length: LengthUnit::Feet, ..Units::default() };
    drop_file(&mut window, missing);
    let shown = window.get_by_label_contains("lake 5 m deep").rect();
    let line = window.get_by_label_contains("Time line, ping").rect();
    assert!(!shown.intersects(line), "{shown} over {line}");
    window.get_by_label("Dismiss").click();
    window.run();
    assert!(window.query_by_label_contains("lake 5 m deep").is_none());
    press(&mut window, Modifiers::NONE, Key::F9);
    window.run();
    assert!(window.query_by_label_contains("lake 5 m deep").is_some());
    assert!(window.query_by_label("needs attention").is_some());
    assert!(window.query_all_by_label_contains(" UTC").next().is_some());
    press(&mut window, Modifiers::NONE, Key::F9);
    assert!(window.query_by_label_contains("lake 5 m deep").is_none());
}

#[test]
fn what_is_typed_in_the_frame_of_the_palettes_key_goes_into_its_field() {
    let mut window = demo_window();
    let key = |key: Key, modifiers: Modifiers| Event::Key {
        key,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers,
    };
    let typed = "turn the w".chars().flat_map(|letter| {
        let pressed = Key::from_name(&letter.to_uppercase().to_string());
        let text = Event::Text(letter.to_string());
        let pressed = pressed.map(|pressed| key(pressed, Modifiers::NONE));
        pressed.into_iter().chain([text])
    });
    let events: Vec<Event> =
        std::iter::once(key(Key::P, Modifiers::COMMAND)).chain(typed).collect();
    let before = app(&window).view.options.waterfall.orientation;
    window.input_mut().events.extend(events);
    window.step();
    // T, N and W mean tools: none was taken.
    assert!(app(&window).map.measuring.tool.is_none());
    assert_eq!(app(&window).logs.shown.reviewing.tool, Default::default());
    window.step();
    let field = window.get_by_label("Command");
    let value = field.accesskit_node().value();
    assert_eq!(value.as_deref(), Some("turn the w"));
    window.event(Event::Text("a".to_owned()));
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_ne!(app(&window).view.options.waterfall.orientation, before);
}

#[test]
fn each_tool_has_a_banner_in_the_views_that_it_is_of_use_in() {
    let mut window = demo_window();
    for (modifiers, key, name, count) in [
        (Modifiers::NONE, Key::D, "Measure distance: ", 2),
        (Modifiers::SHIFT, Key::D, "Measure area: ", 2),
        (Modifiers::NONE, Key::P, "Depth profile: ", 2),
        (Modifiers::NONE, Key::H, "Height from shadow: ", 2),
        (Modifiers::NONE, Key::N, "New box: ", 1),
        (Modifiers::NONE, Key::T, "Mark target: ", 1),
        (Modifiers::NONE, Key::M, "Draw the bottom: ", 1),
        (Modifiers::NONE, Key::K, "Exclude stretches: ", 2),
    ] {
        press(&mut window, modifiers, key);
        let banners: Vec<Rect> =
            (window.query_all_by_label_contains(name)).map(|node| node.rect()).collect();
        assert_eq!(banners.len(), count, "{name}");
        let waterfall = window.get_by_label_contains("Waterfall, pings").rect();
        assert!(waterfall.contains_rect(banners[0].intersect(waterfall)));
        press(&mut window, Modifiers::NONE, Key::Escape);
        assert!(window.query_by_label_contains(name).is_none(), "{name}");
    }
    press(&mut window, Modifiers::NONE, Key::C);
    let banner = "Calibrate on a stretch: drag along level bottom";
    assert_eq!(window.query_all_by_label_contains(banner).count(), 2);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(window.query_by_label_contains(banner).is_none());
}

#[test]
fn zero_that_stands_for_no_value_says_so() {
    let mut window = demo_window();
    // As tall as its panels.
    window.set_size(egui::vec2(1400.0, 2800.0));
    window.run();
    let says = |window: &Window, word: &str| painted(window).iter().any(|(text, _)| text == word);
    open_step(&mut window, WorkStep::Map);
    assert!(says(&window, "automatic"), "the interval of the isobaths");
    open_section(&mut window, WorkStep::Correct, "Excluded");
    assert!(says(&window, "none"), "no turn is excluded");
    let stops = window.get_by_role_and_label(Role::Slider, "Stops below");
    stops.set_value_accesskit(0.5);
    window.run();
    let shown = painted(&window);
    assert!(shown.iter().any(|(text, _)| text.starts_with("0.5")), "{shown:?}");
    assert_eq!(app(&window).document.history.undo_label(), Some("stops to exclude 0.50 m/s"));
}

#[test]
fn a_change_is_named_in_the_units_of_the_day_it_is_read() {
    let mut window = demo_window();
    let feet = Units { length: LengthUnit::Feet, ..Units::default() };
    window.state_mut().app.view.options.units = feet;
    window.run();
    open_step(&mut window, WorkStep::Correct);
    let draft = window.get_by_role_and_label(Role::Slider, "Draft");
    draft.set_value_accesskit(5.0);
    window.run();
    let label = app(&window).document.history.undo_label().expect("a change").to_owned();
    assert_eq!(label, "draft 1.524 m");
    assert_eq!(feet.sentence(&label), "draft 5.00 ft");
}

#[test]
fn the_next_box_comes_one_to_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 6);
    propose(&mut window, &found, folder.path());
    let wide = app(&window).view.visible.len();
    press(&mut window, Modifiers::NONE, Key::Tab);
    window.run();
    let near = app(&window).view.visible.clone();
    let shown = app(&window).logs.shown.reviewing.selected_box().expect("a box");
    let pings = shown.mark.pings.clone();
    assert!(near.start <= pings.start && pings.end <= near.end);
    println!("{wide} pings before, {} one to one", near.len());
    assert!(near.len() < wide && near.len() > 2 * pings.len());
    // The same scale for the next one, and left alone when that is wished for.
    press(&mut window, Modifiers::NONE, Key::Tab);
    window.run();
    let next = app(&window).view.visible.len();
    assert!(next.abs_diff(near.len()) <= near.len() / 4, "{next}");
    press(&mut window, Modifiers::SHIFT, Key::Z);
    assert!(!app(&window).view.options.waterfall.zooms_to_boxes);
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::Tab);
    window.run();
    assert!(app(&window).view.visible.len() > 1000);
}

#[test]
fn an_empty_small_window_offers_what_would_fill_it() {
    let mut window = empty_window();
    window.set_size(egui::vec2(640.0, 360.0));
    window.run();
    for offer in ["Open survey…", "Open the demo survey"] {
        window.get_by_label(offer);
    }
}

/// Returns the number of buttons, switches, fields and other controls that the window draws.
fn controls(window: &Window) -> usize {
    let is_control = |role: Role| {
        matches!(
            role,
            Role::Button
                | Role::CheckBox
                | Role::ComboBox
                | Role::Link
                | Role::RadioButton
                | Role::Slider
                | Role::SpinButton
                | Role::Switch
                | Role::TextInput
        )
    };
    let nodes = window.query_all(By::new().predicate(move |node| is_control(node.role())));
    nodes.count()
}

#[test]
fn an_empty_window_and_the_demo_have_few_controls() {
    let mut window = empty_window();
    window.set_size(egui::vec2(1440.0, 900.0));
    window.run();
    let empty = controls(&window);
    window.get_by_label("Open the demo survey").click();
    settle(&mut window);
    let demo = controls(&window);
    println!("{empty} controls in an empty window, {demo} after the demo was opened");
    assert!(empty <= 12 && demo <= 45, "{empty}, {demo}");
}

#[test]
fn the_tour_leads_through_the_steps_of_the_demo_and_can_be_ended() {
    let mut window = empty_window();
    window.get_by_label("Tour of the six steps").click();
    settle(&mut window);
    assert_eq!(app(&window).logs.count(), 1);
    for step in WorkStep::ALL {
        assert_eq!(app(&window).view.options.panels.step, step);
        assert!(window.query_by_label("End the tour").is_some(), "{step:?}");
        if let Some(next) = window.query_by_label("Next step") {
            next.click();
            settle(&mut window);
        }
    }
    window.get_by_label("End the tour").click();
    window.run();
    assert!(window.query_by_label("End the tour").is_none());
}

#[test]
fn small_windows_look_as_they_did() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = window_of([1280.0, 720.0], 1.0, true);
    let found = detections(&window, 12);
    propose(&mut window, &found, folder.path());
    window.state_mut().app.notices.clear();
    window.state_mut().app.view.options.theme = ThemeChoice::Light;
    press(&mut window, Modifiers::NONE, Key::Tab);
    press(&mut window, Modifiers::NONE, Key::E);
    settle(&mut window);
    window.snapshot("window_1280x720_light");
    let mut snapshots = window.take_snapshot_results();
    let mut window = window_of([1280.0, 720.0], 2.0, true);
    window.state_mut().app.apply(Command::Focus(View::Waterfall));
    press(&mut window, Modifiers::NONE, Key::G);
    press(&mut window, Modifiers::NONE, Key::D);
    settle(&mut window);
    window.snapshot("window_200_percent");
    snapshots.extend(window.take_snapshot_results());
}
