//! The selected box: picture, decision, class, and what is known of it.

use super::super::parts::{fact, remark, within};
use super::chip::Chip;
use super::{ReviewPanel, button, chip, size};
use crate::app::{Action, Command, Tool};
use crate::detection::ObjectExtent;
use crate::detection::review::{Edit, Reviewed};
use crate::detection::targets::Target;
use crate::presentation::units::Units;
use crate::ui::{ViewContext, place, theme, toggle};
use egui::{RichText, Ui};

/// Classes that have a key.
const KEYED: usize = 9;

impl ReviewPanel {
    /// Draws the selected box, or how to select one.
    pub(super) fn selected(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let Some(one) = context.app.log.reviewing.selected_box().cloned() else {
            self.lines.keep(context, None);
            let all = context.app.review_counts().boxes.proposed == 0;
            let is_part = context.app.search_note().is_some();
            remark(
                ui,
                match (all, is_part) {
                    (true, false) => "All boxes in sight are decided.",
                    (true, true) => {
                        "All boxes that were found so far and are in sight are decided."
                    }
                    (false, _) => "No box is selected: press Tab, or click one in the waterfall.",
                },
            );
            return;
        };
        self.picture(ui, context, &one);
        within(ui, |ui| title(ui, context, &one));
        decisions(ui, context, &one);
        classes(ui, context, &one);
        facts(ui, context, &one);
        self.lines.ui(ui, context, &one);
        ui.add_space(4.0);
    }

    fn picture(&mut self, ui: &mut Ui, context: &ViewContext<'_>, one: &Reviewed) {
        let app = context.app;
        let shown = &app.options.waterfall;
        let Some(key) = chip::Key::of(&app.log, &one.mark, shown) else {
            return;
        };
        let (of, ctx) = (key.clone(), ui.ctx().clone());
        self.chip
            .ask(key, app.jobs(), move |_| Chip::new(&of, &ctx));
        if let Some(picture) = self.chip.result() {
            picture.ui(ui, one, &app.log.reviewing.review, app.options.units);
        }
    }
}

fn title(ui: &mut Ui, context: &ViewContext<'_>, one: &Reviewed) {
    let review = &context.app.log.reviewing.review;
    ui.horizontal_wrapped(|ui| {
        let class = review.class_name(one.class);
        let title = if one.name.is_empty() {
            class
        } else {
            &one.name
        };
        ui.label(RichText::new(title).heading().strong());
        if !one.name.is_empty() {
            ui.label(class);
        }
        if let Some(score) = one.score {
            ui.label(format!("{score:.2}"));
        }
        let colour = theme::box_colour_on_panel(context.app.options.theme, one.state);
        let state = RichText::new(one.state.name()).color(colour);
        ui.label(state);
        let corrected = if one.edited { ", corrected" } else { "" };
        let log = match context.app.log_count() {
            0 | 1 => String::new(),
            _ => format!(" of {}", context.app.log.name()),
        };
        let name = format!("box {}{log}{corrected}", one.id.0);
        ui.label(RichText::new(name).weak());
    });
}

fn decisions(ui: &mut Ui, context: &mut ViewContext<'_>, one: &Reviewed) {
    let tool = context.app.log.reviewing.tool;
    ui.horizontal_wrapped(|ui| {
        for (action, name) in [
            (Action::AcceptBox, "Accept"),
            (Action::RejectBox, "Reject"),
            (Action::PreviousBox, "Previous"),
            (Action::NextBox, "Next"),
        ] {
            button(ui, context, action, name, true);
        }
    });
    ui.horizontal_wrapped(|ui| {
        let edits = if tool == Tool::Edit { "Done" } else { "Edit" };
        let draws = if tool == Tool::Draw {
            "Leave it"
        } else {
            "New box"
        };
        // A box drawn by hand has no proposal to go back to.
        let back = match one.model {
            Some(_) => (Action::UndecideBox, "Undecide"),
            None => (Action::RemoveBox, "Remove"),
        };
        for (action, name) in [
            back,
            (Action::EditBox, edits),
            (Action::SwapSide, "Swap side"),
            (Action::NewBox, draws),
        ] {
            button(ui, context, action, name, true);
        }
    });
}

