//! The list of objects.

use super::{LogBox, Object, ObjectBox, ObjectNumbers};
use crate::review::State;
use crate::targets::{GroupSettings, PassLog, Sighting, group};
use crate::{NAMELESS_CLASS, class_index};
use std::collections::HashMap;

/// The boxes of a survey that are in sight, and the objects that they show.
#[derive(Clone, Debug, Default)]
pub struct ObjectList {
    boxes: Vec<ObjectBox>,
    objects: Vec<Object>,
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
    /// after the others, and left out; of the others every box counts.
    pub fn join(boxes: Vec<ObjectBox>, logs: &[PassLog<'_>], before: &ObjectNumbers) -> Self {
        let mut objects = joined(&boxes, logs, false);
        objects.extend(joined(&boxes, logs, true));
        // What is in sight is numbered first: numbers then begin with one.
        let is_hidden = |object: &Object| object.members.iter().all(|one| boxes[*one].is_hidden);
        objects.sort_by_key(is_hidden);
        let keys: Vec<Vec<LogBox>> = objects.iter().map(|object| object.boxes.clone()).collect();
        let mut numbers = before.clone();
        for (object, number) in objects.iter_mut().zip(numbers.give(&keys)) {
            object.number = number;
        }
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
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The numbers that the objects have, and those that they had while they were out of sight.
    pub fn numbers(&self) -> &ObjectNumbers {
        &self.numbers
    }

    /// An object by its number.
    pub fn object(&self, number: u32) -> Option<&Object> {
        let index = (self.objects).binary_search_by_key(&number, |object| object.number);
        self.objects.get(index.ok()?)
    }

    /// The object that a box shows; `None` of a box without a place, and of one that does not
    /// count.
    pub fn object_of(&self, key: LogBox) -> Option<&Object> {
        self.objects.get(*self.of.get(&key)?)
    }

    /// Returns true if anything was decided about any box; otherwise all of them are the detector's
    /// proposals.
    pub fn is_reviewed(&self) -> bool {
        self.is_reviewed
    }

    /// Returns true if a box is one of a target: as long as nothing is decided about any box, each
    /// is; then those are that were accepted or drawn by hand, for a proposal beside them would
    /// pass for an object that somebody has seen.
    pub fn is_target(&self, one: &ObjectBox) -> bool {
        !self.is_reviewed || one.one.state.is_object()
    }

    /// The objects that products show: those with a box of which [`ObjectList::is_target`] says so.
    pub fn targets(&self) -> impl Iterator<Item = &Object> {
        let is_target = |object: &&Object| {
            let mut members = object.members.iter();
            members.any(|member| self.is_target(&self.boxes[*member]))
        };
        self.objects.iter().filter(is_target)
    }

    /// The boxes of an object.
    pub fn members(&self, object: &Object) -> impl Iterator<Item = &ObjectBox> {
        object.members.iter().map(|member| &self.boxes[*member])
    }
}

/// Gives boxes the numbers of their objects, and leaves out objects of which all boxes are hidden,
/// and these boxes; members count the boxes that are left.
fn hide(mut boxes: Vec<ObjectBox>, objects: &mut Vec<Object>) -> Vec<ObjectBox> {
    objects.retain(|object| object.members.iter().any(|member| !boxes[*member].is_hidden));
    for object in &*objects {
        for member in &object.members {
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
    for member in objects.iter_mut().flat_map(|object| &mut object.members) {
        *member = place_of[*member];
    }
    boxes
}

fn is_left(one: &ObjectBox) -> bool {
    one.object.is_some() || !one.is_hidden
}

/// The objects of the boxes that were rejected, or of all others, without numbers.
fn joined(boxes: &[ObjectBox], logs: &[PassLog<'_>], is_rejected: bool) -> Vec<Object> {
    let mut names = Vec::new();
    let (members, sightings): (Vec<usize>, Vec<Sighting<'_>>) = (boxes.iter().enumerate())
        .filter(|(_, one)| (one.one.state == State::Rejected) == is_rejected)
        .filter_map(|(index, one)| {
            let has_name = one.class != NAMELESS_CLASS;
            let sighting = Sighting {
                log: one.log,
                target: one.target.as_ref()?,
                // Every log may have a list of classes of its own: they are compared by name.
                class: has_name.then(|| class_index(&mut names, &one.class)),
                // Who drew a box was sure.
                score: one.one.score.map_or(1.0, f64::from),
            };
            Some((index, sighting))
        })
        .unzip();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let groups = group(&sightings, &GroupSettings::default()).into_iter();
    let objects = groups.filter_map(|mut group| {
        for member in &mut group.members {
            *member = members[*member];
        }
        Object::new(group, &names, boxes, logs)
    });
    objects.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::LogId;
    use crate::review::{BoxId, Reviewed};
    use crate::targets::Target;
    use crate::targets::testing::target;
    use bathyscope_log::survey::{Navigation, Survey};
    use std::sync::Arc;

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
    /// the boxes that are left; `numbers` are those that objects had before, and have then.
    fn objects_from(threshold: f32, numbers: &mut ObjectNumbers) -> (Objects, Boxes) {
        let boxes = [seen(1, 0, 40.0, 0.1), seen(2, 0, 0.0, 0.3), seen(3, 1, 0.4, 0.8)];
        let boxes = boxes.map(|one| {
            let is_hidden = one.one.score < Some(threshold);
            ObjectBox { is_hidden, ..one }
        });
        let (survey, navigation) = (Survey::default(), Navigation::of_pings([]));
        let log: PassLog<'_> = (&survey, &navigation);
        let list = ObjectList::join(boxes.to_vec(), &[log], numbers);
        *numbers = list.numbers().clone();
        let objects = list.objects().iter().map(|one| (one.number, one.place_m[0]));
        let left = list.boxes().iter().map(|one| (one.key.id.0, one.object));
        let members = list.objects().iter().flat_map(|object| list.members(object));
        assert!(members.into_iter().all(|one| one.object.is_some()));
        (objects.collect(), left.collect())
    }

    #[test]
    fn a_filter_hides_objects_and_changes_none() {
        let mut numbers = ObjectNumbers::default();
        let first = objects_from(0.2, &mut numbers);
        assert_eq!(first.0.len(), 1);
        assert_eq!(first.1, [(2, Some(1)), (3, Some(1))], "what is in sight comes first");
        let (number, east_m) = first.0[0];
        assert!(number == 1 && (east_m - 0.2).abs() < 1e-9, "{east_m}");
        let (all, boxes) = objects_from(0.0, &mut numbers);
        assert_eq!(all, [first.0[0], (2, 40.0)]);
        assert_eq!(boxes, [(1, Some(2)), (2, Some(1)), (3, Some(1))]);
        assert_eq!(objects_from(0.5, &mut numbers), first);
        assert_eq!(objects_from(0.9, &mut numbers), (Vec::new(), Vec::new()));
    }
}
