//! Combines all sightings of an object into its properties.

use super::{LogBox, LogId};
use crate::ObjectExtent;
use crate::review::{Certainty, Reviewed, State};
use crate::targets::{Group, LogPings, ObjectHeight, PassCount, PassLog, Target, distinct_passes};
use bathyscope_log::named;
use bathyscope_log::support::geo::LonLat;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A box with its position, and the object that it is a sighting of.
#[derive(Clone, Debug)]
pub struct ObjectBox {
    /// Index of the log in the survey.
    pub log: usize,
    /// Log of the box, and its number there.
    pub key: LogBox,
    /// The box and the decision about it.
    pub one: Arc<Reviewed>,
    /// Name of the class of the box.
    pub class: String,
    /// Position and size of the box in the world; `None` if they cannot be computed.
    pub target: Option<Target>,
    /// Number of the object that the box is a sighting of; `None` for a box without a position.
    pub object: Option<u32>,
    /// True if the score filter hides the box. It still counts as a sighting.
    pub is_hidden: bool,
}

/// State of the decision about an object; variants are in the order of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ObjectState {
    /// No decision has been made.
    Undecided,
    /// There is an object: one of its boxes was accepted or drawn by hand. The decision stays if a
    /// search finds further boxes of the object, or a filter hides boxes.
    Accepted,
    /// There is no object: all its boxes were rejected.
    Rejected,
}

named! {
    /// All states, in the order of the work.
    pub ObjectState {
        Undecided: "undecided",
        Accepted: "accepted",
        Rejected: "rejected",
    }
}

/// An object on the bottom with the boxes that show it. Lengths in metres; NaN if unknown.
#[derive(Clone, Debug)]
pub struct Object {
    /// Number of the object, never used for another object.
    pub number: u32,
    /// Boxes that show the object, by log and number.
    pub boxes: Vec<LogBox>,
    /// Indices of these boxes in the list of boxes, growing.
    pub members: Vec<usize>,
    /// Name that the analyst gave: the name of the first box that has one; empty if none has.
    pub name: String,
    /// Class with the largest sum of scores, among the boxes with a known class.
    pub class: String,
    /// State of the decision about the object.
    pub state: ObjectState,
    /// Highest score of the detector; `None` if all boxes were drawn by hand.
    pub score: Option<f32>,
    /// Highest certainty that the analyst stated for a box of the object; `None` if stated for
    /// none.
    pub certainty: Option<Certainty>,
    /// Mean place of the boxes, weighted by the inverse of their covariances: metres east and north
    /// in the plane of the survey.
    pub place_m: [f64; 2],
    /// Mean place of the boxes in longitude and latitude.
    pub position: LonLat,
    /// Standard deviation of the mean place in the worse direction.
    pub sigma_m: f64,
    /// Index, among its boxes, of the box that measures the size best.
    pub best: usize,
    /// Length along the track, from this box.
    pub length_m: f64,
    /// Width across the track, from this box.
    pub width_m: f64,
    /// Height above the bottom, from all boxes together.
    pub height: ObjectHeight,
    /// Depth of the bottom at the object, from the box that measures the size best.
    pub depth_m: f64,
    /// Heading of the boat at this box, radians clockwise from the north of the plane.
    pub heading_rad: f64,
    /// Number of passes of the boat that saw the object: at most the number of boxes, since both
    /// sides, or two recorders, may see it in one pass.
    pub sightings: usize,
    /// Remarks on its boxes, joined by semicolons.
    pub remarks: String,
    /// Log and pings of each box.
    seen_on: Vec<LogPings>,
}

