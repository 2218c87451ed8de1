//! Cuts a small picture of each object found.

use super::{ChipFolder, ExportError};
use crate::Error;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_objects::{Detection, Mark, Picture, Raster, Rect, Scored, TILE_PX, level};
use std::path::Path;

/// Pixels around a box, so that the object is seen against its surroundings.
const AROUND_PX: f32 = 24.0;

/// The boxes of a log, and the recording and raster that their chips are cut from.
pub struct ChipLog<'a> {
    /// The recording.
    pub survey: &'a Survey,
    /// Raster of the log.
    pub raster: Raster,
    /// Boxes of the log.
    pub found: &'a [Detection],
}

/// Writes the [`chip`] of each box of the logs, one log after the other, into the folder of chips
/// in `folder`: `0001-rock.png` and so on.
///
/// # Errors
/// When a picture cannot be written, or the work was cancelled.
pub fn chips(
    folder: &Path,
    names: &[String],
    logs: &[ChipLog<'_>],
    progress: &Progress,
) -> Result<ChipFolder, Error> {
    let count: usize = logs.iter().map(|log| log.found.len()).sum();
    progress.start(count as u64);
    let mut chips = ChipFolder::begin(folder, names)?;
    for log in logs {
        for found in log.found {
            progress.check()?;
            chips.add(found.class, &chip(log.survey, &log.raster, &found.mark))?;
            progress.advance(1);
        }
    }
    Ok(chips)
}

/// Returns the picture of a box of a survey with its surroundings: range to the right, levels as
/// the detector's input. Pixels are those of the raster, or larger where the box would not fit into
/// a tile, so that a hull is shown as a whole.
pub fn chip(survey: &Survey, raster: &Raster, mark: &Mark) -> Picture {
    let rect = raster.rect_of(mark);
    let room_px = TILE_PX as f32 - 2.0 * AROUND_PX - 1.0;
    let factor = (rect.x1 - rect.x0).max(rect.y1 - rect.y0) / room_px;
    let coarser;
    let raster = if factor > 1.0 {
        coarser = raster.coarser(f64::from(factor));
        &coarser
    } else {
        raster
    };
    let (x, y, width, height) = around(&raster.rect_of(mark));
    let (width, height) = (width.min(TILE_PX), height.min(TILE_PX));
    let mut tile = raster.tile(survey, mark.side, y, x);
    level(&mut tile.pixels);
    Picture::grey(TILE_PX, TILE_PX, tile.pixels).piece(0, 0, width, height)
}

/// Writes the chips of boxes in a picture of another program into the folder of chips in `folder`.
pub(crate) fn picture_chips(
    folder: &Path,
    picture: &Picture,
    names: &[String],
    boxes: &[Scored],
) -> Result<ChipFolder, ExportError> {
    let mut chips = ChipFolder::begin(folder, names)?;
    for found in boxes {
        let (x, y, width, height) = around(&found.rect);
        let width = width.min(picture.width.saturating_sub(x));
        let height = height.min(picture.height.saturating_sub(y));
        let chip = picture.piece(x, y, width, height);
        chips.add(found.class, &chip)?;
    }
    Ok(chips)
}

/// Returns the first column and row, and the number of columns and rows, of a box and its
/// surroundings.
fn around(rect: &Rect) -> (usize, usize, usize, usize) {
    // `as` saturates, and a box's edges are finite.
    let first = |edge: f32| (edge - AROUND_PX).max(0.0) as usize;
    let (x, y) = (first(rect.x0), first(rect.y0));
    let size = |first: usize, edge: f32| ((edge + AROUND_PX) as usize).saturating_sub(first).max(1);
    (x, y, size(x, rect.x1), size(y, rect.y1))
}
