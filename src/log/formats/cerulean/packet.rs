//! Packets of the Ping protocol.

use crate::formats::messages::MessageFormat;
use crate::formats::scalar::{Fields, u16_le};

/// Bytes before the payload.
pub(super) const HEADER: usize = 8;
/// Bytes of the sum after the payload.
const SUM: usize = 2;
/// The two bytes that each packet begins with.
const MARKER: [u8; 2] = *b"BR";

/// Marker and length of packets, by which a walk finds each after the one before.
pub(super) const FORMAT: MessageFormat = MessageFormat {
    noun: "message",
    marker: MARKER,
    length: |bytes, at| {
        let header = Fields(bytes.get(at..at.checked_add(HEADER)?)?);
        let is_header = header.0.starts_with(&MARKER);
        is_header.then(|| HEADER + usize::from(header.u16(2)) + SUM)
    },
};

/// A packet that is whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packet<'a> {
    /// Number of its type.
    pub(super) id: u16,
    /// Number of the device that sent it.
    pub(super) device: u8,
    /// Offset of the payload in the file.
    pub(super) payload_at: usize,
    /// The payload.
    pub(super) payload: &'a [u8],
    header: &'a [u8],
    sum: u16,
}

impl<'a> Packet<'a> {
    /// The packet that begins at an offset; `None` where none does, or where it is cut.
    pub(super) fn at(bytes: &'a [u8], at: usize) -> Option<Self> {
        let length = (FORMAT.length)(bytes, at)?;
        let packet = bytes.get(at..at.checked_add(length)?)?;
        let (header, rest) = packet.split_at_checked(HEADER)?;
        let (payload, sum) = rest.split_at_checked(rest.len().checked_sub(SUM)?)?;
        Some(Self {
            id: Fields(header).u16(4),
            device: Fields(header).u8(6),
            payload_at: at + HEADER,
            payload,
            header,
            sum: u16_le(sum, 0)?,
        })
    }

    /// Returns true if the sum of its bytes is what it says. Some programs leave it 0.
    pub(super) fn is_sound(&self) -> bool {
        let bytes = self.header.iter().chain(self.payload);
        let sum = bytes.fold(0_u16, |sum, byte| sum.wrapping_add(u16::from(*byte)));
        sum == self.sum || self.sum == 0
    }
}
