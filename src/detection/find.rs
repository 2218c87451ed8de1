//! Searches a whole survey, or a picture of another program, tile by tile.

use super::merge::{Seen, merge};
use super::{DetectError, Detection, Model, Picture, Raster, Rect, Scored, TILE_PX};
use crate::progress::Progress;
use crate::survey::{Navigation, Side, Survey};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Share of a tile that its neighbour sees as well: an object up to that length is whole in one of them.
const OVERLAP: f32 = 0.25;
/// A picture up to this many times the network's input is looked at as a whole.
const WHOLE: f32 = 1.5;

/// `detector.*` settings: who is asked, and which boxes count.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetectorSettings {
    /// Another model than the one that comes with the program.
    pub model: Option<PathBuf>,
    /// Least confidence, 0 to 1; without one the model's own.
    pub score: Option<f32>,
    /// Overlap above which the less sure of two boxes is dropped, 0 to 1; without one the model's own.
    pub iou: Option<f32>,
}

/// Searches both sides of a survey, tiles in parallel. `on_tile` hears of each tile's boxes as they come, from any thread; the
/// result has each object once (see `merge`), in order of the pings.
pub fn find(
    survey: &Survey,
    navigation: &Navigation,
    model: &Model,
    settings: &DetectorSettings,
    progress: &Progress,
    on_tile: impl Fn(&[Detection]) + Sync,
) -> Result<Vec<Detection>, DetectError> {
    let raster = Raster::new(survey, navigation, model.pixel_m());
    let sides: Vec<Side> = Side::BOTH
        .into_iter()
        .filter(|&side| recorded(survey, side))
        .collect();
    let grid = Grid::new([raster.columns(), raster.rows()], [TILE_PX; 2]);
    progress.start((sides.len() * grid.count()) as u64);
    let as_detections = |side: Side, boxes: &mut dyn Iterator<Item = Scored>| -> Vec<Detection> {
        boxes
            .map(|found| Detection {
                class: found.class,
                score: found.score,
                mark: raster.mark_of(side, &found.rect),
            })
            .collect()
    };
    let mut all = Vec::new();
    for side in sides {
        let draw = |[column, row]: [usize; 2]| {
            let tile = raster.tile(survey, side, row, column);
            Picture::grey(TILE_PX, TILE_PX, tile.pixels)
        };
        let hear = |seen: &[Seen]| {
            on_tile(&as_detections(side, &mut seen.iter().map(|one| one.found)));
        };
        let boxes = search(&grid, draw, model, settings, progress, hear)?;
        all.extend(as_detections(side, &mut boxes.into_iter()));
    }
    all.sort_by_key(|found| (found.mark.pings.start, found.mark.side));
    Ok(all)
}

/// Searches a picture, whole or in tiles of the network's own size; boxes by falling score, in the picture's pixels.
pub fn find_in_picture(
    picture: &Picture,
    model: &Model,
    settings: &DetectorSettings,
    progress: &Progress,
) -> Result<Vec<Scored>, DetectError> {
    let size = [picture.width, picture.height];
    let input = model.input_size();
    let fits = (0..2).all(|axis| size[axis] as f32 <= WHOLE * input[axis] as f32);
    let grid = Grid::new(size, if fits { size } else { input });
    progress.start(grid.count() as u64);
    let draw = |[x, y]: [usize; 2]| picture.piece(x, y, grid.tile[0], grid.tile[1]);
    search(&grid, draw, model, settings, progress, |_| ())
}

fn recorded(survey: &Survey, side: Side) -> bool {
    survey
        .side_scan
        .iter()
        .any(|ping| ping.side(side).is_some())
}

