//! Simulates surveys of known truth and writes them as valid SL2.
//!
//! From a [`Scene`] (a bed, a boat's track, a recorder and its artefacts) and a seed,
//! [`simulate()`] computes a [`Simulated`] survey: the log as a Lowrance side-scan recorder would
//! have written it, and for every ping the truth: the place of the boat, the depth of the water
//! under it, and the slant range of the nearest visible bed on each side.
//!
//! ```text
//! Scene --path--> pings --echo--> acoustic power by range, true first return --recorder--> bytes --sl2--> log
//!         bed, objects --^                  weed, fish, ... (artefacts) --^
//! ```
//!
//! `training_scene` draws random scenes to train a detector.
//!
//! The same scene and seed give the same log on every machine: every random number is drawn from a
//! stream that belongs to its ping and purpose (`random`), and the arithmetic uses only operations
//! that IEEE 754 defines exactly (`arithmetic`).
//!
//! # Simulate a survey
//!
//! ```
//! use bathyscope_log::support::progress::Progress;
//! use bathyscope_simulation::{Scene, simulate};
//!
//! let scene = Scene::with_pings(200);
//! let simulated = simulate(&scene, 1, &Progress::new())?;
//! assert_eq!(simulated.pings.len(), 200);
//! # Ok::<(), bathyscope_log::support::progress::Cancelled>(())
//! ```

// In a test, a failing `expect` or `unwrap` is a failing test.
#![cfg_attr(test, allow(clippy::expect_used, clippy::unwrap_used))]

mod arithmetic;
mod artefacts;
mod bed;
mod check;
mod echo;
mod listener;
mod log;
mod objects;
mod path;
mod random;
mod recorder;
mod scene;
mod simulate;
mod training_scene;
mod truth;
mod visibility;

pub use scene::{
    Artefacts, Bank, BedKind, BedSettings, Curve, Mound, ObjectKind, ObjectSettings,
    RecorderSettings, Scene, Terrace, TrackSettings,
};
pub use simulate::{Simulated, simulate};
pub use training_scene::{TrainingPlace, TrainingScene, training_scene, training_seed};
pub use truth::{ObjectPass, PingTruth};
