//! The headers of the messages of a JSF file.

use crate::formats::messages::MessageFormat;
use crate::formats::scalar::Fields;

/// Bytes of a message's header.
pub(super) const HEADER: usize = 16;
/// The two bytes that each message begins with: 0x1601.
pub(super) const MARKER: [u8; 2] = [0x01, 0x16];
/// No message is longer; a longer one is damage.
const LONGEST: usize = 1 << 24;

/// Marker and length of messages, by which a walk finds each after the one before.
pub(super) const FORMAT: MessageFormat = MessageFormat {
    noun: "message",
    marker: MARKER,
    length: |bytes, at| Some(HEADER + MessageHeader::at(bytes, at)?.size),
};

/// A message's header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MessageHeader {
    /// Version of the protocol.
    pub(super) version: u8,
    /// Type of the message.
    pub(super) kind: u16,
    /// Subsystem that it is of.
    pub(super) subsystem: u8,
    /// Channel of the subsystem.
    pub(super) channel: u8,
    /// Bytes that follow.
    pub(super) size: usize,
}

impl MessageHeader {
    /// The header at an offset; `None` where there can be none.
    pub(super) fn at(bytes: &[u8], at: usize) -> Option<Self> {
        let header = Fields(bytes.get(at..at.checked_add(HEADER)?)?);
        let size = usize::try_from(header.i32(12)).ok()?;
        let is_header = header.0.starts_with(&MARKER) && size < LONGEST;
        is_header.then(|| Self {
            version: header.u8(2),
            kind: header.u16(4),
            subsystem: header.u8(7),
            channel: header.u8(8),
            size,
        })
    }
}
