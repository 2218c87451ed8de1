//! Searches a whole survey, or a picture from another program, for objects, tile by tile.

use super::merge::{TileDetection, merge};
use super::{DetectError, Detection, Model, Nms, Picture, Raster, Rect, Scored, TILE_PX};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Navigation, Side, Survey};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Share of a tile that it has in common with its neighbour: an object up to that length is whole
/// in one of the two tiles.
const OVERLAP: f32 = 0.25;
/// Greatest size of a picture that is searched as a whole, as a multiple of the network's input.
const WHOLE: f32 = 1.5;
/// Number of reports of a search, approximately.
const REPORTS: usize = 100;

/// `detector.*` settings: which model is used, and which boxes count.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetectorSettings {
    /// File of a model to use; if `None`, the model that comes with the program.
    pub model: Option<PathBuf>,
    /// Least score, 0 to 1; if `None`, that of the model.
    pub score: Option<f32>,
    /// Overlap above which the box of the lower score is dropped, 0 to 1; if `None`, that of the
    /// model.
    pub iou: Option<f32>,
    /// Least score of a box that keeps its class, 0 to 1; below it the box gets the class of
    /// unknown objects. If `None`, that of the model.
    pub name_score: Option<f32>,
}

/// Result of a search so far.
#[derive(Clone, Debug, PartialEq)]
pub struct SoFar {
    /// The boxes in the pings that were searched, each object once, in order of the pings.
    pub boxes: Vec<Detection>,
    /// Pings from the log's start on that were searched on both sides.
    pub pings: usize,
    /// Number of tiles that were searched.
    pub tiles: usize,
}

/// Searches both sides of a survey from its start to its end, tiles in parallel. `on_found`
/// receives the result so far, from any thread, each time with more pings; if the search is
/// cancelled, the last of these results can be kept. The result has each object once (see `merge`),
/// in order of the pings.
///
/// # Errors
/// When the work was cancelled, or the model cannot be used on this picture.
pub fn find(
    survey: &Survey,
    navigation: &Navigation,
    model: &Model,
    settings: &DetectorSettings,
    progress: &Progress,
    on_found: impl Fn(SoFar) + Sync,
) -> Result<Vec<Detection>, DetectError> {
    let raster = Raster::new(survey, navigation, model.pixel_m);
    let is_recorded = |&side: &Side| survey.side_scan.iter().any(|ping| ping.side(side).is_some());
    let sides: Vec<Side> = Side::BOTH.into_iter().filter(is_recorded).collect();
    let grid = TileGrid::new([raster.columns, raster.rows()], [TILE_PX; 2]);
    let draw = |side: usize, [column, row]: [usize; 2]| {
        let pixels = if raster.is_recorded(survey, sides[side], row, column) {
            raster.tile(survey, sides[side], row, column).pixels
        } else {
            vec![0; TILE_PX * TILE_PX]
        };
        Picture::grey(TILE_PX, TILE_PX, pixels)
    };
    let as_detections = |found: Vec<Vec<Scored>>| {
        let mut all: Vec<Detection> = (found.into_iter().zip(&sides))
            .flat_map(|(boxes, &side)| {
                let raster = &raster;
                boxes.into_iter().map(move |found| Detection {
                    class: found.class,
                    score: found.score,
                    mark: raster.mark_of(side, &found.rect),
                })
            })
            .collect();
        all.sort_by_key(|found| (found.mark.pings.start, found.mark.side));
        all
    };
    let on_found = |found: Vec<Vec<Scored>>, tiles: usize, rows: f32| {
        let is_all = rows >= raster.rows() as f32;
        on_found(SoFar {
            boxes: as_detections(found),
            pings: if is_all {
                survey.side_scan.len()
            } else {
                // A ping counts once its whole width has been searched.
                raster.ping_of(f64::from(rows)) as usize
            },
            tiles,
        });
    };
    let found = search(&grid, sides.len(), draw, model, settings, progress, on_found)?;
    Ok(as_detections(found))
}

