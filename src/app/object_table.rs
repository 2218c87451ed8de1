//! Sorts and filters the table of objects.

use bathyscope_objects::objects::{
    ColumnValue, ColumnValues, ListedObject, Object, ObjectColumn, ObjectState,
};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// Name of the column that objects are sorted by initially.
const NUMBER: &str = "number";

/// Order and filter of the table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ObjectTable {
    /// Name of the column that the table is sorted by; the number is used if there is no such
    /// column.
    pub sort: String,
    /// True if the table is sorted in descending order.
    pub falling: bool,
    /// State of the listed objects; `None` lists all.
    pub state: Option<ObjectState>,
    /// Text that the number equals, or that name, class or remarks of the listed objects contain,
    /// in capitals or not; empty lists all.
    #[serde(skip)]
    pub text: String,
}

impl ObjectTable {
    /// Sorts by a column, or reverses the order if the table is sorted by it already.
    pub fn sort_by(&mut self, column: &ObjectColumn) {
        self.falling =
            if self.is_sorted_by(column) { !self.falling } else { begins_with_largest(column) };
        column.name.clone_into(&mut self.sort);
    }

    /// Returns true for the column that the table is sorted by.
    pub fn is_sorted_by(&self, column: &ObjectColumn) -> bool {
        match ObjectColumn::named(&self.sort) {
            Some(by) => by.name == column.name,
            None => column.name == NUMBER,
        }
    }

    /// Returns the numbers of the listed objects, in order. Objects with equal values are ordered
    /// by number; objects without a value come last.
    pub fn list(&self, objects: &[Object], log_names: &[String]) -> Vec<u32> {
        let text = self.text.trim().to_lowercase();
        let passes = |object: &&Object| {
            let of_state = self.state;
            of_state.is_none_or(|state| state == object.state) && says(object, &text)
        };
        let column = ObjectColumn::named(&self.sort);
        let mut shown: Vec<(Option<SortKey>, u32)> = (objects.iter().filter(passes))
            .map(|object| {
                let of = ListedObject { object, shape: None, outline: None, log_names };
                (column.and_then(|column| SortKey::of(column, &of)), object.number)
            })
            .collect();
        shown.sort_by(|(a, _), (b, _)| match (a, b) {
            (Some(a), Some(b)) if self.falling => b.order(a),
            (Some(a), Some(b)) => a.order(b),
            (a, b) => a.is_none().cmp(&b.is_none()),
        });
        shown.into_iter().map(|(_, number)| number).collect()
    }
}

/// Returns true for a column that a first click sorts in descending order: objects that are large
/// or seen often come first.
fn begins_with_largest(column: &ObjectColumn) -> bool {
    let is_place = matches!(column.values, ColumnValues::Position(_));
    (column.values.is_number() || is_place) && column.name != NUMBER
}

/// The value of an object by which the table is sorted.
enum SortKey {
    Text(String),
    Number(f64),
}

impl SortKey {
    fn of(column: &ObjectColumn, of: &ListedObject<'_>) -> Option<Self> {
        if let ColumnValues::State(state) = column.values {
            // States are sorted in the order of the work.
            return Some(Self::Number(f64::from(state(of) as u8)));
        }
        Some(match column.value(of)? {
            ColumnValue::Text(words) => Self::Text(words.to_lowercase()),
            ColumnValue::Count(count) => Self::Number(count as f64),
            ColumnValue::Number(_, number) => Self::Number(number),
        })
    }

    fn order(&self, other: &Self) -> Ordering {
        match (self, other) {
            (Self::Text(one), Self::Text(other)) => one.cmp(other),
            (Self::Number(one), Self::Number(other)) => one.total_cmp(other),
            // A column holds only texts or only numbers.
            (Self::Text(_), Self::Number(_)) => Ordering::Less,
            (Self::Number(_), Self::Text(_)) => Ordering::Greater,
        }
    }
}

