//! Reads numbers from bytes, in either byte order, with a defined result past the end.

/// Returns the `N` bytes at `at`; `None` past the end.
pub(super) fn take<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..at.checked_add(N)?)?.try_into().ok()
}

/// Returns the little-endian u16 at `at`; `None` past the end.
pub(super) fn u16_le(bytes: &[u8], at: usize) -> Option<u16> {
    take(bytes, at).map(u16::from_le_bytes)
}

/// Returns the little-endian u32 at `at`; `None` past the end.
pub(super) fn u32_le(bytes: &[u8], at: usize) -> Option<u32> {
    take(bytes, at).map(u32::from_le_bytes)
}

/// A record of little-endian fields; a field past its end reads as 0, like an unset field.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl Fields<'_> {
    /// Returns the byte at an offset.
    pub(super) fn u8(self, at: usize) -> u8 {
        self.0.get(at).copied().unwrap_or(0)
    }

    /// Returns the u16 at an offset.
    pub(super) fn u16(self, at: usize) -> u16 {
        u16_le(self.0, at).unwrap_or(0)
    }

    /// Returns the i16 at an offset.
    pub(super) fn i16(self, at: usize) -> i16 {
        self.u16(at).cast_signed()
    }

    /// Returns the u32 at an offset.
    pub(super) fn u32(self, at: usize) -> u32 {
        u32_le(self.0, at).unwrap_or(0)
    }

    /// Returns the i32 at an offset.
    pub(super) fn i32(self, at: usize) -> i32 {
        self.u32(at).cast_signed()
    }

    /// Returns the f32 at an offset, which may be NaN or infinite.
    pub(super) fn f32(self, at: usize) -> f32 {
        f32::from_bits(self.u32(at))
    }
}

/// Order of the bytes in a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    /// Most significant byte first.
    Big,
    /// Least significant byte first.
    Little,
}

impl ByteOrder {
    /// Returns the u32 of these bytes in this order.
    pub(super) fn u32(self, bytes: [u8; 4]) -> u32 {
        match self {
            ByteOrder::Big => u32::from_be_bytes(bytes),
            ByteOrder::Little => u32::from_le_bytes(bytes),
        }
    }
}
