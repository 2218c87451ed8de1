//! Draws the parts that all panels use: rows, facts, controls that change a setting, and the axes
//! of plots.

use super::find_setting::{self, ControlPlace};
use crate::app::{Action, App, LogId, OpenLog};
use crate::ui::controls::{self, DropDown, ListKeys, number_field, number_slider};
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::presentation::plot::Axis;
use bathyscope_products::pipeline::settings::{
    Control, ControlValue, Number, SettingChoice, SettingKind, SettingRow, ShownNumber,
};
use egui::{
    Align, Align2, Button, Color32, FontId, Layout, Painter, Pos2, ProgressBar, Rect, Response,
    RichText, Stroke, Ui, WidgetText, pos2, vec2,
};

/// Draws a name on the left and a control on the right; the control has this name for screen
/// readers and tests.
pub(crate) fn row(
    ui: &mut Ui,
    name: &str,
    hint: &str,
    add: impl FnOnce(&mut Ui) -> Response,
) -> Response {
    ui.horizontal(|ui| {
        let label = name_cell(ui, name, hint);
        let response = add(ui).labelled_by(label.id);
        if hint.is_empty() { response } else { response.on_hover_text(hint) }
    })
    .inner
}

/// Draws the name of a row, as wide as the names of all rows.
pub(crate) fn name_cell(ui: &mut Ui, name: &str, hint: &str) -> Response {
    let size = egui::vec2(theme::LABEL_WIDTH, ui.spacing().interact_size.y);
    let label = ui
        .allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(theme::LABEL_WIDTH);
            ui.add(egui::Label::new(name).selectable(false).truncate())
        })
        .inner;
    if hint.is_empty() { label } else { label.on_hover_text(hint) }
}

/// Draws a name and a value that can be selected and copied.
pub(crate) fn fact(ui: &mut Ui, name: &str, hint: &str, value: impl Into<WidgetText>) {
    let value: WidgetText = value.into();
    let value = value.strong();
    let style = egui::TextStyle::Body;
    let extend = Some(egui::TextWrapMode::Extend);
    let room = ui.available_width() - theme::LABEL_WIDTH - ui.spacing().item_spacing.x;
    let width = value.clone().into_galley(ui, extend, f32::INFINITY, style);
    let row = |ui: &mut Ui| {
        name_cell(ui, name, hint);
        // The value must be complete: a long one is wrapped.
        let value = ui.add(egui::Label::new(value).wrap());
        if !hint.is_empty() {
            value.on_hover_text(hint);
        }
    };
    if width.size().x > room {
        ui.horizontal_top(row)
    } else {
        ui.horizontal(row)
    };
}

