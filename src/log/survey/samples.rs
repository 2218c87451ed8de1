//! Reads the echo samples of one side of a ping from the mapped file, or from the samples unpacked
//! from it.

use crate::support::mapped_file::{FileFault, MappedFile};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// The bytes of one file: mapped, or held in memory (a simulated survey, a test). Dereferencing
/// returns the bytes of the file, even if its samples are stored elsewhere.
#[derive(Clone, Debug)]
pub enum Bytes {
    /// A read-only memory map; bytes that cannot be read any more are zero.
    Mapped(Arc<MappedFile>),
    /// Bytes in memory.
    Held(Arc<Vec<u8>>),
    /// Bytes of a file whose samples are compressed, such as a picture.
    Packed {
        /// The file.
        file: Box<Bytes>,
        /// Samples unpacked from the file; the sample spans point into them.
        samples: Arc<Vec<u8>>,
    },
}

impl Bytes {
    /// Returns the fault that has made the bytes, or the data that was read from them, wrong since
    /// the file at `path` was opened; `None` while they are right. See [`MappedFile::fault`].
    pub fn fault(&self, path: &Path) -> Option<FileFault> {
        self.mapped()?.fault(path)
    }

    /// Returns true if the bytes are in a file that other programs can reach.
    pub fn is_shared(&self) -> bool {
        self.mapped().is_some_and(MappedFile::is_shared)
    }

    /// Returns true if the sample spans point into unpacked samples, not into the file.
    pub(crate) fn is_packed(&self) -> bool {
        matches!(self, Bytes::Packed { .. })
    }

    /// Returns the bytes that the sample spans point into.
    pub fn samples(&self) -> &[u8] {
        match self {
            Bytes::Packed { samples, .. } => samples,
            file => file,
        }
    }

    /// Returns the fault of bytes that could not be read, with the offset of the first of them:
    /// from there on the bytes are zero. `None` while all could be read. The call does not access
    /// the disk.
    pub fn lost(&self) -> Option<FileFault> {
        self.mapped()?.lost()
    }

    /// Returns the map of the file; `None` for bytes in memory.
    fn mapped(&self) -> Option<&MappedFile> {
        match self {
            Bytes::Mapped(map) => Some(map),
            Bytes::Held(_) => None,
            Bytes::Packed { file, .. } => file.mapped(),
        }
    }
}

impl From<MappedFile> for Bytes {
    fn from(map: MappedFile) -> Self {
        Self::Mapped(Arc::new(map))
    }
}

impl std::ops::Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Bytes::Mapped(map) => map,
            Bytes::Held(bytes) => bytes,
            Bytes::Packed { file, .. } => file,
        }
    }
}

/// Order in which the samples of a side are stored: the end that is nearest to the boat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleOrder {
    /// The first stored sample is at the transducer.
    NearToFar,
    /// The last stored sample is at the transducer (the port half of a composite frame).
    FarToNear,
}

/// Encoding of a sample in the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// One byte.
    U8,
    /// Two bytes, little-endian; the level is `value >> shift`, which fits a byte.
    U16 {
        /// Bits to drop.
        shift: u8,
    },
    /// Two bytes, little-endian, with a scale for each ping: the level is `base + step * value`, in
    /// units of 2^-[`LEVEL_BITS`].
    ScaledU16 {
        /// Level of the value 0.
        base: i32,
        /// Difference of level from one value to the next.
        step: u32,
    },
    /// Four bytes: real and imaginary part, little-endian i16. The level is their magnitude times
    /// `step`, in units of 2^-[`LEVEL_BITS`].
    ScaledComplex {
        /// Difference of level from one magnitude to the next.
        step: u32,
    },
    /// A number, little-endian, whose magnitude times 2^`exponent` is the level.
    Number {
        /// Type of the numbers.
        kind: NumberKind,
        /// Exponent of 2 that scales a number to a level.
        exponent: i16,
    },
}

/// Type of the numbers that are stored as samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberKind {
    /// One byte.
    U8,
    /// One byte, signed.
    I8,
    /// Two bytes.
    U16,
    /// Two bytes, signed.
    I16,
    /// Four bytes.
    U32,
    /// Four bytes, signed.
    I32,
    /// Four bytes, IEEE 754.
    F32,
    /// Four bytes, the floating point of IBM's System/360: a sign, seven bits of an exponent of 16,
    /// 24 bits of a fraction.
    IbmF32,
}

impl NumberKind {
    /// Returns the number of bytes of a number.
    pub fn width(self) -> usize {
        match self {
            NumberKind::U8 | NumberKind::I8 => 1,
            NumberKind::U16 | NumberKind::I16 => 2,
            NumberKind::U32 | NumberKind::I32 | NumberKind::F32 | NumberKind::IbmF32 => 4,
        }
    }

