//! Tests the detector against onnxruntime, and the metrics against pycocotools.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

mod detection_metrics;
mod detector;
mod shipped_model;
