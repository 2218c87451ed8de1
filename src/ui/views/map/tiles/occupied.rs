//! Finds the blocks of a tile's picture that are not empty: most of a tile along a track is empty,
//! and empty blocks are not drawn.

use egui::ColorImage;

/// Blocks along a side of a picture.
const BLOCKS: usize = 8;

/// A part of a picture: left, top, right and bottom as shares.
pub(super) type PicturePart = [f32; 4];

/// The blocks with something in them, a bit each, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Occupied(u64);

impl Occupied {
    /// The blocks of a picture that are not transparent, or that a neighbour's texel reaches into
    /// when it is magnified.
    pub(super) fn of(image: &ColorImage) -> Self {
        let [width, height] = image.size;
        let mut bits = 0;
        for (y, row) in image.pixels.chunks(width.max(1)).enumerate() {
            for (x, texel) in row.iter().enumerate() {
                if texel.a() == 0 {
                    continue;
                }
                let block = |place: usize, side: usize| place.min(side - 1) * BLOCKS / side;
                for y in [y.saturating_sub(1), y + 1] {
                    for x in [x.saturating_sub(1), x + 1] {
                        bits |= 1 << (BLOCKS * block(y, height) + block(x, width));
                    }
                }
            }
        }
        Self(bits)
    }

    /// Returns the rectangles to draw of a part of the picture: one for each run of blocks in a
    /// row.
    pub(super) fn within(self, [left, top, right, bottom]: PicturePart) -> Vec<PicturePart> {
        let mut parts = Vec::new();
        if self.0 == u64::MAX {
            parts.push([left, top, right, bottom]);
            return parts;
        }
        let share = |block: usize| block as f32 / BLOCKS as f32;
        for row in 0..BLOCKS {
            let [top, bottom] = [top.max(share(row)), bottom.min(share(row + 1))];
            let mut column = 0;
            while column < BLOCKS {
                let end = (column..BLOCKS).find(|column| !self.holds(row, *column));
                let end = end.unwrap_or(BLOCKS);
                let [from, to] = [left.max(share(column)), right.min(share(end))];
                if from < to && top < bottom {
                    parts.push([from, top, to, bottom]);
                }
                column = end + 1;
            }
        }
        parts
    }

    fn holds(self, row: usize, column: usize) -> bool {
        self.0 >> (BLOCKS * row + column) & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::Color32;

    fn with(texels: &[[usize; 2]]) -> Occupied {
        let mut image = ColorImage::filled([80, 80], Color32::TRANSPARENT);
        for [x, y] in texels {
            image.pixels[80 * y + x] = Color32::WHITE;
        }
        Occupied::of(&image)
    }

    #[test]
    fn nothing_is_drawn_of_an_empty_picture_and_all_of_a_full_one_at_once() {
        let whole = [0.0, 0.0, 1.0, 1.0];
        assert_eq!(with(&[]).within(whole), Vec::<PicturePart>::new());
        let full = Occupied::of(&ColorImage::filled([80, 80], Color32::WHITE));
        assert_eq!(full.within(whole), [whole]);
    }

    #[test]
    fn blocks_in_a_row_are_one_part_and_a_part_is_cut_to_what_is_asked_for() {
        // In blocks 2 and 3 of row 1, and on the lower edge of block 7 of row 7.
        let some = with(&[[25, 15], [35, 15], [75, 79]]);
        let whole = some.within([0.0, 0.0, 1.0, 1.0]);
        assert_eq!(whole, [[0.25, 0.125, 0.5, 0.25], [0.875, 0.875, 1.0, 1.0]]);
        let quarter = some.within([0.3, 0.0, 0.4, 0.2]);
        assert_eq!(quarter, [[0.3, 0.125, 0.4, 0.2]]);
    }

    #[test]
    fn a_texel_at_the_edge_of_a_block_occupies_its_neighbour_too() {
        let whole = [0.0, 0.0, 1.0, 1.0];
        assert_eq!(with(&[[9, 15]]).within(whole), [[0.0, 0.125, 0.25, 0.25]]);
    }
}
