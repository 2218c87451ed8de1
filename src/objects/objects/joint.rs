//! Objects over all logs of a survey: what several logs saw of one object is one.

use crate::targets::{
    GroupSettings, LogPings, ObjectHeight, PassCount, PassLog, Sighting, Target, count_seen, group,
};
use crate::{NAMELESS_CLASS, class_index};

/// A box of a log with its place.
#[derive(Clone, Copy, Debug)]
pub struct PlacedBox<'a> {
    /// Which log of the survey it is of.
    pub log: usize,
    /// What it is taken for. Every log may have a list of classes of its own, so classes are
    /// compared by name.
    pub class: &'a str,
    /// Confidence of the detector, 0 to 1; `None` for a box that was drawn by hand: who drew it was
    /// sure.
    pub score: Option<f32>,
    /// Where it lies, in the plane that all logs share.
    pub target: &'a Target,
}

/// An object with all that was seen of it.
#[derive(Clone, Debug, PartialEq)]
pub struct JointObject {
    /// Indices of its boxes, growing.
    pub members: Vec<usize>,
    /// The class with the largest sum of scores, of the boxes that have a name.
    pub class: String,
    /// Mean of the places, weighted by their certainty: metres east and north in the plane.
    pub place_m: [f64; 2],
    /// Standard deviation of that place in the worse direction, metres.
    pub sigma_m: f64,
    /// Its height above the bottom, of all boxes together: the one height that every table and
    /// panel shows.
    pub height: ObjectHeight,
    /// The pings of each box.
    seen_on: Vec<LogPings>,
}

impl JointObject {
    /// The logs that saw it, as the boxes count them, each once.
    pub fn logs(&self) -> Vec<usize> {
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

    /// How many passes of the boat saw it; `logs` are those that the boxes count.
    pub fn sightings(&self, logs: &[PassLog<'_>]) -> usize {
        count_seen(self.seen_on.iter().cloned(), logs)
    }

    /// How many passes of the boat saw it, of those over these logs that covered its place. It goes
    /// through all pings.
    pub fn passes(&self, logs: &[PassLog<'_>]) -> PassCount {
        PassCount::new(&self.seen_on, self.place_m, logs)
    }
}

/// Joins the boxes that show one object, in one log or in several; between logs with less certain
/// places ([`GroupSettings::log_sigma_m`]). By first box.
pub fn joint_objects(boxes: &[PlacedBox<'_>], settings: &GroupSettings) -> Vec<JointObject> {
    let mut names = Vec::new();
    let sightings: Vec<Sighting<'_>> = boxes
        .iter()
        .map(|one| Sighting {
            log: one.log,
            target: one.target,
            class: (one.class != NAMELESS_CLASS).then(|| class_index(&mut names, one.class)),
            score: one.score.map_or(1.0, f64::from),
        })
        .collect();
    let groups = group(&sightings, settings).into_iter();
    groups
        .map(|group| JointObject {
            seen_on: (group.members.iter())
                .map(|member| (boxes[*member].log, boxes[*member].target.mark.pings.clone()))
                .collect(),
            class: (group.class).map_or(NAMELESS_CLASS, |class| &names[class]).to_owned(),
            place_m: [group.east_m, group.north_m],
            sigma_m: group.sigma_m,
            height: group.height,
            members: group.members,
        })
        .collect()
}
