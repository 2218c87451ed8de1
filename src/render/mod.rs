//! wgpu only: slices and matrices in, pictures out. Knows no survey and no widget.
//!
//! `cloud` draws points and `map` lines into an offscreen `target`, `waterfall` draws tiles into a pass of the window;
//! `upload` fills buffers, `camera` orbits, `lod` thins long lines, `diverging` and `colour_map` turn differences and
//! echoes into colours.

mod camera;
mod cloud;
pub mod colour_map;
mod diverging;
mod lod;
mod map;
mod target;
mod upload;
pub mod waterfall;

pub use crate::depth_colours::{depth_colour, depth_share};
pub use camera::{Direction, OrbitCamera, Projection};
pub use cloud::{CloudBuffers, CloudDraw, CloudRenderer, PointVertex};
pub use diverging::{diverging_colour, diverging_reach_m};
pub use lod::{LineLevel, LinePyramid, Specks, Vertex};
pub use map::{LineDraw, LineRenderer, LineUniform, TrackBuffers};
pub use target::Target;
pub use upload::Uploader;
