//! From packet to packet through an XTF file.

use super::raw::{PacketHeader, record};
use crate::formats::report::{WarningKind, WarningReport};
use crate::support::progress::{Cancelled, Progress};

/// The number that every packet begins with.
const MAGIC: u16 = 0xFACE;
/// No packet is longer; a longer one is damage.
const LONGEST_PACKET: usize = 1 << 24;
/// Packets between two looks at the progress.
const PACKETS_A_CHECK: usize = 1024;

/// A walk over the packets of a file.
pub(super) struct PacketWalk<'a> {
    /// The whole file.
    pub(super) bytes: &'a [u8],
    /// Where to say what is wrong.
    pub(super) report: &'a WarningReport,
    /// What is cut at its end is still being written.
    pub(super) is_growing: bool,
    /// Where to say how far it is.
    pub(super) progress: &'a Progress,
}

impl PacketWalk<'_> {
    /// Calls `take` with offset, size and header of every whole packet from `start` on.
    pub(super) fn run(
        &self,
        start: usize,
        mut take: impl FnMut(usize, PacketHeader),
    ) -> Result<(), Cancelled> {
        let (mut at, mut reported, mut packets) = (start, start, 0_usize);
        while at < self.bytes.len() {
            if packets.is_multiple_of(PACKETS_A_CHECK) {
                self.progress.check()?;
                self.progress.advance((at - reported) as u64);
                reported = at;
            }
            packets += 1;
            at = match header(self.bytes, at) {
                Some(packet) => self.step(at, packet, &mut take),
                None => self.over_gap(at),
            };
        }
        self.progress.advance((self.bytes.len() - reported) as u64);
        Ok(())
    }

    fn step(
        &self,
        at: usize,
        packet: PacketHeader,
        take: &mut impl FnMut(usize, PacketHeader),
    ) -> usize {
        let len = self.bytes.len();
        let next = at + packet.size as usize;
        if next == len || header(self.bytes, next).is_some() {
            take(at, packet);
            return next;
        }
        // Something is damaged: this packet's size if another packet begins inside it, else what follows.
        if let Some(found) = next_packet(self.bytes, at + 2, next) {
            let text = format!(
                "a packet says that it is {} bytes long, but the next begins after {}; it was dropped",
                next - at,
                found - at
            );
            self.report.at(WarningKind::Frame, 0, at, text);
            return found;
        }
        if next > len && self.is_growing {
            return len;
        }
        if next > len {
            let text = format!(
                "the file was cut inside its last packet ({} bytes of it are there); it was dropped",
                len - at
            );
            self.report.at(WarningKind::Frame, 0, at, text);
            return len;
        }
        take(at, packet);
        next
    }

    fn over_gap(&self, at: usize) -> usize {
        let len = self.bytes.len();
        let found = next_packet(self.bytes, at + 1, len);
        let to = found.unwrap_or(len);
        if found.is_none() && self.is_growing {
            return to;
        }
        let text = format!("{} bytes belong to no packet and were skipped", to - at);
        self.report.at(WarningKind::Gap, 0, at, text);
        to
    }
}

/// The packet header at `offset`, if one can be there.
pub(super) fn header(bytes: &[u8], offset: usize) -> Option<PacketHeader> {
    let packet: PacketHeader = record(bytes, offset)?;
    let size = packet.size as usize;
    (packet.magic == MAGIC && (size_of::<PacketHeader>()..LONGEST_PACKET).contains(&size))
        .then_some(packet)
}

/// The first packet that begins in `from..to` and is followed by another or by the end of the file: two bytes of magic
/// number alone would be found by chance in every hundred pings.
pub(super) fn next_packet(bytes: &[u8], from: usize, to: usize) -> Option<usize> {
    let to = to.min(bytes.len());
    let searched = bytes.get(from..to)?;
    searched
        .windows(2)
        .enumerate()
        .filter(|(_, window)| **window == MAGIC.to_le_bytes())
        .map(|(index, _)| from + index)
        .find(|&at| {
            header(bytes, at).is_some_and(|packet| {
                let next = at + packet.size as usize;
                next == bytes.len() || header(bytes, next).is_some()
            })
        })
}
