//! wgpu only: slices and matrices in, pictures out. Knows no survey and no widget.
//!
//! It uses nothing outside `ui`.
//!
//! `cloud` draws points, `bottom` a mesh and `map` lines into an offscreen `target`, `waterfall` draws tiles and `flat` areas of one
//! colour and whole pictures into a pass of the window;
//! `pipeline` has what all of them are made of, `upload` fills buffers, `camera` orbits, `lod` thins long lines.

mod bottom;
mod camera;
mod cloud;
mod flat;
mod lod;
mod map;
mod part;
mod pipeline;
mod target;
mod upload;
pub mod waterfall;

pub use bottom::{
    BOTTOM_TILE, BottomBuffers, BottomDraw, BottomPart, BottomRenderer, BottomVertex, towards_light,
};
pub use camera::{CameraProjection, Direction, OrbitCamera};
pub use cloud::{CloudBuffers, CloudDraw, CloudRenderer, PointVertex};
pub use flat::{FlatRenderer, Rgba};
pub use lod::{LinePyramid, Specks, Vertex};
pub use map::{LineDraw, LineRenderer, LineUniform, TrackBuffers};
pub use part::{Cut, ScenePart};
pub use target::{RenderTarget, extent};
pub use upload::Uploader;
