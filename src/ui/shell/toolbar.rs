//! Draws the options of a view at the right end of its title bar, and the controls of the layers of
//! the map, the topmost first: visibility, opacity and order; and those of the swipe, which choose
//! the side of the divider for each layer.

use super::levels;
use crate::app::{
    Action, CloudColour, CloudOptions, EchogramChannel, LayerShown, LayerStack, MapOptions,
    SwipeSide, View, ViewOptions, WaterfallOptions, WorkStep,
};
use crate::ui::controls::{self, DropDown, number_slider, option_switch};
use crate::ui::panels::find_setting;
use crate::ui::{ViewContext, hint_with_key};
use bathyscope_bottom::presentation::colours::ColourMap;
use bathyscope_products::pipeline::BottomColour;
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Button, Checkbox, Popup, RichText, Ui};

/// Returns the width that title and controls of a view need side by side, points; in less space the
/// controls are in a menu.
fn room(view: View) -> f32 {
    match view {
        View::Waterfall => 520.0,
        View::Map => 220.0,
        View::Cloud => 570.0,
        View::Objects | View::Profile => 0.0,
    }
}

/// Draws the controls from right to left; draws nothing while no log is open.
pub(super) fn ui(ui: &mut Ui, view: View, context: &mut ViewContext<'_>) {
    if context.app.logs.shown.survey.is_none() {
        return;
    }
    ui.add_space(6.0);
    ui.spacing_mut().item_spacing.x = 4.0;
    let mut options = context.options().clone();
    if ui.available_width() < room(view) {
        let title = egui::RichText::new("Options").small();
        let title = menu(title).ui(ui, |ui| controls(ui, view, context, &mut options));
        title.0.accessible_name(format!("{} options", view.title()));
    } else {
        controls(ui, view, context, &mut options);
    }
    context.show(options);
}

fn controls(ui: &mut Ui, view: View, context: &mut ViewContext<'_>, options: &mut ViewOptions) {
    match view {
        View::Waterfall => waterfall(ui, context, options),
        View::Map => map(ui, context, options),
        View::Cloud => cloud(ui, context, options),
        // The filter of the table is above its rows.
        View::Objects | View::Profile => {}
    }
}

fn button(ui: &mut Ui, context: &mut ViewContext<'_>, action: Action, label: &str) {
    let label = egui::RichText::new(label).small();
    context.keyed_button(ui.button(label).accessible_name(action.label()), action);
}

fn switch(ui: &mut Ui, on: &mut bool, label: &str, hint: impl Into<egui::WidgetText>) {
    controls::switch(ui, on, label).on_hover_text(hint);
}

fn waterfall(ui: &mut Ui, context: &mut ViewContext<'_>, options: &mut ViewOptions) {
    let title = egui::RichText::new("More").small();
    let more = menu(title).ui(ui, |ui| {
        option_switch(ui, options, Action::RangeLines);
        let ground_range = &mut options.waterfall.ground_range;
        switch(ui, ground_range, "Ground range", hint_with_key(Action::GroundRange));
        button(ui, context, Action::OneToOne, "Equal scales");
        button(ui, context, Action::Orientation, "Turn");
    });
    more.0.accessible_name("More of the waterfall");
    option_switch(ui, options, Action::FirstReturnLine);
    let title = egui::RichText::new("Levels").small();
    let (button, _) = menu(title).ui(ui, |ui| levels::ui(ui, context));
    let sought = find_setting::sought(ui.ctx()).and_then(find_setting::place_of);
    if sought == Some(find_setting::ControlPlace::Levels) {
        Popup::open_id(ui.ctx(), Popup::default_response_id(&button));
    }
    channels(ui, context, &mut options.waterfall);
    let shown = &mut options.waterfall;
    let name = egui::RichText::new(shown.colour_map.name()).small();
    DropDown::new("colour map", name)
        .width(92.0)
        .pick(ui, &mut shown.colour_map, ColourMap::ALL, ColourMap::name)
        .accessible_name("Colour map")
        .on_hover_text("Colours of echo strength.");
}

