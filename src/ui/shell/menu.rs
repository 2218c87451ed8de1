//! Draws the menu bar, whose entries come from the command table.

use super::sides::SidePanel;
use super::{levels, toolbar};
use crate::app::{Action, ActionGroup, App, CloudColour, Command, SideColours, ThemeChoice};
use crate::ui::ViewContext;
use crate::ui::controls::option_checkbox;
use bathyscope_bottom::presentation::colours::ColourMap;
use bathyscope_bottom::presentation::units::{LengthUnit, SpeedUnit};
use bathyscope_log::support::geo::CoordinateFormat;
use bathyscope_products::pipeline::BottomColour;
use egui::{Button, Ui};

/// Function that draws the entries of a menu.
type Contents = fn(&mut Ui, &mut ViewContext<'_>);

/// Draws the menu bar.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    egui::containers::menu::MenuBar::new().ui(ui, |ui| {
        let menus: [(&str, Contents); 6] = [
            ("File", file),
            ("Edit", edit),
            ("View", view),
            ("Survey", survey),
            ("Review", review),
            ("Help", |ui, context| entries(ui, context, ActionGroup::Help)),
        ];
        for (title, contents) in menus {
            ui.menu_button(title, |ui| scrolled(ui, |ui| contents(ui, context)));
        }
        ui.separator();
        buttons(ui, context);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            SidePanel::Details.button(ui, context);
            SidePanel::Steps.button(ui, context);
            theme_button(ui, context);
            palette_field(ui, context);
        });
    });
}

/// Draws a menu, which scrolls if it is longer than the window is tall.
fn scrolled(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    let most = ui.content_rect().bottom() - ui.cursor().top() - 16.0;
    egui::ScrollArea::vertical().max_height(most.max(120.0)).show(ui, add);
}

fn titled(ui: &mut Ui, context: &mut ViewContext<'_>, action: Action, title: &str, enabled: bool) {
    let button = Button::new(title).shortcut_text(action.key());
    let response = ui.add_enabled(enabled, button);
    if response.on_hover_text(action.hint()).clicked() {
        context.push(Command::Do(action));
        ui.close();
    }
}

fn entries(ui: &mut Ui, context: &mut ViewContext<'_>, group: ActionGroup) {
    entries_where(ui, context, group, App::is_available);
}

/// Draws the entries of a group; those for which `enabled` is false cannot be chosen.
fn entries_where(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    group: ActionGroup,
    enabled: impl Fn(&App, Action) -> bool,
) {
    for action in group.actions() {
        let enabled = enabled(context.app, action);
        titled(ui, context, action, action.label(), enabled);
    }
}

fn file(ui: &mut Ui, context: &mut ViewContext<'_>) {
    entries(ui, context, ActionGroup::File);
    let recent = context.app.recent.clone();
    ui.add_enabled_ui(!recent.is_empty(), |ui| {
        ui.menu_button("Recent", |ui| {
            for path in recent {
                let shown = path.display().to_string();
                if ui.button(shown).clicked() {
                    context.push(Command::Open(path));
                    ui.close();
                }
            }
        });
    });
    ui.separator();
    entries(ui, context, ActionGroup::MapFiles);
    ui.separator();
    let is_open = context.app.logs.shown.survey.is_some();
    entries_where(ui, context, ActionGroup::External, |app, action| {
        is_open && app.is_available(action)
    });
    ui.separator();
    entries(ui, context, ActionGroup::LogCopies);
    let ready = context.app.logs.shown.products.is_some();
    entries_where(ui, context, ActionGroup::Export, |_, _| ready);
    ui.separator();
    entries(ui, context, ActionGroup::Quit);
}

fn edit(ui: &mut Ui, context: &mut ViewContext<'_>) {
    // A change that was made in metres is named in the present unit.
    let units = context.units();
    for (action, label) in [
        (Action::Undo, context.app.document.history.undo_label()),
        (Action::Redo, context.app.document.history.redo_label()),
    ] {
        let title = match label {
            Some(label) => format!("{} {}", action.label(), units.sentence(label)),
            None => action.label().to_owned(),
        };
        titled(ui, context, action, &title, label.is_some());
    }
    entries(ui, context, ActionGroup::History);
}

