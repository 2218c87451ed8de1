//! Where the boxes' objects lie in the world: worked out off the window's thread, a box again when it was moved and all again
//! when the track, the first returns or the scale are others.

use super::Reviewing;
use crate::app::{App, Outcome, Task};
use crate::calibration::Calibration;
use crate::cloud::Correction;
use crate::detection::Mark;
use crate::detection::review::BoxId;
use crate::detection::targets::Target;
use crate::first_return::FirstReturns;
use crate::pipeline::{Placing, Products};
use crate::survey::Navigation;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// A box's object on the ground.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Place, extent, height and depth.
    pub target: Target,
    /// Corners of its footprint, metres east and north: length along the track, width across it.
    pub corners: [[f64; 2]; 4],
}

/// What places are worked out from.
#[derive(Clone)]
struct Ground {
    navigation: Arc<Navigation>,
    returns: Arc<FirstReturns>,
    calibration: Arc<Calibration>,
    correction: Arc<Correction>,
}

impl Ground {
    fn of(products: &Products) -> Self {
        Self {
            navigation: products.navigation.clone(),
            returns: products.returns.clone(),
            calibration: products.calibration.clone(),
            correction: products.correction.clone(),
        }
    }

    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.navigation, &other.navigation)
            && Arc::ptr_eq(&self.returns, &other.returns)
            && Arc::ptr_eq(&self.calibration, &other.calibration)
            && (Arc::ptr_eq(&self.correction, &other.correction)
                || self.correction == other.correction)
    }
}

/// A box as it was placed; `None` where it has no place.
pub(in crate::app) type Entry = (Mark, Option<Arc<Placed>>);

/// The places of a log's boxes; another allocation when one of them is another.
pub(in crate::app) type Entries = Arc<HashMap<BoxId, Entry>>;

struct Running {
    ground: Ground,
    task: Task<Vec<(BoxId, Entry)>>,
}

/// The places known.
#[derive(Default)]
pub(super) struct Places {
    known: Entries,
    ground: Option<Ground>,
    running: Option<Running>,
    /// Boxes or ground have changed since it was last looked whether all places are known.
    outdated: bool,
}

impl Reviewing {
    /// The object of a box on the ground; `None` while it is not known, or when it cannot be.
    pub fn placed(&self, id: BoxId) -> Option<&Arc<Placed>> {
        self.places.known.get(&id)?.1.as_ref()
    }

    /// The places of the boxes.
    pub(in crate::app) fn entries(&self) -> &Entries {
        &self.places.known
    }
}

impl Places {
    /// Notes that boxes were added or moved.
    pub fn outdate(&mut self) {
        self.outdated = true;
    }

    /// Whether places are being worked out.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }
}

impl App {
    /// Collects places, and asks for those that are missing.
    pub(in crate::app) fn poll_places(&mut self) {
        let places = &mut self.log.reviewing.places;
        match places.running.as_ref().map(|running| running.task.poll()) {
            Some(Outcome::Pending) => return,
            Some(Outcome::Done(entries)) => {
                if let Some(running) = places.running.take() {
                    // Those of another ground stay on screen until the new ones are there.
                    let is_same = places
                        .ground
                        .as_ref()
                        .is_some_and(|ground| ground.is_same(&running.ground));
                    let known = Arc::make_mut(&mut places.known);
                    if !is_same {
                        known.clear();
                    }
                    known.extend(entries);
                    places.ground = Some(running.ground);
                }
            }
            Some(Outcome::Failed) => places.running = None,
            None => {}
        }
        if places.outdated {
            self.place_boxes();
        }
    }

    fn place_boxes(&mut self) {
        let (Some(survey), Some(products)) = (&self.log.survey, &self.log.products) else {
            return;
        };
        let reviewing = &mut self.log.reviewing;
        reviewing.places.outdated = false;
        let ground = Ground::of(products);
        let places = &mut reviewing.places;
        let is_same = places
            .ground
            .as_ref()
            .is_some_and(|known| known.is_same(&ground));
        let is_known = |id: &BoxId, mark: &Mark| {
            is_same && places.known.get(id).is_some_and(|(known, _)| known == mark)
        };
        let missing: Vec<(BoxId, Mark)> = (reviewing.review.boxes())
            .filter(|one| !is_known(&one.id, &one.mark))
            .map(|one| (one.id, one.mark.clone()))
            .collect();
        if missing.is_empty() {
            return;
        }
        let (survey, from) = (survey.clone(), ground.clone());
        let task = Task::start(&self.jobs, move |progress| {
            let Ground {
                navigation,
                returns,
                calibration,
                correction,
            } = &from;
            let placing = Placing::new(&survey, navigation, returns, calibration, correction);
            let entry = |(id, mark): (BoxId, Mark)| {
                let placed = placing.place(&mark).map(|target| {
                    let corners = corners(navigation, &target);
                    Arc::new(Placed { target, corners })
                });
                (id, (mark, placed))
            };
            let requested = missing.into_par_iter();
            requested
                .filter_map(|one| (!progress.is_cancelled()).then(|| entry(one)))
                .collect()
        });
        places.running = Some(Running { ground, task });
    }
}

/// The footprint turned into the track's direction at the middle of the box.
fn corners(navigation: &Navigation, target: &Target) -> [[f64; 2]; 4] {
    let pings = &target.mark.pings;
    let middle = usize::midpoint(pings.start, pings.end);
    let heading_rad = navigation
        .pings
        .get(middle)
        .map_or(0.0, |ping| ping.heading_rad);
    let (sin, cos) = match heading_rad.is_finite() {
        true => heading_rad.sin_cos(),
        false => (0.0, 1.0),
    };
    let [along_m, across_m] = [0.5 * target.length_m, 0.5 * target.width_m];
    [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)].map(|(ahead, right)| {
        let (along_m, across_m) = (ahead * along_m, right * across_m);
        [
            target.east_m + along_m * sin + across_m * cos,
            target.north_m + along_m * cos - across_m * sin,
        ]
    })
}
