//! Computes convolutions of 3 x 3 with a quarter of the multiplications by Winograd's minimal
//! filtering F(4 x 4, 3 x 3) as in A. Lavin and S. Gray, "Fast Algorithms for Convolutional Neural
//! Networks", 2016.
//!
//! A tile of six by six numbers of a channel is transformed to as many points, in which the
//! convolution is a product; the sums over the channels are matrix products; the points are then
//! transformed back to 4 x 4 numbers of the output. Results differ from those of the plain sum by
//! some 1e-5 of their size.

use bathyscope_bottom::vectors::{VectorLoop, vectorised};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use std::array::from_fn;

/// Number of channels that are computed together.
const LANES: usize = 16;
type Lane = [f32; LANES];
/// Width and height of a tile in the input and in the output; number of points of a tile.
const INPUT: usize = 6;
const OUTPUT: usize = 4;
const POINTS: usize = INPUT * INPUT;
/// Least number of tiles that are computed together, if there are as many: matrices of that many
/// rows, which fit in the cache.
const TOGETHER: usize = 128;

/// Matrix G of the paper, which transforms three weights to six points.
const WEIGHT_POINTS: [[f64; 3]; INPUT] = [
    [1.0 / 4.0, 0.0, 0.0],
    [-1.0 / 6.0, -1.0 / 6.0, -1.0 / 6.0],
    [-1.0 / 6.0, 1.0 / 6.0, -1.0 / 6.0],
    [1.0 / 24.0, 1.0 / 12.0, 1.0 / 6.0],
    [1.0 / 24.0, -1.0 / 12.0, 1.0 / 6.0],
    [0.0, 0.0, 1.0],
];

/// A convolution of 3 x 3 with steps of one and a border of one zero, for pictures of one size.
pub(super) struct Convolution {
    /// Channels of the input and of the output.
    channels: [usize; 2],
    /// Rows and columns of input and output.
    size: [usize; 2],
    /// Tiles down and across.
    tiles: [usize; 2],
    /// Matrix of weights for each point, with a row for each channel of the input.
    weights: Vec<f32>,
    bias: Vec<Lane>,
}

impl Convolution {
    /// Creates a convolution from weights by output channel, input channel, row and column, and a
    /// bias for each output channel. `None` if a number of channels is no multiple of 16, or the
    /// weights or biases do not fit the channels.
    pub(super) fn new(
        weights: &[f32],
        bias: &[f32],
        channels: [usize; 2],
        size: [usize; 2],
    ) -> Option<Self> {
        let [inputs, outputs] = channels;
        let fits = weights.len() == 9 * inputs * outputs && bias.len() == outputs;
        if !fits || inputs % LANES != 0 || outputs % LANES != 0 {
            return None;
        }
        let mut points = vec![0.0; Self::weights_of(channels)];
        let weights = weights.as_chunks::<9>().0;
        // In this order of the loops, consecutive writes to a point are adjacent in memory.
        for input in 0..inputs {
            for output in 0..outputs {
                let of_weights = points_of(&weights[output * inputs + input]);
                for (point, value) in of_weights.into_iter().enumerate() {
                    points[(point * inputs + input) * outputs + output] = value;
                }
            }
        }
        Some(Self {
            channels,
            size,
            tiles: size.map(|side| side.div_ceil(OUTPUT)),
            weights: points,
            bias: bias.as_chunks().0.to_vec(),
        })
    }

    /// Returns the count of weights for a number of channels of input and output.
    pub(super) fn weights_of([inputs, outputs]: [usize; 2]) -> usize {
        POINTS * inputs * outputs
    }

    /// Returns the count of weights that the convolution keeps.
    pub(super) fn weights(&self) -> usize {
        self.weights.len()
    }

    /// Returns the channels, rows and columns of the output.
    pub(super) fn output_shape(&self) -> [usize; 3] {
        [self.channels[1], self.size[0], self.size[1]]
    }

    /// Computes the output for a picture that is stored channel by channel and row by row.
    pub(super) fn run(&self, input: &[f32]) -> Vec<f32> {
        vectorised(Run { convolution: self, input })
    }

