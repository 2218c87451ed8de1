//! Resamples one side of the survey into a picture whose pixels are square on the bottom.
//!
//! Rows follow the distance sailed, columns the slant range outward, both in steps of
//! [`Raster::pixel_m`]; port and starboard look alike (range grows to the right, shadows fall to
//! the right), so that a detector learns one geometry. Columns are slant range, not ground range:
//! the water column distinguishes a fish from a stone, and the picture does not depend on a first
//! return. Beyond twice the altitude, a metre of slant range differs from a metre on the bottom by
//! less than 15 %.

use super::{Mark, Rect};
use bathyscope_log::survey::{Navigation, Side, Survey};
use std::ops::Range;

/// Rows and columns of a tile.
pub const TILE_PX: usize = 416;
/// Speed assumed where the speed in the log is missing or too high, metres a second.
const USUAL_SPEED_MPS: f64 = 1.5;
/// Least speed that is used, metres a second: a boat at rest records the same ground again, but
/// every ping must keep its place in the order.
const LEAST_SPEED_MPS: f64 = 0.05;
/// Highest speed that is used, 15 knots in metres a second: a higher one is due to positions that
/// jump, and would stretch a ping over many rows.
const MOST_SPEED_MPS: f64 = 8.0;
/// Longest pause between two pings that is used, seconds.
const LONGEST_PAUSE_S: f64 = 2.0;

/// Places of the pings in the picture. The pixels are computed one tile at a time.
#[derive(Clone, Debug)]
pub struct Raster {
    /// Side of a pixel, metres.
    pub pixel_m: f64,
    /// Distance sailed up to the middle of each ping, metres, strictly growing.
    along_m: Vec<f64>,
    /// Number of columns of the whole picture, given by the survey's longest range.
    pub columns: usize,
}

/// A tile of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RasterTile {
    /// Side of the survey.
    pub side: Side,
    /// Row of the picture that the tile starts at.
    pub row: usize,
    /// Column of the picture that the tile starts at.
    pub column: usize,
    /// [`TILE_PX`] rows of [`TILE_PX`] echo levels; 0 beyond the survey's end and range.
    pub pixels: Vec<u8>,
}

impl Raster {
    /// Computes the places of the pings. `pixel_m` is the side of a pixel, metres (0.04 for the
    /// shipped models).
    pub fn new(survey: &Survey, navigation: &Navigation, pixel_m: f64) -> Self {
        let mut along_m = Vec::with_capacity(survey.side_scan.len());
        let (mut distance_m, mut last_s) = (0.0, f64::NAN);
        for (ping, place) in survey.side_scan.iter().zip(navigation.pings.iter()) {
            let speed_mps = if place.speed_mps <= MOST_SPEED_MPS {
                place.speed_mps.max(LEAST_SPEED_MPS)
            } else {
                USUAL_SPEED_MPS
            };
            // The first ping, and pings that share a time stamp, advance by a millisecond.
            let pause_s = (ping.time_s - last_s).clamp(0.001, LONGEST_PAUSE_S);
            distance_m += speed_mps * if pause_s.is_finite() { pause_s } else { 0.001 };
            last_s = ping.time_s;
            along_m.push(distance_m);
        }
        let far_m = survey
            .side_scan
            .iter()
            .flat_map(|ping| [ping.port, ping.starboard])
            .flatten()
            .fold(0.0_f64, |far_m, span| far_m.max(f64::from(span.far_m)));
        Self {
            pixel_m,
            along_m,
            // A recorder's range is below a kilometre; a larger one is from a damaged header and is
            // limited.
            columns: (far_m.min(1000.0) / pixel_m).ceil() as usize,
        }
    }

    /// Returns the raster with pixels that are larger by a factor.
    pub fn coarser(&self, factor: f64) -> Self {
        Self {
            pixel_m: self.pixel_m * factor,
            along_m: self.along_m.clone(),
            columns: (self.columns as f64 / factor).ceil() as usize,
        }
    }

    /// Returns the number of rows of the whole picture.
    pub fn rows(&self) -> usize {
        (self.along_m.last().copied().unwrap_or(0.0) / self.pixel_m).ceil() as usize
    }

    /// Returns the row of a ping, both as fractional numbers (a ping covers `ping` to `ping + 1`).
    pub fn row_of(&self, ping: f64) -> f64 {
        let centred = (ping - 0.5).clamp(0.0, self.along_m.len().saturating_sub(1) as f64);
        let low = centred.floor() as usize;
        let Some(&from_m) = self.along_m.get(low) else {
            return 0.0;
        };
        let to_m = self.along_m.get(low + 1).copied().unwrap_or(from_m);
        (from_m + (to_m - from_m) * centred.fract()) / self.pixel_m
    }

