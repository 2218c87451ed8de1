//! An object: what all its sightings say of it; and its boxes.

use super::{LogBox, LogId};
use crate::ObjectExtent;
use crate::review::{Certainty, Reviewed, State};
use crate::targets::{Group, LogPings, ObjectHeight, PassCount, PassLog, Target, count_seen};
use bathyscope_log::named;
use bathyscope_log::support::geo::LonLat;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A box with its place, and the object that it is a sighting of.
#[derive(Clone, Debug)]
pub struct ObjectBox {
    /// Index of its log in the survey.
    pub log: usize,
    /// Its log and its number there.
    pub key: LogBox,
    /// The box, and what was decided about it.
    pub one: Arc<Reviewed>,
    /// Name of its class.
    pub class: String,
    /// Its place in the world; `None` where that cannot be known.
    pub target: Option<Target>,
    /// Number of the object that it is a sighting of; `None` without a place.
    pub object: Option<u32>,
    /// The filter by score has it out of sight. It counts as a sighting all the same.
    pub is_hidden: bool,
}

/// The decision about an object, in the order of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ObjectState {
    /// No decision has been made.
    Undecided,
    /// There is an object: one of its boxes was accepted or drawn by hand. Further boxes that a
    /// search finds of it, or that a filter hides, do not open the question again.
    Accepted,
    /// There is nothing: all its boxes were rejected.
    Rejected,
}

named! {
    /// All of them, in the order of the work.
    pub ObjectState {
        Undecided: "undecided",
        Accepted: "accepted",
        Rejected: "rejected",
    }
}

/// An object on the bottom with the boxes that show it. Lengths in metres; NaN for what is not
/// known.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its number, never given to another object.
    pub number: u32,
    /// The boxes that show it, by log and number.
    pub boxes: Vec<LogBox>,
    /// The places of these in the list of boxes, growing.
    pub members: Vec<usize>,
    /// Name that the analyst gave: that of the first box that has one; empty where none has.
    pub name: String,
    /// The class with the largest sum of scores, of the boxes that have a name.
    pub class: String,
    /// The decision about it.
    pub state: ObjectState,
    /// The highest score of the detector; `None` where nobody but the analyst saw it.
    pub score: Option<f32>,
    /// The certainty of the analyst: the surest word of its boxes.
    pub certainty: Option<Certainty>,
    /// Mean of the places, weighted by the inverse of their covariances: metres east and north in
    /// the plane of the survey.
    pub place_m: [f64; 2],
    /// The same in the world.
    pub position: LonLat,
    /// Standard deviation of that place in the worse direction.
    pub sigma_m: f64,
    /// Place among its boxes of the one that tells its size best.
    pub best: usize,
    /// Its length along the track by that box.
    pub length_m: f64,
    /// Its width across the track by that box.
    pub width_m: f64,
    /// Its height above the bottom, of all boxes together.
    pub height: ObjectHeight,
    /// Depth of the bottom there by the box that tells its size best.
    pub depth_m: f64,
    /// Course of the boat over ground at that box, radians clockwise from north.
    pub course_rad: f64,
    /// Passes of the boat that saw it: at most as many as boxes, since both sides may see it in one
    /// pass, and two recorders too.
    pub sightings: usize,
    /// Remarks on its boxes, one after the other.
    pub remarks: String,
    /// The pings of each box.
    seen_on: Vec<LogPings>,
}

impl Object {
    /// The object of a group of boxes of a list; `names` are those of the classes of the group. It
    /// has no number yet. `None` without logs.
    pub(super) fn new(
        group: Group,
        names: &[&str],
        boxes: &[ObjectBox],
        logs: &[PassLog<'_>],
    ) -> Option<Self> {
        let (survey, navigation) = logs.first()?;
        let shown = || group.members.iter().filter_map(|member| boxes.get(*member));
        let said = || shown().map(|one| &*one.one);
        let best = best(shown());
        let target = shown().nth(best).and_then(|one| one.target.as_ref());
        let seen_on: Vec<LogPings> =
            shown().map(|one| (one.log, one.one.mark.pings.clone())).collect();
        let remarks: Vec<&str> =
            said().map(|one| one.note.as_str()).filter(|note| !note.is_empty()).collect();
        let name = said().map(|one| &one.name).find(|name| !name.is_empty());
        Some(Self {
            number: 0,
            boxes: shown().map(|one| one.key).collect(),
            name: name.cloned().unwrap_or_default(),
            class: group.class.map_or(crate::NAMELESS_CLASS, |class| names[class]).to_owned(),
            state: state(said().map(|one| one.state)),
            score: said().filter_map(|one| one.score).max_by(f32::total_cmp),
            certainty: said().filter_map(|one| one.certainty).max(),
            place_m: [group.east_m, group.north_m],
            position: navigation.to_lon_lat(&survey.track, group.east_m, group.north_m),
            sigma_m: group.sigma_m,
            best,
            length_m: target.map_or(f64::NAN, |target| target.length_m),
            width_m: target.map_or(f64::NAN, |target| target.width_m),
            height: group.height,
            depth_m: target.map_or(f64::NAN, |target| target.depth_m),
            course_rad: target.map_or(f64::NAN, |target| target.heading_rad),
            sightings: count_seen(seen_on.iter().cloned(), logs),
            remarks: remarks.join("; "),
            seen_on,
            members: group.members,
        })
    }

    /// The logs that saw it, in the order of the survey.
    pub fn logs(&self) -> Vec<LogId> {
        let mut logs: Vec<LogId> = self.boxes.iter().map(|one| one.log).collect();
        logs.dedup();
        logs
    }

    /// The logs that saw it, as the boxes count them, each once.
    pub(crate) fn log_indices(&self) -> Vec<usize> {
        let mut logs: Vec<usize> = self.seen_on.iter().map(|(log, _)| *log).collect();
        logs.sort_unstable();
        logs.dedup();
        logs
    }

    /// The log of the sighting that the height rests on, as the boxes count them; `None` without a
    /// height.
    pub(crate) fn height_log(&self) -> Option<usize> {
        let (log, _) = self.seen_on.get(self.height.source?.sighting)?;
        Some(*log)
    }

    /// Counts the passes of the boat over these logs that covered its place, and those that saw it.
    /// It goes through all pings.
    pub fn passes(&self, logs: &[PassLog<'_>]) -> PassCount {
        PassCount::new(&self.seen_on, self.place_m, logs)
    }
}

fn state(boxes: impl Iterator<Item = State> + Clone) -> ObjectState {
    match (boxes.clone().any(State::is_object), boxes.clone().any(|one| one == State::Proposed)) {
        (true, _) => ObjectState::Accepted,
        (false, true) => ObjectState::Undecided,
        (false, false) => ObjectState::Rejected,
    }
}

/// The place of the box that tells the size best: an accepted one before an undecided one, one
/// whose edges were drawn before another, and then the surest, who drew one being sure. Of equals
/// the first.
fn best<'a>(boxes: impl Iterator<Item = &'a ObjectBox>) -> usize {
    let rank = |one: &ObjectBox| {
        let is_drawn = matches!(one.one.extent, ObjectExtent::Drawn { .. });
        (one.one.state.is_object(), is_drawn, one.one.score.unwrap_or(1.0))
    };
    let ranked = boxes.map(rank).enumerate();
    let better = |best: (usize, (bool, bool, f32)), other: (usize, (bool, bool, f32))| {
        if other.1 > best.1 { other } else { best }
    };
    ranked.reduce(better).map_or(0, |(place, _)| place)
}
