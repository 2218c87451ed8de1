//! Draws the steps of the work: their bar across the top of the window, and on the left the
//! sections of the step that is open.

use super::section::{Section, section, unfold_section};
use super::{
    calibration, cloud, corrections, exclusions, first_return, logs, maps, plan, residuals, survey,
};
use crate::app::{Action, Command, StepState, WorkStep};
use crate::ui::{ViewContext, hint_with_key, theme};
use bathyscope_products::pipeline::Stage;
use egui::{
    Align, Align2, Color32, CursorIcon, FontId, Label, Layout, Painter, Rect, Role, Sense, Shape,
    Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2,
};

/// Function that draws the contents of a section.
type Contents = fn(&mut Ui, &mut ViewContext<'_>);

/// The sections of all steps, in the order in which the steps show them.
static SECTIONS: &[(WorkStep, Section, Contents)] = &[
    (WorkStep::Logs, Section::new("Survey"), survey::ui),
    (WorkStep::Logs, Section::new("Logs"), logs::ui),
    (WorkStep::Logs, Section::new("Preset").folded(), survey::preset),
    (WorkStep::Bottom, Section::new(first_return::TITLE).of(Stage::FirstReturn), first_return::ui),
    (WorkStep::Correct, Section::new(calibration::TITLE).of(Stage::Calibration), calibration::ui),
    (WorkStep::Correct, Section::new("Depth correction").of(Stage::Cloud), corrections::depths),
    (
        WorkStep::Correct,
        Section::new("Position").of(Stage::Navigation).folded(),
        corrections::positions,
    ),
    (
        WorkStep::Correct,
        Section::new("Mounting").of(Stage::Navigation).folded(),
        corrections::mounting,
    ),
    (WorkStep::Correct, Section::new("Excluded").of(Stage::Calibration).folded(), exclusions::ui),
    (WorkStep::Map, Section::new(maps::DEPTH_MAP), maps::depth_map),
    (WorkStep::Map, Section::new(maps::ISOBATHS), maps::isobaths),
    (WorkStep::Map, Section::new(maps::MOSAIC).folded(), maps::mosaic),
    (WorkStep::Map, Section::new("Cloud").of(Stage::Cloud).folded(), cloud::ui),
    (WorkStep::Map, Section::new("Outliers").of(Stage::Outliers).folded(), cloud::outliers),
    (WorkStep::Map, Section::new("Survey planning").folded(), plan::ui),
    (WorkStep::Objects, Section::new("Objects"), cloud::objects),
    (WorkStep::Export, Section::new("Residuals").of(Stage::Outliers), residuals::ui),
    (WorkStep::Export, Section::new("Products"), maps::products),
];

/// Returns the step that has the section with a title; `None` if none has.
pub(crate) fn step_of(title: &str) -> Option<WorkStep> {
    let section = SECTIONS.iter().find(|(_, section, _)| section.title == title);
    section.map(|(step, ..)| *step)
}

/// Returns the title of the first section of a step.
pub(crate) fn first_section(step: WorkStep) -> &'static str {
    let first = SECTIONS.iter().find(|(of, ..)| *of == step);
    first.map_or_else(Default::default, |(_, section, _)| section.title)
}

/// Draws the sections of the step that is open.
pub(crate) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    if calibration::has_new_proposal(ui, context) {
        // The keyboard stays where it is: the next key may change the proposal.
        let mut options = context.options().clone();
        options.panels.step = WorkStep::Correct;
        context.show(options);
        unfold_section(ui.ctx(), calibration::TITLE);
        ui.ctx().request_repaint();
    }
    let open = context.options().panels.step;
    for (_, heading, contents) in SECTIONS.iter().filter(|(step, ..)| *step == open) {
        section(ui, context, heading, contents);
    }
}

/// Height of the bar, points.
pub(crate) const BAR_HEIGHT: f32 = 22.0;
/// Greatest width of the button of a step, points.
const WIDEST: f32 = 230.0;
/// Width of a button from which it has the whole title, points.
const ROOM: f32 = 184.0;
/// Space between two buttons, points.
const BETWEEN: f32 = 4.0;

/// Draws a button for each step, with its state.
pub(crate) fn bar(ui: &mut Ui, context: &mut ViewContext<'_>) {
    ui.spacing_mut().item_spacing.x = BETWEEN;
    let count = WorkStep::ALL.len() as f32;
    let width = ((ui.available_width() + BETWEEN) / count - BETWEEN).min(WIDEST);
    ui.horizontal_centered(|ui| {
        for step in WorkStep::ALL {
            button(ui, context, step, width);
        }
    });
}

/// Height of the line of the tour, points.
pub(crate) const TOUR_HEIGHT: f32 = 30.0;

