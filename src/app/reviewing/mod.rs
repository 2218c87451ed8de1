//! The boxes of the open survey: which one is selected, how they are lined up, which tool is in
//! hand.
//!
//! `autosave` keeps decisions as they are made, `classes` changes the list of classes, `decide`
//! carries out edits and moves on to the next box, `edges` moves single edges and marks points,
//! `detect` asks a model, `line` is the queue over all logs, `places` puts boxes on the ground,
//! `judging` compares them with the truth where it is known, `fly` enlarges a box in all views,
//! `files` keeps the review and writes what other programs read.

mod autosave;
mod classes;
mod decide;
mod detect;
mod edges;
mod files;
mod fly;
mod judging;
mod line;
mod places;

pub use bathyscope_objects::review::PIXEL_M;
pub use decide::Nudge;
pub use detect::SearchStatus;
pub use edges::{BoxEdge, border_m};
pub(crate) use judging::Judging;
pub use judging::MistakeSort;
pub use places::LocatedObject;

pub(super) use detect::ObjectSearch;
pub(super) use places::Entries;

use super::LogPlace;
use autosave::Autosave;
use bathyscope_log::survey::{Identity, Navigation, Survey};
use bathyscope_objects::NAMELESS_CLASS;
use bathyscope_objects::review::{BoxId, DecisionCounts, Queue, Review, Reviewed};
use bathyscope_objects::{Mark, Raster};
use files::ReviewOpening;
use places::BoxPlaces;
use std::path::PathBuf;
use std::sync::Arc;

/// Effect of a drag in the waterfall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Moves the picture.
    #[default]
    Look,
    /// Moves the selected box, or its edges.
    Edit,
    /// Draws a new box.
    Draw,
    /// Marks a point at a click.
    Point,
    /// Draws the bottom.
    Bottom,
    /// Excludes stretches; on the map too.
    Exclude,
    /// Proposes a stretch for the scale; on the map too.
    Calibrate,
    /// Accepts first returns above the recorded depth as bottom.
    Accept,
}

/// A review of another log, for when that is opened again.
pub(super) struct Parked {
    review: Arc<Review>,
    saved: Arc<Review>,
    path: Option<PathBuf>,
    /// The decisions are in the file of unsaved ones.
    is_kept: bool,
}

/// The boxes and what is done with them.
pub struct Reviewing {
    /// The boxes and the decisions.
    pub review: Arc<Review>,
    /// The box that keys act on.
    pub selected: Option<BoxId>,
    /// Order, filter and confidence threshold; the same for all open logs.
    pub queue: Queue,
    /// Effect of a drag.
    pub tool: Tool,
    /// The edge of the selected box that the arrow keys move while it is edited.
    pub edge: BoxEdge,
    /// The file that the review is kept in, once it has one.
    pub path: Option<PathBuf>,
    line: Vec<BoxId>,
    /// The boxes in line by their first ping, and the most pings that one covers.
    along: Vec<Arc<Reviewed>>,
    longest: usize,
    counts: DecisionCounts,
    /// Some box was decided or corrected.
    is_touched: bool,
    /// The project keeps what is decided.
    is_in_project: bool,
    /// Class of the next box that is drawn: that of the last one that was named.
    class: usize,
    raster: Option<(Arc<Navigation>, Arc<Raster>)>,
    /// The version in the file, or the empty one.
    saved: Arc<Review>,
    opening: Option<ReviewOpening>,
    /// A sidecar file that cannot be used: it may be somebody's work.
    refused: Option<PathBuf>,
    autosave: Autosave,
    places: BoxPlaces,
    /// Comparison of the boxes with the truth.
    pub judging: Judging,
}

impl Default for Reviewing {
    fn default() -> Self {
        let review = Arc::new(empty(&Survey::default()));
        Self {
            saved: review.clone(),
            review,
            selected: None,
            queue: Queue::default(),
            tool: Tool::default(),
            edge: BoxEdge::default(),
            path: None,
            line: Vec::new(),
            along: Vec::new(),
            longest: 0,
            counts: DecisionCounts::default(),
            is_touched: false,
            is_in_project: false,
            class: 0,
            raster: None,
            opening: None,
            refused: None,
            autosave: Autosave::default(),
            places: BoxPlaces::default(),
            judging: Judging::default(),
        }
    }
}

fn empty(survey: &Survey) -> Review {
    Review::new(Identity::of(survey), vec![NAMELESS_CLASS.to_owned()])
}

