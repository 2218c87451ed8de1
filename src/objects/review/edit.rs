//! Defines the edits of a box by the analyst, and applies them to a review.

use super::{BoxId, Certainty, Review, Reviewed, State, held, is_name};
use crate::{Mark, MeasuredShadow, ObjectExtent, class_index};
use bathyscope_log::survey::Side;
use std::sync::Arc;

/// A decision about a box or a correction of it. Fields of type [`BoxId`] are the number of the
/// box.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// Accepts the box: there is an object.
    Accept(BoxId),
    /// Rejects the box: there is no object.
    Reject(BoxId),
    /// Removes the decision about the box.
    Undecide(BoxId),
    /// Moves or resizes the box.
    Reshape(BoxId, Mark),
    /// Moves the box to the other side.
    SwapSide(BoxId),
    /// Adds a box that the model missed; it gets the number [`Review::next_id`].
    Add {
        /// Side, pings and slant ranges of the box.
        mark: Mark,
        /// Index into the classes.
        class: usize,
    },
    /// Removes a box that was drawn by hand. A box that a model proposed cannot be removed, only
    /// rejected: it is a hard negative.
    Remove(BoxId),
    /// Adds a point, which has a place but no size; it gets the number [`Review::next_id`].
    AddPoint {
        /// Side of the point.
        side: Side,
        /// Index of the ping of the point.
        ping: usize,
        /// Slant range of the point in the recorder's scale, metres.
        range_m: f64,
        /// Index into the classes.
        class: usize,
    },
    /// Sets the edges of the echo and the shadow in the box.
    SetEdges {
        /// Number of the box.
        id: BoxId,
        /// Pings of the echo, near edge of the echo, and far edge of the shadow.
        mark: Mark,
        /// Slant range of the border between echo and shadow in the recorder's scale, metres; that
        /// of the far edge if there is no shadow.
        border_m: f64,
    },
    /// Removes the edges that the analyst has set: the program finds echo and shadow in the box
    /// again.
    FindEdges(BoxId),
    /// Sets the shadow, measured on a ping of the box, that determines the height; with `None`, the
    /// shadow of the box itself determines it again.
    SetShadow(BoxId, Option<MeasuredShadow>),
    /// Changes the class of the box by its name, which is added to the review's classes if it is
    /// new.
    Classify(BoxId, String),
    /// Sets the name of the object.
    Rename(BoxId, String),
    /// Sets the certainty of the analyst.
    Rate(BoxId, Option<Certainty>),
    /// Sets the remark.
    Note(BoxId, String),
}

impl Edit {
    /// Returns the name of the edit in the undo menu.
    pub fn label(&self) -> &'static str {
        self.label_and_target().0
    }

    /// Returns the number of the box to edit; `None` for an edit that adds a box.
    pub fn target(&self) -> Option<BoxId> {
        self.label_and_target().1
    }

    fn label_and_target(&self) -> (&'static str, Option<BoxId>) {
        match self {
            Edit::Accept(id) => ("accept box", Some(*id)),
            Edit::Reject(id) => ("reject box", Some(*id)),
            Edit::Undecide(id) => ("take decision back", Some(*id)),
            Edit::Classify(id, _) => ("class of box", Some(*id)),
            Edit::Reshape(id, _) => ("move box", Some(*id)),
            Edit::SwapSide(id) => ("swap side of box", Some(*id)),
            Edit::Add { .. } => ("new box", None),
            Edit::AddPoint { .. } => ("new point", None),
            Edit::SetEdges { id, .. } => ("edges of box", Some(*id)),
            Edit::FindEdges(id) => ("find edges of box", Some(*id)),
            Edit::SetShadow(id, _) => ("height of box", Some(*id)),
            Edit::Rename(id, _) => ("name of box", Some(*id)),
            Edit::Rate(id, _) => ("certainty of box", Some(*id)),
            Edit::Remove(id) => ("remove box", Some(*id)),
            Edit::Note(id, _) => ("note on box", Some(*id)),
        }
    }
}