/// Searches a picture, whole or in tiles of the network's own size. Returns the boxes by falling
/// score, in the picture's pixels.
///
/// # Errors
/// When the work was cancelled, or the model cannot be used on this picture.
pub fn find_in_picture(
    picture: &Picture,
    model: &Model,
    settings: &DetectorSettings,
    progress: &Progress,
) -> Result<Vec<Scored>, DetectError> {
    let size = [picture.width, picture.height];
    let input = model.input_size();
    let fits = (0..2).all(|axis| size[axis] as f32 <= WHOLE * input[axis] as f32);
    let grid = TileGrid::new(size, if fits { size } else { input });
    let draw = |_: usize, [x, y]: [usize; 2]| picture.piece(x, y, grid.tile[0], grid.tile[1]);
    let found = search(&grid, 1, draw, model, settings, progress, |_, _, _| ())?;
    Ok(found.into_iter().next().unwrap_or_default())
}

/// Draws and searches every tile of some pictures of one size, in parallel and from the first row
/// of tiles to the last, and merges the boxes of the tiles. Returns the objects of each picture.
/// `on_found` receives the objects, the tiles and the rows of pixels so far.
fn search(
    grid: &TileGrid,
    pictures: usize,
    draw: impl Fn(usize, [usize; 2]) -> Picture + Sync,
    model: &Model,
    settings: &DetectorSettings,
    progress: &Progress,
    on_found: impl Fn(Vec<Vec<Scored>>, usize, f32) + Sync,
) -> Result<Vec<Vec<Scored>>, DetectError> {
    let score = settings.score.unwrap_or(model.score);
    let iou = settings.iou.unwrap_or(model.iou);
    let [width, height] = grid.size.map(|size| size as f32);
    let look = |picture: usize, tile: usize| -> Result<Vec<TileDetection>, DetectError> {
        progress.check()?;
        let (place, tile) = grid.place(tile);
        let picture = draw(picture, place);
        // The tile lies beyond the survey's range, or its side was off.
        let boxes = if picture.levels.iter().all(|&level| level == 0) {
            Vec::new()
        } else {
            model.detect(&picture, score, iou)?
        };
        progress.advance(1);
        Ok(boxes
            .into_iter()
            .filter_map(|found| inside(found, [width - tile.x0, height - tile.y0]))
            .map(|found| TileDetection::new(found, tile, width, height))
            .collect())
    };
    let count = grid.count() * pictures;
    progress.start(count as u64);
    let gathered = Mutex::new(Gathered::new(grid, pictures));
    // Names are dropped after the tiles are merged, since the merge joins pieces of one object by
    // their class.
    let name_score = settings.name_score.unwrap_or(model.name_score);
    let named = |mut found: Vec<Vec<Scored>>| {
        for found_box in found.iter_mut().flatten() {
            if found_box.score < name_score {
                found_box.class = model.nameless;
            }
        }
        found
    };
    // A bridge hands the tiles out in their order, so that the searched part is always the survey's
    // beginning and not scattered pieces.
    (0..count).par_bridge().try_for_each(|index| {
        let (picture, tile) = grid.of_picture(index, pictures);
        let seen = look(picture, tile)?;
        let mut gathered = gathered.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(rows) = gathered.add(picture, tile, seen) {
            let found = named(gathered.merged(rows, model.nms, iou));
            let tiles = rows * grid.counts[0] * pictures;
            on_found(found, tiles, grid.end_of(rows));
        }
        Ok::<(), DetectError>(())
    })?;
    let gathered = gathered.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(named(gathered.merged(grid.counts[1], model.nms, iou)))
}

/// Boxes of the tiles that have been searched so far.
struct Gathered<'a> {
    grid: &'a TileGrid,
    /// Boxes of each tile, by picture and by tile.
    seen: Vec<Vec<Vec<TileDetection>>>,
    /// Number of tiles that are not searched yet in each row, over all pictures.
    missing: Vec<usize>,
    /// Number of rows that are done, without a gap, and how many of them were reported.
    done: usize,
    reported: usize,
}