fn view(ui: &mut Ui, context: &mut ViewContext<'_>) {
    ui.menu_button("Steps", |ui| entries(ui, context, ActionGroup::WorkSteps));
    entries(ui, context, ActionGroup::Layout);
    ui.separator();
    entries(ui, context, ActionGroup::Camera);
    ui.separator();
    let mut options = context.options().clone();
    ui.menu_button("Waterfall", |ui| {
        for map in ColourMap::ALL {
            ui.radio_value(&mut options.waterfall.colour_map, map, map.name());
        }
        ui.separator();
        ui.menu_button("Gain and levels", |ui| levels::ui(ui, context));
        ui.separator();
        for action in [
            Action::GroundRange,
            Action::WaterColumn,
            Action::FirstReturnLine,
            Action::RangeLines,
            Action::DepthLine,
        ] {
            option_checkbox(ui, &mut options, action);
        }
        ui.checkbox(&mut options.waterfall.flat_stretches, "Flat stretches");
        ui.checkbox(&mut options.waterfall.boxes, "Boxes");
    });
    ui.menu_button("Map", |ui| {
        toolbar::layers_control(ui, &mut options.map.layers);
        toolbar::swipe_control(ui, &mut options.map);
        ui.separator();
        ui.checkbox(&mut options.map.flat_spots, "Flat stretches");
        option_checkbox(ui, &mut options, Action::Graticule);
    });
    ui.menu_button("3D cloud", |ui| {
        for colour in CloudColour::ALL {
            let name = format!("by {}", colour.name());
            ui.radio_value(&mut options.cloud.colour, colour, name);
        }
        ui.separator();
        option_checkbox(ui, &mut options, Action::Bottom3d);
        for colour in BottomColour::ALL {
            let name = format!("bottom by {}", colour.name());
            ui.radio_value(&mut options.cloud.bottom_colour, colour, name);
        }
        option_checkbox(ui, &mut options, Action::BottomIsobaths);
        ui.separator();
        option_checkbox(ui, &mut options, Action::Points3d);
        option_checkbox(ui, &mut options, Action::OutlierPreview);
        ui.checkbox(&mut options.cloud.boxes, "Boxes");
        option_checkbox(ui, &mut options, Action::Water3d);
    });
    ui.menu_button("Coordinates", |ui| {
        for format in CoordinateFormat::ALL {
            ui.radio_value(&mut options.coordinates, format, format.name());
        }
    });
    ui.menu_button("Units", |ui| {
        for unit in LengthUnit::ALL {
            ui.radio_value(&mut options.units.length, unit, unit.name());
        }
        ui.separator();
        for unit in SpeedUnit::ALL {
            ui.radio_value(&mut options.units.speed, unit, unit.name());
        }
    });
    ui.menu_button("Side colours", |ui| {
        let paper = "paper: starboard red, port blue";
        ui.radio_value(&mut options.side_colours, SideColours::Paper, paper);
        let maritime = "maritime: port red, starboard green";
        ui.radio_value(&mut options.side_colours, SideColours::Maritime, maritime);
    });
    if context.app.logs.has_swath() {
        ui.checkbox(&mut options.swath.0, "Points across the track (swath)")
            .on_hover_text("Draws the points of StructureScan 3D on the map and in 3D.");
    }
    context.show(options);
    entries(ui, context, ActionGroup::Look);
}

