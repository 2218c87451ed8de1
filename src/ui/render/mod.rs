//! wgpu only: slices and matrices in, pictures out. Knows no survey and no widget.
//!
//! `cloud` draws points, `bottom` a mesh and `map` lines into an offscreen `target`, `waterfall` draws tiles and `flat` areas of one
//! colour and whole pictures into a pass of the window;
//! `upload` fills buffers, `camera` orbits, `lod` thins long lines.

mod bottom;
mod camera;
mod cloud;
mod flat;
mod lod;
mod map;
mod part;
mod target;
mod upload;
pub mod waterfall;

pub use bottom::{
    BOTTOM_TILE, BottomBuffers, BottomDraw, BottomPart, BottomRenderer, BottomVertex, towards_light,
};
pub use camera::{Direction, OrbitCamera, Projection};
pub use cloud::{CloudBuffers, CloudDraw, CloudRenderer, PointVertex};
pub use flat::{FlatRenderer, Rgba};
pub use lod::{LinePyramid, Specks, Vertex};
pub use map::{LineDraw, LineRenderer, LineUniform, TrackBuffers};
pub use part::{Cut, Part};
pub use target::Target;
pub use upload::Uploader;
