//! Reads records: their header, the fields of their ping, and the position of its samples in the
//! file; walks from record to record.

use super::varstruct::{VarStruct, first_item, whole_varuint};
use crate::formats::scalar::u32_le;
use crate::formats::walk::Walk;
use crate::support::progress::Cancelled;

/// Value of field 0 of every record header.
const MAGIC: [u8; 4] = 0xB7E9_DA86_u32.to_le_bytes();
/// Bytes before the magic number: the number of fields, and the key of field 0 with its length of
/// 4.
const BEFORE_MAGIC: usize = 2;
/// First four bytes of the trailer of a record, as a number.
const TRAILER_MAGIC: u32 = 0xF98E_ACBC;
/// Bytes of the trailer: the magic number, the record's length, a checksum.
const TRAILER: usize = 12;
/// Bytes of the checksum after the fields of a record header. It is not checked: other readers
/// report that it is wrong in whole records.
const CHECKSUM: usize = 4;
/// Lowest stored depth that means "no depth".
const NO_DEPTH: u32 = 0xFFFF_FF00;

/// The header of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RecordHeader {
    /// Channel of the record; `None` where the header does not state it.
    pub(super) channel: Option<u32>,
    /// Milliseconds since the start of the recording.
    pub(super) time_ms: i32,
    /// Offset of the body.
    pub(super) body: usize,
    /// Bytes of the body; 0 without a body.
    pub(super) size: usize,
}

impl RecordHeader {
    /// Reads the record header at `at`; `None` where there is none or it is damaged.
    pub(super) fn read(bytes: &[u8], at: usize) -> Option<Self> {
        let magic = at.checked_add(BEFORE_MAGIC)?;
        if bytes.get(at + 1) != Some(&4) || u32_le(bytes, magic) != Some(u32::from_le_bytes(MAGIC))
        {
            return None;
        }
        let fields = VarStruct::read(bytes, at)?;
        let state = fields.structure(1);
        let channel = state.and_then(|state| state.bytes(1));
        // The time is negative for a ping that was sent before the recording began.
        let time_ms = fields.unsigned(5).unwrap_or(0).cast_signed();
        Some(Self {
            channel: channel.and_then(first_item).and_then(whole_varuint),
            time_ms,
            body: fields.end + CHECKSUM,
            size: usize::try_from(fields.unsigned(4).unwrap_or(0)).ok()?,
        })
    }

    /// Returns the offset of the end of the body.
    pub(super) fn end(&self) -> usize {
        self.body.saturating_add(self.size)
    }
}

/// Position of the samples of a ping in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StoredSamples {
    /// Offset of the first sample.
    pub(super) offset: usize,
    /// Number of samples.
    pub(super) count: u32,
    /// True if a sample has two bytes.
    pub(super) is_wide: bool,
}

/// The ping in the body of a record. Depths are as they are stored
/// (`decode::DepthEncoding`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RecordBody {
    /// Channel; `None` where the body does not state it.
    pub(super) channel: Option<u32>,
    /// Depth of the bottom; `None` where the body has none.
    pub(super) bottom: Option<u32>,
    /// Depth, or slant range, of the first and the last sample.
    pub(super) range: [Option<u32>; 2],
    /// Latitude and longitude, 2^32 units to the circle.
    pub(super) place: Option<[i32; 2]>,
    /// Number of the beam: 1 down in a cone, 2 to port, 3 to starboard, 4 down in a fan.
    pub(super) beam: Option<u32>,
    /// Tilt of a side-scan element, as other programs interpret it: negative to port, positive to
    /// starboard.
    pub(super) tilt: Option<f32>,
    /// Number of samples that the body states.
    pub(super) stated_samples: u32,
    /// Position of the samples; `None` where the body states none, or has too few bytes for them.
    pub(super) samples: Option<StoredSamples>,
}

/// A ping of any channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ping {
    /// Offset of the ping's record.
    pub(super) offset: usize,
    /// Offset of the end of the body.
    pub(super) end: usize,
    /// Milliseconds since the start of the recording.
    pub(super) time_ms: i32,
    /// Number of the ping's channel.
    pub(super) channel: u16,
    /// Content of the record.
    pub(super) body: RecordBody,
}

