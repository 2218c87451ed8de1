//! Errors of models that cannot be used, as sentences that say what to do.

use bathyscope_log::support::progress::Cancelled;
use std::path::PathBuf;

/// A model that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("cannot use the model: {reason}: {path}")]
pub struct ModelError {
    /// The fault.
    pub reason: Unusable,
    /// File of the model.
    pub path: PathBuf,
}

/// Fault of a model, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum Unusable {
    /// The system gives no bytes.
    #[error("it cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// More bytes than any detector for a tile has.
    #[error("it is larger than {0} MiB; export a smaller network")]
    TooLarge(u64),
    /// No protobuf, no graph.
    #[error("it is no ONNX file, or is cut short; export the network as ONNX, opset 13")]
    NotOnnx,
    /// Weights in another file.
    #[error(
        "its weights lie in `{0}`, which is not beside it; copy that file there, or export again with the weights inside"
    )]
    WeightsElsewhere(String),
    /// A layer that is refused.
    #[error("it holds the layer {layer}, {why}")]
    Layer {
        /// The operator's name.
        layer: String,
        /// Meaning of the layer, and what to do.
        why: &'static str,
    },
    /// More layers than any detector has, or a tensor beyond measure.
    #[error("{0}; export a smaller network")]
    TooBig(String),
    /// Not a picture.
    #[error(
        "its input {0}; a picture of 1 or 3 channels is expected, for example [1, 3, 416, 416]"
    )]
    Input(String),
    /// Outputs that no decoder knows.
    #[error(
        "its outputs ({0}) are those of no known detector; name the family in the sidecar JSON file (yolov4, raw_heads, \
         yolov5, yolov8, end_to_end or yolox)"
    )]
    Layout(String),
    /// Outputs that do not fit the family that the sidecar names.
    #[error("its outputs do not fit the family {family}: {why}; correct the sidecar JSON file")]
    Misfit {
        /// The family.
        family: String,
        /// Outputs or entries that do not fit.
        why: String,
    },
    /// Raw heads without anchors.
    #[error(
        "its outputs are raw heads, whose anchors no ONNX file holds; write them into the sidecar JSON file, as `heads`"
    )]
    NoAnchors,
    /// Another task than detection.
    #[error("it was trained for the task `{0}`; export a detector")]
    Task(String),
    /// The sidecar JSON file.
    #[error("the sidecar JSON file is wrong: {0}")]
    Sidecar(String),
    /// Refused by tract, the whole chain of reasons.
    #[error("it cannot be compiled: {0}")]
    Compile(String),
    /// Failed while running, the whole chain of reasons.
    #[error("it fails on a picture: {0}")]
    Run(String),
    /// tract stopped half way.
    #[error("it is damaged: {0} stopped half way")]
    Damaged(&'static str),
    /// Took too long.
    #[error("{what} takes longer than {seconds} s; export a smaller network")]
    Slow {
        /// Work that takes too long.
        what: &'static str,
        /// Limit of its time, seconds.
        seconds: u64,
    },
}

/// A search that came to no end.
#[derive(Debug, thiserror::Error)]
pub enum DetectError {
    /// It was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The model failed on a tile.
    #[error("cannot search for objects: {0}")]
    Model(#[from] Unusable),
}