fn says(object: &Object, text: &str) -> bool {
    let parts = [&object.name, &object.class, &object.remarks];
    let has = |part: &&String| part.to_lowercase().contains(text);
    text.is_empty() || parts.iter().any(has) || object.number.to_string() == text
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::LonLat;
    use bathyscope_log::survey::{Navigation, Survey};
    use bathyscope_objects::ObjectExtent;
    use bathyscope_objects::objects::{LogBox, LogId, ObjectBox, ObjectList, ObjectNumbers};
    use bathyscope_objects::review::{BoxId, Certainty, Reviewed, State};
    use bathyscope_objects::targets::Target;
    use std::sync::Arc;

    fn target(length_m: f64) -> Target {
        let mark = bathyscope_objects::Mark::point(bathyscope_log::survey::Side::Port, 5, 6.0);
        Target {
            mark,
            extent: ObjectExtent::Found,
            measured_shadow: None,
            parts: None,
            slant_m: 5.0,
            ground_m: 4.0,
            altitude_m: 3.0,
            east_m: 0.0,
            north_m: 0.0,
            position: LonLat { lon_deg: 0.0, lat_deg: 0.0 },
            length_m,
            width_m: 0.4,
            height_m: f64::NAN,
            shadow_m: [f64::NAN; 2],
            height_sigma_m: f64::NAN,
            depth_m: 3.0,
            sigma_m: 0.3,
            along_sigma_m: 0.3,
            across_sigma_m: 0.3,
            heading_rad: 0.0,
            sailed_m: 10.0,
        }
    }

    fn reviewed(state: State, score: f32) -> Reviewed {
        let mark = bathyscope_objects::Mark::point(bathyscope_log::survey::Side::Port, 5, 6.0);
        Reviewed { score: Some(score), state, ..Reviewed::drawn(BoxId(1), mark, 0) }
    }

    fn object(number: u32, class: &str, boxes: &[(Reviewed, Target)]) -> Object {
        let boxed = |(index, (review_box, target)): (usize, &(Reviewed, Target))| ObjectBox {
            log: 0,
            key: LogBox { log: LogId(1), id: BoxId(index as u32) },
            one: Arc::new(review_box.clone()),
            class: class.to_owned(),
            // Each box belongs to its own line.
            target: Some(Target { sailed_m: 50.0 * index as f64, ..target.clone() }),
            object: None,
            is_hidden: false,
        };
        let (survey, navigation) = (Survey::default(), Navigation::of_pings([]));
        let boxes = boxes.iter().enumerate().map(boxed).collect();
        let list = ObjectList::join(boxes, &[(&survey, &navigation)], &ObjectNumbers::default());
        let [object] = &list.objects[..] else { panic!("one object") };
        let mut object = object.clone();
        object.number = number;
        object
    }

    #[test]
    fn a_row_says_what_its_boxes_say() {
        let mut drawn = reviewed(State::Accepted, 0.3);
        drawn.extent = ObjectExtent::Drawn { border_m: 6.0 };
        drawn.name = "Anna".to_owned();
        drawn.certainty = Some(Certainty::Probable);
        drawn.note = "two".to_owned();
        let mut other = reviewed(State::Proposed, 0.8);
        other.note = "three".to_owned();
        other.certainty = Some(Certainty::Unsure);
        let boxes = [(other, target(2.0)), (drawn, target(1.0))];
        let object = self::object(1, "rock", &boxes);
        assert_eq!(object.name, "Anna");
        assert_eq!(object.remarks, "three; two");
        assert_eq!(object.state, ObjectState::Accepted, "by one of them");
        assert_eq!(object.score, Some(0.8));
        assert_eq!(object.certainty, Some(Certainty::Probable));
        assert_eq!(object.length_m, 1.0, "what was drawn counts");
        let rejected = [(reviewed(State::Rejected, 0.5), target(1.0))];
        assert_eq!(self::object(1, "rock", &rejected).state, ObjectState::Rejected);
    }

    fn sort(table: &mut ObjectTable, name: &str) {
        table.sort_by(ObjectColumn::named(name).expect("a column"));
    }

    #[test]
    fn the_table_is_sorted_and_filtered() {
        let one_box = |state, score, length_m| [(reviewed(state, score), target(length_m))];
        let objects = [
            object(1, "tyre", &one_box(State::Accepted, 0.5, 2.0)),
            object(2, "Rock", &one_box(State::Proposed, 0.9, f64::NAN)),
            object(3, "block", &one_box(State::Rejected, 0.7, 3.0)),
        ];
        let mut table = ObjectTable::default();
        assert_eq!(table.list(&objects, &[]), [1, 2, 3]);
        sort(&mut table, "length_m");
        assert_eq!(table.list(&objects, &[]), [3, 1, 2], "the longest first");
        sort(&mut table, "length_m");
        assert_eq!(table.list(&objects, &[]), [1, 3, 2], "what is not known last");
        sort(&mut table, "class");
        assert_eq!(table.list(&objects, &[]), [3, 2, 1]);
        sort(&mut table, "state");
        assert_eq!(table.list(&objects, &[]), [2, 1, 3]);
        sort(&mut table, "score");
        assert_eq!(table.list(&objects, &[]), [2, 3, 1]);
        table.text = "ROC".to_owned();
        assert_eq!(table.list(&objects, &[]), [2]);
        table.text = "3".to_owned();
        assert_eq!(table.list(&objects, &[]), [3]);
        table.text.clear();
        table.state = Some(ObjectState::Accepted);
        assert_eq!(table.list(&objects, &[]), [1]);
    }

    #[test]
    fn fifty_thousand_objects_are_listed() {
        let boxes = [(reviewed(State::Proposed, 0.5), target(1.0))];
        let first = object(1, "rock", &boxes);
        let objects: Vec<Object> = (0..50_000_u32)
            .map(|index| {
                let mut numbered = first.clone();
                numbered.number = index + 1;
                numbered.length_m = f64::from(index.wrapping_mul(2_654_435_761) >> 12);
                numbered
            })
            .collect();
        let mut table = ObjectTable::default();
        sort(&mut table, "length_m");
        table.text = "rock".to_owned();
        assert_eq!(table.list(&objects, &[]).len(), objects.len());
    }
}
