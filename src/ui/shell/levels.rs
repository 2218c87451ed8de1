//! Draws gain, filters and levels of the waterfall, with a histogram in which black and white can
//! be dragged.

use crate::app::Action;
use crate::ui::panels::{find_setting, parts};
use crate::ui::{ViewContext, controls, theme};
use bathyscope_bottom::picture::LevelHistogram;
use bathyscope_products::pipeline::settings::{ControlValue, SettingKind, SettingRow, rows};
use egui::{Color32, CursorIcon, Painter, Pos2, Rect, Response, Sense, Stroke, Ui, pos2, vec2};

/// Width of the panel, points.
const WIDTH: f32 = 300.0;
/// Height of the histogram, points.
const HEIGHT: f32 = 72.0;
/// Half of the size of the knob of a level, points.
const KNOB: f32 = 5.0;
/// Least difference between black and white, levels.
const APART: f64 = 1.0;

/// Draws all controls of the picture.
pub(super) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>) {
    ui.set_width(WIDTH);
    names(ui, context, &rows::PICTURE_GAIN);
    for row in [&rows::PICTURE_SPREADING, &rows::PICTURE_ABSORPTION, &rows::PICTURE_BALANCE] {
        parts::setting(ui, context, row);
    }
    names(ui, context, &rows::PICTURE_STRIPES);
    names(ui, context, &rows::PICTURE_DESPECKLE);
    ui.separator();
    histogram(ui, context);
    automatic(ui, context);
    if context.app.logs.shown.settings.picture.black.is_some() {
        parts::setting(ui, context, &rows::PICTURE_BLACK);
        parts::setting(ui, context, &rows::PICTURE_WHITE);
    }
    parts::setting(ui, context, &rows::PICTURE_GAMMA);
    ui.separator();
    names(ui, context, &rows::PICTURE_FLIP);
    names(ui, context, &rows::PICTURE_FIRST);
    context.button(ui.button("Reset"), Action::LevelsReset);
}

/// Draws a setting of few names side by side, because a drop-down list would close the panel with
/// it.
fn names(ui: &mut Ui, context: &mut ViewContext<'_>, setting: &'static SettingRow) {
    let SettingKind::Choice(choice) = &setting.kind else {
        return;
    };
    let current = (choice.get)(&context.app.logs.shown.settings);
    parts::row(ui, setting.label, setting.hint, |ui| {
        let names = ui.horizontal(|ui| {
            for name in choice.names {
                let item = controls::chip(ui, name.value == current, name.label);
                if name.value == current {
                    find_setting::answer(ui, context, setting.key, &item);
                }
                let hint = format!("{} {}", setting.hint, name.meaning);
                if item.on_hover_text(hint).clicked() && name.value != current {
                    context.set(setting, ControlValue::Name(name.value), false);
                }
            }
        });
        names.response
    });
}

/// Returns black and white as they are shown, levels.
fn shown(context: &ViewContext<'_>, counted: &LevelHistogram) -> [f64; 2] {
    let picture = &context.app.logs.shown.settings.picture;
    [
        picture.black.unwrap_or(f64::from(255.0 * counted.automatic.black)),
        picture.white.unwrap_or(f64::from(255.0 * counted.automatic.white)),
    ]
}

fn automatic(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let picture = &context.app.logs.shown.settings.picture;
    let mut is_automatic = picture.black.is_none() && picture.white.is_none();
    let hint = "Black at the 1st percentile of the echoes, white a little above the 99th. \
                Off: black and white stay as they are set.";
    let counted = context.app.histogram();
    let levels = counted.map(|counted| shown(context, counted));
    ui.horizontal(|ui| {
        let switch = ui.checkbox(&mut is_automatic, "Automatic level");
        if switch.on_hover_text(hint).changed() {
            let levels = if is_automatic {
                None
            } else {
                // The levels stay at their present values, so that the picture does not jump.
                levels.or(Some([0.0, 255.0]))
            };
            set(context, levels, "levels of the waterfall", false);
        }
        let button = ui.button("0 to 255");
        let hint = "Black at 0, white at 255: levels as bytes are recorded.";
        if button.on_hover_text(hint).clicked() {
            let all = Some([0.0, 255.0]);
            set(context, all, "levels of the waterfall", false);
        }
    });
}

