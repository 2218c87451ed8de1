//! Aligns the picture along the line: it extracts bands of cells around the line, in which the line
//! is level, so that they can be averaged along the track without smearing a sloping edge.

use super::grid::TrackerGrid;
use super::rows::SampleRows;
use std::ops::Range;

/// Returns the stretches of rows over which the line moves no more than `limit` cells a row.
pub(super) fn stretches(line: &[usize], limit: usize) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for row in 0..line.len() {
        match stretches.last_mut() {
            Some(stretch) if line[row].abs_diff(line[row - 1]) <= limit => stretch.end = row + 1,
            _ => stretches.push(row..row + 1),
        }
    }
    stretches
}

/// Returns half of a gaussian: weights at distances 0, 1, 2 ... up to three standard deviations.
pub(super) fn gaussian(deviation: f32) -> Vec<f32> {
    let reach = (3.0 * deviation).ceil() as usize;
    (0..=reach).map(|distance| (-0.5 * (distance as f32 / deviation).powi(2)).exp()).collect()
}

/// Returns the weighted mean of each value with its neighbours; at the ends, over the neighbours
/// that exist.
pub(super) fn smooth(values: &[f32], weights: &[f32]) -> Vec<f32> {
    (0..values.len())
        .map(|at| {
            let (mut sum, mut total) = (0.0, 0.0);
            for (value, weight) in neighbours(values.len(), at, weights) {
                sum += weight * values[value];
                total += weight;
            }
            sum / total
        })
        .collect()
}

/// Returns indices and weights of the neighbours of `at` (itself included) below `count`.
fn neighbours(count: usize, at: usize, weights: &[f32]) -> impl Iterator<Item = (usize, f32)> {
    let reach = weights.len() - 1;
    let range = at.saturating_sub(reach)..count.min(at + reach + 1);
    range.map(move |other| (other, weights[other.abs_diff(at)]))
}

/// Fills `band` with the cells from `half` before to `half` beyond the line on each row of a
/// stretch, interpolated. `line` holds the places of the stretch's rows; beyond the recorded cells,
/// the last one is repeated.
pub(super) fn extract(
    rows: &SampleRows,
    stretch: &Range<usize>,
    line: &[f32],
    half: usize,
    band: &mut TrackerGrid,
) {
    band.reset(stretch.len(), 2 * half + 1, 0.0);
    for (index, (row, &at)) in stretch.clone().zip(line).enumerate() {
        let cells = &rows.row(row as isize)[..rows.recorded[row]];
        let Some(last) = cells.len().checked_sub(1) else {
            continue;
        };
        let whole = at.floor();
        let share = at - whole;
        let cell = |offset: isize| {
            f32::from(cells[(whole as isize + offset).clamp(0, last as isize) as usize])
        };
        for (offset, out) in (-(half as isize)..).zip(band.row_mut(index)) {
            *out = cell(offset) * (1.0 - share) + cell(offset + 1) * share;
        }
    }
}

/// Writes the average of the band along the track to `out`.
pub(super) fn smooth_along(band: &TrackerGrid, weights: &[f32], out: &mut TrackerGrid) {
    out.reset(band.len(), band.width(), 0.0);
    for row in 0..band.len() {
        let target = out.row_mut(row);
        let mut total = 0.0;
        for (other, weight) in neighbours(band.len(), row, weights) {
            total += weight;
            for (target, value) in target.iter_mut().zip(band.row(other)) {
                *target += weight * value;
            }
        }
        for target in target {
            *target /= total;
        }
    }
}
