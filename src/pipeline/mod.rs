//! Runs the stages in order, keeps what is still valid, and tells what is stale.

mod engine;
mod outputs;
mod products;
mod report;
mod settings;

pub use engine::{Engine, EngineStatus};
pub use outputs::{Written, write_products};
pub use products::{Products, Stage, run};
pub use report::{Report, warnings};
pub use settings::{Preset, Settings, SettingsError};
