//! Defines the pictures that a detector searches and the boxes in their pixels, and scales grey
//! levels.

/// Echo levels, or a picture from another program in grey or colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// 1 (grey) or 3 (red, green, blue).
    pub channels: usize,
    /// Rows of pixels, a pixel's channels side by side: `width * height * channels` levels.
    pub levels: Vec<u8>,
}

/// Level at which the brightest twentieth of a tile begins after scaling.
const BRIGHT_LEVEL: f32 = 180.0;
/// Share of the pixels above 0 that are below [`BRIGHT_LEVEL`] after scaling.
const BRIGHT_SHARE: f64 = 0.95;
/// Least and greatest gain: a tile of noise alone must not be amplified until it looks like echoes.
const GAIN: (f32, f32) = (0.5, 4.0);

impl Picture {
    /// Creates a grey picture.
    pub fn grey(width: usize, height: usize, levels: Vec<u8>) -> Self {
        Self { width, height, channels: 1, levels }
    }

    /// Returns the level of a pixel in red, green or blue (0 to 2). Beyond the edge, the nearest
    /// pixel inside counts; 0 if the picture is empty.
    pub fn level(&self, x: usize, y: usize, colour: usize) -> u8 {
        let x = x.min(self.width.saturating_sub(1));
        let y = y.min(self.height.saturating_sub(1));
        let channel = if self.channels == 1 { 0 } else { colour };
        let index = (y * self.width + x) * self.channels + channel;
        self.levels.get(index).copied().unwrap_or(0)
    }

    /// Returns the brightness of a pixel, with the weights of the eye for the colours (ITU-R
    /// BT.601).
    pub fn brightness(&self, x: usize, y: usize) -> f32 {
        if self.channels == 1 {
            return f32::from(self.level(x, y, 0));
        }
        let [red, green, blue] = [0, 1, 2].map(|colour| f32::from(self.level(x, y, colour)));
        0.299 * red + 0.587 * green + 0.114 * blue
    }

    /// Returns the picture in grey.
    pub(crate) fn to_grey(&self) -> Picture {
        if self.channels == 1 {
            return self.clone();
        }
        let pixels = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        let levels = pixels.map(|(x, y)| self.brightness(x, y).round() as u8);
        Picture::grey(self.width, self.height, levels.collect())
    }

    /// Returns the picture with its rows in reverse order, as a boat that comes from the other end
    /// would record it.
    pub fn mirrored(&self) -> Picture {
        let row = (self.width * self.channels).max(1);
        Picture { levels: self.levels.rchunks(row).flatten().copied().collect(), ..*self }
    }

    /// Returns a piece of the picture; pixels beyond its edge are 0.
    pub fn piece(&self, x: usize, y: usize, width: usize, height: usize) -> Picture {
        let mut levels = vec![0; width * height * self.channels];
        let across = width.min(self.width.saturating_sub(x)) * self.channels;
        let rows = levels.chunks_exact_mut((width * self.channels).max(1));
        for (row, out) in rows.enumerate().take(self.height.saturating_sub(y)) {
            let from = ((y + row) * self.width + x) * self.channels;
            if let Some(inside) = self.levels.get(from..from + across) {
                out[..across].copy_from_slice(inside);
            }
        }
        Picture { width, height, channels: self.channels, levels }
    }
}

/// An axis-parallel box. `x` grows with slant range, `y` along the track; pixel `i` covers `i` to
/// `i + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Near edge.
    pub x0: f32,
    /// First edge along the track.
    pub y0: f32,
    /// Far edge.
    pub x1: f32,
    /// Last edge along the track.
    pub y1: f32,
}

/// A box with a class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Labelled {
    /// Index into the class names.
    pub class: usize,
    /// Edges of the box.
    pub rect: Rect,
}

/// A box that a detector proposes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scored {
    /// Index into the class names.
    pub class: usize,
    /// Score, 0 to 1.
    pub score: f32,
    /// Edges of the box.
    pub rect: Rect,
}

impl Scored {
    /// Creates a box from its class, score and edges.
    pub const fn new(class: usize, score: f32, rect: Rect) -> Self {
        Self { class, score, rect }
    }
}

impl Rect {
    /// Creates a box from the corners with its least and its greatest coordinates.
    pub const fn new([x0, y0]: [f32; 2], [x1, y1]: [f32; 2]) -> Self {
        Self { x0, y0, x1, y1 }
    }

    /// Returns width times height; 0 for a box that is inside out.
    pub fn area(&self) -> f32 {
        (self.x1 - self.x0).max(0.0) * (self.y1 - self.y0).max(0.0)
    }

    /// Returns the intersection of two boxes; inside out (area 0) when they do not meet.
    pub fn intersection(&self, other: &Rect) -> Rect {
        Self::new(
            [self.x0.max(other.x0), self.y0.max(other.y0)],
            [self.x1.min(other.x1), self.y1.min(other.y1)],
        )
    }

    /// Returns the smallest box around both.
    pub(crate) fn hull(&self, other: &Rect) -> Rect {
        Self::new(
            [self.x0.min(other.x0), self.y0.min(other.y0)],
            [self.x1.max(other.x1), self.y1.max(other.y1)],
        )
    }

    /// Returns the intersection over union, 0 to 1; 0 for two boxes without area.
    pub fn iou(&self, other: &Rect) -> f32 {
        let shared = self.intersection(other).area();
        let union = self.area() + other.area() - shared;
        if union > 0.0 { shared / union } else { 0.0 }
    }

    /// Returns the box moved by an offset.
    pub(crate) fn shifted(&self, dx: f32, dy: f32) -> Rect {
        Self::new([self.x0 + dx, self.y0 + dy], [self.x1 + dx, self.y1 + dy])
    }
}

/// Scales a tile's levels in place: the 95th percentile of the pixels above 0 becomes 180, by a
/// gain between 0.5 and 4; levels are limited to 255. Pixels of 0 (beyond the survey, or silence)
/// are not counted and stay 0.
///
/// Recorders differ in gain and curve, so the same rule must be applied to the pictures that a
/// model is trained on and to those that it searches.
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

/// Returns the smallest level above 0 that [`BRIGHT_SHARE`] of the pixels above 0 do not exceed;
/// `None` without such pixels.
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
    fn iou_is_shared_area_over_joint_area() {
        let rect = |x0, y0, x1, y1| Rect { x0, y0, x1, y1 };
        let a = rect(0.0, 0.0, 4.0, 2.0);
        assert_eq!(a.iou(&rect(2.0, 0.0, 6.0, 2.0)), 4.0 / 12.0);
        assert_eq!(a.iou(&a), 1.0);
        assert_eq!(a.iou(&rect(4.0, 0.0, 6.0, 2.0)), 0.0);
        assert_eq!(a.iou(&rect(5.0, 5.0, 4.0, 4.0)), 0.0);
    }

    #[test]
    fn the_95th_percentile_of_the_echo_becomes_180() {
        // The levels 1 to 100 once each, between pixels without an echo: the 95th percentile is 95.
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
