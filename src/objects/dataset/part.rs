//! Finds the part of a known object that lies in a tile.
//!
//! A tile's edge may cut an object. Where it is known what each ping shows, the box is that of the
//! part in the tile: of a slanting pipe whose upper half is cut away only the lower half has a box.

use crate::{Mark, Raster, RasterTile, Rect, TILE_PX};
use bathyscope_log::survey::Side;

/// An object whose place is known.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownObject {
    /// Index into the class names.
    pub class: usize,
    /// Around what is shown of its echo and its shadow.
    pub whole: Mark,
    /// True if anything is shown of it. What a person has seen is.
    pub shown: bool,
    /// Part of the object on each ping, in the order of the pings; empty where only its box is
    /// known.
    pub slices: Vec<Slice>,
}

/// Part of an object on one ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// The ping.
    pub ping: usize,
    /// Nearest slant range that shows it, metres.
    pub near_m: f64,
    /// Farthest slant range that shows it, metres.
    pub far_m: f64,
    /// Contribution to the object's visibility: an observer distinguishes the object from chance
    /// where the sum reaches 1.
    pub visibility: f32,
}

impl Slice {
    fn mark(&self, side: Side) -> Mark {
        Mark::new(side, self.ping..self.ping + 1, [self.near_m, self.far_m])
    }
}

/// The part of an object in a tile.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ObjectPart {
    /// The box around it, in the tile.
    pub rect: Rect,
    /// Its outline as a polygon of columns and rows; empty where only the object's box is known.
    pub outline: Vec<[f32; 2]>,
    /// Share of the object in this part: of its visibility, or of its box.
    share: f32,
    /// True if it can be seen at all.
    shown: bool,
}

/// Least share of an object that lies in the tile.
const LEAST_SHARE: f32 = 0.4;
/// Least width and height of a box, pixels.
const LEAST_PX: f32 = 6.0;

impl ObjectPart {
    /// Returns true if a detector may be asked for it: something of it is shown, it is at least 6
    /// pixels wide and high, and at least 40 % of the object; of an object known ping by ping, what
    /// lies in the tile must be visible by itself.
    pub(crate) fn is_plain(&self) -> bool {
        let large = (self.rect.x1 - self.rect.x0).min(self.rect.y1 - self.rect.y0) >= LEAST_PX;
        self.shown && large && self.share >= LEAST_SHARE
    }
}

impl KnownObject {
    /// Returns true if the whole of it may be asked for, as [`ObjectPart::is_plain`] says.
    pub fn is_plain(&self, raster: &Raster) -> bool {
        let rect = raster.rect_of(&self.whole);
        self.part(rect, 1.0).is_plain()
    }

    /// Returns the part of it that lies in a tile of its side; `None` where there is none.
    pub(crate) fn part_in(&self, tile: &RasterTile, raster: &Raster) -> Option<ObjectPart> {
        let place = |mark: &Mark| {
            let rect = raster.rect_of(mark);
            rect.shifted(-(tile.column as f32), -(tile.row as f32))
        };
        let whole = place(&self.whole);
        let inside = whole.intersection(&FRAME);
        if inside.area() <= 0.0 {
            return None;
        }
        if self.slices.is_empty() {
            return Some(self.part(inside, inside.area() / whole.area()));
        }
        let rows = self.slices.iter().filter_map(|slice| {
            let row = place(&slice.mark(self.whole.side));
            let cut = row.intersection(&FRAME);
            (cut.area() > 0.0).then(|| (cut, slice.visibility * cut.area() / row.area()))
        });
        self.part_of_rows(&rows.collect::<Vec<_>>())
    }

    /// The part that some rows, and what remains of their visibility, are; `None` where there are
    /// none, as in a gap.
    fn part_of_rows(&self, rows: &[(Rect, f32)]) -> Option<ObjectPart> {
        let (first, others) = rows.split_first()?;
        let around = others.iter().fold(first.0, |sum, (row, _)| sum.hull(row));
        let visibility: f32 = rows.iter().map(|(_, visibility)| visibility).sum();
        let all: f32 = self.slices.iter().map(|slice| slice.visibility).sum();
        Some(ObjectPart {
            outline: outline(rows),
            shown: self.shown && visibility >= 1.0,
            ..self.part(around, visibility / all)
        })
    }

    fn part(&self, rect: Rect, share: f32) -> ObjectPart {
        ObjectPart { rect, outline: Vec::new(), share, shown: self.shown }
    }
}

/// Down the near edges of the rows, and up the far ones.
fn outline(rows: &[(Rect, f32)]) -> Vec<[f32; 2]> {
    let near = rows.iter().flat_map(|(row, _)| [[row.x0, row.y0], [row.x0, row.y1]]);
    let far = rows.iter().rev();
    let far = far.flat_map(|(row, _)| [[row.x1, row.y1], [row.x1, row.y0]]);
    near.chain(far).collect()
}

/// The tile.
const FRAME: Rect = Rect::new([0.0, 0.0], [TILE_PX as f32, TILE_PX as f32]);
