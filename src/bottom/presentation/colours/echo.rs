//! Colours of echo strengths, dark to bright, in gamma space.

use super::{Rgb, ramp};

/// Colours of the echo strengths 0 to 255.
pub type EchoPalette = [Rgb; 256];

/// Black over brown to pale yellow, as side-scan towfish programs show it.
const GOLD: &[Rgb] =
    &[[0, 0, 0], [58, 34, 4], [120, 76, 8], [184, 126, 18], [232, 184, 56], [255, 236, 150]];
/// Matplotlib's `viridis` at every 32nd entry: even steps to the eye, safe for the colour-blind.
pub(super) const VIRIDIS: &[Rgb] = &[
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

/// Black to copper, the classic of fish-finders: red saturates at 81 % (Matplotlib's `copper`).
pub fn copper(level: u8) -> Rgb {
    const SLOPES: [f32; 3] = [1.2346, 0.7812, 0.4975];
    SLOPES.map(|slope| (slope * f32::from(level)).round().min(255.0) as u8)
}

/// Black to white.
pub fn grey(level: u8) -> Rgb {
    [level; 3]
}

/// White to black.
pub fn inverse_grey(level: u8) -> Rgb {
    [255 - level; 3]
}

/// Black over brown to yellow.
pub fn gold(level: u8) -> Rgb {
    ramp(GOLD, share(level))
}

/// Perceptually even.
pub fn viridis(level: u8) -> Rgb {
    ramp(VIRIDIS, share(level))
}

fn share(level: u8) -> f32 {
    f32::from(level) / 255.0
}

/// The colours of all levels.
pub fn palette(colour: fn(u8) -> Rgb) -> EchoPalette {
    std::array::from_fn(|level| colour(level as u8))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance([r, g, b]: [u8; 3]) -> f32 {
        0.2126 * f32::from(r) + 0.7152 * f32::from(g) + 0.0722 * f32::from(b)
    }

    #[test]
    fn stronger_echoes_are_brighter_in_every_map_but_the_inverse() {
        for (name, palette) in [
            ("copper", palette(copper)),
            ("grey", palette(grey)),
            ("gold", palette(gold)),
            ("viridis", palette(viridis)),
        ] {
            let rises = palette.windows(2).all(|two| luminance(two[1]) + 0.8 >= luminance(two[0]));
            assert!(rises && luminance(palette[255]) > luminance(palette[0]) + 100.0, "{name}");
        }
        let mut inverse = palette(inverse_grey);
        inverse.reverse();
        assert_eq!(inverse, palette(grey));
    }

    #[test]
    fn copper_is_that_of_matplotlib() {
        // matplotlib.colormaps["copper"](index, bytes=True), 3.8.
        let copper = palette(copper);
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
}
