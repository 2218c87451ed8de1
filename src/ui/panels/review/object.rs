//! The object that the selected box shows, with the pictures of all boxes that show it side by side; and the list of all objects.

use super::super::parts::{Section, fact, list_rows, remark, row, section};
use super::button;
use super::chip::{self, Chip};
use crate::app::{Action, App, Command, LogBox, ObjectState, SurveyObject};
use crate::detection::review::{Filter, State};
use crate::pipeline::Background;
use crate::ui::{ViewContext, place, text, theme};
use egui::{Button, Color32, ComboBox, RichText, Role, ScrollArea, Sense, Ui, WidgetInfo, vec2};

/// Width of a picture, points: two of them side by side, and a part of the next.
const PICTURE_WIDTH: f32 = 124.0;
/// Pictures that are made of one object; of one that was seen more often the others are counted.
const MOST_PICTURES: usize = 24;

/// What the pictures of an object are made of: the box of each.
type Boxes = Vec<(LogBox, chip::Key)>;

/// The pictures of the boxes that show the selected object.
#[derive(Default)]
pub struct ObjectPictures {
    chips: Background<Boxes, Vec<(LogBox, Chip)>>,
}

impl ObjectPictures {
    /// Whether the pictures are those of the selected object.
    pub fn is_settled(&self) -> bool {
        !self.chips.is_running()
    }

    /// Draws what is known of the object of the selected box, and what decides about it.
    pub fn ui(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let Some(object) = context.app.selected_object().cloned() else {
            return;
        };
        facts(ui, context, &object);
        if object.boxes.len() > 1 {
            self.pictures(ui, context, &object);
            ui.horizontal_wrapped(|ui| {
                for (action, name) in [
                    (Action::AcceptObject, "Accept all"),
                    (Action::RejectObject, "Reject all"),
                    (Action::UndecideObject, "Undecide all"),
                    (Action::NextSighting, "Next sighting"),
                ] {
                    button(ui, context, action, name, true);
                }
            });
        }
        ui.add_space(4.0);
    }

    fn pictures(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>, object: &SurveyObject) {
        let app = context.app;
        let map = app.options.waterfall.colour_map;
        let picture = |id: &LogBox| {
            let mark = &app.log_box(*id)?.mark;
            Some((*id, chip::Key::of(app.open_log(id.log)?, mark, map)?))
        };
        let shown = object.boxes.iter().take(MOST_PICTURES);
        let boxes: Boxes = shown.filter_map(picture).collect();
        let (of, ctx) = (boxes.clone(), ui.ctx().clone());
        self.chips.ask(boxes, app.jobs(), move |progress| {
            let mut chips = Vec::with_capacity(of.len());
            for (id, key) in &of {
                progress.check().ok()?;
                chips.extend(Chip::new(key, &ctx).map(|chip| (*id, chip)));
            }
            Some(chips)
        });
        let made = self.chips.result().map_or(&[][..], Vec::as_slice);
        let strip = ScrollArea::horizontal()
            .id_salt(("sightings", object.number))
            .auto_shrink([false, true]);
        strip.show(ui, |ui| {
            ui.horizontal(|ui| {
                for (id, chip) in made.iter().filter(|(id, _)| object.boxes.contains(id)) {
                    context.commands.extend(sighting(ui, app, *id, chip));
                }
            });
        });
        let more = object.boxes.len().saturating_sub(MOST_PICTURES);
        if more > 0 {
            remark(ui, format!("and {} more", text::count(more)));
        }
    }
}

