//! A small picture of each object found.

use super::{ExportError, write_aside};
use crate::detection::{Detection, Picture, Raster, Rect, Scored, TILE_PX, level};
use crate::progress::{Cancelled, Progress};
use crate::survey::Survey;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

/// Pixels around a box, so that the eye sees what the object stands out from.
const AROUND_PX: f32 = 24.0;

/// Chips that were not written.
#[derive(Debug, thiserror::Error)]
pub enum ChipError {
    /// One of the files.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// It was told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Writes `0001-rock.png` and so on into `folder`: each box of a survey with its surroundings, range to the right, a pixel the
/// raster's, levels as a detector sees them. Of a box longer than a tile its beginning is shown.
pub fn chips(
    folder: &Path,
    survey: &Survey,
    raster: &Raster,
    names: &[String],
    detections: &[Detection],
    progress: &Progress,
) -> Result<(), ChipError> {
    progress.start(detections.len() as u64);
    for (index, found) in detections.iter().enumerate() {
        progress.check()?;
        let (x, y, width, height) = around(&raster.rect_of(&found.mark));
        let (width, height) = (width.min(TILE_PX), height.min(TILE_PX));
        let mut tile = raster.tile(survey, found.mark.side, y, x);
        level(&mut tile.pixels);
        let chip = Picture::grey(TILE_PX, TILE_PX, tile.pixels).piece(0, 0, width, height);
        write(folder, index, names, found.class, &chip)?;
        progress.advance(1);
    }
    Ok(())
}

/// The same for a picture of another program.
pub fn picture_chips(
    folder: &Path,
    picture: &Picture,
    names: &[String],
    boxes: &[Scored],
) -> Result<(), ExportError> {
    for (index, found) in boxes.iter().enumerate() {
        let (x, y, width, height) = around(&found.rect);
        let width = width.min(picture.width.saturating_sub(x));
        let height = height.min(picture.height.saturating_sub(y));
        let chip = picture.piece(x, y, width, height);
        write(folder, index, names, found.class, &chip)?;
    }
    Ok(())
}

/// First column and row, columns and rows of a box and its surroundings.
fn around(rect: &Rect) -> (usize, usize, usize, usize) {
    // `as` saturates, and a box's edges are finite.
    let first = |edge: f32| (edge - AROUND_PX).max(0.0) as usize;
    let (x, y) = (first(rect.x0), first(rect.y0));
    let size = |first: usize, edge: f32| ((edge + AROUND_PX) as usize).saturating_sub(first).max(1);
    (x, y, size(x, rect.x1), size(y, rect.y1))
}

fn write(
    folder: &Path,
    index: usize,
    names: &[String],
    class: usize,
    chip: &Picture,
) -> Result<(), ExportError> {
    let name = names.get(class).map_or("object", String::as_str);
    let path = folder.join(format!("{:04}-{}.png", index + 1, file_safe(name)));
    let colour = if chip.channels == 3 {
        ExtendedColorType::Rgb8
    } else {
        ExtendedColorType::L8
    };
    write_aside(&path, |file| {
        let mut out = BufWriter::new(file);
        PngEncoder::new(&mut out)
            .write_image(&chip.levels, chip.width as u32, chip.height as u32, colour)
            .map_err(io::Error::other)?;
        out.flush()
    })
}

/// A class name, which a model's file may have chosen, as part of a file name: letters, digits and hyphens.
fn file_safe(name: &str) -> String {
    let letters = name.chars().take(40);
    letters
        .map(|letter| {
            if letter.is_alphanumeric() {
                letter
            } else {
                '-'
            }
        })
        .collect()
}
