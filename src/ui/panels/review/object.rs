//! Draws the object that the selected box shows, with the pictures of all its boxes side by side.

use super::super::parts::{fact, remark};
use super::{buttons, size};
use crate::app::{Action, App, Command, LogBox, Object};
use crate::ui::views::chip::{self, BoxChip, Chips};
use crate::ui::{ViewContext, place, text, theme};
use egui::{RichText, Role, ScrollArea, Sense, Ui, WidgetInfo, vec2};

/// Width of a picture, points, so that two pictures and a part of the next fit side by side.
const PICTURE_WIDTH: f32 = 124.0;
/// Height of the tallest picture, points.
const PICTURE_HEIGHT: f32 = 110.0;
/// Greatest number of pictures of an object; the remaining boxes are counted.
const MOST_PICTURES: usize = 24;

/// Draws the facts of the object of the selected box, the pictures of its boxes, and the buttons
/// that decide about it.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>, chips: &mut Chips) {
    let Some(object) = context.app.selected_object().cloned() else {
        return;
    };
    facts(ui, context, &object);
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

fn facts(ui: &mut Ui, context: &ViewContext<'_>, object: &Object) {
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