fn classes(ui: &mut Ui, context: &mut ViewContext<'_>, one: &Reviewed) {
    let review = context.app.log.reviewing.review.clone();
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (class, name) in review.classes().iter().enumerate() {
            let (label, hint) = match class < KEYED {
                true => (
                    format!("{} {name}", class + 1),
                    format!("Key {}", class + 1),
                ),
                false => (name.clone(), String::new()),
            };
            let chosen = class == one.class;
            let chip = toggle::chip(ui, chosen, label).accessible_name(format!("Class {name}"));
            let chip = match hint.is_empty() {
                true => chip,
                false => chip.on_hover_text(hint),
            };
            if chip.clicked() {
                context.push(Command::Edit {
                    edit: Edit::Relabel(one.id, class),
                    live: false,
                });
            }
        }
    });
}

fn facts(ui: &mut Ui, context: &ViewContext<'_>, one: &Reviewed) {
    let app = context.app;
    let mark = &one.mark;
    fact(
        ui,
        "Size",
        "Along the track and in slant range; echo and shadow together.",
        size(app.log.reviewing.size_m(mark), app.options.units),
    );
    fact(ui, "Range", "Slant range of its near and far edge.", {
        let ranges = app.options.units.span(place::ranges_m(app, mark), 2);
        format!("{ranges} {}", mark.side.name())
    });
    if let Some(placed) = app.log.reviewing.placed(one.id) {
        on_the_ground(ui, context, &placed.target);
    }
    let model = one.model.as_deref().unwrap_or("drawn by hand");
    fact(ui, "From", "The model that proposed it.", model);
}

/// Where its object lies and how large it is.
fn on_the_ground(ui: &mut Ui, context: &ViewContext<'_>, target: &Target) {
    let units = context.app.options.units;
    fact(
        ui,
        "Place",
        "The middle of the object on the bottom, WGS84.",
        RichText::new(place::written(context.app, target.position)).monospace(),
    );
    fact(
        ui,
        "Within",
        "Standard deviation of the place, without the receiver's own error.",
        units.measure(target.sigma_m, 2),
    );
    let hint = "Length along the track, width across it, and height from the shadow where it ends within the range.";
    fact(ui, "Object", hint, extent(target, units));
    let hint = "The height is H (end - start) / end, with the altitude H and the slant ranges of the shadow.";
    fact(ui, "Shadow", hint, shadow(target, units));
    fact(
        ui,
        "Depth",
        &format!(
            "Of the bottom where it lies, {}.",
            place::reduction(context.app).reference().name()
        ),
        units.measure(target.depth_m, 2),
    );
}

/// Length, width and height, and whether they are of edges drawn by hand.
fn extent(target: &Target, units: Units) -> String {
    let edges = match (target.extent, target.measured_shadow) {
        (ObjectExtent::Point, None) => return "a point, of no known size".to_owned(),
        (ObjectExtent::Drawn { .. }, None) => ", edges drawn",
        (ObjectExtent::Drawn { .. }, Some(_)) => ", edges drawn, shadow measured",
        (ObjectExtent::Found | ObjectExtent::Point, Some(_)) => ", shadow measured",
        (ObjectExtent::Found, None) => "",
    };
    let height = match target.height_m.is_finite() {
        true => {
            let sigma = units.measure(target.height_sigma_m, 2);
            format!("{} ± {sigma}", units.number(target.height_m, 2))
        }
        false => units.measure(target.height_m, 2),
    };
    let size = size([target.length_m, target.width_m], units);
    format!("{size}, height {height}{edges}")
}

/// What the height is computed from.
fn shadow(target: &Target, units: Units) -> String {
    let [start_m, end_m] = target.shadow_m;
    let altitude = units.measure(target.altitude_m, 2);
    match (start_m.is_finite(), end_m.is_finite()) {
        (true, true) => format!("{}, altitude {altitude}", units.span([start_m, end_m], 2)),
        (true, false) => {
            let start = units.measure(start_m, 2);
            format!("from {start} off the range, altitude {altitude}")
        }
        (false, _) => format!("none, altitude {altitude}"),
    }
}