/// Draws and searches every tile, in parallel, and merges what they saw.
fn search(
    grid: &Grid,
    draw: impl Fn([usize; 2]) -> Picture + Sync,
    model: &Model,
    settings: &DetectorSettings,
    progress: &Progress,
    hear: impl Fn(&[Seen]) + Sync,
) -> Result<Vec<Scored>, DetectError> {
    let score = settings.score.unwrap_or(model.score());
    let iou = settings.iou.unwrap_or(model.iou());
    let [width, height] = grid.size.map(|size| size as f32);
    let one = |index: usize| -> Result<Vec<Seen>, DetectError> {
        progress.check()?;
        let (place, tile) = grid.place(index);
        let picture = draw(place);
        // Beyond the survey's range, or a side that was off.
        let boxes = if picture.levels.iter().all(|&level| level == 0) {
            Vec::new()
        } else {
            model.detect(&picture, score, iou)?
        };
        let seen: Vec<Seen> = boxes
            .into_iter()
            .filter_map(|found| inside(found, [width - tile.x0, height - tile.y0]))
            .map(|found| Seen::new(found, tile, width, height))
            .collect();
        progress.advance(1);
        hear(&seen);
        Ok(seen)
    };
    let seen: Vec<Vec<Seen>> = (0..grid.count())
        .into_par_iter()
        .map(one)
        .collect::<Result<_, _>>()?;
    Ok(merge(seen.concat(), model.nms(), iou))
}

/// A box cut at the picture's end, which lies within a tile that is larger; `None` where most of it lies beyond: what looks
/// like an object there is the edge itself.
fn inside(found: Scored, [width, height]: [f32; 2]) -> Option<Scored> {
    let rect = found.rect.intersection(&Rect {
        x0: 0.0,
        y0: 0.0,
        x1: width,
        y1: height,
    });
    (rect.area() >= 0.5 * found.rect.area()).then_some(Scored { rect, ..found })
}

/// Tiles over a picture, overlapping.
struct Grid {
    /// Pixels across and down of the picture.
    size: [usize; 2],
    /// Pixels across and down of a tile.
    tile: [usize; 2],
    /// Tiles across and down.
    counts: [usize; 2],
}

impl Grid {
    fn new(size: [usize; 2], tile: [usize; 2]) -> Self {
        let counts = [0, 1].map(|axis| {
            let beyond = size[axis].saturating_sub(tile[axis]);
            match size[axis] {
                0 => 0,
                _ => 1 + beyond.div_ceil(step(tile[axis])),
            }
        });
        Self { size, tile, counts }
    }

    fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// The tile's first pixel, across and down, and its edges. The last tile of a row ends with the picture, so that no tile
    /// but one larger than the picture reaches beyond it.
    fn place(&self, index: usize) -> ([usize; 2], Rect) {
        let at = [index % self.counts[0], index / self.counts[0]];
        let place = [0, 1].map(|axis| {
            let last = self.size[axis].saturating_sub(self.tile[axis]);
            (at[axis] * step(self.tile[axis])).min(last)
        });
        let [x0, y0] = place.map(|first| first as f32);
        let rect = Rect {
            x0,
            y0,
            x1: x0 + self.tile[0] as f32,
            y1: y0 + self.tile[1] as f32,
        };
        (place, rect)
    }
}

/// Pixels from a tile to the next.
fn step(tile: usize) -> usize {
    ((tile as f32 * (1.0 - OVERLAP)) as usize).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_beyond_the_picture_is_no_object() {
        let found = |x0, x1| Scored {
            class: 0,
            score: 0.5,
            rect: Rect {
                x0,
                y0: 0.0,
                x1,
                y1: 10.0,
            },
        };
        let edges = |x0, x1| inside(found(x0, x1), [375.0, 416.0]).map(|one| one.rect.x1);
        assert_eq!(edges(300.0, 320.0), Some(320.0));
        assert_eq!(edges(360.0, 380.0), Some(375.0));
        assert_eq!(edges(370.0, 390.0), None);
    }

    #[test]
    fn tiles_cover_the_picture_and_overlap() {
        let grid = Grid::new([1000, 300], [416, 416]);
        let places: Vec<[usize; 2]> = (0..grid.count()).map(|index| grid.place(index).0).collect();
        assert_eq!(places, [[0, 0], [312, 0], [584, 0]]);
        assert_eq!(Grid::new([416, 417], [416, 416]).count(), 2);
        assert_eq!(Grid::new([0, 100], [416, 416]).count(), 0);
    }
}
