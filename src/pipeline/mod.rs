//! Runs the stages in order, keeps what is still valid, and tells what is stale.
//!
//! `settings` holds every setting and the two presets, `products` the stages and what they made, `engine` runs them on a
//! worker for the window, `outputs` writes the files of `bathyscope process`, `clouds` those of points, `track` those of the
//! boat's way, `record` what lies beside
//! each of them and `report` the whole. `detections`
//! searches for objects and writes them, `boxes` writes what was decided about boxes, `lessons` as pictures for training,
//! `mosaic` the side-scan mosaic, `depth` the depth map and what follows from it, `merged` that
//! of several logs, `agreement` how points differ from a reference.

mod agreement;
mod boxes;
mod clouds;
mod depth;
mod detections;
mod engine;
mod lessons;
mod merged;
mod mosaic;
mod outputs;
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
pub use depth::{DepthChart, DepthWritten, NamedComparison, write_depth};
pub use detections::{Proposed, proposed_rows, record_detections, write_detections};
pub use engine::{Engine, EngineStatus};
pub use merged::Merged;
pub use mosaic::{MosaicWritten, mosaic_layout, write_mosaic};
pub use outputs::{Written, spare_files, write_products, write_report};
pub use placing::Placing;
pub use product::Product;
pub use products::{Products, Stage, run};
pub use record::{Coordinates, Made};
pub use report::{Report, warnings};
pub use settings::{Preset, Settings, SettingsError};
