//! The few parts that all panels are made of: sections, rows, facts, and controls that change a setting.

use crate::app::{Action, Command};
use crate::pipeline::{EngineStatus, Settings, Stage};
use crate::ui::{ViewContext, theme};
use egui::{Align, Layout, Response, RichText, Ui, WidgetText};

/// The heading of a panel's part, and whether it is open.
pub struct Section {
    /// Number of the paper's step, if it is one.
    pub number: Option<u8>,
    /// Name.
    pub title: &'static str,
    /// The stage whose result it shows, for the mark of stale results.
    pub stage: Option<Stage>,
}

/// How a stage's result stands to its settings.
#[derive(Clone, Copy, PartialEq)]
enum Freshness {
    Fresh,
    Stale,
    Running(f32),
}

fn freshness(context: &ViewContext<'_>, stage: Option<Stage>) -> Freshness {
    let Some(stage) = stage else {
        return Freshness::Fresh;
    };
    if let EngineStatus::Running {
        stage: running,
        fraction,
    } = context.app.engine_status()
    {
        if running == stage {
            return Freshness::Running(fraction);
        }
        if running < stage {
            return Freshness::Stale;
        }
    }
    match context.app.stale() {
        Some(first) if first <= stage => Freshness::Stale,
        _ => Freshness::Fresh,
    }
}

/// A titled part of a panel; a click on the title folds it.
pub fn section(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    section: &Section,
    body: impl FnOnce(&mut Ui, &mut ViewContext<'_>),
) {
    let folded_id = egui::Id::unique(("folded", section.title));
    let mut folded = ui.data_mut(|data| *data.get_persisted_mut_or(folded_id, false));
    let freshness = freshness(context, section.stage);
    if heading(ui, context, section, folded, freshness).clicked() {
        folded = !folded;
        ui.data_mut(|data| data.insert_persisted(folded_id, folded));
    }
    if !folded {
        body(ui, context);
        ui.add_space(2.0);
    }
    ui.add(egui::Separator::default().spacing(5.0));
}

fn heading(
    ui: &mut Ui,
    context: &ViewContext<'_>,
    section: &Section,
    folded: bool,
    freshness: Freshness,
) -> Response {
    let look = context.app.options.theme;
    let size = egui::vec2(ui.available_width(), 20.0);
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click());
    let painter = ui.painter();
    let strong = ui.visuals().strong_text_color();
    let mut x = rect.left();
    if let Some(number) = section.number {
        painter.text(
            egui::pos2(x, rect.center().y),
            egui::Align2::LEFT_CENTER,
            number,
            egui::FontId::proportional(14.0),
            theme::accent_colour(look),
        );
        x += 16.0;
    }
    let title = section.title.to_uppercase();
    let font = egui::FontId::proportional(12.0);
    painter.text(
        egui::pos2(x, rect.center().y),
        egui::Align2::LEFT_CENTER,
        title,
        font,
        strong,
    );
    let mark = match freshness {
        _ if folded => Some(("folded".to_owned(), ui.visuals().weak_text_color())),
        Freshness::Fresh => None,
        Freshness::Stale => Some((
            "older than its settings".to_owned(),
            theme::stale_colour(look),
        )),
        Freshness::Running(share) => Some((
            format!("{:.0} %", f64::from(share) * 100.0),
            theme::accent_colour(look),
        )),
    };
    if let Some((text, colour)) = mark {
        painter.text(
            rect.right_center(),
            egui::Align2::RIGHT_CENTER,
            text,
            egui::FontId::proportional(theme::SMALL),
            colour,
        );
    }
    let state = match freshness {
        Freshness::Stale => ", older than its settings",
        _ => "",
    };
    let name = format!("{} section{state}", section.title);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    response.on_hover_cursor(egui::CursorIcon::PointingHand)
}

/// A name on the left and a control on the right that carries the name for screen readers and tests.
pub fn row(ui: &mut Ui, name: &str, hint: &str, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    ui.horizontal(|ui| {
        let label = name_cell(ui, name, hint);
        let response = add(ui).labelled_by(label.id);
        if hint.is_empty() {
            response
        } else {
            response.on_hover_text(hint)
        }
    })
    .inner
}

fn name_cell(ui: &mut Ui, name: &str, hint: &str) -> Response {
    let size = egui::vec2(theme::LABEL_WIDTH, ui.spacing().interact_size.y);
    let label = ui
        .allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(theme::LABEL_WIDTH);
            ui.add(egui::Label::new(name).selectable(false).truncate())
        })
        .inner;
    if hint.is_empty() {
        label
    } else {
        label.on_hover_text(hint)
    }
}

/// A name and a value that can be selected and copied.
pub fn fact(ui: &mut Ui, name: &str, hint: &str, value: impl Into<WidgetText>) {
    let value: WidgetText = value.into();
    let value = value.strong();
    let style = egui::TextStyle::Body;
    let extend = Some(egui::TextWrapMode::Extend);
    let room = ui.available_width() - theme::LABEL_WIDTH - ui.spacing().item_spacing.x;
    let width = value.clone().into_galley(ui, extend, f32::INFINITY, style);
    let row = |ui: &mut Ui| {
        name_cell(ui, name, hint);
        // What is cut off is not known: a long value takes another line.
        let value = ui.add(egui::Label::new(value).wrap());
        if !hint.is_empty() {
            value.on_hover_text(hint);
        }
    };
    match width.size().x > room {
        true => ui.horizontal_top(row),
        false => ui.horizontal(row),
    };
}