    /// Returns the magnitude of a number of [`NumberKind::width`] bytes; NaN for another count of
    /// bytes.
    pub(crate) fn magnitude(self, stored: &[u8]) -> f64 {
        match (self, stored) {
            (NumberKind::U8, &[a]) => f64::from(a),
            (NumberKind::I8, &[a]) => f64::from(a.cast_signed().unsigned_abs()),
            (NumberKind::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
            (NumberKind::I16, &[a, b]) => f64::from(i16::from_le_bytes([a, b]).unsigned_abs()),
            (NumberKind::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (NumberKind::I32, &[a, b, c, d]) => {
                f64::from(i32::from_le_bytes([a, b, c, d]).unsigned_abs())
            }
            (NumberKind::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])).abs(),
            (NumberKind::IbmF32, &[a, b, c, d]) => {
                let bits = u32::from_le_bytes([a, b, c, d]);
                let power = 4 * (((bits >> 24) & 0x7F) as i16 - 64) - 24;
                f64::from(bits & 0xFF_FFFF) * power_of_two(power)
            }
            _ => f64::NAN,
        }
    }
}

/// Returns 2^`exponent`, with the exponent limited to -1000 to 1000, which suffices for samples.
fn power_of_two(exponent: i16) -> f64 {
    f64::from_bits(u64::from((i16::clamp(exponent, -1000, 1000) + 1023).cast_unsigned()) << 52)
}

/// Number of bits after the binary point of the levels of an [`Encoding`].
pub const LEVEL_BITS: u32 = 20;

impl Encoding {
    /// Returns the number of bytes of a sample.
    pub fn width(self) -> usize {
        match self {
            Encoding::U8 => 1,
            Encoding::U16 { .. } | Encoding::ScaledU16 { .. } => 2,
            Encoding::ScaledComplex { .. } => 4,
            Encoding::Number { kind, .. } => kind.width(),
        }
    }
}

/// Place of the samples of one side of a ping in the bytes, and the slant range that they cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideSpan {
    /// Index into [`super::Survey::bytes`].
    pub file: u8,
    /// Encoding of a sample.
    pub encoding: Encoding,
    /// Order of the stored samples: which end is nearest to the boat.
    pub order: SampleOrder,
    /// Byte offset of the first stored sample, in [`Bytes::samples`].
    pub offset: u64,
    /// Number of samples.
    pub count: u32,
    /// Slant range at the near edge of the nearest sample, metres.
    pub near_m: f32,
    /// Slant range at the far edge of the farthest sample, metres.
    pub far_m: f32,
}

impl SideSpan {
    /// Creates a span of `count` samples of one byte, nearest first, at the start of the first
    /// file, over a slant range from its near to its far edge, metres.
    pub fn of_bytes(count: u32, [near_m, far_m]: [f32; 2]) -> Self {
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

    /// Returns the stored bytes of the samples in [`Bytes::samples`]; empty where the span is
    /// outside of the bytes.
    pub(crate) fn stored<'a>(&self, bytes: &'a [u8]) -> &'a [u8] {
        Samples::new(bytes, self).map(|samples| samples.stored).unwrap_or_default()
    }

    /// Returns the metres of slant range that one sample covers, as the recorder states them.
    pub fn metres_per_sample(&self) -> f64 {
        f64::from(self.far_m - self.near_m) / f64::from(self.count.max(1))
    }

    /// Returns the slant range `sample` samples outward from the near edge, metres, by the
    /// recorder's scale.
    pub fn range_m(&self, sample: f64) -> f64 {
        f64::from(self.near_m) + sample * self.metres_per_sample()
    }

    /// Inverse of [`SideSpan::range_m`].
    pub fn sample_at(&self, range_m: f64) -> f64 {
        (range_m - f64::from(self.near_m)) / self.metres_per_sample()
    }
}

/// The samples of one side of a ping; index 0 is nearest to the boat, whatever the order in the
/// file.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    stored: &'a [u8],
    encoding: Encoding,
    order: SampleOrder,
}

impl<'a> Samples<'a> {
    /// Creates the samples of a span of `bytes`; `None` when the span is outside of the bytes.
    pub fn new(bytes: &'a [u8], span: &SideSpan) -> Option<Self> {
        let width = span.encoding.width();
        let start = usize::try_from(span.offset).ok()?;
        let end = start.checked_add((span.count as usize).checked_mul(width)?)?;
        let stored = bytes.get(start..end)?;
        Some(Self { stored, encoding: span.encoding, order: span.order })
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.stored.len() / self.encoding.width()
    }

    /// Returns true if there is no sample.
    pub fn is_empty(&self) -> bool {
        self.stored.is_empty()
    }

