//! Holds the analyst's decisions about the boxes of a survey: plain state, changed by edits, and
//! kept in a file of its own.
//!
//! In: boxes that a model proposes, and edits. Out: boxes with decisions, the order in which to
//! review them, and the rows of a file.
//!
//! `edit` applies a decision, `adopt` adds a new model's detections to existing decisions, `queue`
//! orders the boxes for review, `file` reads and writes a review. A [`ReviewedTile`] is a picture
//! to train a detector on. The log itself is never changed.

mod adopt;
mod edit;
mod file;
mod queue;

pub use edit::Edit;
pub(crate) use file::LARGEST_FILE;
pub use file::{BoxRow, ReviewError, ReviewRows, SearchRow};
pub use queue::{DecisionCounts, Queue, Sort};

use super::class::is_name;
use super::dataset::{LEAST_PX, LEAST_SHARE, PictureBoxes};
use super::{Labelled, Mark, MeasuredShadow, NAMELESS_CLASS, ObjectExtent, Raster, Rect, TILE_PX};
use bathyscope_log::named;
use bathyscope_log::survey::{Identity, Side, Survey};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Side of a pixel of the raster in which boxes are compared and shown, metres.
pub const PIXEL_M: f64 = 0.04;
/// Side of the square around a point in which detections are ignored, metres.
const POINT_M: f32 = 2.0;

/// Number of a box, never used twice in a review.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct BoxId(pub u32);

/// State of the decision about a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// A model proposed the box, and there is no decision yet.
    Proposed,
    /// A model proposed the box, and it is right.
    Accepted,
    /// The box shows no object: a hard negative for training.
    Rejected,
    /// The model missed the object, and the box was drawn by hand.
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

/// Certainty of the analyst that there is an object, and of its class: a statement of the analyst,
/// in addition to the score of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Certainty {
    /// The box may show something else, or nothing.
    Unsure,
    /// The box is more likely right than not.
    Probable,
    /// The analyst has no doubt.
    Certain,
}

named! {
    /// All certainties, the least sure first.
    pub Certainty {
        Unsure: "unsure",
        Probable: "probable",
        Certain: "certain",
    }
}

impl State {
    /// Returns true if the state means that there is an object.
    pub fn is_object(self) -> bool {
        matches!(self, State::Accepted | State::Added)
    }
}

/// A box with the decision about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reviewed {
    /// Number of the box.
    pub id: BoxId,
    /// Box around the echo and its shadow.
    pub mark: Mark,
    /// Index into [`Review::classes`].
    pub class: usize,
    /// Score from the last model that found the box, 0 to 1; `None` if no model has.
    pub score: Option<f32>,
    /// State of the decision about the box.
    pub state: State,
    /// True if class, place, edges, name, certainty or note were changed by hand: the detections of
    /// a new model do not replace such a box.
    pub edited: bool,
    /// Remark from the analyst.
    pub note: String,
    /// Name from the analyst, in addition to the class; empty without a name.
    pub name: String,
    /// Certainty of the analyst; `None` if not stated.
    pub certainty: Option<Certainty>,
    /// Source of the extent of the object.
    pub extent: ObjectExtent,
    /// Measured shadow that determines the height; `None` if the shadow of the extent does.
    pub shadow: Option<MeasuredShadow>,
    /// Name of the model that proposed the box; `None` for a box drawn by hand.
    pub model: Option<Arc<str>>,
}

impl Reviewed {
    /// Creates a box that is drawn by hand, without further statements; a proposal differs from it
    /// in score, state and model.
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

    /// Moves the box. A shadow that was measured on a ping outside the new box is removed.
    fn set_mark(&mut self, mark: Mark) {
        self.shadow = self.shadow.filter(|shadow| shadow.fits(&mark));
        self.mark = mark;
    }

    /// Returns true if the analyst has changed or decided about the box; the detections of a new
    /// model do not replace it.
    pub fn is_kept(&self) -> bool {
        self.state != State::Proposed || self.edited
    }

    /// Returns true if the box is shown: it is kept, or its score is at least `threshold`, or it
    /// has no score.
    pub(crate) fn is_shown_from(&self, threshold: f32) -> bool {
        self.is_kept() || self.score.is_none_or(|score| score >= threshold)
    }
}

