//! Views printed from the window: asked for as an analyst would, looked at as a picture.

use crate::window::{Window, app, demo_window, press};
use bathyscope::app::{Command, MapLayer, Paper, PrintOptions};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::path::Path;

/// Types a path over the one that is proposed, and goes on.
pub(crate) fn name_file(window: &mut Window, label: &str, path: &Path, verb: &str) {
    let field = |window: &Window| window.get_by_role_and_label(Role::TextInput, label).focus();
    field(window);
    window.run();
    press(window, Modifiers::COMMAND, Key::A);
    window.get_by_role_and_label(Role::TextInput, label).type_text(&path.display().to_string());
    window.run();
    window.get_by_label(verb).click();
    window.run();
}

fn print(window: &mut Window, view: &str, options: PrintOptions, path: &Path) {
    let mut shown = app(window).view.options.clone();
    shown.print = options;
    window.state_mut().app.apply(Command::Show(Box::new(shown)));
    press(window, Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
    window.get_by_label("View to print").click();
    window.run();
    // The title of the view itself comes first.
    let entries = window.get_all_by_role_and_label(Role::Button, view);
    entries.last().expect("an entry of the list").click();
    window.run();
    window.get_by_label("Save…").click();
    window.run();
    name_file(window, "File to write", path, "Print");
}

fn notice(window: &Window) -> Vec<(&str, bool)> {
    let notices = app(window).notices.shown().iter();
    notices.map(|notice| (notice.text.as_str(), notice.is_error)).collect()
}

#[test]
fn views_are_printed_on_paper_and_in_pixels() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let mosaic = &mut window.state_mut().app.view.options.map.layers;
    mosaic.set_visible(MapLayer::Mosaic, true);
    window.run();
    let before = app(&window).view.options.clone();
    let paper = PrintOptions { dpi: 150, ..PrintOptions::default() };
    let narrow = PrintOptions {
        paper: Paper::Pixels,
        width_px: 900,
        light: false,
        ..PrintOptions::default()
    };
    for (view, options, size) in [
        ("Map", paper, [Some(1754), Some(1240)]),
        ("Waterfall", narrow.clone(), [Some(900), None]),
        ("3D cloud", narrow, [Some(900), None]),
    ] {
        let path = folder.path().join(format!("{view}.png"));
        print(&mut window, view, options, &path);
        assert!(notice(&window).iter().all(|(_, is_error)| !is_error), "{:?}", notice(&window));
        let picture = image::open(&path).expect("a picture").to_rgb8();
        let [width, height] = size;
        assert_eq!(Some(picture.width()), width);
        assert!(height.is_none_or(|height| picture.height() == height));
        let colours: std::collections::HashSet<_> = picture.pixels().collect();
        assert!(colours.len() > 100, "{view} is drawn");
        if let Some(keep) = std::env::var_os("BATHYSCOPE_KEEP") {
            std::fs::copy(&path, Path::new(&keep).join(format!("{view}.png"))).expect("a copy");
        }
        assert!(picture.get_pixel(2, 2).0.iter().all(|&level| (level > 150) == (view == "Map")));
    }
    let mut after = app(&window).view.options.clone();
    after.print = before.print.clone();
    assert_eq!(after, before, "the window looks as it did");
    let left = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 3, "nothing half written stays");
}

#[test]
fn what_cannot_be_printed_is_said() {
    let mut window = crate::window::empty_window();
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
    assert!(notice(&window)[0].0.contains("nothing to print"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let path = folder.path().join("map.sl2");
    print(&mut window, "Map", PrintOptions::default(), &path);
    assert!(notice(&window)[0].0.contains("ends in .png"), "{:?}", notice(&window));
    assert!(!path.exists());
}
