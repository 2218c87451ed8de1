//! Draws the menu bar, whose entries come from the command table.

use super::sides::SidePanel;
use super::{levels, toolbar};
use crate::app::{Action, ActionGroup, CloudColour, Command, SideColours, ViewOptions};
use crate::ui::ViewContext;
use crate::ui::controls::option_checkbox;
use bathyscope_bottom::presentation::colours::ColourMap;
use bathyscope_bottom::presentation::units::{LengthUnit, SpeedUnit};
use bathyscope_log::support::geo::CoordinateFormat;
use bathyscope_products::pipeline::BottomColour;
use egui::{Button, Ui};

/// Entries of a menu.
enum Item {
    /// The commands of a group; those that are options have a checkbox.
    Group(ActionGroup),
    /// A menu that opens beside this one.
    Menu(&'static str, &'static [Item]),
    /// A line between two groups.
    Line,
    /// A function that draws entries that are no commands, or have names that change: two beside
    /// others, or the values of an option.
    Drawn(fn(&mut Ui, &mut ViewContext<'_>)),
}

use Item::{Drawn, Group, Line, Menu};

/// The menus of the bar.
const MENUS: [(&str, &[Item]); 6] = [
    ("File", FILE),
    ("Edit", &[Drawn(undo_and_redo), Group(ActionGroup::History)]),
    ("View", VIEW),
    ("Survey", SURVEY),
    ("Review", REVIEW),
    ("Help", &[Group(ActionGroup::Help)]),
];

const FILE: &[Item] = &[
    Group(ActionGroup::File),
    Menu("Recent", &[Drawn(recent)]),
    Line,
    Group(ActionGroup::Project),
    Menu("This log", &[Group(ActionGroup::ShownLog), Line, Group(ActionGroup::LogCopies)]),
    Line,
    Menu("Other files", &[Group(ActionGroup::External), Line, Group(ActionGroup::MapFiles)]),
    Line,
    Group(ActionGroup::Export),
    Group(ActionGroup::Quit),
];

const VIEW: &[Item] = &[
    Menu("Steps", &[Group(ActionGroup::WorkSteps)]),
    Menu("Arrangement", &[Group(ActionGroup::Layout)]),
    Menu("Views and panels", &[Group(ActionGroup::Window)]),
    Menu("Camera", &[Group(ActionGroup::Camera)]),
    Line,
    Menu(
        "Waterfall",
        &[
            Menu("Colours", &[Drawn(waterfall_colours)]),
            Menu("Gain and levels", &[Drawn(levels::ui)]),
            Line,
            Group(ActionGroup::WaterfallPicture),
            Drawn(waterfall_marks),
        ],
    ),
    Menu("Map", &[Drawn(map)]),
    Menu(
        "3D cloud",
        &[
            Menu("Colours of the points", &[Drawn(cloud_colours)]),
            Menu("Colours of the bottom", &[Drawn(bottom_colours)]),
            Line,
            Group(ActionGroup::Cloud3d),
        ],
    ),
    Line,
    Menu("Coordinates", &[Drawn(coordinates)]),
    Menu("Units", &[Drawn(units)]),
    Menu("Colours of the sides", &[Drawn(side_colours)]),
    Group(ActionGroup::Look),
];

const SURVEY: &[Item] = &[
    Group(ActionGroup::Processing),
    Menu("Presets", &[Group(ActionGroup::Presets)]),
    Line,
    Menu("Bottom", &[Group(ActionGroup::Bottom)]),
    Menu("Scale", &[Group(ActionGroup::Scale)]),
    Menu("Exclusions", &[Group(ActionGroup::Exclusions)]),
    Menu("Several logs", &[Group(ActionGroup::SeveralLogs)]),
    Menu("Mounting", &[Group(ActionGroup::Mounting)]),
    Line,
    Menu("Measure", &[Group(ActionGroup::Measuring)]),
    Menu("Survey planning", &[Group(ActionGroup::Planning)]),
    Menu("Comparison", &[Group(ActionGroup::Comparing)]),
    Menu("Pings", &[Group(ActionGroup::Pings)]),
];

const REVIEW: &[Item] = &[
    Group(ActionGroup::Detector),
    Menu("Model", &[Group(ActionGroup::Models)]),
    Line,
    Group(ActionGroup::Boxes),
    Menu("Decide", &[Group(ActionGroup::Decisions)]),
    Menu("Selected box", &[Group(ActionGroup::SelectedBox)]),
    Line,
    Menu("Review files", &[Group(ActionGroup::ReviewFiles)]),
    Menu("Known objects", &[Group(ActionGroup::Truth)]),
];

/// Draws the menu bar.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    egui::containers::menu::MenuBar::new().ui(ui, |ui| {
        for (title, items) in MENUS {
            ui.menu_button(title, |ui| draw(ui, context, items));
        }
        let has_survey = context.app.logs.shown.survey.is_some();
        if has_survey {
            ui.separator();
            buttons(ui, context);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if has_survey {
                SidePanel::Details.button(ui, context);
                SidePanel::Steps.button(ui, context);
            }
            palette_field(ui, context);
        });
    });
}

