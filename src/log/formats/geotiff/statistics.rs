//! Statistics of a band, as GDAL defines them.

use super::{CellFormat, NODATA};

/// Count, ends, mean and spread of the values that are known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Statistics {
    /// Number of known values.
    pub count: u64,
    /// The least; infinite where none is known.
    pub least: f64,
    /// The greatest; infinite where none is known.
    pub most: f64,
    mean: f64,
    /// Sum of the squares of what the values differ from their mean by.
    squares: f64,
}

impl Default for Statistics {
    fn default() -> Self {
        Self { count: 0, least: f64::INFINITY, most: f64::NEG_INFINITY, mean: 0.0, squares: 0.0 }
    }
}

impl Statistics {
    /// Computes the statistics of the cells of a tile; colours have none.
    pub(super) fn of(cells: CellFormat, bytes: &[u8]) -> Self {
        match cells {
            CellFormat::Rgba => Self::default(),
            CellFormat::Level | CellFormat::Class => Self::of_levels(bytes),
            CellFormat::Metres => {
                let values = bytes.as_chunks().0.iter();
                let values = values.map(|&four| f32::from_le_bytes(four));
                Self::of_values(values.filter(|&metres| metres != NODATA).map(f64::from))
            }
        }
    }

    fn of_levels(levels: &[u8]) -> Self {
        let mut counts = [0_u64; 256];
        for &level in levels {
            counts[usize::from(level)] += 1;
        }
        let mut all = Self::default();
        for (level, &count) in counts.iter().enumerate().skip(1).filter(|(_, count)| **count > 0) {
            let level = level as f64;
            all.join(&Self { count, least: level, most: level, mean: level, squares: 0.0 });
        }
        all
    }

    fn of_values(values: impl Iterator<Item = f64> + Clone) -> Self {
        let mut all = Self::default();
        let mut sum = 0.0;
        for value in values.clone() {
            all.count += 1;
            all.least = all.least.min(value);
            all.most = all.most.max(value);
            sum += value;
        }
        all.mean = sum / all.count.max(1) as f64;
        all.squares = values.map(|value| (value - all.mean).powi(2)).sum();
        all
    }

    /// Adds the values of another part.
    pub(super) fn join(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let [own, others] = [self.count, other.count].map(|count| count as f64);
        let apart = other.mean - self.mean;
        self.squares += other.squares + apart * apart * own * others / (own + others);
        self.mean += apart * others / (own + others);
        self.count += other.count;
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
    }

    /// The mean; `None` where no value is known.
    pub(super) fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    /// Standard deviation of all values, not of a sample of them; `None` where no value is known.
    pub(super) fn deviation(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.squares / self.count as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_join_to_the_figures_of_the_whole() {
        let bytes = |values: &[f32]| -> Vec<u8> {
            values.iter().flat_map(|value| value.to_le_bytes()).collect()
        };
        let mut joined = Statistics::default();
        for part in [&[2.0, NODATA, 4.0][..], &[NODATA], &[4.0, 4.0, 5.0, 5.0, 7.0, 9.0]] {
            joined.join(&Statistics::of(CellFormat::Metres, &bytes(part)));
        }
        // The well-known example: mean 5, standard deviation 2.
        assert_eq!((joined.count, joined.least, joined.most), (8, 2.0, 9.0));
        assert!((joined.mean().unwrap() - 5.0).abs() < 1e-12);
        assert!((joined.deviation().unwrap() - 2.0).abs() < 1e-12);
        let levels = Statistics::of(CellFormat::Level, &[2, 4, 4, 0, 4, 5, 5, 0, 7, 9]);
        assert_eq!((levels.count, levels.least, levels.most), (8, 2.0, 9.0));
        assert!((levels.deviation().unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(Statistics::default().mean(), None);
    }
}
