//! Draws the selected box: picture, decision, class, and facts.

use super::super::parts::{fact, remark, within};
use super::{ReviewPanel, buttons, size};
use crate::app::{Action, LogBox, Tool};
use crate::ui::views::chip::{self, BoxChip};
use crate::ui::{ViewContext, place, theme};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_objects::ObjectExtent;
use bathyscope_objects::review::Reviewed;
use bathyscope_objects::targets::{ObjectHeight, Target};
use egui::{RichText, Ui};

impl ReviewPanel {
    /// Draws the selected box, or a remark on how to select one.
    pub(super) fn selected(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let Some(review_box) = context.app.logs.shown.reviewing.selected_box().cloned() else {
            self.lines.keep(context, None);
            let all = context.app.logs.review_counts().boxes.proposed == 0;
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
        self.picture(ui, context, &review_box);
        within(ui, |ui| title(ui, context, &review_box));
        decisions(ui, context, &review_box);
        self.classes.ui(ui, context, &review_box);
        facts(ui, context, &review_box);
        self.lines.ui(ui, context, &review_box);
        ui.add_space(4.0);
    }

    fn picture(&mut self, ui: &mut Ui, context: &ViewContext<'_>, review_box: &Reviewed) {
        let app = context.app;
        let shown = &app.view.options.waterfall;
        let Some(key) = chip::ChipKey::of(&app.logs.shown, &review_box.mark, shown) else {
            return;
        };
        let (of, ctx) = (key.clone(), ui.ctx().clone());
        self.chip.ask(key, app.jobs.workers(), move |_| BoxChip::new(&of, &ctx));
        if let Some(picture) = self.chip.result() {
            picture.ui(ui, review_box, &app.logs.shown.reviewing.review, app.view.options.units);
        }
    }
}

fn title(ui: &mut Ui, context: &ViewContext<'_>, review_box: &Reviewed) {
    let review = &context.app.logs.shown.reviewing.review;
    ui.horizontal_wrapped(|ui| {
        let class = review.class_name(review_box.class);
        let title = if review_box.name.is_empty() { class } else { &review_box.name };
        ui.label(RichText::new(title).heading().strong());
        if !review_box.name.is_empty() {
            ui.label(class);
        }
        if let Some(score) = review_box.score {
            ui.label(format!("{score:.2}"));
        }
        let colour = theme::box_colour_on_panel(context.theme(), review_box.state);
        let state = RichText::new(review_box.state.name()).color(colour);
        ui.label(state);
        let corrected = if review_box.edited { ", corrected" } else { "" };
        let log = match context.app.logs.count() {
            0 | 1 => String::new(),
            _ => format!(" of {}", context.app.logs.shown.name()),
        };
        let name = format!("box {}{log}{corrected}", review_box.id.0);
        ui.label(RichText::new(name).weak());
    });
}

fn decisions(ui: &mut Ui, context: &mut ViewContext<'_>, review_box: &Reviewed) {
    let tool = context.app.logs.shown.reviewing.tool;
    let named = [
        (Action::AcceptBox, "Accept"),
        (Action::RejectBox, "Reject"),
        (Action::PreviousBox, "Previous"),
        (Action::NextBox, "Next"),
    ];
    buttons(ui, context, &named);
    let edits = if tool == Tool::Edit { "Done" } else { "Edit" };
    let draws = if tool == Tool::Draw { "Keep undecided" } else { "New box" };
    // A box that was drawn by hand has no undecided state to return to.
    let back = match review_box.model {
        Some(_) => (Action::UndecideBox, "Undecide"),
        None => (Action::RemoveBox, "Remove"),
    };
    let named =
        [back, (Action::EditBox, edits), (Action::SwapSide, "Swap side"), (Action::NewBox, draws)];
    buttons(ui, context, &named);
}

fn facts(ui: &mut Ui, context: &ViewContext<'_>, review_box: &Reviewed) {
    let app = context.app;
    let mark = &review_box.mark;
    let hint = "Along the track and in slant range; echo and shadow together.";
    let value = size(app.logs.shown.reviewing.size_m(mark), app.view.options.units);
    fact(ui, "Size", hint, value);
    fact(ui, "Range", "Slant range of its near and far edge.", {
        let ranges = app.view.options.units.span(place::ranges_m(app, mark), 2);
        format!("{ranges} {}", mark.side.name())
    });
    if let Some(placed) = app.logs.shown.reviewing.placed(review_box.id) {
        on_the_ground(ui, context, review_box, &placed.target);
    }
    let model = review_box.model.as_deref().unwrap_or("drawn by hand");
    fact(ui, "From", "The model that proposed it.", model);
}

/// Draws the position and the size of the object of a box.
fn on_the_ground(ui: &mut Ui, context: &ViewContext<'_>, review_box: &Reviewed, target: &Target) {
    let app = context.app;
    let units = app.view.options.units;
    let hint = "The middle of the object on the bottom, WGS84.";
    let value = RichText::new(place::written(context.app, target.position)).monospace();
    fact(ui, "Position", hint, value);
    let hint = "Standard deviation of the position, without the error of the receiver.";
    fact(ui, "Uncertainty", hint, units.measure(target.sigma_m, 2));
    let hint = "Length along the track and width across it, of the echo without its shadow.";
    fact(ui, "Object", hint, extent(target, units));
    let hint = "Height above the bottom from the shadows of all boxes, with its standard deviation; a shadow set by hand counts alone.";
    let object = app.objects.of_box(LogBox { log: app.logs.shown.id, id: review_box.id });
    // Until its boxes are joined, an object has the height by this box alone.
    let by_box = || ObjectHeight::of(std::iter::once(target));
    let height = object.map_or_else(by_box, |object| object.height);
    fact(ui, "Height", hint, units.with_sigma(height.mean_m, height.sigma_m, 2));
    if height.source.is_some() {
        let key = Action::HeightFromShadow.key();
        let hint = format!(
            "The sighting that the height rests on. Sightings that contradict it are left out; {key} measures a shadow by hand."
        );
        let source = object.map_or_else(
            || height.source_in_words(None),
            |object| app.objects.listed_object(object).height_source(),
        );
        fact(ui, "Height from", &hint, source);
    }
    let hint =
        "Slant ranges where the shadow starts and ends. Height = altitude x (end - start) / end.";
    fact(ui, "Shadow", hint, shadow(target, units));
    fact(
        ui,
        "Depth",
        &format!(
            "Of the bottom where it lies, {}.",
            place::reduction(context.app).reference_name()
        ),
        units.measure(target.depth_m, 2),
    );
}

/// Returns length and width as text, and whether the edges were drawn by hand.
fn extent(target: &Target, units: Units) -> String {
    let edges = match target.extent {
        ObjectExtent::Point => return "a point, of no known size".to_owned(),
        ObjectExtent::Drawn { .. } => ", edges drawn",
        ObjectExtent::Found => "",
    };
    let size = size([target.length_m, target.width_m], units);
    format!("{size}{edges}")
}

/// Describes the shadow and the altitude from which the height is computed.
fn shadow(target: &Target, units: Units) -> String {
    let [start_m, end_m] = target.shadow_m;
    let altitude = units.measure(target.altitude_m, 2);
    let measured = match target.measured_shadow {
        Some(_) => ", measured",
        None => "",
    };
    match (start_m.is_finite(), end_m.is_finite()) {
        (true, true) => {
            format!("{}, altitude {altitude}{measured}", units.span([start_m, end_m], 2))
        }
        (true, false) => {
            let start = units.measure(start_m, 2);
            format!("from {start} off the range, altitude {altitude}{measured}")
        }
        (false, _) => format!("none, altitude {altitude}"),
    }
}
