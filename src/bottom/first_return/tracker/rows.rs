//! Loads the picture of a chunk: one row of bytes for each ping, nearest cell first, for samples of
//! either mode.

use super::super::{Normalisation, SampleMode, int32_image};
use super::runs::TrackerChunk;
use bathyscope_log::survey::{Side, Survey};

/// Returns the number of samples in a cell of the picture.
pub(super) fn cell(samples: SampleMode) -> usize {
    match samples {
        SampleMode::Bytes => 1,
        SampleMode::Words => int32_image::WORD,
    }
}

/// Largest number of cells of a row that are searched, nearest first. Recorders write some 3000;
/// the limit keeps a damaged header from taking gigabytes.
const MOST_CELLS: usize = 16_384;

/// Rows of equal width; cells that were not recorded are zero.
#[derive(Default)]
pub(super) struct SampleRows {
    cells: Vec<u8>,
    /// Number of cells in a row.
    pub width: usize,
    /// Number of cells that were recorded in each row.
    pub recorded: Vec<usize>,
    scratch: Vec<u8>,
}

impl SampleRows {
    /// Replaces the picture with that of `chunk`.
    pub(super) fn load(
        &mut self,
        survey: &Survey,
        normalisation: &Normalisation,
        side: Side,
        chunk: &TrackerChunk,
    ) {
        let mode = normalisation.samples;
        let lengths = chunk.pings.iter().map(|&ping| {
            let samples = survey.samples(ping as usize, side);
            samples.map_or(0, |samples| (samples.len() / cell(mode)).min(MOST_CELLS))
        });
        self.recorded.clear();
        self.recorded.extend(lengths);
        self.width = self.recorded.iter().copied().max().unwrap_or(0);
        self.cells.clear();
        self.cells.resize(self.width * chunk.pings.len(), 0);
        for (row, &ping) in chunk.pings.iter().enumerate() {
            let Some(samples) = survey.samples(ping as usize, side) else {
                continue;
            };
            let out = &mut self.cells[row * self.width..][..self.recorded[row]];
            match mode {
                SampleMode::Bytes => {
                    samples.copy_outward(&mut self.scratch);
                    out.copy_from_slice(&self.scratch[..out.len()]);
                }
                SampleMode::Words => {
                    for (cell, word) in out.iter_mut().zip(int32_image::outward(samples, side, 0)) {
                        *cell = (255.0 * normalisation.normalised(word)) as u8;
                    }
                }
            }
        }
    }

    /// Returns the number of rows.
    pub(super) fn len(&self) -> usize {
        self.recorded.len()
    }

    /// Returns a row; beyond the ends, the first or the last row.
    pub(super) fn row(&self, row: isize) -> &[u8] {
        let row = row.clamp(0, self.len() as isize - 1) as usize;
        &self.cells[row * self.width..][..self.width]
    }
}
