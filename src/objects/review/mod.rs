//! The analyst's decisions about the boxes of a survey: pure state, changed by edits, kept in a
//! file of its own.
//!
//! In: boxes that a model proposes, and edits. Out: boxes with decisions, the order in which to
//! look at them, and the rows of a file.
//!
//! `edit` is what a decision does, `adopt` what a new model's detections do to decisions that are
//! there, `queue` the order in which boxes are looked at, `searched` which pings a model has been
//! over, `tiles` the pictures that teach a detector, `file` how a review is kept. The log itself is
//! never touched.

mod adopt;
mod edit;
mod file;
mod queue;
mod searched;
mod tiles;

pub use edit::Edit;
pub use file::{BoxRow, ReviewError, ReviewRows, SearchRow, read_text};
pub use queue::{DecisionCounts, Queue, Sort};
pub use searched::Searched;
pub use tiles::ReviewedTile;

use super::class::is_name;
use super::{Mark, MeasuredShadow, ObjectExtent};
use bathyscope_log::named;
use bathyscope_log::survey::Identity;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Side of a pixel of the raster that boxes are compared and shown in, metres.
pub const PIXEL_M: f64 = 0.04;

/// Number of a box, never given twice in a review.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct BoxId(pub u32);

/// State of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Proposed by a model, not yet decided.
    Proposed,
    /// Proposed by a model, and right.
    Accepted,
    /// Proposed where no object is: a hard negative for training.
    Rejected,
    /// Missed by the model and drawn by hand.
    Added,
}

named! {
    /// All states in the order of the work.
    pub State {
        Proposed: "proposed",
        Accepted: "accepted",
        Rejected: "rejected",
        Added: "added",
    }
}

/// The certainty of the analyst that there is an object, and of what it is: a word of their own,
/// beside the score of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Certainty {
    /// It may be something else, or nothing.
    Unsure,
    /// More likely than not.
    Probable,
    /// No doubt.
    Certain,
}

named! {
    /// All of them, the least sure first.
    pub Certainty {
        Unsure: "unsure",
        Probable: "probable",
        Certain: "certain",
    }
}

impl State {
    /// Returns true if it says that there is an object.
    pub fn is_object(self) -> bool {
        matches!(self, State::Accepted | State::Added)
    }
}

/// A box with what is decided about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reviewed {
    /// Its number.
    pub id: BoxId,
    /// Box around the echo and its shadow.
    pub mark: Mark,
    /// Index into [`Review::classes`].
    pub class: usize,
    /// Score of the last model that saw it, 0 to 1; `None` while none has.
    pub score: Option<f32>,
    /// State of the decision about it.
    pub state: State,
    /// Class, place, edges, name, certainty or note were changed by hand: a new model does not
    /// take it away.
    pub edited: bool,
    /// The analyst's remark.
    pub note: String,
    /// Name from the analyst, in addition to its class; empty where it has no name.
    pub name: String,
    /// Certainty of the analyst; `None` where not stated.
    pub certainty: Option<Certainty>,
    /// Source of its extent.
    pub extent: ObjectExtent,
    /// The shadow that its height was measured by; `None` where it is the one of its extent.
    pub shadow: Option<MeasuredShadow>,
    /// The model that proposed it; `None` for a box drawn by hand.
    pub model: Option<Arc<str>>,
}

impl Reviewed {
    /// A box that is drawn by hand, with nothing said of it yet; a proposal differs in score, state
    /// and model.
    pub fn drawn(id: BoxId, mark: Mark, class: usize) -> Self {
        Self {
            id,
            mark,
            class,
            score: None,
            state: State::Added,
            edited: false,
            note: String::new(),
            name: String::new(),
            certainty: None,
            extent: ObjectExtent::Found,
            shadow: None,
            model: None,
        }
    }

    /// Gives it another box. A shadow that was measured on a ping outside of it is none of its own.
    fn set_mark(&mut self, mark: Mark) {
        self.shadow = self.shadow.filter(|shadow| shadow.fits(&mark));
        self.mark = mark;
    }

    /// Returns true if the analyst has touched it; a new model leaves such a box as it is.
    pub fn is_kept(&self) -> bool {
        self.state != State::Proposed || self.edited
    }

