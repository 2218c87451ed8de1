//! Converts values to colours: depths, echoes, differences, uncertainties and other values of
//! rasters and points.
//!
//! In: a value and the ends of its scale. Out: a colour.

use super::ticks;
use bathyscope_log::named;
use serde::{Deserialize, Serialize};

/// Colour: red, green and blue, sRGB.
pub type Rgb = [u8; 3];

/// Colours of the echo levels 0 to 255.
pub type EchoPalette = [Rgb; 256];

/// ColorBrewer's `YlOrRd` in five classes (Brewer 2002).
const YELLOW_TO_RED: [Rgb; 5] =
    [[255, 255, 178], [254, 204, 92], [253, 141, 60], [240, 59, 32], [189, 0, 38]];
/// ColorBrewer's `Purples` in five classes.
const PURPLES: [Rgb; 5] =
    [[242, 240, 247], [203, 201, 226], [158, 154, 200], [117, 107, 177], [84, 39, 143]];
/// cmocean's `deep` (Thyng et al. 2016) in steps of a tenth from shallow to deep, as sRGB. It ends
/// before the near-black of the original, so that the deepest ground stays visible on a dark
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
/// Black through brown to pale yellow, as programs for towed side-scan sonars show echoes.
const GOLD: &[Rgb] =
    &[[0, 0, 0], [58, 34, 4], [120, 76, 8], [184, 126, 18], [232, 184, 56], [255, 236, 150]];
/// Matplotlib's `viridis` at every 32nd entry: even steps to the eye, safe for the colour-blind.
const VIRIDIS: &[Rgb] = &[
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];
/// Moreland's "cool to warm" (2009) in steps of a sixteenth, as sRGB: even to the eye, safe for the
/// colour-blind, and its middle differs from both a dark and a light canvas.
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
/// Smallest value at which a scale of differences ends, metres.
const LEAST_M: f64 = 0.01;

/// Returns the position of a depth on the colour scale, 0 (shallow) to 1 (deep); 0.5 if the ends of
/// the scale are equal.
pub fn depth_share(depth_m: f32, range_m: [f32; 2]) -> f32 {
    let [shallow_m, deep_m] = range_m;
    if deep_m > shallow_m {
        ((depth_m - shallow_m) / (deep_m - shallow_m)).clamp(0.0, 1.0)
    } else {
        0.5
    }
}

/// Returns the sRGB colour of a share of the scale, 0 (shallow) to 1 (deep); grey for NaN.
///
/// The colours of depth are the same in Bathyscope, on the report's map and in the style of
/// `depth.tif`: shallow light to deep dark, even to the eye.
pub fn depth_colour(share: f32) -> Rgb {
    if share.is_nan() {
        return [128, 128, 128];
    }
    ramp(&DEEP, share)
}

/// Returns the colour of a depth, multiplied by `light`, which is 1 on level ground.
pub fn lit_depth_colour(depth_m: f32, range_m: [f32; 2], light: f32) -> Rgb {
    depth_colour(depth_share(depth_m, range_m))
        .map(|channel| (f32::from(channel) * light).round().min(255.0) as u8)
}

/// Returns the colour of an echo level on a scale from black to copper, as fish-finders show it.
/// Red is at its maximum from 81 % of the levels on (Matplotlib's `copper`).
pub fn copper(level: u8) -> Rgb {
    const SLOPES: [f32; 3] = [1.2346, 0.7812, 0.4975];
    SLOPES.map(|slope| (slope * f32::from(level)).round().min(255.0) as u8)
}

/// Returns the colour of an echo level on a scale from black to white.
pub fn grey(level: u8) -> Rgb {
    [level; 3]
}

/// Colours of echo strength.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ColourMap {
    /// Black to copper, as fish-finders show it.
    #[default]
    Copper,
    /// Black to white.
    Grey,
    /// White to black.
    InverseGrey,
    /// Black through brown to pale yellow.
    Gold,
    /// Perceptually even (viridis).
    Viridis,
}

named! {
    /// All colour maps in the order of the menu.
    pub ColourMap {
        Copper: "copper",
        Grey: "grey",
        InverseGrey: "inverse grey",
        Gold: "gold",
        Viridis: "viridis",
    }
}

impl ColourMap {
    /// Returns the colours of all levels.
    pub fn palette(self) -> EchoPalette {
        let colour: fn(u8) -> Rgb = match self {
            Self::Copper => copper,
            Self::Grey => grey,
            Self::InverseGrey => |level| [255 - level; 3],
            Self::Gold => |level| ramp(GOLD, f32::from(level) / 255.0),
            Self::Viridis => |level| ramp(VIRIDIS, f32::from(level) / 255.0),
        };
        std::array::from_fn(|level| colour(level as u8))
    }

    /// Returns true if the colour of weak echoes is light, so that lines over the picture must be
    /// dark.
    pub fn is_light(self) -> bool {
        luminance(self.palette()[0]) > 127.0
    }
}

fn luminance([r, g, b]: Rgb) -> f32 {
    0.2126 * f32::from(r) + 0.7152 * f32::from(g) + 0.0722 * f32::from(b)
}