/// Draws the choice of the down-looking channel, if the log has any.
pub(super) fn channels(ui: &mut Ui, context: &ViewContext<'_>, shown: &mut WaterfallOptions) {
    let survey = context.app.logs.shown.survey.as_ref();
    let has = |channel: &EchogramChannel| match channel.kind() {
        None => true,
        Some(kind) => survey.is_some_and(|survey| survey.has_echogram(kind)),
    };
    let there: Vec<EchogramChannel> = EchogramChannel::ALL.into_iter().filter(has).collect();
    if there.len() < 2 {
        return;
    }
    let name = match (shown.echogram, shown.echogram_alone) {
        (EchogramChannel::None, _) => "side-scan".to_owned(),
        (channel, true) => channel.name().to_owned(),
        (channel, false) => format!("+ {}", channel.name()),
    };
    DropDown::new("channels", egui::RichText::new(name).small())
        .width(92.0)
        .show(ui, |choices| {
            for channel in there {
                if channel == EchogramChannel::None {
                    choices.value(&mut shown.echogram, channel, "side-scan");
                    continue;
                }
                for alone in [false, true] {
                    let is_it = shown.echogram == channel && shown.echogram_alone == alone;
                    let label = if !alone {
                        format!("side-scan and {}", channel.name())
                    } else {
                        format!("{} alone", channel.name())
                    };
                    if choices.choice(is_it, label).clicked() {
                        (shown.echogram, shown.echogram_alone) = (channel, alone);
                    }
                }
            }
        })
        .accessible_name("Channels")
        .on_hover_text("Side-scan, or a down-looking channel with its bottom.");
}

/// Returns a menu that stays open while its sliders are dragged.
fn menu(title: egui::RichText) -> MenuButton<'static> {
    let stays = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    MenuButton::new(title).config(stays)
}

fn map(ui: &mut Ui, context: &ViewContext<'_>, options: &mut ViewOptions) {
    let shown = &mut options.map;
    if context.app.logs.count() > 1 || shown.track_by_log {
        let hint = "Colours each track by its log, not by depth.";
        switch(ui, &mut shown.track_by_log, "By log", hint);
    }
    if options.panels.step == WorkStep::Correct {
        let hint = "The flat stretches for the calibration, ranked.";
        switch(ui, &mut shown.flat_spots, "Flat stretches", hint);
    }
    menu(egui::RichText::new("Layers").small())
        .ui(ui, |ui| {
            layers_control(ui, &mut shown.layers);
            ui.separator();
            swipe_control(ui, shown);
        })
        .0
        .on_hover_text("Layers of the map, their order and opacity.");
}

fn cloud(ui: &mut Ui, context: &mut ViewContext<'_>, options: &mut ViewOptions) {
    button(ui, context, Action::SideView, "Side");
    button(ui, context, Action::TopView, "Top");
    option_switch(ui, options, Action::OutlierPreview);
    let shown = &mut options.cloud;
    let mut is_clipped = shown.clip.is_some();
    switch(ui, &mut is_clipped, "Clip box", hint_with_key(Action::ClipBox3d));
    if is_clipped != shown.clip.is_some() {
        shown.toggle_clip();
    }
    if !context.app.map.measuring.stations().is_empty() {
        switch(ui, &mut shown.cut, "Cut", hint_with_key(Action::Cut3d));
    }
    bottom_colours(ui, shown);
    point_colours(ui, context, shown);
}

fn point_colours(ui: &mut Ui, context: &ViewContext<'_>, shown: &mut CloudOptions) {
    let several_logs = context.app.logs.count() > 1;
    let keys = Action::NextCloudColour.key();
    let hint = format!("What the colour of a point says ({keys}).");
    let selected = if shown.points {
        format!("points by {}", shown.colour.name())
    } else {
        "no points".to_owned()
    };
    DropDown::new("colours of points", egui::RichText::new(selected).small())
        .width(116.0)
        .show(ui, |choices| {
            choices.ui().checkbox(&mut shown.points, "points");
            choices.ui().separator();
            for colour in CloudColour::ALL {
                if colour != CloudColour::Log || several_logs {
                    choices.value(&mut shown.colour, colour, colour.name());
                }
            }
        })
        .accessible_name("Colours of points")
        .on_hover_text(hint);
}

