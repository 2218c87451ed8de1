//! Draws a whole log in one picture for the report: a sample of its pings beside each other, port
//! above and starboard below, with the first return.

use super::jpeg_address;
use crate::pipeline::ProcessedLog;
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::waterfall::{Levels, RangeAxis};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Side;
use rayon::prelude::*;

/// Largest number of columns of the picture.
const COLUMNS: usize = 1040;
/// Number of rows of each side.
const SIDE_ROWS: usize = 150;
/// Largest number of pings that are read for a column, evenly spread over the pings of the column.
const READ: usize = 4;
/// Room for the labels of ranges on the left, pixels.
const LEFT: usize = 40;

/// Returns the values with which the page shows a log: its picture, the lines and the labels;
/// `None` without side-scan.
pub(super) fn strip(
    log: &ProcessedLog,
    name: &str,
    progress: &Progress,
) -> Result<Option<Value>, Cancelled> {
    let Some(axis) = RangeAxis::of(&log.survey).filter(|_| log.survey.has_side_scan()) else {
        return Ok(None);
    };
    let columns = COLUMNS.min(axis.pings);
    let strip = ReportStrip { log, far_m: axis.far_m, columns };
    let levels = Levels::of(&log.survey);
    progress.start(columns as u64);
    let drawn = (0..columns).into_par_iter().map(|column| {
        progress.check()?;
        progress.advance(1);
        Ok(strip.column(column, levels))
    });
    let drawn = drawn.collect::<Result<Vec<_>, Cancelled>>()?;
    let rows = 2 * SIDE_ROWS;
    let mut pixels = vec![0; columns * rows];
    for (column, shades) in drawn.iter().enumerate() {
        for (row, shade) in shades.iter().enumerate() {
            pixels[row * columns + column] = *shade;
        }
    }
    Ok(Some(strip.values(name, jpeg_address(&pixels, columns, rows))))
}

struct ReportStrip<'a> {
    log: &'a ProcessedLog,
    far_m: f64,
    columns: usize,
}

impl ReportStrip<'_> {
    /// Returns the pings of a column.
    fn pings(&self, column: usize) -> std::ops::Range<usize> {
        let pings = self.log.survey.side_scan.len();
        column * pings / self.columns..((column + 1) * pings / self.columns).max(1)
    }

    /// Returns the shades of a column, from the far end of port to the far end of starboard.
    fn column(&self, column: usize, levels: Levels) -> Vec<u8> {
        let pings = self.pings(column);
        let step = pings.len().div_ceil(READ).max(1);
        let mut sums = vec![0.0; 2 * SIDE_ROWS];
        let mut read = 0;
        for ping in pings.step_by(step) {
            read += 1;
            for side in Side::BOTH {
                self.add(ping, side, &mut sums);
            }
        }
        let shade = |sum: f32| {
            let echo = sum / read.max(1) as f32 / 255.0;
            let share = (echo - levels.black) / (levels.white - levels.black);
            (255.0 * share.clamp(0.0, 1.0)).round() as u8
        };
        sums.into_iter().map(shade).collect()
    }

    /// Adds the mean echo in each row of one side of a ping to the sums of the rows of that side.
    fn add(&self, ping: usize, side: Side, sums: &mut [f32]) {
        let (survey, reduction) = (&self.log.survey, self.log.products.reduction());
        let (Some(span), Some(samples)) = (survey.span(ping, side), survey.samples(ping, side))
        else {
            return;
        };
        for row in 0..SIDE_ROWS {
            let [from, to] = [row, row + 1].map(|row| {
                let range_m = row as f64 / SIDE_ROWS as f64 * self.far_m;
                let sample = reduction.sample_at(span, range_m);
                sample.clamp(0.0, samples.len() as f64) as usize
            });
            if to > from {
                let sum: u32 = (from..to).map(|sample| u32::from(samples.get(sample))).sum();
                let place = match side {
                    Side::Port => SIDE_ROWS - 1 - row,
                    Side::Starboard => SIDE_ROWS + row,
                };
                sums[place] += sum as f32 / (to - from) as f32;
            }
        }
    }

    /// Returns the vertical position of a range in the picture, pixels.
    fn y(&self, side: Side, range_m: f64) -> f64 {
        let rows = range_m / self.far_m * SIDE_ROWS as f64;
        match side {
            Side::Port => SIDE_ROWS as f64 - rows,
            Side::Starboard => SIDE_ROWS as f64 + rows,
        }
    }

    /// Returns an SVG path through the median first return of each column.
    fn line(&self, side: Side) -> String {
        let reduction = self.log.products.reduction();
        let mut path = String::new();
        let mut is_down = false;
        for column in 0..self.columns {
            let mut ranges: Vec<f64> = self
                .pings(column)
                .filter_map(|ping| {
                    let pick = self.log.products.returns.side(side).get(ping)?;
                    let span = self.log.survey.span(ping, side)?;
                    let sample = f64::from(pick.sample);
                    pick.is_some().then(|| reduction.range_m(span, sample))
                })
                .collect();
            is_down = if ranges.is_empty() {
                false
            } else {
                let letter = if is_down { 'L' } else { 'M' };
                let range_m = bathyscope_log::support::statistics::median(&mut ranges);
                let (x, y) = (LEFT + column, self.y(side, range_m));
                path += &format!("{letter}{x} {y:.1}");
                true
            };
        }
        path
    }

    fn values(&self, name: &str, picture: String) -> Value {
        let height = 2 * SIDE_ROWS;
        let ranges = Side::BOTH.into_iter().flat_map(|side| {
            [0.5, 1.0].map(|share| {
                let range_m = share * self.far_m;
                let y = self.y(side, range_m).clamp(9.0, height as f64 - 2.0);
                (format!("{y:.1}"), format!("{range_m:.0}"))
            })
        });
        context! {
            name,
            picture,
            left => LEFT,
            width => LEFT + self.columns,
            columns => self.columns,
            height,
            port => self.line(Side::Port),
            starboard => self.line(Side::Starboard),
            ranges => ranges.collect::<Vec<_>>(),
        }
    }
}
