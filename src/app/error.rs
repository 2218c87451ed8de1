//! Errors of operations that the analyst requests.

use bathyscope_log::formats::{GrowingError, OpenError};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::progress::Cancelled;
use bathyscope_objects::truth::TruthError;
use bathyscope_objects::{DetectError, ModelError};
use bathyscope_products::export::ExportError;
use bathyscope_products::pipeline::{SettingsError, SourceError};
use bathyscope_products::project::StoreError;
use std::io;
use std::path::PathBuf;

/// Reason for the failure of a requested operation, as one sentence for the analyst.
#[derive(Debug, thiserror::Error)]
pub(super) enum AppError {
    /// The work ended in a panic.
    #[error("{0} failed unexpectedly")]
    Failed(&'static str),
    /// Opening a log ended in a panic.
    #[error("opening failed unexpectedly: {0}")]
    OpeningFailed(String),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A log cannot be read.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The followed log was cut, replaced or removed, or its copy cannot be written or read.
    #[error(transparent)]
    Growing(#[from] GrowingError),
    /// Reading a followed log ended in a panic.
    #[error("it failed unexpectedly")]
    StepFailed,
    /// The corrections of a log's source by its settings cannot be applied.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The settings cannot be used.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The track of another receiver, the readings of a gauge or a polygon cannot be read.
    #[error(transparent)]
    Unusable(#[from] FileError),
    /// A model cannot be used.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The search for objects was cancelled or failed.
    #[error(transparent)]
    Search(#[from] DetectError),
    /// A log of an untitled project is not at its place.
    #[error("another recording is at the place of a log")]
    OtherLog,
    /// The folder of untitled projects cannot be created.
    #[error("the folder cannot be created: {source}: {}", path.display())]
    NoFolder {
        /// Error of the system.
        #[source]
        source: io::Error,
        /// Path of the folder.
        path: PathBuf,
    },
    /// The truth of the demo survey cannot be used.
    #[error(transparent)]
    DemoTruth(#[from] TruthError),
    /// A file of truth cannot be used.
    #[error(transparent)]
    Truth(#[from] FileError<TruthError>),
    /// A project cannot be opened.
    #[error(transparent)]
    Project(#[from] StoreError),
    /// The file name of a measurement has no known format.
    #[error("a measurement's name ends in .geojson or .csv: {}", .0.display())]
    FigureFormat(PathBuf),
    /// A file cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The survey cannot be compared with a reference, or files cannot be written.
    #[error(transparent)]
    Products(#[from] bathyscope_products::Error),
}
