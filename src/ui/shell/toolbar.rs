//! The options of a view, at the right end of its title bar.

use super::{levels, map_layers, swipe};
use crate::app::{
    Action, CloudColour, CloudOptions, ColourMap, Command, EchogramChannel, View, ViewOptions,
    WaterfallOptions,
};
use crate::pipeline::BottomColour;
use crate::ui::{ViewContext, toggle};
use egui::Ui;
use egui::containers::menu::{MenuButton, MenuConfig};

/// Width that the title and all controls of a view need side by side; below it they go into a menu.
fn room(view: View) -> f32 {
    match view {
        View::Waterfall => 640.0,
        View::Map => 220.0,
        View::Cloud => 570.0,
    }
}

/// Draws the controls from right to left; nothing while there is nothing to look at.
pub fn ui(ui: &mut Ui, view: View, context: &mut ViewContext<'_>) {
    if context.app.log.survey.is_none() {
        return;
    }
    ui.add_space(6.0);
    ui.spacing_mut().item_spacing.x = 4.0;
    let before = context.app.options.clone();
    let mut options = before.clone();
    if ui.available_width() < room(view) {
        let title = egui::RichText::new("Options").small();
        let title = menu(title).ui(ui, |ui| controls(ui, view, context, &mut options));
        title.0.accessible_name(format!("{} options", view.title()));
    } else {
        controls(ui, view, context, &mut options);
    }
    if options != before {
        context.push(Command::Show(Box::new(options)));
    }
}

fn controls(ui: &mut Ui, view: View, context: &mut ViewContext<'_>, options: &mut ViewOptions) {
    match view {
        View::Waterfall => waterfall(ui, context, options),
        View::Map => map(ui, context, options),
        View::Cloud => cloud(ui, context, options),
    }
}

fn button(ui: &mut Ui, context: &mut ViewContext<'_>, action: Action, label: &str) {
    let label = egui::RichText::new(label).small();
    let button = ui.button(label).accessible_name(action.label());
    let hint = action.keys().map_or_else(
        || action.hint().to_owned(),
        |keys| format!("{} ({keys})", action.hint()),
    );
    if button.on_hover_text(hint).clicked() {
        context.push(Command::Do(action));
    }
}

fn switch(ui: &mut Ui, on: &mut bool, label: &str, hint: &str) {
    toggle::switch(ui, on, label).on_hover_text(hint);
}

fn waterfall(ui: &mut Ui, context: &mut ViewContext<'_>, options: &mut ViewOptions) {
    button(ui, context, Action::Orientation, "Turn");
    let shown = &mut options.waterfall;
    switch(
        ui,
        &mut shown.range_lines,
        "Range lines",
        "Lines of equal slant range.",
    );
    switch(
        ui,
        &mut shown.first_return,
        "First return",
        "Draws the first return on both sides (B).",
    );
    switch(
        ui,
        &mut shown.ground_range,
        "Ground",
        "Distance on level ground instead of slant range (G).",
    );
    button(ui, context, Action::OneToOne, "1:1");
    menu(egui::RichText::new("Levels").small()).ui(ui, |ui| levels::ui(ui, context));
    channels(ui, context, &mut options.waterfall);
    let shown = &mut options.waterfall;
    egui::ComboBox::from_id_salt("colour map")
        .width(92.0)
        .selected_text(egui::RichText::new(shown.colour_map.name()).small())
        .show_ui(ui, |ui| {
            for map in ColourMap::ALL {
                ui.selectable_value(&mut shown.colour_map, map, map.name());
            }
        })
        .response
        .accessible_name("Colour map")
        .on_hover_text("Colours of echo strength.");
}

/// The channels that look down, where the log has any.
pub fn channels(ui: &mut Ui, context: &ViewContext<'_>, shown: &mut WaterfallOptions) {
    let survey = context.app.log.survey.as_ref();
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
    egui::ComboBox::from_id_salt("channels")
        .width(92.0)
        .selected_text(egui::RichText::new(name).small())
        .show_ui(ui, |ui| {
            for channel in there {
                if channel == EchogramChannel::None {
                    ui.selectable_value(&mut shown.echogram, channel, "side-scan");
                    continue;
                }
                for alone in [false, true] {
                    let is_it = shown.echogram == channel && shown.echogram_alone == alone;
                    let label = match alone {
                        false => format!("side-scan and {}", channel.name()),
                        true => format!("{} alone", channel.name()),
                    };
                    if ui.selectable_label(is_it, label).clicked() {
                        (shown.echogram, shown.echogram_alone) = (channel, alone);
                    }
                }
            }
        })
        .response
        .accessible_name("Channels")
        .on_hover_text("Side-scan, or a channel that looks down with its bottom.");
}

