//! Finds the places of the pixels of a tile in the plane of a map.

use super::web_tile::{TILE_PIXELS, WebTile};
use bathyscope_log::support::geo::LonLat;

/// Pixels between two places of the lattice. A projection bends so little over them that a place
/// between is off by a millionth of a pixel where a pixel is some decimetres long: by `16^2 / 8` of
/// a pixel times its length over the earth's radius.
const STEP: usize = 16;
/// Places of the lattice along a side.
const PLACES: usize = TILE_PIXELS / STEP + 1;

/// The middles of a tile's pixels in a plane: projected on a lattice, and linear between its
/// places. A projection at every pixel took four fifths of the time that a tile takes.
pub(crate) struct PixelPlaces {
    /// Row by row from the north-west, metres.
    lattice: Vec<[f64; 2]>,
}

impl PixelPlaces {
    /// Computes the places in the plane of a projection.
    pub(crate) fn new(tile: WebTile, project: impl Fn(LonLat) -> [f64; 2]) -> Self {
        let lattice = (0..PLACES * PLACES).map(|place| {
            let pixel = [place % PLACES, place / PLACES].map(|number| (STEP * number) as f64);
            project(tile.place(pixel))
        });
        Self { lattice: lattice.collect() }
    }

    /// The middle of a pixel, given as its column and row, metres east and north.
    pub(crate) fn of(&self, pixel: [usize; 2]) -> [f64; 2] {
        let [column, row] = pixel.map(|number| number / STEP);
        let [right, down] = pixel.map(|number| ((number % STEP) as f64 + 0.5) / STEP as f64);
        let first = row * PLACES + column;
        let corners = [first, first + 1, first + PLACES, first + PLACES + 1];
        let [a, b, c, d] = corners.map(|corner| self.lattice[corner]);
        [0, 1].map(|axis| {
            let upper = a[axis] + (b[axis] - a[axis]) * right;
            let lower = c[axis] + (d[axis] - c[axis]) * right;
            upper + (lower - upper) * down
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map_tiles::web_pixel;
    use bathyscope_log::support::geo::UtmZone;

    /// Returns the largest error of the place of a pixel, in pixels, in the tile of a zoom that
    /// holds a place.
    fn off(at: LonLat, zoom: u8) -> f64 {
        let tile = WebTile::at_pixel(web_pixel(at, zoom), zoom);
        let zone = UtmZone::of(at);
        let places = PixelPlaces::new(tile, |at| zone.to_metres(at));
        let middle =
            |pixel: [usize; 2]| zone.to_metres(tile.place(pixel.map(|number| number as f64 + 0.5)));
        let between = |[x0, y0]: [f64; 2], [x1, y1]: [f64; 2]| (x1 - x0).hypot(y1 - y0);
        let pixel_m = between(middle([0, 0]), middle([1, 0]));
        let pixels = (0..TILE_PIXELS * TILE_PIXELS).step_by(7);
        let off_m = pixels.map(|pixel| {
            let pixel = [pixel % TILE_PIXELS, pixel / TILE_PIXELS];
            between(places.of(pixel), middle(pixel))
        });
        off_m.fold(0.0, f64::max) / pixel_m
    }

    #[test]
    fn pixels_lie_where_the_projection_has_them() {
        for at in [
            LonLat::new(9.1, 47.6),
            LonLat::new(-111.4, 36.9),
            LonLat::new(25.0, 69.9),
            LonLat::new(147.3, -42.9),
        ] {
            // Pixels of 0.2 m, and of 40 m.
            assert!(off(at, 19) < 3e-6, "{at:?}: {}", off(at, 19));
            assert!(off(at, 12) < 4e-4, "{at:?}: {}", off(at, 12));
        }
    }
}
