//! Defines the columns of the table of objects. CSV, GeoJSON, GeoPackage, waypoints, placemarks,
//! report, window and manual are made from this one table.

use super::{Object, ObjectState};
use crate::review::Certainty;
use crate::targets::FittedShape;
use bathyscope_log::support::geo::LonLat;

/// An object with the further data that a row of the table needs.
#[derive(Clone, Copy, Debug)]
pub struct ListedObject<'a> {
    /// The object.
    pub object: &'a Object,
    /// Solid that fits the object; `None` if none fits.
    pub shape: Option<&'a FittedShape>,
    /// Corners of its footprint: length along the track by width across it, from the sighting that
    /// measures the size best; `None` if the size is not known.
    pub outline: Option<[LonLat; 4]>,
    /// Names of the logs of the survey; empty for a survey of one log.
    pub log_names: &'a [String],
}

impl<'a> ListedObject<'a> {
    /// Returns the source of the height in words; empty without a height.
    pub fn height_source(&self) -> String {
        let log = self.object.height_log().and_then(|log| self.log_names.get(log));
        self.object.height.source_in_words(log.map(String::as_str))
    }

    fn solid(&self, value: fn(&'a FittedShape) -> f64) -> f64 {
        self.shape.map_or(f64::NAN, value)
    }
}

/// The values of a column, one for each object.
#[derive(Clone, Copy, Debug)]
pub enum ColumnValues {
    /// Words; empty if unknown.
    Text(fn(&ListedObject<'_>) -> String),
    /// Whole numbers.
    Count(fn(&ListedObject<'_>) -> usize),
    /// Decimal numbers with this number of decimals; NaN if unknown.
    Number(usize, fn(&ListedObject<'_>) -> f64),
    /// Lengths, metres; NaN if unknown.
    Length(fn(&ListedObject<'_>) -> f64),
    /// Lengths and their standard deviations, metres: the window and the report show both in one
    /// column, files have a column for each.
    Measured(fn(&ListedObject<'_>) -> [f64; 2]),
    /// Decisions about the objects.
    State(fn(&ListedObject<'_>) -> ObjectState),
    /// Positions; in files, the column holds the latitude, and another column the longitude.
    Position(fn(&ListedObject<'_>) -> LonLat),
}

impl ColumnValues {
    /// Returns true for numbers, which are aligned at the right.
    pub fn is_number(&self) -> bool {
        matches!(self, Count(_) | Number(..) | Length(_) | Measured(_))
    }

    /// Returns true for lengths, whose unit is that of the window.
    pub fn is_length(&self) -> bool {
        matches!(self, Length(_) | Measured(_))
    }
}

/// Name of the column of logs; the window shows this column as the colours of the logs.
pub const LOGS_COLUMN: &str = "logs";
/// Decimals of lengths in files: millimetres.
const LENGTH_DECIMALS: usize = 3;
/// Decimals of degrees in files: about a millimetre.
const DEGREE_DECIMALS: usize = 8;

/// A column.
#[derive(Clone, Copy, Debug)]
pub struct ObjectColumn {
    /// Name of the column in files, with the unit.
    pub name: &'static str,
    /// Heading in the window and in the report, without a unit; empty for a column of files only.
    pub heading: &'static str,
    /// Values of the column.
    pub values: ColumnValues,
    /// Meaning of the values, in a sentence.
    pub meaning: &'static str,
}

/// The value of an object in a column.
#[derive(Clone, Debug, PartialEq)]
pub enum ColumnValue {
    /// Words.
    Text(String),
    /// A whole number.
    Count(usize),
    /// Decimal number with this number of decimals.
    Number(usize, f64),
}

impl ObjectColumn {
    /// Returns the columns of the window and the report for a number of logs; the column of logs is
    /// left out for one log. The columns of the position come last, since they are wide.
    pub fn shown(logs: usize) -> impl Iterator<Item = &'static Self> {
        let is_shown = move |column: &&Self| {
            !column.heading.is_empty() && (logs > 1 || column.name != LOGS_COLUMN)
        };
        let shown = move || OBJECT_COLUMNS.iter().filter(is_shown);
        let is_of_place = |column: &&Self| matches!(column.name, "lat" | "sigma_m");
        shown().filter(move |column| !is_of_place(column)).chain(shown().filter(is_of_place))
    }

    /// Returns the column with a name; `None` if there is none.
    pub fn named(name: &str) -> Option<&'static Self> {
        OBJECT_COLUMNS.iter().find(|column| column.name == name)
    }

    /// Returns the value of an object, rounded to the decimals of the column; `None` if it is not
    /// known.
    pub fn value(&self, of: &ListedObject<'_>) -> Option<ColumnValue> {
        let number = |value: f64, decimals: usize| {
            let scale = 10_f64.powi(decimals as i32);
            // The sum turns -0 into 0, which is written without a sign.
            let rounded = || ColumnValue::Number(decimals, (value * scale).round() / scale + 0.0);
            value.is_finite().then(rounded)
        };
        match self.values {
            Text(value) => Some(value(of)).filter(|words| !words.is_empty()).map(ColumnValue::Text),
            State(value) => Some(ColumnValue::Text(value(of).name().to_owned())),
            Count(value) => Some(ColumnValue::Count(value(of))),
            Number(decimals, value) => number(value(of), decimals),
            Length(value) => number(value(of), LENGTH_DECIMALS),
            Measured(value) => number(value(of)[0], LENGTH_DECIMALS),
            Position(value) => number(value(of).lat_deg, DEGREE_DECIMALS),
        }
    }

    /// Returns the value of an object as text; empty if it is not known.
    pub fn text(&self, of: &ListedObject<'_>) -> String {
        match self.value(of) {
            None => String::new(),
            Some(ColumnValue::Text(words)) => words,
            Some(ColumnValue::Count(count)) => count.to_string(),
            Some(ColumnValue::Number(decimals, value)) => format!("{value:.decimals$}"),
        }
    }
}

use ColumnValues::{Count, Length, Measured, Number, Position, State, Text};

/// Creates a column of the window, the report and all files.
const fn shown(
    name: &'static str,
    heading: &'static str,
    values: ColumnValues,
    meaning: &'static str,
) -> ObjectColumn {
    ObjectColumn { name, heading, values, meaning }
}

/// Creates a column of files only.
const fn filed(name: &'static str, values: ColumnValues, meaning: &'static str) -> ObjectColumn {
    ObjectColumn { name, heading: "", values, meaning }
}

/// All columns, in their order.
pub const OBJECT_COLUMNS: &[ObjectColumn] = &[
    shown(
        "number",
        "no.",
        Count(|of| of.object.number as usize),
        "Number of the object. It is given once, and kept through reviews, filters and exports.",
    ),
    shown("name", "name", Text(|of| of.object.name.clone()), "Name that the analyst gave."),
    shown(
        "class",
        "class",
        Text(|of| of.object.class.clone()),
        "Class with the largest sum of scores over the boxes of the object.",
    ),
    shown(
        "state",
        "state",
        State(|of| of.object.state),
        "Decision of the analyst: undecided, accepted or rejected.",
    ),
    shown(
        "score",
        "score",
        Number(4, |of| of.object.score.map_or(f64::NAN, f64::from)),
        "Highest score of the detector, 0 to 1; empty for an object drawn by hand.",
    ),
    shown(
        "certainty",
        "certainty",
        Text(|of| of.object.certainty.map_or("", Certainty::name).to_owned()),
        "Certainty of the analyst: unsure, probable or certain.",
    ),
    filed(
        "lon",
        Number(DEGREE_DECIMALS, |of| of.object.position.lon_deg),
        "Longitude, WGS84, degrees.",
    ),
    shown(
        "lat",
        "position",
        Position(|of| of.object.position),
        "Latitude, WGS84, degrees; the mean of its boxes, weighted by their covariances.",
    ),
    filed(
        "east_m",
        Length(|of| of.object.place_m[0]),
        "Metres east of the survey's origin, as in the cloud.",
    ),
    filed("north_m", Length(|of| of.object.place_m[1]), "Metres north of the survey's origin."),
    shown(
        "sigma_m",
        "within",
        Length(|of| of.object.sigma_m),
        "Standard deviation of the position in the worse direction, without the error of the receiver.",
    ),
    shown(
        "length_m",
        "length",
        Length(|of| of.object.length_m),
        "Length along the track, of the sighting that tells the size best.",
    ),
    shown(
        "width_m",
        "width",
        Length(|of| of.object.width_m),
        "Width across the track, of the same sighting.",
    ),
    shown(
        "height_m",
        "height",
        Measured(|of| [of.object.height.mean_m, of.object.height.sigma_m]),
        "Height above the bottom, from the shadows that agree with the surest one.",
    ),
    filed(
        "height_sigma_m",
        Length(|of| of.object.height.sigma_m),
        "Standard deviation of the height.",
    ),
    filed(
        "height_source",
        Text(|of| of.height_source()),
        "Sighting that the height rests on, and how many sightings contradict it.",
    ),
    shown("depth_m", "depth", Length(|of| of.object.depth_m), "Depth of the bottom at the object."),
    filed(
        "heading_deg",
        Number(0, |of| of.object.heading_rad.to_degrees().round().rem_euclid(360.0)),
        "Heading of the boat by `heading.source` at the sighting that tells the size best, degrees clockwise from north.",
    ),
    shown(
        "sightings",
        "seen",
        Count(|of| of.object.sightings),
        "Passes of the boat that saw the object.",
    ),
    filed("boxes", Count(|of| of.object.boxes.len()), "Boxes that show the object."),
    shown(
        LOGS_COLUMN,
        "logs",
        Text(|of| {
            let logs = of.object.log_indices().into_iter();
            let names: Vec<&str> =
                logs.filter_map(|log| of.log_names.get(log)).map(String::as_str).collect();
            names.join("; ")
        }),
        "Logs that saw the object; empty where the survey is one log.",
    ),
    filed(
        "shape",
        Text(|of| of.shape.map_or("", |shape| shape.posed.solid.kind.name()).to_owned()),
        "Kind of the solid that explains echo and shadow best: inferred, not measured.",
    ),
    filed(
        "shape_length_m",
        Number(2, |of| of.solid(|shape| shape.posed.solid.length_m)),
        "Length of the solid.",
    ),
    filed(
        "shape_width_m",
        Number(2, |of| of.solid(|shape| shape.posed.solid.width_m)),
        "Width of the solid.",
    ),
    filed(
        "shape_height_m",
        Number(2, |of| of.solid(|shape| shape.posed.solid.height_m)),
        "Height of the solid.",
    ),
    filed(
        "shape_heading_deg",
        Number(0, |of| of.solid(|shape| shape.posed.shown_heading_rad().to_degrees())),
        "Direction of the length of the solid, degrees clockwise from north.",
    ),
    filed(
        "shape_explained",
        Number(2, |of| of.solid(|shape| shape.explained)),
        "Share of the picture, beyond speckle, that the solid explains.",
    ),
    shown("remarks", "remarks", Text(|of| of.object.remarks.clone()), "Remarks on the boxes."),
];
