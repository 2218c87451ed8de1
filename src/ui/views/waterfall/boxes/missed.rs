//! Objects of the truth that no box has found.

use super::{Lens, on_screen, outline};
use crate::app::App;
use crate::ui::theme;
use crate::ui::views::waterfall::labels::WaterfallLabels;
use bathyscope_objects::truth::Mistake;
use egui::{Align2, Painter, Rect, vec2};

/// A missed object in view.
pub(in crate::ui::views::waterfall) struct Missed<'a> {
    class: &'a str,
    rect: Rect,
    is_selected: bool,
}

impl<'a> Missed<'a> {
    /// Those that a lens sees; none before anything was proposed, which would only give the truth
    /// away.
    pub(crate) fn in_view(lens: &Lens, app: &'a App) -> Vec<Self> {
        let judging = &app.log.reviewing.judging;
        let shown = app.view.options.waterfall.boxes && app.log.reviewing.has_boxes();
        let Some(comparison) = judging.comparison().filter(|_| shown) else {
            return Vec::new();
        };
        let truth = comparison.truth();
        let missed = judging.mistakes().iter().filter_map(|mistake| {
            let Mistake::Miss { object, .. } = mistake else {
                return None;
            };
            let known = truth.objects.get(*object)?;
            Some(Missed {
                class: truth.class_name(known.class),
                rect: on_screen(lens, &known.whole),
                is_selected: judging.missed() == Some(*object),
            })
        });
        missed.filter(|missed| missed.rect.intersects(lens.rect)).collect()
    }

    /// Draws its outline.
    pub(crate) fn draw(&self, painter: &Painter) {
        let style = outline::Style::missed();
        outline::draw(painter, self.rect, style, self.is_selected);
    }

    /// Writes `missed rock` below it, where the words of boxes are not.
    pub(crate) fn label(&self, labels: &mut WaterfallLabels<'_>) {
        let at = self.rect.left_bottom() + vec2(0.0, 2.0);
        let words = format!("missed {}", self.class);
        labels.write(at, Align2::LEFT_TOP, &words, theme::MISSED_COLOUR);
    }
}
