//! YOLOv4 with the decoding in the network, as Tianxiaomo's and Darknet's exporters write it.

use super::Found;
use crate::{Rect, Scored};

/// `boxes` holds x1, y1, x2, y2 of each candidate, `confs` its `classes` scores (objectness times
/// class). `scale` is what a box's unit is in pixels, across and down: the input's size where boxes
/// are fractions of it, 1 where they are pixels.
pub(crate) fn boxes_and_confs(
    boxes: &[f32],
    confs: &[f32],
    classes: usize,
    scale: [f32; 2],
    least: f32,
) -> Vec<Scored> {
    let mut found = Found::new(least);
    for (edges, scores) in boxes.chunks_exact(4).zip(confs.chunks_exact(classes.max(1))) {
        found.add(1.0, scores.iter().copied(), || {
            Rect::new(
                [edges[0] * scale[0], edges[1] * scale[1]],
                [edges[2] * scale[0], edges[3] * scale[1]],
            )
        });
    }
    found.boxes
}
