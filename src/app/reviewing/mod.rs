//! Holds the boxes of a log with their decisions, selection, order and tool, and locates their
//! objects on the Earth in a background thread: for a box again when it was moved, and for all
//! boxes when the track, the first returns or the scale changed.
//!
//! `decide` applies edits, renames classes and goes through undo steps, `edges` moves single edges
//! and marks points, `detect` searches with a detector, `line` is the queue over all logs and
//! enlarges a box in all views, `judging` compares boxes with the truth if it is known, `files`
//! reads and writes the review and exports boxes.

mod decide;
mod detect;
mod edges;
mod files;
mod judging;
mod line;

pub use bathyscope_objects::review::PIXEL_M;
pub use decide::Nudge;
pub use detect::SearchStatus;
pub use edges::{BoxEdge, border_m};
pub(crate) use judging::Judging;
pub use judging::MistakeSort;

pub(super) use detect::ObjectSearch;
pub(super) use files::SUFFIX as REVIEW_SUFFIX;

use super::jobs::JobKey;
use super::{App, LogId, LogPlace};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Identity, Navigation, Survey};
use bathyscope_objects::review::{BoxId, DecisionCounts, Queue, Review, Reviewed};
use bathyscope_objects::targets::{Target, TopShape};
use bathyscope_objects::{Mark, MeasuredShadow, NAMELESS_CLASS, ObjectExtent, Raster};
use bathyscope_products::pipeline::{ObjectLocator, Products};
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Selected tool, which determines the effect of a drag in the waterfall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Moves the picture.
    #[default]
    Look,
    /// Moves the selected box, or its edges.
    Edit,
    /// Draws a new box.
    Draw,
    /// Marks a point by a click.
    Point,
    /// Draws the bottom.
    Bottom,
    /// Excludes stretches; also acts on the map.
    Exclude,
    /// Proposes a stretch for the scale; also acts on the map.
    Calibrate,
    /// Accepts first returns above the recorded depth as bottom.
    Accept,
}

/// The boxes of a log, and the state of their review.
#[derive(Default)]
pub struct Reviewing {
    /// The boxes with the decisions about them.
    pub review: Arc<Review>,
    /// The selected box, on which keys act; `None` if none is selected.
    pub selected: Option<BoxId>,
    /// Order, filter and confidence threshold; the same for all open logs.
    pub queue: Queue,
    /// Selected tool.
    pub tool: Tool,
    /// The edge of the selected box that the arrow keys move while it is edited.
    pub edge: BoxEdge,
    /// The file of the review; `None` until it has one.
    pub path: Option<PathBuf>,
    line: Vec<BoxId>,
    /// The boxes of the queue by their first ping, and the greatest number of pings of a box.
    along: Vec<Arc<Reviewed>>,
    longest: usize,
    counts: DecisionCounts,
    /// True if a box was decided or corrected.
    is_touched: bool,
    /// Class of the next box that is drawn, which is the class that was given last.
    class: usize,
    raster: Option<(Arc<Navigation>, Arc<Raster>)>,
    /// The version in the file of the review; `None` if it has no file.
    saved: Option<Arc<Review>>,
    /// A sidecar file that cannot be used, and is not overwritten, because it may be somebody's
    /// work.
    refused: Option<PathBuf>,
    places: BoxPlaces,
    /// Comparison of the boxes with the truth.
    pub judging: Judging,
}

/// A box's object on the ground.
#[derive(Clone, Debug)]
pub struct LocatedObject {
    /// Position, extent, height and depth.
    pub target: Target,
    /// Corners of its footprint, metres east and north, with the length along the track and the
    /// width across it; all four are the position for a point.
    pub corners: [[f64; 2]; 4],
}

/// Results from which positions are computed.
#[derive(Clone)]
struct PlaceInputs(Products);

