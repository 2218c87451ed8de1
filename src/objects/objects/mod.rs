//! The objects of a survey: one list of what the boxes of all logs show.
//!
//! In: boxes with their places and what was decided about them, and the numbers that objects had
//! before. Out: the objects that they are sightings of. The window, products, report and plan
//! have it from here.
//!
//! `review` says which boxes count, `object` is what all boxes of an object say of it, `numbers`
//! keeps the numbers of objects, `list` joins boxes into objects, `columns` is the table of what is
//! said of an object.

mod columns;
mod list;
mod numbers;
mod object;
mod review;

pub use columns::{
    ColumnValue, ColumnValues, LOGS_COLUMN, ListedObject, OBJECT_COLUMNS, ObjectColumn,
};
pub use list::ObjectList;
pub use numbers::{LogNumbers, ObjectNumbers};
pub use object::{Object, ObjectBox, ObjectState};
pub use review::SurveyReview;
pub use review::{KeptReview, LogReview};

use crate::review::BoxId;

/// Tells the logs of a survey apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LogId(pub u64);

/// A box of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LogBox {
    /// The log.
    pub log: LogId,
    /// Its number in that log's review.
    pub id: BoxId,
}
