//! Where the bottom is flat along the track.

use super::FlatSpot;
use crate::progress::{Cancelled, Progress};
use crate::statistics::median;
use crate::survey::{Navigation, Survey};
use std::ops::Range;

/// Length of a stretch, metres, where the track is long enough.
const LENGTH_M: f64 = 10.0;
/// Pings in a stretch, at least.
const MIN_PINGS: usize = 20;
/// Slower than this the boat is at rest, metres a second: its depth is flat whatever the bottom is.
const MIN_SPEED_MPS: f64 = 0.2;
/// A pause between two pings that ends a stretch, seconds.
const MAX_PAUSE_S: f64 = 2.0;

/// Ranks the flattest stretches of the track, flattest first, at most `count`, not overlapping.
///
/// A stretch is flat when the recorded depth varies little over it and, with a quarter of the weight, over three times
/// its length: many stretches tie where the recorder rounds depths to 0.1 m, and the middle of a plain is the safest.
pub fn flat_spots(
    survey: &Survey,
    navigation: &Navigation,
    count: usize,
    progress: &Progress,
) -> Result<Vec<FlatSpot>, Cancelled> {
    let profile = Profile::new(survey, navigation);
    let starts: Vec<usize> = (0..profile.len()).step_by(MIN_PINGS / 4).collect();
    progress.start(starts.len() as u64);
    let length_m = LENGTH_M.min(profile.length_m() / 6.0);
    let mut ranked = Vec::new();
    for chunk in starts.chunks(4096) {
        progress.check()?;
        for &start in chunk {
            let Some(pings) = profile.stretch(start, length_m) else {
                continue;
            };
            let wide = profile.around(&pings, length_m);
            ranked.push((
                profile.variation_m(&pings) + profile.variation_m(&wide) / 4.0,
                pings,
            ));
        }
        progress.advance(chunk.len() as u64);
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut spots: Vec<FlatSpot> = Vec::new();
    for (_, pings) in ranked {
        if spots.len() == count {
            break;
        }
        let overlaps =
            |spot: &FlatSpot| spot.pings.start < pings.end && pings.start < spot.pings.end;
        if !spots.iter().any(overlaps) {
            spots.push(profile.describe(pings));
        }
    }
    Ok(spots)
}

/// Depth and slope of a stretch that the user chose; `None` when it holds no recorded depth.
pub(super) fn describe(
    survey: &Survey,
    navigation: &Navigation,
    pings: Range<usize>,
) -> Option<FlatSpot> {
    let profile = Profile::new(survey, navigation);
    let spot = profile.describe(pings.start..pings.end.min(profile.len()));
    spot.depth_m.is_finite().then_some(spot)
}

/// Recorded depth against distance along the track, with running sums so that any stretch costs the same.
struct Profile {
    depths_m: Vec<f64>,
    /// Distance sailed up to each ping, metres.
    along_m: Vec<f64>,
    /// Sums over the usable pings before each index.
    sums: Vec<Sums>,
}

#[derive(Clone, Copy, Default)]
struct Sums {
    usable: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Profile {
    fn new(survey: &Survey, navigation: &Navigation) -> Self {
        let pings = &survey.side_scan;
        let mut along_m = Vec::with_capacity(pings.len());
        let mut distance_m = 0.0;
        for (index, place) in navigation.pings.iter().enumerate() {
            let pause_s = pings[index].time_s - pings[index.saturating_sub(1)].time_s;
            if place.speed_mps.is_finite() && pause_s < MAX_PAUSE_S {
                distance_m += place.speed_mps * pause_s;
            }
            along_m.push(distance_m);
        }
        let usable = |index: usize| {
            let pause_s = pings[index].time_s - pings[index.saturating_sub(1)].time_s;
            pings[index].locked_depth_m() > 0.0
                && pause_s < MAX_PAUSE_S
                && navigation.pings[index].speed_mps >= MIN_SPEED_MPS
        };
        let mut sums = vec![Sums::default()];
        for index in 0..along_m.len() {
            let last = sums[index];
            let (x, y) = (along_m[index], f64::from(pings[index].depth_m));
            sums.push(if usable(index) { last.with(x, y) } else { last });
        }
        Self {
            depths_m: pings.iter().map(|ping| f64::from(ping.depth_m)).collect(),
            along_m,
            sums,
        }
    }

    fn len(&self) -> usize {
        self.along_m.len()
    }

    fn length_m(&self) -> f64 {
        self.along_m.last().copied().unwrap_or(0.0)
    }

    /// Pings from `start` on that cover `length_m`, all of them usable.
    fn stretch(&self, start: usize, length_m: f64) -> Option<Range<usize>> {
        let goal_m = self.along_m[start] + length_m;
        let end = self
            .along_m
            .partition_point(|&along_m| along_m < goal_m)
            .max(start + MIN_PINGS);
        let complete = end < self.len() && self.sums(start..end).usable == (end - start) as f64;
        complete.then_some(start..end)
    }

    /// A stretch with `margin_m` more on either side.
    fn around(&self, pings: &Range<usize>, margin_m: f64) -> Range<usize> {
        let from_m = self.along_m[pings.start] - margin_m;
        let to_m = self.along_m[pings.end - 1] + margin_m;
        let place = |goal_m: f64| self.along_m.partition_point(|&along_m| along_m < goal_m);
        // Where the boat seems not to move, because a log gives one time to all pings, no distance is below the goal.
        place(from_m).min(pings.start)..place(to_m).max(pings.end)
    }

    fn sums(&self, pings: Range<usize>) -> Sums {
        let (a, b) = (self.sums[pings.start], self.sums[pings.end]);
        Sums {
            usable: b.usable - a.usable,
            x: b.x - a.x,
            y: b.y - a.y,
            xx: b.xx - a.xx,
            xy: b.xy - a.xy,
            yy: b.yy - a.yy,
        }
    }

    /// How much the depth varies over a stretch: rise of its line and twice the scatter about it, metres.
    fn variation_m(&self, pings: &Range<usize>) -> f64 {
        let (slope, scatter_m) = self.sums(pings.clone()).line();
        let length_m = self.along_m[pings.end - 1] - self.along_m[pings.start];
        slope.abs() * length_m + 2.0 * scatter_m
    }

    fn describe(&self, pings: Range<usize>) -> FlatSpot {
        let (slope, scatter_m) = if pings.is_empty() {
            (f64::NAN, f64::NAN)
        } else {
            self.sums(pings.clone()).line()
        };
        let depths = self.depths_m.get(pings.clone()).unwrap_or_default();
        let mut recorded: Vec<f64> = depths
            .iter()
            .copied()
            .filter(|&depth_m| depth_m > 0.0)
            .collect();
        FlatSpot {
            pings,
            depth_m: median(&mut recorded),
            slope,
            scatter_m,
        }
    }
}

impl Sums {
    fn with(self, x: f64, y: f64) -> Self {
        Self {
            usable: self.usable + 1.0,
            x: self.x + x,
            y: self.y + y,
            xx: self.xx + x * x,
            xy: self.xy + x * y,
            yy: self.yy + y * y,
        }
    }

    /// Least-squares slope, and the standard deviation about the line.
    fn line(&self) -> (f64, f64) {
        let n = self.usable.max(1.0);
        let xx = (self.xx - self.x * self.x / n).max(0.0);
        let xy = self.xy - self.x * self.y / n;
        let yy = (self.yy - self.y * self.y / n).max(0.0);
        let slope = if xx > 1e-6 * n { xy / xx } else { 0.0 };
        (slope, ((yy - slope * xy).max(0.0) / n).sqrt())
    }
}
