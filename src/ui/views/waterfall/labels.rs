//! Writes words on the picture.

use egui::{Align2, Color32, FontId, Galley, Painter, Pos2, Rect};
use std::sync::Arc;

/// Size of text on the picture, points.
const TEXT_POINTS: f32 = 11.0;
/// Room between labels, points.
const APART: f32 = 2.0;

/// Colour of words that do not name a side.
pub(super) const INK: Color32 = Color32::from_gray(235);

/// Short words that do not overlap each other or the edges of the view: a word that would overlap
/// an earlier one or reach beyond the view is not written.
pub(super) struct WaterfallLabels<'a> {
    painter: &'a Painter,
    occupied: Vec<Rect>,
}

impl<'a> WaterfallLabels<'a> {
    /// Creates an empty set of labels.
    pub(super) fn new(painter: &'a Painter) -> Self {
        Self { painter, occupied: Vec::new() }
    }

    /// Reserves an area, in which no words are written.
    pub(super) fn keep_clear(&mut self, area: Rect) {
        self.occupied.push(area);
    }

    /// Writes a word if there is room.
    pub(super) fn write(&mut self, at: Pos2, anchor: Align2, text: &str, ink: Color32) {
        let (galley, rect) = lay_out(self.painter, at, anchor, text);
        let ground = ground(rect);
        let apart = ground.expand(APART);
        let is_inside = self.painter.clip_rect().contains_rect(ground);
        if is_inside && self.occupied.iter().all(|other| !other.intersects(apart)) {
            paint(self.painter, galley, rect, ink);
            self.occupied.push(ground);
        }
    }
}

/// Writes a text on a background that keeps it readable on any picture.
pub(super) fn text(painter: &Painter, at: Pos2, anchor: Align2, text: &str) {
    let (galley, rect) = lay_out(painter, at, anchor, text);
    paint(painter, galley, rect, INK);
}

/// Returns the area that [`text`] covers.
pub(super) fn covered(painter: &Painter, at: Pos2, anchor: Align2, text: &str) -> Rect {
    ground(lay_out(painter, at, anchor, text).1)
}

fn lay_out(painter: &Painter, at: Pos2, anchor: Align2, text: &str) -> (Arc<Galley>, Rect) {
    let font = FontId::proportional(TEXT_POINTS);
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::PLACEHOLDER);
    let rect = anchor.anchor_size(at, galley.size());
    (galley, rect)
}

fn ground(text: Rect) -> Rect {
    text.expand2(egui::vec2(3.0, 1.0))
}

fn paint(painter: &Painter, galley: Arc<Galley>, rect: Rect, ink: Color32) {
    painter.rect_filled(ground(rect), 2.0, Color32::from_black_alpha(215));
    painter.galley(rect.min, galley, ink);
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{pos2, vec2};

    #[test]
    fn labels_neither_cover_each_other_nor_stick_out() {
        let frame = egui::Context::default().run_ui(Default::default(), |ui| {
            let painter = ui.painter_at(Rect::from_min_size(pos2(0.0, 0.0), vec2(200.0, 100.0)));
            let mut labels = WaterfallLabels::new(&painter);
            let mut written = |x: f32, y: f32| {
                labels.write(pos2(x, y), Align2::LEFT_TOP, "10 m", INK);
                labels.occupied.len()
            };
            assert_eq!(written(20.0, 20.0), 1);
            assert_eq!(written(25.0, 28.0), 1, "it would cover the first");
            assert_eq!(written(20.0, 50.0), 2);
            assert_eq!(written(195.0, 50.0), 2, "it would stick out");
            labels.keep_clear(Rect::from_min_size(pos2(0.0, 80.0), vec2(200.0, 20.0)));
            labels.write(pos2(20.0, 75.0), Align2::LEFT_TOP, "10 m", INK);
            assert_eq!(labels.occupied.len(), 3, "it would cover the banner");
        });
        frame.drop_without_applying_deltas();
    }
}
