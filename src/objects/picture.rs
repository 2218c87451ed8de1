//! A picture that a detector searches.

/// Echo levels, or a picture of another program in grey or colour.
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

impl Picture {
    /// A grey picture.
    pub fn grey(width: usize, height: usize, levels: Vec<u8>) -> Self {
        Self { width, height, channels: 1, levels }
    }

    /// The level of a pixel in red, green or blue (0 to 2). Beyond the edge it is that of the
    /// nearest pixel inside; 0 where the picture is empty.
    pub fn level(&self, x: usize, y: usize, colour: usize) -> u8 {
        let x = x.min(self.width.saturating_sub(1));
        let y = y.min(self.height.saturating_sub(1));
        let channel = if self.channels == 1 { 0 } else { colour };
        let index = (y * self.width + x) * self.channels + channel;
        self.levels.get(index).copied().unwrap_or(0)
    }

    /// Brightness as the eye weighs the colours (ITU-R BT.601).
    pub fn brightness(&self, x: usize, y: usize) -> f32 {
        if self.channels == 1 {
            return f32::from(self.level(x, y, 0));
        }
        let [red, green, blue] = [0, 1, 2].map(|colour| f32::from(self.level(x, y, colour)));
        0.299 * red + 0.587 * green + 0.114 * blue
    }

    /// The picture without its colours.
    pub(crate) fn to_grey(&self) -> Picture {
        if self.channels == 1 {
            return self.clone();
        }
        let pixels = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        let levels = pixels.map(|(x, y)| self.brightness(x, y).round() as u8);
        Picture::grey(self.width, self.height, levels.collect())
    }

    /// The picture with its rows in turned order: as a boat that comes from the other end records
    /// it.
    pub fn mirrored(&self) -> Picture {
        let row = (self.width * self.channels).max(1);
        Picture { levels: self.levels.rchunks(row).flatten().copied().collect(), ..*self }
    }

    /// A piece of the picture; what lies beyond its edge is 0.
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
