//! Draws legends over a view: scales of colours, and plates of text; and the text and buttons of an
//! empty view.

use super::ticks;
use crate::app::{Action, ViewOptions};
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::cloud::DepthReference;
use bathyscope_bottom::presentation::colours::{depth_colour, difference_colour, share_colour};
use bathyscope_bottom::presentation::units::Units;
use egui::{
    Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, RichText, Shape, Ui, UiBuilder, Vec2, pos2,
    vec2,
};

/// Width of the colour bar, points.
const BAR: f32 = 12.0;
/// Steps of the colour bar.
const STEPS: usize = 40;

/// Returns true if a view has room for words beside its numbers; a small view keeps scales and
/// legends, but shows no explanations.
pub(super) fn has_room(rect: Rect) -> bool {
    rect.size().min_elem() >= 240.0
}

/// Returns true if a view is wide enough for a line of words.
pub(super) fn has_width(rect: Rect) -> bool {
    rect.width() >= 150.0
}

/// Returns the font of small text on a view.
pub(super) fn font() -> FontId {
    FontId::proportional(11.0)
}

/// Space between a text and the edge of its plate, points.
const PLATE_MARGIN: Vec2 = vec2(4.0, 2.0);

/// Returns the size that [`plate`] takes for a text.
pub(super) fn plate_size(painter: &Painter, text: &str) -> Vec2 {
    let galley = painter.layout_no_wrap(text.to_owned(), font(), Color32::WHITE);
    galley.size() + 2.0 * PLATE_MARGIN
}

/// Writes a text on a plate; returns the area of the plate.
pub(super) fn plate(
    painter: &Painter,
    options: &ViewOptions,
    at: Pos2,
    anchor: Align2,
    text: &str,
    colour: Color32,
) -> Rect {
    let galley = painter.layout_no_wrap(text.to_owned(), font(), colour);
    let rect = anchor.anchor_size(at, galley.size() + 2.0 * PLATE_MARGIN);
    painter.rect_filled(rect, 3.0, theme::plate_colour(options));
    painter.galley(rect.min + PLATE_MARGIN, galley, colour);
    rect
}

/// Writes words on a plate, in the colour of words on a canvas; returns the area of the plate.
pub(super) fn words(
    painter: &Painter,
    options: &ViewOptions,
    at: Pos2,
    anchor: Align2,
    text: &str,
) -> Rect {
    let ink = theme::canvas_text_colour(options);
    plate(painter, options, at, anchor, text, ink)
}

/// Returns the shift from a place of a view to a text above it, and the anchor of the text, on the
/// side where there is more room.
pub(super) fn beside(at: Pos2, view: Rect, away: f32) -> (Vec2, Align2) {
    if at.x < view.center().x {
        (vec2(away, -away), Align2::LEFT_BOTTOM)
    } else {
        (vec2(-away, -away), Align2::RIGHT_BOTTOM)
    }
}

/// Puts buttons on a part of a view, in a frame that keeps them readable over whatever is drawn
/// there.
pub(super) fn framed(ui: &mut Ui, options: &ViewOptions, place: Rect, add: impl FnOnce(&mut Ui)) {
    let frame =
        egui::Frame::NONE.fill(theme::plate_colour(options)).corner_radius(3.0).inner_margin(2.0);
    ui.scope_builder(UiBuilder::new().max_rect(place), |ui| frame.show(ui, add));
}

/// A scale of colours with their values.
pub(super) struct LegendScale {
    title: String,
    /// Values at the top and at the bottom, in the unit of the title.
    ends: [f64; 2],
    /// Function from a share of the way from the top to a colour.
    colour: fn(f32) -> [u8; 3],
    /// True if values above zero carry a sign.
    signed: bool,
}

impl LegendScale {
    /// Creates a scale of depths, shallow on top.
    pub(super) fn of_depth(range_m: [f32; 2], reference: DepthReference, units: Units) -> Self {
        Self {
            title: reference.title(units.symbol()),
            ends: range_m.map(|depth_m| units.in_unit(f64::from(depth_m))),
            colour: depth_colour,
            signed: false,
        }
    }

    /// Creates a scale of levels of echoes, the strongest on top.
    pub(super) fn of_levels([low, high]: [f32; 2]) -> Self {
        Self {
            title: "echo level".to_owned(),
            ends: [high, low].map(f64::from),
            colour: |share| share_colour(1.0 - share),
            signed: false,
        }
    }

    /// Creates a scale of lengths, the least on top.
    pub(super) fn of_lengths(
        name: &str,
        ends_m: [f32; 2],
        units: Units,
        colour: fn(f32) -> [u8; 3],
    ) -> Self {
        Self {
            title: format!("{name}, {}", units.symbol()),
            ends: ends_m.map(|metres| units.in_unit(f64::from(metres))),
            colour,
            signed: false,
        }
    }

