//! Colours of differences: blue below zero, red above, light grey where there is none.

use super::{Rgb, ramp};
use crate::presentation::ticks;

/// Moreland's "cool to warm" (2009) at every sixteenth of the way, as sRGB: even to the eye, safe
/// for the colour-blind, and its middle is neither that of a dark canvas nor that of a light one.
const COOL_TO_WARM: [Rgb; 17] = [
    [59, 76, 192],
    [77, 104, 215],
    [98, 130, 234],
    [119, 154, 247],
    [141, 176, 254],
    [163, 194, 255],
    [184, 208, 249],
    [204, 217, 238],
    [221, 221, 221],
    [236, 211, 197],
    [245, 196, 173],
    [247, 177, 148],
    [244, 154, 123],
    [236, 127, 99],
    [222, 96, 77],
    [203, 62, 56],
    [180, 4, 38],
];

/// The least end of a scale, metres.
const LEAST_M: f64 = 0.01;

/// sRGB colour of a share of a scale that is symmetric about zero, 0 (lowest) to 1 (highest).
pub fn difference_colour(share: f32) -> Rgb {
    ramp(&COOL_TO_WARM, share)
}

/// A round end of a scale that reaches as far as a difference does, a centimetre at least, metres.
pub fn difference_reach_m(difference_m: f64) -> f64 {
    let needed_m = difference_m.abs();
    if !(needed_m.is_finite() && needed_m > LEAST_M) {
        return LEAST_M;
    }
    ticks::scale_end(needed_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// matplotlib.colormaps["coolwarm"](share, bytes=True), 3.11: of a table of 256, which cuts
    /// halves off.
    const GOLDEN: [(f32, [u8; 3]); 9] = [
        (0.0, [58, 76, 192]),
        (0.1, [88, 118, 226]),
        (0.3, [157, 189, 254]),
        (0.45, [207, 217, 234]),
        (0.5, [221, 220, 219]),
        (0.55, [232, 213, 202]),
        (0.7, [246, 171, 141]),
        (0.9, [214, 82, 67]),
        (1.0, [179, 3, 38]),
    ];

    #[test]
    fn colours_are_those_of_matplotlib_s_coolwarm() {
        for (share, expected) in GOLDEN {
            for (got, want) in difference_colour(share).into_iter().zip(expected) {
                assert!(got.abs_diff(want) <= 2, "{share}: {got} {want}");
            }
        }
    }

    #[test]
    fn a_scale_ends_at_a_round_number_just_beyond_what_it_holds() {
        for (difference_m, reach_m) in [
            (0.0, 0.01),
            (f64::NAN, 0.01),
            (0.0821, 0.1),
            (-0.212, 0.25),
            (0.3, 0.3),
            (0.61, 0.8),
            (1.2, 1.5),
            (9.0, 10.0),
            (37.0, 40.0),
        ] {
            let found_m = difference_reach_m(difference_m);
            assert!((found_m - reach_m).abs() < 1e-12, "{difference_m}: {found_m}");
        }
    }
}
