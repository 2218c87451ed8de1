//! Reads and writes a review as a JSON file. A file may be of unknown origin, so every number in it
//! is checked before it is used.

use super::{BoxId, Certainty, Review, Reviewed, State, held, is_name};
use crate::labels::MOST_CLASSES;
use crate::{Mark, MeasuredShadow, ObjectExtent};
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::{Identity, Side, Survey};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// Greatest size of a file of boxes that is read, bytes.
pub(crate) const LARGEST_FILE: u64 = 64 << 20;
/// Version of the layout of the file.
const VERSION: u32 = 1;
const MOST_BOXES: usize = 200_000;
/// Greatest number of searched stretches; a review written by this program has two or three.
const MOST_SEARCHED: usize = 1_000;
/// Greatest length of a note, characters.
const LONGEST_NOTE: usize = 10_000;

/// Error of a file that is no review, or a review of another log.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}")]
pub struct ReviewError {
    what: String,
    /// Number of the faulty box; `None` if the fault is elsewhere.
    pub id: Option<BoxId>,
}

impl ReviewError {
    fn new(what: impl Into<String>) -> Self {
        Self { what: what.into(), id: None }
    }
}

/// Contents of a review, row by row, for the files that hold it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReviewRows {
    /// Names of the classes.
    pub classes: Vec<String>,
    /// Pings that a model has searched.
    pub searched: Vec<SearchRow>,
    /// The boxes.
    pub boxes: Vec<BoxRow>,
}

#[derive(Serialize, Deserialize)]
struct Stored {
    version: u32,
    survey: Identity,
    classes: Vec<String>,
    /// Pings that a model has searched; missing in the file if they were not recorded.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    searched: Vec<SearchRow>,
    boxes: Vec<BoxRow>,
}

/// Pings that a model has searched, as stored in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchRow {
    /// Name of the model.
    pub model: String,
    /// First and last ping, the last excluded.
    pub pings: [usize; 2],
}

/// A box as stored in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoxRow {
    /// [`Reviewed::id`].
    pub id: BoxId,
    /// Side of the box.
    pub side: Side,
    /// First and last ping, the last excluded.
    pub pings: [usize; 2],
    /// Nearest slant range, metres.
    pub near_m: f64,
    /// Farthest slant range, metres.
    pub far_m: f64,
    /// Name of the class of the box.
    pub class: String,
    /// [`Reviewed::score`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub score: Option<f32>,
    /// [`Reviewed::state`].
    pub state: State,
    /// [`Reviewed::edited`].
    #[serde(default)]
    pub edited: bool,
    /// [`Reviewed::note`].
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// [`Reviewed::name`].
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// [`Reviewed::certainty`]; its key in files is `confidence`.
    #[serde(default, rename = "confidence", skip_serializing_if = "Option::is_none")]
    pub certainty: Option<Certainty>,
    /// Border between echo and shadow that the analyst has set, metres of slant range
    /// ([`ObjectExtent::Drawn`]); `None` if it is not set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub border_m: Option<f64>,
    /// [`Reviewed::shadow`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shadow: Option<MeasuredShadow>,
    /// True if the box is a point without size: [`ObjectExtent::Point`].
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub point: bool,
    /// [`Reviewed::model`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
}

/// Part of a file that identifies the log of the review.
#[derive(Deserialize)]
struct OfLog {
    survey: Identity,
}

/// Part of a file that holds the layout version, so that a newer file is distinguished from a
/// broken one.
#[derive(Deserialize)]
struct Versioned {
    version: u32,
}

impl Review {
    /// Returns the review as the text of a file.
    pub fn to_json(&self) -> String {
        let searched = self.searched.iter().map(|search| SearchRow {
            model: search.model.to_string(),
            pings: [search.pings.start, search.pings.end],
        });
        let stored = Stored {
            version: VERSION,
            survey: self.identity.clone(),
            classes: self.classes.clone(),
            searched: searched.collect(),
            boxes: self.boxes().map(|review_box| self.row(review_box)).collect(),
        };
        // All values are strings, whole numbers and finite numbers, so writing cannot fail.
        serde_json::to_string_pretty(&stored).unwrap_or_default()
    }