fn survey(ui: &mut Ui, context: &mut ViewContext<'_>) {
    entries(ui, context, ActionGroup::Processing);
    ui.separator();
    ui.menu_button("Measure", |ui| entries(ui, context, ActionGroup::Measuring));
    ui.menu_button("Survey planning", |ui| entries(ui, context, ActionGroup::Planning));
    ui.menu_button("Mounting", |ui| entries(ui, context, ActionGroup::Mounting));
    entries_where(ui, context, ActionGroup::Comparing, |app, action| match action {
        Action::CompareWith => app.logs.shown.products.is_some(),
        _ => app.map.comparing.reference.is_some(),
    });
    ui.separator();
    entries(ui, context, ActionGroup::Pings);
}

fn review(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let is_open = context.app.logs.shown.survey.is_some();
    let has_boxes = context.app.logs.has_boxes();
    let is_known = context.app.logs.shown.reviewing.judging.source().is_some();
    entries_where(ui, context, ActionGroup::Detector, |app, action| {
        action != Action::FindObjects || app.logs.shown.products.is_some()
    });
    ui.separator();
    entries_where(ui, context, ActionGroup::Boxes, |_, action| {
        is_open && (has_boxes || matches!(action, Action::NewBox | Action::MarkTarget))
    });
    ui.separator();
    entries_where(ui, context, ActionGroup::ReviewFiles, |_, action| {
        is_open && (has_boxes || action == Action::OpenReview)
    });
    ui.separator();
    entries_where(ui, context, ActionGroup::Truth, |_, action| {
        is_open && (is_known || action == Action::OpenTruth)
    });
}

fn buttons(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let undo = context.app.document.history.undo_label();
    let redo = context.app.document.history.redo_label();
    let units = context.units();
    let open = "Open";
    for (action, label, enabled, what) in [
        (Action::Open, open, true, None),
        (Action::Undo, "Undo", undo.is_some(), undo),
        (Action::Redo, "Redo", redo.is_some(), redo),
    ] {
        let hint = what.map_or_else(
            || action.hint().to_owned(),
            |what| format!("{}: {}", action.label(), units.sentence(what)),
        );
        let hint = format!("{hint} ({})", action.key());
        let button = ui.add_enabled(enabled, Button::new(label));
        let button = button.accessible_name(format!("{label} button"));
        context.button_with_hint(button, action, hint);
    }
}

fn theme_button(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let label = match context.theme() {
        ThemeChoice::Dark => "Light",
        ThemeChoice::Light => "Dark",
    };
    let button = ui.button(label).accessible_name(Action::Theme.label());
    context.keyed_button(button, Action::Theme);
}

fn palette_field(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let action = Action::Palette;
    let room = (ui.available_width() - 8.0).min(280.0);
    // The menus take most of a narrow bar: there the palette is opened by its key only.
    let (title, keys) = match room {
        240.0.. => ("Search or run a command", action.keys()),
        130.0.. => ("Search", action.keys()),
        60.0.. => ("Search", None),
        _ => return,
    };
    let button = Button::new(egui::RichText::new(title).weak())
        .shortcut_text(keys.unwrap_or_default())
        .min_size(egui::vec2(room, 20.0))
        .fill(ui.visuals().extreme_bg_color);
    if ui.add(button).accessible_name(action.label()).clicked() {
        context.push(Command::Do(action));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Groups whose commands have their place elsewhere: in toolbars, panels and notices, or as
    /// keys alone.
    const ELSEWHERE: [&str; 10] = [
        "OtherLogs",
        "Exported",
        "Undo",
        "Focus",
        "WaterfallPicture",
        "MapLayers",
        "Colours",
        "Coordinates",
        "Units",
        "MeasuringByKey",
    ];

    #[test]
    fn each_group_of_commands_is_in_a_menu_or_has_its_place_elsewhere() {
        let source = include_str!("menu.rs");
        for action in Action::ALL {
            let group = format!("{:?}", action.group());
            let is_in_menu = source.contains(&format!("ActionGroup::{group})"))
                || source.contains(&format!("ActionGroup::{group},"));
            let is_elsewhere = ELSEWHERE.contains(&&*group);
            assert_ne!(is_in_menu, is_elsewhere, "{group} of {}", action.label());
        }
    }
}
