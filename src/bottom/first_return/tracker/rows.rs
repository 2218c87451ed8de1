//! Splits the pings where the line may break, and into chunks that are tracked independently, and
//! loads the picture of a chunk: one row of bytes for each ping, nearest cell first.

use super::super::normalise::{WORD, words_outward};
use super::super::{Normalisation, SampleMode};
use bathyscope_log::survey::{Side, SideSpan, Survey};
use std::ops::Range;

/// Returns the number of samples in a cell of the picture.
pub(super) fn cell(samples: SampleMode) -> usize {
    match samples {
        SampleMode::Bytes => 1,
        SampleMode::Words => WORD,
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
                    for (cell, word) in out.iter_mut().zip(words_outward(samples, side, 0)) {
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

/// Number of pings whose picks a chunk gives. Chunks begin at multiples of this number in a run,
/// whatever part of the log is requested.
const KEPT: usize = 512;

/// Number of further pings at both ends of a chunk that its line is found with, so that the lines
/// of neighbouring chunks meet.
const OVERLAP: usize = 96;

/// Longest time between two pings of one line, seconds.
const LONGEST_GAP_S: f64 = 1.5;

/// Pings of one side that are tracked together.
pub(super) struct TrackerChunk {
    /// All pings, overlap included.
    pub pings: Vec<u32>,
    /// Range of `pings` whose picks this chunk gives.
    pub kept: Range<usize>,
    /// Length of a sample in slant range, metres, the same for all pings.
    pub metres_per_sample: f64,
    /// Slant range at the near edge of the first sample, metres.
    pub near_m: f64,
}

impl TrackerChunk {
    /// Returns the pings whose picks this chunk gives.
    pub(super) fn kept_pings(&self) -> &[u32] {
        &self.pings[self.kept.clone()]
    }
}

/// Returns the chunks of one side that give the pick of at least one ping of `requested`.
pub(super) fn chunks(survey: &Survey, side: Side, requested: &Range<usize>) -> Vec<TrackerChunk> {
    let mut chunks = Vec::new();
    for run in runs(survey, side) {
        let Some(span) = run.first().and_then(|&ping| survey.span(ping as usize, side)) else {
            continue;
        };
        for start in (0..run.len()).step_by(KEPT) {
            let kept = start..run.len().min(start + KEPT);
            let first = run[kept.start] as usize;
            let last = run[kept.end - 1] as usize;
            if last < requested.start || first >= requested.end {
                continue;
            }
            let with_overlap = start.saturating_sub(OVERLAP)..run.len().min(kept.end + OVERLAP);
            chunks.push(TrackerChunk {
                kept: kept.start - with_overlap.start..kept.end - with_overlap.start,
                pings: run[with_overlap].to_vec(),
                metres_per_sample: span.metres_per_sample(),
                near_m: f64::from(span.near_m),
            });
        }
    }
    chunks
}

/// Returns the pings of one side in runs, divided at time gaps and changes of range.
fn runs(survey: &Survey, side: Side) -> Vec<Vec<u32>> {
    let mut runs: Vec<Vec<u32>> = Vec::new();
    let mut last: Option<(f64, &SideSpan)> = None;
    for (index, ping) in survey.side_scan.iter().enumerate() {
        let Some(span) = ping.side(side).filter(|span| can_track(span)) else {
            continue;
        };
        let continues = last.is_some_and(|(time_s, before)| {
            (ping.time_s - time_s).abs() <= LONGEST_GAP_S && same_scale(before, span)
        });
        last = Some((ping.time_s, span));
        match runs.last_mut() {
            Some(run) if continues => run.push(index as u32),
            _ => runs.push(vec![index as u32]),
        }
    }
    runs
}

fn can_track(span: &SideSpan) -> bool {
    let metres = span.metres_per_sample();
    span.count >= 16 && metres.is_finite() && metres > 0.0
}

/// Returns true if two pings have the same scale. Humminbird pings differ in their number of
/// samples but not in scale: that is no change of range.
fn same_scale(a: &SideSpan, b: &SideSpan) -> bool {
    let (one, other) = (a.metres_per_sample(), b.metres_per_sample());
    (one - other).abs() <= 0.002 * one && f64::from((a.near_m - b.near_m).abs()) < one
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::{SidePing, SideScanState};

    fn survey(times_and_ranges: impl Iterator<Item = (f64, f32)>) -> Survey {
        let ping = |(time_s, far_m)| SidePing {
            port: Some(SideSpan::of_bytes(100, [0.0, far_m])),
            ..SidePing::with_depth(time_s, f32::NAN)
        };
        Survey {
            side_scan_state: SideScanState::Usable,
            ..Survey::of_pings(times_and_ranges.map(ping))
        }
    }

    #[test]
    fn line_breaks_at_time_gaps_and_range_changes() {
        let survey = survey((0..300).map(|ping| {
            let gap_s = if ping < 100 { 0.0 } else { 10.0 };
            (gap_s + 0.05 * f64::from(ping), if ping < 200 { 12.0 } else { 15.0 })
        }));
        let chunks = chunks(&survey, Side::Port, &(0..300));
        let starts: Vec<u32> = chunks.iter().map(|chunk| chunk.pings[0]).collect();
        assert_eq!(starts, [0, 100, 200]);
        assert!(chunks.iter().all(|chunk| chunk.kept == (0..100)));
        assert!(super::chunks(&survey, Side::Starboard, &(0..300)).is_empty());
    }

    #[test]
    fn every_ping_is_answered_for_once_and_chunks_do_not_depend_on_the_request() {
        let survey = survey((0..2000).map(|ping| (0.05 * f64::from(ping), 12.0)));
        let all = chunks(&survey, Side::Port, &(0..2000));
        let kept: Vec<u32> = all.iter().flat_map(TrackerChunk::kept_pings).copied().collect();
        assert!(kept.into_iter().eq(0..2000));
        let some = chunks(&survey, Side::Port, &(700..701));
        assert_eq!(some.len(), 1);
        assert!(all.iter().any(|chunk| chunk.pings == some[0].pings));
    }
}
