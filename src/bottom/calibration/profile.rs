//! Measures the slope and the variation of the recorded depth along the track.

use bathyscope_log::survey::{Navigation, Survey};
use std::ops::Range;

/// Speed below which the boat is at rest, metres a second: its depth is flat whatever the bottom
/// is.
const MIN_SPEED_MPS: f64 = 0.2;
/// Shortest pause between two pings that ends a stretch, seconds.
const MAX_PAUSE_S: f64 = 2.0;

/// Recorded depth against distance along the track, with running sums so that any stretch costs the
/// same.
pub(super) struct Profile {
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
    pub(super) fn new(survey: &Survey, navigation: &Navigation) -> Self {
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
            pings[index].good_depth_m() > 0.0
                && pause_s < MAX_PAUSE_S
                && navigation.pings[index].speed_mps >= MIN_SPEED_MPS
        };
        let mut sums = vec![Sums::default()];
        for index in 0..along_m.len() {
            let last = sums[index];
            let (x, y) = (along_m[index], f64::from(pings[index].depth_m));
            sums.push(if usable(index) { last.with(x, y) } else { last });
        }
        Self { along_m, sums }
    }

    pub(super) fn len(&self) -> usize {
        self.along_m.len()
    }

    pub(super) fn length_m(&self) -> f64 {
        self.along_m.last().copied().unwrap_or(0.0)
    }

    /// Returns the shortest stretch from `start` that is at least `length_m` long and has at least
    /// `min_pings` pings; `None` where one of them has no usable depth, or the track ends before.
    pub(super) fn stretch(
        &self,
        start: usize,
        length_m: f64,
        min_pings: usize,
    ) -> Option<Range<usize>> {
        let goal_m = self.along_m[start] + length_m;
        let end = self.along_m.partition_point(|&along_m| along_m < goal_m).max(start + min_pings);
        let complete = end < self.len() && self.sums(&(start..end)).usable == (end - start) as f64;
        complete.then_some(start..end)
    }

    /// Returns a stretch with `margin_m` more on either side.
    pub(super) fn around(&self, pings: &Range<usize>, margin_m: f64) -> Range<usize> {
        let from_m = self.along_m[pings.start] - margin_m;
        let to_m = self.along_m[pings.end - 1] + margin_m;
        let place = |goal_m: f64| self.along_m.partition_point(|&along_m| along_m < goal_m);
        // Where the boat seems not to move, because a log gives one time to all pings, no distance
        // is below the goal.
        place(from_m).min(pings.start)..place(to_m).max(pings.end)
    }

    fn sums(&self, pings: &Range<usize>) -> Sums {
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

    /// Returns the variation of the depth over a stretch, metres: the rise of its line plus twice
    /// the scatter about this line.
    pub(super) fn variation_m(&self, pings: &Range<usize>) -> f64 {
        let (slope, scatter_m) = self.sums(pings).line();
        let length_m = self.along_m[pings.end - 1] - self.along_m[pings.start];
        slope.abs() * length_m + 2.0 * scatter_m
    }

    /// Returns the length of a stretch along the track, metres.
    pub(super) fn way_m(&self, pings: &Range<usize>) -> f64 {
        let ends = self.along_m.get(pings.start..pings.end).unwrap_or_default();
        let ends = ends.first().zip(ends.last());
        ends.map_or(0.0, |(from_m, to_m)| to_m - from_m)
    }

    /// Returns the least-squares slope of the depth, metres a metre, and the standard deviation
    /// about its line, metres; NaN for no pings.
    pub(super) fn line(&self, pings: &Range<usize>) -> (f64, f64) {
        if pings.is_empty() {
            return (f64::NAN, f64::NAN);
        }
        self.sums(pings).line()
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

    /// Returns the least-squares slope, and the standard deviation about the line.
    fn line(&self) -> (f64, f64) {
        let n = self.usable.max(1.0);
        let xx = (self.xx - self.x * self.x / n).max(0.0);
        let xy = self.xy - self.x * self.y / n;
        let yy = (self.yy - self.y * self.y / n).max(0.0);
        let slope = if xx > 1e-6 * n { xy / xx } else { 0.0 };
        (slope, ((yy - slope * xy).max(0.0) / n).sqrt())
    }
}
