//! What the analyst does to a box.

use super::{BoxId, Review, Reviewed, State, held};
use crate::detection::Mark;
use crate::survey::Side;
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
        /// Where.
        mark: Mark,
        /// Index into the classes.
        class: usize,
    },
    /// Removes a box that was drawn by hand. One that a model proposed is rejected instead: it is a hard negative.
    Remove(BoxId),
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
            Edit::Remove(_) => "remove box",
            Edit::Note(..) => "note on box",
        }
    }

    /// The box that it is about, if there is one already.
    pub fn target(&self) -> Option<BoxId> {
        match self {
            Edit::Add { .. } => None,
            Edit::Accept(id)
            | Edit::Reject(id)
            | Edit::Undecide(id)
            | Edit::Relabel(id, _)
            | Edit::Reshape(id, _)
            | Edit::SwapSide(id)
            | Edit::Remove(id)
            | Edit::Note(id, _) => Some(*id),
        }
    }
}

impl Review {
    /// The review after an edit; `None` when it would change nothing: no such box or class, a box without extent, a decision
    /// that stands already.
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
                self.correct(*id, |one| one.mark = mark)
            }
            Edit::SwapSide(id) => self.correct(*id, |one| {
                one.mark.side = match one.mark.side {
                    Side::Port => Side::Starboard,
                    Side::Starboard => Side::Port,
                }
            }),
            Edit::Add { mark, class } => self.add(mark, *class),
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

    fn add(&self, mark: &Mark, class: usize) -> Option<Review> {
        let mark = held(mark, self.identity.pings)?;
        let class = (class < self.classes.len()).then_some(class)?;
        let mut after = self.clone();
        let id = after.take_id();
        after.boxes.push(Arc::new(Reviewed {
            id,
            mark,
            class,
            score: None,
            state: State::Added,
            edited: false,
            note: String::new(),
            model: None,
        }));
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

/// A box drawn by hand has no proposal to go back to or to agree with: it is added, or it is rejected.
fn affirmed(one: &Reviewed, state: State) -> State {
    if one.model.is_none() {
        State::Added
    } else {
        state
    }
}
