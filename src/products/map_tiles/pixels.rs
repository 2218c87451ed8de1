//! Holds depth and light of a tile, pixel by pixel, and makes the pictures of the tile.
//!
//! Depths with their hill-shade are sampled at the places of the pixels in the plane of a map.

use super::web_tile::{TILE_PIXELS, WebTile};
use bathyscope_bottom::bathymetry::{Light, Surface};
use bathyscope_bottom::presentation::colours::lit_depth_colour;
use bathyscope_log::support::geo::LonLat;

/// Number of pixels between two places of the lattice. A projection is so nearly linear over them
/// that the error of a place between is a millionth of a pixel where a pixel is some decimetres
/// long: `16^2 / 8` of a pixel times its length over the earth's radius.
const STEP: usize = 16;
/// Number of places of the lattice along a side.
const PLACES: usize = TILE_PIXELS / STEP + 1;

/// Depth and light of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pixel {
    /// Depth, metres, positive down.
    pub depth_m: f32,
    /// Brightness of the bottom; level ground has 1.
    pub light: f32,
}

/// The pixels of a tile, row by row from the north-west; depth and light are NaN where nothing is
/// known.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    depth_m: Vec<f32>,
    light: Vec<f32>,
}

impl Pixels {
    /// Creates a tile from the known pixels, each given as its column and row; `None` where no
    /// pixel is known.
    pub(crate) fn draw(known: impl Fn([usize; 2]) -> Option<Pixel>) -> Option<Self> {
        let pixels = (0..TILE_PIXELS * TILE_PIXELS)
            .map(|pixel| known([pixel % TILE_PIXELS, pixel / TILE_PIXELS]));
        Self::collect(pixels)
    }

    /// Combines four tiles of the next zoom (in the order of [`WebTile::children`]) to one tile:
    /// each pixel is the mean of the known ones of four pixels. `None` where no pixel is known.
    pub(crate) fn of_children(children: [Option<&Self>; 4]) -> Option<Self> {
        const HALF: usize = TILE_PIXELS / 2;
        let pixels = (0..TILE_PIXELS * TILE_PIXELS).map(|pixel| {
            let (column, row) = (pixel % TILE_PIXELS, pixel / TILE_PIXELS);
            let child = children[2 * (row / HALF) + column / HALF]?;
            let first = 2 * (row % HALF) * TILE_PIXELS + 2 * (column % HALF);
            let four = [first, first + 1, first + TILE_PIXELS, first + TILE_PIXELS + 1];
            child.mean(four)
        });
        Self::collect(pixels)
    }

    fn collect(pixels: impl Iterator<Item = Option<Pixel>>) -> Option<Self> {
        let (depth_m, light): (Vec<f32>, Vec<f32>) = pixels
            .map(|pixel| pixel.map_or((f32::NAN, f32::NAN), |pixel| (pixel.depth_m, pixel.light)))
            .unzip();
        let is_known = depth_m.iter().any(|depth| !depth.is_nan());
        is_known.then_some(Self { depth_m, light })
    }

    fn mean(&self, pixels: [usize; 4]) -> Option<Pixel> {
        let known = || pixels.iter().filter(|pixel| !self.depth_m[**pixel].is_nan());
        let count = known().count() as f32;
        (count > 0.0).then(|| Pixel {
            depth_m: known().map(|pixel| self.depth_m[*pixel]).sum::<f32>() / count,
            light: known().map(|pixel| self.light[*pixel]).sum::<f32>() / count,
        })
    }

    /// Returns all values, depths before lights, 4 bytes each, the lowest first.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let values = self.depth_m.iter().chain(&self.light);
        values.flat_map(|value| value.to_le_bytes()).collect()
    }

    /// Reads pixels from the bytes of [`Pixels::to_bytes`]; `None` where they are too few or too
    /// many.
    pub(crate) fn of_bytes(bytes: &[u8]) -> Option<Self> {
        let (values, rest) = bytes.as_chunks::<4>();
        let mut depth_m: Vec<f32> = values.iter().copied().map(f32::from_le_bytes).collect();
        if !rest.is_empty() || depth_m.len() != 2 * TILE_PIXELS * TILE_PIXELS {
            return None;
        }
        let light = depth_m.split_off(TILE_PIXELS * TILE_PIXELS);
        Some(Self { depth_m, light })
    }

    /// Returns the colours of depth, lit; transparent where nothing is known. Each pixel has red,
    /// green, blue and opacity.
    pub fn colours(&self, range_m: [f32; 2]) -> Vec<u8> {
        self.rgba(|pixel| lit_depth_colour(pixel.depth_m, range_m, pixel.light))
    }

    /// Returns elevations (minus the depths) in the encoding Terrarium: red * 256 + green + blue /
    /// 256 - 32768 metres; transparent where nothing is known.
    pub(crate) fn elevations(&self) -> Vec<u8> {
        self.rgba(|pixel| {
            let steps = (256.0 * (32_768.0 - f64::from(pixel.depth_m))).round();
            let [_, red, green, blue] = (steps.clamp(0.0, 16_777_215.0) as u32).to_be_bytes();
            [red, green, blue]
        })
    }

    fn rgba(&self, colour: impl Fn(Pixel) -> [u8; 3]) -> Vec<u8> {
        let pixels = self.depth_m.iter().zip(&self.light);
        let colours = pixels.flat_map(|(&depth_m, &light)| {
            if depth_m.is_nan() {
                [0; 4]
            } else {
                let [red, green, blue] = colour(Pixel { depth_m, light });
                [red, green, blue, 255]
            }
        });
        colours.collect()
    }
}

