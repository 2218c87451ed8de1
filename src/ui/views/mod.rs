//! One file a view.

pub(super) mod background;
mod cloud;
mod empty;
mod legend;
mod map;
mod picture;
mod profile;
mod ticks;
pub(super) mod waterfall;

pub use cloud::CloudView;
pub use map::MapView;
pub use profile::ProfileView;
pub use waterfall::WaterfallView;