    /// Returns the ping of a row: the inverse of [`Raster::row_of`].
    pub fn ping_of(&self, row: f64) -> f64 {
        let goal_m = row * self.pixel_m;
        let after = self.along_m.partition_point(|&along_m| along_m < goal_m);
        if after == 0 || self.along_m.is_empty() {
            return 0.5;
        }
        let before = after - 1;
        let Some(&to_m) = self.along_m.get(after) else {
            return before as f64 + 0.5;
        };
        let from_m = self.along_m[before];
        before as f64 + 0.5 + (goal_m - from_m) / (to_m - from_m)
    }

    /// Converts a mark to a box in the pixels of the whole picture.
    pub fn rect_of(&self, mark: &Mark) -> Rect {
        Rect::new(
            [(mark.near_m / self.pixel_m) as f32, self.row_of(mark.pings.start as f64) as f32],
            [(mark.far_m / self.pixel_m) as f32, self.row_of(mark.pings.end as f64) as f32],
        )
    }

    /// Converts a box in the pixels of the whole picture to a mark of at least one ping.
    pub(crate) fn mark_of(&self, side: Side, rect: &Rect) -> Mark {
        let start = self.ping_of(f64::from(rect.y0)).round().max(0.0) as usize;
        let end = self.ping_of(f64::from(rect.y1)).round() as usize;
        let last = self.along_m.len().saturating_sub(1);
        Mark::new(
            side,
            start.min(last)..end.clamp(start.min(last) + 1, last + 1),
            [f64::from(rect.x0.max(0.0)) * self.pixel_m, f64::from(rect.x1) * self.pixel_m],
        )
    }

    /// Returns the row and column at which a tile around the middle of a box starts, limited to the
    /// picture.
    pub(crate) fn start_about(&self, rect: &Rect) -> [usize; 2] {
        let start = |from: f32, to: f32, count: usize| {
            let requested = (0.5 * (from + to) - 0.5 * TILE_PX as f32).max(0.0) as usize;
            requested.min(count.saturating_sub(TILE_PX))
        };
        [start(rect.y0, rect.y1, self.rows()), start(rect.x0, rect.x1, self.columns)]
    }

    /// Returns true if most pings of a tile were recorded at least to the middle of its columns. A
    /// network finds nothing in rows that are mostly dark, and a few pings of a long range must not
    /// make the whole survey wide.
    pub(crate) fn is_recorded(
        &self,
        survey: &Survey,
        side: Side,
        row: usize,
        column: usize,
    ) -> bool {
        let ping_at = |row: usize| {
            let goal_m = row as f64 * self.pixel_m;
            self.along_m.partition_point(|&along_m| along_m < goal_m)
        };
        let pings = ping_at(row)..ping_at(row + TILE_PX);
        let shown = self.columns.saturating_sub(column).min(TILE_PX);
        let middle_m = (column as f64 + 0.5 * shown as f64) * self.pixel_m;
        let spans = pings.filter_map(|ping| survey.span(ping, side));
        let (mut count, mut reaching) = (0, 0);
        for span in spans {
            count += 1;
            reaching += usize::from(f64::from(span.far_m) >= middle_m);
        }
        // If the tile has no ping of its own, the pings before and after it are drawn.
        2 * reaching >= count
    }

    /// Draws a tile. Each pixel is the mean of the samples of a ping that it covers; between pings,
    /// rows are interpolated, and if pings are closer than rows, a row is the mean of its pings.
    pub fn tile(&self, survey: &Survey, side: Side, row: usize, column: usize) -> RasterTile {
        let mut pixels = vec![0; TILE_PX * TILE_PX];
        let mut lines = Lines::new(survey, side, self.pixel_m, column);
        let mut sum = [0.0_f32; TILE_PX];
        for (index, out) in pixels.chunks_exact_mut(TILE_PX).enumerate() {
            let middle_m = ((row + index) as f64 + 0.5) * self.pixel_m;
            if middle_m > self.along_m.last().copied().unwrap_or(0.0) {
                break;
            }
            sum.fill(0.0);
            for (ping, weight) in self.weights(middle_m) {
                for (sum, level) in sum.iter_mut().zip(lines.of(ping)) {
                    *sum += weight * level;
                }
            }
            for (out, sum) in out.iter_mut().zip(&sum) {
                *out = rounded(*sum);
            }
        }
        RasterTile { side, row, column, pixels }
    }

