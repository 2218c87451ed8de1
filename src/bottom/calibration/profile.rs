//! Measures the slope and the variation of the recorded depth along the track.

use bathyscope_log::survey::{Navigation, Survey};
use std::array::from_fn;
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
    /// Sums over the usable pings before each index: of 1, x, y, x², x y and y², of the distance x
    /// and the depth y, metres.
    sums: Vec<[f64; 6]>,
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
        let mut sums = vec![[0.0; 6]];
        for index in 0..along_m.len() {
            let (x, y) = (along_m[index], f64::from(pings[index].depth_m));
            let (last, added) = (sums[index], [1.0, x, y, x * x, x * y, y * y]);
            sums.push(if usable(index) { from_fn(|of| last[of] + added[of]) } else { last });
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
        let complete = end < self.len() && self.sums(&(start..end))[0] == (end - start) as f64;
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

    fn sums(&self, pings: &Range<usize>) -> [f64; 6] {
        let (a, b) = (self.sums[pings.start], self.sums[pings.end]);
        from_fn(|of| b[of] - a[of])
    }

    /// Returns the variation of the depth over a stretch, metres: the rise of its line plus twice
    /// the scatter about this line.
    pub(super) fn variation_m(&self, pings: &Range<usize>) -> f64 {
        let (slope, scatter_m) = line_of(self.sums(pings));
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
        line_of(self.sums(pings))
    }
}

/// Returns the least-squares slope of the points that were summed, and the standard deviation about
/// the line.
fn line_of([usable, x, y, xx, xy, yy]: [f64; 6]) -> (f64, f64) {
    let n = usable.max(1.0);
    let xx = (xx - x * x / n).max(0.0);
    let xy = xy - x * y / n;
    let yy = (yy - y * y / n).max(0.0);
    let slope = if xx > 1e-6 * n { xy / xx } else { 0.0 };
    (slope, ((yy - slope * xy).max(0.0) / n).sqrt())
}
