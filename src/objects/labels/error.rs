//! Defines the errors of label files that cannot be used.

use super::MOST_CLASSES;
use bathyscope_log::support::file_error::FileError;
use std::io;

/// Error of label files that cannot be used, with the path.
pub type LabelError = FileError<LabelFault>;

/// Fault of label files, as a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum LabelFault {
    /// The file could not be read from the disk.
    #[error("cannot read the labels: {0}")]
    NotRead(io::Error),
    /// The folder could not be listed.
    #[error("cannot list the folder of labels: {0}")]
    NotListed(io::Error),
    /// A file is longer than this limit, bytes.
    #[error("labels longer than {} MiB are not read", .0 >> 20)]
    TooLong(u64),
    /// The folder holds no labels.
    #[error(
        "no labels in the folder; name one that holds YOLO label files (*.txt) or a COCO file (*.json)"
    )]
    NoLabels,
    /// The folder holds several JSON files, and any of them may be the COCO file.
    #[error("several JSON files in the folder; name the one that holds the labels")]
    SeveralFiles,
    /// The labels have too many classes.
    #[error("{count} {named} are more than {MOST_CLASSES}")]
    TooManyClasses {
        /// Number of classes.
        count: usize,
        /// Word for classes in this format.
        named: &'static str,
    },
    /// The file is not JSON in COCO's format.
    #[error("cannot use the COCO file: {0}")]
    NotCoco(serde_json::Error),
    /// The file holds no true boxes, only predictions.
    #[error(
        "a list of results holds predictions; true boxes are in a COCO file with images, annotations and categories"
    )]
    OnlyResults,
    /// A line of a YOLO file is no valid box.
    #[error("cannot use line {line}: {what}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// The fault.
        what: String,
    },
    /// An annotation or a result of a COCO file is no valid box.
    #[error("cannot use the box {number} of the file: {what}")]
    Annotation {
        /// Number of the box in the file, from 1.
        number: usize,
        /// The fault.
        what: String,
    },
    /// The predictions are of other pictures than the true boxes.
    #[error(
        "no predictions have the name of a labelled picture; name the folders of the same pictures"
    )]
    OtherPictures,
}
