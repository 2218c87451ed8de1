//! The status bar has everything that is known of a place, and cuts nothing off.

use crate::calm_window::window_of;
use crate::logs_window::change;
use crate::window::{Window, app, demo_window, press};
use bathyscope::app::{Command, LogPlace};
use bathyscope_log::support::geo::CoordinateFormat;
use bathyscope_log::survey::{HeadingSource, Side};
use egui::{Key, Modifiers, Rect};
use egui_kittest::kittest::Queryable as _;

/// Texts of the status bar with their places, left to right.
fn status_bar(window: &Window) -> Vec<(String, Rect)> {
    use egui_kittest::kittest::NodeT as _;
    let height = window.ctx.content_rect().height();
    let nodes = window.query_all_by(|_| true);
    let named = nodes.filter_map(|node| {
        let accesskit = node.accesskit_node();
        let name = accesskit.label().or(accesskit.value())?;
        Some((name, node.rect()))
    });
    // What a panel holds beyond its lower edge lies there, too.
    let is_cell = |text: &str| {
        let starts =
            ["ping ", "range ", "altitude ", "depth ", "COG ", "compass ", "UTM ", "Notices"];
        let is_place = text.contains("° N") && text.contains("° ")
            || text.contains("' N")
            || text.contains("\" N");
        let is_time = text.ends_with("UTC") || text.ends_with(" s");
        is_place
            || is_time
            || text.ends_with("m/s")
            || starts.iter().any(|start| text.starts_with(start))
    };
    let in_bar = named.filter(|(text, rect)| {
        is_cell(text) && rect.top() > height - 26.0 && rect.bottom() < height + 1.0
    });
    let mut found: Vec<(String, Rect)> = in_bar.collect();
    found.sort_by(|(_, a), (_, b)| a.left().total_cmp(&b.left()));
    // A label is there twice: itself, and its text.
    found.dedup();
    found
}

#[test]
fn the_status_bar_names_the_place_and_lets_the_least_important_parts_go() {
    for (pixels, scale) in [([1920.0, 1080.0], 1.0), ([1280.0, 720.0], 1.0), ([1280.0, 720.0], 2.0)]
    {
        let mut window = window_of(pixels, scale, false);
        window.run();
        let mark =
            LogPlace { side: Some(Side::Starboard), sample: Some(700.0), ..LogPlace::ping(1204) };
        for format in CoordinateFormat::ALL {
            let state = window.state_mut();
            state.app.view.options.coordinates = format;
            state.app.apply(Command::Select(Some(mark)));
            window.run();
            let bar = status_bar(&window);
            let texts: Vec<&str> = bar.iter().map(|(text, _)| text.as_str()).collect();
            println!("{pixels:?} at {scale}: {}", texts.join(" | "));
            let whole = window.ctx.content_rect();
            assert!(bar.iter().all(|(_, rect)| whole.contains_rect(*rect)), "{bar:?}");
            let apart = bar.windows(2).all(|two| two[0].1.right() <= two[1].1.left() + 0.5);
            assert!(apart, "{bar:?}");
            let has = |start: &str| texts.iter().any(|text| text.starts_with(start));
            assert!(has("depth "), "{texts:?}");
            if whole.width() > 1000.0 {
                for start in ["ping ", "range ", "altitude ", "depth ", "COG "] {
                    assert!(has(start), "{start} of {texts:?}");
                }
                let has_end = |end: &str| texts.iter().any(|text| text.ends_with(end));
                assert!(has_end("m/s") && texts.iter().any(|text| text.contains(':')), "{texts:?}");
            }
        }
    }
}

#[test]
fn a_heading_of_the_compass_is_called_so() {
    let mut window = demo_window();
    window.state_mut().app.apply(Command::Select(Some(LogPlace::ping(1204))));
    let mut settings = app(&window).logs.shown.settings.as_ref().clone();
    settings.heading.source = HeadingSource::Compass;
    let change = Command::Change { settings: Box::new(settings), label: "heading", live: false };
    window.state_mut().app.apply(change);
    window.run();
    let texts = status_bar(&window);
    let starts = |start: &str| texts.iter().any(|(text, _)| text.starts_with(start));
    assert!(starts("compass ") && !starts("COG "), "{texts:?}");
}

#[test]
fn the_depth_line_names_what_is_missing_and_leads_to_its_control() {
    use egui_kittest::kittest::NodeT as _;
    let mut window = demo_window();
    window.run();
    for text in ["Depths below transducer", "draft not given", "water level not given"] {
        window.get_by_label(text);
    }
    window.get_by_label("sound speed 1500 m/s assumed");
    window.get_by_label_contains("error ±");
    window.get_by_label("draft not given").click();
    window.run();
    assert!(window.get_all_by_label("Draft").any(|control| control.accesskit_node().is_focused()));
    let sections = [
        ("Depths below transducer", "Depth correction section"),
        ("sound speed 1500 m/s assumed", "Depth correction section"),
        ("error ±", "Depth map section"),
    ];
    for (part, section) in sections {
        // The panel is shown if it was hidden.
        press(&mut window, Modifiers::NONE, Key::F7);
        window.get_by_label_contains(part).click();
        window.run();
        let title = window.get_by_label(section);
        assert!(title.accesskit_node().is_focused(), "{part}");
    }
    change(&mut window, "draft_m=0.3");
    window.run();
    window.get_by_label("Depths below surface");
    window.get_by_label("draft 0.30 m");
}
