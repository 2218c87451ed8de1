//! Determines the part of an object that a picture shows: the part of its echo and shadow that
//! stands out from the speckle and the noise.
//!
//! Geometry alone predicts more than an observer can see: the thin end of a trunk, a shadow filled
//! with noise, an object in the shadow of another object. Therefore each ping is simulated twice,
//! with the object and without it, and the mean levels that a recorder would write are compared.
//! The object is shown where the levels differ by a good part of the speckle's spread; nothing is
//! shown where the whole difference, weighted as by the best filter, does not exceed the speckle.

use bathyscope_log::survey::Side;
use std::ops::Range;

/// Differences that an object makes in the levels of one ping.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Trace {
    /// Index of the object.
    pub object: usize,
    /// The side that insonified the object.
    pub side: Side,
    /// Slant range of one sample, metres.
    pub metres_per_sample: f64,
    /// Index of the first sample that differs.
    pub first_sample: usize,
    /// Level with the object minus level without it, of each sample from `first_sample` on, in
    /// standard deviations of the speckle.
    pub stands_out: Vec<f32>,
}

/// Part of an object that is shown in one pass, and the box around it. Pings count recorded pings.
#[derive(Clone, Debug, PartialEq)]
pub struct VisiblePart {
    /// First ping that shows the object.
    pub first_ping: usize,
    /// Last ping that shows the object.
    pub last_ping: usize,
    /// Nearest slant range that shows the echo or the shadow of the object, metres.
    pub near_m: f64,
    /// Farthest slant range that shows the echo or the shadow of the object, metres.
    pub far_m: f64,
    /// Part of the object that each ping shows, in the order of the pings; pings that show nothing
    /// are left out.
    pub slices: Vec<VisibleSlice>,
}

/// Part of an object that one ping shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleSlice {
    /// Index of the ping.
    pub ping: usize,
    /// Nearest slant range that shows the object, metres.
    pub near_m: f64,
    /// Farthest slant range that shows the object, metres.
    pub far_m: f64,
    /// Contribution of the ping to the object's visibility; the object is shown where the
    /// contributions add up to at least 1. The sum over the samples of the squared difference, in
    /// standard deviations of the speckle, divided by the number of samples of one grain of
    /// speckle, is the ping's share in the square of the signal-to-noise ratio behind the best
    /// (matched) filter; the contribution is this share divided by the square of [`SEEN_RATIO`].
    pub visibility: f32,
}

/// Signal-to-noise ratio from which an observer can distinguish an object from chance (A. Rose, J.
/// Opt. Soc. Am. 38, 1948).
const SEEN_RATIO: f32 = 5.0;
/// Side of the square over which an eye averages speckle, metres.
const EYE_M: f64 = 0.2;
/// Smallest mean difference over such a square that stands out, in standard deviations of the
/// speckle (2.2 dB).
const SEEN: f32 = 0.4;
/// Smallest difference of a single sample that stands out, in standard deviations of the speckle
/// (1.4 dB): the mean alone would extend beyond the edges.
const OWN: f32 = 0.25;
/// Difference beyond which a sample gets no more weight when a box is trimmed, in standard
/// deviations of the speckle.
const PLAIN: f32 = 1.5;
/// Share of the differences that is cut off at each side of the box, such as the outermost bit of
/// an edge or a twig.
const TRIMMED: f64 = 0.01;

