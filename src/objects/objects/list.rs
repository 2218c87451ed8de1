//! Joins the boxes of a survey into a list of objects.

use super::{LogBox, Object, ObjectBox, ObjectNumbers};
use crate::review::State;
use crate::targets::{PassLog, Sighting, group};
use crate::{NAMELESS_CLASS, class_index};
use std::collections::HashMap;

/// The boxes of a survey that belong to a shown object or are not hidden themselves, and the
/// objects.
#[derive(Clone, Debug, Default)]
pub struct ObjectList {
    /// The boxes, log by log.
    pub boxes: Vec<ObjectBox>,
    /// The objects, by number.
    pub objects: Vec<Object>,
    /// Index of the object of every box that has one.
    of: HashMap<LogBox, usize>,
    /// Numbers of the objects, including those of objects that are hidden now.
    pub numbers: ObjectNumbers,
    /// True if there is a decision about any box; otherwise all boxes are proposals of the
    /// detector.
    pub is_reviewed: bool,
}

impl ObjectList {
    /// Joins the boxes that show the same object. All places are in the plane of the first of
    /// `logs`; the log index of a box refers to `logs`. A rejected box is no sighting of the object
    /// beside it; rejected boxes form objects of their own, because the decision about them can
    /// still change. An object keeps the number that it had in `before`. Objects whose boxes are
    /// all hidden are numbered after the others, and left out; of the other objects every box
    /// counts, hidden or not.
    pub fn join(boxes: Vec<ObjectBox>, logs: &[PassLog<'_>], before: &ObjectNumbers) -> Self {
        let mut objects = joined(&boxes, logs, false);
        objects.extend(joined(&boxes, logs, true));
        // Shown objects are numbered first, so that their numbers begin with one.
        let is_hidden =
            |object: &Object| object.members.iter().all(|member| boxes[*member].is_hidden);
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
            is_reviewed: boxes.iter().any(|object_box| object_box.one.state != State::Proposed),
            boxes,
            objects,
            of,
            numbers,
        }
    }

    /// Returns an object by its number.
    pub fn object(&self, number: u32) -> Option<&Object> {
        let index = (self.objects).binary_search_by_key(&number, |object| object.number);
        self.objects.get(index.ok()?)
    }

    /// Returns the object that a box shows; `None` for a box without a place, and for a box that is
    /// not in the list.
    pub fn object_of(&self, key: LogBox) -> Option<&Object> {
        self.objects.get(*self.of.get(&key)?)
    }

    /// Returns true if a box belongs to a target. While there is no decision about any box, every
    /// box does; after that, only boxes that were accepted or drawn by hand: a proposal beside them
    /// could be mistaken for an object that somebody has confirmed.
    pub fn is_target(&self, object_box: &ObjectBox) -> bool {
        !self.is_reviewed || object_box.one.state.is_object()
    }

    /// Returns the objects that products show: those with a box for which [`ObjectList::is_target`]
    /// is true.
    pub fn targets(&self) -> impl Iterator<Item = &Object> {
        let is_target = |object: &&Object| {
            let mut members = object.members.iter();
            members.any(|member| self.is_target(&self.boxes[*member]))
        };
        self.objects.iter().filter(is_target)
    }

    /// Returns the boxes of an object.
    pub fn members(&self, object: &Object) -> impl Iterator<Item = &ObjectBox> {
        object.members.iter().map(|member| &self.boxes[*member])
    }
}

/// Sets the object number of each box, removes objects whose boxes are all hidden, and returns the
/// boxes that are left; the members of the objects are then indices into these.
fn hide(mut boxes: Vec<ObjectBox>, objects: &mut Vec<Object>) -> Vec<ObjectBox> {
    objects.retain(|object| object.members.iter().any(|member| !boxes[*member].is_hidden));
    for object in &*objects {
        for member in &object.members {
            boxes[*member].object = Some(object.number);
        }
    }
    let mut left = 0;
    let place_of: Vec<usize> = (boxes.iter())
        .map(|object_box| {
            let place = left;
            left += usize::from(is_left(object_box));
            place
        })
        .collect();
    boxes.retain(is_left);
    for member in objects.iter_mut().flat_map(|object| &mut object.members) {
        *member = place_of[*member];
    }
    boxes
}

fn is_left(object_box: &ObjectBox) -> bool {
    object_box.object.is_some() || !object_box.is_hidden
}

/// Joins the rejected boxes, or all other boxes, into objects without numbers.
fn joined(boxes: &[ObjectBox], logs: &[PassLog<'_>], is_rejected: bool) -> Vec<Object> {
    let mut names = Vec::new();
    let (members, sightings): (Vec<usize>, Vec<Sighting<'_>>) = (boxes.iter().enumerate())
        .filter(|(_, object_box)| (object_box.one.state == State::Rejected) == is_rejected)
        .filter_map(|(index, object_box)| {
            let has_name = object_box.class != NAMELESS_CLASS;
            let sighting = Sighting {
                log: object_box.log,
                target: object_box.target.as_ref()?,
                // Every log may have its own list of classes, so they are compared by name.
                class: has_name.then(|| class_index(&mut names, &object_box.class)),
                // A box without a score was drawn by hand, which counts as sure.
                score: object_box.one.score.map_or(1.0, f64::from),
            };
            Some((index, sighting))
        })
        .unzip();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let groups = group(&sightings).into_iter();
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
    use crate::testing::target;
    use bathyscope_log::survey::{Navigation, Survey};
    use std::sync::Arc;

    /// Creates a box of line `line`; each line is 50 m of sailed distance further on.
    fn seen(id: u32, line: u32, east_m: f64, score: f32) -> ObjectBox {
        let placed = Target { east_m, sailed_m: 50.0 * f64::from(line), ..target() };
        let mut reviewed = Reviewed::drawn(BoxId(id), placed.mark.clone(), 0);
        (reviewed.score, reviewed.state) = (Some(score), State::Proposed);
        ObjectBox {
            log: 0,
            key: LogBox { log: LogId(0), id: BoxId(id) },
            one: Arc::new(reviewed),
            class: "rock".to_owned(),
            target: Some(placed),
            object: None,
            is_hidden: false,
        }
    }

    type Objects = Vec<(u32, f64)>;
    type Boxes = Vec<(u32, Option<u32>)>;

    /// Returns the objects when undecided boxes of a lower score are hidden: the number and place
    /// of each, and the boxes that are left. `numbers` holds the numbers from before, and is
    /// updated.
    fn objects_from(threshold: f32, numbers: &mut ObjectNumbers) -> (Objects, Boxes) {
        let boxes = [seen(1, 0, 40.0, 0.1), seen(2, 0, 0.0, 0.3), seen(3, 1, 0.4, 0.8)];
        let boxes = boxes.map(|object_box| {
            let is_hidden = object_box.one.score < Some(threshold);
            ObjectBox { is_hidden, ..object_box }
        });
        let (survey, navigation) = (Survey::default(), Navigation::of_pings([]));
        let log: PassLog<'_> = (&survey, &navigation);
        let list = ObjectList::join(boxes.to_vec(), &[log], numbers);
        *numbers = list.numbers.clone();
        let objects = list.objects.iter().map(|object| (object.number, object.place_m[0]));
        let left = list.boxes.iter().map(|object_box| (object_box.key.id.0, object_box.object));
        let members = list.objects.iter().flat_map(|object| list.members(object));
        assert!(members.into_iter().all(|member| member.object.is_some()));
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