    /// Computes the same as `run`. All calls are inlined, so that the compiler can use all vector
    /// instructions of the processor.
    #[inline(always)]
    fn run_inlined(&self, input: &[f32]) -> Vec<f32> {
        let padded = self.padded(input);
        let [height, width] = self.size;
        let [inputs, outputs] = self.channels;
        let [down, across] = self.tiles;
        let rows_together = TOGETHER.div_ceil(across).min(down);
        let most = rows_together * across;
        let mut input_points = vec![[0.0; LANES]; POINTS * most * inputs / LANES];
        let mut output_points = vec![[0.0; LANES]; POINTS * most * outputs / LANES];
        let mut output = vec![0.0; outputs * height * width];
        for first in (0..down).step_by(rows_together) {
            let rows = rows_together.min(down - first);
            for tile in 0..rows * across {
                let place = [first + tile / across, tile % across];
                self.transform_input(&padded, place, (tile, most), &mut input_points);
            }
            self.multiply(
                [rows * across, most],
                input_points.as_flattened(),
                output_points.as_flattened_mut(),
            );
            for tile in 0..rows * across {
                let place = [first + tile / across, tile % across];
                self.write_output(&output_points, (tile, most), place, &mut output);
            }
        }
        output
    }

    /// Returns the picture with its border, pixel by pixel, with the channels of a pixel side by
    /// side.
    #[inline(always)]
    fn padded(&self, input: &[f32]) -> Vec<Lane> {
        let [height, width] = self.size;
        let lanes = self.channels[0] / LANES;
        let [down, across] = self.tiles.map(|tiles| OUTPUT * tiles + 2);
        let mut padded = vec![[0.0; LANES]; down * across * lanes];
        for y in 0..height {
            let row = &mut padded[((y + 1) * across + 1) * lanes..][..width * lanes];
            for lane in 0..lanes {
                let rows: [&[f32]; LANES] =
                    from_fn(|c| &input[((lane * LANES + c) * height + y) * width..][..width]);
                for x in 0..width {
                    row[x * lanes + lane] = from_fn(|c| rows[c][x]);
                }
            }
        }
        padded
    }

    /// Transforms the input of tile number `tile`, of at most `most`, to its points.
    #[inline(always)]
    fn transform_input(
        &self,
        padded: &[Lane],
        [row, column]: [usize; 2],
        (tile, most): (usize, usize),
        points: &mut [Lane],
    ) {
        let lanes = self.channels[0] / LANES;
        let across = OUTPUT * self.tiles[1] + 2;
        for lane in 0..lanes {
            let at =
                |i, j| &padded[((OUTPUT * row + i) * across + OUTPUT * column + j) * lanes + lane];
            let mut columns = [[[0.0; LANES]; INPUT]; INPUT];
            for (j, column) in columns.iter_mut().enumerate() {
                *column = six_points([at(0, j), at(1, j), at(2, j), at(3, j), at(4, j), at(5, j)]);
            }
            let [c0, c1, c2, c3, c4, c5] = &columns;
            for i in 0..INPUT {
                let row_points = six_points([&c0[i], &c1[i], &c2[i], &c3[i], &c4[i], &c5[i]]);
                for (j, point) in row_points.into_iter().enumerate() {
                    points[((i * INPUT + j) * most + tile) * lanes + lane] = point;
                }
            }
        }
    }

    /// Sums the products over the channels: one matrix product for each point.
    fn multiply(&self, [tiles, most]: [usize; 2], from: &[f32], into: &mut [f32]) {
        let [inputs, outputs] = self.channels;
        for point in 0..POINTS {
            let from = &from[point * most * inputs..][..tiles * inputs];
            let weights = &self.weights[point * inputs * outputs..][..inputs * outputs];
            let into = &mut into[point * most * outputs..][..tiles * outputs];
            matmul(
                MatMut::from_row_major_slice_mut(into, tiles, outputs),
                Accum::Replace,
                MatRef::from_row_major_slice(from, tiles, inputs),
                MatRef::from_row_major_slice(weights, inputs, outputs),
                1.0,
                Par::Seq,
            );
        }
    }

