//! Reads ping headers of a SON file, which are tags and values between a magic number and an end
//! tag, and walks from ping to ping. The IDX file beside it is not needed: magic numbers and
//! lengths are sufficient.

use crate::formats::ByteOrder;
use crate::formats::collected::WarningKind;
use crate::formats::scalar::take;
use crate::formats::walk::Walk;
use crate::support::progress::Cancelled;

/// First bytes of every ping, on all units.
const MAGIC: [u8; 4] = [0xC0, 0xDE, 0xAB, 0x21];
/// The tag that ends the header.
const END: u8 = 0x21;
/// First tag with a value of four bytes; lower tags have a value of one byte.
const FIRST_WIDE_TAG: u8 = 0x80;
/// Most tags of a header; more are damage. Headers of the units seen have 67, 72 or 152 bytes.
const MOST_TAGS: usize = 100;
/// Most plausible samples of a ping.
const MOST_SAMPLES: u32 = 1 << 16;
/// Bytes in which the first pings of a file are searched.
const SEARCHED_FOR_PINGS: usize = 1 << 20;

/// Values of a ping header that Bathyscope uses. The length of the header differs between units;
/// the tags do not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PingHeader {
    /// Tag 81: milliseconds since the recording's start.
    pub time_ms: u32,
    /// Tag 82: east, metres of a Mercator projection on the International 1924 sphere.
    pub easting_m: i32,
    /// Tag 83: north, in the same projection.
    pub northing_m: i32,
    /// Tag 84, first half: 0 when the heading is not valid.
    pub heading_quality: u16,
    /// Tag 84, second half: heading, tenths of a degree.
    pub heading_decideg: u16,
    /// Tag 85, first half: 0 when the speed is not valid.
    pub speed_quality: u16,
    /// Tag 85, second half: speed, tenths of a metre a second.
    pub speed_dmps: u16,
    /// Tag 87: depth, tenths of a metre; 0 when there is no bottom lock.
    pub depth_dm: u32,
    /// Tag 50: 0 and 1 down sonar (low, high), 2 port, 3 starboard, 4 down-imaging; `None` without
    /// the tag.
    pub beam: Option<u8>,
    /// Tag 92: frequency, Hz.
    pub frequency_hz: u32,
    /// Tag A0: number of one-byte samples after the header.
    pub sample_count: u32,
    /// Bytes from the magic number to the first sample.
    pub header_len: usize,
}

impl PingHeader {
    /// Reads the header that begins at `offset`; `None` where there is none, or it states no
    /// samples.
    pub(crate) fn parse(bytes: &[u8], offset: usize, order: ByteOrder) -> Option<Self> {
        if take(bytes, offset)? != MAGIC {
            return None;
        }
        let mut header = Self::default();
        let mut at = offset + MAGIC.len();
        for _ in 0..MOST_TAGS {
            let tag = *bytes.get(at)?;
            at += 1;
            if tag == END {
                header.header_len = at - offset;
                return (header.sample_count > 0).then_some(header);
            }
            if tag < FIRST_WIDE_TAG {
                let value = *bytes.get(at)?;
                if tag == 0x50 {
                    header.beam = Some(value);
                }
                at += 1;
            } else {
                header.wide(tag, order.u32(take(bytes, at)?));
                at += 4;
            }
        }
        None
    }

    /// Returns the bytes of header and samples together.
    pub(crate) fn size(&self) -> usize {
        self.header_len + self.sample_count as usize
    }

    fn wide(&mut self, tag: u8, value: u32) {
        let halves = ((value >> 16) as u16, value as u16);
        match tag {
            0x81 => self.time_ms = value,
            0x82 => self.easting_m = value.cast_signed(),
            0x83 => self.northing_m = value.cast_signed(),
            0x84 => (self.heading_quality, self.heading_decideg) = halves,
            0x85 => (self.speed_quality, self.speed_dmps) = halves,
            0x87 => self.depth_dm = value,
            0x92 => self.frequency_hz = value,
            0xA0 if value <= MOST_SAMPLES => self.sample_count = value,
            _ => {}
        }
    }
}

/// Returns the byte order of a file's numbers: the order in which the length of a ping leads to the
/// next ping. `None` where there is no ping in the first megabyte.
pub(super) fn byte_order(bytes: &[u8]) -> Option<ByteOrder> {
    let until = bytes.len().min(SEARCHED_FOR_PINGS);
    let mut fallback = None;
    let mut at = 0;
    while let Some(offset) = next_magic(bytes, at).filter(|&offset| offset < until) {
        for order in [ByteOrder::Big, ByteOrder::Little] {
            if let Some(ping) = PingHeader::parse(bytes, offset, order) {
                let next = offset + ping.size();
                if bytes.get(next..next + MAGIC.len()) == Some(&MAGIC) || next == bytes.len() {
                    return Some(order);
                }
                fallback = fallback.or(Some(order));
            }
        }
        at = offset + 1;
    }
    fallback
}