/// Sets black and white to these levels; with `None` they follow the log.
fn set(context: &mut ViewContext<'_>, levels: Option<[f64; 2]>, label: &'static str, live: bool) {
    let rounded = levels.map(|levels| levels.map(|level| (10.0 * level).round() / 10.0));
    context.change_live(label, live, |settings| {
        settings.picture.black = rounded.map(|[black, _]| black);
        settings.picture.white = rounded.map(|[_, white]| white);
    });
}

/// Draws the histogram of the levels, with black and white, which can be dragged.
fn histogram(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let size = vec2(ui.available_width(), HEIGHT);
    let (area, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let painter = ui.painter_at(area.expand(KNOB));
    let Some(counted) = context.app.histogram().cloned() else {
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Image, true, "Histogram, not counted yet")
        });
        return;
    };
    let levels = shown(context, &counted);
    let reach = f64::from(counted.reach).max(1.2 * levels[1]);
    let inside = area.shrink2(vec2(KNOB, 0.0));
    let weak = ui.visuals().weak_text_color();
    bars(&painter, inside, &counted, reach, weak);
    let x_of = |level: f64| inside.left() + (level / reach) as f32 * inside.width();
    for (level, fill) in levels.into_iter().zip([Color32::BLACK, Color32::WHITE]) {
        knob(&painter, inside, x_of(level), fill, context);
    }
    let [black, white] = levels;
    response.widget_info(|| {
        let name = format!("Histogram of the echoes, black at {black:.1}, white at {white:.1}");
        egui::WidgetInfo::labeled(egui::Role::Image, true, name)
    });
    if response.hovered() {
        ui.set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    let level_at = |at: Pos2| f64::from((at.x - inside.left()) / inside.width()) * reach;
    follow(ui, &response, context, levels, level_at);
}

/// Moves the nearer of black and white with a drag.
fn follow(
    ui: &Ui,
    response: &Response,
    context: &mut ViewContext<'_>,
    [black, white]: [f64; 2],
    level_at: impl Fn(Pos2) -> f64,
) {
    let held_id = response.id.with("held");
    if let Some(at) = response.interact_pointer_pos()
        && (response.drag_started() || response.clicked())
    {
        let level = level_at(at);
        let holds_black = (level - black).abs() < (level - white).abs();
        ui.data_mut(|data| data.insert_temp(held_id, holds_black));
    }
    let is_moved = response.dragged() || response.drag_stopped() || response.clicked();
    let Some(at) = response.interact_pointer_pos().filter(|_| is_moved) else {
        return;
    };
    let holds_black: bool = ui.data(|data| data.get_temp(held_id)).unwrap_or(false);
    let level = level_at(at).max(0.0);
    let levels = if holds_black {
        [level.min(white - APART).max(0.0), white]
    } else {
        [black, level.max(black + APART)]
    };
    let live = response.dragged() && !response.drag_stopped();
    let label = if holds_black { rows::PICTURE_BLACK.name } else { rows::PICTURE_WHITE.name };
    set(context, Some(levels), label, live);
}

fn bars(painter: &Painter, area: Rect, counted: &LevelHistogram, reach: f64, ink: Color32) {
    painter.rect_filled(area, 0.0, ink.gamma_multiply(0.08));
    let most = counted.bars.iter().copied().max().unwrap_or(1).max(1);
    let width = area.width() * counted.reach / (reach as f32 * counted.bars.len() as f32);
    for (index, &count) in counted.bars.iter().enumerate() {
        // The height is the square root of the count: otherwise the water column and the shadows
        // would hide the rest.
        let height = area.height() * (count as f32 / most as f32).sqrt();
        let top = pos2(area.left() + index as f32 * width, area.bottom() - height);
        let bar = Rect::from_min_max(top, pos2(top.x + width, area.bottom()));
        painter.rect_filled(bar.intersect(area), 0.0, ink);
    }
}

fn knob(painter: &Painter, area: Rect, x: f32, fill: Color32, context: &ViewContext<'_>) {
    let x = x.clamp(area.left(), area.right());
    let accent = theme::accent_colour(context.theme());
    let stroke = Stroke::new(1.5, accent);
    painter.line_segment([pos2(x, area.top()), pos2(x, area.bottom())], stroke);
    painter.circle(pos2(x, area.bottom() - KNOB), KNOB, fill, stroke);
}
