//! Header of the packets of an XTF file, by which a walk finds each after the one before.

use super::raw::{PacketHeader, record};
use crate::formats::messages::MessageFormat;

/// The number that every packet begins with.
pub(super) const MAGIC: u16 = 0xFACE;
/// No packet is longer; a longer one is damage.
const LONGEST_PACKET: usize = 1 << 24;

/// Packets.
pub(super) const PACKETS: MessageFormat = MessageFormat {
    noun: "packet",
    marker: MAGIC.to_le_bytes(),
    length: |bytes, offset| header(bytes, offset).map(|packet| packet.size as usize),
};

/// The packet header at `offset`, if one can be there.
pub(super) fn header(bytes: &[u8], offset: usize) -> Option<PacketHeader> {
    let packet: PacketHeader = record(bytes, offset)?;
    let size = packet.size as usize;
    (packet.magic == MAGIC && (size_of::<PacketHeader>()..LONGEST_PACKET).contains(&size))
        .then_some(packet)
}