/// Returns the sRGB colour of a share of a scale that is symmetric about zero, 0 (lowest) to 1
/// (highest).
///
/// Differences are blue below zero, red above and light grey at zero.
pub fn difference_colour(share: f32) -> Rgb {
    ramp(&COOL_TO_WARM, share)
}

/// Returns a round end of a scale for differences up to `difference_m`, at least a centimetre,
/// metres.
pub fn difference_reach_m(difference_m: f64) -> f64 {
    let needed_m = difference_m.abs();
    if !(needed_m.is_finite() && needed_m > LEAST_M) {
        return LEAST_M;
    }
    ticks::scale_end(needed_m)
}

/// Returns the colour of a share of a scale of uncertainty, 0 (lowest) to 1 (highest).
pub fn uncertainty_colour(share: f32) -> Rgb {
    ramp(&YELLOW_TO_RED, share)
}

/// Returns the colour of a share of a scale of distance, 0 (near) to 1 (far).
pub fn distance_colour(share: f32) -> Rgb {
    ramp(&PURPLES, share)
}

/// Colours of the sources of a depth, in this order: a sounding, a first return, the levels of
/// echoes, interpolation between neighbours.
pub const SOURCES: [Rgb; 4] = [[0, 90, 160], [230, 130, 0], [170, 130, 200], [205, 205, 200]];

/// Returns the colour at `share` of the scale for properties that have no scale of their own, 0
/// (lowest) to 1 (highest): perceptually even.
pub fn share_colour(share: f32) -> Rgb {
    ramp(VIRIDIS, share)
}

/// Returns the colour of a value on a scale with these ends; grey where there is no value, or no
/// scale.
pub fn value_colour(value: f32, ends: Option<[f32; 2]>) -> Rgb {
    match ends.filter(|_| value.is_finite()) {
        Some(ends) => share_colour(depth_share(value, ends)),
        None => [128; 3],
    }
}

/// Returns the colour at a share, 0 to 1, of a scale of at least two evenly spaced colours,
/// interpolated linearly between neighbours.
fn ramp(colours: &[Rgb], share: f32) -> Rgb {
    let position = share.clamp(0.0, 1.0) * (colours.len() - 1) as f32;
    let below = (position as usize).min(colours.len() - 2);
    let part = position - below as f32;
    std::array::from_fn(|channel| {
        let [from, to] = [below, below + 1].map(|index| f32::from(colours[index][channel]));
        (from + part * (to - from)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Colours by Matplotlib 3.11, `matplotlib.colormaps["coolwarm"](share, bytes=True)`, which
    /// takes them from a table of 256 colours and rounds down.
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

    /// Returns the CIE lightness of an sRGB colour.
    fn lightness(colour: [u8; 3]) -> f64 {
        let linear = colour.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
        116.0 * y.cbrt() - 16.0
    }

    #[test]
    fn a_ramp_passes_its_colours_and_stays_within_its_ends() {
        for (index, colour) in PURPLES.into_iter().enumerate() {
            assert_eq!(distance_colour(index as f32 / 4.0), colour);
        }
        assert_eq!(uncertainty_colour(-1.0), YELLOW_TO_RED[0]);
        assert_eq!(uncertainty_colour(7.0), YELLOW_TO_RED[4]);
        let ends = Some([2.0, 6.0]);
        assert_eq!(value_colour(4.0, ends), share_colour(0.5));
        assert_eq!(value_colour(9.0, ends), share_colour(1.0));
        assert_eq!(value_colour(4.0, Some([4.0, 4.0])), share_colour(0.5));
        assert_eq!(value_colour(f32::NAN, ends), value_colour(4.0, None));
        assert_eq!(ramp(&[[0, 0, 0], [255, 255, 255]], 0.5), [128; 3]);
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

    #[test]
    fn stronger_echoes_are_brighter_in_every_map_but_a_light_one() {
        for map in ColourMap::ALL {
            let mut palette = map.palette();
            if map.is_light() {
                palette.reverse();
            }
            let rises = palette.windows(2).all(|two| luminance(two[1]) + 0.8 >= luminance(two[0]));
            let range = luminance(palette[255]) - luminance(palette[0]);
            assert!(rises && range > 100.0, "{}", map.name());
        }
        assert!(ColourMap::InverseGrey.is_light() && !ColourMap::Copper.is_light());
    }

    #[test]
    fn copper_is_that_of_matplotlib() {
        // matplotlib.colormaps["copper"](index, bytes=True), 3.8.
        let copper = ColourMap::Copper.palette();
        for (index, colour) in
            [(0, [0, 0, 0]), (64, [79, 50, 32]), (128, [158, 100, 64]), (255, [255, 199, 127])]
        {
            for (got, want) in copper[index].into_iter().zip(colour) {
                assert!(got.abs_diff(want) <= 1, "{index}: {:?}", copper[index]);
            }
        }
        assert_eq!(copper[206][0], 254);
        assert_eq!(copper[207][0], 255);
    }

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
