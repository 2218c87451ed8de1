//! Draws the selected box: picture, decision, class, and facts; and the object that it shows, with
//! the pictures of all its boxes side by side.

use super::super::parts::{fact, remark, within};
use super::{ReviewPanel, buttons, size};
use crate::app::{Action, App, Command, LogBox, Object, Tool};
use crate::ui::views::chip::{self, BoxChip, Chips};
use crate::ui::{ViewContext, place, text, theme};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_objects::ObjectExtent;
use bathyscope_objects::review::Reviewed;
use bathyscope_objects::targets::{ObjectHeight, Target};
use egui::{RichText, Role, ScrollArea, Sense, Ui, WidgetInfo, vec2};

/// Width of a picture, points, so that two pictures and a part of the next fit side by side.
const PICTURE_WIDTH: f32 = 124.0;
/// Height of the tallest picture, points.
const PICTURE_HEIGHT: f32 = 110.0;
/// Greatest number of pictures of an object; the remaining boxes are counted.
const MOST_PICTURES: usize = 24;

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

/// Draws the facts of the object of the selected box, the pictures of its boxes, and the buttons
/// that decide about it.
pub(super) fn object(ui: &mut Ui, context: &mut ViewContext<'_>, chips: &mut Chips) {
    let Some(object) = context.app.selected_object().cloned() else {
        return;
    };
    object_facts(ui, context, &object);
    if object.boxes.len() > 1 {
        pictures(ui, context, chips, &object);
        let named = [
            (Action::AcceptObject, "Accept all"),
            (Action::RejectObject, "Reject all"),
            (Action::UndecideObject, "Undecide all"),
            (Action::NextSighting, "Next sighting"),
        ];
        buttons(ui, context, &named);
    }
    ui.add_space(4.0);
}

fn pictures(ui: &mut Ui, context: &mut ViewContext<'_>, chips: &mut Chips, object: &Object) {
    let app = context.app;
    let shown = object.boxes.iter().take(MOST_PICTURES);
    let boxes = shown.filter_map(|id| chip::wanted(app, *id)).collect();
    chip::ask(chips, boxes, app, ui.ctx());
    let made = chips.result().map_or(&[][..], Vec::as_slice);
    let strip =
        ScrollArea::horizontal().id_salt(("sightings", object.number)).auto_shrink([false, true]);
    strip.show(ui, |ui| {
        ui.horizontal(|ui| {
            for ((id, _), chip) in made.iter().filter(|((id, _), _)| object.boxes.contains(id)) {
                context.commands.extend(sighting(ui, app, *id, chip));
            }
        });
    });
    let more = object.boxes.len().saturating_sub(MOST_PICTURES);
    if more > 0 {
        remark(ui, format!("and {} more", text::count(more)));
    }
}

/// Draws a picture over the name of its log; a click shows the box in its log.
fn sighting(ui: &mut Ui, app: &App, id: LogBox, chip: &BoxChip) -> Option<Command> {
    let (log, review_box) = (app.logs.get(id.log)?, app.logs.log_box(id)?);
    let is_selected = app.logs.shown.selected_box() == Some(id);
    let response = ui
        .vertical(|ui| {
            ui.set_max_width(PICTURE_WIDTH);
            let room = vec2(PICTURE_WIDTH, PICTURE_HEIGHT);
            let picture = chip.draw(ui, review_box, room, Sense::click());
            if is_selected {
                let frame = egui::Stroke::new(2.0, theme::SELECTION_COLOUR);
                let kind = egui::StrokeKind::Inside;
                ui.painter().rect_stroke(picture.rect, 0.0, frame, kind);
            }
            ui.horizontal(|ui| {
                let ping = review_box.mark.pings.start;
                let name = match app.logs.count() {
                    0 | 1 => format!("ping {ping}"),
                    _ => {
                        let (area, _) = ui.allocate_exact_size(vec2(9.0, 9.0), Sense::hover());
                        ui.painter().rect_filled(area, 2.0, theme::rgb(log.colour));
                        format!("{} ping {ping}", log.name())
                    }
                };
                let name = RichText::new(name).size(theme::SMALL);
                ui.add(egui::Label::new(name).truncate());
            });
            picture
        })
        .inner;
    let name = format!("Sighting in {}, box {}", log.name(), review_box.id.0);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_selected, &name));
    let hint = format!("{}: shows it in all views", review_box.state.name());
    let response = response.on_hover_text(hint);
    response.clicked().then_some(Command::SelectLogBox(id))
}

fn object_facts(ui: &mut Ui, context: &ViewContext<'_>, object: &Object) {
    let app = context.app;
    let name = match object.name.as_str() {
        "" => String::new(),
        name => format!("{name}, "),
    };
    let title = format!("Object {}, {name}{}", object.number, object.class);
    let hint = "The class of most of its boxes.";
    ui.label(RichText::new(title).strong()).on_hover_text(hint);
    fact(ui, "Seen", SEEN, seen(app, object));
    shape(ui, context);
    if object.boxes.len() > 1 {
        let hint = "Weighted mean position of its boxes (WGS84).";
        let at = RichText::new(place::written(app, object.position)).monospace();
        fact(ui, "Position", hint, at);
        let hint = "Standard deviation of the position, without the error of the receiver.";
        let sigma = app.view.options.units.measure(object.sigma_m, 2);
        fact(ui, "Uncertainty", hint, sigma);
    }
}

const SEEN: &str = "Passes that saw the object, of those that covered its position. Few sightings of many passes suggest a false alarm.";

/// Returns the number of sightings as text: `2 of 3 passes, in 1 log, 3 boxes`; the boxes are named
/// if there are more of them than passes.
fn seen(app: &App, object: &Object) -> String {
    let mut seen = match app.selected_object_passes() {
        Some(passes) => {
            let covered = text::plural(passes.covered, "pass", "passes");
            format!("{} of {covered}", passes.seen)
        }
        None => text::plural(object.sightings, "pass", "passes"),
    };
    if app.logs.count() > 1 {
        let logs = text::plural(object.logs().len(), "log", "logs");
        seen += &format!(", in {logs}");
    }
    if object.boxes.len() > object.sightings {
        let boxes = text::plural(object.boxes.len(), "box", "boxes");
        seen += &format!(", {boxes}");
    }
    seen
}

/// Draws the solid that explains echo and shadow best, or the reason why there is none.
fn shape(ui: &mut Ui, context: &ViewContext<'_>) {
    let app = context.app;
    let Some(found) = app.selected_object_shape() else {
        return;
    };
    let hint = "Inferred solid whose echo and shadow fit the picture best: length, width, and the share of the picture that fits.";
    let words = match found {
        Ok(fitted) => {
            let solid = &fitted.posed.solid;
            let units = app.view.options.units;
            let size = size([solid.length_m, solid.width_m], units);
            let rivals = match fitted.rivals.first() {
                Some(rival) if rival.is_boat() != solid.kind.is_boat() || !rival.is_boat() => {
                    format!(", or {}", rival.name())
                }
                _ => String::new(),
            };
            let explained = 100.0 * fitted.explained;
            let kind = solid.kind.name();
            format!("{kind}{rivals}, {size}; {explained:.0} % fits")
        }
        Err(why) => why.to_string(),
    };
    fact(ui, "Shape", hint, words);
}
