//! Defines measurements on the map and in the waterfall.

use bathyscope_log::support::geo::{LonLat, area_m2, distance_m};
use bathyscope_log::survey::{Identity, Side, Survey};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Kind of a measurement: the quantity for which its line was drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeasurementKind {
    /// Length along a line.
    Distance,
    /// Area of a polygon.
    Area,
    /// Depths along a line.
    Profile,
    /// Height of an object that casts a shadow in the waterfall, from its top to the end of the
    /// shadow.
    Height,
}

impl MeasurementKind {
    /// Returns the name: `distance`, `area`, `profile` or `height`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Distance => "distance",
            Self::Area => "area",
            Self::Profile => "profile",
            Self::Height => "height",
        }
    }
}

/// Place in a log's side-scan at which a corner was set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pick {
    /// Log of the picked place.
    pub log: Identity,
    /// Side of the picked place.
    pub side: Side,
    /// Side-scan ping of the picked place.
    pub ping: usize,
    /// Slant range on the recorder's scale, metres.
    pub slant_m: f64,
}

impl Pick {
    /// Returns the side of the picked place in a log: the other side if the sides were exchanged
    /// when it was picked and are not now, or the reverse.
    pub fn side_in(&self, survey: &Survey) -> Side {
        if self.log.swapped_sides == survey.swapped_sides { self.side } else { self.side.other() }
    }
}

/// Line that was drawn to measure a quantity. The quantity follows from the line, so only the line
/// is stored, as positions, so that it stays at its place on the ground when the plane of the
/// survey changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Kind of the measurement.
    pub kind: MeasurementKind,
    /// Corners in the order of drawing; an area is closed from the last to the first.
    pub corners: Vec<LonLat>,
    /// Places in the side-scan at which corners were set, by the index of the corner from 0; a
    /// corner that was set on the map has no entry. Both corners of a height have one.
    pub picks: BTreeMap<usize, Pick>,
    /// Analyst's remark.
    pub note: String,
}

impl Measurement {
    /// Creates a measurement without corners.
    pub fn new(kind: MeasurementKind) -> Self {
        Self { kind, corners: Vec::new(), picks: BTreeMap::new(), note: String::new() }
    }

    /// Returns the distances along the line from its start to each of its corners, on the
    /// ellipsoid, metres.
    pub fn distances_m(&self) -> Vec<f64> {
        let legs = self.corners.windows(2).scan(0.0, |sum_m, leg| {
            *sum_m += distance_m(leg[0], leg[1]);
            Some(*sum_m)
        });
        let start = self.corners.first().map(|_| 0.0);
        start.into_iter().chain(legs).collect()
    }

    /// Returns the length of the line, or the perimeter of an area, metres.
    pub fn length_m(&self) -> f64 {
        let along_m = self.distances_m().last().copied().unwrap_or(0.0);
        match (self.kind, self.corners.first(), self.corners.last()) {
            (MeasurementKind::Area, Some(first), Some(last)) => along_m + distance_m(*last, *first),
            _ => along_m,
        }
    }

    /// Returns the area on the ellipsoid, square metres.
    pub fn area_m2(&self) -> f64 {
        area_m2(&self.corners)
    }

    /// Returns the measurement with one more corner; `pick` is its place in the side-scan if it was
    /// set there.
    pub fn with(&self, corner: LonLat, pick: Option<Pick>) -> Self {
        let mut longer = self.clone();
        longer.picks.extend(pick.map(|pick| (longer.corners.len(), pick)));
        longer.corners.push(corner);
        longer
    }

    /// Returns the measurement without its last corner.
    pub fn without_last(&self) -> Self {
        let mut shorter = self.clone();
        shorter.corners.pop();
        let kept = shorter.corners.len();
        shorter.picks.retain(|corner, _| *corner < kept);
        shorter
    }

    /// Returns the side and ping of a shadow, and the slant ranges of both its ends on the
    /// recorder's scale, metres; `None` if the measurement is not a height with both ends.
    pub fn shadow(&self) -> Option<(&Pick, [f64; 2])> {
        let [top, end] = [0, 1].map(|corner| self.picks.get(&corner));
        let (top, end) = top.zip(end).filter(|_| self.kind == MeasurementKind::Height)?;
        Some((top, [top.slant_m, end.slant_m]))
    }

    /// Returns true if there are enough corners to measure the quantity.
    pub fn is_measurable(&self) -> bool {
        let least = if self.kind == MeasurementKind::Area { 3 } else { 2 };
        self.corners.len() >= least
    }
}

/// Measurement as stored in the file.
#[derive(Serialize, Deserialize)]
pub(super) struct MeasurementRow {
    kind: MeasurementKind,
    /// Longitude and latitude, degrees.
    corners: Vec<[f64; 2]>,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    note: String,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    picks: Vec<PickRow>,
}

/// [`Pick`] with the index of its corner.
#[derive(Serialize, Deserialize)]
struct PickRow {
    corner: usize,
    #[serde(flatten)]
    pick: Pick,
}

impl MeasurementRow {
    /// Names of the fields of a row.
    pub(super) const FIELDS: [&str; 4] = ["corners", "kind", "note", "picks"];

    pub(super) fn of(measurement: &Measurement) -> Self {
        let corners = measurement.corners.iter();
        let picks = measurement.picks.clone().into_iter();
        Self {
            kind: measurement.kind,
            corners: corners.map(|at| [at.lon_deg, at.lat_deg]).collect(),
            note: measurement.note.clone(),
            picks: picks.map(|(corner, pick)| PickRow { corner, pick }).collect(),
        }
    }

    /// Converts the row to a measurement.
    ///
    /// # Errors
    /// A sentence on the rule that the row breaks, when a corner is not on the earth or a pick is
    /// not valid.
    pub(super) fn read(self) -> Result<Measurement, &'static str> {
        let corners = self.corners.into_iter();
        let corners = corners.map(|[lon_deg, lat_deg]| LonLat { lon_deg, lat_deg });
        let corners: Vec<LonLat> = corners.collect();
        if !corners.iter().all(LonLat::is_on_earth) {
            return Err("corners are longitude and latitude in degrees");
        }
        let picks = self.picks.into_iter();
        let picks: BTreeMap<usize, Pick> = picks.map(|row| (row.corner, row.pick)).collect();
        let is_pick = |(corner, pick): (&usize, &Pick)| {
            *corner < corners.len() && pick.slant_m.is_finite() && pick.slant_m >= 0.0
        };
        if !picks.iter().all(is_pick) {
            return Err("picks are corners with their ping, side and slant range");
        }
        if self.kind == MeasurementKind::Height && (corners.len() != 2 || picks.len() != 2) {
            return Err("a height has two corners with their picks");
        }
        Ok(Measurement { kind: self.kind, corners, picks, note: self.note })
    }
}
