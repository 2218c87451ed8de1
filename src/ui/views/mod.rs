//! One file a view.

pub(super) mod chip;
mod cloud;
mod drag;
mod empty;
mod legend;
mod map;
pub(super) mod measured;
mod objects;
mod picture;
mod profile;
mod tool_banner;
pub(super) mod waterfall;

use crate::support::presentation::ticks;
pub use cloud::CloudView;
pub use map::MapView;
pub use objects::ObjectsView;
pub use profile::ProfileView;
pub use waterfall::WaterfallView;