/// A name and the file that is in use for it, with buttons that choose one and that leave it.
pub fn file(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    name: &str,
    hint: &str,
    path: Option<&std::path::Path>,
    [open, remove]: [Action; 2],
) {
    let mut press = |ui: &mut Ui, label: &str, action: Action| {
        let button = ui.small_button(label).accessible_name(action.label());
        if button.on_hover_text(action.hint()).clicked() {
            context.push(Command::Do(action));
        }
    };
    ui.horizontal(|ui| {
        name_cell(ui, name, hint);
        let Some(path) = path else {
            return press(ui, "Choose…", open);
        };
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            press(ui, "Remove", remove);
            press(ui, "Choose…", open);
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let file = path.file_name().unwrap_or_default().to_string_lossy();
                let shown = ui.add(egui::Label::new(RichText::new(file).strong()).truncate());
                shown.on_hover_text(path.display().to_string());
            });
        });
    });
}

/// A quiet remark.
pub fn remark(ui: &mut Ui, text: impl Into<String>) {
    ui.add(egui::Label::new(RichText::new(text).small().weak()).wrap());
}

/// Something that does not agree or could not be used.
pub fn warning(ui: &mut Ui, context: &ViewContext<'_>, text: &str) {
    let colour = theme::stale_colour(context.app.options.theme);
    ui.add(egui::Label::new(RichText::new(text).small().color(colour)).wrap());
}

/// A setting as a slider.
pub struct Knob {
    /// Name in front of it.
    pub name: &'static str,
    /// Name of its change in the undo menu.
    pub undo: &'static str,
    /// What it does, with the paper's symbol.
    pub hint: &'static str,
    /// Lowest and highest value.
    pub range: std::ops::RangeInclusive<f64>,
    /// Smallest step.
    pub step: f64,
    /// Digits after the point.
    pub decimals: usize,
    /// Unit behind the number.
    pub suffix: &'static str,
}

/// Width of the value beside a slider: a unit as long as `m/s` must find room, or the row is wider than its panel.
fn value_width(ui: &Ui, knob: &Knob) -> f32 {
    let font = egui::TextStyle::Button.resolve(ui.style());
    let width = |value: f64| {
        let text = format!("{value:.*}{}", knob.decimals, knob.suffix);
        let colour = egui::Color32::PLACEHOLDER;
        let galley = ui.painter().layout_no_wrap(text, font.clone(), colour);
        galley.size().x
    };
    let widest = width(*knob.range.start()).max(width(*knob.range.end()));
    (widest + 2.0 * ui.spacing().button_padding.x)
        .ceil()
        .max(58.0)
}

/// A part of a window whose content, however wide, leaves it as wide as it is: a panel that took the width of its content would
/// offer that width again in the next frame, and a row that is a little too wide would widen it for ever.
pub fn of_given_width(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    let area = ui.available_rect_before_wrap();
    let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(area));
    add(&mut inner);
    ui.advance_cursor_after_rect(area);
}

/// A slider for a setting; a whole drag is one undo step.
pub fn knob(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    knob: Knob,
    value: f64,
    set: impl FnOnce(&mut Settings, f64),
) {
    let mut wanted = value;
    let response = row(ui, knob.name, knob.hint, |ui| {
        let value_width = value_width(ui, &knob);
        ui.spacing_mut().slider_width = (ui.available_width() - value_width - 8.0).max(40.0);
        ui.spacing_mut().interact_size.x = value_width;
        ui.add(
            egui::Slider::new(&mut wanted, knob.range.clone())
                // A value is rounded when it is edited, not when it is shown: showing must change nothing.
                .clamping(egui::SliderClamping::Edits)
                .step_by(knob.step)
                .fixed_decimals(knob.decimals)
                .suffix(knob.suffix),
        )
    });
    if response.changed() || response.drag_stopped() {
        let mut settings = Settings::clone(&context.app.log.settings);
        if response.changed() {
            set(&mut settings, wanted);
        }
        context.push(Command::Change {
            settings: Box::new(settings),
            label: knob.undo,
            live: response.dragged() && !response.drag_stopped(),
        });
    }
}

/// One of several values of a setting: value, name, what it means.
pub type Choice<T> = (T, &'static str, &'static str);

/// A setting as a list to choose from.
pub fn choice<T: Copy + PartialEq>(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    name: &'static str,
    hint: &str,
    options: &[Choice<T>],
    current: T,
    set: impl FnOnce(&mut Settings, T),
) {
    let shown = options
        .iter()
        .find(|(value, ..)| *value == current)
        .map_or("", |(_, shown, _)| *shown);
    let mut picked = None;
    row(ui, name, hint, |ui| {
        egui::ComboBox::from_id_salt(name)
            .width(ui.available_width() - 2.0)
            .selected_text(shown)
            .show_ui(ui, |ui| {
                for (value, label, meaning) in options {
                    let item = ui.selectable_label(*value == current, *label);
                    if item.on_hover_text(*meaning).clicked() {
                        picked = Some(*value);
                    }
                }
            })
            .response
    });
    if let Some(value) = picked {
        let mut settings = Settings::clone(&context.app.log.settings);
        set(&mut settings, value);
        context.push(Command::Change {
            settings: Box::new(settings),
            label: name,
            live: false,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

    #[test]
    fn a_fact_is_never_cut_off() {
        let value = "0.82 × 1.30 m, height 2.05 m";
        let mut panel = Harness::builder().with_size([220.0, 120.0]).build_ui(|ui| {
            fact(ui, "Object", "", value);
            fact(ui, "Depth", "", "3.20 m");
        });
        panel.run();
        let height = |text: &str| panel.get_by_label(text).rect().height();
        // In two lines, where one has no room; what has room stays in one.
        assert!(height(value) > 1.5 * height("3.20 m"));
        assert!(panel.get_by_label(value).rect().right() <= 220.0);
    }
}
