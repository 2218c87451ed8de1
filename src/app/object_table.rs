//! The table of objects: which rows it shows, in which order.

use bathyscope_objects::objects::{ObjectState, ObjectSummary, SurveyObject};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// A column of the table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ObjectColumn {
    /// As they were found, along the first log.
    #[default]
    Number,
    /// What the analyst calls it.
    Name,
    /// What most of its boxes take it for.
    Class,
    /// How far the decisions are.
    State,
    /// The confidence of the analyst, and then of the detector.
    #[serde(alias = "Sure")]
    Confidence,
    /// Metres along the track.
    Length,
    /// Metres across the track.
    Width,
    /// Metres above the bottom.
    Height,
    /// Metres of the bottom below the level that depths count from.
    Depth,
    /// Passes of the boat that saw it: what is seen every time is rarely a false alarm.
    Seen,
    /// Logs that saw it.
    Logs,
    /// Where it lies, from south to north.
    Position,
    /// What is noted on its boxes.
    Remarks,
}

impl ObjectColumn {
    /// All columns, from left to right.
    pub const ALL: [Self; 13] = [
        Self::Number,
        Self::Name,
        Self::Class,
        Self::State,
        Self::Confidence,
        Self::Length,
        Self::Width,
        Self::Height,
        Self::Depth,
        Self::Seen,
        Self::Logs,
        Self::Position,
        Self::Remarks,
    ];

    /// Its heading.
    pub fn name(self) -> &'static str {
        match self {
            Self::Number => "no.",
            Self::Name => "name",
            Self::Class => "class",
            Self::State => "state",
            Self::Confidence => "confidence",
            Self::Length => "length",
            Self::Width => "width",
            Self::Height => "height",
            Self::Depth => "depth",
            Self::Seen => "seen",
            Self::Logs => "logs",
            Self::Position => "position",
            Self::Remarks => "remarks",
        }
    }

    /// Whether a first click on its heading sorts from the largest down: what is seen most often
    /// and what is largest comes first.
    fn begins_with_largest(self) -> bool {
        !matches!(self, Self::Number | Self::Name | Self::Class | Self::State | Self::Remarks)
    }
}

/// Which objects the table shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ObjectFilter {
    /// Objects with undecided boxes.
    Undecided,
    /// Objects whose boxes were accepted or added.
    Accepted,
    /// Objects whose boxes were rejected.
    Rejected,
}

impl ObjectFilter {
    /// All of them, in the order of the work.
    pub const ALL: [Self; 3] = [Self::Undecided, Self::Accepted, Self::Rejected];

    /// Its name in the list.
    pub fn name(self) -> &'static str {
        match self {
            Self::Undecided => "undecided",
            Self::Accepted => "accepted",
            Self::Rejected => "rejected",
        }
    }

    fn takes(self, state: ObjectState) -> bool {
        match state {
            ObjectState::Open(_) => self == Self::Undecided,
            ObjectState::Accepted => self == Self::Accepted,
            ObjectState::Rejected => self == Self::Rejected,
        }
    }
}

/// Order and filter of the table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ObjectTable {
    /// The column that it is sorted by.
    pub sort: ObjectColumn,
    /// From the largest down.
    pub falling: bool,
    /// Only objects in this state.
    pub state: Option<ObjectFilter>,
    /// Only objects with this in number, name, class or remarks, in capitals or not.
    #[serde(skip)]
    pub text: String,
}

impl ObjectTable {
    /// Sorts by a column, or, where it is the one already, the other way around.
    pub fn sort_by(&mut self, column: ObjectColumn) {
        self.falling = match self.sort == column {
            true => !self.falling,
            false => column.begins_with_largest(),
        };
        self.sort = column;
    }

    /// Numbers of the objects that are shown, in order. Objects come by number, and stay so where
    /// they are alike; what is not known comes last.
    pub fn list(&self, objects: &[SurveyObject]) -> Vec<u32> {
        let text = self.text.trim().to_lowercase();
        let passes = |object: &&SurveyObject| {
            let of_state = self.state;
            of_state.is_none_or(|state| state.takes(object.summary.state)) && says(object, &text)
        };
        let mut shown: Vec<&SurveyObject> = objects.iter().filter(passes).collect();
        shown.sort_by(|a, b| self.order(a, b));
        shown.into_iter().map(|object| object.number).collect()
    }

    fn order(&self, a: &SurveyObject, b: &SurveyObject) -> Ordering {
        let turned = |order: Ordering| if self.falling { order.reverse() } else { order };
        let (left, right) = (&a.summary, &b.summary);
        let numbers = |left: f64, right: f64| match (left.is_nan(), right.is_nan()) {
            (false, false) => turned(left.total_cmp(&right)),
            (left, right) => left.cmp(&right),
        };
        let texts = |left: &str, right: &str| match (left.is_empty(), right.is_empty()) {
            (false, false) => turned(left.to_lowercase().cmp(&right.to_lowercase())),
            (left, right) => left.cmp(&right),
        };
        match self.sort {
            ObjectColumn::Number => turned(a.number.cmp(&b.number)),
            ObjectColumn::Name => texts(&left.name, &right.name),
            ObjectColumn::Class => texts(&a.joint.class, &b.joint.class),
            ObjectColumn::State => turned(state_place(left.state).cmp(&state_place(right.state))),
            ObjectColumn::Confidence => turned(
                (left.confidence.cmp(&right.confidence)).then(score(left).total_cmp(&score(right))),
            ),
            ObjectColumn::Length => numbers(left.length_m, right.length_m),
            ObjectColumn::Width => numbers(left.width_m, right.width_m),
            ObjectColumn::Height => numbers(a.joint.height.mean_m, b.joint.height.mean_m),
            ObjectColumn::Depth => numbers(left.depth_m, right.depth_m),
            ObjectColumn::Seen => turned(a.sightings.cmp(&b.sightings)),
            ObjectColumn::Logs => turned(a.logs().len().cmp(&b.logs().len())),
            ObjectColumn::Position => numbers(a.position.lat_deg, b.position.lat_deg),
            ObjectColumn::Remarks => texts(&left.notes, &right.notes),
        }
    }
}