    /// Transforms the points of one tile back to its output, and adds the bias.
    #[inline(always)]
    fn write_output(
        &self,
        points: &[Lane],
        (tile, most): (usize, usize),
        [row, column]: [usize; 2],
        output: &mut [f32],
    ) {
        let lanes = self.channels[1] / LANES;
        let [height, width] = self.size;
        for lane in 0..lanes {
            let at = |i, j| &points[((i * INPUT + j) * most + tile) * lanes + lane];
            let mut columns = [[[0.0; LANES]; OUTPUT]; INPUT];
            for (j, column) in columns.iter_mut().enumerate() {
                *column = four_values([at(0, j), at(1, j), at(2, j), at(3, j), at(4, j), at(5, j)]);
            }
            let [c0, c1, c2, c3, c4, c5] = &columns;
            let mut rows = [[[0.0; LANES]; OUTPUT]; OUTPUT];
            for (i, row) in rows.iter_mut().enumerate() {
                *row = four_values([&c0[i], &c1[i], &c2[i], &c3[i], &c4[i], &c5[i]]);
            }
            let (y, x) = (OUTPUT * row, OUTPUT * column);
            for (i, values) in rows.iter().enumerate().take(height - y) {
                for (j, value) in values.iter().enumerate().take(width - x) {
                    for (c, (value, bias)) in value.iter().zip(&self.bias[lane]).enumerate() {
                        let channel = lane * LANES + c;
                        output[(channel * height + y + i) * width + x + j] = value + bias;
                    }
                }
            }
        }
    }
}

/// A run of a convolution, which is compiled once for each kind of processor.
struct Run<'a> {
    convolution: &'a Convolution,
    input: &'a [f32],
}

impl VectorLoop for Run<'_> {
    type Output = Vec<f32>;

    #[inline(always)]
    fn run(self) -> Vec<f32> {
        self.convolution.run_inlined(self.input)
    }
}

/// Transforms nine weights to their points.
fn points_of(weights: &[f32; 9]) -> [f32; POINTS] {
    let weights = weights.map(f64::from);
    // The columns of the weights are transformed first, then the rows of the result.
    let mut down = [[0.0; 3]; INPUT];
    for (down, [a, b, c]) in down.iter_mut().zip(WEIGHT_POINTS) {
        for (column, down) in down.iter_mut().enumerate() {
            *down = a * weights[column] + b * weights[3 + column] + c * weights[6 + column];
        }
    }
    let mut points = [0.0; POINTS];
    for (points, down) in points.as_chunks_mut::<INPUT>().0.iter_mut().zip(down) {
        for (point, [a, b, c]) in points.iter_mut().zip(WEIGHT_POINTS) {
            *point = (a * down[0] + b * down[1] + c * down[2]) as f32;
        }
    }
    points
}

/// Transforms six numbers to six points (matrix B of the paper).
#[inline(always)]
fn six_points([d0, d1, d2, d3, d4, d5]: [&Lane; INPUT]) -> [Lane; INPUT] {
    let even = each([d2, d4], |[d2, d4]| d4 - 4.0 * d2);
    let odd = each([d1, d3], |[d1, d3]| d3 - 4.0 * d1);
    let even_2 = each([d2, d4], |[d2, d4]| d4 - d2);
    let odd_2 = each([d1, d3], |[d1, d3]| 2.0 * (d3 - d1));
    [
        each([d0, d2, d4], |[d0, d2, d4]| 4.0 * d0 - 5.0 * d2 + d4),
        each([&even, &odd], |[even, odd]| even + odd),
        each([&even, &odd], |[even, odd]| even - odd),
        each([&even_2, &odd_2], |[even, odd]| even + odd),
        each([&even_2, &odd_2], |[even, odd]| even - odd),
        each([d1, d3, d5], |[d1, d3, d5]| 4.0 * d1 - 5.0 * d3 + d5),
    ]
}

