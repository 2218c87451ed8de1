//! Colours of depth, the same in Bathyscope, on the report's map and in the style of `depth.tif`:
//! shallow light to deep dark, even to the eye.

use super::{Rgb, ramp};

/// cmocean's `deep` (Thyng et al. 2016) in steps of a tenth of the way from shallow to deep, as
/// sRGB. It ends before the original's near-black, so that the deepest stays visible on a dark
/// canvas.
const DEEP: [Rgb; 11] = [
    [253, 253, 204],
    [206, 236, 179],
    [156, 219, 165],
    [111, 201, 163],
    [86, 177, 163],
    [76, 153, 160],
    [68, 130, 155],
    [62, 108, 150],
    [62, 82, 143],
    [64, 60, 115],
    [54, 43, 77],
];

/// Returns the place of a depth between the ends of the colour scale, 0 (shallow) to 1 (deep).
pub fn depth_share(depth_m: f32, range_m: [f32; 2]) -> f32 {
    let [shallow_m, deep_m] = range_m;
    if deep_m > shallow_m {
        ((depth_m - shallow_m) / (deep_m - shallow_m)).clamp(0.0, 1.0)
    } else {
        0.5
    }
}

/// sRGB colour of a share of the scale, 0 (shallow) to 1 (deep); grey for NaN.
pub fn depth_colour(share: f32) -> Rgb {
    if share.is_nan() {
        return [128, 128, 128];
    }
    ramp(&DEEP, share)
}

/// Colour of a depth under a light that leaves level ground as it is.
pub fn lit_depth_colour(depth_m: f32, range_m: [f32; 2], light: f32) -> Rgb {
    depth_colour(depth_share(depth_m, range_m))
        .map(|channel| (f32::from(channel) * light).round().min(255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness of an sRGB colour.
    fn lightness(colour: [u8; 3]) -> f64 {
        let linear = colour.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
        116.0 * y.cbrt() - 16.0
    }

    #[test]
    fn deeper_is_darker_in_even_steps() {
        let steps: Vec<f64> = (0..=20).map(|i| lightness(depth_colour(i as f32 / 20.0))).collect();
        for pair in steps.windows(2) {
            let fall = pair[0] - pair[1];
            assert!((1.0..8.0).contains(&fall), "{steps:?}");
        }
    }

    #[test]
    fn a_flat_survey_and_a_missing_depth_have_a_colour() {
        assert_eq!(depth_share(3.0, [3.0, 3.0]), 0.5);
        assert_eq!(depth_colour(f32::NAN), [128, 128, 128]);
        assert_eq!(depth_share(-1.0, [0.0, 2.0]), 0.0);
    }
}
