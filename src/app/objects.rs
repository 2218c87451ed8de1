//! The objects of the survey: the boxes of all visible logs, those of one object together.
//!
//! They are put together off the window's thread, again when a box, a place, the confidence or the logs are others. An object keeps its
//! number while its boxes are decided, moved or hidden.

use super::reviewing::{Entries, Placed};
use super::{App, LogBox, LogId, ObjectSummary, ObjectTable, OpenLog};
use crate::detection::review::{Review, Reviewed, State};
use crate::detection::targets::{
    FittedShape, GroupSettings, PassCount, PassLog, ShapeError, Target,
};
use crate::pipeline::joint::{JointObject, PlacedBox, joint_objects, object_shape};
use crate::pipeline::{Background, ProcessedLog, Same};
use crate::support::geo::LonLat;
use crate::survey::{LeftOut, Navigation, Survey};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// An object with the boxes that show it.
#[derive(Clone, Debug)]
pub struct SurveyObject {
    /// Its number, never given to another object while the logs are open.
    pub number: u32,
    /// The boxes that show it, by log in the order of the list and by number.
    pub boxes: Vec<LogBox>,
    /// Where it lies.
    pub position: LonLat,
    /// Class, place in the plane of the survey, and height.
    pub joint: JointObject,
    /// Passes of the boat that saw it: at most as many as boxes, since both sides may see it in one pass, and two recorders too.
    pub sightings: usize,
    /// Name, state and size for a row of the table.
    pub summary: ObjectSummary,
}

impl SurveyObject {
    /// The logs that saw it, in the order of the list.
    pub fn logs(&self) -> Vec<LogId> {
        let mut logs: Vec<LogId> = self.boxes.iter().map(|one| one.log).collect();
        logs.dedup();
        logs
    }
}

/// How far the decisions about an object are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectState {
    /// So many of its boxes are undecided.
    Open(usize),
    /// There is an object: all its boxes were accepted or drawn by hand.
    Accepted,
    /// There is nothing: all its boxes were rejected.
    Rejected,
}

/// A log as objects are made of it.
#[derive(Clone)]
struct LogBoxes {
    id: LogId,
    survey: Arc<Survey>,
    navigation: Arc<Navigation>,
    left_out: Arc<LeftOut>,
    review: Arc<Review>,
    entries: Entries,
    /// Confidence from which proposals count.
    threshold: f32,
}

impl PartialEq for LogBoxes {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
            && self.threshold == other.threshold
            && Arc::ptr_eq(&self.review, &other.review)
            && Arc::ptr_eq(&self.entries, &other.entries)
            && Arc::ptr_eq(&self.left_out, &other.left_out)
    }
}

impl LogBoxes {
    /// The boxes in sight that are placed and not in a stretch that is left out.
    fn boxes(&self) -> impl Iterator<Item = &Reviewed> {
        let counts = |one: &&Reviewed| {
            one.is_shown_from(self.threshold) && !self.left_out.is_middle_out(&one.mark.pings)
        };
        self.review.boxes().filter(counts)
    }

    fn pass_log(&self) -> PassLog<'_> {
        (&self.survey, &self.navigation)
    }

    fn placed<'a>(&'a self, log: usize, one: &'a Reviewed) -> Option<PlacedBox<'a>> {
        // One that was moved since is placed again in a moment; until then it counts where it was.
        let (_, placed) = self.entries.get(&one.id)?;
        Some(PlacedBox {
            log,
            class: self.review.class_name(one.class),
            score: one.score,
            target: &placed.as_ref()?.target,
        })
    }
}

/// Objects with their numbers.
#[derive(Default)]
struct Grouped {
    objects: Arc<Vec<SurveyObject>>,
    /// The object of every box.
    of: HashMap<LogBox, usize>,
    numbers: Arc<Numbers>,
}

