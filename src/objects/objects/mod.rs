//! Joins the boxes of all logs of a survey into one list of objects.
//!
//! In: boxes with their places and the decisions about them, and the numbers that objects had
//! before. Out: the objects that the boxes are sightings of. The window, products, report and plan
//! all use this list.
//!
//! `review` determines which boxes count and keeps the numbers of objects, `object` combines all
//! boxes of an object, `list` joins boxes into objects, `columns` defines the table of objects.

mod columns;
mod list;
mod object;
mod review;

pub use columns::{
    ColumnValue, ColumnValues, LOGS_COLUMN, ListedObject, OBJECT_COLUMNS, ObjectColumn,
};
pub use list::ObjectList;
pub use object::{Object, ObjectBox, ObjectState};
pub use review::{KeptReview, LogNumbers, LogReview, ObjectNumbers, SurveyReview};

use crate::review::BoxId;

/// Identifier of a log of a survey.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LogId(pub u64);

/// A box of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LogBox {
    /// The log.
    pub log: LogId,
    /// Number of the box in the review of this log.
    pub id: BoxId,
}