impl Reviewing {
    /// Returns true if there is anything to review.
    pub fn has_boxes(&self) -> bool {
        self.review.boxes().len() > 0
    }

    /// Returns true if a tool or a box is selected.
    pub(crate) fn is_in_use(&self) -> bool {
        self.tool != Tool::Look || self.selected.is_some()
    }

    /// The selected box.
    pub fn selected_box(&self) -> Option<&Reviewed> {
        self.review.get(self.selected?)
    }

    /// The boxes to look at, in order.
    pub fn line(&self) -> &[BoxId] {
        &self.line
    }

    /// The boxes in line, along the track.
    pub fn in_line(&self) -> impl Iterator<Item = &Reviewed> {
        self.along.iter().map(AsRef::as_ref)
    }

    /// The boxes in line that have pings in a range. Costs what it finds.
    pub fn between(&self, pings: std::ops::Range<usize>) -> impl Iterator<Item = &Reviewed> {
        let from =
            self.along.partition_point(|one| one.mark.pings.start + self.longest <= pings.start);
        self.along[from..]
            .iter()
            .map(AsRef::as_ref)
            .take_while(move |one| one.mark.pings.start < pings.end)
            .filter(move |one| one.mark.pings.end > pings.start)
    }

    /// Returns the numbers of boxes by decision.
    pub fn counts(&self) -> DecisionCounts {
        self.counts
    }

    /// Class that the next box drawn gets.
    pub fn class(&self) -> usize {
        self.class.min(self.review.classes().len().saturating_sub(1))
    }

    /// The survey's raster; `None` until it is known where the pings lie.
    pub fn raster(&self) -> Option<&Arc<Raster>> {
        self.raster.as_ref().map(|(_, raster)| raster)
    }

    /// Returns true if decisions are in no file yet. Proposals alone are no loss: the model makes
    /// them again.
    pub fn is_unsaved(&self) -> bool {
        !self.is_in_project
            && !Arc::ptr_eq(&self.review, &self.saved)
            && (self.is_touched || is_touched(&self.saved))
    }

    /// Returns true if a review is being read, or boxes are being placed or compared.
    pub(super) fn is_busy(&self) -> bool {
        self.opening.is_some()
            || self.autosave.is_looking()
            || self.places.is_busy()
            || self.judging.is_busy()
    }

    /// Extent of a mark along the track and in slant range, metres; the first is NaN until the
    /// raster is known.
    pub fn size_m(&self, mark: &Mark) -> [f64; 2] {
        size_m(self.raster().map(AsRef::as_ref), mark)
    }

    /// Returns a copy that holds only what is drawn: the boxes in line, with nothing to save.
    pub(super) fn for_picture(&self) -> Self {
        let mut copy = Self {
            saved: self.review.clone(),
            queue: self.queue.clone(),
            raster: self.raster.clone(),
            ..Self::default()
        };
        copy.set(self.review.clone());
        copy
    }

    /// Takes another version of the boxes.
    fn set(&mut self, review: Arc<Review>) {
        self.review = review;
        self.places.outdate();
        self.judging.outdate();
        self.is_touched = is_touched(&self.review);
        if self.selected_box().is_none() {
            self.selected = None;
        }
        self.sort_and_filter();
    }

    /// Lines the boxes up anew.
    fn sort_and_filter(&mut self) {
        let raster = self.raster().cloned();
        let longer_m = |mark: &Mark| {
            let [along_m, across_m] = size_m(raster.as_deref(), mark);
            along_m.max(across_m)
        };
        self.line = self.queue.sort_and_filter(&self.review, longer_m);
        let in_line = self.review.shared().iter();
        let in_line = in_line.filter(|one| self.queue.takes(&self.review, one, longer_m));
        self.along = in_line.cloned().collect();
        self.along.sort_by_key(|one| one.mark.pings.start);
        let lengths = self.along.iter().map(|one| one.mark.pings.len());
        self.longest = lengths.max().unwrap_or(0);
        self.counts = DecisionCounts::of(&self.review, &self.queue);
    }

    /// Lays the raster out where pings lie elsewhere than before.
    pub(super) fn follow(&mut self, survey: &Survey, navigation: &Arc<Navigation>) {
        self.places.outdate();
        let is_known = |(known, _): &(Arc<Navigation>, _)| Arc::ptr_eq(known, navigation);
        if !self.raster.as_ref().is_some_and(is_known) {
            let raster = Raster::new(survey, navigation, PIXEL_M);
            self.raster = Some((navigation.clone(), Arc::new(raster)));
            self.judging.outdate();
            self.sort_and_filter();
        }
    }

