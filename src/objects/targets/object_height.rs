//! Combines the heights of all sightings of an object into one height above the bottom.

use super::Target;
use crate::ObjectExtent;
use bathyscope_log::survey::Side;

/// Difference up to which two heights agree, in joint standard deviations.
const AGREE_SIGMAS: f64 = 2.5;
/// Ratio of the mean height to its standard deviation up to which a height that the program found
/// may as well be 0.
const LEAST_SIGMAS: f64 = 1.0;
/// Least standard deviation with which a height counts, metres.
const LEAST_SIGMA_M: f64 = 0.01;

/// The height of an object above the bottom, from all its sightings.
#[derive(Clone, Copy, Debug)]
pub struct ObjectHeight {
    /// Mean of the heights that agree with the surest one, weighted by the inverse of their
    /// variances, metres; NaN without a height.
    pub mean_m: f64,
    /// Standard deviation of the mean, metres; NaN without a height. It is larger if the sightings
    /// differ by more than their own deviations explain.
    pub sigma_m: f64,
    /// Sighting with the surest height; `None` without a height.
    pub source: Option<HeightSource>,
    /// Number of sightings in the mean.
    pub counted: usize,
    /// Number of sightings whose height contradicts the surest one. They are not in the mean.
    pub contradicting: usize,
}

/// The sighting with the surest height of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeightSource {
    /// Index of the sighting among those of the object.
    pub sighting: usize,
    /// True if an analyst has set the edges of the box or measured the shadow.
    pub is_by_hand: bool,
    /// Index of the ping on which the shadow was measured, or of the first ping of the box.
    pub ping: usize,
    /// Side of the sighting.
    pub side: Side,
}

impl ObjectHeight {
    /// An unknown height.
    const UNKNOWN: Self =
        Self { mean_m: f64::NAN, sigma_m: f64::NAN, source: None, counted: 0, contradicting: 0 };

    /// Returns the source in words: `shadow, ping 895 port of lake-1; 1 sighting contradicts it`;
    /// empty without a height. `log` is the name of the log of the sighting, if the survey has
    /// several logs.
    pub fn source_in_words(&self, log: Option<&str>) -> String {
        let Some(HeightSource { is_by_hand, ping, side, .. }) = self.source else {
            return String::new();
        };
        let how = if is_by_hand { "by hand" } else { "shadow" };
        let of_log = log.map_or_else(String::new, |log| format!(" of {log}"));
        let contradicted = match self.contradicting {
            0 => String::new(),
            1 => "; 1 sighting contradicts it".to_owned(),
            count => format!("; {count} sightings contradict it"),
        };
        format!("{how}, ping {ping} {}{of_log}{contradicted}", side.name())
    }

    /// Computes the height of an object from its sightings.
    ///
    /// If an analyst has set the edges or measured the shadow of a sighting, only such sightings
    /// count. Sightings that contradict the surest one are left out rather than averaged: a
    /// sighting that shows only part of the shadow has a wrong height with a small deviation.
    pub fn of<'a>(targets: impl Iterator<Item = &'a Target>) -> Self {
        let is_known =
            |target: &Target| target.height_m.is_finite() && !target.height_sigma_m.is_nan();
        let known = targets.enumerate().filter(|(_, target)| is_known(target));
        let (set, found): (Vec<_>, Vec<_>) = known.partition(|(_, target)| is_by_hand(target));
        let candidates = if set.is_empty() { found } else { set };
        let Some((sighting, surest)) = surest(&candidates) else {
            return Self::UNKNOWN;
        };
        let agrees = |target: &&Target| {
            let apart_m = (target.height_m - surest.height_m).abs();
            apart_m <= AGREE_SIGMAS * sigma_m(target).hypot(sigma_m(surest))
        };
        let counted: Vec<&Target> =
            candidates.iter().map(|(_, target)| *target).filter(agrees).collect();
        let [mean_m, sigma_m] = mean(&counted);
        // The mean is tested, not each height: without the small heights, the mean would be too
        // large.
        if mean_m <= LEAST_SIGMAS * sigma_m && !is_by_hand(surest) {
            return Self::UNKNOWN;
        }
        Self {
            mean_m,
            sigma_m,
            source: Some(HeightSource {
                sighting,
                is_by_hand: is_by_hand(surest),
                ping: surest.measured_shadow.map_or(surest.mark.pings.start, |shadow| shadow.ping),
                side: surest.mark.side,
            }),
            counted: counted.len(),
            contradicting: candidates.len() - counted.len(),
        }
    }
}

fn is_by_hand(target: &Target) -> bool {
    target.measured_shadow.is_some() || matches!(target.extent, ObjectExtent::Drawn { .. })
}