/// Transforms six points to four numbers (matrix A of the paper).
#[inline(always)]
fn four_values([m0, m1, m2, m3, m4, m5]: [&Lane; INPUT]) -> [Lane; OUTPUT] {
    let sum = each([m1, m2], |[m1, m2]| m1 + m2);
    let difference = each([m1, m2], |[m1, m2]| m1 - m2);
    let sum_2 = each([m3, m4], |[m3, m4]| m3 + m4);
    let difference_2 = each([m3, m4], |[m3, m4]| m3 - m4);
    [
        each([m0, &sum, &sum_2], |[m0, sum, sum_2]| m0 + sum + sum_2),
        each([&difference, &difference_2], |[difference, difference_2]| {
            difference + 2.0 * difference_2
        }),
        each([&sum, &sum_2], |[sum, sum_2]| sum + 4.0 * sum_2),
        each([&difference, &difference_2, m5], |[difference, difference_2, m5]| {
            difference + 8.0 * difference_2 + m5
        }),
    ]
}

/// Computes each channel separately.
#[inline(always)]
fn each<const N: usize>(from: [&Lane; N], compute: impl Fn([f32; N]) -> f32) -> Lane {
    // Loops instead of closures: the compiler may not inline closures, and could then not use all
    // vector instructions of the processor.
    let mut into = [0.0; LANES];
    for (c, into) in into.iter_mut().enumerate() {
        let mut values = [0.0; N];
        for (value, lane) in values.iter_mut().zip(&from) {
            *value = lane[c];
        }
        *into = compute(values);
    }
    into
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns pseudo-random numbers between -1 and 1.
    fn numbers(count: usize, seed: u32) -> Vec<f32> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    /// Computes the convolution as the plain sum of its definition.
    fn plain(
        weights: &[f32],
        bias: &[f32],
        [inputs, outputs]: [usize; 2],
        [height, width]: [usize; 2],
        input: &[f32],
    ) -> Vec<f64> {
        let at = |channel: usize, y: usize, x: usize| {
            if (1..=height).contains(&y) && (1..=width).contains(&x) {
                f64::from(input[(channel * height + y - 1) * width + x - 1])
            } else {
                0.0
            }
        };
        let mut output = Vec::new();
        for o in 0..outputs {
            for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                let terms = (0..9 * inputs).map(|term| {
                    let (channel, tap) = (term / 9, term % 9);
                    let weight = f64::from(weights[o * 9 * inputs + term]);
                    weight * at(channel, y + tap / 3, x + tap % 3)
                });
                output.push(f64::from(bias[o]) + terms.sum::<f64>());
            }
        }
        output
    }

    #[test]
    fn it_gives_the_sum_for_pictures_of_any_size() {
        let channels = [32, 16];
        let [weights, bias] = [numbers(9 * 32 * 16, 1), numbers(16, 2)];
        for size in [[13, 13], [1, 5], [4, 8], [30, 3], [2, 131]] {
            let input = numbers(32 * size[0] * size[1], 3);
            let convolution = Convolution::new(&weights, &bias, channels, size);
            let output = convolution.expect("channels that fit").run(&input);
            let expected = plain(&weights, &bias, channels, size, &input);
            assert_eq!(output.len(), expected.len());
            let off = (output.iter().zip(&expected))
                .map(|(value, expected)| (f64::from(*value) - expected).abs())
                .fold(0.0, f64::max);
            assert!(off < 2e-4, "{size:?}: {off}");
        }
    }

    #[test]
    fn channels_that_do_not_fit_are_left_to_another_way() {
        let new = |channels: [usize; 2], weights: usize| {
            let bias = vec![0.0; channels[1]];
            Convolution::new(&vec![0.0; weights], &bias, channels, [8, 8])
        };
        assert!(new([16, 16], 9 * 256).is_some());
        assert!(new([8, 16], 9 * 128).is_none());
        assert!(new([16, 36], 9 * 16 * 36).is_none());
        assert!(new([16, 16], 256).is_none());
    }
}