impl RecordBody {
    /// Reads the body of a record; `None` where it is truncated or its fields are damaged.
    pub(super) fn read(bytes: &[u8], header: &RecordHeader) -> Option<Self> {
        let body = bytes.get(..header.end())?;
        let fields = VarStruct::read(body, header.body)?;
        let depth = |number| {
            let stored = fields.varuint(number);
            stored.filter(|stored| *stored < NO_DEPTH)
        };
        let beam = fields.structure(13);
        let tilt = beam.and_then(|beam| beam.structure(5)?.float(0));
        let stated_samples = fields.unsigned(7).unwrap_or(0);
        let has_shade = fields.unsigned(8).is_some_and(|shade| shade != 0);
        Some(Self {
            channel: fields.varuint(0),
            bottom: depth(1),
            range: [depth(3), depth(4)],
            place: fields.signed(9).zip(fields.signed(10)).map(<[i32; 2]>::from),
            beam: fields.varuint(12),
            tilt: tilt.filter(|tilt| tilt.is_finite()),
            stated_samples,
            samples: locate(fields.end, header.end(), stated_samples, has_shade),
        })
    }
}

/// Finds the samples between the fields and the end of a body. They are the last bytes of the body,
/// after additional bytes (a checksum) of some units, and before one byte of shade a sample where
/// the ping states shade. Samples have eight bits where there is only room for one byte a sample.
fn locate(from: usize, end: usize, count: u32, has_shade: bool) -> Option<StoredSamples> {
    let room = end.checked_sub(from)?;
    let samples = usize::try_from(count).ok().filter(|count| *count > 0)?;
    let wide = samples.checked_mul(2)?;
    let is_wide = room >= wide;
    let stored = if is_wide { wide } else { samples };
    let rest = room.checked_sub(stored)?;
    let shade = if has_shade && is_wide && rest >= samples { samples } else { 0 };
    Some(StoredSamples { offset: end - shade - stored, count, is_wide })
}

/// Calls `take` with the offset and the header of every whole record from `start` on; fails only if
/// cancelled.
pub(super) fn walk_records(
    walk: Walk<'_>,
    start: usize,
    mut take: impl FnMut(usize, &RecordHeader),
) -> Result<(), Cancelled> {
    let bytes = walk.bytes;
    walk.progress.walk(start, bytes.len(), |at| {
        let Some(header) = RecordHeader::read(bytes, at) else {
            return Ok(walk.over_gap(at, next_record(bytes, at + 1, bytes.len())));
        };
        let end = header.end();
        if let Some(next) = behind(bytes, end) {
            take(at, &header);
            return Ok(next);
        }
        // No record follows: the size in the header may be damaged.
        if let Some(found) = next_record(bytes, header.body, end) {
            return Ok(walk.over_long(at, end, found));
        }
        if end > bytes.len() {
            return Ok(walk.over_cut(at, "recording"));
        }
        take(at, &header);
        Ok(end)
    })
}

/// Returns the offset of the record after one that ends at `end`, if the bytes there confirm this
/// end: a trailer, which may be truncated, another record without a trailer between, or the end of
/// the file.
fn behind(bytes: &[u8], end: usize) -> Option<usize> {
    let len = bytes.len();
    let next = end.saturating_add(TRAILER);
    let is_record = |at| RecordHeader::read(bytes, at).is_some();
    let has_trailer = u32_le(bytes, end) == Some(TRAILER_MAGIC);
    if has_trailer || next == len || is_record(next) {
        Some(next.min(len)).filter(|_| end <= len)
    } else {
        (end == len || is_record(end)).then_some(end)
    }
}

/// Returns the offset of the first record header that begins in `from..to`: the magic number and
/// readable fields identify it.
pub(super) fn next_record(bytes: &[u8], from: usize, to: usize) -> Option<usize> {
    let to = to.min(bytes.len());
    let mut at = from;
    while at < to {
        let magic = at.checked_add(BEFORE_MAGIC)?;
        let searched = bytes.get(magic..)?;
        let mut windows = searched.windows(MAGIC.len()).take(to - at);
        let found = at + windows.position(|window| window == MAGIC)?;
        if RecordHeader::read(bytes, found).is_some() {
            return Some(found);
        }
        at = found + 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_found_at_both_widths_with_what_may_lie_around_them() {
        let found = |room: usize, count, has_shade| {
            let found = locate(100, 100 + room, count, has_shade);
            found.map(|found| (found.offset, found.is_wide))
        };
        assert_eq!(found(20, 10, false), Some((100, true)));
        // A checksum before the samples; one byte of shade a sample after them.
        assert_eq!(found(24, 10, false), Some((104, true)));
        assert_eq!(found(30, 10, true), Some((100, true)));
        assert_eq!(found(34, 10, true), Some((104, true)));
        // Shade is stated, but the body has no room for it.
        assert_eq!(found(20, 10, true), Some((100, true)));
        assert_eq!(found(10, 10, false), Some((100, false)));
        assert_eq!(found(14, 10, false), Some((104, false)));
        for (room, count) in [(9, 10), (20, 0), (20, u32::MAX), (0, 1)] {
            assert_eq!(found(room, count, false), None, "{count} in {room}");
        }
    }
}
