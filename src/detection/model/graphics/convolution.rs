//! The constants of a convolution, as the shader reads them.

/// Output channels and pixels that a group computes, `SIDE` of the shader.
pub(super) const SIDE: usize = 64;
/// Numbers of each sum that a group fetches at once, `DEPTH` of the shader.
const DEPTH: usize = 16;
/// Row and column of a number that lies under no window.
const NOWHERE: u32 = u32::MAX;

/// Constants of a convolution. Sums are filled up with zeros to a multiple of [`DEPTH`] numbers, channels to one of [`SIDE`], so that the
/// shader fetches them without a look at their ends.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Weights {
    /// By number of the sum and output channel, then a bias for each channel.
    pub(super) numbers: Vec<f32>,
    /// For each number of a sum, how far it lies behind the first number under the window, and its row and column there in 16 bits each.
    pub(super) under: Vec<[u32; 2]>,
}

impl Weights {
    /// How many numbers they are, filled up: up to 64 times the weights of a layer with one output channel.
    pub(super) fn count([read, ..]: [u32; 3], window: [u32; 2], channels: usize) -> usize {
        let terms = [read, window[0], window[1]];
        let terms = terms
            .iter()
            .fold(1_usize, |all, one| all.saturating_mul(*one as usize));
        let depth = terms.saturating_add(DEPTH);
        depth.saturating_mul(channels.next_multiple_of(SIDE))
    }

    /// Of weights by output channel, input channel, row and column; of one bias, or one for each output channel. The input has so many
    /// channels, rows and columns, the window so many rows and columns. `None` where numbers are not as many as that.
    pub(super) fn new(
        (weights, biases): (&[f32], &[f32]),
        [read, height, width]: [u32; 3],
        [rows, columns]: [u32; 2],
        channels: usize,
    ) -> Option<Self> {
        let terms = (read * rows * columns) as usize;
        let are_all = weights.len() == terms * channels && [1, channels].contains(&biases.len());
        let fits = rows.max(columns) < NOWHERE >> 16;
        if !are_all || !fits {
            return None;
        }
        let across = channels.next_multiple_of(SIDE);
        let depth = terms.next_multiple_of(DEPTH);
        let mut numbers = vec![0.0; (depth + 1) * across];
        for (channel, weights) in weights.chunks_exact(terms).enumerate() {
            for (term, weight) in weights.iter().enumerate() {
                numbers[term * across + channel] = *weight;
            }
            numbers[depth * across + channel] = biases[channel % biases.len()];
        }
        let position = |term: u32| {
            let (channel, row, column) = (
                term / (rows * columns),
                term / columns % rows,
                term % columns,
            );
            let behind = (channel * height + row) * width + column;
            [behind, row << 16 | column]
        };
        let mut under: Vec<[u32; 2]> = (0..terms as u32).map(position).collect();
        under.resize(depth, [0, NOWHERE]);
        Some(Self { numbers, under })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_filled_up_and_know_where_they_lie() {
        let weights: Vec<f32> = (1..=12).map(|number| number as f32).collect();
        let of =
            |weights: &[f32], biases: &[f32]| Weights::new((weights, biases), [2, 5, 7], [1, 3], 2);
        let made = of(&weights, &[0.5, 0.25]).expect("as many as it has");
        assert_eq!(made.numbers.len(), 17 * SIDE);
        assert!(made.numbers.len() <= Weights::count([2, 5, 7], [1, 3], 2));
        assert_eq!(Weights::count([u32::MAX; 3], [u32::MAX; 2], 1), usize::MAX);
        // The second channel's first weight is its seventh number of all.
        assert_eq!(made.numbers[..3], [1.0, 7.0, 0.0]);
        assert_eq!(made.numbers[5 * SIDE..][..3], [6.0, 12.0, 0.0]);
        assert!(made.numbers[6 * SIDE..16 * SIDE].iter().all(|n| *n == 0.0));
        assert_eq!(made.numbers[16 * SIDE..][..3], [0.5, 0.25, 0.0]);
        assert_eq!(made.under[2], [2, 2]);
        assert_eq!(made.under[4], [36, 1]);
        assert_eq!(made.under[6..], [[0, NOWHERE]; 10]);
        assert_eq!(of(&weights[1..], &[0.5]), None);
        assert_eq!(of(&weights, &[0.5; 3]), None);
    }
}
