//! Depth and light of a tile, pixel by pixel, and the pictures of it.

use super::web_tile::TILE_PIXELS;
use bathyscope_bottom::presentation::colours::lit_depth_colour;

/// Depth and light of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pixel {
    /// Depth, metres, positive down.
    pub depth_m: f32,
    /// Brightness of the bottom; level ground has 1.
    pub light: f32,
}

/// A tile's pixels, row by row from the north-west; depths are NaN where nothing is known.
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

    /// The tile that four of the next zoom make (in the order of [`WebTile::children`]): each pixel
    /// is the mean of what is known of four.
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
            .map(|pixel| pixel.map_or((f32::NAN, f32::NAN), |one| (one.depth_m, one.light)))
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

    /// All values, depths before lights, 4 bytes each, the lowest first.
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

    /// Colours of depth, lit; clear where nothing is known. Red, green, blue and opacity of each
    /// pixel.
    pub fn colours(&self, range_m: [f32; 2]) -> Vec<u8> {
        self.rgba(|pixel| lit_depth_colour(pixel.depth_m, range_m, pixel.light))
    }

    /// Elevations (minus the depths) in the encoding that is called Terrarium: red * 256 + green +
    /// blue / 256 - 32768 metres; clear where nothing is known.
    pub fn elevations(&self) -> Vec<u8> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