/// Draws the sentence of the tour for the open step, with buttons to go on and to end the tour.
pub(crate) fn tour(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let step = context.options().panels.step;
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        context.named_button(ui.button("End"), Action::EndTour);
        if let Some(next) = step.next() {
            context.button(ui.button("Next step"), next.action());
        }
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            ui.strong(step.title());
            ui.add(Label::new(step.tour()).truncate()).on_hover_text(step.tour());
        });
    });
}

fn button(ui: &mut Ui, context: &mut ViewContext<'_>, step: WorkStep, width: f32) {
    let (rect, response) = ui.allocate_exact_size(vec2(width, 20.0), Sense::click());
    let is_open = context.options().panels.step == step;
    let state = step.state(context.app);
    let said = in_words(&state, context);
    let name = format!("Step {} {}, {said}", step.number(), step.title());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_open, &name));
    let visuals = ui.style().interact_selectable(&response, is_open);
    let painter = ui.painter_at(rect.expand(1.0));
    painter.rect_filled(rect, visuals.corner_radius, visuals.weak_bg_fill);
    if response.has_focus() {
        let stroke = ui.visuals().widgets.hovered.fg_stroke;
        painter.rect_stroke(rect, visuals.corner_radius, stroke, StrokeKind::Inside);
    }
    let accent = theme::accent_colour(context.theme());
    if is_open {
        // The line marks the open step without relying on colour.
        let along = rect.shrink2(vec2(3.0, 0.0)).x_range();
        painter.hline(along, rect.bottom() - 1.0, Stroke::new(2.0, accent));
    }
    let at = |x: f32| pos2(rect.left() + x, rect.center().y);
    let beside = Align2::LEFT_CENTER;
    painter.text(at(8.0), beside, step.number(), FontId::proportional(14.0), accent);
    let title = if width < ROOM { step.short_title() } else { step.title() };
    painter.text(at(24.0), beside, title, FontId::proportional(13.0), visuals.text_color());
    mark(&painter, rect, &state, ui.visuals().weak_text_color(), context);
    let response = response.on_hover_cursor(CursorIcon::PointingHand);
    let hint = format!("{}\nState: {said}.", hint_with_key(step.action()));
    if response.on_hover_text(hint).clicked() {
        context.push(Command::Do(step.action()));
    }
}

/// Describes the state of a step, without a full stop at its end.
fn in_words(state: &StepState, context: &ViewContext<'_>) -> String {
    match state {
        StepState::Open => "not begun".to_owned(),
        StepState::Done => "done".to_owned(),
        StepState::NeedsLook(why) => {
            let why = context.units().sentence(why);
            format!("needs a look: {}", why.trim_end_matches('.'))
        }
        StepState::OutOfDate => "out of date".to_owned(),
        StepState::Running(_) => "updating".to_owned(),
    }
}

/// Draws the mark of a state at the right end of a button: a tick, an exclamation mark, a ring, or
/// the done share.
fn mark(
    painter: &Painter,
    rect: Rect,
    state: &StepState,
    weak: Color32,
    context: &ViewContext<'_>,
) {
    let at = rect.right_center() - vec2(12.0, 0.0);
    let (stale, accent) =
        (theme::stale_colour(context.theme()), theme::accent_colour(context.theme()));
    match state {
        StepState::Open => {}
        StepState::Done => {
            let tick = [vec2(-4.0, 0.0), vec2(-1.5, 3.0), vec2(4.0, -3.5)].map(|by| at + by);
            painter.add(Shape::line(tick.to_vec(), Stroke::new(1.6, weak)));
        }
        StepState::NeedsLook(_) => {
            let font = FontId::proportional(15.0);
            painter.text(at, Align2::CENTER_CENTER, "!", font, stale);
        }
        StepState::OutOfDate => {
            painter.circle_stroke(at, 4.0, Stroke::new(1.6, stale));
        }
        StepState::Running(share) => {
            let text = share.map_or_else(
                || "…".to_owned(),
                |share| format!("{:.0} %", 100.0 * f64::from(share)),
            );
            let right = rect.right_center() - vec2(6.0, 0.0);
            let font = FontId::proportional(theme::SMALL);
            painter.text(right, Align2::RIGHT_CENTER, text, font, accent);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::panels::find_setting::{CONTROLS, ControlPlace};

    #[test]
    fn each_section_with_settings_is_in_a_step() {
        for (place, _) in CONTROLS {
            if let ControlPlace::Section(title) = place {
                assert!(step_of(title).is_some(), "{title}");
            }
        }
        assert_eq!(step_of(calibration::TITLE), Some(WorkStep::Correct));
    }

    #[test]
    fn each_step_has_a_section_and_each_title_is_there_once() {
        for step in WorkStep::ALL {
            assert!(!first_section(step).is_empty(), "{step:?}");
        }
        for (_, section, _) in SECTIONS {
            let same = SECTIONS.iter().filter(|(_, other, _)| other.title == section.title);
            assert_eq!(same.count(), 1, "{}", section.title);
        }
    }
}
