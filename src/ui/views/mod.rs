//! Draws the views of a survey: waterfall, map, cloud, profile, and the table of objects, each in
//! its own module.
//!
//! In: the state. Out: a picture with marks for each view, and commands.

pub(super) mod chip;
mod cloud;
mod legend;
mod map;
pub(super) mod measured;
mod objects;
mod profile;
mod tool;
pub(super) mod waterfall;

use bathyscope_bottom::presentation::ticks;
pub use cloud::CloudView;
pub use map::MapView;
pub(crate) use objects::ObjectsView;
pub use profile::ProfileView;
pub use waterfall::WaterfallView;