/// One picture over the name of its log; a click shows the box in its log.
fn sighting(ui: &mut Ui, app: &App, id: LogBox, chip: &Chip) -> Option<Command> {
    let (log, one) = (app.open_log(id.log)?, app.log_box(id)?);
    let is_selected = app.selected_log_box() == Some(id);
    let response = ui
        .vertical(|ui| {
            ui.set_max_width(PICTURE_WIDTH);
            let picture = chip.draw(ui, one, PICTURE_WIDTH, Sense::click());
            if is_selected {
                let frame = egui::Stroke::new(2.0, theme::selection_colour());
                let kind = egui::StrokeKind::Inside;
                ui.painter().rect_stroke(picture.rect, 0.0, frame, kind);
            }
            ui.horizontal(|ui| {
                let ping = one.mark.pings.start;
                let name = match app.log_count() {
                    0 | 1 => format!("ping {ping}"),
                    _ => {
                        swatch(ui, log.colour);
                        format!("{} ping {ping}", log.name())
                    }
                };
                let name = RichText::new(name).size(theme::SMALL);
                ui.add(egui::Label::new(name).truncate());
            });
            picture
        })
        .inner;
    let name = format!("Sighting in {}, box {}", log.name(), one.id.0);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_selected, &name));
    let hint = format!("{}: shows it in all views", one.state.name());
    let response = response.on_hover_text(hint);
    response.clicked().then_some(Command::SelectLogBox(id))
}

fn swatch(ui: &mut Ui, [r, g, b]: [u8; 3]) {
    let (area, _) = ui.allocate_exact_size(vec2(9.0, 9.0), Sense::hover());
    let colour = Color32::from_rgb(r, g, b);
    ui.painter().rect_filled(area, 2.0, colour);
}

fn facts(ui: &mut Ui, context: &ViewContext<'_>, object: &SurveyObject) {
    let app = context.app;
    let title = format!("Object {}, {}", object.number, object.joint.class);
    let hint = "What most of the boxes that show it take it for.";
    ui.label(RichText::new(title).strong()).on_hover_text(hint);
    let seen = match app.selected_object_passes() {
        Some(passes) => format!("{} of {passes} times", object.boxes.len()),
        None => text::plural(object.boxes.len(), "time", "times"),
    };
    let logs = object.logs().len();
    let seen = match app.log_count() {
        0 | 1 => seen,
        _ => format!("{seen}, in {}", text::plural(logs, "log", "logs")),
    };
    let hint = "Boxes that show it, of the passes of the boat that covered its place. What is seen every time is rarely a false alarm.";
    fact(ui, "Seen", hint, seen);
    if object.boxes.len() > 1 {
        let hint = "Mean of the places of its boxes, weighted by their certainty, WGS84.";
        let at = RichText::new(place::written(app, object.position)).monospace();
        fact(ui, "Mean place", hint, at);
        let hint = "Standard deviation of that place, and the mean of the heights that are known.";
        let height = app.options.units.measure(object.joint.height_m, 2);
        let within = app.options.units.measure(object.joint.sigma_m, 2);
        fact(ui, "Within", hint, format!("{within}, height {height}"));
    }
}

/// Draws the list of the objects that the boxes of all visible logs show.
pub fn list(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if context.app.objects().is_empty() {
        return;
    }
    let heading = Section {
        number: None,
        title: "Object list",
        stage: None,
    };
    section(ui, context, &heading, |ui, context| {
        let filter = &context.app.log.reviewing.queue.filter;
        let objects = context.app.objects().iter();
        let mut objects: Vec<&SurveyObject> = objects
            .filter(|object| passes(context.app, filter, object))
            .collect();
        order(ui).sort(&mut objects);
        let all = context.app.objects().len();
        let said = text::plural(all, "object", "objects");
        remark(
            ui,
            match objects.len() == all {
                true => format!("{said}, each of the boxes that show it."),
                false => format!("{} of {said}, by the filter.", text::count(objects.len())),
            },
        );
        rows(ui, context, &objects);
    });
}

/// What the list is sorted by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
enum Order {
    /// As they were found, along the first log.
    #[default]
    Number,
    /// Seen most often first: what is seen every time is rarely a false alarm.
    Seen,
    /// Class by class.
    Class,
}

impl Order {
    const ALL: [Self; 3] = [Self::Number, Self::Seen, Self::Class];

    fn name(self) -> &'static str {
        match self {
            Self::Number => "number",
            Self::Seen => "times seen",
            Self::Class => "class",
        }
    }

    /// Objects come by number, and stay so where they are alike.
    fn sort(self, objects: &mut [&SurveyObject]) {
        match self {
            Self::Number => {}
            Self::Seen => objects.sort_by_key(|one| std::cmp::Reverse(one.boxes.len())),
            Self::Class => objects.sort_by(|a, b| a.joint.class.cmp(&b.joint.class)),
        }
    }
}