/// Returns the part of an object that the pings of one pass show; `None` where nothing stands out.
/// `rows` are pings in their order, each with its differences; `spacing_m` is the distance between
/// two pings, and `grain` is the number of neighbouring samples that share one grain of speckle.
pub(super) fn visible_part(
    rows: &[(usize, &Trace)],
    spacing_m: f64,
    grain: f32,
) -> Option<VisiblePart> {
    let (first, last) = (rows.first()?, rows.last()?);
    let metres_per_sample = first.1.metres_per_sample;
    // A recorder that changes its range in the middle of an object shows the object at two scales;
    // only the pings of the first scale are kept.
    let rows = rows.iter().filter(|(_, trace)| trace.metres_per_sample == metres_per_sample);
    let start = rows.clone().map(|(_, trace)| trace.first_sample).min()?;
    let end = rows.clone().map(|(_, trace)| trace.first_sample + trace.stands_out.len()).max()?;
    let mut picture = VisibilityPicture::new(last.0 + 1 - first.0, end - start);
    for (ping, trace) in rows {
        picture.put(ping - first.0, trace.first_sample - start, &trace.stands_out);
    }
    let half = |step_m: f64| (0.5 * EYE_M / step_m.max(1e-6)).round() as usize;
    let [pings, samples] = picture.extent([half(spacing_m), half(metres_per_sample)])?;
    let range_m = |sample: usize| (start + sample) as f64 * metres_per_sample;
    let slice = |row: usize| {
        let columns = picture.slice(row, &samples)?;
        Some(VisibleSlice {
            ping: first.0 + row,
            near_m: range_m(columns.start),
            far_m: range_m(columns.end),
            visibility: picture.energy(row, &samples) / (grain * SEEN_RATIO * SEEN_RATIO),
        })
    };
    let slices: Vec<VisibleSlice> = pings.clone().filter_map(slice).collect();
    let visibility: f32 = slices.iter().map(|slice| slice.visibility).sum();
    (visibility >= 1.0).then(|| VisiblePart {
        first_ping: first.0 + pings.start,
        last_ping: first.0 + pings.end - 1,
        near_m: range_m(samples.start),
        far_m: range_m(samples.end),
        slices,
    })
}

/// Differences of levels, with a row for each ping and a column for each sample.
struct VisibilityPicture {
    rows: usize,
    columns: usize,
    levels: Vec<f32>,
    /// True where a level stands out; set by [`VisibilityPicture::extent`].
    stands_out: Vec<bool>,
}

impl VisibilityPicture {
    fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            levels: vec![0.0; rows * columns],
            stands_out: vec![false; rows * columns],
        }
    }

    fn put(&mut self, row: usize, column: usize, levels: &[f32]) {
        let from = row * self.columns + column;
        self.levels[from..from + levels.len()].copy_from_slice(levels);
    }

    /// Returns rows and columns of the box around the levels that stand out, and marks these levels
    /// in `stands_out`; `None` where nothing stands out. Levels are averaged over `2 * half + 1`
    /// rows and columns.
    fn extent(&mut self, half: [usize; 2]) -> Option<[Range<usize>; 2]> {
        let along_columns = running_mean(&self.levels, half[1], [self.rows, self.columns], false);
        let averaged = running_mean(&along_columns, half[0], [self.rows, self.columns], true);
        let (mut by_row, mut by_column) = (vec![0.0; self.rows], vec![0.0; self.columns]);
        for (index, (&own, mean)) in self.levels.iter().zip(averaged).enumerate() {
            if own.abs() >= OWN && mean.abs() >= SEEN {
                let amount = f64::from(own.abs().min(PLAIN));
                by_row[index / self.columns] += amount;
                by_column[index % self.columns] += amount;
                self.stands_out[index] = true;
            }
        }
        Some([trimmed(&by_row)?, trimmed(&by_column)?])
    }

    /// Returns the shortest range of columns, within `columns`, with all levels of a row that stand
    /// out; `None` where none does.
    fn slice(&self, row: usize, columns: &Range<usize>) -> Option<Range<usize>> {
        let seen = &self.stands_out[row * self.columns..][columns.clone()];
        let first = seen.iter().position(|&seen| seen)?;
        let last = seen.iter().rposition(|&seen| seen)?;
        Some(columns.start + first..columns.start + last + 1)
    }

    /// Returns the sum of the squares of one row's levels in some columns.
    fn energy(&self, row: usize, columns: &Range<usize>) -> f32 {
        let levels = &self.levels[row * self.columns..][columns.clone()];
        levels.iter().map(|level| level * level).sum()
    }
}

/// Returns the means over `half` neighbours on either side, along each row or, if `down`, along
/// each column. Levels outside of the picture count as 0.
fn running_mean(levels: &[f32], half: usize, [rows, columns]: [usize; 2], down: bool) -> Vec<f32> {
    let (lines, length) = if down { (columns, rows) } else { (rows, columns) };
    let at = |line: usize, place: usize| {
        if down { place * columns + line } else { line * columns + place }
    };
    let mut means = vec![0.0; levels.len()];
    let width = (2 * half + 1) as f64;
    for line in 0..lines {
        let level = |place: usize| f64::from(levels[at(line, place)]);
        let mut sum: f64 = (0..half.min(length)).map(level).sum();
        for place in 0..length {
            if place + half < length {
                sum += level(place + half);
            }
            if place > half {
                sum -= level(place - half - 1);
            }
            means[at(line, place)] = (sum / width) as f32;
        }
    }
    means
}