/// Pings that were searched on both sides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Searched {
    /// Name of the model that searched the pings last.
    pub model: Arc<str>,
    /// The pings, the end excluded.
    pub pings: Range<usize>,
}

/// All boxes of a log, with the decisions about them. Boxes are shared between the versions that
/// undo keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Review {
    identity: Identity,
    classes: Vec<String>,
    /// Boxes in the order of their numbers.
    boxes: Vec<Arc<Reviewed>>,
    next_id: u32,
    /// Searched pings along the track, without overlap.
    searched: Vec<Searched>,
}

impl Default for Review {
    /// Creates the empty review of no log.
    fn default() -> Self {
        Self::new(Identity::of(&Survey::default()), vec![NAMELESS_CLASS.to_owned()])
    }
}

impl Review {
    /// Creates an empty review with the classes that a box can have.
    pub fn new(identity: Identity, classes: Vec<String>) -> Self {
        Self { identity, classes, boxes: Vec::new(), next_id: 1, searched: Vec::new() }
    }

    /// Returns the review for another identity of the same log, which has grown or whose sides are
    /// exchanged: each box stays on its echo.
    #[must_use]
    pub fn carried_to(&self, identity: Identity) -> Self {
        let there = self.clone().with_sides(identity.swapped_sides);
        Self { identity, ..there }
    }

    /// Returns the identity of the log that the review belongs to.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// Returns the review for the log with port and starboard exchanged or not: each box stays on
    /// its echo.
    #[must_use]
    pub fn with_sides(mut self, swapped_sides: bool) -> Self {
        if self.identity.swapped_sides != swapped_sides {
            for review_box in &mut self.boxes {
                let review_box = Arc::make_mut(review_box);
                review_box.mark.side = review_box.mark.side.other();
            }
            self.identity.swapped_sides = swapped_sides;
        }
        self
    }

    /// Returns the names of the classes.
    pub fn classes(&self) -> &[String] {
        &self.classes
    }

    /// Returns the name of a class; empty if there is no class with this index.
    pub fn class_name(&self, class: usize) -> &str {
        self.classes.get(class).map_or("", String::as_str)
    }

    /// Returns the review with a class renamed for all its boxes; `None` if there is no such class,
    /// or the new name is invalid or equal to the old one. If another class already has the new
    /// name, the boxes get that class.
    pub fn with_class_renamed(&self, from: &str, to: &str) -> Option<Review> {
        let place = |name: &str| self.classes.iter().position(|class| class == name);
        let of = place(from).filter(|_| from != to && is_name(to))?;
        let mut after = self.clone();
        match place(to) {
            None => to.clone_into(&mut after.classes[of]),
            Some(known) => {
                for review_box in after.boxes.iter_mut().filter(|review_box| review_box.class == of)
                {
                    Arc::make_mut(review_box).class = known;
                }
            }
        }
        Some(after)
    }

    /// Returns the boxes in the order of their numbers.
    pub fn boxes(&self) -> impl ExactSizeIterator<Item = &Reviewed> {
        self.boxes.iter().map(AsRef::as_ref)
    }

    /// Returns the boxes as shared pointers, which other versions of the review hold too.
    pub fn shared(&self) -> &[Arc<Reviewed>] {
        &self.boxes
    }

    /// Returns a box by its number.
    pub fn get(&self, id: BoxId) -> Option<&Reviewed> {
        self.position(id).map(|index| self.boxes[index].as_ref())
    }

    /// Returns the number that the next box gets.
    pub fn next_id(&self) -> BoxId {
        BoxId(self.next_id)
    }

    fn position(&self, id: BoxId) -> Option<usize> {
        self.boxes.binary_search_by_key(&id, |review_box| review_box.id).ok()
    }

    fn take_id(&mut self) -> BoxId {
        let id = BoxId(self.next_id);
        self.next_id = self.next_id.saturating_add(1);
        id
    }

    /// Returns the searched pings, along the track; empty if they are not known: no search was
    /// made, or the review is from a program that did not record them.
    pub fn searched(&self) -> &[Searched] {
        &self.searched
    }