/// A surface with its hill-shade.
#[derive(Clone, Copy)]
pub(crate) struct LitSurface<'a> {
    surface: &'a Surface,
    /// Hill-shade of each cell from [`bathyscope_bottom::bathymetry::hill_shade`]: 0 where it is
    /// unknown.
    shade: &'a [u8],
    level_ground: f32,
}

impl<'a> LitSurface<'a> {
    /// Creates a lit surface from the hill-shade that was computed with `light`.
    pub(crate) fn new(surface: &'a Surface, shade: &'a [u8], light: &Light) -> Self {
        Self { surface, shade, level_ground: f32::from(light.level_ground()) }
    }

    /// Returns the depth and the light at a place, metres east and north: the depth is interpolated
    /// between the centres of cells, or the depth of the cell where a neighbour has none. Ground
    /// whose slope is unknown is as bright as level ground. `None` where the cell has no depth.
    pub(crate) fn at(&self, place: [f64; 2]) -> Option<Pixel> {
        let cell = self.surface.grid.index_at(place[0], place[1])?;
        let of_cell = self.surface.depth_m.get(cell).copied();
        let known = of_cell.filter(|depth_m| !depth_m.is_nan())?;
        let depth_m = self.surface.depth_at(place).unwrap_or(known);
        let light = match self.shade.get(cell) {
            Some(&shade) if shade > 0 => f32::from(shade) / self.level_ground,
            _ => 1.0,
        };
        Some(Pixel { depth_m, light })
    }
}

/// Middles of a tile's pixels in a plane: projected at the places of a lattice, and interpolated
/// linearly between them. A projection at every pixel took four fifths of the time of a tile.
pub(crate) struct PixelPlaces {
    /// Places of the lattice, row by row from the north-west, metres.
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

    /// Returns the middle of a pixel, given by its column and row, metres east and north.
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
    use bathyscope_bottom::bathymetry::{Grid, hill_shade};
    use bathyscope_log::support::geo::UtmZone;
    use bathyscope_log::support::progress::Progress;

    fn sloped([column, _]: [usize; 2]) -> Option<Pixel> {
        Some(Pixel { depth_m: 2.0 + 1e-2 * column as f32, light: 1.0 })
    }

    #[test]
    fn depths_come_back_from_their_encoding() {
        let pixels = Pixels::draw(sloped).unwrap();
        let bytes = pixels.elevations();
        for (pixel, depth_m) in bytes.chunks_exact(4).zip(&pixels.depth_m) {
            let [red, green, blue] = [0, 1, 2].map(|part| f64::from(pixel[part]));
            let elevation_m = red * 256.0 + green + blue / 256.0 - 32_768.0;
            assert!((elevation_m + f64::from(*depth_m)).abs() <= 1.0 / 512.0);
            assert_eq!(pixel[3], 255);
        }
    }

    #[test]
    fn a_coarser_pixel_is_the_mean_of_what_is_known() {
        let fine = Pixels::draw(sloped).unwrap();
        let coarse = Pixels::of_children([None, Some(&fine), None, None]).unwrap();
        let at = |column: usize, row: usize| coarse.depth_m[row * TILE_PIXELS + column];
        assert!(at(0, 0).is_nan() && at(127, 128).is_nan() && at(128, 128).is_nan());
        let mean = 0.5 * (fine.depth_m[0] + fine.depth_m[1]);
        assert!((at(128, 0) - mean).abs() < 1e-6);
        assert!(coarse.colours([2.0, 3.0])[..4] == [0; 4]);
        assert!(Pixels::draw(|_| None).is_none());
        assert!(Pixels::of_children([None; 4]).is_none());
        let mut holed = fine.clone();
        holed.depth_m[1] = f32::NAN;
        let coarse = Pixels::of_children([Some(&holed), None, None, None]).unwrap();
        let known = [0, TILE_PIXELS, TILE_PIXELS + 1].map(|pixel| fine.depth_m[pixel]);
        assert!((coarse.depth_m[0] - known.iter().sum::<f32>() / 3.0).abs() < 1e-6);
    }

    #[test]
    fn a_place_has_the_depth_and_the_light_of_the_map() {
        let grid = Grid { west_m: 0.0, north_m: 5.0, cell_m: 1.0, columns: 5, rows: 5 };
        let mut depth_m: Vec<f32> = (0..25).map(|cell| 2.0 + 0.1 * (cell % 5) as f32).collect();
        depth_m[24] = f32::NAN;
        let surface = Surface::of_depths(grid, depth_m);
        let light = Light::suited(&surface);
        let shade = hill_shade(&surface, &light, &Progress::new()).unwrap();
        let lit = LitSurface::new(&surface, &shade, &light);
        let between = lit.at([2.0, 2.5]).unwrap();
        assert!((between.depth_m - 2.15).abs() < 1e-6);
        // The bottom sinks to the east, so it is turned away from the light in the north-west.
        assert!(between.light < 0.999, "{between:?}");
        // Between a known cell and an unknown one, on the side of the known one.
        assert_eq!(lit.at([3.9, 0.5]).map(|pixel| pixel.depth_m), Some(2.3));
        assert_eq!(lit.at([3.9, 0.5]).map(|pixel| pixel.light), Some(1.0));
        assert_eq!(lit.at([4.5, 0.5]), None);
        assert_eq!(lit.at([5.5, 2.5]), None);
    }

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
            // Pixels of 0.2 m at zoom 19, and of 40 m at zoom 12.
            assert!(off(at, 19) < 3e-6, "{at:?}: {}", off(at, 19));
            assert!(off(at, 12) < 4e-4, "{at:?}: {}", off(at, 12));
        }
    }
}