    /// Returns the level of the sample `index` steps outward from the boat. Panics beyond the last
    /// sample, as a slice does.
    pub fn get(&self, index: usize) -> u8 {
        let stored = self.stored_index(index);
        match self.encoding {
            Encoding::U8 => self.stored[stored],
            Encoding::U16 { shift } => (u32::from(self.pair(2 * stored)) >> shift).min(255) as u8,
            Encoding::ScaledU16 { base, step } => {
                let level = self.level(stored, base, step);
                (level >> LEVEL_BITS).clamp(0, 255) as u8
            }
            // The conversion limits the value to 0..=255.
            Encoding::ScaledComplex { step } => self.magnitude(stored, step) as u8,
            // As above; NaN becomes 0.
            Encoding::Number { kind, exponent } => self.number(stored, kind, exponent) as u8,
        }
    }

    /// Returns the sample `index` steps outward from the boat with all stored bits, up to 16; for
    /// samples that are scaled to levels, the level times 256. Panics beyond the last sample, as a
    /// slice does.
    pub fn wide(&self, index: usize) -> u16 {
        let stored = self.stored_index(index);
        match self.encoding {
            Encoding::U8 => u16::from(self.stored[stored]),
            Encoding::U16 { .. } => self.pair(2 * stored),
            Encoding::ScaledU16 { base, step } => {
                let level = self.level(stored, base, step) >> (LEVEL_BITS - 8);
                level.clamp(0, 0xFFFF) as u16
            }
            Encoding::ScaledComplex { step } => (self.magnitude(stored, step) * 256.0) as u16,
            Encoding::Number { kind, exponent } => {
                (self.number(stored, kind, exponent) * 256.0) as u16
            }
        }
    }

    fn stored_index(&self, index: usize) -> usize {
        match self.order {
            SampleOrder::NearToFar => index,
            SampleOrder::FarToNear => self.len() - 1 - index,
        }
    }

    /// Returns the level of [`Encoding::ScaledU16`], in units of 2^-[`LEVEL_BITS`].
    fn level(&self, stored: usize, base: i32, step: u32) -> i64 {
        i64::from(base) + i64::from(step) * i64::from(self.pair(2 * stored))
    }

    /// Returns the level of [`Encoding::ScaledComplex`].
    fn magnitude(&self, stored: usize, step: u32) -> f32 {
        let part = |at| f32::from(self.pair(at).cast_signed());
        let magnitude = part(4 * stored).hypot(part(4 * stored + 2));
        magnitude * step as f32 / (1 << LEVEL_BITS) as f32
    }

    /// Returns the level of [`Encoding::Number`].
    fn number(&self, stored: usize, kind: NumberKind, exponent: i16) -> f64 {
        let width = kind.width();
        let stored = &self.stored[width * stored..width * (stored + 1)];
        kind.magnitude(stored) * power_of_two(exponent)
    }

    /// Returns two stored bytes as a number.
    fn pair(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.stored[at], self.stored[at + 1]])
    }

    /// Returns the stored bytes and their order if each sample is one byte, otherwise `None`;
    /// faster than [`Samples::get`] for passes over the whole survey.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(kind: NumberKind, exponent: i16, stored: &[u8]) -> Vec<u8> {
        let span = SideSpan {
            encoding: Encoding::Number { kind, exponent },
            ..SideSpan::of_bytes((stored.len() / kind.width()) as u32, [0.0, 1.0])
        };
        let mut levels = Vec::new();
        let samples = Samples::new(stored, &span).expect("samples");
        samples.copy_outward(&mut levels);
        levels
    }

    #[test]
    fn the_magnitude_of_any_number_is_a_level() {
        assert_eq!(levels(NumberKind::I8, 0, &[1, 255, 128]), [1, 1, 128]);
        let pairs = [-300_i16, i16::MIN, 7, 0].map(i16::to_le_bytes).concat();
        assert_eq!(levels(NumberKind::I16, -2, &pairs), [75, 255, 1, 0]);
        let words = [3_u32 << 24, u32::MAX, 0, 1].map(u32::to_le_bytes).concat();
        assert_eq!(levels(NumberKind::U32, -24, &words), [3, 255, 0, 0]);
        assert_eq!(levels(NumberKind::I32, -24, &words), [3, 0, 0, 0]);
        let floats = [0.5_f32, -0.25, f32::NAN, f32::INFINITY, -1e30, 0.0];
        let floats = floats.map(f32::to_le_bytes).concat();
        assert_eq!(levels(NumberKind::F32, 8, &floats), [128, 64, 0, 255, 255, 0]);
        assert_eq!(levels(NumberKind::F32, i16::MIN, &floats), [0, 0, 0, 255, 0, 0]);
        assert_eq!(levels(NumberKind::F32, i16::MAX, &floats)[..2], [255, 255]);
        // 118.625 is 0x76A000 * 16^2 / 2^24, as in IBM's own example of the format.
        let floats = [0xC276_A000_u32, 0x4276_A000, 0x7FFF_FFFF, 0];
        let floats = floats.map(u32::to_le_bytes).concat();
        assert_eq!(levels(NumberKind::IbmF32, 0, &floats), [118, 118, 255, 0]);
    }
}