    /// Returns the pings that no search has covered, along the track; empty if the searched pings
    /// are not known.
    pub fn unsearched(&self) -> Vec<Range<usize>> {
        if self.searched.is_empty() {
            return Vec::new();
        }
        let starts = self.searched.iter().map(|search| search.pings.start);
        let ends = self.searched.iter().map(|search| search.pings.end);
        let from = std::iter::once(0).chain(ends);
        let to = starts.chain(std::iter::once(self.identity.pings));
        let between = from.zip(to).map(|(from, to)| from..to);
        between.filter(|gap| !gap.is_empty()).collect()
    }

    /// Returns the searched pings in words, such as `pings 0 to 811 of 3453`; `None` if all pings
    /// were searched, or the searched pings are not known.
    pub fn coverage(&self) -> Option<String> {
        if self.unsearched().is_empty() {
            return None;
        }
        let mut parts: Vec<Range<usize>> = Vec::new();
        for Searched { pings, .. } in &self.searched {
            match parts.last_mut() {
                Some(last) if last.end == pings.start => last.end = pings.end,
                _ => parts.push(pings.clone()),
            }
        }
        let parts = parts.iter();
        let parts: Vec<String> =
            parts.map(|part| format!("{} to {}", part.start, part.end - 1)).collect();
        Some(format!("pings {} of {}", parts.join(", "), self.identity.pings))
    }

    /// Returns true if a mark has pings that no search has covered; `unsearched` is the result of
    /// [`Review::unsearched`].
    pub(crate) fn reaches_into(unsearched: &[Range<usize>], mark: &Mark) -> bool {
        let meets = |gap: &Range<usize>| mark.pings.start < gap.end && gap.start < mark.pings.end;
        unsearched.iter().any(meets)
    }

    /// Records that a model has searched some pings, in place of any earlier search of them.
    fn note_search(&mut self, model: &Arc<str>, pings: Range<usize>) {
        let pings = pings.start..pings.end.min(self.identity.pings);
        if pings.is_empty() {
            return;
        }
        let mut noted: Vec<Searched> = Vec::with_capacity(self.searched.len() + 2);
        for earlier in self.searched.drain(..) {
            let Range { start, end } = earlier.pings;
            for left in [start..end.min(pings.start), start.max(pings.end)..end] {
                if !left.is_empty() {
                    noted.push(Searched { model: earlier.model.clone(), pings: left });
                }
            }
        }
        noted.push(Searched { model: model.clone(), pings });
        noted.sort_by_key(|search| search.pings.start);
        for search in noted {
            match self.searched.last_mut() {
                Some(last)
                    if last.model == search.model && last.pings.end == search.pings.start =>
                {
                    last.pings.end = search.pings.end;
                }
                _ => self.searched.push(search),
            }
        }
    }
}

/// Returns the mark limited to the pings of the survey and to positive slant ranges; `None` unless
/// at least one ping and a positive length in range are left.
fn held(mark: &Mark, pings: usize) -> Option<Mark> {
    let (start, end) = (mark.pings.start, mark.pings.end.min(pings));
    let (near_m, far_m) = (mark.near_m.max(0.0), mark.far_m);
    let is_sound = start < end && far_m.is_finite() && far_m > near_m;
    is_sound.then_some(Mark::new(mark.side, start..end, [near_m, far_m]))
}

/// A tile of the raster with the decisions about the boxes in it.
#[derive(Clone, Debug, PartialEq)]
pub struct ReviewedTile {
    /// Side of the survey.
    pub side: Side,
    /// Row of the raster at which the tile starts.
    pub row: usize,
    /// Column of the raster at which the tile starts.
    pub column: usize,
    /// Boxes in the tile. Accepted and added boxes are labels; if all boxes were rejected there are
    /// none, which makes a hard negative. Undecided boxes, points, and objects that the edge cuts
    /// off are ignored boxes.
    pub boxes: PictureBoxes,
    /// Number of rejected boxes in the tile.
    pub rejected: usize,
}