    /// Returns true where it is in sight: where it is kept, or has no lower score than `threshold`.
    pub(crate) fn is_shown_from(&self, threshold: f32) -> bool {
        self.is_kept() || self.score.is_none_or(|score| score >= threshold)
    }
}

/// All boxes of a survey. Boxes are shared between the versions that undo keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Review {
    identity: Identity,
    classes: Vec<String>,
    /// Boxes in the order of their numbers.
    boxes: Vec<Arc<Reviewed>>,
    next_id: u32,
    /// Along the track, without overlap.
    searched: Vec<Searched>,
}

impl Review {
    /// An empty review with the classes that a box can have.
    pub fn new(identity: Identity, classes: Vec<String>) -> Self {
        Self { identity, classes, boxes: Vec::new(), next_id: 1, searched: Vec::new() }
    }

    /// The same for a log of which more was written since, or whose sides are exchanged: a box
    /// stays on its echo.
    #[must_use]
    pub fn carried_to(&self, identity: Identity) -> Self {
        let there = self.clone().with_sides(identity.swapped_sides);
        Self { identity, ..there }
    }

    /// The log that it belongs to.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// The same boxes for a log whose port and starboard are exchanged or not: a box stays on its
    /// echo.
    #[must_use]
    pub fn with_sides(mut self, swapped_sides: bool) -> Self {
        if self.identity.swapped_sides != swapped_sides {
            for one in &mut self.boxes {
                let one = Arc::make_mut(one);
                one.mark.side = one.mark.side.other();
            }
            self.identity.swapped_sides = swapped_sides;
        }
        self
    }

    /// Names of the classes.
    pub fn classes(&self) -> &[String] {
        &self.classes
    }

    /// Name of a class; empty for an index that has none.
    pub fn class_name(&self, class: usize) -> &str {
        self.classes.get(class).map_or("", String::as_str)
    }

    /// The review with a class under another name, which all its boxes have then; `None` where it
    /// has no such class. Boxes of two classes that have one name then are of one class.
    pub fn with_class_renamed(&self, from: &str, to: &str) -> Option<Review> {
        let place = |name: &str| self.classes.iter().position(|class| class == name);
        let of = place(from).filter(|_| from != to && is_name(to))?;
        let mut after = self.clone();
        match place(to) {
            None => to.clone_into(&mut after.classes[of]),
            Some(known) => {
                for one in after.boxes.iter_mut().filter(|one| one.class == of) {
                    Arc::make_mut(one).class = known;
                }
            }
        }
        Some(after)
    }

    /// The boxes in the order of their numbers.
    pub fn boxes(&self) -> impl ExactSizeIterator<Item = &Reviewed> {
        self.boxes.iter().map(AsRef::as_ref)
    }

    /// The boxes, shared with the other versions of the review.
    pub fn shared(&self) -> &[Arc<Reviewed>] {
        &self.boxes
    }

    /// A box by its number.
    pub fn get(&self, id: BoxId) -> Option<&Reviewed> {
        self.position(id).map(|index| self.boxes[index].as_ref())
    }

    /// The number that the next box gets.
    pub fn next_id(&self) -> BoxId {
        BoxId(self.next_id)
    }

    fn position(&self, id: BoxId) -> Option<usize> {
        self.boxes.binary_search_by_key(&id, |one| one.id).ok()
    }

    fn take_id(&mut self) -> BoxId {
        let id = BoxId(self.next_id);
        self.next_id = self.next_id.saturating_add(1);
        id
    }
}

/// The mark held to the survey: at least one ping and a range that is positive; `None` when nothing
/// is left of it.
fn held(mark: &Mark, pings: usize) -> Option<Mark> {
    let (start, end) = (mark.pings.start, mark.pings.end.min(pings));
    let (near_m, far_m) = (mark.near_m.max(0.0), mark.far_m);
    let is_sound = start < end && far_m.is_finite() && far_m > near_m;
    is_sound.then_some(Mark::new(mark.side, start..end, [near_m, far_m]))
}

#[cfg(test)]
mod tests;