/// Draws a setting that is a file: its path, with buttons that choose and remove the file.
pub(crate) fn file(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    setting: &SettingRow,
    path: Option<&std::path::Path>,
    [open, remove]: [Action; 2],
) {
    let mut press = |ui: &mut Ui, label: &str, action: Action| {
        let button = ui.small_button(label).accessible_name(action.label());
        if action == open {
            find_setting::answer(ui, context, setting.key, &button);
        }
        context.button(button, action);
    };
    ui.horizontal(|ui| {
        name_cell(ui, setting.label, setting.hint);
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

/// Draws the visible rows of a list of any length. When `here` has changed, because keys step
/// through the list, that row is scrolled to the middle.
pub(crate) fn list_rows(
    ui: &mut Ui,
    name: &'static str,
    count: usize,
    here: Option<usize>,
    mut add: impl FnMut(&mut Ui, usize) -> Option<Response>,
) {
    const ROWS: f32 = 8.0;
    let height = ui.spacing().interact_size.y;
    let each = height + ui.spacing().item_spacing.y;
    let area = egui::ScrollArea::vertical().id_salt(name);
    let mut area = area.max_height(ROWS * each).auto_shrink([false, true]);
    let last_id = egui::Id::unique(("last row shown", name));
    let last: Option<usize> = ui.data(|data| data.get_temp(last_id)).flatten();
    if here != last {
        ui.data_mut(|data| data.insert_temp(last_id, here));
        if let Some(here) = here {
            let offset = (here as f32 - (ROWS - 1.0) / 2.0) * each;
            area = area.vertical_scroll_offset(offset.max(0.0));
        }
    }
    let keys = ListKeys::read(ui, name, count);
    let area = keys.scroll(area, each, ROWS);
    area.show_rows(ui, height, count, |ui, rows| {
        for index in rows {
            if let Some(row) = add(ui, index) {
                keys.row(ui, index, &row);
            }
        }
    });
}

/// Returns a bar for the done share of some work.
pub(crate) fn progress_bar(context: &ViewContext<'_>, share: f32, width: f32) -> ProgressBar {
    let bar = ProgressBar::new(share).desired_width(width);
    bar.desired_height(8.0).fill(theme::accent_colour(context.theme()))
}

/// Draws a table of small text, with hints for its headings.
pub(crate) fn table(ui: &mut Ui, name: &str, columns: &[(&str, &str)], rows: impl FnOnce(&mut Ui)) {
    egui::Grid::new(name).num_columns(columns.len()).spacing([8.0, 2.0]).striped(true).show(
        ui,
        |ui| {
            for (title, hint) in columns {
                ui.label(RichText::new(*title).small().strong()).on_hover_text(*hint);
            }
            ui.end_row();
            rows(ui);
        },
    );
}

/// Draws a remark in small, weak text.
pub(crate) fn remark(ui: &mut Ui, text: impl Into<String>) {
    ui.add(egui::Label::new(RichText::new(text).small().weak()).wrap());
}

/// Draws a warning about a contradiction, or about something that cannot be used.
pub(crate) fn warning(ui: &mut Ui, context: &ViewContext<'_>, text: &str) {
    let colour = theme::stale_colour(context.theme());
    ui.add(egui::Label::new(RichText::new(text).small().color(colour)).wrap());
}

/// Returns the width of the value beside a slider, points: without space for a unit as long as
/// `m/s`, the row would be wider than its panel.
fn value_width(ui: &Ui, number: &ShownNumber<'_>, none_word: Option<&str>) -> f32 {
    let font = egui::TextStyle::Button.resolve(ui.style());
    let width = |text: String| {
        let colour = egui::Color32::PLACEHOLDER;
        let galley = ui.painter().layout_no_wrap(text, font.clone(), colour);
        galley.size().x
    };
    let ends = number.ends.into_iter();
    let ends = ends.map(|value| format!("{value:.*}{}", number.decimals, number.suffix));
    let texts = ends.chain(none_word.map(str::to_owned));
    let widest = texts.map(width).fold(0.0, f32::max);
    (widest + 2.0 * ui.spacing().button_padding.x).ceil().max(58.0)
}

/// Draws content without widening the part of the window that contains it: a panel with the width
/// of its content would get that width again in the next frame, and a row that is a little too wide
/// would widen it for ever.
pub(crate) fn of_given_width(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    let area = ui.available_rect_before_wrap();
    let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(area));
    add(&mut inner);
    ui.advance_cursor_after_rect(area);
}

/// Draws a part of a panel, so that a row that is too wide does not widen the parts below it.
pub(crate) fn within(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    let area = ui.available_rect_before_wrap();
    let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(area));
    add(&mut inner);
    let foot = inner.min_rect().bottom().max(area.top());
    let used = egui::Rect::from_min_max(area.min, egui::pos2(area.right(), foot));
    ui.advance_cursor_after_rect(used);
}

/// Draws the control of a setting, as the table of settings defines it; a whole drag is one undo
/// step.
pub(crate) fn setting(ui: &mut Ui, context: &mut ViewContext<'_>, row: &'static SettingRow) {
    // A figure above that appears or disappears with the results must not end a drag.
    let own = egui::UiBuilder::new().scope_id(egui::Id::unique(("setting", row.key)));
    ui.scope_builder(own, |ui| {
        let control = match &row.kind {
            SettingKind::Number(setting) => number(ui, context, row, setting),
            SettingKind::Choice(setting) => choice(ui, context, row, setting),
            // Files are drawn by [`file`]; other settings are changed in a view.
            SettingKind::Numbers { .. } | SettingKind::Text(_) => return,
        };
        find_setting::answer(ui, context, row.key, &control);
    });
}

/// Draws the controls of all settings that are numbers or names in the section with this title.
pub(crate) fn settings_of(ui: &mut Ui, context: &mut ViewContext<'_>, title: &'static str) {
    for row in find_setting::rows_in(ControlPlace::Section(title)) {
        if matches!(row.kind, SettingKind::Number(_) | SettingKind::Choice(_)) {
            setting(ui, context, row);
        }
    }
}

fn number(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    setting: &'static SettingRow,
    number: &'static Number,
) -> Response {
    let units = context.units();
    let shown = number.shown_in(units);
    let [least, most] = shown.ends;
    let mut requested = shown.value(&context.app.logs.shown.settings);
    let hint = match number.without.filter(|_| number.zero_is_none()) {
        Some(without) => format!("{} At 0: {without}.", setting.hint),
        None => setting.hint.to_owned(),
    };
    let hint = units.sentence(&hint);
    let is_none = (number.get)(&context.app.logs.shown.settings).is_none();
    let none_word = number.none_word().filter(|_| is_none || number.zero_is_none());
    let shows_word = none_word.is_some() && requested == 0.0;
    let suffix = if shows_word { "" } else { &shown.suffix };
    // Zero is shown as the word for its meaning.
    let written = |value: f64| match none_word.filter(|_| value == 0.0) {
        Some(word) => word.to_owned(),
        None => format!("{value:.*}", shown.decimals),
    };
    let read = |text: &str| {
        let text = text.trim();
        let is_word = text.is_empty() || none_word.is_some_and(|word| word == text);
        if is_word && none_word.is_some() {
            Some(0.0)
        } else {
            controls::parse_number(text.trim_end_matches(shown.suffix.trim()))
        }
    };
    let response = row(ui, setting.label, &hint, |ui| {
        if number.control == Control::Drag {
            let value = number_field(&mut requested)
                .range(least..=most)
                // Drawing must not change the value.
                .clamp_existing_to_range(false)
                .speed(2.0 * shown.step)
                .custom_formatter(|value, _| written(value))
                .custom_parser(read);
            return ui.add(value.suffix(suffix));
        }
        find_setting::edit_number(ui, setting.key);
        let value_width = value_width(ui, &shown, none_word);
        ui.spacing_mut().slider_width = (ui.available_width() - value_width - 10.0).max(24.0);
        ui.spacing_mut().interact_size.x = value_width;
        ui.add(
            number_slider(&mut requested, least..=most)
                .logarithmic(number.control == Control::LogSlider)
                .smallest_positive(shown.step)
                // A value is rounded when it is edited, not when it is shown: drawing must not
                // change the value.
                .clamping(egui::SliderClamping::Edits)
                .step_by(shown.step)
                .custom_formatter(|value, _| written(value))
                .custom_parser(read)
                .suffix(suffix),
        )
    });
    if response.changed() || response.drag_stopped() {
        let live = response.dragged() && !response.drag_stopped();
        if response.changed() {
            context.set(setting, ControlValue::Number(shown.in_setting(requested)), live);
        } else {
            // The end of the drag changes nothing, and ends the undo step.
            context.change_live(setting.name, live, |_| {});
        }
    }
    response
}

fn choice(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    setting: &'static SettingRow,
    choice: &'static SettingChoice,
) -> Response {
    let current = (choice.get)(&context.app.logs.shown.settings);
    let shown = choice.names.iter().find(|name| name.value == current);
    let mut picked = None;
    let response = row(ui, setting.label, setting.hint, |ui| {
        let shown = shown.map_or(current.as_str(), |name| name.label);
        DropDown::new(setting.key, shown).width(ui.available_width() - 2.0).show(ui, |choices| {
            for name in choice.names {
                let item = choices.choice(name.value == current, name.label);
                if item.on_hover_text(name.meaning).clicked() {
                    picked = Some(name.value);
                }
            }
        })
    });
    if let Some(value) = picked {
        context.set(setting, ControlValue::Name(value), false);
    }
    response
}

/// Draws a small button of an action.
pub(crate) fn press(ui: &mut Ui, context: &mut ViewContext<'_>, action: Action, is_enabled: bool) {
    press_short(ui, context, (action, action.label()), is_enabled);
}

/// Draws a small button of an action with a short label, which the button before it explains.
pub(crate) fn press_short(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    (action, label): (Action, &str),
    is_enabled: bool,
) {
    let button = ui.add_enabled(is_enabled, Button::new(label).small());
    context.named_button(button, action);
}

/// Returns the name of an open log; empty if the log is not open any more.
pub(crate) fn name_of(app: &App, id: LogId) -> String {
    app.logs.get(id).map_or_else(String::new, OpenLog::name)
}

/// Space below for numbers and a name, points.
const BELOW: f32 = 26.0;
/// Space on the right for half of the last number, points.
const RIGHT: f32 = 20.0;
/// Space above for half of the highest number, points.
const ABOVE: f32 = 6.0;

/// The two axes of a plot on the screen.
pub(crate) struct PlotAxes {
    /// Area in which curves are drawn.
    pub area: Rect,
    across: Axis,
    up: Axis,
}

impl PlotAxes {
    /// Creates axes with space on the left for numbers and name: a number that is cut off would
    /// lose its sign first.
    pub(crate) fn new(painter: &Painter, rect: Rect, across: Axis, up: Axis) -> Self {
        let width = |(_, label): &(f64, String)| {
            let galley = painter.layout_no_wrap(label.clone(), font(), Color32::PLACEHOLDER);
            galley.size().x
        };
        let widest = up.ticks.iter().map(width).fold(20.0, f32::max);
        let name = if up.name.is_empty() { 0.0 } else { 8.0 };
        let min = rect.min + vec2(widest.ceil() + 6.0 + name, ABOVE);
        Self { area: Rect::from_min_max(min, rect.max - vec2(RIGHT, BELOW)), across, up }
    }

    /// Returns the position of a pair of values on the screen.
    pub(crate) fn at(&self, x: f64, y: f64) -> Pos2 {
        // The shares are small enough for an `f32`.
        let [x, y] = [self.across.share(x), self.up.share(y)].map(|share| share as f32);
        self.area.lerp_inside(vec2(x, 1.0 - y))
    }

    /// Draws lines, numbers and names of both axes.
    pub(crate) fn draw(&self, painter: &Painter, ink: Color32) {
        let faint = Stroke::new(1.0, ink.gamma_multiply(0.2));
        for (value, label) in &self.across.ticks {
            let x = self.at(*value, self.up.ends[0]).x;
            let below = pos2(x, self.area.bottom() + 3.0);
            painter.text(below, Align2::CENTER_TOP, label, font(), ink);
            painter.vline(x, self.area.y_range(), faint);
        }
        for (value, label) in &self.up.ticks {
            let y = self.at(self.across.ends[0], *value).y;
            let beside = pos2(self.area.left() - 4.0, y);
            painter.text(beside, Align2::RIGHT_CENTER, label, font(), ink);
            painter.hline(self.area.x_range(), y, faint);
        }
        let below = pos2(self.area.center().x, self.area.bottom() + 13.0);
        painter.text(below, Align2::CENTER_TOP, &self.across.name, font(), ink);
        let name = painter.layout_no_wrap(self.up.name.clone(), font(), ink);
        let left = self.area.left() - 24.0 - 8.0;
        let start = pos2(left, self.area.center().y + 0.5 * name.size().x);
        let quarter = std::f32::consts::FRAC_PI_2;
        painter.add(egui::epaint::TextShape::new(start, name, ink).with_angle(-quarter));
    }
}

fn font() -> FontId {
    FontId::proportional(10.0)
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
        // A long value takes two lines; a value with enough space stays in one.
        assert!(height(value) > 1.5 * height("3.20 m"));
        assert!(panel.get_by_label(value).rect().right() <= 220.0);
    }
}