/// Draws the entries of a menu, which scrolls if it is longer than the window is tall.
fn draw(ui: &mut Ui, context: &mut ViewContext<'_>, items: &[Item]) {
    let most = ui.content_rect().bottom() - ui.cursor().top() - 16.0;
    egui::ScrollArea::vertical().max_height(most.max(120.0)).show(ui, |ui| {
        for item in items {
            match item {
                Group(group) => group.actions().for_each(|action| entry(ui, context, action)),
                Menu(title, items) => {
                    ui.menu_button(*title, |ui| draw(ui, context, items));
                }
                Line => {
                    ui.separator();
                }
                Drawn(entries) => entries(ui, context),
            }
        }
    });
}

/// Draws a command; one without anything to act on cannot be chosen.
fn entry(ui: &mut Ui, context: &mut ViewContext<'_>, action: Action) {
    let mut options = context.options().clone();
    if action.display_option(&mut options).is_some() {
        option_checkbox(ui, &mut options, action);
        return context.show(options);
    }
    titled(ui, context, action, action.label(), context.app.is_available(action));
}

fn titled(ui: &mut Ui, context: &mut ViewContext<'_>, action: Action, title: &str, enabled: bool) {
    let button = Button::new(title).shortcut_text(action.key());
    let response = ui.add_enabled(enabled, button);
    if response.on_hover_text(action.hint()).clicked() {
        context.push(Command::Do(action));
        ui.close();
    }
}

fn recent(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if context.app.recent.is_empty() {
        ui.weak("no log was opened yet");
    }
    for path in context.app.recent.clone() {
        if ui.button(path.display().to_string()).clicked() {
            context.push(Command::Open(path));
            ui.close();
        }
    }
}

fn undo_and_redo(ui: &mut Ui, context: &mut ViewContext<'_>) {
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
}

/// Lets the analyst choose one of several values of a display option.
fn choose<T: Copy + PartialEq>(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    option: impl Fn(&mut ViewOptions) -> &mut T,
    values: impl IntoIterator<Item = T>,
    name: impl Fn(T) -> String,
) {
    let mut options = context.options().clone();
    for value in values {
        ui.radio_value(option(&mut options), value, name(value));
    }
    context.show(options);
}

fn waterfall_colours(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let name = |map: ColourMap| map.name().to_owned();
    choose(ui, context, |options| &mut options.waterfall.colour_map, ColourMap::ALL, name);
}

fn waterfall_marks(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mut options = context.options().clone();
    ui.checkbox(&mut options.waterfall.flat_stretches, "Flat stretches");
    ui.checkbox(&mut options.waterfall.boxes, "Boxes");
    context.show(options);
}

