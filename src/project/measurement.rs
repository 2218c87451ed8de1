//! What was measured on the map.

use crate::geo::{LonLat, area_m2, distance_m};
use serde::{Deserialize, Serialize};

/// What a line was drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeasurementKind {
    /// Length along a line.
    Distance,
    /// Area of a polygon.
    Area,
    /// Depths along a line.
    Profile,
}

impl MeasurementKind {
    /// `distance`, `area` or `profile`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Distance => "distance",
            Self::Area => "area",
            Self::Profile => "profile",
        }
    }

    /// Corners that there is something to measure between.
    fn least_corners(self) -> usize {
        match self {
            Self::Distance | Self::Profile => 2,
            Self::Area => 3,
        }
    }
}

/// A line that was drawn to measure. What it measures follows from it, so only the line is kept. It is kept as positions, so that it
/// stays on its ground when the plane of the survey changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// What it was drawn for.
    pub kind: MeasurementKind,
    /// Its corners in the order of drawing; an area is closed from the last to the first.
    pub corners: Vec<LonLat>,
    /// The analyst's remark.
    pub note: String,
}

impl Measurement {
    /// Metres along the line from its start to each of its corners, on the ellipsoid.
    pub fn distances_m(&self) -> Vec<f64> {
        let legs = self.corners.windows(2).scan(0.0, |sum_m, leg| {
            *sum_m += distance_m(leg[0], leg[1]);
            Some(*sum_m)
        });
        let start = self.corners.first().map(|_| 0.0);
        start.into_iter().chain(legs).collect()
    }

    /// Metres along the line; around an area.
    pub fn length_m(&self) -> f64 {
        let along_m = self.distances_m().last().copied().unwrap_or(0.0);
        match (self.kind, self.corners.first(), self.corners.last()) {
            (MeasurementKind::Area, Some(first), Some(last)) => along_m + distance_m(*last, *first),
            _ => along_m,
        }
    }

    /// Square metres of an area, on the ellipsoid.
    pub fn area_m2(&self) -> f64 {
        area_m2(&self.corners)
    }

    /// The measurement with one more corner.
    pub fn with(&self, corner: LonLat) -> Self {
        let corners = self.corners.iter().copied().chain([corner]);
        Self {
            corners: corners.collect(),
            ..self.clone()
        }
    }

    /// Whether there is something between its corners.
    pub fn is_measurable(&self) -> bool {
        self.corners.len() >= self.kind.least_corners()
    }
}

/// A measurement as the file keeps it.
#[derive(Serialize, Deserialize)]
pub(super) struct MeasurementRow {
    kind: MeasurementKind,
    /// Longitude and latitude, degrees.
    corners: Vec<[f64; 2]>,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    note: String,
}

impl MeasurementRow {
    /// The fields of a row.
    pub const FIELDS: [&str; 3] = ["corners", "kind", "note"];

    pub fn of(measurement: &Measurement) -> Self {
        let corners = measurement.corners.iter();
        Self {
            kind: measurement.kind,
            corners: corners.map(|at| [at.lon_deg, at.lat_deg]).collect(),
            note: measurement.note.clone(),
        }
    }

    /// The measurement; the error says what no map has.
    ///
    /// # Errors
    /// What no map has.
    pub fn read(self) -> Result<Measurement, &'static str> {
        let corners = self.corners.into_iter();
        let corners = corners.map(|[lon_deg, lat_deg]| LonLat { lon_deg, lat_deg });
        let corners: Vec<LonLat> = corners.collect();
        if !corners.iter().all(LonLat::is_on_earth) {
            return Err("corners are longitude and latitude in degrees");
        }
        Ok(Measurement {
            kind: self.kind,
            corners,
            note: self.note,
        })
    }
}
