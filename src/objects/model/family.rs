//! Determines which family of detectors the outputs of a network belong to, by their shapes or from
//! the sidecar file, and decodes the outputs accordingly.

use super::Unusable;
use super::sidecar::{FamilyName, Metadata, Sidecar};
use super::tract::Output;
use crate::Scored;
use crate::decode::{self, HeadEntry, HeadLayout};

/// Greatest number of boxes of an end-to-end network; 300 is usual.
const MOST_END_TO_END: usize = 1000;
/// Strides of the heads of the detectors in use: three heads, two (tiny), four (large inputs), four
/// (small objects).
const STRIDES: [&[usize]; 4] = [&[8, 16, 32], &[16, 32], &[8, 16, 32, 64], &[4, 8, 16, 32]];

/// Name of an output, and its shape.
pub(super) type Shaped<'a> = (&'a str, &'a [usize]);

/// Family of a detector, with the data needed to decode its outputs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DetectorFamily {
    /// Number of classes.
    pub classes: usize,
    kind: Kind,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    BoxesAndConfs {
        boxes: usize,
        confs: usize,
        /// True if boxes are fractions of the picture, false if they are in pixels; `None` until
        /// the first run has shown it.
        fractions: Option<bool>,
    },
    RawHeads(Vec<BoundHead>),
    Rows,
    Columns,
    EndToEnd,
    Yolox(&'static [usize]),
}

/// A raw head and the output that holds it.
#[derive(Clone, Debug, PartialEq)]
struct BoundHead {
    output: usize,
    layout: HeadLayout,
    /// Columns and rows of grid cells.
    grid: [usize; 2],
    head: HeadEntry,
}

impl FamilyName {
    /// Returns the name of the family in a few words.
    pub(super) fn words(self) -> &'static str {
        match self {
            FamilyName::Yolov4 => "YOLOv4 (boxes and scores)",
            FamilyName::RawHeads => "raw YOLO heads",
            FamilyName::Yolov5 => "YOLOv5 or v7",
            FamilyName::Yolov8 => "YOLOv8 to v12",
            FamilyName::EndToEnd => "an end-to-end YOLO",
            FamilyName::Yolox => "YOLOX",
        }
    }
}

