//! Words on the picture.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect};

/// Size of text on the picture, points.
const TEXT_POINTS: f32 = 11.0;

/// Text with a ground that keeps it readable on any picture. Returns the ground.
pub(super) fn text(painter: &Painter, at: Pos2, anchor: Align2, text: &str) -> Rect {
    let galley = painter.layout_no_wrap(
        text.to_owned(),
        FontId::proportional(TEXT_POINTS),
        Color32::from_gray(235),
    );
    let rect = anchor.anchor_size(at, galley.size());
    let ground = rect.expand2(egui::vec2(3.0, 1.0));
    painter.rect_filled(ground, 2.0, Color32::from_black_alpha(150));
    painter.galley(rect.min, galley, Color32::PLACEHOLDER);
    ground
}
