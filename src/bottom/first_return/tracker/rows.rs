//! The picture of a chunk: one row of bytes a ping, nearest cell first, whatever the samples are.

use super::super::{Normalisation, SampleMode, int32_image};
use super::runs::TrackerChunk;
use bathyscope_log::survey::{Side, Survey};

/// Samples in a cell of the picture.
pub(super) fn cell(samples: SampleMode) -> usize {
    match samples {
        SampleMode::Bytes => 1,
        SampleMode::Words => int32_image::WORD,
    }
}

/// Cells that are searched, nearest first. Recorders write some 3000; a damaged header must not ask
/// for gigabytes.
const MOST_CELLS: usize = 16_384;

/// Rows of equal width; cells that were not recorded are zero.
#[derive(Default)]
pub(super) struct SampleRows {
    cells: Vec<u8>,
    /// Cells in a row.
    pub width: usize,
    /// Cells that were recorded, for each row.
    pub recorded: Vec<usize>,
    scratch: Vec<u8>,
}

impl SampleRows {
    /// Replaces the picture by that of `chunk`.
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

    /// Number of rows.
    pub(super) fn len(&self) -> usize {
        self.recorded.len()
    }

    /// One row; beyond the ends, the end rows.
    pub(super) fn row(&self, row: isize) -> &[u8] {
        let row = row.clamp(0, self.len() as isize - 1) as usize;
        &self.cells[row * self.width..][..self.width]
    }
}