    /// Returns the pings of a row, with weights that add up to 1.
    fn weights(&self, middle_m: f64) -> impl Iterator<Item = (usize, f32)> {
        let half_m = 0.5 * self.pixel_m;
        let place = |goal_m: f64| self.along_m.partition_point(|&along_m| along_m < goal_m);
        let inside = place(middle_m - half_m)..place(middle_m + half_m);
        let (between, far_share) = if inside.is_empty() {
            let after = inside.end.min(self.along_m.len() - 1);
            let before = after.saturating_sub(1);
            let gap_m = self.along_m[after] - self.along_m[before];
            let share = if gap_m > 0.0 {
                ((middle_m - self.along_m[before]) / gap_m).clamp(0.0, 1.0)
            } else {
                1.0
            };
            (before..after + 1, Some(share as f32))
        } else {
            (inside, None)
        };
        let Range { start, end } = between;
        (start..end).map(move |ping| {
            let weight = match far_share {
                None => 1.0 / (end - start) as f32,
                Some(_) if end - start == 1 => 1.0,
                Some(share) if ping == start => 1.0 - share,
                Some(share) => share,
            };
            (ping, weight)
        })
    }
}

/// Returns the sample whose near edge is nearest to a fractional sample number; 0 for a negative
/// one. Does not use `f64::round`, which is a function of the C library and took a third of the
/// time of a tile.
fn index_at(sample: f64) -> usize {
    let low = sample as usize;
    low.saturating_add(usize::from(sample - low as f64 >= 0.5))
}

/// Returns the level nearest to a number that is not negative.
fn rounded(level: f32) -> u8 {
    let low = level as u8;
    low.saturating_add(u8::from(level - f32::from(low) >= 0.5))
}

/// Pings resampled to the columns of one tile. The last two are kept, since a row uses the same few
/// pings as its neighbour.
struct Lines<'a> {
    survey: &'a Survey,
    side: Side,
    pixel_m: f64,
    column: usize,
    kept: [(usize, Vec<f32>); 2],
    samples: Vec<u8>,
}

impl<'a> Lines<'a> {
    fn new(survey: &'a Survey, side: Side, pixel_m: f64, column: usize) -> Self {
        let none = || (usize::MAX, vec![0.0; TILE_PX]);
        Self { survey, side, pixel_m, column, kept: [none(), none()], samples: Vec::new() }
    }

    fn of(&mut self, ping: usize) -> &[f32] {
        let slot = ping % 2;
        if self.kept[slot].0 != ping {
            self.kept[slot].0 = ping;
            self.resample(ping, slot);
        }
        &self.kept[slot].1
    }

