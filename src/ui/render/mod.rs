//! Draws slices and matrices into pictures, with wgpu only. This module depends neither on the
//! survey nor on widgets.
//!
//! `cloud` draws points, `bottom` a mesh and `map` lines into an offscreen target, `waterfall`
//! draws tiles and `flat` areas of one colour and whole pictures into a pass of the window.
//! `pipeline` has the target and the parts common to all of them and fills buffers, `camera`
//! orbits, `lod` thins long lines.

mod bottom;
mod camera;
mod cloud;
mod flat;
mod lod;
mod map;
mod pipeline;
pub mod waterfall;

pub use bottom::{
    BOTTOM_TILE, BottomBuffers, BottomDraw, BottomPart, BottomRenderer, BottomVertex, towards_light,
};
pub use camera::{CameraProjection, OrbitCamera};
pub(crate) use cloud::{CloudBuffers, CloudDraw, CloudRenderer, PointVertex};
pub(crate) use flat::FlatRenderer;
pub use flat::Rgba;
pub use lod::Vertex;
pub(crate) use lod::{LinePyramid, Specks};
pub(crate) use map::{LineDraw, LineRenderer, LineUniform, TrackBuffers};
pub(crate) use pipeline::plain_texture;
pub use pipeline::{Cut, RenderTarget, ScenePart, Uploader, extent};