/// A menu that stays open while its sliders are dragged.
fn menu(title: egui::RichText) -> MenuButton<'static> {
    let stays = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    MenuButton::new(title).config(stays)
}

fn map(ui: &mut Ui, context: &ViewContext<'_>, options: &mut ViewOptions) {
    let shown = &mut options.map;
    if context.app.log_count() > 1 || shown.track_by_log {
        switch(
            ui,
            &mut shown.track_by_log,
            "By log",
            "Colours the tracks by the log that they are of, instead of by depth.",
        );
    }
    switch(
        ui,
        &mut shown.flat_spots,
        "Flat stretches",
        "The ranked stretches to calibrate on.",
    );
    menu(egui::RichText::new("Layers").small())
        .ui(ui, |ui| {
            map_layers::control(ui, &mut shown.layers);
            ui.separator();
            swipe::control(ui, shown);
        })
        .0
        .on_hover_text("What the map shows, in which order, and how strongly.");
}

fn cloud(ui: &mut Ui, context: &mut ViewContext<'_>, options: &mut ViewOptions) {
    button(ui, context, Action::SideView, "Side");
    button(ui, context, Action::TopView, "Top");
    let shown = &mut options.cloud;
    switch(
        ui,
        &mut shown.outlier_preview,
        "Outliers",
        "Shows the points that the filter removes in a third colour (O).",
    );
    let mut is_clipped = shown.clip.is_some();
    switch(
        ui,
        &mut is_clipped,
        "Clip box",
        "Draws what lies in a box alone (Shift+X).",
    );
    if is_clipped != shown.clip.is_some() {
        shown.toggle_clip();
    }
    if !context.app.measuring.stations().is_empty() {
        switch(
            ui,
            &mut shown.cut,
            "Cut",
            "Cuts along the line of the depth profile (Shift+Q).",
        );
    }
    bottom_colours(ui, shown);
    point_colours(ui, context, shown);
}

fn point_colours(ui: &mut Ui, context: &ViewContext<'_>, shown: &mut CloudOptions) {
    let several_logs = context.app.log_count() > 1;
    let hint = format!(
        "What the colour of a point says ({}).",
        Action::NextCloudColour.keys().unwrap_or_default()
    );
    let selected = match shown.points {
        true => format!("points by {}", shown.colour.name()),
        false => "no points".to_owned(),
    };
    egui::ComboBox::from_id_salt("colours of points")
        .width(116.0)
        .selected_text(egui::RichText::new(selected).small())
        .show_ui(ui, |ui| {
            ui.checkbox(&mut shown.points, "points");
            ui.separator();
            for colour in CloudColour::ALL {
                if colour != CloudColour::Log || several_logs {
                    ui.selectable_value(&mut shown.colour, colour, colour.name());
                }
            }
        })
        .response
        .accessible_name("Colours of points")
        .on_hover_text(hint);
}

fn bottom_colours(ui: &mut Ui, shown: &mut CloudOptions) {
    let hint = format!(
        "What the colour of the bottom says ({}).",
        Action::NextBottomColour.keys().unwrap_or_default()
    );
    let selected = match shown.bottom {
        true => format!("bottom by {}", shown.bottom_colour.name()),
        false => "no bottom".to_owned(),
    };
    egui::ComboBox::from_id_salt("colours of the bottom")
        .width(128.0)
        .selected_text(egui::RichText::new(selected).small())
        .show_ui(ui, |ui| {
            ui.checkbox(&mut shown.bottom, "bottom");
            ui.separator();
            for colour in BottomColour::ALL {
                ui.selectable_value(&mut shown.bottom_colour, colour, colour.name());
            }
            ui.separator();
            ui.checkbox(&mut shown.isobaths, "isobaths");
        })
        .response
        .accessible_name("Colours of the bottom")
        .on_hover_text(hint);
}
