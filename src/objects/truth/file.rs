//! Reads the truth from files. A file may be of unknown origin, so every number in it is checked
//! before it is used.

use super::SurveyTruth;
use crate::dataset::KnownObject;
use crate::labels::MOST_CLASSES;
use crate::review::{LARGEST_FILE, Review, ReviewError};
use crate::{Mark, ObjectExtent, class_index};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::{Identity, Side};
use csv::StringRecord;
use std::io;
use std::path::Path;

/// Greatest number of sightings: more than any survey holds.
const MOST_OBJECTS: usize = 200_000;

/// Reason why a file cannot be used as the truth about the open survey, in a sentence without the
/// path.
#[derive(Debug, thiserror::Error)]
pub enum TruthError {
    /// The file could not be read from the disk.
    #[error("cannot read the truth: {0}")]
    NotRead(io::Error),
    /// The file is a review that cannot be read, or a review of another log.
    #[error(transparent)]
    Review(#[from] ReviewError),
    /// The file is no valid CSV.
    #[error("the table of objects is broken: {0}")]
    NotATable(#[from] csv::Error),
    /// The table has no column of this name.
    #[error(
        "there is no column `{0}`; truth is a table of objects as `bathyscope simulate` writes it, or a review"
    )]
    NoColumn(&'static str),
    /// A line is no valid sighting.
    #[error("cannot use line {line}: {what}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// The fault.
        what: String,
    },
    /// The table has more lines or kinds than any survey.
    #[error("at most {MOST_OBJECTS} sightings of {MOST_CLASSES} kinds are read")]
    TooMany,
}

impl SurveyTruth {
    /// Reads the truth about the log `of` from a file.
    ///
    /// # Errors
    /// When the file cannot be read, or as [`SurveyTruth::parse`].
    pub fn read(path: &Path, of: &Identity) -> Result<Self, FileError<TruthError>> {
        let text = regular_file::read_text(path, LARGEST_FILE).map_err(TruthError::NotRead);
        text.and_then(|text| Self::parse(&text, of)).map_err(FileError::at(path))
    }

    /// Parses the table of objects that `bathyscope simulate` writes, or the review of the log `of`
    /// (its accepted and added boxes).
    ///
    /// # Errors
    /// When the text is neither of the two, when a line is invalid, or when it belongs to another
    /// log.
    pub fn parse(text: &str, of: &Identity) -> Result<Self, TruthError> {
        if text.trim_start().starts_with('{') {
            return Ok(Self::from_review(&Review::from_json(text, of)?));
        }
        from_table(text, of.pings)
    }

    /// Creates the truth from the accepted and added boxes of a review, without its points.
    pub(crate) fn from_review(review: &Review) -> Self {
        // The box around the object at a point is unknown.
        let objects = (review.boxes()).filter(|review_box| {
            review_box.state.is_object() && review_box.extent != ObjectExtent::Point
        });
        Self {
            classes: review.classes().to_vec(),
            objects: objects
                .map(|review_box| KnownObject {
                    class: review_box.class,
                    whole: review_box.mark.clone(),
                    shown: true,
                    slices: Vec::new(),
                })
                .collect(),
            was_seen: true,
        }
    }
}

/// Indices of the columns of the table that are read.
struct Columns {
    kind: usize,
    side: usize,
    /// First ping, last ping, near and far edge of the box around the visible part of echo and
    /// shadow.
    whole: [usize; 4],
    shown: usize,
}

impl Columns {
    fn of(header: &StringRecord) -> Result<Self, TruthError> {
        let column = |name: &'static str| {
            let found = header.iter().position(|field| field.trim() == name);
            found.ok_or(TruthError::NoColumn(name))
        };
        Ok(Self {
            kind: column("kind")?,
            side: column("side")?,
            whole: [
                column("box_first_ping")?,
                column("box_last_ping")?,
                column("box_near_m")?,
                column("box_far_m")?,
            ],
            shown: column("shown")?,
        })
    }
}

fn from_table(text: &str, pings: usize) -> Result<SurveyTruth, TruthError> {
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let columns = Columns::of(table.headers()?)?;
    let mut truth = SurveyTruth { classes: Vec::new(), objects: Vec::new(), was_seen: false };
    for (index, record) in table.records().enumerate() {
        let record = record?;
        // An object that no pass insonified has no side in the table.
        if record.get(columns.side).is_none_or(str::is_empty) {
            continue;
        }
        let known = known(&record, index + 2, &columns, pings, &mut truth.classes)?;
        truth.objects.push(known);
        if truth.objects.len() > MOST_OBJECTS || truth.classes.len() > MOST_CLASSES {
            return Err(TruthError::TooMany);
        }
    }
    Ok(truth)
}

fn known(
    record: &StringRecord,
    line: usize,
    columns: &Columns,
    pings: usize,
    classes: &mut Vec<String>,
) -> Result<KnownObject, TruthError> {
    let fault = |what: String| TruthError::Line { line, what };
    let field = |column: usize| record.get(column).unwrap_or_default().trim();
    let no = |column: usize, needed: &str| fault(format!("`{}` is no {needed}", field(column)));
    let metres = |column: usize| {
        let value = field(column).parse().ok();
        value
            .filter(|metres: &f64| metres.is_finite() && *metres >= 0.0)
            .ok_or_else(|| no(column, "range in metres"))
    };
    let ping = |column: usize| {
        let value = field(column).parse::<usize>();
        value.map_err(|_| no(column, "ping"))
    };
    let side = Side::BOTH
        .into_iter()
        .find(|side| side.name() == field(columns.side))
        .ok_or_else(|| no(columns.side, "side"))?;
    let [first, last, box_near, box_far] = columns.whole;
    let (first, last) = (ping(first)?, ping(last)?);
    if last >= pings {
        return Err(fault(format!(
            "ping {last} is beyond the {pings} of the open log; this is the truth of another"
        )));
    }
    let (near_m, far_m) = (metres(box_near)?, metres(box_far)?);
    if first > last || near_m >= far_m {
        return Err(fault("the object is inside out".to_owned()));
    }
    let shown = match field(columns.shown) {
        "0" => false,
        "1" => true,
        other => return Err(fault(format!("`{other}` in `shown` is neither 0 nor 1"))),
    };
    Ok(KnownObject {
        class: class_index(classes, field(columns.kind)),
        whole: Mark::new(side, first..last + 1, [near_m, far_m]),
        shown,
        slices: Vec::new(),
    })
}