    /// Creates a scale of the hardness of the bed against the median of the map, decibels, the
    /// hardest on top.
    pub(super) fn of_hardness([low_db, high_db]: [f32; 2]) -> Self {
        Self {
            title: "hardness, dB".to_owned(),
            ends: [high_db, low_db].map(f64::from),
            colour: |share| share_colour(1.0 - share),
            signed: true,
        }
    }

    /// Creates a scale of residuals up to `reach_m` to either side of zero, the higher on top.
    pub(super) fn of_residuals(reach_m: f64, units: Units) -> Self {
        let reach = units.in_unit(reach_m);
        Self {
            title: format!("residual, {}", units.symbol()),
            ends: [reach, -reach],
            colour: |share| difference_colour(1.0 - share),
            signed: true,
        }
    }

    /// Draws the scale upright with its right bottom corner at `corner`; returns the covered area.
    pub(super) fn show(
        &self,
        painter: &Painter,
        options: &ViewOptions,
        corner: Pos2,
        height: f32,
    ) -> Rect {
        let text = theme::canvas_text_colour(options);
        let title = painter.layout_no_wrap(self.title.clone(), font(), text);
        let width = (title.size().x + 10.0).max(64.0);
        let plate = Rect::from_min_max(corner - vec2(width, height + 34.0), corner);
        painter.rect_filled(plate, 3.0, theme::plate_colour(options));
        painter.galley(plate.min + vec2(6.0, 4.0), title, text);
        let bar = Rect::from_min_size(plate.min + vec2(8.0, 24.0), vec2(BAR, height));
        painter.add(bar_shape(bar, self.colour));
        let [top, bottom] = self.ends;
        let (low, high) = (top.min(bottom), top.max(bottom));
        let parts = f64::from(height / 22.0).max(2.0);
        let step = ticks::round_step((high - low).max(1e-3), parts);
        for value in ticks::multiples(low, high, step) {
            let share = if high > low { ((value - top) / (bottom - top)) as f32 } else { 0.5 };
            let y = bar.top() + height * share;
            painter.hline(bar.right()..=bar.right() + 4.0, y, (1.0, text));
            let sign = if self.signed && value > 0.0 { "+" } else { "" };
            let label = format!("{sign}{}", ticks::label(value, step));
            let at = pos2(bar.right() + 7.0, y);
            painter.text(at, Align2::LEFT_CENTER, label, font(), text);
        }
        plate
    }
}

fn bar_shape(bar: Rect, colour: fn(f32) -> [u8; 3]) -> Shape {
    let mut mesh = Mesh::default();
    for step in 0..STEPS {
        let [top, bottom] = [step, step + 1].map(|step| step as f32 / STEPS as f32);
        let band = Rect::from_min_max(
            pos2(bar.left(), bar.top() + top * bar.height()),
            pos2(bar.right(), bar.top() + bottom * bar.height()),
        );
        mesh.add_colored_rect(band, theme::rgb(colour(0.5 * (top + bottom))));
    }
    Shape::mesh(mesh)
}

/// Text shown instead of a drawing that needs a GPU.
pub(super) const NO_GPU: &str =
    "No GPU: this picture needs a graphics driver (Vulkan, Metal or DirectX 12).";

/// Shows a sentence in the middle of the view.
pub(super) fn say(ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect, text: &str) {
    middle(ui, context, (rect, 20.0), text, None);
}

/// Shows what the view waits for, or a button to go on when processing was stopped.
pub(super) fn wait(ui: &mut Ui, context: &mut ViewContext<'_>, rect: Rect, text: &str) {
    if !context.app.is_stopped() {
        return say(ui, context, rect, text);
    }
    let text = "Processing was stopped before there was a result.";
    middle(ui, context, (rect, 48.0), text, Some(Action::Update));
}

/// Shows a text in a band of this height, and a button below it.
fn middle(
    ui: &mut Ui,
    context: &mut ViewContext<'_>,
    (rect, height): (Rect, f32),
    text: &str,
    action: Option<Action>,
) {
    let colour = theme::canvas_text_colour(context.options());
    let band = Rect::from_center_size(rect.center(), vec2(rect.width() * 0.9, height));
    ui.scope_builder(UiBuilder::new().max_rect(band), |ui| {
        ui.vertical_centered(|ui| {
            ui.label(RichText::new(text).color(colour));
            if let Some(action) = action {
                context.button(ui.button(action.label()), action);
            }
        });
    });
}
