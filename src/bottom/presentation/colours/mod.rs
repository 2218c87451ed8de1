//! Tables of colours: of depths, of echoes, of differences, and of what else a raster holds.
//!
//! In: a value and the ends of its scale. Out: a colour.

mod depth;
mod difference;
mod echo;

pub use depth::{depth_colour, depth_share, lit_depth_colour};
pub use difference::{difference_colour, difference_reach_m};
use echo::VIRIDIS;
pub use echo::{EchoPalette, copper, gold, grey, inverse_grey, palette, viridis};

/// Red, green and blue, sRGB.
pub type Rgb = [u8; 3];

/// ColorBrewer's `YlOrRd` in five classes (Brewer 2002).
const YELLOW_TO_RED: [Rgb; 5] =
    [[255, 255, 178], [254, 204, 92], [253, 141, 60], [240, 59, 32], [189, 0, 38]];
/// ColorBrewer's `Purples` in five classes.
const PURPLES: [Rgb; 5] =
    [[242, 240, 247], [203, 201, 226], [158, 154, 200], [117, 107, 177], [84, 39, 143]];

/// Colour of a share of a scale of uncertainty, 0 (lowest) to 1 (highest).
pub fn uncertainty_colour(share: f32) -> Rgb {
    ramp(&YELLOW_TO_RED, share)
}

/// Colour of a share of a scale of distance, 0 (near) to 1 (far).
pub fn distance_colour(share: f32) -> Rgb {
    ramp(&PURPLES, share)
}

/// Colours of the sources of a depth: a sounding, a first return, nothing but its neighbours.
pub const SOURCES: [Rgb; 4] = [[0, 90, 160], [230, 130, 0], [170, 130, 200], [205, 205, 200]];

/// Colour of a share of a scale of anything that a point has, 0 (lowest) to 1 (highest):
/// perceptually even.
pub fn share_colour(share: f32) -> Rgb {
    ramp(VIRIDIS, share)
}

/// Colour of a value of a scale with these ends; grey where there is no value, or no scale.
pub fn value_colour(value: f32, ends: Option<[f32; 2]>) -> Rgb {
    const NONE: Rgb = [128; 3];
    let Some([low, high]) = ends.filter(|_| value.is_finite()) else {
        return NONE;
    };
    let share = if high > low { (value - low) / (high - low) } else { 0.5 };
    share_colour(share)
}

/// The colour at a share, 0 to 1, of the way through colours at even distances, linear between
/// them. There are two colours at least.
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
}
