//! Heads as the last convolution leaves them: YOLOv3 and v4 without the decoding.

use super::{Found, centred, logistic};
use crate::Scored;

/// Parameters of a head that the network does not state.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Head {
    /// Width and height of each anchor, pixels of the network's input.
    pub anchors: Vec<[f32; 2]>,
    /// Darknet's `scale_x_y`: how far a centre may leave its cell.
    pub scale_x_y: f32,
    /// Darknet's `new_coords`: sizes are `(2 t)^2` anchors instead of `e^t`.
    pub new_coords: bool,
    /// True if the logistic function has been applied already (Darknet's heads with `new_coords`).
    pub activated: bool,
}

/// Order of the numbers in a head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HeadLayout {
    /// Anchors and attributes, rows, columns.
    ChannelsFirst,
    /// Rows, columns, anchors and attributes.
    ChannelsLast,
    /// Anchors, rows, columns, attributes.
    AnchorsFirst,
}

impl HeadLayout {
    /// Index of an attribute's number; `sizes` are anchors, attributes, rows, columns.
    fn index(self, sizes: [usize; 4], anchor: usize, attribute: usize, cell: [usize; 2]) -> usize {
        let [anchors, attributes, rows, columns] = sizes;
        let [row, column] = cell;
        match self {
            HeadLayout::ChannelsFirst => {
                ((anchor * attributes + attribute) * rows + row) * columns + column
            }
            HeadLayout::ChannelsLast => {
                ((row * columns + column) * anchors + anchor) * attributes + attribute
            }
            HeadLayout::AnchorsFirst => {
                ((anchor * rows + row) * columns + column) * attributes + attribute
            }
        }
    }
}

/// `values` holds, for each anchor and grid cell, tx, ty, tw, th, objectness and a value a class.
/// `grid` is columns and rows, `input` the network's width and height.
///
/// `x = (column + s sigma(tx) - (s - 1) / 2) stride`, `w = e^tw anchor`, score = sigma(objectness)
/// sigma(class) (Darknet's `yolo_layer.c`, `s` its `scale_x_y`).
pub(crate) fn raw_head(
    values: &[f32],
    layout: HeadLayout,
    head: &Head,
    classes: usize,
    grid: [usize; 2],
    input: [usize; 2],
    least: f32,
) -> Vec<Scored> {
    let [columns, rows] = grid;
    let sizes = [head.anchors.len(), 5 + classes, rows, columns];
    let stride = [0, 1].map(|axis| input[axis] as f32 / grid[axis] as f32);
    let active = |x: f32| if head.activated { x } else { logistic(x) };
    let size = |t: f32, anchor: f32| {
        if head.new_coords { (2.0 * active(t)).powi(2) * anchor } else { t.exp() * anchor }
    };
    let centre = |t: f32, cell: usize| {
        cell as f32 + head.scale_x_y * active(t) - 0.5 * (head.scale_x_y - 1.0)
    };
    let mut found = Found::new(least);
    for (anchor, [width, height]) in head.anchors.iter().enumerate() {
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)))
        {
            let at = |attribute| {
                let index = layout.index(sizes, anchor, attribute, [row, column]);
                values.get(index).copied().unwrap_or(f32::NAN)
            };
            let objectness = active(at(4));
            // Most cells hold nothing: their classes need not be looked at.
            if objectness < least {
                continue;
            }
            let scores = (5..5 + classes).map(|attribute| active(at(attribute)));
            found.add(objectness, scores, || {
                centred([
                    centre(at(0), column) * stride[0],
                    centre(at(1), row) * stride[1],
                    size(at(2), *width),
                    size(at(3), *height),
                ])
            });
        }
    }
    found.boxes
}
