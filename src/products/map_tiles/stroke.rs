//! Lines on a picture with smooth edges.

use super::TILE_PIXELS;

/// Width, colour and opacity of lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct TilePen {
    /// Pixels.
    pub width: f64,
    /// Red, green, blue.
    pub rgb: [u8; 3],
    /// 0 to 1.
    pub opacity: f64,
}

/// Draws lines, given in pixels of the tile, over its picture (red, green, blue, opacity). Where
/// lines meet nothing is drawn twice.
pub(super) fn stroke<'a>(
    picture: &mut [u8],
    lines: impl Iterator<Item = &'a [[f64; 2]]>,
    pen: TilePen,
) {
    let mut covered = vec![0.0_f64; TILE_PIXELS * TILE_PIXELS];
    for line in lines {
        for step in line.windows(2) {
            cover(&mut covered, [step[0], step[1]], 0.5 * pen.width);
        }
    }
    for (pixel, covered) in picture.chunks_exact_mut(4).zip(covered) {
        blend(pixel, pen.rgb, pen.opacity * covered);
    }
}

/// Marks how much of each pixel a step covers.
fn cover(covered: &mut [f64], [from, to]: [[f64; 2]; 2], half_width: f64) {
    let reach = half_width + 1.0;
    let span = |axis: usize| {
        let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
        let first = (low - reach).floor().max(0.0) as usize;
        let end = (high + reach).ceil().clamp(0.0, TILE_PIXELS as f64) as usize;
        first..end
    };
    for row in span(1) {
        for column in span(0) {
            let middle = [column as f64 + 0.5, row as f64 + 0.5];
            let share = (half_width + 0.5 - distance(middle, from, to)).clamp(0.0, 1.0);
            let pixel = &mut covered[row * TILE_PIXELS + column];
            *pixel = pixel.max(share);
        }
    }
}

fn distance(at: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length2 = way[0] * way[0] + way[1] * way[1];
    let along = (at[0] - from[0]) * way[0] + (at[1] - from[1]) * way[1];
    let share = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
    let away = [0, 1].map(|axis| at[axis] - from[axis] - share * way[axis]);
    (away[0] * away[0] + away[1] * away[1]).sqrt()
}

/// A colour over what is there, which may be clear.
fn blend(pixel: &mut [u8], rgb: [u8; 3], opacity: f64) {
    if opacity <= 0.0 {
        return;
    }
    let below = f64::from(pixel[3]) / 255.0 * (1.0 - opacity);
    let all = opacity + below;
    for (part, colour) in pixel.iter_mut().zip(rgb) {
        let mixed = (f64::from(colour) * opacity + f64::from(*part) * below) / all;
        *part = mixed.round() as u8;
    }
    pixel[3] = (255.0 * all).round() as u8;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_covers_its_pixels_once_and_shows_on_a_clear_picture() {
        let mut picture = vec![0; 4 * TILE_PIXELS * TILE_PIXELS];
        let pen = TilePen { width: 2.0, rgb: [200, 100, 0], opacity: 0.5 };
        let lines = [[[10.0, 20.0], [40.0, 20.0]], [[40.0, 20.0], [10.0, 20.0]]];
        stroke(&mut picture, lines.iter().map(<[[f64; 2]; 2]>::as_slice), pen);
        let at = |column: usize, row: usize| &picture[4 * (row * TILE_PIXELS + column)..][..4];
        assert_eq!(at(20, 19), [200, 100, 0, 128]);
        assert_eq!(at(20, 20), [200, 100, 0, 128]);
        assert_eq!(at(20, 22), [0; 4]);
        assert_eq!(at(50, 20), [0; 4]);
        let mut full = [0, 0, 0, 255];
        blend(&mut full, [200, 100, 0], 0.5);
        assert_eq!(full, [100, 50, 0, 255]);
    }
}
