//! Draws the buttons on the map, and the divider between two stacks of layers, which is dragged, or
//! moved by the arrow keys after a click. The layers are chosen in the title of the view.

use super::MapScene;
use crate::app::{Action, Command, MapLayer, Swipe, SwipeSide, Tool, WorkStep};
use crate::ui::controls::{self, keep_arrows};
use crate::ui::views::legend;
use crate::ui::{ViewContext, ViewRequest, theme};
use bathyscope_products::project::MeasurementKind;
use egui::{
    Align2, CursorIcon, Key, Modifiers, Painter, Rect, Response, Sense, Stroke, Ui, Vec2,
    WidgetInfo, pos2, vec2,
};

/// Half of the width in which the pointer grips the divider, points.
const REACH: f32 = 5.0;
/// Steps of the divider for an arrow key, and with Shift, as shares of the map.
const STEPS: [f32; 2] = [0.02, 0.1];

/// Returns the part of the map that a layer is drawn in.
pub(super) fn part(scene: &MapScene<'_>, layer: MapLayer) -> Rect {
    let swipe = &scene.options.map.swipe;
    let (left, right) = scene.rect.split_left_right_at_x(divider_x(scene.rect, swipe));
    match swipe.side(layer) {
        _ if !swipe.on => scene.rect,
        SwipeSide::Both => scene.rect,
        SwipeSide::Left => left,
        SwipeSide::Right => right,
    }
}

fn divider_x(rect: Rect, swipe: &Swipe) -> f32 {
    rect.left() + rect.width() * swipe.share.clamp(0.0, 1.0)
}

/// Draws the divider with the names of the layers on either side, and moves it.
pub(super) fn swipe_ui(ui: &mut Ui, context: &mut ViewContext<'_>, scene: &MapScene<'_>) {
    let swipe = &scene.options.map.swipe;
    if !swipe.on {
        return;
    }
    let x = divider_x(scene.rect, swipe);
    // The upper edge is left to the buttons, the lower one to the coordinates.
    let top = scene.rect.top() + 38.0;
    let bottom = (scene.rect.bottom() - 18.0).max(top);
    let handle = Rect::from_min_max(pos2(x - REACH, top), pos2(x + REACH, bottom));
    let response = ui.interact(handle, ui.scope_id().with("swipe"), Sense::click_and_drag());
    response.widget_info(|| {
        let percent = f64::from(100.0 * swipe.share);
        WidgetInfo::slider(true, percent, "Divider of the map, percent")
    });
    if let Some(by) = moved(ui, scene.rect, &response) {
        let mut options = context.options().clone();
        options.map.swipe.shift(by);
        context.show(options);
    }
    let response = response.on_hover_cursor(CursorIcon::ResizeHorizontal);
    paint(&ui.painter_at(scene.rect), scene, x, &response);
}

/// Returns the distance by which the divider was moved, as a share of the width; `None` if it was
/// not moved.
fn moved(ui: &mut Ui, rect: Rect, response: &Response) -> Option<f32> {
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    let mut by = response.drag_delta().x / rect.width().max(1.0);
    if response.has_focus() {
        keep_arrows(ui.ctx(), response.id, true, false);
        for (key, way) in [(Key::ArrowLeft, -1.0), (Key::ArrowRight, 1.0)] {
            // A plain arrow would match with Shift held, too.
            for (modifiers, step) in [(Modifiers::SHIFT, STEPS[1]), (Modifiers::NONE, STEPS[0])] {
                let pressed = ui.input_mut(|input| input.count_and_consume_key(modifiers, key));
                by += pressed as f32 * step * way;
            }
        }
    }
    (by != 0.0).then_some(by)
}

fn paint(painter: &Painter, scene: &MapScene<'_>, x: f32, response: &Response) {
    let held = response.hovered() || response.dragged() || response.has_focus();
    let ink = if held { theme::SELECTION_COLOUR } else { theme::canvas_text_colour(scene.options) };
    let plate = theme::plate_colour(scene.options);
    painter.vline(x, scene.rect.y_range(), Stroke::new(4.0, plate));
    painter.vline(x, scene.rect.y_range(), Stroke::new(1.5, ink));
    let grip = Rect::from_center_size(pos2(x, scene.rect.center().y), vec2(9.0, 34.0));
    painter.rect_filled(grip, 4.0, plate);
    painter.rect_stroke(grip, 4.0, Stroke::new(1.5, ink), egui::StrokeKind::Inside);
    for (side, anchor, aside) in
        [(SwipeSide::Left, Align2::RIGHT_TOP, -8.0), (SwipeSide::Right, Align2::LEFT_TOP, 8.0)]
    {
        let text = names(scene, side);
        let at = pos2(x, scene.rect.top() + 40.0) + Vec2::X * aside;
        if !text.is_empty() {
            legend::words(painter, scene.options, at, anchor, &text);
        }
    }
}

/// Returns the names of the layers that are drawn on this side only, the topmost first.
fn names(scene: &MapScene<'_>, side: SwipeSide) -> String {
    let map = &scene.options.map;
    let own = map.layers.bottom_up().rev().map(|shown| shown.layer);
    let own = own.filter(|layer| map.layers.is_visible(*layer) && map.swipe.side(*layer) == side);
    own.map(MapLayer::name).collect::<Vec<_>>().join("\n")
}

/// Shows the button Fit, in its step the tool of the calibration, and the menu of measuring tools.
pub(super) fn show_buttons(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    rect: Rect,
    request: &mut Option<ViewRequest>,
) {
    let bar = Rect::from_min_size(rect.min + vec2(4.0, 4.0), vec2(rect.width() - 60.0, 28.0));
    legend::framed(ui, context.options(), bar, |ui| {
        ui.horizontal(|ui| {
            buttons(ui, context, request);
            measure_menu(ui, context);
        });
    });
}

fn buttons(ui: &mut Ui, context: &mut ViewContext<'_>, request: &mut Option<ViewRequest>) {
    ui.spacing_mut().item_spacing.x = 4.0;
    let fit = ui.button("Fit");
    let hint = format!(
        "Shows the whole track and the layers around it ({}, or a double-click).",
        Action::Fit.key()
    );
    if fit.on_hover_text(hint).clicked() {
        *request = Some(ViewRequest::Fit);
    }
    let action = Action::Calibrate;
    let holds = context.app.logs.shown.reviewing.tool == Tool::Calibrate;
    if holds || context.options().panels.step == WorkStep::Correct {
        let tool = controls::underline(ui, holds, egui::Button::new("Calibrate"));
        context.keyed_button(tool.accessible_name(action.label()), action);
    }
}

fn measure_menu(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let tools = [
        (Action::MeasureDistance, MeasurementKind::Distance),
        (Action::MeasureArea, MeasurementKind::Area),
        (Action::DepthProfile, MeasurementKind::Profile),
        (Action::HeightFromShadow, MeasurementKind::Height),
    ];
    let tool = context.app.map.measuring.tool;
    let title = egui::RichText::new("Measure");
    let title = match tool {
        Some(_) => title.color(theme::MEASURE_COLOUR),
        None => title,
    };
    ui.menu_button(title, |ui| {
        for (action, kind) in tools {
            let is_it = tool == Some(kind);
            let button = egui::Button::selectable(is_it, action.label());
            let button = button.shortcut_text(action.key());
            let button = controls::underline(ui, is_it, button);
            if button.on_hover_text(action.hint()).clicked() {
                context.push(Command::Do(action));
                ui.close();
            }
        }
    });
}