impl Grouped {
    fn new(logs: &[LogBoxes], before: &Numbers) -> Self {
        let all = logs.iter().enumerate();
        let all: Vec<(LogBox, &Reviewed, PlacedBox<'_>)> = all
            .flat_map(|(log, boxes)| {
                boxes.boxes().filter_map(move |one| {
                    let id = LogBox {
                        log: boxes.id,
                        id: one.id,
                    };
                    Some((id, one, boxes.placed(log, one)?))
                })
            })
            .collect();
        // What was rejected is nothing: it is no sighting of the object beside it.
        let mut found = Vec::new();
        for is_rejected in [false, true] {
            let part = all.iter();
            let part: Vec<_> = part
                .filter(|(_, one, _)| (one.state == State::Rejected) == is_rejected)
                .collect();
            let placed: Vec<PlacedBox<'_>> = part.iter().map(|(.., placed)| *placed).collect();
            let joined = joint_objects(&placed, &GroupSettings::default()).into_iter();
            found.extend(joined.map(|joint| {
                let members = joint.members.iter().map(|member| part[*member]);
                let boxes = members.clone().map(|(id, ..)| *id);
                let summary =
                    ObjectSummary::of(members.map(|(_, one, placed)| (*one, placed.target)));
                (boxes.collect::<Vec<LogBox>>(), joint, summary)
            }));
        }
        let pass_logs: Vec<PassLog<'_>> = logs.iter().map(LogBoxes::pass_log).collect();
        let mut numbers = before.clone();
        let numbered = numbers.give(found.iter().map(|(boxes, ..)| boxes.as_slice()));
        let mut objects: Vec<SurveyObject> = found
            .into_iter()
            .zip(numbered)
            .filter_map(|((boxes, joint, summary), number)| {
                let LogBoxes {
                    survey, navigation, ..
                } = logs.first()?;
                let [east_m, north_m] = joint.place_m;
                Some(SurveyObject {
                    number,
                    boxes,
                    position: navigation.to_lon_lat(&survey.track, east_m, north_m),
                    sightings: joint.sightings(&pass_logs),
                    joint,
                    summary,
                })
            })
            .collect();
        objects.sort_by_key(|object| object.number);
        let each = objects.iter().enumerate();
        let of = each.flat_map(|(index, object)| object.boxes.iter().map(move |id| (*id, index)));
        Self {
            of: of.collect(),
            numbers: Arc::new(numbers),
            objects: Arc::new(objects),
        }
    }
}

/// The number that every box had last, also while it is out of sight.
#[derive(Clone, Debug, Default)]
struct Numbers {
    of: HashMap<LogBox, u32>,
    last: u32,
}

impl Numbers {
    /// A number for each group of boxes: the one that most of its boxes had, where no other group has more of those; else a new one.
    fn give<'a>(&mut self, groups: impl Iterator<Item = &'a [LogBox]>) -> Vec<u32> {
        let groups: Vec<&[LogBox]> = groups.collect();
        let mut claims: Vec<(usize, u32, usize)> = Vec::new();
        for (index, group) in groups.iter().enumerate() {
            let mut votes: HashMap<u32, usize> = HashMap::new();
            for number in group.iter().filter_map(|id| self.of.get(id)) {
                *votes.entry(*number).or_default() += 1;
            }
            claims.extend(
                votes
                    .into_iter()
                    .map(|(number, votes)| (votes, number, index)),
            );
        }
        claims.sort_by_key(|(votes, number, index)| (std::cmp::Reverse(*votes), *number, *index));
        let mut given: Vec<Option<u32>> = vec![None; groups.len()];
        let mut taken = HashSet::new();
        for (_, number, index) in claims {
            if given[index].is_none() && taken.insert(number) {
                given[index] = Some(number);
            }
        }
        let numbers: Vec<u32> = given
            .into_iter()
            .map(|number| {
                number.unwrap_or_else(|| {
                    self.last += 1;
                    self.last
                })
            })
            .collect();
        for (group, number) in groups.iter().zip(&numbers) {
            self.of.extend(group.iter().map(|id| (*id, *number)));
        }
        numbers
    }
}

/// The object whose passes are counted, and the logs that they are of.
#[derive(Clone, PartialEq)]
struct PassesOf {
    number: u32,
    boxes: Vec<LogBox>,
    place_m: [f64; 2],
    logs: Vec<(LogId, Same<Navigation>)>,
}

