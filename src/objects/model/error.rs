//! Defines the errors of models that cannot be used, as sentences that tell the user what to do.

use bathyscope_log::support::progress::Cancelled;
use std::path::PathBuf;

/// Error of a model that cannot be used, with the path.
#[derive(Debug, thiserror::Error)]
#[error("cannot use the model: {reason}: {path}")]
pub struct ModelError {
    /// The fault.
    pub reason: Unusable,
    /// File of the model.
    pub path: PathBuf,
}

/// Fault of a model, with the remedy in its message.
#[derive(Debug, thiserror::Error)]
pub enum Unusable {
    /// The file could not be read from the disk.
    #[error("it cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// The file is larger than any detector for a tile, MiB.
    #[error("it is larger than {0} MiB; export a smaller network")]
    TooLarge(u64),
    /// The file is no protobuf of ONNX, or holds no graph.
    #[error("it is no ONNX file, or is cut short; export the network as ONNX, opset 13")]
    NotOnnx,
    /// The weights are in another file, which is missing.
    #[error(
        "its weights lie in `{0}`, which is not beside it; copy that file there, or export again with the weights inside"
    )]
    WeightsElsewhere(String),
    /// The network has a layer that is refused.
    #[error("it holds the layer {layer}, {why}")]
    Layer {
        /// The operator's name.
        layer: String,
        /// Reason why the layer is refused, and what the user can do.
        why: &'static str,
    },
    /// The network has more layers than any detector, or a tensor or computation is too large.
    #[error("{0}; export a smaller network")]
    TooBig(String),
    /// The input of the network is no picture.
    #[error(
        "its input {0}; a picture of 1 or 3 channels is expected, for example [1, 3, 416, 416]"
    )]
    Input(String),
    /// The outputs have shapes of no known family of detectors.
    #[error(
        "its outputs ({0}) are those of no known detector; name the family in the sidecar JSON file (yolov4, raw_heads, \
         yolov5, yolov8, end_to_end or yolox)"
    )]
    Layout(String),
    /// The outputs do not fit the family that the sidecar file names.
    #[error("its outputs do not fit the family {family}: {why}; correct the sidecar JSON file")]
    Misfit {
        /// Name of the family.
        family: String,
        /// Outputs or entries that do not fit.
        why: String,
    },
    /// The outputs are raw heads, and the sidecar file holds no anchors.
    #[error(
        "its outputs are raw heads, whose anchors no ONNX file holds; write them into the sidecar JSON file, as `heads`"
    )]
    NoAnchors,
    /// The network was trained for another task than detection.
    #[error("it was trained for the task `{0}`; export a detector")]
    Task(String),
    /// The sidecar JSON file is wrong.
    #[error("the sidecar JSON file is wrong: {0}")]
    Sidecar(String),
    /// tract refuses the network; the text is the whole chain of reasons.
    #[error("it cannot be compiled: {0}")]
    Compile(String),
    /// The network fails while it runs; the text is the whole chain of reasons.
    #[error("it fails on a picture: {0}")]
    Run(String),
    /// tract panicked during this work.
    #[error("it is damaged: {0} stopped half way")]
    Damaged(&'static str),
    /// The work takes too long.
    #[error("{what} takes longer than {seconds} s; export a smaller network")]
    Slow {
        /// Work that takes too long.
        what: &'static str,
        /// Limit of its time, seconds.
        seconds: u64,
    },
}

impl Unusable {
    /// Refuses a network that is too large, with `text` as the reason, unless it fits.
    pub(super) fn unless(fits: bool, text: impl FnOnce() -> String) -> Result<(), Self> {
        if fits { Ok(()) } else { Err(Self::TooBig(text())) }
    }
}

/// Error of a search that did not end normally.
#[derive(Debug, thiserror::Error)]
pub enum DetectError {
    /// The search was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The model failed on a tile.
    #[error("cannot search for objects: {0}")]
    Model(#[from] Unusable),
}
