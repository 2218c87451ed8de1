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
    /// The confidence filter has it out of sight. It counts as a sighting all the same.
    pub is_hidden: bool,
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

/// The boxes of a survey that are in sight, and the objects that they show.
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
    /// keeps the number that it had in `before`. Objects of which all boxes are hidden are numbered
    /// and left out; of the others every box counts.
    pub fn join(boxes: Vec<ObjectBox>, logs: &[PassLog<'_>], before: &ObjectNumbers) -> Self {
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
        let boxes = hide(boxes, &mut objects);
        let mut of = HashMap::new();
        for (index, object) in objects.iter().enumerate() {
            of.extend(object.boxes.iter().map(|key| (*key, index)));
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

/// Gives boxes the numbers of their objects, and leaves out objects of which all boxes are hidden,
/// and these boxes; members count the boxes that are left.
fn hide(mut boxes: Vec<ObjectBox>, objects: &mut Vec<SurveyObject>) -> Vec<ObjectBox> {
    objects.retain(|object| object.joint.members.iter().any(|member| !boxes[*member].is_hidden));
    for object in &*objects {
        for member in &object.joint.members {
            boxes[*member].object = Some(object.number);
        }
    }
    let mut left = 0;
    let place_of: Vec<usize> = (boxes.iter())
        .map(|one| {
            let place = left;
            left += usize::from(is_left(one));
            place
        })
        .collect();
    boxes.retain(is_left);
    for member in objects.iter_mut().flat_map(|object| &mut object.joint.members) {
        *member = place_of[*member];
    }
    boxes
}

fn is_left(one: &ObjectBox) -> bool {
    one.object.is_some() || !one.is_hidden
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::review::BoxId;
    use crate::targets::testing::target;
    use bathyscope_log::survey::{Navigation, Survey};

    /// A box of a first line, 50 m further of the way a second one, and so on.
    fn seen(id: u32, line: u32, east_m: f64, score: f32) -> ObjectBox {
        let placed = Target { east_m, sailed_m: 50.0 * f64::from(line), ..target() };
        let mut one = Reviewed::drawn(BoxId(id), placed.mark.clone(), 0);
        (one.score, one.state) = (Some(score), State::Proposed);
        ObjectBox {
            log: 0,
            key: LogBox { log: LogId(0), id: BoxId(id) },
            one: Arc::new(one),
            class: "rock".to_owned(),
            target: Some(placed),
            object: None,
            is_hidden: false,
        }
    }

    type Objects = Vec<(u32, f64)>;
    type Boxes = Vec<(u32, Option<u32>)>;

    /// The objects where undecided boxes of less score are hidden: number and place of each, and
    /// the boxes that are left.
    fn objects_from(threshold: f32) -> (Objects, Boxes) {
        let boxes = [seen(1, 0, 40.0, 0.1), seen(2, 0, 0.0, 0.3), seen(3, 1, 0.4, 0.8)];
        let boxes = boxes.map(|one| {
            let is_hidden = one.one.score < Some(threshold);
            ObjectBox { is_hidden, ..one }
        });
        let (survey, navigation) = (Survey::default(), Navigation::of_pings([]));
        let log: PassLog<'_> = (&survey, &navigation);
        let list = ObjectList::join(boxes.to_vec(), &[log], &ObjectNumbers::default());
        let objects = list.objects().iter().map(|one| (one.number, one.joint.place_m[0]));
        let left = list.boxes().iter().map(|one| (one.key.id.0, one.object));
        let members = list.objects().iter().flat_map(|object| list.members(object));
        assert!(members.into_iter().all(|one| one.object.is_some()));
        (objects.collect(), left.collect())
    }

    #[test]
    fn a_filter_hides_objects_and_changes_none() {
        let (all, boxes) = objects_from(0.0);
        assert_eq!(all.iter().map(|one| one.0).collect::<Vec<u32>>(), [1, 2]);
        assert!((all[1].1 - 0.2).abs() < 1e-9, "{all:?}");
        assert_eq!(boxes, [(1, Some(1)), (2, Some(2)), (3, Some(2))]);
        for threshold in [0.2, 0.5] {
            let (left, boxes) = objects_from(threshold);
            assert_eq!(left, all[1..]);
            assert_eq!(boxes, [(2, Some(2)), (3, Some(2))]);
        }
        assert_eq!(objects_from(0.9), (Vec::new(), Vec::new()));
    }
}
