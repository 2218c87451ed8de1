//! What the boxes of an object say of it.

use crate::ObjectExtent;
use crate::review::{Confidence, Reviewed, State};
use crate::targets::Target;
use bathyscope_log::named;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// The decision about an object, in the order of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ObjectState {
    /// Nobody has decided.
    Undecided,
    /// There is an object: one of its boxes was accepted or drawn by hand. Further boxes that a
    /// search finds of it, or that a filter hides, do not open the question again.
    Accepted,
    /// There is nothing: all its boxes were rejected.
    Rejected,
}

named! {
    /// All of them, in the order of the work.
    pub ObjectState {
        Undecided: "undecided",
        Accepted: "accepted",
        Rejected: "rejected",
    }
}

/// What the boxes of an object say of it. Metres; NaN for what is not known.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSummary {
    /// What the analyst calls it: the first of its boxes that has a name; empty where none has.
    pub name: String,
    /// Remarks on its boxes, one after the other.
    pub notes: String,
    /// The decision about it.
    pub state: ObjectState,
    /// The highest score of its boxes.
    pub score: Option<f32>,
    /// How sure the analyst is: the surest word of its boxes.
    pub confidence: Option<Confidence>,
    /// Place among its boxes of the one that tells its size best.
    pub best: usize,
    /// Its length by that box.
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
            score: None,
            confidence: None,
            best: 0,
            length_m: f64::NAN,
            width_m: f64::NAN,
            depth_m: f64::NAN,
        };
        let mut best: Option<(bool, bool, f32)> = None;
        let (mut open, mut objects) = (0, 0);
        for (place, (one, target)) in boxes.enumerate() {
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
                summary.best = place;
                summary.length_m = target.length_m;
                summary.width_m = target.width_m;
                summary.depth_m = target.depth_m;
            }
        }
        summary.state = match (open, objects) {
            (_, 1..) => ObjectState::Accepted,
            (0, _) => ObjectState::Rejected,
            _ => ObjectState::Undecided,
        };
        summary
    }
}