impl PlaceInputs {
    fn is_same(&self, other: &Self) -> bool {
        let (one, other) = (&self.0, &other.0);
        Arc::ptr_eq(&one.navigation, &other.navigation)
            && Arc::ptr_eq(&one.returns, &other.returns)
            && Arc::ptr_eq(&one.calibration, &other.calibration)
            && Arc::ptr_eq(&one.relief, &other.relief)
            && (Arc::ptr_eq(&one.correction, &other.correction)
                || one.correction == other.correction)
    }
}

/// The properties of a box that its position and its height depend on.
type BoxExtent = (Mark, ObjectExtent, Option<MeasuredShadow>, TopShape);

/// The properties of a box, and its located object, `None` if it has no position.
type LocatedBox = (BoxExtent, Option<Arc<LocatedObject>>);

/// The positions of a log's boxes; a change of any of them makes another allocation.
pub(super) type Entries = Arc<HashMap<BoxId, LocatedBox>>;

/// State of the positions of a log's boxes.
#[derive(Default)]
struct BoxPlaces {
    known: Entries,
    ground: Option<PlaceInputs>,
    /// True if boxes or ground have changed since the last check for missing positions.
    outdated: bool,
}

impl Reviewing {
    /// Returns true if there are boxes to review.
    pub fn has_boxes(&self) -> bool {
        self.review.boxes().len() > 0
    }

    /// Returns true if a tool or a box is selected.
    pub(crate) fn is_in_use(&self) -> bool {
        self.tool != Tool::Look || self.selected.is_some()
    }

    /// Returns the selected box; `None` if none is selected.
    pub fn selected_box(&self) -> Option<&Reviewed> {
        self.review.get(self.selected?)
    }

    /// Returns the boxes of the queue, in its order.
    pub fn line(&self) -> &[BoxId] {
        &self.line
    }

    /// Returns the boxes of the queue, along the track.
    pub fn in_line(&self) -> impl Iterator<Item = &Reviewed> {
        self.along.iter().map(AsRef::as_ref)
    }

    /// Returns the boxes of the queue that have pings in a range, in a time that grows with their
    /// number only.
    pub fn between(&self, pings: std::ops::Range<usize>) -> impl Iterator<Item = &Reviewed> {
        let from = self.along.partition_point(|review_box| {
            review_box.mark.pings.start + self.longest <= pings.start
        });
        self.along[from..]
            .iter()
            .map(AsRef::as_ref)
            .take_while(move |review_box| review_box.mark.pings.start < pings.end)
            .filter(move |review_box| review_box.mark.pings.end > pings.start)
    }

    /// Returns the numbers of boxes by decision.
    pub fn counts(&self) -> DecisionCounts {
        self.counts
    }

    /// Returns the class of the next box that is drawn.
    pub fn class(&self) -> usize {
        self.class.min(self.review.classes().len().saturating_sub(1))
    }

    /// Returns the raster of the log; `None` until the positions of the pings are known.
    pub fn raster(&self) -> Option<&Arc<Raster>> {
        self.raster.as_ref().map(|(_, raster)| raster)
    }

    /// Returns true if decisions are not in the file of the review. Boxes that are only proposed
    /// do not count: the model finds them again.
    pub fn is_unsaved(&self) -> bool {
        let saved = self.saved.as_ref();
        self.is_touched && !saved.is_some_and(|saved| Arc::ptr_eq(saved, &self.review))
    }

    /// Returns the extent of a mark along the track and in slant range, metres; the first is NaN
    /// until the raster is known.
    pub fn size_m(&self, mark: &Mark) -> [f64; 2] {
        size_m(self.raster().map(AsRef::as_ref), mark)
    }

    /// Returns a copy that holds only the drawn parts: the boxes of the queue.
    pub(super) fn for_picture(&self) -> Self {
        let mut copy =
            Self { queue: self.queue.clone(), raster: self.raster.clone(), ..Self::default() };
        copy.set(self.review.clone());
        copy
    }

