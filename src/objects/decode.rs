//! Converts a network's numbers to boxes, in pixels of the network's input. Each family of
//! detectors has a function.
//!
//! In: the outputs of a network, and their shapes. Out: boxes with classes and scores.
//!
//! Every decoder receives the numbers as the network returns them and the least score, and makes
//! one box a candidate, of its class with the highest score. Numbers that are not finite make no
//! box: the model file may be from anybody.

use super::{Rect, Scored};
use serde::Deserialize;

/// The parameters of a head that the network does not state.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(crate) struct HeadEntry {
    /// Pixels of the input in a grid cell; the heads differ in their stride.
    pub stride: usize,
    /// Width and height of each anchor, pixels of the network's input.
    pub anchors: Vec<[f32; 2]>,
    /// Darknet's `scale_x_y`: factor of a centre's offset within its cell; above 1, the centre may
    /// lie outside the cell.
    #[serde(default = "one")]
    pub scale_x_y: f32,
    /// Darknet's `new_coords`: sizes are `(2 t)^2` anchors instead of `e^t`.
    #[serde(default)]
    pub new_coords: bool,
    /// True if the logistic function has been applied already (Darknet's heads with `new_coords`).
    #[serde(default)]
    pub activated: bool,
}

fn one() -> f32 {
    1.0
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

/// Returns the box of a candidate with its class of the highest score, if `trust` times this score
/// is at least `least`.
fn surest(
    least: f32,
    trust: f32,
    scores: impl Iterator<Item = f32>,
    rect: impl FnOnce() -> Rect,
) -> Option<Scored> {
    let (class, score) = scores
        .enumerate()
        .filter(|(_, score)| score.is_finite())
        .max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    scored(least, class, trust * score, rect)
}

/// Returns the box of a candidate of a known class, if its score is at least `least`.
fn scored(least: f32, class: usize, score: f32, rect: impl FnOnce() -> Rect) -> Option<Scored> {
    // Written so that a NaN is refused.
    let rect = (score >= least).then(rect)?;
    let finite = [rect.x0, rect.y0, rect.x1, rect.y1].iter().all(|edge| edge.is_finite());
    (finite && rect.area() > 0.0).then(|| Scored::new(class, score.min(1.0), rect))
}

/// Returns the boxes of YOLOv5, YOLOv7 and Darknet's row layout: one row a candidate.
///
/// `values` holds 5 + `classes` numbers a candidate: centre x, centre y, width, height in pixels,
/// objectness, then a score a class. A box's score is objectness times class.
pub fn rows(values: &[f32], classes: usize, least: f32) -> Vec<Scored> {
    let rows = values.chunks_exact(5 + classes);
    rows.filter_map(|row| {
        let rect = || centred([row[0], row[1], row[2], row[3]]);
        surest(least, row[4], row[5..].iter().copied(), rect)
    })
    .collect()
}

/// Returns the boxes of YOLOv8 to v12: one column a candidate.
///
/// `values` holds 4 + `classes` rows of as many columns as there are candidates: centre x, centre
/// y, width, height in pixels, then a score a class; there is no objectness.
pub fn columns(values: &[f32], classes: usize, least: f32) -> Vec<Scored> {
    let count = values.len() / (4 + classes);
    let at = |row: usize, column: usize| values.get(row * count + column).copied();
    let candidate = |column: usize| {
        let scores = (4..4 + classes).filter_map(|row| at(row, column));
        let rect = || centred([0, 1, 2, 3].map(|row| at(row, column).unwrap_or(f32::NAN)));
        surest(least, 1.0, scores, rect)
    };
    (0..count).filter_map(candidate).collect()
}

/// Returns the boxes of YOLOv10, YOLO26 and other networks that suppress overlapping boxes
/// themselves.
///
/// `values` holds six numbers a box: x1, y1, x2, y2 in pixels, score, class. Rows whose class is
/// not below `classes` make no box.
pub(crate) fn end_to_end(values: &[f32], classes: usize, least: f32) -> Vec<Scored> {
    let rows = values.chunks_exact(6);
    rows.filter_map(|row| {
        let class = row[5].round();
        // Written so that a NaN is refused.
        (class >= 0.0 && class < classes as f32).then_some(())?;
        scored(least, class as usize, row[4], || Rect::new([row[0], row[1]], [row[2], row[3]]))
    })
    .collect()
}

/// Returns the boxes of YOLOv4 with the decoding in the network, as Tianxiaomo's and Darknet's
/// exporters write it.
///
/// `boxes` holds x1, y1, x2, y2 of each candidate, `confs` its `classes` scores (objectness times
/// class). `scale` is the size in pixels of a box's unit, across and down: the input's size where
/// boxes are fractions of it, 1 where they are in pixels.
pub(crate) fn boxes_and_confs(
    boxes: &[f32],
    confs: &[f32],
    classes: usize,
    scale: [f32; 2],
    least: f32,
) -> Vec<Scored> {
    let candidates = boxes.chunks_exact(4).zip(confs.chunks_exact(classes.max(1)));
    let [across, down] = scale;
    candidates
        .filter_map(|(edges, scores)| {
            let [x0, y0, x1, y1] = [edges[0], edges[1], edges[2], edges[3]];
            let rect = || Rect::new([x0 * across, y0 * down], [x1 * across, y1 * down]);
            surest(least, 1.0, scores.iter().copied(), rect)
        })
        .collect()
}

/// Returns the boxes of YOLOX, whose rows are still in units of their grid cell.
///
/// `values` holds 5 + `classes` numbers a grid cell, the grids of `strides` one after the other,
/// row by row: the centre's offset in cells, the logarithm of the size in cells, objectness, a
/// score a class. `input` is the network's width and height.
///
/// `x = (tx + column) stride`, `w = e^tw stride` (Megvii's `demo_postprocess`).
pub(crate) fn yolox(
    values: &[f32],
    classes: usize,
    input: [usize; 2],
    strides: &[usize],
    least: f32,
) -> Vec<Scored> {
    let cells = strides.iter().flat_map(|&stride| {
        let [columns, rows] = input.map(|size| size / stride);
        (0..rows).flat_map(move |row| (0..columns).map(move |column| (stride, column, row)))
    });
    let candidate = |(cell, (stride, column, row)): (&[f32], (usize, usize, usize))| {
        let size = stride as f32;
        let rect = || {
            let [x, y] = [cell[0] + column as f32, cell[1] + row as f32];
            centred([x * size, y * size, cell[2].exp() * size, cell[3].exp() * size])
        };
        surest(least, cell[4], cell[5..].iter().copied(), rect)
    };
    values.chunks_exact(5 + classes).zip(cells).filter_map(candidate).collect()
}

impl HeadLayout {
    /// Returns the index of the number of an attribute; `sizes` are anchors, attributes, rows,
    /// columns.
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

/// Returns the boxes of a head that is the output of the last convolution: YOLOv3 and v4 without
/// the decoding.
///
/// `values` holds, for each anchor and grid cell, tx, ty, tw, th, objectness and a value a class.
/// `grid` is columns and rows, `input` the network's width and height.
///
/// `x = (column + s sigma(tx) - (s - 1) / 2) stride`, `w = e^tw anchor`, score = sigma(objectness)
/// sigma(class) (Darknet's `yolo_layer.c`, `s` its `scale_x_y`).
pub(crate) fn raw_head(
    values: &[f32],
    layout: HeadLayout,
    head: &HeadEntry,
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
    let candidate = |(anchor, row, column): (usize, usize, usize)| {
        let at = |attribute| {
            let index = layout.index(sizes, anchor, attribute, [row, column]);
            values.get(index).copied().unwrap_or(f32::NAN)
        };
        let objectness = active(at(4));
        // Most cells hold no object: their class scores need not be computed.
        if objectness < least {
            return None;
        }
        let scores = (5..5 + classes).map(|attribute| active(at(attribute)));
        let [width, height] = head.anchors[anchor];
        surest(least, objectness, scores, || {
            let [x, y] = [centre(at(0), column), centre(at(1), row)];
            centred([x * stride[0], y * stride[1], size(at(2), width), size(at(3), height)])
        })
    };
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let anchors = 0..head.anchors.len();
    anchors
        .flat_map(|anchor| cells.clone().map(move |(row, column)| (anchor, row, column)))
        .filter_map(candidate)
        .collect()
}

/// Creates a box from its centre and size.
fn centred([x, y, width, height]: [f32; 4]) -> Rect {
    Rect::new([x - 0.5 * width, y - 0.5 * height], [x + 0.5 * width, y + 0.5 * height])
}

/// Returns `1 / (1 + e^-x)`.
fn logistic(x: f32) -> f32 {
    1.0 / (1.0 + (-x).exp())
}