    fn resample(&mut self, ping: usize, slot: usize) {
        let line = &mut self.kept[slot].1;
        line.fill(0.0);
        let (Some(span), Some(samples)) =
            (self.survey.span(ping, self.side), self.survey.samples(ping, self.side))
        else {
            return;
        };
        let last_m = (self.column + line.len()) as f64 * self.pixel_m;
        let part = index_at(span.sample_at(self.column as f64 * self.pixel_m)).saturating_sub(1)
            ..index_at(span.sample_at(last_m)).saturating_add(2).min(samples.len());
        samples.copy_part_outward(part.clone(), &mut self.samples);
        let held = |samples: Range<usize>| {
            let [start, end] = [samples.start, samples.end].map(|at| at.checked_sub(part.start));
            self.samples.get(start?..end?)
        };
        for (index, level) in line.iter_mut().enumerate() {
            let near_m = (self.column + index) as f64 * self.pixel_m;
            let from = index_at(span.sample_at(near_m));
            let to = index_at(span.sample_at(near_m + self.pixel_m));
            // If samples are coarser than pixels, the sample at the pixel's middle is used.
            let middle = span.sample_at(near_m + 0.5 * self.pixel_m);
            let covered = if to > from {
                from..to.min(part.end)
            } else if middle >= 0.0 {
                middle as usize..middle as usize + 1
            } else {
                continue;
            };
            if let Some(covered) = held(covered).filter(|some| !some.is_empty()) {
                let sum: u32 = covered.iter().map(|&sample| u32::from(sample)).sum();
                *level = sum as f32 / covered.len() as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::survey;
    use std::sync::Arc;

    #[test]
    fn a_mark_and_its_box_are_the_same_place() {
        let (survey, navigation) = survey(200, |_, _| 0);
        let raster = Raster::new(&survey, &navigation, 0.04);
        assert_eq!(raster.columns, 250);
        let mark = Mark::new(Side::Port, 40..52, [3.2, 4.8]);
        let rect = raster.rect_of(&mark);
        // Twelve pings of 0.2 m are 60 rows of 0.04 m.
        assert!((rect.y1 - rect.y0 - 60.0).abs() < 0.01, "{rect:?}");
        assert!((rect.x0 - 80.0).abs() < 1e-3 && (rect.x1 - 120.0).abs() < 1e-3);
        let back = raster.mark_of(Side::Port, &rect);
        assert_eq!((back.side, back.pings.clone()), (mark.side, mark.pings));
        assert!((back.near_m - 3.2).abs() < 1e-5 && (back.far_m - 4.8).abs() < 1e-5);
        assert_eq!(back.samples(&survey), 32..48);
    }

    #[test]
    fn a_bright_patch_lands_in_its_box() {
        let (survey, navigation) = survey(200, |ping, sample| {
            u8::from((40..52).contains(&ping) && (32..48).contains(&sample)) * 200
        });
        let raster = Raster::new(&survey, &navigation, 0.04);
        let tile = raster.tile(&survey, Side::Port, 100, 50);
        let mark = Mark::new(Side::Port, 40..52, [3.2, 4.8]);
        let rect = raster.rect_of(&mark).shifted(-50.0, -100.0);
        for (index, &pixel) in tile.pixels.iter().enumerate() {
            let (x, y) = ((index % TILE_PX) as f32 + 0.5, (index / TILE_PX) as f32 + 0.5);
            // Interpolation blurs the edges by a ping (5 rows) along the track, and by a pixel in
            // range.
            let inside = |grow_x: f32, grow_y: f32| {
                (rect.x0 - grow_x..rect.x1 + grow_x).contains(&x)
                    && (rect.y0 - grow_y..rect.y1 + grow_y).contains(&y)
            };
            if inside(-1.5, -3.0) {
                assert_eq!(pixel, 200, "dark inside at {x}, {y}");
            }
            if !inside(1.5, 3.0) {
                assert_eq!(pixel, 0, "bright outside at {x}, {y}");
            }
        }
    }

    #[test]
    fn a_side_that_was_not_recorded_is_dark_and_an_empty_survey_has_no_rows() {
        let (some, navigation) = survey(20, |_, _| 90);
        let raster = Raster::new(&some, &navigation, 0.04);
        let tile = raster.tile(&some, Side::Starboard, 0, 0);
        assert!(tile.pixels.iter().all(|&pixel| pixel == 0));
        let (none, navigation) = survey(0, |_, _| 0);
        let raster = Raster::new(&none, &navigation, 0.04);
        assert_eq!((raster.rows(), raster.columns), (0, 0));
        assert_eq!(raster.tile(&none, Side::Port, 0, 0).pixels.len(), TILE_PX * TILE_PX);
    }

    #[test]
    fn positions_that_jump_do_not_stretch_the_picture() {
        let (some, mut navigation) = survey(200, |_, _| 90);
        let sound = Raster::new(&some, &navigation, 0.04).rows();
        for (ping, place) in Arc::make_mut(&mut navigation.pings).iter_mut().enumerate() {
            place.speed_mps = 10f64.powi(ping as i32 % 8 + 1);
        }
        let rows = Raster::new(&some, &navigation, 0.04).rows();
        assert!(rows <= sound, "{rows} rows instead of {sound}");
    }

    #[test]
    fn what_few_pings_were_recorded_to_is_not_searched() {
        let (mut some, navigation) = survey(400, |_, _| 90);
        for ping in Arc::make_mut(&mut some.side_scan).iter_mut().step_by(5) {
            ping.port.as_mut().unwrap().far_m = 400.0;
        }
        let raster = Raster::new(&some, &navigation, 0.04);
        assert_eq!(raster.columns, 10_000);
        let is_recorded = |column| raster.is_recorded(&some, Side::Port, 300, column);
        assert!(is_recorded(0));
        assert!(!is_recorded(208) && !is_recorded(9_000));
        // A survey that is narrower than a tile is recorded everywhere.
        let (narrow, navigation) = survey(400, |_, _| 90);
        let raster = Raster::new(&narrow, &navigation, 0.04);
        assert!(raster.is_recorded(&narrow, Side::Port, 300, 0));
    }
}