impl Object {
    /// Creates the object of a group of boxes of a list; `names` are the class names that the group
    /// refers to. The number is 0 until one is assigned. `None` if there are no logs.
    pub(super) fn new(
        group: Group,
        names: &[&str],
        boxes: &[ObjectBox],
        logs: &[PassLog<'_>],
    ) -> Option<Self> {
        let (survey, navigation) = logs.first()?;
        let shown = || group.members.iter().filter_map(|member| boxes.get(*member));
        let reviewed = || shown().map(|object_box| &*object_box.one);
        let best = best(shown());
        let target = shown().nth(best).and_then(|object_box| object_box.target.as_ref());
        let seen_on: Vec<LogPings> =
            shown().map(|object_box| (object_box.log, object_box.one.mark.pings.clone())).collect();
        let remarks: Vec<&str> = reviewed()
            .map(|review_box| review_box.note.as_str())
            .filter(|note| !note.is_empty())
            .collect();
        let name = reviewed().map(|review_box| &review_box.name).find(|name| !name.is_empty());
        Some(Self {
            number: 0,
            boxes: shown().map(|object_box| object_box.key).collect(),
            name: name.cloned().unwrap_or_default(),
            class: group.class.map_or(crate::NAMELESS_CLASS, |class| names[class]).to_owned(),
            state: state(reviewed().map(|review_box| review_box.state)),
            score: reviewed().filter_map(|review_box| review_box.score).max_by(f32::total_cmp),
            certainty: reviewed().filter_map(|review_box| review_box.certainty).max(),
            place_m: [group.east_m, group.north_m],
            position: navigation.to_lon_lat(&survey.track, group.east_m, group.north_m),
            sigma_m: group.sigma_m,
            best,
            length_m: target.map_or(f64::NAN, |target| target.length_m),
            width_m: target.map_or(f64::NAN, |target| target.width_m),
            height: group.height,
            depth_m: target.map_or(f64::NAN, |target| target.depth_m),
            heading_rad: target.map_or(f64::NAN, |target| target.heading_rad),
            sightings: distinct_passes(&seen_on, logs).len(),
            remarks: remarks.join("; "),
            seen_on,
            members: group.members,
        })
    }

    /// Returns the logs that saw the object, in the order of the survey.
    pub fn logs(&self) -> Vec<LogId> {
        let mut logs: Vec<LogId> = self.boxes.iter().map(|log_box| log_box.log).collect();
        logs.dedup();
        logs
    }

    /// Returns the indices of the logs that saw the object, each once, growing.
    pub(crate) fn log_indices(&self) -> Vec<usize> {
        let mut logs: Vec<usize> = self.seen_on.iter().map(|(log, _)| *log).collect();
        logs.sort_unstable();
        logs.dedup();
        logs
    }

    /// Returns the index of the log of the sighting that the height is from; `None` without a
    /// height.
    pub(crate) fn height_log(&self) -> Option<usize> {
        self.seen_on.get(self.height.source?.sighting).map(|(log, _)| *log)
    }

    /// Counts the passes of the boat in these logs that covered the place of the object, and those
    /// that saw it. This reads the navigation of all pings.
    pub fn passes(&self, logs: &[PassLog<'_>]) -> PassCount {
        PassCount::new(&self.seen_on, self.place_m, logs)
    }
}

fn state(boxes: impl Iterator<Item = State> + Clone) -> ObjectState {
    match (boxes.clone().any(State::is_object), boxes.clone().any(|state| state == State::Proposed))
    {
        (true, _) => ObjectState::Accepted,
        (false, true) => ObjectState::Undecided,
        (false, false) => ObjectState::Rejected,
    }
}

/// Returns the index of the box that measures the size best. An accepted box is preferred to an
/// undecided one, then a box whose edges were drawn to another, then the higher score, where a box
/// drawn by hand counts as 1. Among equals the first is returned.
fn best<'a>(boxes: impl Iterator<Item = &'a ObjectBox>) -> usize {
    let rank = |object_box: &ObjectBox| {
        let is_drawn = matches!(object_box.one.extent, ObjectExtent::Drawn { .. });
        (object_box.one.state.is_object(), is_drawn, object_box.one.score.unwrap_or(1.0))
    };
    let ranked = boxes.map(rank).enumerate();
    let better = |best: (usize, (bool, bool, f32)), other: (usize, (bool, bool, f32))| {
        if other.1 > best.1 { other } else { best }
    };
    ranked.reduce(better).map_or(0, |(place, _)| place)
}
