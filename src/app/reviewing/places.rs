//! Locates the objects of boxes on the Earth in a background thread: for a box again when it was
//! moved, and for all boxes when the track, the first returns or the scale changed.

use super::Reviewing;
use crate::app::jobs::JobKey;
use crate::app::{App, LogId};
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::review::{BoxId, Reviewed};
use bathyscope_objects::targets::{Target, TopShape};
use bathyscope_objects::{Mark, MeasuredShadow, ObjectExtent};
use bathyscope_products::pipeline::{ObjectLocator, Products};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

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
pub(in crate::app) type LocatedBox = (BoxExtent, Option<Arc<LocatedObject>>);

/// The positions of a log's boxes; a change of any of them makes another allocation.
pub(in crate::app) type Entries = Arc<HashMap<BoxId, LocatedBox>>;

/// State of the positions of a log's boxes.
#[derive(Default)]
pub(super) struct BoxPlaces {
    known: Entries,
    ground: Option<PlaceInputs>,
    /// True if boxes or ground have changed since the last check for missing positions.
    pub(super) outdated: bool,
}

impl Reviewing {
    /// Returns the object of a box on the ground; `None` until it is located, or if it cannot be.
    pub fn placed(&self, id: BoxId) -> Option<&Arc<LocatedObject>> {
        self.places.known.get(&id)?.1.as_ref()
    }

    /// Returns the positions of the boxes.
    pub(in crate::app) fn entries(&self) -> &Entries {
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
    pub(in crate::app) fn locate_boxes(&mut self, id: LogId) {
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
