//! The real river through the whole pipeline: three containers of one recording must give one
//! cloud.

use crate::truth::processed;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::pipeline::Products;

/// Calibrated range of the first return, per ping; NaN without one.
fn ranges(survey: &Survey, products: &Products, side: Side) -> Vec<f64> {
    let picks = products.returns.side(side).iter().enumerate();
    picks
        .map(|(ping, pick)| products.calibration.pick_range_m(survey, ping, side, pick.sample))
        .collect()
}

fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share) as usize]
}

#[test]
fn the_transcoded_logs_give_the_recorded_cloud() {
    let Some(data) = bathyscope_test_support::real_data() else {
        return;
    };
    let (survey, products) = processed(&data.join("humminbird-glen-canyon/Rec00001.DAT"));
    assert_eq!(survey.side_scan.len(), 3453);
    for name in ["glencanyon-transcoded.sl2", "glencanyon-transcoded.sl3"] {
        let (other, others) = processed(&data.join("lowrance").join(name));
        assert_eq!(other.side_scan.len(), 3453, "{name}");
        assert_eq!(other.soundings.len(), survey.soundings.len(), "{name}");
        for side in Side::BOTH {
            let pairs = ranges(&survey, &products, side);
            let pairs = pairs.into_iter().zip(ranges(&other, &others, side));
            let mut apart: Vec<f64> =
                pairs.map(|(a, b)| (a - b).abs()).filter(|apart| apart.is_finite()).collect();
            assert!(apart.len() > 3400, "{name} {side:?}: {} pings in both", apart.len());
            // The transcoding resampled 1479 to 1550 samples of 1.9 cm to 1400 of 2.0 cm: half a
            // sample is its limit.
            let (median, p95) = (quantile(&mut apart, 0.5), quantile(&mut apart, 0.95));
            eprintln!("{name} {side:?}: median {median:.3} m, p95 {p95:.3} m apart");
            assert!(median < 0.02, "{name} {side:?}: median {median} m apart");
            assert!(p95 < 0.25, "{name} {side:?}: p95 {p95} m apart");
        }
    }
}

/// Range of the deeper side minus recorded depth over some pings, sorted: on a slope the upper side
/// detects the bank first, and the recorder's own depth is that of the water under the boat.
fn deeper_side_minus_depth(
    survey: &Survey,
    products: &Products,
    pings: std::ops::Range<usize>,
) -> Vec<f64> {
    let [port, starboard] = Side::BOTH.map(|side| ranges(survey, products, side));
    let mut apart: Vec<f64> = pings
        .map(|ping| port[ping].max(starboard[ping]) - f64::from(survey.good_depth_m(ping)))
        .filter(|apart| apart.is_finite())
        .collect();
    apart.sort_by(f64::total_cmp);
    apart
}

#[test]
fn the_line_agrees_with_the_recorded_depth() {
    let Some(data) = bathyscope_test_support::real_data() else {
        return;
    };
    let (survey, products) = processed(&data.join("humminbird-glen-canyon/Rec00001.DAT"));
    // The whole log as far as the recorder had the bottom: boulders as tall as the boat is far from
    // them.
    let mut all = deeper_side_minus_depth(&survey, &products, 0..3453);
    eprintln!("whole log: n {}, median {:+.3} m", all.len(), quantile(&mut all, 0.5));
    assert!(all.len() > 2200, "{} pings", all.len());
    assert!(quantile(&mut all, 0.5).abs() < 0.40, "{}", quantile(&mut all, 0.5));
    // Pings 1910 to 2300: smooth sand between the last boulders, at 1852 to 1902 on both sides, and
    // the place where the recorder loses the bottom. It rounds to 0.1 m.
    let mut sand = deeper_side_minus_depth(&survey, &products, 1910..2300);
    let (low, median, high) =
        (quantile(&mut sand, 0.05), quantile(&mut sand, 0.5), quantile(&mut sand, 0.95));
    eprintln!("sand: n {}, {low:+.3} {median:+.3} {high:+.3} m", sand.len());
    assert!(median.abs() < 0.05 && low > -0.20 && high < 0.20, "{low:+.3} {median:+.3} {high:+.3}");
}
