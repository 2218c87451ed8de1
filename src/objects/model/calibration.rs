//! Maps the confidence that a network gives to the share of such boxes that lie on an object.
//!
//! A network's confidence ranks its boxes; how many of those at 0.8 are right depends on what it
//! was trained on. A sidecar may hold points that map it to the share that was right on chips which
//! training never saw, straight between neighbours.

/// A rising map of confidences, 0 to 1 on both sides. Without points it leaves them as they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ConfidenceCalibration {
    /// The network's confidence and what it comes to, both rising, from `[0, 0]` on.
    points: Vec<[f32; 2]>,
}

impl ConfidenceCalibration {
    /// `None` unless both numbers rise from point to point between 0 and 1, the first being 1 at
    /// the end: only then has each confidence one counterpart.
    pub(super) fn new(points: &[[f32; 2]]) -> Option<Self> {
        let mut all = vec![[0.0, 0.0]];
        all.extend(points.iter().filter(|&&point| point != [0.0, 0.0]));
        let rises = all.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] < pair[1][1]);
        let [last, highest] = all[all.len() - 1];
        (rises && last == 1.0 && highest <= 1.0).then_some(Self { points: all })
    }

    /// Returns the share that a network's confidence is mapped to.
    pub(super) fn calibrated(&self, confidence: f32) -> f32 {
        self.mapped(confidence, [0, 1])
    }

    /// The network's confidence that comes to `calibrated`; above 1 where none does.
    pub(super) fn confidence(&self, calibrated: f32) -> f32 {
        match self.points.last() {
            Some(&[_, highest]) if calibrated > highest => 1.0 + calibrated - highest,
            _ => self.mapped(calibrated, [1, 0]),
        }
    }

    fn mapped(&self, value: f32, [from, to]: [usize; 2]) -> f32 {
        let above = self.points.partition_point(|point| point[from] < value);
        match (above.checked_sub(1), self.points.get(above)) {
            (Some(below), Some(high)) => {
                let low = self.points[below];
                let share = (value - low[from]) / (high[from] - low[from]);
                low[to] + share * (high[to] - low[to])
            }
            // At 0 or below, and above the end.
            (None, Some(first)) => first[to].min(value),
            (Some(below), None) => self.points[below][to],
            (None, None) => value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent() -> ConfidenceCalibration {
        ConfidenceCalibration::new(&[[0.2, 0.1], [0.6, 0.8], [1.0, 0.95]]).expect("a rising map")
    }

    #[test]
    fn confidences_are_mapped_straight_between_points_and_back() {
        let map = bent();
        for (confidence, calibrated) in
            [(0.0, 0.0), (0.1, 0.05), (0.2, 0.1), (0.4, 0.45), (0.8, 0.875), (1.0, 0.95)]
        {
            assert!((map.calibrated(confidence) - calibrated).abs() < 1e-6);
            assert!((map.confidence(calibrated) - confidence).abs() < 1e-6);
        }
        // No box is as sure as that.
        assert!(map.confidence(0.97) > 1.0);
    }

    #[test]
    fn without_points_confidences_stay() {
        for value in [0.0, 0.3, 1.0] {
            let map = ConfidenceCalibration::default();
            assert_eq!([map.calibrated(value), map.confidence(value)], [value; 2]);
        }
    }

    #[test]
    fn what_does_not_rise_to_the_end_is_no_map() {
        let refused: [&[[f32; 2]]; 6] = [
            &[],
            &[[0.5, 0.5]],
            &[[0.5, 0.5], [0.4, 0.6], [1.0, 1.0]],
            &[[0.5, 0.5], [0.7, 0.5], [1.0, 1.0]],
            &[[0.5, 0.5], [1.0, 1.1]],
            &[[0.5, f32::NAN], [1.0, 1.0]],
        ];
        for points in refused {
            assert_eq!(ConfidenceCalibration::new(points), None, "{points:?}");
        }
        assert!(ConfidenceCalibration::new(&[[0.0, 0.0], [1.0, 1.0]]).is_some());
    }
}