fn bottom_colours(ui: &mut Ui, shown: &mut CloudOptions) {
    let keys = Action::NextBottomColour.key();
    let hint = format!("What the colour of the bottom says ({keys}).");
    let selected = if shown.bottom {
        format!("bottom by {}", shown.bottom_colour.name())
    } else {
        "no bottom".to_owned()
    };
    let selected = egui::RichText::new(selected).small();
    DropDown::new("colours of the bottom", selected)
        .width(128.0)
        .show(ui, |choices| {
            choices.ui().checkbox(&mut shown.bottom, "bottom");
            choices.ui().separator();
            for colour in BottomColour::ALL {
                choices.value(&mut shown.bottom_colour, colour, colour.name());
            }
            choices.ui().separator();
            choices.ui().checkbox(&mut shown.isobaths, "isobaths");
        })
        .accessible_name("Colours of the bottom")
        .on_hover_text(hint);
}

/// Width of a layer's name and of its opacity, points.
const WIDTHS: [f32; 2] = [118.0, 84.0];

/// Draws a row for each layer.
pub(super) fn layers_control(ui: &mut Ui, stack: &mut LayerStack) {
    let rows: Vec<LayerShown> = stack.bottom_up().rev().copied().collect();
    let last = rows.len().saturating_sub(1);
    egui::Grid::new("map layers").num_columns(3).spacing([8.0, 3.0]).show(ui, |ui| {
        for (index, shown) in rows.into_iter().enumerate() {
            visible(ui, stack, shown);
            opacity(ui, stack, shown);
            order(ui, stack, shown, [index > 0, index < last]);
            ui.end_row();
        }
    });
}

fn visible(ui: &mut Ui, stack: &mut LayerStack, shown: LayerShown) {
    let mut visible = shown.visible;
    ui.set_min_width(WIDTHS[0]);
    let check = ui.add(Checkbox::new(&mut visible, shown.layer.name()));
    if check.on_hover_text(shown.layer.hint()).changed() {
        stack.set_visible(shown.layer, visible);
    }
}

fn opacity(ui: &mut Ui, stack: &mut LayerStack, shown: LayerShown) {
    let mut percent = (100.0 * shown.opacity).round();
    ui.spacing_mut().slider_width = WIDTHS[1];
    let slider =
        number_slider(&mut percent, 0.0..=100.0).step_by(1.0).fixed_decimals(0).suffix(" %");
    let name = format!("{} opacity", shown.layer.name());
    let slider = ui.add_enabled(shown.visible, slider);
    let slider = slider.on_hover_text(&name).accessible_name(name);
    if slider.changed() {
        stack.set_opacity(shown.layer, percent / 100.0);
    }
}

fn order(ui: &mut Ui, stack: &mut LayerStack, shown: LayerShown, [up, down]: [bool; 2]) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        let mut button = |enabled, text: &str, what: &str| {
            let button = Button::new(RichText::new(text).small());
            let name = format!("{what} {}", shown.layer.name());
            let button = ui.add_enabled(enabled, button).accessible_name(&name);
            button.on_hover_text(name).clicked()
        };
        if button(up, "Up", "Raise") {
            stack.raise(shown.layer);
        }
        if button(down, "Down", "Lower") {
            stack.lower(shown.layer);
        }
    });
}

/// Draws the check box that divides the map, and a row for each visible layer.
pub(super) fn swipe_control(ui: &mut Ui, map: &mut MapOptions) {
    let mut on = map.swipe.on;
    let check = ui.checkbox(&mut on, "Swipe");
    if check.on_hover_text(hint_with_key(Action::Swipe)).changed() {
        map.swipe.toggle(&mut map.layers);
    }
    if !on {
        return;
    }
    let shown = map.layers.bottom_up().rev();
    let shown: Vec<_> = shown.map(|shown| shown.layer).collect();
    egui::Grid::new("swipe sides").num_columns(2).spacing([8.0, 3.0]).show(ui, |ui| {
        for layer in shown.into_iter().filter(|layer| map.layers.is_visible(*layer)) {
            ui.label(RichText::new(layer.name()).small());
            let mut side = map.swipe.side(layer);
            DropDown::new(("side", layer), RichText::new(side.name()).small())
                .width(64.0)
                .pick(ui, &mut side, SwipeSide::ALL, SwipeSide::name)
                .accessible_name(format!("Side of {}", layer.name()));
            if side != map.swipe.side(layer) {
                map.swipe.set_side(layer, side);
            }
            ui.end_row();
        }
    });
}
