//! The help page: every command with its key and what it does.

use crate::app::Action;
use egui::{Grid, RichText, ScrollArea, Window};

/// What the mouse does in all views.
const MOUSE: &[(&str, &str)] = &[
    ("Wheel", "Zooms at the pointer."),
    (
        "Drag, or middle button",
        "Moves the view; turns the 3D cloud.",
    ),
    ("Shift + wheel", "Moves along the track in the waterfall."),
    ("Click", "Selects what is there, in all views."),
    (
        "Double-click",
        "Shows everything; on a title, gives the view the whole centre.",
    ),
];

/// Keys that mean something else while a box is selected.
const BOX_KEYS: &[(&str, &str, &str)] = &[
    (
        "Class of the box",
        "1 to 9",
        "While a box is selected the digits name its class; Escape gives them back to the views.",
    ),
    (
        "Move the box",
        "Arrows",
        "While a box is edited: a ping along the track, a pixel across it; ten with Shift.",
    ),
    (
        "Resize the box",
        "Ctrl+Arrows",
        "While a box is edited: moves its right and lower edges; ten steps with Shift.",
    ),
];

/// Draws the page while it is open.
pub fn ui(ctx: &egui::Context, open: &mut bool) {
    if *open && ctx.input(|input| input.key_pressed(egui::Key::Escape)) {
        *open = false;
    }
    Window::new("Keys and commands")
        .open(open)
        .collapsible(false)
        .default_size([620.0, 560.0])
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ctx, |ui| {
            ScrollArea::vertical()
                .auto_shrink([false, true])
                .show(ui, |ui| {
                    ui.label(concat!("Bathyscope ", env!("CARGO_PKG_VERSION")));
                    table(
                        ui,
                        "mouse",
                        MOUSE.iter().map(|&(what, does)| (what, "", does)),
                    );
                    ui.separator();
                    let actions = Action::ALL.iter().map(|action| {
                        (
                            action.label(),
                            action.keys().unwrap_or_default(),
                            action.hint(),
                        )
                    });
                    table(ui, "commands", actions);
                    ui.separator();
                    table(ui, "boxes", BOX_KEYS.iter().copied());
                });
        });
}

fn table<'a>(ui: &mut egui::Ui, id: &str, rows: impl Iterator<Item = (&'a str, &'a str, &'a str)>) {
    Grid::new(id)
        .num_columns(3)
        .striped(true)
        .min_col_width(90.0)
        .spacing([14.0, 3.0])
        .show(ui, |ui| {
            for (label, keys, hint) in rows {
                ui.label(RichText::new(label).strong());
                ui.label(RichText::new(keys).monospace());
                ui.label(hint);
                ui.end_row();
            }
        });
}