impl<'a> Gathered<'a> {
    fn new(grid: &'a TileGrid, pictures: usize) -> Self {
        let [across, rows] = grid.counts;
        Self {
            grid,
            seen: vec![vec![Vec::new(); grid.count()]; pictures],
            missing: vec![across * pictures; rows],
            done: 0,
            reported: 0,
        }
    }

    /// Stores the boxes of a tile. Returns the number of rows that are done if a report is due.
    fn add(&mut self, picture: usize, tile: usize, seen: Vec<TileDetection>) -> Option<usize> {
        let row = tile / self.grid.counts[0];
        self.seen[picture][tile] = seen;
        self.missing[row] -= 1;
        while self.missing.get(self.done) == Some(&0) {
            self.done += 1;
        }
        let rows = self.missing.len();
        // Reports are few because merging takes time in proportion to all boxes found so far.
        let is_due = self.done - self.reported >= rows.div_ceil(REPORTS) || self.done == rows;
        (is_due && self.done > self.reported).then(|| {
            self.reported = self.done;
            self.done
        })
    }

    /// Returns the objects of each picture in its first `rows` rows of tiles. A box that continues
    /// behind these rows is left out: it lies whole in the next row.
    fn merged(&self, rows: usize, nms: Nms, iou: f32) -> Vec<Vec<Scored>> {
        let is_all = rows == self.missing.len();
        let end = self.grid.end_of(rows);
        let is_whole = |seen: &TileDetection| is_all || !seen.is_cut_at(end);
        (self.seen.iter())
            .map(|picture| {
                let tiles = &picture[..rows * self.grid.counts[0]];
                let seen = tiles.iter().flatten().filter(|detection| is_whole(detection));
                merge(seen.copied().collect(), nms, iou)
            })
            .collect()
    }
}

/// Returns a box cut at the end of the picture, for a tile that reaches beyond it; `None` if most
/// of the box lies beyond: there, the edge itself looks like an object.
fn inside(found: Scored, [width, height]: [f32; 2]) -> Option<Scored> {
    let rect = found.rect.intersection(&Rect::new([0.0, 0.0], [width, height]));
    (rect.area() >= 0.5 * found.rect.area()).then_some(Scored { rect, ..found })
}

/// A grid of overlapping tiles over a picture.
struct TileGrid {
    /// Pixels across and down of the picture.
    size: [usize; 2],
    /// Pixels across and down of a tile.
    tile: [usize; 2],
    /// Tiles across and down.
    counts: [usize; 2],
}

impl TileGrid {
    fn new(size: [usize; 2], tile: [usize; 2]) -> Self {
        let counts = [0, 1].map(|axis| match size[axis] {
            0 => 0,
            size => 1 + size.saturating_sub(tile[axis]).div_ceil(step(tile[axis])),
        });
        Self { size, tile, counts }
    }

    fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// Returns the picture and its tile, both by index, that are searched as the `index`th: the
    /// order is one row of tiles of all pictures, then the next row.
    fn of_picture(&self, index: usize, pictures: usize) -> (usize, usize) {
        let [across, _] = self.counts;
        let (row, rest) = (index / (across * pictures), index % (across * pictures));
        (rest / across, row * across + rest % across)
    }

    /// Returns the row of pixels at which the first `rows` rows of tiles end, excluded.
    fn end_of(&self, rows: usize) -> f32 {
        match rows {
            0 => 0.0,
            rows if rows >= self.counts[1] => self.size[1] as f32,
            rows => self.place((rows - 1) * self.counts[0]).1.y1,
        }
    }

