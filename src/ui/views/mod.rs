//! One file a view.

mod background;
mod cloud;
mod empty;
mod legend;
mod map;
mod picture;
mod profile;
mod ticks;
mod waterfall;

pub use cloud::CloudView;
pub use map::MapView;
pub use profile::ProfileView;
pub use waterfall::WaterfallView;
