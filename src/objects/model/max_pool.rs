//! Maxima over windows of a picture.

use std::ops::Range;

/// A window that moves over the rows, or over the columns, of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoolAxis {
    /// Numbers of the input.
    pub(super) from: usize,
    /// Numbers of the output.
    pub(super) into: usize,
    /// Numbers of the window.
    pub(super) window: usize,
    /// Step from one window to the next.
    pub(super) step: usize,
    /// Width by which the first window begins before the picture.
    pub(super) before: usize,
}

impl PoolAxis {
    /// Returns the part of the picture that the window at a place covers.
    fn covered(&self, place: usize) -> Range<usize> {
        let start = place * self.step;
        let end = (start + self.window).saturating_sub(self.before);
        start.saturating_sub(self.before).min(self.from)..end.min(self.from)
    }

    /// Returns true if windows are pairs, one after the other, and all of them whole.
    fn is_in_pairs(&self) -> bool {
        (self.window, self.step, self.before) == (2, 2, 0) && self.into == self.from / 2
    }
}

/// The greatest number in each window, channel by channel; minus infinity in a window that covers
/// nothing of the picture.
pub(super) fn max_pool(input: &[f32], channels: usize, [rows, columns]: [PoolAxis; 2]) -> Vec<f32> {
    let mut output = Vec::with_capacity(channels * rows.into * columns.into);
    let mut greatest = vec![0.0; columns.from];
    for picture in input.chunks_exact(rows.from * columns.from) {
        for row in 0..rows.into {
            // Down the columns, of which several are compared at once, and then along the row.
            greatest.fill(f32::NEG_INFINITY);
            for y in rows.covered(row) {
                let line = &picture[y * columns.from..][..columns.from];
                for (greatest, value) in greatest.iter_mut().zip(line) {
                    *greatest = greatest.max(*value);
                }
            }
            if columns.is_in_pairs() {
                let pairs = greatest.as_chunks::<2>().0.iter();
                output.extend(pairs.map(|[one, other]| one.max(*other)));
                continue;
            }
            output.extend((0..columns.into).map(|column| {
                let covered = greatest[columns.covered(column)].iter();
                covered.copied().fold(f32::NEG_INFINITY, f32::max)
            }));
        }
    }
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_hold_their_greatest_number_whatever_their_size_step_and_border() {
        // The last window of an odd side may be cut: rounded up, as some networks ask for.
        let axis = |from: usize, window: usize, step: usize, before: usize, cut: bool| PoolAxis {
            from,
            into: (from + 2 * before - window + usize::from(cut) * (step - 1)) / step + 1,
            window,
            step,
            before,
        };
        let number = |at: usize| ((at * 7919) % 1009) as f32 - 500.0;
        for (window, step, before, cut) in [
            (2, 2, 0, false),
            (2, 2, 0, true),
            (5, 1, 2, false),
            (3, 2, 1, false),
            (1, 1, 0, false),
        ] {
            let (rows, columns) =
                (axis(9, window, step, before, cut), axis(15, window, step, before, cut));
            let input: Vec<f32> = (0..2 * 9 * 15).map(number).collect();
            let output = max_pool(&input, 2, [rows, columns]);
            assert_eq!(output.len(), 2 * rows.into * columns.into);
            for (at, found) in output.iter().enumerate() {
                let (channel, row) =
                    (at / (rows.into * columns.into), at / columns.into % rows.into);
                let column = at % columns.into;
                let mut expected = f32::NEG_INFINITY;
                for (dy, dx) in (0..window).flat_map(|dy| (0..window).map(move |dx| (dy, dx))) {
                    let [y, x] = [row * step + dy, column * step + dx];
                    if (before..before + 9).contains(&y) && (before..before + 15).contains(&x) {
                        let at = (channel * 9 + y - before) * 15 + x - before;
                        expected = expected.max(input[at]);
                    }
                }
                assert_eq!(*found, expected, "{window} {step} {before}: {at}");
            }
        }
    }
}
