//! Converts a picture to the input numbers of a network, and boxes in the input's pixels back to
//! the picture's pixels.

use super::sidecar::{Colour, Resize};
use crate::{Picture, Rect};

/// Grey level of the bars beside a letterboxed picture, as in the training of Darknet's successors.
const BAR: f32 = 114.0;

/// Size, number format and picture preparation of a network's input.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct InputSpec {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Number of channels, 1 or 3.
    pub channels: usize,
    /// True if the channels of a pixel are stored side by side.
    pub channels_last: bool,
    /// Order of the colours.
    pub colour: Colour,
    /// Factor from levels of 0 to 255.
    pub scale: f32,
    /// Number subtracted from each channel after scaling.
    pub mean: [f32; 3],
    /// Number by which each channel is divided after that.
    pub std: [f32; 3],
    /// Method to bring a picture to the input's size.
    pub resize: Resize,
}

/// Place of a picture in the network's input: `input = picture * scale + offset`, across and down.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct InputFit {
    scale: [f32; 2],
    offset: [f32; 2],
    /// Pixels of the input that the picture covers, across and down.
    covered: [usize; 2],
    picture: [f32; 2],
}

impl InputFit {
    /// Fits a picture of `picture` pixels (across, down) into an input of `input` pixels.
    pub(super) fn new(picture: [usize; 2], input: [usize; 2], resize: Resize) -> Self {
        let size = picture.map(|pixels| pixels.max(1) as f32);
        let ratio = [0, 1].map(|axis| input[axis] as f32 / size[axis]);
        let both = ratio[0].min(ratio[1]);
        let covered = match resize {
            Resize::Stretch => input,
            _ => [0, 1].map(|axis| ((size[axis] * both).round() as usize).clamp(1, input[axis])),
        };
        let offset = match resize {
            // A bar of odd width has its larger part on the right and below, as Ultralytics rounds
            // it.
            Resize::Letterbox => [0, 1].map(|axis| {
                let half = 0.5 * (input[axis] - covered[axis]) as f32;
                (half - 0.1).round().max(0.0)
            }),
            _ => [0.0, 0.0],
        };
        Self {
            scale: [0, 1].map(|axis| covered[axis] as f32 / size[axis]),
            offset,
            covered,
            picture: size,
        }
    }

    /// Converts a box from the input's pixels to the picture's, cut at the picture's edges.
    pub(super) fn to_picture(&self, rect: &Rect) -> Rect {
        let back = |value: f32, axis: usize| {
            ((value - self.offset[axis]) / self.scale[axis]).clamp(0.0, self.picture[axis])
        };
        Rect::new([back(rect.x0, 0), back(rect.y0, 1)], [back(rect.x1, 0), back(rect.y1, 1)])
    }
}

impl InputSpec {
    /// Returns the shape of the input for a batch of one picture, in the network's order.
    pub(super) fn shape(&self) -> [usize; 4] {
        let Self { width, height, channels, .. } = *self;
        if self.channels_last { [1, height, width, channels] } else { [1, channels, height, width] }
    }

    /// Returns the count of numbers of one input.
    pub(super) fn count(&self) -> usize {
        self.width * self.height * self.channels
    }

    /// Returns the place of a picture in the input.
    pub(super) fn fit(&self, picture: &Picture) -> InputFit {
        InputFit::new([picture.width, picture.height], [self.width, self.height], self.resize)
    }

    /// Converts a picture to input numbers; between pixels, levels are interpolated linearly.
    pub(super) fn numbers(&self, picture: &Picture, fit: &InputFit) -> Vec<f32> {
        let mut numbers = vec![0.0; self.count()];
        for channel in 0..self.channels {
            let bar = self.number(BAR, channel);
            let across = places(self.width, fit, 0);
            let down = places(self.height, fit, 1);
            for (y, down) in down.iter().enumerate() {
                for (x, across) in across.iter().enumerate() {
                    let number = match (*across, *down) {
                        (Some(x), Some(y)) => {
                            self.number(self.between(picture, x, y, channel), channel)
                        }
                        _ => bar,
                    };
                    let index = if self.channels_last {
                        (y * self.width + x) * self.channels + channel
                    } else {
                        (channel * self.height + y) * self.width + x
                    };
                    numbers[index] = number;
                }
            }
        }
        numbers
    }

    /// Converts a grey level to the number that the network expects.
    fn number(&self, level: f32, channel: usize) -> f32 {
        (level * self.scale - self.mean[channel]) / self.std[channel]
    }

    /// Interpolates the level of a channel between four pixels.
    fn between(&self, picture: &Picture, x: PixelPlace, y: PixelPlace, channel: usize) -> f32 {
        let level = |x, y| self.level(picture, x, y, channel);
        let row = |y| mix(level(x.low, y), || level(x.low + 1, y), x.share);
        mix(row(y.low), || row(y.low + 1), y.share)
    }

    fn level(&self, picture: &Picture, x: usize, y: usize, channel: usize) -> f32 {
        match self.colour {
            _ if self.channels == 1 => picture.brightness(x, y),
            Colour::Grey => picture.brightness(x, y),
            Colour::Rgb => f32::from(picture.level(x, y, channel)),
            Colour::Bgr => f32::from(picture.level(x, y, 2 - channel)),
        }
    }
}

/// Interpolates from `low` to `high` by a share of 0 to 1; `high` is not computed if its share is
/// 0.
fn mix(low: f32, high: impl FnOnce() -> f32, share: f32) -> f32 {
    if share > 0.0 { low + share * (high() - low) } else { low }
}

/// A place between two neighbouring pixels along one axis: the lower pixel, and the share of the
/// way to the next.
#[derive(Clone, Copy)]
struct PixelPlace {
    low: usize,
    share: f32,
}

/// Returns the places in the picture of the middles of the input's pixels along one axis; `None` in
/// the bars.
fn places(count: usize, fit: &InputFit, axis: usize) -> Vec<Option<PixelPlace>> {
    let first = fit.offset[axis] as usize;
    let inside = first..first + fit.covered[axis];
    let place = |index: usize| {
        let middle = index as f32 + 0.5 - fit.offset[axis];
        let place = (middle / fit.scale[axis] - 0.5).clamp(0.0, fit.picture[axis] - 1.0);
        let place = PixelPlace { low: place as usize, share: place.fract() };
        inside.contains(&index).then_some(place)
    };
    (0..count).map(place).collect()
}
