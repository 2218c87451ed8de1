//! Pictures with known boxes, as detectors are trained and judged on: chips, and the label files
//! that tools read.
//!
//! In: tiles of a survey, and the objects known in them. Out: pictures, and texts of labels.
//!
//! `chip` cuts a tile and decides which boxes it may be asked for, `part` what of an object lies in
//! a tile; `yolo`, `coco` and `voc` write the labels. The same code serves simulated surveys and
//! reviewed ones.

mod chip;
mod coco;
mod part;
mod voc;
mod yolo;

pub use chip::{Chip, PictureBoxes};
pub use coco::Coco;
pub use part::{KnownObject, Slice};
pub use voc::voc_xml;
pub use yolo::yolo_lines;

#[cfg(test)]
mod tests;