/// Returns the family that outputs of these shapes belong to; `input` is the network's width and
/// height.
pub(super) fn guess(
    outputs: &[Shaped<'_>],
    input: [usize; 2],
    metadata: &Metadata,
) -> Result<FamilyName, Unusable> {
    let unknown = || Err(Unusable::Layout(listed(outputs)));
    if boxes_and_confs(outputs).is_some() {
        return Ok(FamilyName::Yolov4);
    }
    if let [(_, shape)] = outputs
        && let Some([first, second]) = flat(shape)
    {
        // True if some strides make `count` boxes, with `each` of them a grid cell.
        let cells = |count: usize, each: usize| {
            STRIDES.iter().any(|strides| each * cells_of(input, strides) == count)
        };
        let one_class = cells(first, 1) || cells(first, 3);
        return match (first, second) {
            (_, 6) if metadata.end_to_end() => Ok(FamilyName::EndToEnd),
            (count, 6) if count <= MOST_END_TO_END && !one_class => Ok(FamilyName::EndToEnd),
            (count, width) if count < width && count > 4 => Ok(FamilyName::Yolov8),
            (count, width) if width > 5 && cells(count, 1) => Ok(FamilyName::Yolox),
            (count, width) if width > 5 && cells(count, 3) => Ok(FamilyName::Yolov5),
            _ => unknown(),
        };
    }
    let all_grids = outputs.iter().all(|(_, shape)| !layouts(shape, input).is_empty());
    if all_grids && !outputs.is_empty() { Ok(FamilyName::RawHeads) } else { unknown() }
}

/// Assigns the outputs to the parts of a family, and determines the number of classes.
pub(super) fn bind(
    name: FamilyName,
    outputs: &[Shaped<'_>],
    input: [usize; 2],
    sidecar: &Sidecar,
    known_names: Option<usize>,
) -> Result<DetectorFamily, Unusable> {
    let misfit = |why: String| Unusable::Misfit { family: name.words().to_owned(), why };
    let unfit = || misfit(listed(outputs));
    let single_shape = || match outputs {
        [(_, shape)] => flat(shape).ok_or_else(unfit),
        _ => Err(unfit()),
    };
    let more = |width: usize, fixed: usize| {
        let classes = width.checked_sub(fixed).filter(|&classes| classes > 0);
        classes.ok_or_else(unfit)
    };
    let (classes, kind) = match name {
        FamilyName::Yolov4 => {
            let (boxes, confs, classes) = boxes_and_confs(outputs).ok_or_else(unfit)?;
            let fractions = coordinates(sidecar);
            (classes, Kind::BoxesAndConfs { boxes, confs, fractions })
        }
        FamilyName::RawHeads => {
            let (classes, heads) = bind_heads(outputs, input, sidecar, misfit)?;
            (classes, Kind::RawHeads(heads))
        }
        FamilyName::Yolov5 => (more(single_shape()?[1], 5)?, Kind::Rows),
        FamilyName::Yolov8 => (more(single_shape()?[0], 4)?, Kind::Columns),
        FamilyName::EndToEnd => {
            let [_, width] = single_shape()?;
            if width != 6 {
                return Err(unfit());
            }
            // The outputs do not show how many classes there are.
            (known_names.unwrap_or(80), Kind::EndToEnd)
        }
        FamilyName::Yolox => {
            let [count, width] = single_shape()?;
            let strides = STRIDES.into_iter().find(|strides| cells_of(input, strides) == count);
            let strides = strides.ok_or_else(|| {
                misfit(format!(
                    "{count} boxes are not the grid cells of an input of {} x {}",
                    input[0], input[1]
                ))
            })?;
            (more(width, 5)?, Kind::Yolox(strides))
        }
    };
    Ok(DetectorFamily { classes, kind })
}

impl DetectorFamily {
    /// Returns the boxes of at least the score `least`, in pixels of the input.
    pub(super) fn decode(&self, outputs: &[Output], input: [usize; 2], least: f32) -> Vec<Scored> {
        let values = |index: usize| outputs.get(index).map_or(&[][..], |output| &output.values);
        match &self.kind {
            Kind::BoxesAndConfs { boxes, confs, fractions } => {
                let scale = if *fractions == Some(false) {
                    [1.0; 2]
                } else {
                    input.map(|size| size as f32)
                };
                let (boxes, confs) = (values(*boxes), values(*confs));
                decode::boxes_and_confs(boxes, confs, self.classes, scale, least)
            }
            Kind::RawHeads(heads) => heads
                .iter()
                .flat_map(|bound| {
                    let BoundHead { layout, head, grid, .. } = bound;
                    let values = values(bound.output);
                    decode::raw_head(values, *layout, head, self.classes, *grid, input, least)
                })
                .collect(),
            Kind::Rows => decode::rows(values(0), self.classes, least),
            Kind::Columns => decode::columns(values(0), self.classes, least),
            Kind::EndToEnd => decode::end_to_end(values(0), self.classes, least),
            Kind::Yolox(strides) => decode::yolox(values(0), self.classes, input, strides, least),
        }
    }

    /// Returns true if the network drops overlapping boxes itself.
    pub(super) fn suppresses(&self) -> bool {
        self.kind == Kind::EndToEnd
    }

    /// Determines from the outputs of a first run what the shapes do not show: boxes are fractions
    /// of the picture if no edge is far beyond 1.
    pub(super) fn learn(&mut self, first_run: &[Output]) {
        if let Kind::BoxesAndConfs { boxes, fractions, .. } = &mut self.kind
            && fractions.is_none()
        {
            let edges = first_run.get(*boxes).map_or(&[][..], |output| &output.values);
            let largest = edges.iter().fold(0.0_f32, |largest, edge| largest.max(*edge));
            *fractions = Some(largest <= 4.0);
        }
    }
}

/// Returns true if the sidecar file states fractions as the unit of the boxes, false for pixels;
/// `None` if it states neither.
fn coordinates(sidecar: &Sidecar) -> Option<bool> {
    let words = sidecar.outputs.coordinates.as_deref()?;
    if words.contains("fraction") {
        return Some(true);
    }
    words.contains("pixel").then_some(false)
}

/// Returns the outputs in words, for messages.
fn listed(outputs: &[Shaped<'_>]) -> String {
    let words = outputs.iter().map(|(name, shape)| format!("{name} {shape:?}"));
    words.collect::<Vec<_>>().join(", ")
}

/// Returns the last two sizes of a shape if all sizes before are 1.
fn flat(shape: &[usize]) -> Option<[usize; 2]> {
    let (&[first, second], before) = shape.split_last_chunk::<2>().map(|(a, b)| (b, a))?;
    before.iter().all(|&size| size == 1).then_some([first, second])
}

/// Returns the indices of the boxes `[1, N, 1, 4]` or `[1, N, 4]` and of the scores `[1, N, C]`,
/// and C. If either output could be the boxes, their names decide: exporters do not agree on the
/// order.
fn boxes_and_confs(outputs: &[Shaped<'_>]) -> Option<(usize, usize, usize)> {
    let [a, b] = outputs else {
        return None;
    };
    let pair = |(_, boxes): &Shaped<'_>, (_, confs): &Shaped<'_>| match (*boxes, *confs) {
        (&([1, boxes, 1, 4] | [1, boxes, 4]), &[1, count, classes]) => {
            (boxes == count && classes > 0).then_some(classes)
        }
        _ => None,
    };
    match (pair(a, b), pair(b, a)) {
        (Some(classes), None) => Some((0, 1, classes)),
        (None, Some(classes)) => Some((1, 0, classes)),
        (Some(classes), Some(_)) if a.0.contains("box") => Some((0, 1, classes)),
        (Some(_), Some(classes)) if b.0.contains("box") => Some((1, 0, classes)),
        _ => None,
    }
}

fn cells_of(input: [usize; 2], strides: &[usize]) -> usize {
    strides.iter().map(|stride| (input[0] / stride) * (input[1] / stride)).sum()
}

/// Returns the ways in which an output can be read as a raw head: its layout, columns and rows, and
/// numbers a cell.
fn layouts(shape: &[usize], input: [usize; 2]) -> Vec<(HeadLayout, [usize; 2], usize)> {
    let ways = match *shape {
        [1, channels, rows, columns] => vec![
            (HeadLayout::ChannelsFirst, [columns, rows], channels),
            // The same four sizes, with the channels last.
            (HeadLayout::ChannelsLast, [rows, channels], columns),
        ],
        [1, anchors, rows, columns, attributes] => {
            vec![(HeadLayout::AnchorsFirst, [columns, rows], anchors * attributes)]
        }
        _ => Vec::new(),
    };
    ways.into_iter()
        .filter(|(_, [columns, rows], numbers)| {
            let stride = input[0].checked_div(*columns).unwrap_or(0);
            stride > 1 && columns * stride == input[0] && rows * stride == input[1] && *numbers >= 6
        })
        .collect()
}

fn bind_heads(
    outputs: &[Shaped<'_>],
    input: [usize; 2],
    sidecar: &Sidecar,
    misfit: impl Fn(String) -> Unusable,
) -> Result<(usize, Vec<BoundHead>), Unusable> {
    if sidecar.heads.is_empty() {
        return Err(Unusable::NoAnchors);
    }
    let mut found = None;
    let mut heads = Vec::new();
    for (output, (name, shape)) in outputs.iter().enumerate() {
        let ways = layouts(shape, input);
        let fitting = ways.into_iter().find_map(|(layout, grid, numbers)| {
            let entry = sidecar.heads.iter().find(|entry| entry.stride * grid[0] == input[0])?;
            let count = entry.anchors.len();
            let each = numbers.checked_div(count)?;
            (each * count == numbers && each > 5).then_some((layout, grid, each - 5, entry))
        });
        let Some((layout, grid, classes, entry)) = fitting else {
            return Err(misfit(format!(
                "no entry of `heads` has the stride and anchors of {name} {shape:?}"
            )));
        };
        if *found.get_or_insert(classes) != classes {
            return Err(misfit("its heads differ in their classes".to_owned()));
        }
        heads.push(BoundHead { output, layout, grid, head: entry.clone() });
    }
    found.map(|classes| (classes, heads)).ok_or_else(|| misfit("there are no outputs".to_owned()))
}
