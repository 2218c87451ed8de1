//! Numbers out of bytes: never past the end, in either byte order.

/// `N` bytes at `at`; `None` past the end.
pub(super) fn take<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..at.checked_add(N)?)?.try_into().ok()
}

/// A little-endian u16.
pub(super) fn u16_le(bytes: &[u8], at: usize) -> Option<u16> {
    take(bytes, at).map(u16::from_le_bytes)
}

/// A little-endian u32.
pub(super) fn u32_le(bytes: &[u8], at: usize) -> Option<u32> {
    take(bytes, at).map(u32::from_le_bytes)
}

/// A record of little-endian fields; one past its end reads as 0, as an unset one does.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl Fields<'_> {
    /// One byte.
    pub(super) fn u8(self, at: usize) -> u8 {
        self.0.get(at).copied().unwrap_or(0)
    }

    /// A u16.
    pub(super) fn u16(self, at: usize) -> u16 {
        u16_le(self.0, at).unwrap_or(0)
    }

    /// An i16.
    pub(super) fn i16(self, at: usize) -> i16 {
        self.u16(at).cast_signed()
    }

    /// A u32.
    pub(super) fn u32(self, at: usize) -> u32 {
        u32_le(self.0, at).unwrap_or(0)
    }

    /// An i32.
    pub(super) fn i32(self, at: usize) -> i32 {
        self.u32(at).cast_signed()
    }

    /// An f32; it may be NaN or infinite.
    pub(super) fn f32(self, at: usize) -> f32 {
        f32::from_bits(self.u32(at))
    }
}

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    /// Most significant first.
    Big,
    /// Least significant first.
    Little,
}

impl ByteOrder {
    /// A u32 in this order.
    pub(super) fn u32(self, bytes: [u8; 4]) -> u32 {
        match self {
            ByteOrder::Big => u32::from_be_bytes(bytes),
            ByteOrder::Little => u32::from_le_bytes(bytes),
        }
    }
}
