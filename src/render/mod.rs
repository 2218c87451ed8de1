//! wgpu only: slices and matrices in, pictures out. Knows no survey and no widget.

mod camera;
mod cloud;
pub mod colour_map;
mod lod;
mod map;
mod ramp;
mod target;
pub mod waterfall;

pub use camera::{Direction, OrbitCamera, Projection};
pub use cloud::{CloudBuffers, CloudDraw, CloudRenderer, PointVertex};
pub use lod::{LineLevel, LinePyramid, Segment, Vertex};
pub use map::{LineDraw, LineRenderer, LineUniform, TrackBuffers};
pub use ramp::{depth_colour, depth_share};
pub use target::Target;