    /// Returns the row of a box of this review.
    pub fn row(&self, review_box: &Reviewed) -> BoxRow {
        BoxRow {
            id: review_box.id,
            side: review_box.mark.side,
            pings: [review_box.mark.pings.start, review_box.mark.pings.end],
            near_m: review_box.mark.near_m,
            far_m: review_box.mark.far_m,
            class: self.class_name(review_box.class).to_owned(),
            score: review_box.score,
            state: review_box.state,
            edited: review_box.edited,
            note: review_box.note.clone(),
            name: review_box.name.clone(),
            certainty: review_box.certainty,
            border_m: review_box.extent.border_m(),
            shadow: review_box.shadow,
            point: review_box.extent == ObjectExtent::Point,
            model: review_box.model.as_deref().map(str::to_owned),
        }
    }

    /// Reads the review of an open log from a file. The log may have grown since the file was
    /// written.
    ///
    /// # Errors
    /// When the file cannot be read, or as [`Review::from_json`]; the error holds the path.
    pub fn open_for(path: &Path, survey: &Survey) -> Result<Self, ReviewError> {
        let own = Identity::of(survey);
        let text = regular_file::read_text(path, LARGEST_FILE).map_err(|error| {
            ReviewError::new(format!("cannot read the review: {error}: {}", path.display()))
        })?;
        let of: Option<OfLog> = serde_json::from_str(&text).ok();
        let of = of.map(|of| of.survey).filter(|of| survey.is_or_was(of));
        let read = Self::from_json(&text, of.as_ref().unwrap_or(&own)).map_err(|error| {
            ReviewError { what: format!("{error}: {}", path.display()), ..error }
        })?;
        Ok(read.carried_to(own))
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// When the text is no review, has another layout version, is of another log than `of`, or
    /// holds a box that is impossible.
    pub fn from_json(text: &str, of: &Identity) -> Result<Self, ReviewError> {
        let refuse = |text: String| Err(ReviewError::new(text));
        let versioned: Versioned = serde_json::from_str(text)
            .map_err(|error| ReviewError::new(format!("this is no review of boxes: {error}")))?;
        if versioned.version != VERSION {
            return refuse(format!(
                "this review has layout {}, this program reads layout {VERSION}; use the program that wrote it",
                versioned.version
            ));
        }
        let stored: Stored = serde_json::from_str(text)
            .map_err(|error| ReviewError::new(format!("this review is damaged: {error}")))?;
        if !stored.survey.is_same_log(of) {
            return refuse(format!(
                "this review belongs to another log, of {} pings and {} bytes; open that log first: {}",
                stored.survey.pings, stored.survey.byte_count, stored.survey.file
            ));
        }
        let rows =
            ReviewRows { classes: stored.classes, searched: stored.searched, boxes: stored.boxes };
        let drawn_on = Identity { swapped_sides: stored.survey.swapped_sides, ..of.clone() };
        let read = Self::from_rows(rows, &drawn_on)?;
        Ok(read.with_sides(of.swapped_sides))
    }

    /// Creates a review of the log `of` from rows of a file.
    ///
    /// # Errors
    /// When there are too many rows, or a row is impossible for the log.
    pub fn from_rows(rows: ReviewRows, of: &Identity) -> Result<Self, ReviewError> {
        let refuse = |text: String| Err(ReviewError::new(text));
        if rows.searched.len() > MOST_SEARCHED {
            return refuse(format!(
                "this review has {} stretches that were searched; at most {MOST_SEARCHED} are read",
                rows.searched.len()
            ));
        }
        if rows.boxes.len() > MOST_BOXES || rows.classes.len() > MOST_CLASSES {
            return refuse(format!(
                "this review has {} boxes of {} classes; at most {MOST_BOXES} of {MOST_CLASSES} are read",
                rows.boxes.len(),
                rows.classes.len()
            ));
        }
        let mut seen = HashSet::new();
        if !rows.classes.iter().all(|class| is_name(class) && seen.insert(class)) {
            return Err(ReviewError::new(
                "this review is damaged: a class name is empty, too long or there twice",
            ));
        }
        let mut review = Review::new(of.clone(), rows.classes);
        let mut seen = HashSet::new();
        let mut models: HashSet<Arc<str>> = HashSet::new();
        for SearchRow { model, pings: [start, end] } in rows.searched {
            if !is_name(&model) || start >= end || end > of.pings {
                return Err(ReviewError::new(
                    "this review is damaged: the pings that were searched lie outside the log",
                ));
            }
            review.note_search(&shared(&mut models, model), start..end);
        }
        for row in rows.boxes {
            let id = row.id;
            let wrong = |what: &str| ReviewError {
                what: format!("this review is damaged: box {}: {what}", id.0),
                id: Some(id),
            };
            if !seen.insert(id) || id.0 == u32::MAX {
                return Err(wrong("its number is there twice or out of range"));
            }
            let model = row.model.clone().map(|name| shared(&mut models, name));
            let read = review.read_box(row, model).map_err(wrong)?;
            review.next_id = review.next_id.max(id.0 + 1);
            review.boxes.push(Arc::new(read));
        }
        review.boxes.sort_unstable_by_key(|review_box| review_box.id);
        Ok(review)
    }

    fn read_box(&self, row: BoxRow, model: Option<Arc<str>>) -> Result<Reviewed, &'static str> {
        let [start, end] = row.pings;
        let mark = Mark::new(row.side, start..end, [row.near_m, row.far_m]);
        let is_held = held(&mark, self.identity.pings).as_ref() == Some(&mark);
        let class = self.classes.iter().position(|class| *class == row.class);
        let extent = match row.border_m {
            Some(border_m) => ObjectExtent::Drawn { border_m },
            None if row.point => ObjectExtent::Point,
            None => ObjectExtent::Found,
        };
        let is_inside = |border_m: f64| !row.point && (row.near_m..=row.far_m).contains(&border_m);
        let has_score = row.score.is_none_or(|score| (0.0..=1.0).contains(&score));
        let has_short_note = row.note.chars().count() <= LONGEST_NOTE;
        let has_origin = match row.state {
            State::Added => model.is_none(),
            State::Proposed | State::Accepted => model.is_some(),
            State::Rejected => true,
        };
        check(is_held, "its pings or ranges lie outside the log")?;
        let class = class.ok_or("its class is not in the list")?;
        check(has_score, "its score is not between 0 and 1")?;
        check(
            has_short_note && model.as_deref().is_none_or(is_name),
            "its note or the name of its model is too long",
        )?;
        check(
            row.name.is_empty() || is_name(&row.name),
            "its name is too long or not of one line",
        )?;
        check(row.border_m.is_none_or(is_inside), "the border of its shadow lies outside of it")?;
        check(
            row.shadow.is_none_or(|shadow| shadow.fits(&mark)),
            "the shadow that its height was measured by lies on no ping of it, or has no length",
        )?;
        check(has_origin, "its state does not fit where it came from")?;
        Ok(Reviewed {
            id: row.id,
            mark,
            class,
            score: row.score,
            state: row.state,
            edited: row.edited,
            note: row.note,
            name: row.name,
            certainty: row.certainty,
            extent,
            shadow: row.shadow,
            model,
        })
    }
}

fn check(is_sound: bool, fault: &'static str) -> Result<(), &'static str> {
    is_sound.then_some(()).ok_or(fault)
}

fn shared(models: &mut HashSet<Arc<str>>, name: String) -> Arc<str> {
    if let Some(known) = models.get(name.as_str()) {
        return known.clone();
    }
    let model: Arc<str> = name.into();
    models.insert(model.clone());
    model
}
