//! Runs the stages in order, keeps what is still valid, and tells what is stale.

mod engine;
mod products;
mod settings;

pub use engine::{Engine, EngineStatus};
pub use products::{Products, Stage, run};
pub use settings::{Preset, Settings, SettingsError};