impl Review {
    /// Returns the class names to train with, and the index of each class of the review among them.
    /// The names are the analyst's list, then other classes that boxes have, with the class of
    /// unknown objects last. So the classes of the list have the same numbers in the data of all
    /// logs of a survey.
    pub fn training_classes(&self, list: &[String]) -> (Vec<String>, Vec<Option<usize>>) {
        let is_used = |class: usize| self.boxes().any(|review_box| review_box.class == class);
        let others = self.classes.iter().enumerate();
        let others = others.filter(|(class, name)| !list.contains(name) && is_used(*class));
        let (nameless, named): (Vec<_>, Vec<_>) =
            others.partition(|(_, name)| *name == NAMELESS_CLASS);
        let others = named.into_iter().chain(nameless).map(|(_, name)| name);
        let names: Vec<String> = list.iter().chain(others).cloned().collect();
        let place = |class: &String| names.iter().position(|name| name == class);
        let places = self.classes.iter().map(place).collect();
        (names, places)
    }

    /// Returns tiles that hold every decided box, as few as a walk along the track needs. Undecided
    /// boxes and points make no tile of their own.
    pub fn tiles(&self, raster: &Raster) -> Vec<ReviewedTile> {
        let mut tiles = Vec::new();
        for side in Side::BOTH {
            let mut boxes: Vec<(Rect, &Reviewed)> = self
                .boxes()
                .filter(|review_box| review_box.mark.side == side)
                .map(|review_box| (rect_of(raster, review_box), review_box))
                .collect();
            boxes.sort_by(|(a, _), (b, _)| a.y0.total_cmp(&b.y0));
            let first = tiles.len();
            for (rect, review_box) in &boxes {
                let is_held = |tile: &ReviewedTile| {
                    let inside = rect.intersection(&frame(tile));
                    inside.area() >= 0.999 * rect.area()
                };
                // Tiles follow the track, so only the last few can hold the box.
                let is_seen = tiles[first..].iter().rev().take(8).any(is_held);
                let is_picture =
                    review_box.state != State::Proposed && review_box.extent != ObjectExtent::Point;
                if is_picture && !is_seen {
                    tiles.push(around(rect, side, raster, &boxes));
                }
            }
        }
        tiles
    }
}

/// Returns a box in the pixels of the raster; for a point, the square that an object there may
/// cover.
fn rect_of(raster: &Raster, review_box: &Reviewed) -> Rect {
    let rect = raster.rect_of(&review_box.mark);
    if review_box.extent != ObjectExtent::Point {
        return rect;
    }
    let half = 0.5 * POINT_M / raster.pixel_m as f32;
    let [x, y] = [0.5 * (rect.x0 + rect.x1), 0.5 * (rect.y0 + rect.y1)];
    Rect::new([(x - half).max(0.0), (y - half).max(0.0)], [x + half, y + half])
}

fn frame(tile: &ReviewedTile) -> Rect {
    let (x0, y0) = (tile.column as f32, tile.row as f32);
    Rect::new([x0, y0], [x0 + TILE_PX as f32, y0 + TILE_PX as f32])
}

/// Creates a tile around the middle of a box, limited to the picture.
fn around(rect: &Rect, side: Side, raster: &Raster, boxes: &[(Rect, &Reviewed)]) -> ReviewedTile {
    let [row, column] = raster.start_about(rect);
    let mut tile = ReviewedTile { side, row, column, boxes: PictureBoxes::default(), rejected: 0 };
    let frame = frame(&tile);
    for (rect, review_box) in boxes {
        let inside = rect.intersection(&frame);
        if inside.area() <= 0.0 {
            continue;
        }
        let label =
            Labelled { class: review_box.class, rect: inside.shifted(-frame.x0, -frame.y0) };
        let large = (inside.x1 - inside.x0).min(inside.y1 - inside.y0) >= LEAST_PX;
        let whole_enough = large && inside.area() >= LEAST_SHARE * rect.area();
        // The size of a point is unknown.
        let is_plain = whole_enough && review_box.extent != ObjectExtent::Point;
        match review_box.state {
            State::Rejected => tile.rejected += 1,
            State::Accepted | State::Added if is_plain => tile.boxes.labels.push(label),
            State::Accepted | State::Added | State::Proposed => tile.boxes.ignored.push(label),
        }
    }
    tile
}

#[cfg(test)]
mod tests;