/// The order of the list, and its choice.
fn order(ui: &mut Ui) -> Order {
    let id = egui::Id::unique("order of objects");
    let mut order: Order = ui.data_mut(|data| *data.get_persisted_mut_or_default(id));
    let before = order;
    row(
        ui,
        "Order",
        "What the list of objects is sorted by.",
        |ui| {
            ComboBox::from_id_salt("sort objects")
                .width(ui.available_width() - 2.0)
                .selected_text(order.name())
                .show_ui(ui, |ui| {
                    for one in Order::ALL {
                        ui.selectable_value(&mut order, one, one.name());
                    }
                })
                .response
        },
    );
    if order != before {
        ui.data_mut(|data| data.insert_persisted(id, order));
    }
    order
}

/// Whether the filter of the queue lets an object through: by its own class and state.
fn passes(app: &App, filter: &Filter, object: &SurveyObject) -> bool {
    let of_class = |class: &String| *class == object.joint.class;
    let in_state = |state: State| match app.object_state(object) {
        ObjectState::Open(_) => state == State::Proposed,
        ObjectState::Accepted => state.is_object(),
        ObjectState::Rejected => state == State::Rejected,
    };
    filter.class.as_ref().is_none_or(of_class) && filter.state.is_none_or(in_state)
}

fn rows(ui: &mut Ui, context: &mut ViewContext<'_>, objects: &[&SurveyObject]) {
    let app = context.app;
    let number = app.selected_object().map(|object| object.number);
    let here = number.and_then(|number| objects.iter().position(|one| one.number == number));
    list_rows(ui, "objects", objects.len(), here, |ui, index| {
        if let Some(object) = objects.get(index) {
            let command = object_row(ui, app, object, here == Some(index));
            context.commands.extend(command);
        }
    });
}

/// `7 rock, 3 times, 1 undecided` with the colours of the logs that saw it.
fn object_row(ui: &mut Ui, app: &App, object: &SurveyObject, is_here: bool) -> Option<Command> {
    let state = app.object_state(object);
    let (said, shown) = match state {
        ObjectState::Open(open) if open == object.boxes.len() => {
            ("undecided".to_owned(), State::Proposed)
        }
        ObjectState::Open(open) => (format!("{open} undecided"), State::Proposed),
        ObjectState::Accepted => ("accepted".to_owned(), State::Accepted),
        ObjectState::Rejected => ("rejected".to_owned(), State::Rejected),
    };
    let times = text::plural(object.boxes.len(), "time", "times");
    let (number, class) = (object.number, &object.joint.class);
    let words = format!("{number} {class}, {times}");
    let logs = object.logs();
    let names: Vec<String> = (logs.iter().filter_map(|id| app.open_log(*id)))
        .map(|log| log.name())
        .collect();
    let clicked = ui
        .horizontal(|ui| {
            if app.log_count() > 1 {
                for log in logs.iter().filter_map(|id| app.open_log(*id)) {
                    swatch(ui, log.colour);
                }
            }
            let colour = theme::box_colour_on_panel(app.options.theme, shown);
            let [words, state] = [&words, &said].map(|text| RichText::new(text).color(colour));
            let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
            let button = Button::selectable(is_here, words).right_text(state);
            let button = button.truncate().min_size(size);
            let response = ui.add(button);
            let name = format!("Object {number}, {class}, seen {times}, {said}");
            response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_here, &name));
            let hint = format!("Seen in {}", names.join(", "));
            response.on_hover_text(hint).clicked()
        })
        .inner;
    let best = best(app, object)?;
    clicked.then_some(Command::SelectLogBox(best))
}

/// The box that shows an object first: one of the log that is shown, and of several the surest.
fn best(app: &App, object: &SurveyObject) -> Option<LogBox> {
    let score = |id: &LogBox| {
        let one = app.log_box(*id);
        one.and_then(|one| one.score).unwrap_or(1.0)
    };
    let rank = |id: &LogBox| (id.log == app.log.id, score(id));
    let boxes = object.boxes.iter();
    let best = boxes.max_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    best.copied()
}
