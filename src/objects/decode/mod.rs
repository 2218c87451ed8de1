//! Converts a network's numbers to boxes, in pixels of the network's input. Each family of
//! detectors has a file.
//!
//! In: the outputs of a network, and their shapes. Out: boxes with classes and scores.
//!
//! Every decoder takes the numbers as they come, the least score that counts, and gives one box a
//! candidate, of its surest class. What is not finite is no box: the numbers come from a file that
//! somebody else made.

mod boxes_and_confs;
mod columns;
mod end_to_end;
mod raw_heads;
mod rows;
mod yolox;

pub(crate) use boxes_and_confs::boxes_and_confs;
pub use columns::columns;
pub(crate) use end_to_end::end_to_end;
pub(crate) use raw_heads::{Head, HeadLayout, raw_head};
pub use rows::rows;
pub(crate) use yolox::yolox;

use super::{Rect, Scored};

/// The boxes found so far and what counts as one.
struct Found {
    least: f32,
    boxes: Vec<Scored>,
}

impl Found {
    fn new(least: f32) -> Self {
        Self { least, boxes: Vec::new() }
    }

    /// Keeps a box of the surest class when `trust` times its score counts.
    fn add(&mut self, trust: f32, scores: impl Iterator<Item = f32>, rect: impl FnOnce() -> Rect) {
        let surest = scores
            .enumerate()
            .filter(|(_, score)| score.is_finite())
            .max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((class, score)) = surest else {
            return;
        };
        self.add_one(class, trust * score, rect);
    }

    /// Keeps a box of known class when its score counts.
    fn add_one(&mut self, class: usize, score: f32, rect: impl FnOnce() -> Rect) {
        // Written so that a NaN does not count.
        if score >= self.least {
            let rect = rect();
            let finite = [rect.x0, rect.y0, rect.x1, rect.y1].iter().all(|edge| edge.is_finite());
            if finite && rect.area() > 0.0 {
                self.boxes.push(Scored::new(class, score.min(1.0), rect));
            }
        }
    }
}

/// A box by its centre and size.
fn centred([x, y, width, height]: [f32; 4]) -> Rect {
    Rect::new([x - 0.5 * width, y - 0.5 * height], [x + 0.5 * width, y + 0.5 * height])
}

/// `1 / (1 + e^-x)`.
fn logistic(x: f32) -> f32 {
    1.0 / (1.0 + (-x).exp())
}