/// Boxes of an object in their places: what its shape is fitted to.
type ShapeOf = Vec<(LogBox, Same<Placed>)>;
/// Its shape, and the boxes that it is of.
type ShapeFound = (Vec<LogBox>, Result<FittedShape, ShapeError>);

/// The objects, and the work on them.
#[derive(Default)]
pub(super) struct Objects {
    grouping: Background<Vec<LogBoxes>, Grouped>,
    passes: Background<PassesOf, (u32, PassCount)>,
    shape: Background<ShapeOf, ShapeFound>,
    listing: Background<(Same<Vec<SurveyObject>>, ObjectTable), Vec<u32>>,
}

impl Objects {
    /// Whether objects are being put together.
    pub fn is_busy(&self) -> bool {
        self.grouping.is_running()
            || self.passes.is_running()
            || self.shape.is_running()
            || self.listing.is_running()
    }
}

impl App {
    /// The objects that the boxes of all visible logs show, by number.
    pub fn objects(&self) -> &[SurveyObject] {
        let grouped = self.objects.grouping.result();
        grouped.map_or(&[], |grouped| &grouped.objects)
    }

    /// Numbers of the objects that the table shows, in its order.
    pub fn listed_objects(&self) -> &[u32] {
        self.objects.listing.result().map_or(&[], Vec::as_slice)
    }

    /// An object by its number.
    pub fn object(&self, number: u32) -> Option<&SurveyObject> {
        let objects = self.objects();
        let index = objects.binary_search_by_key(&number, |object| object.number);
        objects.get(index.ok()?)
    }

    /// The object that a box shows; `None` where it has no place, and of logs that are not visible.
    pub fn object_of(&self, id: LogBox) -> Option<&SurveyObject> {
        let grouped = self.objects.grouping.result()?;
        grouped.objects.get(*grouped.of.get(&id)?)
    }

    /// The box that shows an object first: one of the log that is shown, and of several the surest.
    pub fn best_box(&self, object: &SurveyObject) -> Option<LogBox> {
        let rank = |id: &LogBox| {
            let score = self.log_box(*id).and_then(|one| one.score);
            (id.log == self.log.id, score.unwrap_or(1.0))
        };
        let best = object.boxes.iter().max_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        best.copied()
    }

    /// The object of the selected box.
    pub fn selected_object(&self) -> Option<&SurveyObject> {
        self.object_of(self.selected_log_box()?)
    }

    /// The shape of the selected object, or why it has none, once it is fitted.
    pub fn selected_object_shape(&self) -> Option<&Result<FittedShape, ShapeError>> {
        let (boxes, shape) = self.objects.shape.result()?;
        let object = self.selected_object()?;
        (*boxes == object.boxes).then_some(shape)
    }

    /// How many passes of the boat over all visible logs saw the selected object, and how many covered its place, once they are counted.
    pub fn selected_object_passes(&self) -> Option<PassCount> {
        let (number, passes) = self.objects.passes.result()?;
        let object = self.selected_object()?;
        // Those of a moment ago are of other boxes.
        (*number == object.number && passes.seen == object.sightings).then_some(*passes)
    }

    /// Has the objects put together again where what they are made of has changed.
    pub(super) fn poll_objects(&mut self) {
        let boxes = |log: &OpenLog| {
            let products = log.products.as_ref()?;
            Some(LogBoxes {
                id: log.id,
                survey: log.survey.clone()?,
                navigation: products.navigation.clone(),
                left_out: products.left_out.clone(),
                review: log.reviewing.review.clone(),
                entries: log.reviewing.entries().clone(),
                threshold: log.reviewing.queue.threshold,
            })
        };
        let logs: Vec<LogBoxes> = self.visible_logs().filter_map(boxes).collect();
        let Objects { grouping, .. } = &mut self.objects;
        let before = grouping.result();
        let before = before.map_or_else(Arc::default, |grouped| grouped.numbers.clone());
        let of = logs.clone();
        grouping.ask(logs.clone(), &self.jobs, move |_| {
            Some(Grouped::new(&of, &before))
        });
        self.list_objects();
        self.count_passes(logs);
        self.fit_shape();
    }

