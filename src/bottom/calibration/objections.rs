//! Lists objections to a stretch as the place of a calibration, in sentences.

use super::FlatSpot;
use bathyscope_log::survey::{Side, Survey};

/// Length below which a stretch is short, metres: it is based on a handful of soundings.
const SHORT_M: f64 = 5.0;
/// Slope along the track above which a bottom is not level, metres a metre.
const SLOPING: f64 = 0.03;
/// Relief above which the scale mixes several depths, as a share of the depth.
const UNEVEN: f64 = 0.15;
/// Share of the pings at which the recorder had lost the bottom, above which there is an objection.
const LOST: f64 = 0.1;
/// A spread counts as larger than that of the best stretch when it is this many times as large, and
/// above this share of the scale.
const WIDER: f64 = 1.5;
const WIDE: f64 = 0.01;
/// Share of the scale above which a spread is large without comparison: at 2 m of depth it is 6 cm.
pub(super) const VERY_WIDE: f64 = 0.03;

impl FlatSpot {
    /// Returns the reasons why the stretch is a worse place for a calibration than `best`, or no
    /// place at all; empty where there is no objection.
    pub fn objections(&self, survey: &Survey, best: Option<&FlatSpot>) -> Vec<String> {
        if self.depth_m.is_nan() {
            return vec![
                "The log has no recorded depth over these pings, so they give no scale.".to_owned(),
            ];
        }
        let pings = self.pings.len();
        if self.lost >= pings {
            return vec![
                "The recorder had lost the bottom over all of these pings, so they give no scale."
                    .to_owned(),
            ];
        }
        let mut found = Vec::new();
        if self.lost as f64 > LOST * pings as f64 {
            found.push(format!(
                "The recorder had lost the bottom at {} of {pings} pings.",
                self.lost
            ));
        }
        found.extend(self.few_returns(survey));
        if self.length_m < SHORT_M {
            found.push(format!("The stretch is short: {:.1} m along the track.", self.length_m));
        }
        if self.slope.abs() > SLOPING {
            found.push(format!(
                "The bottom slopes by {:.1} % along the track.",
                100.0 * self.slope.abs()
            ));
        }
        if self.is_tilted() {
            found.push(format!(
                "The bottom slopes across the track: the sides differ by {:.1} %.",
                100.0 * self.tilt
            ));
        }
        if self.relief_m > UNEVEN * self.depth_m {
            found.push(format!("The recorded depth varies by {:.0} cm.", 100.0 * self.relief_m));
        }
        found.extend(self.wide_spread(best));
        found
    }

    /// Returns a sentence where more than half the pings give no usable first return on a side that
    /// was recorded.
    pub(super) fn few_returns(&self, survey: &Survey) -> Option<String> {
        let recorded = survey.side_scan.get(self.pings.start)?;
        let poorer = Side::BOTH
            .into_iter()
            .zip(self.picks)
            .filter(|(side, _)| recorded.side(*side).is_some())
            .min_by_key(|(_, picks)| *picks);
        let (side, picks) = poorer.filter(|(_, picks)| 2 * picks < self.pings.len())?;
        Some(format!(
            "Only {picks} of {} pings have a usable first return to {}.",
            self.pings.len(),
            side.name(),
        ))
    }

    /// Returns a sentence where the scales of single pings scatter by much, by themselves or
    /// compared with those of the best stretch.
    fn wide_spread(&self, best: Option<&FlatSpot>) -> Option<String> {
        let spread = self.spread()?;
        let percent = 100.0 * spread;
        let best = best.filter(|best| best.pings != self.pings);
        let of_best = best.and_then(FlatSpot::spread);
        match of_best.filter(|best| spread > WIDE.max(WIDER * best)) {
            Some(best) => Some(format!(
                "Pings scatter by {percent:.1} %, by {:.1} % on the best stretch.",
                100.0 * best
            )),
            None => (spread > VERY_WIDE).then(|| format!("Pings scatter by {percent:.1} %.")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::Scale;

    /// A stretch of 100 pings on which nothing is wrong.
    fn good() -> FlatSpot {
        FlatSpot {
            pings: 400..500,
            length_m: 10.0,
            depth_m: 2.0,
            relief_m: 0.1,
            lost: 0,
            slope: 0.004,
            scatter_m: 0.01,
            picks: [98, 99],
            tilt: 0.001,
            ppd: Some(Scale { px_per_m: 50.0, spread_px_per_m: 0.4, picks: 197 }),
            factor: Some(1.003),
        }
    }

    #[test]
    fn a_worse_stretch_says_why_and_a_good_one_says_nothing() {
        let survey = Survey::default();
        let of = |change: fn(&mut FlatSpot)| {
            let mut spot = FlatSpot { pings: 900..1000, ..good() };
            change(&mut spot);
            spot.objections(&survey, Some(&good())).join(" ")
        };
        assert_eq!(of(|_| ()), "");
        assert!(of(|spot| spot.length_m = 3.2).contains("short: 3.2 m"));
        assert!(of(|spot| spot.slope = -0.06).contains("slopes by 6.0 %"));
        assert!(of(|spot| spot.tilt = 0.02).contains("differ by 2.0 %"));
        assert!(of(|spot| spot.relief_m = 0.5).contains("varies by 50 cm"));
        assert!(of(|spot| spot.lost = 40).contains("lost the bottom at 40 of 100"));
        let lost = of(|spot| {
            spot.lost = 100;
            spot.ppd = None;
        });
        assert!(lost.contains("lost the bottom over all"), "{lost}");
        let none = of(|spot| spot.depth_m = f64::NAN);
        assert!(none.contains("no recorded depth"), "{none}");
    }

    #[test]
    fn a_larger_spread_never_takes_an_objection_back() {
        let survey = Survey::default();
        let best = good();
        let mut last = 0;
        for spread_px_per_m in [0.4, 0.7, 1.6, 4.29, 20.0] {
            let spot = FlatSpot {
                pings: 0..100,
                ppd: best.ppd.map(|ppd| Scale { spread_px_per_m, ..ppd }),
                ..good()
            };
            for best in [Some(&best), None] {
                let found = spot.objections(&survey, best).len();
                assert!(best.is_none() || found >= last, "{spread_px_per_m}");
                last = if best.is_some() { found } else { last };
                assert_eq!(found > 0, spread_px_per_m > if best.is_some() { 0.6 } else { 1.5 });
            }
        }
    }
}
