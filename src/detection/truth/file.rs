//! Truth from files. What is read may come from anywhere: every number is checked before it is believed.

use super::Truth;
use crate::detection::dataset::Known;
use crate::detection::review::Review;
use crate::detection::{Mark, ObjectExtent, class_index};
use crate::survey::{Identity, Side};
use csv::StringRecord;

/// More sightings than any survey holds.
const MOST_OBJECTS: usize = 200_000;
/// More classes than any detector of this kind knows.
const MOST_CLASSES: usize = 1_000;

/// A file that does not describe the open survey.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct TruthError(String);

impl Truth {
    /// Reads the table of objects that `bathyscope simulate` writes, or the review of the log `of` (its accepted and added
    /// boxes).
    ///
    /// # Errors
    /// A sentence when the text is neither, when a line makes no sense, or when it belongs to another log.
    pub fn parse(text: &str, of: &Identity) -> Result<Self, TruthError> {
        if text.trim_start().starts_with('{') {
            let review =
                Review::from_json(text, of).map_err(|error| TruthError(error.to_string()))?;
            return Ok(Self::from_review(&review));
        }
        from_table(text, of.pings)
    }

    /// The accepted and added boxes of a review, without its points.
    pub fn from_review(review: &Review) -> Self {
        // Of a point nobody knows the box.
        let objects = (review.boxes())
            .filter(|one| one.state.is_object() && one.extent != ObjectExtent::Point);
        Self {
            classes: review.classes().to_vec(),
            objects: objects
                .map(|one| Known {
                    class: one.class,
                    whole: one.mark.clone(),
                    shown: true,
                    slices: Vec::new(),
                })
                .collect(),
            was_seen: true,
        }
    }
}

/// Where the table keeps what is read.
struct Columns {
    kind: usize,
    side: usize,
    /// First ping, last ping, near and far edge of the box around what is shown of echo and shadow.
    whole: [usize; 4],
    shown: usize,
}

impl Columns {
    fn of(header: &StringRecord) -> Result<Self, TruthError> {
        let column = |name: &str| {
            let found = header.iter().position(|field| field.trim() == name);
            found.ok_or_else(|| {
                TruthError(format!(
                    "there is no column `{name}`; truth is a table of objects as `bathyscope simulate` writes it, or a review"
                ))
            })
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

fn from_table(text: &str, pings: usize) -> Result<Truth, TruthError> {
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let broken = |error: csv::Error| TruthError(format!("the table of objects is broken: {error}"));
    let columns = Columns::of(table.headers().map_err(broken)?)?;
    let mut truth = Truth {
        classes: Vec::new(),
        objects: Vec::new(),
        was_seen: false,
    };
    for (index, record) in table.records().enumerate() {
        let record = record.map_err(broken)?;
        // An object that no pass insonified has no side.
        if record.get(columns.side).is_none_or(str::is_empty) {
            continue;
        }
        let known = known(&record, &columns, pings, &mut truth.classes)
            .map_err(|what| TruthError(format!("cannot use line {}: {what}", index + 2)))?;
        truth.objects.push(known);
        if truth.objects.len() > MOST_OBJECTS || truth.classes.len() > MOST_CLASSES {
            return Err(TruthError(format!(
                "at most {MOST_OBJECTS} sightings of {MOST_CLASSES} kinds are read"
            )));
        }
    }
    Ok(truth)
}

fn known(
    record: &StringRecord,
    columns: &Columns,
    pings: usize,
    classes: &mut Vec<String>,
) -> Result<Known, String> {
    let field = |column: usize| record.get(column).unwrap_or_default().trim();
    let metres = |column: usize| {
        let value = field(column).parse().ok();
        value
            .filter(|metres: &f64| metres.is_finite() && *metres >= 0.0)
            .ok_or_else(|| format!("`{}` is no range in metres", field(column)))
    };
    let ping = |column: usize| {
        let value = field(column).parse::<usize>();
        value.map_err(|_| format!("`{}` is no ping", field(column)))
    };
    let side = Side::BOTH
        .into_iter()
        .find(|side| side.name() == field(columns.side))
        .ok_or_else(|| format!("`{}` is no side", field(columns.side)))?;
    let [first, last, box_near, box_far] = columns.whole;
    let (first, last) = (ping(first)?, ping(last)?);
    if last >= pings {
        return Err(format!(
            "ping {last} is beyond the {pings} of the open log; this is the truth of another"
        ));
    }
    let (near_m, far_m) = (metres(box_near)?, metres(box_far)?);
    if first > last || near_m >= far_m {
        return Err("the object is inside out".to_owned());
    }
    let shown = match field(columns.shown) {
        "0" => false,
        "1" => true,
        other => return Err(format!("`{other}` in `shown` is neither 0 nor 1")),
    };
    Ok(Known {
        class: class_index(classes, field(columns.kind)),
        whole: Mark {
            side,
            pings: first..last + 1,
            near_m,
            far_m,
        },
        shown,
        slices: Vec::new(),
    })
}