/// Returns the shortest range that leaves at most [`TRIMMED`] of the sum at either end; `None`
/// where the sum is 0.
fn trimmed(amounts: &[f64]) -> Option<Range<usize>> {
    let cut = TRIMMED * amounts.iter().sum::<f64>();
    let passes_cut = || {
        let mut sum = 0.0;
        move |amount: &f64| {
            sum += amount;
            sum > cut
        }
    };
    let first = amounts.iter().position(passes_cut())?;
    let last = amounts.iter().rposition(passes_cut())?;
    Some(first..last + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(first_sample: usize, stands_out: Vec<f32>) -> Trace {
        Trace { object: 0, side: Side::Port, metres_per_sample: 0.02, first_sample, stands_out }
    }

    #[test]
    fn the_box_holds_the_echo_and_the_shadow_and_no_faint_end() {
        // Ten samples of echo, thirty of shadow, then twenty of a shadow that noise has filled.
        let levels = [vec![1.5; 10], vec![-1.0; 30], vec![-0.1; 20]].concat();
        let traces: Vec<Trace> = (0..12).map(|_| trace(100, levels.clone())).collect();
        let rows: Vec<(usize, &Trace)> = (40..).zip(&traces).collect();
        let found = visible_part(&rows, 0.1, 1.0).expect("a box");
        assert_eq!([found.first_ping, found.last_ping], [40, 51]);
        assert_eq!(found.slices.len(), 12);
        let slice = found.slices[3];
        assert_eq!((slice.ping, slice.near_m, slice.far_m), (43, found.near_m, found.far_m));
        // The sum of the squares of ten samples of 1.5 and thirty of 1, divided by the square of 5.
        assert!((slice.visibility - 52.5 / 25.0).abs() < 1e-4);
        assert!((found.near_m - 2.0).abs() < 1e-9 && (found.far_m - 2.8).abs() < 1e-9);
    }

    #[test]
    fn speckle_hides_what_is_faint_or_single() {
        let faint = trace(5, vec![0.3; 50]);
        let rows: Vec<(usize, &Trace)> = (0..9).map(|ping| (ping, &faint)).collect();
        assert_eq!(visible_part(&rows, 0.1, 1.0), None);
        let single = trace(5, vec![1.5]);
        assert_eq!(visible_part(&[(3, &single)], 0.1, 1.0), None);
        assert_eq!(visible_part(&[], 0.1, 1.0), None);
    }

    #[test]
    fn an_object_rises_out_of_the_speckle_as_a_whole_or_is_not_shown() {
        let rows = |trace| (0..10).map(move |ping| (ping, trace));
        let plain = trace(5, vec![0.5; 30]);
        let rows: Vec<(usize, &Trace)> = rows(&plain).collect();
        // Some 250 samples of 0.5, without the edges: the signal-to-noise ratio is the root of 63,
        // about 8; with four samples per grain it is half of that.
        assert!(visible_part(&rows, 0.1, 1.0).is_some());
        assert_eq!(visible_part(&rows, 0.1, 4.0), None);
    }

    #[test]
    fn a_running_mean_is_the_mean() {
        let levels: Vec<f32> = (0..35).map(|i| ((i * 7919) % 23) as f32).collect();
        for half in [0, 1, 3, 9] {
            for down in [false, true] {
                let means = running_mean(&levels, half, [5, 7], down);
                for (row, column) in (0..5).flat_map(|row| (0..7).map(move |column| (row, column)))
                {
                    let half = half as isize;
                    let neighbours = (-half..=half).map(|off| {
                        let (row, column) = (row as isize, column as isize);
                        let [row, column] =
                            if down { [row + off, column] } else { [row, column + off] };
                        let inside = (0..5).contains(&row) && (0..7).contains(&column);
                        if inside { levels[(row * 7 + column) as usize] } else { 0.0 }
                    });
                    let mean = neighbours.sum::<f32>() / (2 * half + 1) as f32;
                    assert!((means[row * 7 + column] - mean).abs() < 1e-4);
                }
            }
        }
    }
}
