//! One file a view.

mod cloud;
mod map;
mod profile;
mod waterfall;

pub use cloud::CloudView;
pub use map::MapView;
pub use profile::ProfileView;
pub use waterfall::WaterfallView;