fn map(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let mut options = context.options().clone();
    toolbar::layers_control(ui, &mut options.map.layers);
    toolbar::swipe_control(ui, &mut options.map);
    ui.separator();
    ui.checkbox(&mut options.map.flat_spots, "Flat stretches");
    option_checkbox(ui, &mut options, Action::Graticule);
    if context.app.logs.has_swath() {
        ui.checkbox(&mut options.swath.0, "Points across the track (swath)")
            .on_hover_text("Draws the points of StructureScan 3D on the map and in 3D.");
    }
    context.show(options);
}

fn cloud_colours(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let name = |colour: CloudColour| format!("by {}", colour.name());
    choose(ui, context, |options| &mut options.cloud.colour, CloudColour::ALL, name);
}

fn bottom_colours(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let name = |colour: BottomColour| format!("by {}", colour.name());
    choose(ui, context, |options| &mut options.cloud.bottom_colour, BottomColour::ALL, name);
}

fn coordinates(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let name = |format: CoordinateFormat| format.name().to_owned();
    choose(ui, context, |options| &mut options.coordinates, CoordinateFormat::ALL, name);
}

fn units(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let name = |unit: LengthUnit| unit.name().to_owned();
    choose(ui, context, |options| &mut options.units.length, LengthUnit::ALL, name);
    ui.separator();
    let name = |unit: SpeedUnit| unit.name().to_owned();
    choose(ui, context, |options| &mut options.units.speed, SpeedUnit::ALL, name);
}

fn side_colours(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let both = [SideColours::Maritime, SideColours::Paper];
    let name = |colours: SideColours| match colours {
        SideColours::Maritime => "at sea: port red, starboard green".to_owned(),
        SideColours::Paper => "in the paper: port blue, starboard red".to_owned(),
    };
    choose(ui, context, |options| &mut options.side_colours, both, name);
}

fn buttons(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let undo = context.app.document.history.undo_label();
    let redo = context.app.document.history.redo_label();
    let units = context.units();
    for (action, label, what) in [(Action::Undo, "Undo", undo), (Action::Redo, "Redo", redo)] {
        let hint = what.map_or_else(
            || action.hint().to_owned(),
            |what| format!("{}: {}", action.label(), units.sentence(what)),
        );
        let hint = format!("{hint} ({})", action.key());
        let button = ui.add_enabled(what.is_some(), Button::new(label));
        let button = button.accessible_name(format!("{label} button"));
        context.button_with_hint(button, action, hint);
    }
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
        "Levels",
        "MapLayers",
        "Colours",
        "Coordinates",
        "Units",
        "MeasuringByKey",
    ];

    /// Calls `visit` with the title and the entries of each menu.
    fn each_menu(title: &'static str, items: &[Item], visit: &mut impl FnMut(&str, &[Item])) {
        visit(title, items);
        for item in items {
            if let Menu(title, items) = item {
                each_menu(title, items, visit);
            }
        }
    }

    #[test]
    fn each_group_of_commands_is_in_a_menu_or_has_its_place_elsewhere() {
        let mut groups = Vec::new();
        for (title, items) in MENUS {
            each_menu(title, items, &mut |_, items| {
                groups.extend(items.iter().filter_map(|item| match item {
                    Group(group) => Some(*group),
                    _ => None,
                }));
            });
        }
        for action in Action::ALL {
            let group = action.group();
            let is_elsewhere = ELSEWHERE.contains(&&*format!("{group:?}"));
            assert_ne!(groups.contains(&group), is_elsewhere, "{group:?} of {}", action.label());
        }
    }

    #[test]
    fn no_menu_has_more_than_twelve_entries() {
        for (title, items) in MENUS {
            each_menu(title, items, &mut |title, items| {
                let entries = items.iter().map(|item| match item {
                    Group(group) => group.actions().count(),
                    Menu(..) => 1,
                    Line => 0,
                    Drawn(_) => 2,
                });
                let count: usize = entries.sum();
                assert!((1..=12).contains(&count), "{title} has {count} entries");
            });
        }
    }
}
