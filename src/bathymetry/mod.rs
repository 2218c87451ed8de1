//! Depth maps from soundings.
