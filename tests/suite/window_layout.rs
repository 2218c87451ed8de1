//! Tests that controls and panels of Bathyscope stay in their places, whatever comes and goes.

use crate::calm_window::window_of;
use crate::window::{Window, app, demo_window, drawn_window, open_step, press, settle};
use bathyscope::app::{Action, Command, FileToWrite, WorkStep};
use bathyscope_products::pipeline::{Preset, Settings};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;

#[test]
fn the_panels_keep_their_width_whatever_they_hold() {
    let mut window = demo_window();
    open_step(&mut window, WorkStep::Correct);
    let width = |window: &Window| {
        let section = window.get_by_label("Depth correction section");
        section.rect().width()
    };
    let before = width(&window);
    // With it come sliders whose unit is as long as m/s.
    window.get_by_label("Correct the speed of sound").click_accesskit();
    for _ in 0..30 {
        window.step();
    }
    window.run();
    assert_eq!(width(&window), before);
    let speed = window.get_by_role_and_label(Role::Slider, "Recorder");
    let row = speed.rect();
    let section = window.get_by_label("Depth correction section").rect();
    assert!(row.right() <= section.right() + 0.5, "{row} in {section}");
}

#[test]
fn notices_lie_over_the_views_and_move_nothing() {
    let mut window = demo_window();
    let places = |window: &Window| {
        ["Waterfall, pings", "Map, track of"].map(|name| window.get_by_label_contains(name).rect())
    };
    let before = places(&window);
    for text in ["one thing", "another thing"] {
        let command = Command::Notify(text.to_owned());
        window.state_mut().app.apply(command);
    }
    window.run();
    assert!(window.query_by_label("another thing").is_some());
    assert_eq!(places(&window), before);
    // The folder is named, and a button opens it.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("products");
    window.state_mut().app.apply(Command::Write(FileToWrite::Products(out.clone())));
    window.run();
    let notice = app(&window).notices.shown().last().expect("what was written");
    let end = format!(", into {}", out.display());
    assert!(notice.text.ends_with(&end), "{}", notice.text);
    assert_eq!(notice.offer, Some(Action::OpenExported));
    assert!(window.query_by_label("Open folder").is_some());
}

#[test]
fn what_cannot_be_removed_is_not_offered() {
    use egui_kittest::kittest::NodeT as _;
    let mut window = demo_window();
    window.get_by_label("File").click();
    window.run();
    window.get_by_label("Other files").click();
    window.run();
    let entry = |window: &Window, name: &str| {
        let entry = window.get_by_label_contains(name);
        entry.accesskit_node().is_disabled()
    };
    assert!(entry(&window, "Remove the base map"));
    assert!(entry(&window, "Remove the water levels"));
    assert!(!entry(&window, "Open base map"));
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text("base map");
    window.run();
    assert!(window.query_by_label_contains("Open base map").is_some());
    assert!(window.query_by_label_contains("Remove the base map").is_none());
}

#[test]
fn a_menu_of_a_view_breaks_no_word() {
    let mut window = demo_window();
    let map = window.get_by_label_contains("Map, track of").rect();
    // At the right edge there is no room beside the pointer.
    for at in [map.center(), map.right_center() - egui::vec2(3.0, 0.0)] {
        window.hover_at(at);
        for pressed in [true, false] {
            window.event(egui::Event::PointerButton {
                pos: at,
                button: egui::PointerButton::Secondary,
                pressed,
                modifiers: Modifiers::NONE,
            });
        }
        window.run();
        let entry = window.get_by_label("Copy position").rect();
        assert!(entry.height() < 26.0, "{entry}");
        let position = window
            .get_all_by_label_contains("° N")
            .map(|node| node.rect())
            .filter(|rect| (rect.left() - entry.left()).abs() < 12.0);
        for rect in position {
            assert!(rect.height() < 26.0, "the position in {rect}");
        }
        press(&mut window, Modifiers::NONE, Key::Escape);
    }
}

#[test]
fn the_cloud_is_in_view_after_a_change_of_preset() {
    use bathyscope::app::View;
    let picture = |first: Preset, then: Option<Preset>| {
        let mut window = drawn_window([500.0, 400.0]);
        // A new survey starts from these.
        (window.state_mut().app).use_settings(&Settings::preset(first));
        window.state_mut().app.apply(Command::OpenDemo);
        window.state_mut().show_alone(View::Cloud);
        settle(&mut window);
        if let Some(preset) = then {
            window.state_mut().app.apply(Command::UsePreset(preset));
            settle(&mut window);
        }
        window.render().expect("a picture")
    };
    // Mercator metres are longer, and the first point, from which places are counted, is another.
    let opened = picture(Preset::Published, None);
    let changed = picture(Preset::Recommended, Some(Preset::Published));
    let both = opened.pixels().zip(changed.pixels());
    let differing = both.filter(|(one, other)| one != other).count();
    assert!(differing < 200, "{differing} pixels differ");
}

/// Labels of the panels that take more than two lines, and those that the window cuts at its right
/// edge.
fn long_labels(window: &Window) -> Vec<String> {
    use egui_kittest::kittest::NodeT as _;
    // Three lines of small print are higher than two of the text.
    const TWO_LINES: f32 = 38.0;
    let size = window.ctx.content_rect().size();
    let labels = window.query_all_by_role(Role::Label);
    let wrong = labels.filter_map(|label| {
        let node = label.accesskit_node();
        let text = node.value().or_else(|| node.label())?;
        let rect = label.rect();
        let is_wrong = rect.height() > TWO_LINES || rect.right() > size.x + 0.5;
        is_wrong.then(|| format!("{rect}: {text}"))
    });
    wrong.collect()
}

#[test]
fn texts_of_panels_take_two_lines_at_most_and_none_is_cut() {
    let mut wrong = Vec::new();
    for scale in [1.0, 2.0] {
        let mut window = window_of([1280.0, 720.0], scale, true);
        wrong.extend(long_labels(&window));
        // With a proposed scale, a selected box and its tools.
        press(&mut window, Modifiers::NONE, Key::Tab);
        window.state_mut().app.apply(Command::Do(Action::Calibrate));
        settle(&mut window);
        wrong.extend(long_labels(&window));
        let layout = window.state_mut();
        layout.app.apply(Command::Do(Action::EditBox));
        settle(&mut window);
        wrong.extend(long_labels(&window));
    }
    wrong.sort();
    wrong.dedup();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
