//! wgpu only: slices and matrices in, pictures out. Knows no survey and no widget.
