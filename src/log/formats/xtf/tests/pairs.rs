//! Tests that side-scan of two frequencies is read as two pairs.

use super::*;

/// Returns a file of two frequencies, which have different ranges.
pub(super) fn two_frequencies() -> Xtf {
    Xtf {
        channels: vec![(1, 100.0), (2, 100.0), (1, 400.0), (2, 400.0)],
        side: |_, side| side.slant_range_m = if side.channel < 2 { 100.0 } else { 50.0 },
        ping: |index, ping| {
            (ping.sensor_x, ping.sensor_y) = (START.lon_deg, latitude(index));
            ping.sensor_altitude_m = 7.5;
        },
        ..Xtf::default()
    }
}

#[test]
fn one_of_two_frequencies_is_shown_and_the_other_can_be_chosen() {
    let survey = read(&two_frequencies());
    let far_m = |survey: &Survey| survey.side_scan[9].starboard.map(|span| span.far_m);
    assert_eq!(far_m(&survey), Some(100.0));
    assert_eq!(survey.channels.len(), 4);
    let summary = "100 kHz, 0 is shown; set source.frequency_khz to show 400 kHz, 2";
    assert!(says(&survey, summary), "{:?}", survey.warnings);
    let high = survey.clone().with_frequency(380.0);
    assert_eq!(far_m(&high), Some(50.0));
    assert_eq!(high.side_scan[9].depth_m, 7.5);
    assert!(says(&high, "400 kHz, 2 is shown; set source.frequency_khz to show 100 kHz, 0"));
    assert_eq!(survey.clone().with_frequency(120.0).side_scan, survey.side_scan);
    // A file with one pair has nothing to choose from.
    let single = read(&Xtf::default());
    assert!(single.pairs.is_empty() && !says(&single, "source.frequency_khz"));
    assert_eq!(far_m(&single.with_frequency(400.0)), Some(25.0));
}
