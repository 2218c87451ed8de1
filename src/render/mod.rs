//! wgpu only: slices and matrices in, pictures out. Knows no survey and no widget.

pub mod colour_map;
pub mod waterfall;
