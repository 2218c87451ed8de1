//! Edits of a box by the analyst.

use super::{BoxId, Certainty, Review, Reviewed, State, held, is_name};
use crate::{Mark, MeasuredShadow, ObjectExtent, class_index};
use bathyscope_log::survey::Side;
use std::sync::Arc;

/// A decision or a correction.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// There is an object.
    Accept(BoxId),
    /// There is nothing.
    Reject(BoxId),
    /// Takes the decision back.
    Undecide(BoxId),
    /// It is of another class.
    Relabel(BoxId, usize),
    /// It lies elsewhere or is larger or smaller.
    Reshape(BoxId, Mark),
    /// It lies on the other side.
    SwapSide(BoxId),
    /// A box that the model missed; it gets [`Review::next_id`].
    Add {
        /// Side, pings and slant ranges of the box.
        mark: Mark,
        /// Index into the classes.
        class: usize,
    },
    /// Removes a box that was drawn by hand. One that a model proposed is rejected instead: it is a
    /// hard negative.
    Remove(BoxId),
    /// A point that the analyst marks: a place without size; it gets [`Review::next_id`].
    AddPoint {
        /// The side it lies on.
        side: Side,
        /// The ping that shows it.
        ping: usize,
        /// Its slant range by the recorder's scale, metres.
        range_m: f64,
        /// Index into the classes.
        class: usize,
    },
    /// The edges of its echo and its shadow as the analyst sees them.
    SetEdges {
        /// The box.
        id: BoxId,
        /// Pings of the echo, its near edge, and the end of the shadow.
        mark: Mark,
        /// Slant range of the border between echo and shadow by the recorder's scale, metres; that
        /// of the far edge where there is no shadow.
        border_m: f64,
    },
    /// Leaves it to the program again to find echo and shadow in the box.
    FindEdges(BoxId),
    /// Its height is that of what casts a shadow measured on one of its pings; with `None` that of
    /// its own shadow again.
    SetShadow(BoxId, Option<MeasuredShadow>),
    /// It is of a class by its name, which becomes one of the review's classes.
    Classify(BoxId, String),
    /// Name from the analyst.
    Rename(BoxId, String),
    /// Certainty of the analyst.
    Rate(BoxId, Option<Certainty>),
    /// A remark.
    Note(BoxId, String),
}

impl Edit {
    /// Its name in the undo menu.
    pub fn label(&self) -> &'static str {
        match self {
            Edit::Accept(_) => "accept box",
            Edit::Reject(_) => "reject box",
            Edit::Undecide(_) => "take decision back",
            Edit::Relabel(..) => "class of box",
            Edit::Reshape(..) => "move box",
            Edit::SwapSide(_) => "swap side of box",
            Edit::Add { .. } => "new box",
            Edit::AddPoint { .. } => "new point",
            Edit::SetEdges { .. } => "edges of box",
            Edit::FindEdges(_) => "find edges of box",
            Edit::SetShadow(..) => "height of box",
            Edit::Classify(..) => "class of box",
            Edit::Rename(..) => "name of box",
            Edit::Rate(..) => "certainty of box",
            Edit::Remove(_) => "remove box",
            Edit::Note(..) => "note on box",
        }
    }

    /// The box that it is about, if there is one already.
    pub fn target(&self) -> Option<BoxId> {
        match self {
            Edit::Add { .. } | Edit::AddPoint { .. } => None,
            Edit::Accept(id)
            | Edit::Reject(id)
            | Edit::Undecide(id)
            | Edit::Relabel(id, _)
            | Edit::Reshape(id, _)
            | Edit::SwapSide(id)
            | Edit::Remove(id)
            | Edit::SetEdges { id, .. }
            | Edit::FindEdges(id)
            | Edit::SetShadow(id, _)
            | Edit::Classify(id, _)
            | Edit::Rename(id, _)
            | Edit::Rate(id, _)
            | Edit::Note(id, _) => Some(*id),
        }
    }
}

impl Review {
    /// The review after an edit; `None` when it would change nothing: no such box or class, a box
    /// without extent, a decision that stands already.
    pub fn apply(&self, edit: &Edit) -> Option<Review> {
        match edit {
            Edit::Accept(id) => self.change(*id, |one| one.state = affirmed(one, State::Accepted)),
            Edit::Reject(id) => self.change(*id, |one| one.state = State::Rejected),
            Edit::Undecide(id) => {
                self.change(*id, |one| one.state = affirmed(one, State::Proposed))
            }
            Edit::Relabel(id, class) => {
                let class = (*class < self.classes.len()).then_some(*class)?;
                self.correct(*id, |one| one.class = class)
            }
            Edit::Reshape(id, mark) => {
                let mark = held(mark, self.identity.pings)?;
                self.correct(*id, |one| {
                    one.extent = one.extent.moved(&one.mark, &mark);
                    one.set_mark(mark);
                })
            }
            Edit::SwapSide(id) => self.correct(*id, |one| {
                one.shadow = None;
                one.mark.side = one.mark.side.other();
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
                self.correct(*id, |one| {
                    one.set_mark(mark);
                    one.extent = ObjectExtent::Drawn { border_m };
                })
            }
            Edit::FindEdges(id) => self.correct(*id, |one| {
                if one.extent != ObjectExtent::Point {
                    one.extent = ObjectExtent::Found;
                }
            }),
            Edit::SetShadow(id, shadow) => {
                let mark = &self.get(*id)?.mark;
                shadow.is_none_or(|shadow| shadow.fits(mark)).then_some(())?;
                self.correct(*id, |one| one.shadow = *shadow)
            }
            Edit::Classify(id, name) => self.classify(*id, name.trim()),
            Edit::Rename(id, name) => {
                let name = name.trim();
                (name.is_empty() || is_name(name)).then_some(())?;
                self.correct(*id, |one| name.clone_into(&mut one.name))
            }
            Edit::Rate(id, certainty) => self.correct(*id, |one| one.certainty = *certainty),
            Edit::Remove(id) => self.remove(*id),
            Edit::Note(id, text) => self.correct(*id, |one| one.note.clone_from(text)),
        }
    }

    fn change(&self, id: BoxId, change: impl FnOnce(&mut Reviewed)) -> Option<Review> {
        let index = self.position(id)?;
        let mut one = Reviewed::clone(&self.boxes[index]);
        change(&mut one);
        if one == *self.boxes[index] {
            return None;
        }
        let mut after = self.clone();
        after.boxes[index] = Arc::new(one);
        Some(after)
    }

    fn correct(&self, id: BoxId, change: impl FnOnce(&mut Reviewed)) -> Option<Review> {
        self.change(id, |one| {
            let before = one.clone();
            change(one);
            one.edited |= *one != before;
        })
    }

    /// The class becomes one of the review's own where it is new.
    fn classify(&self, id: BoxId, name: &str) -> Option<Review> {
        is_name(name).then_some(())?;
        let mut named = self.clone();
        let class = class_index(&mut named.classes, name);
        named.correct(id, |one| one.class = class)
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

/// A box drawn by hand has no proposal to go back to or to agree with: it is added, or it is
/// rejected.
fn affirmed(one: &Reviewed, state: State) -> State {
    if one.model.is_none() { State::Added } else { state }
}
