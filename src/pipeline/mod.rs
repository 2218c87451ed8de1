//! Runs the stages in order, keeps what is still valid, and tells what is stale.
//!
//! `settings` holds every setting and the two presets, `log_settings` those that one of several logs has for itself, `products` the stages and what they made, `engine` runs them on a
//! worker for the window. What `outputs` puts together is written here: `clouds` writes the files of points, `track` those of the
//! boat's way, `mosaic` the side-scan mosaic, `depth` the depth map and what follows from it, `detections`
//! searches for objects and writes them, `agreement` tells how points differ from a reference, `record` is what lies beside
//! each file and `report` the whole. `boxes` writes what was decided about boxes, `lessons` as pictures for training, `merged` the
//! depth map of several logs.

mod agreement;
mod boxes;
mod clouds;
mod depth;
mod detections;
mod engine;
mod lessons;
mod log_settings;
mod merged;
mod mosaic;
mod placing;
mod product;
mod products;
mod record;
mod report;
mod settings;
mod track;

pub use agreement::{
    Agreement, ComparisonRecord, Reference, ResidualTables, matching_in_words, positions,
    write_comparison, write_differences,
};
pub use boxes::{BoxesWritten, reviewed_rows, write_boxes};
pub use clouds::{write_clouds, write_tables};
pub use depth::{DepthChart, DepthWritten, NamedComparison, write_depth};
pub use detections::{Proposed, proposed_rows, write_detections};
pub use engine::{Engine, EngineStatus};
pub use log_settings::{
    LogSettings, SettingValues, from_values, is_of_one_log, is_setting, setting_values, with_values,
};
pub use merged::Merged;
pub use mosaic::{MosaicWritten, mosaic_layout, write_mosaic};
pub use placing::Placing;
pub use product::Product;
pub use products::{Products, Stage, run};
pub use record::{Coordinates, Made, write_record};
pub use report::{CalibrationReport, Input, Report, warnings};
pub use settings::{Preset, Settings, SettingsError};
pub use track::write_track;

use crate::geo::MapPlane;
use crate::survey::Survey;

/// The plane of the system that `crs` names.
///
/// # Errors
/// A sentence that says why there is none.
pub fn map_plane(survey: &Survey, settings: &Settings) -> Result<MapPlane, String> {
    let origin = survey.track.frame.origin();
    let crs = settings.crs.at(origin).map_err(|error| error.to_string())?;
    Ok(MapPlane::new(crs, origin))
}