impl Review {
    /// Returns the review after an edit; `None` if the edit changes nothing: there is no such box
    /// or class, the box has no extent, or the decision is already made.
    pub fn apply(&self, edit: &Edit) -> Option<Review> {
        match edit {
            Edit::Accept(id) => self
                .change(*id, |review_box| review_box.state = affirmed(review_box, State::Accepted)),
            Edit::Reject(id) => self.change(*id, |review_box| review_box.state = State::Rejected),
            Edit::Undecide(id) => self
                .change(*id, |review_box| review_box.state = affirmed(review_box, State::Proposed)),
            Edit::Reshape(id, mark) => {
                let mark = held(mark, self.identity.pings)?;
                self.correct(*id, |review_box| {
                    review_box.extent = review_box.extent.moved(&review_box.mark, &mark);
                    review_box.set_mark(mark);
                })
            }
            Edit::SwapSide(id) => self.correct(*id, |review_box| {
                review_box.shadow = None;
                review_box.mark.side = review_box.mark.side.other();
            }),
            Edit::Add { mark, class } => self.add(mark, *class, ObjectExtent::Found),
            Edit::AddPoint { side, ping, range_m, class } => {
                let mark = Mark::point(*side, *ping, *range_m);
                self.add(&mark, *class, ObjectExtent::Point)
            }
            Edit::SetEdges { id, mark, border_m } => {
                let mark = held(mark, self.identity.pings)?;
                let border_m = border_m.clamp(mark.near_m, mark.far_m);
                border_m.is_finite().then_some(())?;
                self.correct(*id, |review_box| {
                    review_box.set_mark(mark);
                    review_box.extent = ObjectExtent::Drawn { border_m };
                })
            }
            Edit::FindEdges(id) => self.correct(*id, |review_box| {
                if review_box.extent != ObjectExtent::Point {
                    review_box.extent = ObjectExtent::Found;
                }
            }),
            Edit::SetShadow(id, shadow) => {
                let mark = &self.get(*id)?.mark;
                shadow.is_none_or(|shadow| shadow.fits(mark)).then_some(())?;
                self.correct(*id, |review_box| review_box.shadow = *shadow)
            }
            Edit::Classify(id, name) => self.classify(*id, name.trim()),
            Edit::Rename(id, name) => {
                let name = name.trim();
                (name.is_empty() || is_name(name)).then_some(())?;
                self.correct(*id, |review_box| name.clone_into(&mut review_box.name))
            }
            Edit::Rate(id, certainty) => {
                self.correct(*id, |review_box| review_box.certainty = *certainty)
            }
            Edit::Remove(id) => self.remove(*id),
            Edit::Note(id, text) => {
                self.correct(*id, |review_box| review_box.note.clone_from(text))
            }
        }
    }

    fn change(&self, id: BoxId, change: impl FnOnce(&mut Reviewed)) -> Option<Review> {
        let index = self.position(id)?;
        let mut review_box = Reviewed::clone(&self.boxes[index]);
        change(&mut review_box);
        if review_box == *self.boxes[index] {
            return None;
        }
        let mut after = self.clone();
        after.boxes[index] = Arc::new(review_box);
        Some(after)
    }

    fn correct(&self, id: BoxId, change: impl FnOnce(&mut Reviewed)) -> Option<Review> {
        self.change(id, |review_box| {
            let before = review_box.clone();
            change(review_box);
            review_box.edited |= *review_box != before;
        })
    }

    /// Sets the class of a box by its name, which is added to the review's classes if it is new.
    fn classify(&self, id: BoxId, name: &str) -> Option<Review> {
        is_name(name).then_some(())?;
        let mut named = self.clone();
        let class = class_index(&mut named.classes, name);
        named.correct(id, |review_box| review_box.class = class)
    }

    fn add(&self, mark: &Mark, class: usize, extent: ObjectExtent) -> Option<Review> {
        let mark = held(mark, self.identity.pings)?;
        let class = (class < self.classes.len()).then_some(class)?;
        let mut after = self.clone();
        let id = after.take_id();
        after.boxes.push(Arc::new(Reviewed { extent, ..Reviewed::drawn(id, mark, class) }));
        Some(after)
    }

    fn remove(&self, id: BoxId) -> Option<Review> {
        let index = self.position(id)?;
        let is_manual = self.boxes[index].model.is_none();
        is_manual.then(|| {
            let mut after = self.clone();
            after.boxes.remove(index);
            after
        })
    }
}

/// Returns the state for a box that is accepted or undecided. A box drawn by hand was not proposed,
/// so it is [`State::Added`] in both cases.
fn affirmed(review_box: &Reviewed, state: State) -> State {
    if review_box.model.is_none() { State::Added } else { state }
}