fn sigma_m(target: &Target) -> f64 {
    target.height_sigma_m.max(LEAST_SIGMA_M)
}

/// Returns the sighting whose height is the largest multiple of its standard deviation. The
/// smallest deviation alone is no measure: the ends of a short piece of shadow are as sharp as
/// those of a whole one.
fn surest<'a>(targets: &[(usize, &'a Target)]) -> Option<(usize, &'a Target)> {
    let ratio = |target: &Target| target.height_m / sigma_m(target);
    targets.iter().copied().max_by(|(_, a), (_, b)| ratio(a).total_cmp(&ratio(b)))
}

/// Returns the weighted mean of some heights and its standard deviation, metres.
fn mean(targets: &[&Target]) -> [f64; 2] {
    let weight = |target: &Target| sigma_m(target).powi(-2);
    let weights: f64 = targets.iter().map(|target| weight(target)).sum();
    let sum: f64 = targets.iter().map(|target| weight(target) * target.height_m).sum();
    let mean_m = sum / weights;
    let squares = |target: &&Target| weight(target) * (target.height_m - mean_m).powi(2);
    let excess = match targets.len() {
        0 | 1 => 1.0,
        count => (targets.iter().map(squares).sum::<f64>() / (count - 1) as f64).sqrt().max(1.0),
    };
    [mean_m, excess * weights.sqrt().recip()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::target;

    fn seen(height_m: f64, height_sigma_m: f64) -> Target {
        Target { height_m, height_sigma_m, ..target() }
    }

    fn height(targets: &[Target]) -> ObjectHeight {
        ObjectHeight::of(targets.iter())
    }

    #[test]
    fn heights_that_agree_are_averaged_by_their_variances() {
        let both = height(&[seen(0.2, 0.2), seen(0.5, 0.1)]);
        assert!((both.mean_m - (4.0 * 0.5 + 0.2) / 5.0).abs() < 1e-9);
        // The heights differ by 0.3 m, where 0.22 m is usual: the mean is 1.34 times as uncertain
        // as both deviations state.
        let squares = (0.3_f64).powi(2) / (0.1_f64.powi(2) + 0.2_f64.powi(2));
        assert!((both.sigma_m - (squares / 125.0).sqrt()).abs() < 1e-9);
        assert_eq!((both.counted, both.contradicting), (2, 0));
    }

    #[test]
    fn a_part_of_a_shadow_does_not_outweigh_a_whole_one() {
        // The rock of `pond.py --seed 11 --lines 4`, ping 895 port; its true height is 0.65 m.
        let both = height(&[seen(0.075, 0.025), seen(0.57, 0.08)]);
        assert_eq!((both.mean_m, both.counted, both.contradicting), (0.57, 1, 1));
        assert_eq!(both.source_in_words(None), "shadow, ping 100 port; 1 sighting contradicts it");
    }

    #[test]
    fn a_height_no_larger_than_its_deviation_is_not_stated() {
        assert_eq!(height(&[seen(1.0, 2.01)]).source, None);
        let other = height(&[seen(0.1, 0.2), seen(0.5, 0.1)]);
        assert_eq!(other.counted, 2, "{other:?}");
    }

    #[test]
    fn a_height_that_an_analyst_measured_counts_alone() {
        let mut targets = [seen(0.5, 0.45), seen(1.3, 0.1)];
        assert_eq!(height(&targets[..1]).mean_m, 0.5);
        assert!((height(&targets[..1]).sigma_m - 0.45).abs() < 1e-9);
        let both = height(&targets);
        assert!((1.22..1.3).contains(&both.mean_m) && (0.09..0.25).contains(&both.sigma_m));
        targets[0].extent = ObjectExtent::Drawn { border_m: 1.5 };
        let [both, first] = [&targets[..], &targets[..1]].map(height);
        assert_eq!((both.mean_m, both.sigma_m), (first.mean_m, first.sigma_m));
        assert_eq!((both.source, both.counted), (first.source, first.counted));
        assert_eq!(both.contradicting, 0);
        let said = height(&targets).source_in_words(Some("lake-1"));
        assert_eq!(said, "by hand, ping 100 port of lake-1");
        // A height by hand counts at any uncertainty.
        targets[0] = Target { height_sigma_m: 1.05, ..targets[0].clone() };
        assert!((height(&targets[..1]).sigma_m - 1.05).abs() < 1e-9);
        let unknown = height(&[target()]);
        assert!(unknown.mean_m.is_nan() && unknown.sigma_m.is_nan());
        assert_eq!((unknown.source, unknown.source_in_words(None).as_str()), (None, ""));
    }
}
