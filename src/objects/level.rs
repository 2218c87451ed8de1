//! Levels of a tile, brought to one scale before a detector sees it.
//!
//! Recorders differ in gain and curve, and the same rule must serve what a model learns from and
//! what it later searches.

/// Level that the brightest twentieth of a tile begins at.
const BRIGHT_LEVEL: f32 = 180.0;
/// Share of the pixels below that level.
const BRIGHT_SHARE: f64 = 0.95;
/// Weakest and strongest gain: a tile of noise alone is not blown up into echoes.
const GAIN: (f32, f32) = (0.5, 4.0);

/// Scales a tile's levels in place: the 95th percentile of the pixels above 0 becomes 180, by a
/// gain between 0.5 and 4; what exceeds 255 is held there. Pixels of 0 (beyond the survey, or
/// silence) count for nothing and stay 0.
pub fn level(pixels: &mut [u8]) {
    let mut counts = [0_usize; 256];
    for &pixel in pixels.iter() {
        counts[usize::from(pixel)] += 1;
    }
    let Some(bright) = percentile(&counts) else {
        return;
    };
    let gain = (BRIGHT_LEVEL / bright).clamp(GAIN.0, GAIN.1);
    let table: Vec<u8> =
        (0..=u8::MAX).map(|pixel| (f32::from(pixel) * gain).round().min(255.0) as u8).collect();
    for pixel in pixels {
        *pixel = table[usize::from(*pixel)];
    }
}

/// The smallest level above 0 that [`BRIGHT_SHARE`] of the pixels above 0 do not exceed; `None`
/// without such pixels.
fn percentile(counts: &[usize; 256]) -> Option<f32> {
    let total: usize = counts[1..].iter().sum();
    let goal = (BRIGHT_SHARE * total as f64).ceil() as usize;
    let mut below = 0;
    let found = counts[1..].iter().position(|&count| {
        below += count;
        below >= goal && below > 0
    });
    found.map(|index| (index + 1) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_95th_percentile_of_the_echo_becomes_180() {
        // 1 to 100 once each, between pixels without an echo: the 95th percentile is 95.
        let mut pixels: Vec<u8> = (1..=100).flat_map(|level| [0, level]).collect();
        level(&mut pixels);
        assert_eq!(pixels[2 * 95 - 1], 180);
        assert_eq!(pixels[2 * 50 - 1], 95);
        assert!(pixels.iter().step_by(2).all(|&pixel| pixel == 0));
    }

    #[test]
    fn gain_is_limited_and_levels_do_not_wrap() {
        let mut faint = vec![3; 100];
        level(&mut faint);
        assert_eq!(faint, [12; 100]);
        let mut mixed = vec![40; 99];
        mixed.push(250);
        level(&mut mixed);
        assert_eq!((mixed[0], mixed[99]), (160, 255));
        let mut silent = vec![0; 10];
        level(&mut silent);
        assert_eq!(silent, [0; 10]);
    }
}