    /// Replaces the boxes by another version.
    pub(super) fn set(&mut self, review: Arc<Review>) {
        self.review = review;
        self.places.outdated = true;
        self.judging.outdated = true;
        self.is_touched = self.review.boxes().any(Reviewed::is_kept);
        if self.selected_box().is_none() {
            self.selected = None;
        }
        self.sort_and_filter();
    }

    /// Sorts and filters the boxes again.
    fn sort_and_filter(&mut self) {
        let raster = self.raster().cloned();
        let longer_m = |mark: &Mark| {
            let [along_m, across_m] = size_m(raster.as_deref(), mark);
            along_m.max(across_m)
        };
        self.line = self.queue.sort_and_filter(&self.review, longer_m);
        let in_line = self.review.shared().iter();
        let in_line =
            in_line.filter(|review_box| self.queue.takes(&self.review, review_box, longer_m));
        self.along = in_line.cloned().collect();
        self.along.sort_by_key(|review_box| review_box.mark.pings.start);
        let lengths = self.along.iter().map(|review_box| review_box.mark.pings.len());
        self.longest = lengths.max().unwrap_or(0);
        self.counts = DecisionCounts::of(&self.review, &self.queue);
    }

    /// Makes the raster again if the positions of the pings have changed.
    pub(super) fn follow(&mut self, survey: &Survey, navigation: &Arc<Navigation>) {
        self.places.outdated = true;
        let is_known = |(known, _): &(Arc<Navigation>, _)| Arc::ptr_eq(known, navigation);
        if !self.raster.as_ref().is_some_and(is_known) {
            let raster = Raster::new(survey, navigation, PIXEL_M);
            self.raster = Some((navigation.clone(), Arc::new(raster)));
            self.judging.outdated = true;
            self.sort_and_filter();
        }
    }

    /// Makes the raster for a log that has grown; boxes keep their positions until there are
    /// results of the whole log.
    pub(super) fn grow(&mut self, survey: &Survey, navigation: &Arc<Navigation>) {
        let raster = Raster::new(survey, navigation, PIXEL_M);
        self.raster = Some((navigation.clone(), Arc::new(raster)));
    }

    /// Assigns the boxes to a longer state of their log.
    pub(super) fn carry(&mut self, identity: Identity) {
        if *self.review.identity() == identity {
            return;
        }
        self.review = Arc::new(self.review.carried_to(identity));
    }

    /// Starts the review of a log that was opened.
    pub(super) fn start(&mut self, survey: &Survey) {
        let classes = vec![NAMELESS_CLASS.to_owned()];
        self.set(Arc::new(Review::new(Identity::of(survey), classes)));
    }

    /// Moves the boxes with their echoes to the other side when the sides of the log are exchanged
    /// or restored.
    pub(super) fn exchange(&mut self, swapped_sides: bool) {
        if self.review.identity().swapped_sides == swapped_sides {
            return;
        }
        self.set(Arc::new(Review::clone(&self.review).with_sides(swapped_sides)));
    }

    /// Copies the order and filter of the boxes, and the order of the mistakes, from the log that
    /// was shown before; deselects the tools of both logs, and the box of that log.
    pub(super) fn take_tools(&mut self, before: &mut Self) {
        before.tool = Tool::Look;
        before.selected = None;
        self.tool = Tool::Look;
        self.queue = before.queue.clone();
        self.judging.sort = before.judging.sort;
        self.sort_and_filter();
        self.count_mistakes();
    }

    /// Returns the object of a box on the ground; `None` until it is located, or if it cannot be.
    pub fn placed(&self, id: BoxId) -> Option<&Arc<LocatedObject>> {
        self.places.known.get(&id)?.1.as_ref()
    }

    /// Returns the positions of the boxes.
    pub(super) fn entries(&self) -> &Entries {
        &self.places.known
    }