    /// Returns the tile's first pixel, across and down, and its edges. The last tile of a row ends
    /// with the picture, so that a tile reaches beyond the picture only if it is larger.
    fn place(&self, index: usize) -> ([usize; 2], Rect) {
        let at = [index % self.counts[0], index / self.counts[0]];
        let place = [0, 1].map(|axis| {
            let last = self.size[axis].saturating_sub(self.tile[axis]);
            (at[axis] * step(self.tile[axis])).min(last)
        });
        let [x0, y0] = place.map(|first| first as f32);
        let rect = Rect::new([x0, y0], [x0 + self.tile[0] as f32, y0 + self.tile[1] as f32]);
        (place, rect)
    }
}

/// Returns the pixels from one tile to the next.
fn step(tile: usize) -> usize {
    ((tile as f32 * (1.0 - OVERLAP)) as usize).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_beyond_the_picture_is_no_object() {
        let found = |x0, x1| Scored::new(0, 0.5, Rect::new([x0, 0.0], [x1, 10.0]));
        let edges =
            |x0, x1| inside(found(x0, x1), [375.0, 416.0]).map(|found_box| found_box.rect.x1);
        assert_eq!(edges(300.0, 320.0), Some(320.0));
        assert_eq!(edges(360.0, 380.0), Some(375.0));
        assert_eq!(edges(370.0, 390.0), None);
    }

    #[test]
    fn rows_of_tiles_are_reported_once_all_before_them_are_done() {
        // Three rows of two tiles, in two pictures.
        let grid = TileGrid::new([500, 1000], [416, 416]);
        assert_eq!(grid.counts, [2, 3]);
        let mut gathered = Gathered::new(&grid, 2);
        let seen = |tile: usize, [y0, y1]: [f32; 2]| {
            let tile = grid.place(tile).1;
            let rect = Rect::new([10.0, y0 - tile.y0], [20.0, y1 - tile.y0]);
            let found = Scored::new(0, 0.5, rect);
            vec![TileDetection::new(found, tile, 500.0, 1000.0)]
        };
        let places: Vec<(usize, usize)> = (0..12).map(|index| grid.of_picture(index, 2)).collect();
        assert_eq!(places[..5], [(0, 0), (0, 1), (1, 0), (1, 1), (0, 2)]);
        let add = |gathered: &mut Gathered<'_>, index: usize, rows: [f32; 2]| {
            let (picture, tile) = places[index];
            gathered.add(picture, tile, seen(tile, rows))
        };
        assert_eq!(add(&mut gathered, 0, [400.0, 416.0]), None);
        // The second row is done before the first.
        for index in 4..8 {
            assert_eq!(add(&mut gathered, index, [400.0, 430.0]), None);
        }
        assert_eq!(add(&mut gathered, 1, [30.0, 50.0]), None);
        assert_eq!(add(&mut gathered, 2, [100.0, 120.0]), None);
        assert_eq!(add(&mut gathered, 3, [390.0, 416.0]), Some(2));
        let first = gathered.merged(1, Nms::default(), 0.45);
        let starts =
            |found: &[Scored]| found.iter().map(|found_box| found_box.rect.y0).collect::<Vec<_>>();
        // An object that the first row of tiles cuts off at its end is not reported yet; two rows
        // show it whole.
        assert_eq!([starts(&first[0]), starts(&first[1])], [[30.0], [100.0]]);
        assert_eq!(gathered.merged(2, Nms::default(), 0.45)[0].len(), 3);
        assert_eq!((grid.end_of(1), grid.end_of(3)), (416.0, 1000.0));
    }

    #[test]
    fn tiles_cover_the_picture_and_overlap() {
        let grid = TileGrid::new([1000, 300], [416, 416]);
        let places: Vec<[usize; 2]> = (0..grid.count()).map(|index| grid.place(index).0).collect();
        assert_eq!(places, [[0, 0], [312, 0], [584, 0]]);
        assert_eq!(TileGrid::new([416, 417], [416, 416]).count(), 2);
        assert_eq!(TileGrid::new([0, 100], [416, 416]).count(), 0);
    }
}
