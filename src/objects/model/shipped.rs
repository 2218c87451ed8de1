//! The model that comes with the program.

use super::load::{self, Limits};
use super::{Model, ModelError};
use std::path::PathBuf;

/// YOLOv4-tiny, its origin, data and figures in the model card beside it.
pub(super) const ONNX: &[u8] = include_bytes!("../../../assets/detector/default.onnx");
/// Classes, input and thresholds of the model.
pub(super) const SIDECAR: &str = include_str!("../../../assets/detector/default.json");

/// The model that comes with the program: compiled into it, so that nothing is downloaded.
///
/// # Errors
/// When the model cannot be used; the error names its file and says why.
pub fn shipped() -> Result<Model, ModelError> {
    load::from_bytes(ONNX.into(), Some(SIDECAR), None, Limits::NONE).map_err(|reason| ModelError {
        reason,
        path: PathBuf::from("the model that comes with the program"),
    })
}