/// Calls `take` with the offset and the header of every whole ping of a file, beginning at or after
/// `from` if it is given; fails only if cancelled.
pub(super) fn walk_pings(
    walk: Walk<'_>,
    order: ByteOrder,
    from: Option<usize>,
    mut take: impl FnMut(usize, PingHeader),
) -> Result<(), Cancelled> {
    let (bytes, len) = (walk.bytes, walk.bytes.len());
    let start = from.map_or(0, |from| next_magic(bytes, from).unwrap_or(len));
    walk.progress.advance(start as u64);
    walk.progress.walk(start, len, |at| {
        let Some(ping) = PingHeader::parse(bytes, at, order) else {
            return Ok(walk.over_gap(at, next_magic(bytes, at + 1)));
        };
        let next = at.saturating_add(ping.size());
        if next == len || bytes.get(next..next + MAGIC.len()) == Some(&MAGIC) {
            take(at, ping);
            return Ok(next);
        }
        // No ping follows: the sample count may be damaged.
        let inside = next_magic(bytes, at + ping.header_len).filter(|&found| found < next);
        if let Some(found) = inside {
            let text = format!(
                "a ping says that it has {} samples, but the next begins after {}; it was dropped",
                ping.sample_count,
                found - at - ping.header_len
            );
            walk.report.at(WarningKind::Frame, walk.file, at, text);
            return Ok(found);
        }
        if next > len {
            return Ok(walk.over_cut(at, "recording"));
        }
        take(at, ping);
        Ok(next)
    })
}

/// Returns the offset of the first magic number at or after `from`.
fn next_magic(bytes: &[u8], from: usize) -> Option<usize> {
    let searched = bytes.get(from..)?;
    searched.windows(4).position(|window| window == MAGIC).map(|at| from + at)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Header of the first port ping of the USGS river survey, byte for byte, and two samples.
    const PORT: [u8; 69] = *b"\xc0\xde\xab\x21\x80\x00\x00\x00\x01\x81\x00\x00\x00\x00\x82\xff\x42\x93\x09\
        \x83\x00\x43\x16\x6c\x84\x00\x01\x07\xb9\x85\x00\x01\x00\x1b\x87\x00\x00\x00\x12\x50\x02\x51\x0a\
        \x92\x00\x06\xf1\x58\x53\x07\x54\x01\x95\x00\x00\x00\x1a\x56\x76\x57\x8b\xa0\x00\x00\x05\xc7\x21\xff\xff";

    #[test]
    fn a_real_header_is_read() {
        let header = PingHeader::parse(&PORT, 0, ByteOrder::Big).unwrap();
        assert_eq!(header.header_len, 67);
        assert_eq!(header.sample_count, 1479);
        assert_eq!((header.easting_m, header.northing_m), (-12_414_199, 4_396_652));
        assert_eq!((header.heading_quality, header.heading_decideg), (1, 1977));
        assert_eq!((header.speed_quality, header.speed_dmps), (1, 27));
        assert_eq!((header.depth_dm, header.beam), (18, Some(2)));
        assert_eq!(header.frequency_hz, 455_000);
    }

    #[test]
    fn longer_headers_and_unknown_tags_are_read_over() {
        let mut longer = PORT[..34].to_vec();
        longer.extend_from_slice(&[0x86, 1, 2, 3, 4]);
        longer.extend_from_slice(&PORT[34..]);
        let header = PingHeader::parse(&longer, 0, ByteOrder::Big).unwrap();
        assert_eq!((header.header_len, header.depth_dm, header.sample_count), (72, 18, 1479));
    }

    #[test]
    fn the_longest_header_has_all_tags() {
        // All tags that PINGVerter lists for headers of 152 bytes.
        let mut ping = MAGIC.to_vec();
        let wide = |ping: &mut Vec<u8>, tag: u8, value: u32| {
            ping.push(tag);
            ping.extend(value.to_be_bytes());
        };
        for tag in 0x80..=0x8F {
            wide(&mut ping, tag, if tag == 0x87 { 18 } else { 0x2121_2121 });
        }
        ping.extend([0x50, 3, 0x51, 10]);
        wide(&mut ping, 0x92, 1_200_000);
        ping.extend([0x53, 0x21, 0x54, 0x21]);
        wide(&mut ping, 0x95, 0x21);
        ping.extend([0x56, 0x21, 0x57, 0x21]);
        for tag in 0x98..=0x9F {
            wide(&mut ping, tag, 0x2121_2121);
        }
        wide(&mut ping, 0xA0, 900);
        ping.push(END);
        assert_eq!(ping.len(), 152);
        let header = PingHeader::parse(&ping, 0, ByteOrder::Big).unwrap();
        assert_eq!((header.header_len, header.sample_count), (152, 900));
        assert_eq!((header.depth_dm, header.beam), (18, Some(3)));
        assert_eq!(header.frequency_hz, 1_200_000);
    }

    #[test]
    fn cut_headers_are_none() {
        for len in 0..67 {
            assert_eq!(PingHeader::parse(&PORT[..len], 0, ByteOrder::Big), None);
        }
    }
}
