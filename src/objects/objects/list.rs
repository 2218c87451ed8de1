//! The list of objects.

use super::{JointObject, LogBox, LogId, ObjectNumbers, ObjectSummary, PlacedBox, joint_objects};
use crate::review::{Reviewed, State};
use crate::targets::{GroupSettings, PassLog, Target};
use bathyscope_log::support::geo::LonLat;
use std::collections::HashMap;
use std::sync::Arc;

/// A box with its place, and the object that it is a sighting of.
#[derive(Clone, Debug)]
pub struct ObjectBox {
    /// Which log of the survey it is of.
    pub log: usize,
    /// The same, and its number there.
    pub key: LogBox,
    /// The box, and what was decided about it.
    pub one: Arc<Reviewed>,
    /// Name of its class.
    pub class: String,
    /// Where it lies in the world; `None` where that cannot be known.
    pub target: Option<Target>,
    /// Number of the object that it is a sighting of; `None` without a place.
    pub object: Option<u32>,
}

/// An object with the boxes that show it.
#[derive(Clone, Debug)]
pub struct SurveyObject {
    /// Its number, never given to another object.
    pub number: u32,
    /// The boxes that show it, by log and number.
    pub boxes: Vec<LogBox>,
    /// Where it lies.
    pub position: LonLat,
    /// Class, place in the plane of the survey, and height. Members count the boxes of the list.
    pub joint: JointObject,
    /// Passes of the boat that saw it: at most as many as boxes, since both sides may see it in one
    /// pass, and two recorders too.
    pub sightings: usize,
    /// What its boxes say of it.
    pub summary: ObjectSummary,
}

impl SurveyObject {
    /// The logs that saw it, in the order of the survey.
    pub fn logs(&self) -> Vec<LogId> {
        let mut logs: Vec<LogId> = self.boxes.iter().map(|one| one.log).collect();
        logs.dedup();
        logs
    }
}

/// All boxes of a survey that count, and the objects that they show.
#[derive(Clone, Debug, Default)]
pub struct ObjectList {
    boxes: Vec<ObjectBox>,
    objects: Vec<SurveyObject>,
    /// The object of every box that has one, by its place in the list.
    of: HashMap<LogBox, usize>,
    numbers: ObjectNumbers,
    is_reviewed: bool,
}

impl ObjectList {
    /// Joins the boxes that show one object. All places are in the plane of the first of `logs`,
    /// which the boxes count. A rejected box shows nothing: it is no sighting of the object beside
    /// it, and rejected boxes are objects of their own, as they can be decided otherwise. An object
    /// keeps the number that it had in `before`.
    pub fn join(mut boxes: Vec<ObjectBox>, logs: &[PassLog<'_>], before: &ObjectNumbers) -> Self {
        let mut joined = joined(&boxes, false);
        joined.extend(self::joined(&boxes, true));
        let keys = |joint: &JointObject| -> Vec<LogBox> {
            joint.members.iter().map(|member| boxes[*member].key).collect()
        };
        let keys: Vec<Vec<LogBox>> = joined.iter().map(keys).collect();
        let mut numbers = before.clone();
        let numbered = numbers.give(&keys);
        let mut objects: Vec<SurveyObject> = (joined.into_iter().zip(keys).zip(numbered))
            .filter_map(|((joint, boxes_of), number)| {
                let (survey, navigation) = logs.first()?;
                let [east_m, north_m] = joint.place_m;
                let members = joint.members.iter().map(|member| &boxes[*member]);
                let members = members.filter_map(|one| Some((&*one.one, one.target.as_ref()?)));
                Some(SurveyObject {
                    number,
                    boxes: boxes_of,
                    position: navigation.to_lon_lat(&survey.track, east_m, north_m),
                    sightings: joint.sightings(logs),
                    summary: ObjectSummary::of(members),
                    joint,
                })
            })
            .collect();
        objects.sort_by_key(|object| object.number);
        let mut of = HashMap::new();
        for (index, object) in objects.iter().enumerate() {
            of.extend(object.boxes.iter().map(|key| (*key, index)));
            for member in &object.joint.members {
                boxes[*member].object = Some(object.number);
            }
        }
        Self {
            is_reviewed: boxes.iter().any(|one| one.one.state != State::Proposed),
            boxes,
            objects,
            of,
            numbers,
        }
    }

    /// The boxes, log by log.
    pub fn boxes(&self) -> &[ObjectBox] {
        &self.boxes
    }

    /// The objects, by number.
    pub fn objects(&self) -> &[SurveyObject] {
        &self.objects
    }

    /// The numbers that the objects have, and those that they had while they were out of sight.
    pub fn numbers(&self) -> &ObjectNumbers {
        &self.numbers
    }

    /// An object by its number.
    pub fn object(&self, number: u32) -> Option<&SurveyObject> {
        let index = (self.objects).binary_search_by_key(&number, |object| object.number);
        self.objects.get(index.ok()?)
    }

    /// The object that a box shows; `None` of a box without a place, and of one that does not
    /// count.
    pub fn object_of(&self, key: LogBox) -> Option<&SurveyObject> {
        self.objects.get(*self.of.get(&key)?)
    }

    /// Whether anything was decided about any box; otherwise all of them are the detector's
    /// proposals.
    pub fn is_reviewed(&self) -> bool {
        self.is_reviewed
    }

    /// Whether a box is one of a target: as long as nothing is decided about any box, each is; then
    /// those are that were accepted or drawn by hand, for a proposal beside them would pass for an
    /// object that somebody has seen.
    pub fn is_target(&self, one: &ObjectBox) -> bool {
        !self.is_reviewed || one.one.state.is_object()
    }

    /// The objects that products show: those with a box of which [`ObjectList::is_target`] says so.
    pub fn targets(&self) -> impl Iterator<Item = &SurveyObject> {
        let is_target = |object: &&SurveyObject| {
            let mut members = object.joint.members.iter();
            members.any(|member| self.is_target(&self.boxes[*member]))
        };
        self.objects.iter().filter(is_target)
    }

    /// The boxes of an object.
    pub fn members(&self, object: &SurveyObject) -> impl Iterator<Item = &ObjectBox> {
        object.joint.members.iter().map(|member| &self.boxes[*member])
    }
}

/// The objects of the boxes that were rejected, or of all others; members count all boxes.
fn joined(boxes: &[ObjectBox], is_rejected: bool) -> Vec<JointObject> {
    let (members, placed): (Vec<usize>, Vec<PlacedBox<'_>>) = (boxes.iter().enumerate())
        .filter(|(_, one)| (one.one.state == State::Rejected) == is_rejected)
        .filter_map(|(index, one)| {
            let placed = PlacedBox {
                log: one.log,
                class: &one.class,
                score: one.one.score,
                target: one.target.as_ref()?,
            };
            Some((index, placed))
        })
        .unzip();
    let mut objects = joint_objects(&placed, &GroupSettings::default());
    for member in objects.iter_mut().flat_map(|object| &mut object.members) {
        *member = members[*member];
    }
    objects
}
