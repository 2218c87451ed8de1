//! Errors of label files that cannot be used.

use super::MOST_CLASSES;
use bathyscope_log::support::file_error::FileError;
use std::io;

/// Label files that cannot be used.
pub type LabelError = FileError<LabelFault>;

/// Fault of label files, as a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum LabelFault {
    /// The system does not give the file.
    #[error("cannot read the labels: {0}")]
    NotRead(io::Error),
    /// The system does not give the folder.
    #[error("cannot list the folder of labels: {0}")]
    NotListed(io::Error),
    /// A file has more bytes than this.
    #[error("labels longer than {} MiB are not read", .0 >> 20)]
    TooLong(u64),
    /// The folder holds no labels.
    #[error(
        "no labels in the folder; name one that holds YOLO label files (*.txt) or a COCO file (*.json)"
    )]
    NoLabels,
    /// The folder holds more than one file that may be COCO's.
    #[error("several JSON files in the folder; name the one that holds the labels")]
    SeveralFiles,
    /// It names too many classes.
    #[error("{count} {named} are more than {MOST_CLASSES}")]
    TooManyClasses {
        /// Number of classes.
        count: usize,
        /// Word for classes in its format.
        named: &'static str,
    },
    /// It is no JSON of COCO's.
    #[error("cannot use the COCO file: {0}")]
    NotCoco(serde_json::Error),
    /// It holds no true boxes.
    #[error(
        "a list of results holds predictions; true boxes are in a COCO file with images, annotations and categories"
    )]
    OnlyResults,
    /// A line of YOLO's is no box.
    #[error("cannot use line {line}: {what}")]
    Line {
        /// Counted from 1.
        line: usize,
        /// The fault.
        #[source]
        what: YoloLineFault,
    },
    /// An annotation or a result of COCO's is no box.
    #[error("cannot use the box {number} of the file: {what}")]
    Annotation {
        /// Counted from 1.
        number: usize,
        /// The fault.
        #[source]
        what: AnnotationFault,
    },
    /// Predictions are of other pictures.
    #[error(
        "no predictions have the name of a labelled picture; name the folders of the same pictures"
    )]
    OtherPictures,
}

/// Fault of a line of YOLO's.
#[derive(Debug, thiserror::Error)]
pub enum YoloLineFault {
    /// It has one number too few.
    #[error("a predicted box needs a score: class cx cy w h score")]
    NoScore,
    /// It has one number too many.
    #[error("a true box has no sixth number (these may be predictions): class cx cy w h")]
    ExtraNumber,
    /// Its count of numbers is wrong.
    #[error("{count} numbers where a box is written {shape}")]
    Numbers {
        /// Count of the numbers.
        count: usize,
        /// Numbers that a box has.
        shape: &'static str,
    },
    /// Its class is none.
    #[error("`{0}` is no class (a whole number from 0, below {MOST_CLASSES})")]
    NoClass(String),
    /// A field is no number.
    #[error("`{0}` is no number")]
    NotANumber(String),
    /// The box lies beyond the picture.
    #[error("centre and size are shares of the picture, from 0 to 1")]
    Beyond,
    /// Its score is none.
    #[error("the score `{0}` is not within 0 to 1")]
    BadScore(String),
}

/// Fault of an annotation or a result of COCO's.
#[derive(Debug, thiserror::Error)]
pub enum AnnotationFault {
    /// Its picture is not in the file.
    #[error("there is no picture {0}")]
    UnknownPicture(String),
    /// Its category is not in the file.
    #[error("there is no category {0}")]
    UnknownCategory(u64),
    /// It is predicted and has no score.
    #[error("a predicted box needs a score from 0 to 1")]
    NoScore,
    /// Its corners are none.
    #[error("its bbox is [left, top, width, height] in pixels")]
    NoBox,
}
