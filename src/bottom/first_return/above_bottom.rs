//! Flags the picks that lie above the bottom that the recorder reported.
//!
//! Boulders and banks are flagged with weed and fish. The echo does not distinguish them: on
//! simulated ponds it grows behind weed and fades behind boulders (level 0.1 to 0.4 m behind the
//! recorded depth against that of the first 0.1 m behind the pick), but over the boulders of the
//! river of the tests it grows by 8 to 90 bytes, as behind weed, and neither the edge nor the
//! plateau behind it differs more between the two than along either. What lies above the bottom for
//! long is recognised by its length along the track ([`crate::cloud::CloudPoint::above_bottom_m`]).

/// Returns true if a pick is nearer than the depth by more than `margin_m`, by the recorder's own
/// scale.
pub(super) fn is_above(range_m: f32, depth_m: f32, margin_m: f64) -> bool {
    // Comparisons with NaN are false: without a depth or a pick nothing is flagged.
    f64::from(range_m) < f64::from(depth_m) - margin_m
}