    /// Lays the raster out for a log that has grown; boxes keep their places until results of the
    /// whole log are there.
    pub(super) fn grow(&mut self, survey: &Survey, navigation: &Arc<Navigation>) {
        let raster = Raster::new(survey, navigation, PIXEL_M);
        self.raster = Some((navigation.clone(), Arc::new(raster)));
    }

    /// Carries the boxes over to a longer state of their log. What is in a file stays what is in
    /// it.
    pub(super) fn carry(&mut self, identity: Identity) {
        if *self.review.identity() == identity {
            return;
        }
        let carried = Arc::new(self.review.carried_to(identity));
        if Arc::ptr_eq(&self.saved, &self.review) {
            self.saved = carried.clone();
        }
        self.autosave.carry(&self.review, &carried);
        self.review = carried;
    }

    /// Starts on a survey; what was decided about it before it was closed comes back.
    pub(super) fn start(&mut self, survey: &Survey, parked: &mut Vec<Parked>) {
        let identity = Identity::of(survey);
        let is_same = |parked: &Parked| {
            let of = parked.review.identity();
            of.file == identity.file && of.is_same_log(&identity)
        };
        if let Some(index) = parked.iter().rposition(is_same) {
            let parked = parked.remove(index);
            self.saved = parked.saved;
            self.path = parked.path;
            self.set(parked.review);
            self.exchange(identity.swapped_sides);
        } else {
            self.saved = Arc::new(empty(survey));
            self.set(self.saved.clone());
        }
    }

    /// Has the boxes lie on the echoes that they were drawn on when the sides of the log are
    /// exchanged, or no longer. What was saved stays saved: a review says which sides it means.
    pub(super) fn exchange(&mut self, swapped_sides: bool) {
        if self.review.identity().swapped_sides == swapped_sides {
            return;
        }
        let exchanged = Arc::new(Review::clone(&self.review).with_sides(swapped_sides));
        if Arc::ptr_eq(&self.review, &self.saved) {
            self.saved = exchanged.clone();
        }
        self.set(exchanged);
    }

    /// Takes up the boxes that a project has of the log.
    pub(super) fn take_kept(&mut self, review: Arc<Review>) {
        self.saved = review.clone();
        self.set(review);
    }

    /// Leaves it to the project to keep what is decided: no file next to the log is read or written
    /// any more.
    pub(super) fn keep_elsewhere(&mut self) {
        self.is_in_project = true;
        // What this run wrote there for safety would be offered when the log is opened next.
        self.autosave.clear();
        self.autosave = Autosave::default();
    }

    /// Returns the part of the review that is kept when the log is closed; `None` without boxes,
    /// and where a project keeps them.
    pub(super) fn park(&mut self) -> Option<Parked> {
        (self.has_boxes() && !self.is_in_project).then(|| Parked {
            is_kept: self.autosave.holds(&self.review),
            review: self.review.clone(),
            saved: self.saved.clone(),
            path: self.path.clone(),
        })
    }

    /// Takes over what an analyst goes on working with when another log is shown: order and filter
    /// of the boxes.
    pub(super) fn take_tools(&mut self, before: &mut Self) {
        before.tool = Tool::Look;
        before.selected = None;
        self.tool = Tool::Look;
        self.queue = before.queue.clone();
        self.judging.sort_as(&before.judging);
        self.sort_and_filter();
        self.count_mistakes();
    }
}

fn is_touched(review: &Review) -> bool {
    review.boxes().any(Reviewed::is_kept)
}

fn size_m(raster: Option<&Raster>, mark: &Mark) -> [f64; 2] {
    let along_m = raster.map_or(f64::NAN, |raster| {
        let rect = raster.rect_of(mark);
        f64::from(rect.y1 - rect.y0) * raster.pixel_m()
    });
    [along_m, mark.far_m - mark.near_m]
}

/// The middle of a box as a place in the survey.
pub(super) fn middle(survey: &Survey, mark: &Mark) -> LogPlace {
    let ping = usize::midpoint(mark.pings.start, mark.pings.end.saturating_sub(1));
    let span = survey.span(ping, mark.side);
    let sample = span
        .map(|span| (span, span.sample_at(0.5 * (mark.near_m + mark.far_m))))
        .filter(|(span, sample)| (0.0..f64::from(span.count)).contains(sample))
        .map(|(_, sample)| sample as f32);
    LogPlace { ping, side: sample.map(|_| mark.side), sample, point: None }
}
