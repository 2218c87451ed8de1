//! Tables of 256 colours, dark to bright, in gamma space.

/// Red, green and blue of the echo strengths 0 to 255.
pub type Palette = [[u8; 3]; 256];

/// Colours at even distances, between which the table is interpolated.
type Stops = &'static [[u8; 3]];

const GREY: Stops = &[[0, 0, 0], [255, 255, 255]];
const INVERSE_GREY: Stops = &[[255, 255, 255], [0, 0, 0]];
/// Black over brown to pale yellow, as side-scan towfish programs show it.
const GOLD: Stops = &[
    [0, 0, 0],
    [58, 34, 4],
    [120, 76, 8],
    [184, 126, 18],
    [232, 184, 56],
    [255, 236, 150],
];
/// Matplotlib's `viridis` at every 32nd entry: even steps to the eye, safe for the colour-blind.
const VIRIDIS: Stops = &[
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

/// Black to copper, the classic of fish-finders: red saturates at 81 % (Matlab's and Matplotlib's `copper`).
pub fn copper() -> Palette {
    const SLOPES: [f32; 3] = [1.2346, 0.7812, 0.4975];
    std::array::from_fn(|index| SLOPES.map(|slope| (slope * index as f32).round().min(255.0) as u8))
}

/// Black to white.
pub fn grey() -> Palette {
    interpolate(GREY)
}

/// White to black.
pub fn inverse_grey() -> Palette {
    interpolate(INVERSE_GREY)
}

/// Black over brown to yellow.
pub fn gold() -> Palette {
    interpolate(GOLD)
}

/// Perceptually even.
pub fn viridis() -> Palette {
    interpolate(VIRIDIS)
}

fn interpolate(stops: Stops) -> Palette {
    std::array::from_fn(|index| {
        let place = index as f32 / 255.0 * (stops.len() - 1) as f32;
        let below = (place as usize).min(stops.len() - 2);
        let share = place - below as f32;
        std::array::from_fn(|channel| {
            let [from, to] = [stops[below][channel], stops[below + 1][channel]].map(f32::from);
            (from + (to - from) * share).round() as u8
        })
    })
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
            ("copper", copper()),
            ("grey", grey()),
            ("gold", gold()),
            ("viridis", viridis()),
        ] {
            let rises = palette
                .windows(2)
                .all(|two| luminance(two[1]) + 0.8 >= luminance(two[0]));
            assert!(
                rises && luminance(palette[255]) > luminance(palette[0]) + 100.0,
                "{name}"
            );
        }
        let mut inverse = inverse_grey();
        inverse.reverse();
        assert_eq!(inverse, grey());
    }

    #[test]
    fn copper_is_that_of_matplotlib() {
        // matplotlib.colormaps["copper"](index, bytes=True), 3.8.
        let copper = copper();
        for (index, colour) in [
            (0, [0, 0, 0]),
            (64, [79, 50, 32]),
            (128, [158, 100, 64]),
            (255, [255, 199, 127]),
        ] {
            for (got, want) in copper[index].into_iter().zip(colour) {
                assert!(got.abs_diff(want) <= 1, "{index}: {:?}", copper[index]);
            }
        }
        assert_eq!(copper[206][0], 254);
        assert_eq!(copper[207][0], 255);
    }
}
