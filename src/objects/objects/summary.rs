//! What the boxes of an object say of it.

use crate::ObjectExtent;
use crate::review::{Confidence, Reviewed, State};
use crate::targets::Target;
use std::cmp::Ordering;

/// How far the decisions about an object are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectState {
    /// So many of its boxes are undecided.
    Open(usize),
    /// There is an object: all its boxes were accepted or drawn by hand.
    Accepted,
    /// There is nothing: all its boxes were rejected.
    Rejected,
}

/// What the boxes of an object say of it. Metres; NaN for what is not known.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSummary {
    /// What the analyst calls it: the first of its boxes that has a name; empty where none has.
    pub name: String,
    /// Remarks on its boxes, one after the other.
    pub notes: String,
    /// How far the decisions about it are.
    pub state: ObjectState,
    /// The same in the word that tables have for a box: that of the box that tells its size best.
    pub best_state: State,
    /// The highest score of its boxes.
    pub score: Option<f32>,
    /// How sure the analyst is: the surest word of its boxes.
    pub confidence: Option<Confidence>,
    /// Its length by the box that tells its size best.
    pub length_m: f64,
    /// Its width by the same box.
    pub width_m: f64,
    /// Depth of the bottom there by the same box.
    pub depth_m: f64,
}

impl ObjectSummary {
    /// Of the boxes of an object, with their places. Sizes are those of an accepted box before an
    /// undecided one, of a box whose edges were drawn before another, and then of the surest one.
    pub fn of<'a>(boxes: impl Iterator<Item = (&'a Reviewed, &'a Target)>) -> Self {
        let mut summary = Self {
            name: String::new(),
            notes: String::new(),
            state: ObjectState::Rejected,
            best_state: State::Rejected,
            score: None,
            confidence: None,
            length_m: f64::NAN,
            width_m: f64::NAN,
            depth_m: f64::NAN,
        };
        let mut best: Option<(bool, bool, f32)> = None;
        let (mut open, mut objects) = (0, 0);
        for (one, target) in boxes {
            open += usize::from(one.state == State::Proposed);
            objects += usize::from(one.state.is_object());
            if summary.name.is_empty() {
                summary.name.clone_from(&one.name);
            }
            if !one.note.is_empty() {
                if !summary.notes.is_empty() {
                    summary.notes.push_str("; ");
                }
                summary.notes.push_str(&one.note);
            }
            let higher = |score: f32| summary.score.is_none_or(|known| score > known);
            if one.score.is_some_and(higher) {
                summary.score = one.score;
            }
            summary.confidence = summary.confidence.max(one.confidence);
            let is_drawn = matches!(one.extent, ObjectExtent::Drawn { .. });
            let rank = (one.state.is_object(), is_drawn, one.score.unwrap_or(1.0));
            let is_better =
                |best: (bool, bool, f32)| rank.partial_cmp(&best) == Some(Ordering::Greater);
            if best.is_none_or(is_better) {
                best = Some(rank);
                summary.best_state = one.state;
                summary.length_m = target.length_m;
                summary.width_m = target.width_m;
                summary.depth_m = target.depth_m;
            }
        }
        summary.state = match (open, objects) {
            (0, 0) => ObjectState::Rejected,
            (0, _) => ObjectState::Accepted,
            _ => ObjectState::Open(open),
        };
        summary
    }
}