    /// Returns the boxes that have no position on a ground.
    fn not_located(&self, ground: &PlaceInputs) -> Vec<(BoxId, BoxExtent)> {
        let (places, review) = (&self.places, &self.review);
        let is_same = places.ground.as_ref().is_some_and(|known| known.is_same(ground));
        let top = |review_box: &Reviewed| TopShape::of_class(review.class_name(review_box.class));
        let is_known = |review_box: &Reviewed| {
            let known = places.known.get(&review_box.id);
            let is_as_placed = |(mark, extent, shadow, placed_top): &BoxExtent| {
                *mark == review_box.mark
                    && *extent == review_box.extent
                    && *shadow == review_box.shadow
                    && *placed_top == top(review_box)
            };
            is_same && known.is_some_and(|(known, _)| is_as_placed(known))
        };
        (review.boxes())
            .filter(|review_box| !is_known(review_box))
            .map(|review_box| {
                let Reviewed { id, mark, extent, shadow, .. } = review_box;
                (*id, (mark.clone(), *extent, *shadow, top(review_box)))
            })
            .collect()
    }
}

impl BoxPlaces {
    /// Sets positions that were computed on a ground.
    fn take(&mut self, ground: PlaceInputs, entries: Vec<(BoxId, LocatedBox)>) {
        // Positions on an earlier ground stay visible until the new ones are computed.
        let is_same = self.ground.as_ref().is_some_and(|known| known.is_same(&ground));
        let known = Arc::make_mut(&mut self.known);
        if !is_same {
            known.clear();
        }
        known.extend(entries);
        self.ground = Some(ground);
    }
}

impl App {
    /// Starts locating the boxes of a log that have no position on its present ground.
    pub(super) fn locate_boxes(&mut self, id: LogId) {
        if self.jobs.is_running(&JobKey::PlaceBoxes(id)) {
            return;
        }
        let Some(log) = self.logs.get_mut(id).filter(|log| log.reviewing.places.outdated) else {
            return;
        };
        let (Some(survey), Some(products)) = (log.survey.clone(), log.products.clone()) else {
            return;
        };
        log.reviewing.places.outdated = false;
        let ground = PlaceInputs(products);
        let missing = log.reviewing.not_located(&ground);
        if missing.is_empty() {
            return;
        }
        let from = ground.clone();
        let work = move |progress: &Progress| {
            let locator = ObjectLocator::new(&survey, &from.0);
            let entry = |(id, (mark, extent, shadow, top)): (BoxId, BoxExtent)| {
                let placed = locator.place_as(&mark, extent, shadow, top).map(|target| {
                    let corners = target.corners();
                    Arc::new(LocatedObject { target, corners })
                });
                (id, ((mark, extent, shadow, top), placed))
            };
            let requested = missing.into_par_iter();
            requested
                .filter_map(|unplaced| (!progress.is_cancelled()).then(|| entry(unplaced)))
                .collect()
        };
        self.jobs.run(JobKey::PlaceBoxes(id), work, move |app, entries| {
            if let Some(log) = app.logs.get_mut(id) {
                log.reviewing.places.take(ground, entries);
            }
        });
    }
}

fn size_m(raster: Option<&Raster>, mark: &Mark) -> [f64; 2] {
    let along_m = raster.map_or(f64::NAN, |raster| {
        let rect = raster.rect_of(mark);
        f64::from(rect.y1 - rect.y0) * raster.pixel_m
    });
    [along_m, mark.far_m - mark.near_m]
}

/// Returns the middle of a box as a place in the survey.
pub(super) fn middle(survey: &Survey, mark: &Mark) -> LogPlace {
    let ping = usize::midpoint(mark.pings.start, mark.pings.end.saturating_sub(1));
    let span = survey.span(ping, mark.side);
    let sample = span
        .map(|span| (span, span.sample_at(0.5 * (mark.near_m + mark.far_m))))
        .filter(|(span, sample)| (0.0..f64::from(span.count)).contains(sample))
        .map(|(_, sample)| sample as f32);
    LogPlace { ping, side: sample.map(|_| mark.side), sample, point: None }
}