/// Undecided first, as the order of the work.
fn state_place(state: ObjectState) -> usize {
    match state {
        ObjectState::Open(_) => 0,
        ObjectState::Accepted => 1,
        ObjectState::Rejected => 2,
    }
}

/// Who drew a box was sure.
fn score(summary: &ObjectSummary) -> f32 {
    summary.score.unwrap_or(1.0)
}

fn says(object: &SurveyObject, text: &str) -> bool {
    let summary = &object.summary;
    let parts = [&summary.name, &object.joint.class, &summary.notes];
    let has = |part: &&String| part.to_lowercase().contains(text);
    text.is_empty() || parts.iter().any(has) || object.number.to_string() == text
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::LonLat;
    use bathyscope_objects::ObjectExtent;
    use bathyscope_objects::objects::{LogBox, LogId, PlacedBox, joint_objects};
    use bathyscope_objects::review::{BoxId, Confidence, Reviewed, State};
    use bathyscope_objects::targets::{GroupSettings, Target};

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

    fn object(number: u32, class: &str, boxes: &[(Reviewed, Target)]) -> SurveyObject {
        let placed = PlacedBox { log: 0, class, score: None, target: &boxes[0].1 };
        let joint = joint_objects(&[placed], &GroupSettings::default());
        let log = LogId(1);
        SurveyObject {
            number,
            boxes: vec![LogBox { log, id: BoxId(number) }; boxes.len()],
            position: boxes[0].1.position,
            joint: joint[0].clone(),
            sightings: boxes.len(),
            summary: ObjectSummary::of(boxes.iter().map(|(one, target)| (one, target))),
        }
    }

    #[test]
    fn a_row_says_what_its_boxes_say() {
        let mut drawn = reviewed(State::Accepted, 0.3);
        drawn.extent = ObjectExtent::Drawn { border_m: 6.0 };
        drawn.name = "Anna".to_owned();
        drawn.confidence = Some(Confidence::Probable);
        drawn.note = "two".to_owned();
        let mut other = reviewed(State::Proposed, 0.8);
        other.note = "three".to_owned();
        other.confidence = Some(Confidence::Unsure);
        let boxes = [(other, target(2.0)), (drawn, target(1.0))];
        let summary = object(1, "rock", &boxes).summary;
        assert_eq!(summary.name, "Anna");
        assert_eq!(summary.notes, "three; two");
        assert_eq!(summary.state, ObjectState::Open(1));
        assert_eq!(summary.score, Some(0.8));
        assert_eq!(summary.confidence, Some(Confidence::Probable));
        assert_eq!(summary.length_m, 1.0, "what was drawn counts");
        let rejected = [(reviewed(State::Rejected, 0.5), target(1.0))];
        assert_eq!(object(1, "rock", &rejected).summary.state, ObjectState::Rejected);
    }

    #[test]
    fn the_table_is_sorted_and_filtered() {
        let one = |state, score, length_m| [(reviewed(state, score), target(length_m))];
        let objects = [
            object(1, "tyre", &one(State::Accepted, 0.5, 2.0)),
            object(2, "Rock", &one(State::Proposed, 0.9, f64::NAN)),
            object(3, "block", &one(State::Rejected, 0.7, 3.0)),
        ];
        let mut table = ObjectTable::default();
        assert_eq!(table.list(&objects), [1, 2, 3]);
        table.sort_by(ObjectColumn::Length);
        assert_eq!(table.list(&objects), [3, 1, 2], "the longest first");
        table.sort_by(ObjectColumn::Length);
        assert_eq!(table.list(&objects), [1, 3, 2], "what is not known last");
        table.sort_by(ObjectColumn::Class);
        assert_eq!(table.list(&objects), [3, 2, 1]);
        table.sort_by(ObjectColumn::State);
        assert_eq!(table.list(&objects), [2, 1, 3]);
        table.sort_by(ObjectColumn::Confidence);
        assert_eq!(table.list(&objects), [2, 3, 1]);
        table.text = "ROC".to_owned();
        assert_eq!(table.list(&objects), [2]);
        table.text = "3".to_owned();
        assert_eq!(table.list(&objects), [3]);
        table.text.clear();
        table.state = Some(ObjectFilter::Accepted);
        assert_eq!(table.list(&objects), [1]);
    }

    #[test]
    fn fifty_thousand_objects_are_listed() {
        let boxes = [(reviewed(State::Proposed, 0.5), target(1.0))];
        let first = object(1, "rock", &boxes);
        let objects: Vec<SurveyObject> = (0..50_000_u32)
            .map(|index| {
                let mut one = first.clone();
                one.number = index + 1;
                one.summary.length_m = f64::from(index.wrapping_mul(2_654_435_761) >> 12);
                one
            })
            .collect();
        let mut table = ObjectTable::default();
        table.sort_by(ObjectColumn::Length);
        table.text = "rock".to_owned();
        assert_eq!(table.list(&objects).len(), objects.len());
    }
}
