//! Pictures with known boxes, as detectors are trained and judged on: chips, and the label files that tools read.
//!
//! `chip` cuts a tile and decides which boxes it may be asked for, `visible` whether a box can be seen at all; `yolo`,
//! `coco` and `voc` write the labels. The same code serves simulated surveys and reviewed ones.

mod chip;
mod coco;
mod visible;
mod voc;
mod yolo;

pub use chip::{Boxes, Chip, Known};
pub use coco::Coco;
pub use visible::{Contrast, Standing};
pub use voc::voc_xml;
pub use yolo::yolo_lines;

#[cfg(test)]
mod tests;