    /// Sorts and filters the table where the objects, the order or the filter are others.
    fn list_objects(&mut self) {
        let Objects {
            grouping, listing, ..
        } = &mut self.objects;
        let Some(grouped) = grouping.result() else {
            return;
        };
        let (objects, table) = (grouped.objects.clone(), self.options.objects.clone());
        let key = (Same(objects.clone()), table.clone());
        listing.ask(key, &self.jobs, move |_| Some(table.list(&objects)));
    }

    /// Fits a shape to the selected object where its boxes, or their places, are others.
    fn fit_shape(&mut self) {
        let boxes = self.selected_object().map(|object| object.boxes.clone());
        let placed = boxes.into_iter().flatten().filter_map(|id| {
            let log = self.open_log(id.log)?;
            let processed = ProcessedLog {
                survey: log.survey.clone()?,
                products: log.products.clone()?,
            };
            Some((id, processed, log.reviewing.placed(id.id)?.clone()))
        });
        let placed: Vec<(LogBox, ProcessedLog, Arc<Placed>)> = placed.collect();
        if placed.is_empty() {
            // Nobody would collect it, and the window would never rest.
            if self.objects.shape.is_running() {
                self.objects.shape = Background::default();
            }
            return;
        }
        let of = placed.iter().map(|(id, _, at)| (*id, Same(at.clone())));
        self.objects.shape.ask(of.collect(), &self.jobs, move |_| {
            let boxes: Vec<(&ProcessedLog, &Target)> = (placed.iter())
                .map(|(_, log, at)| (log, &at.target))
                .collect();
            let ids = placed.iter().map(|(id, ..)| *id).collect();
            Some((ids, object_shape(&boxes)))
        });
    }

    fn count_passes(&mut self, logs: Vec<LogBoxes>) {
        let Some(object) = self.selected_object() else {
            // Nobody would collect what is being counted, and the window would never rest.
            if self.objects.passes.is_running() {
                self.objects.passes = Background::default();
            }
            return;
        };
        let (number, joint) = (object.number, object.joint.clone());
        let track = |one: &LogBoxes| (one.id, Same(one.navigation.clone()));
        let of = PassesOf {
            number,
            boxes: object.boxes.clone(),
            place_m: joint.place_m,
            logs: logs.iter().map(track).collect(),
        };
        self.objects.passes.ask(of, &self.jobs, move |_| {
            let logs: Vec<PassLog<'_>> = logs.iter().map(LogBoxes::pass_log).collect();
            Some((number, joint.passes(&logs)))
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::review::BoxId;

    fn boxes(ids: &[(u64, u32)]) -> Vec<LogBox> {
        let id = |(log, id): &(u64, u32)| LogBox {
            log: LogId(*log),
            id: BoxId(*id),
        };
        ids.iter().map(id).collect()
    }

    fn give(numbers: &mut Numbers, groups: &[&[(u64, u32)]]) -> Vec<u32> {
        let groups: Vec<Vec<LogBox>> = groups.iter().map(|group| boxes(group)).collect();
        numbers.give(groups.iter().map(Vec::as_slice))
    }

    #[test]
    fn an_object_keeps_its_number_whatever_becomes_of_its_boxes() {
        let mut numbers = Numbers::default();
        let first = give(
            &mut numbers,
            &[&[(0, 1), (1, 1)], &[(0, 2)], &[(0, 3), (1, 2)]],
        );
        assert_eq!(first, [1, 2, 3]);
        // The first loses a box, which stands alone; the second is out of sight; a new one comes.
        let next = give(
            &mut numbers,
            &[&[(0, 1)], &[(1, 9)], &[(0, 3), (1, 2), (2, 1)], &[(1, 1)]],
        );
        assert_eq!(next, [1, 4, 3, 5]);
        // It comes into sight again, with one more box.
        let again = give(&mut numbers, &[&[(0, 2), (2, 7)], &[(0, 1), (1, 1)]]);
        assert_eq!(again, [2, 1]);
        // Two objects become one: the number of more boxes stays.
        let joined = give(&mut numbers, &[&[(0, 2), (0, 3), (1, 2), (2, 1)]]);
        assert_eq!(joined, [3]);
    }
}
