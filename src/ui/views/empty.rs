//! Draws text and buttons of an empty view.

use crate::app::Action;
use crate::ui::{ViewContext, theme};
use egui::{Rect, RichText, Ui, UiBuilder, vec2};

/// Text shown instead of a drawing that needs a GPU.
pub(super) const NO_GPU: &str =
    "No GPU: this picture needs a graphics driver (Vulkan, Metal or DirectX 12).";

/// First steps of a new user, one line each.
const FIRST_STEPS: [&str; 3] = [
    "1. Open the log that your recorder wrote on its card, or drop it on the window.",
    "2. Look whether the line follows the bottom here, and at the depths on the map.",
    "3. Export the depth map, the mosaic and the report.",
];

/// Shows a sentence in the middle of the view.
pub(super) fn say(ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect, text: &str) {
    middle(ui, context, (rect, 20.0), &[text], &[]);
}

/// Shows what the view waits for, or a button to go on when processing was stopped.
pub(super) fn wait(ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect, text: &str) {
    if !context.app.is_stopped() {
        return say(ui, context, rect, text);
    }
    let text = "Processing was stopped before there was a result.";
    middle(ui, context, (rect, 48.0), &[text], &[Action::Update]);
}

/// Shows what would fill the view, with buttons to open a log or the demo.
pub(super) fn offer_to_open(ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect, text: &str) {
    middle(ui, context, (rect, 84.0), &[text], &[Action::Open, Action::OpenDemo]);
}

/// Shows the first steps, with buttons to open a log or the demo.
pub(super) fn first_steps(ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect) {
    middle(ui, context, (rect, 140.0), &FIRST_STEPS, &[Action::Open, Action::OpenDemo]);
}

/// Shows lines of text in a band of this height, and buttons below them.
fn middle(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    (rect, height): (Rect, f32),
    lines: &[&str],
    actions: &[Action],
) {
    let colour = theme::canvas_text_colour(context.options());
    let band = Rect::from_center_size(rect.center(), vec2(rect.width() * 0.9, height));
    ui.scope_builder(UiBuilder::new().max_rect(band), |ui| {
        ui.vertical_centered(|ui| {
            for line in lines {
                ui.label(RichText::new(*line).color(colour));
            }
            if lines.len() > 1 {
                ui.add_space(8.0);
            }
            for &action in actions {
                context.button(ui.button(action.label()), action);
            }
        });
    });
}
