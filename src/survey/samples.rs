//! Echo samples of one side of a ping, borrowed from the mapped file.

use std::ops::Range;
use std::sync::Arc;

/// The bytes of one file: mapped, or held in memory (a simulated survey, a test).
#[derive(Clone, Debug)]
pub enum Bytes {
    /// A read-only memory map.
    Mapped(Arc<memmap2::Mmap>),
    /// Bytes in memory.
    Held(Arc<Vec<u8>>),
}

impl std::ops::Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Bytes::Mapped(map) => map,
            Bytes::Held(bytes) => bytes,
        }
    }
}

/// Which end of the stored samples is nearest to the boat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleOrder {
    /// The first stored sample is at the transducer.
    NearToFar,
    /// The last stored sample is at the transducer (the port half of a composite frame).
    FarToNear,
}

/// How a sample is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// One byte.
    U8,
    /// Two bytes, little-endian, of which `value >> shift` fits a byte.
    U16 {
        /// Bits to drop.
        shift: u8,
    },
    /// Four bytes, little-endian, of which `value >> shift` fits a byte.
    U32 {
        /// Bits to drop.
        shift: u8,
    },
    /// Two bytes, little-endian, on the scale of their own ping: `base + step * value` is the level in units of 2^-[`LEVEL_BITS`].
    ScaledU16 {
        /// Level of the value 0.
        base: i32,
        /// Levels from one value to the next.
        step: u32,
    },
    /// Four bytes: real and imaginary part, little-endian i16. The level is their magnitude times `step`, in units of
    /// 2^-[`LEVEL_BITS`].
    ScaledComplex {
        /// Levels from one magnitude to the next.
        step: u32,
    },
}

/// Bits after the point of the levels of an [`Encoding`].
pub(crate) const LEVEL_BITS: u32 = 20;

impl Encoding {
    /// Bytes of a sample.
    pub fn width(self) -> usize {
        match self {
            Encoding::U8 => 1,
            Encoding::U16 { .. } | Encoding::ScaledU16 { .. } => 2,
            Encoding::U32 { .. } | Encoding::ScaledComplex { .. } => 4,
        }
    }
}

/// Where the samples of one side of a ping lie, and the slant range that they cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideSpan {
    /// Index into [`super::Survey::bytes`].
    pub file: u8,
    /// How a sample is stored.
    pub encoding: Encoding,
    /// Which end is nearest.
    pub order: SampleOrder,
    /// Byte offset of the first stored sample.
    pub offset: u64,
    /// Number of samples.
    pub count: u32,
    /// Slant range at the near edge of the nearest sample, metres.
    pub near_m: f32,
    /// Slant range at the far edge of the farthest sample, metres.
    pub far_m: f32,
}

impl SideSpan {
    /// Bytes from the near to the far one, at the start of the first file: what tests of ranges need.
    #[cfg(test)]
    pub(crate) fn of_bytes(count: u32, [near_m, far_m]: [f32; 2]) -> Self {
        Self {
            file: 0,
            encoding: Encoding::U8,
            order: SampleOrder::NearToFar,
            offset: 0,
            count,
            near_m,
            far_m,
        }
    }

    /// Metres of slant range that one sample covers, as the recorder states it.
    pub fn metres_per_sample(&self) -> f64 {
        f64::from(self.far_m - self.near_m) / f64::from(self.count.max(1))
    }

    /// Slant range at a distance of `sample` samples outward from the nearest edge, metres, by the recorder's scale.
    pub fn range_m(&self, sample: f64) -> f64 {
        f64::from(self.near_m) + sample * self.metres_per_sample()
    }

    /// Inverse of [`SideSpan::range_m`].
    pub fn sample_at(&self, range_m: f64) -> f64 {
        (range_m - f64::from(self.near_m)) / self.metres_per_sample()
    }
}

/// The samples of one side of a ping; index 0 is nearest to the boat whatever the file's order.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    stored: &'a [u8],
    encoding: Encoding,
    order: SampleOrder,
}

impl<'a> Samples<'a> {
    /// `None` when the span lies outside the bytes.
    pub fn new(bytes: &'a [u8], span: &SideSpan) -> Option<Self> {
        let width = span.encoding.width();
        let start = usize::try_from(span.offset).ok()?;
        let end = start.checked_add((span.count as usize).checked_mul(width)?)?;
        let stored = bytes.get(start..end)?;
        Some(Self {
            stored,
            encoding: span.encoding,
            order: span.order,
        })
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.stored.len() / self.encoding.width()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.stored.is_empty()
    }

    /// The sample `index` steps outward from the boat. Panics beyond the last, as a slice does.
    pub fn get(&self, index: usize) -> u8 {
        let stored = match self.order {
            SampleOrder::NearToFar => index,
            SampleOrder::FarToNear => self.len() - 1 - index,
        };
        match self.encoding {
            Encoding::U8 => self.stored[stored],
            Encoding::U16 { shift } => (self.pair(2 * stored) >> shift).min(255) as u8,
            Encoding::U32 { shift } => {
                let [low, high] = [4 * stored, 4 * stored + 2].map(|at| u32::from(self.pair(at)));
                ((high << 16 | low) >> shift).min(255) as u8
            }
            Encoding::ScaledU16 { base, step } => {
                let value = self.pair(2 * stored);
                let level = i64::from(base) + i64::from(step) * i64::from(value);
                (level >> LEVEL_BITS).clamp(0, 255) as u8
            }
            Encoding::ScaledComplex { step } => {
                let part = |at| f32::from(self.pair(at).cast_signed());
                let magnitude = part(4 * stored).hypot(part(4 * stored + 2));
                // The conversion keeps to 0..=255.
                (magnitude * step as f32 / (1 << LEVEL_BITS) as f32) as u8
            }
        }
    }

    /// Two stored bytes as a number.
    fn pair(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.stored[at], self.stored[at + 1]])
    }

    /// The stored bytes when they are one byte a sample, with their order; the fast way for whole-survey passes.
    pub fn stored_u8(&self) -> Option<(&'a [u8], SampleOrder)> {
        (self.encoding == Encoding::U8).then_some((self.stored, self.order))
    }

    /// Replaces `out` with all samples, nearest first.
    pub fn copy_outward(&self, out: &mut Vec<u8>) {
        self.copy_part_outward(0..self.len(), out);
    }

    /// Replaces `out` with some of the samples, nearest first; those beyond the last are left out.
    pub fn copy_part_outward(&self, part: Range<usize>, out: &mut Vec<u8>) {
        let end = part.end.min(self.len());
        let start = part.start.min(end);
        out.clear();
        match self.stored_u8() {
            Some((bytes, SampleOrder::NearToFar)) => out.extend_from_slice(&bytes[start..end]),
            Some((bytes, SampleOrder::FarToNear)) => {
                let count = bytes.len();
                out.extend(bytes[count - end..count - start].iter().rev());
            }
            None => out.extend((start..end).map(|index| self.get(index))),
        }
    }
}
