//! A frame of either format, and how one is recognised.

use super::{sl2, sl3};
use crate::formats::scalar;
use crate::support::geo::METRES_PER_FOOT;

/// The two frame layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameLayout {
    /// 144-byte headers.
    Sl2,
    /// 128-, 168- or 180-byte headers.
    Sl3,
}

/// Channel number of depths across the track. The packet length in its headers is not that of the
/// data.
pub(super) const STRUCTURE_SCAN_3D: u16 = 9;
/// No channel number above this was ever seen; a header with one is not a header.
const LAST_CHANNEL: u16 = 31;
/// No header is longer than this.
const LONGEST_HEADER: usize = 256;

/// Fields of a frame that Bathyscope uses, still in the recorder's units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LowranceFrame {
    /// Offset of the frame.
    pub offset: usize,
    /// Header and data.
    pub size: usize,
    /// Offset of the echo data.
    pub data_offset: usize,
    /// Bytes of echo data.
    pub data_len: usize,
    /// Channel number.
    pub channel: u16,
    /// Near limit of the range, feet.
    pub min_range_ft: f32,
    /// Far limit of the range, feet.
    pub max_range_ft: f32,
    /// Frequency code.
    pub frequency: u16,
    /// Unix seconds or a millisecond count.
    pub clock: u32,
    /// Water depth, feet.
    pub depth_ft: f32,
    /// Keel offset, feet; 0 where the layout has none.
    pub keel_ft: f32,
    /// Speed over ground, knots.
    pub speed_kn: f32,
    /// East, Mercator metres.
    pub x_m: i32,
    /// North, Mercator metres.
    pub y_m: i32,
    /// Course over ground, radians.
    pub course_rad: f32,
    /// Compass heading, radians.
    pub heading_rad: f32,
    /// Milliseconds since the log's time zero.
    pub time_ms: i32,
}

/// Result of looking for a frame at an offset.
#[derive(Debug)]
pub(crate) enum FrameCheck {
    /// A whole frame.
    Whole(LowranceFrame),
    /// A frame header whose data goes on behind the end of the file.
    Cut,
    /// No frame header.
    Nothing,
}

impl FrameLayout {
    /// The shortest header of the layout.
    pub(crate) fn shortest_header(self) -> usize {
        match self {
            FrameLayout::Sl2 => size_of::<sl2::Header>(),
            FrameLayout::Sl3 => size_of::<sl3::Header>(),
        }
    }

    /// Looks for a frame at `offset`. `lost` is the number of bytes lost from the file before it:
    /// the frame states where it was before they were.
    pub(crate) fn look(self, bytes: &[u8], offset: usize, lost: i64) -> FrameCheck {
        if lost_before(bytes, offset) != Some(lost) {
            return FrameCheck::Nothing;
        }
        let header =
            offset.checked_add(self.shortest_header()).and_then(|end| bytes.get(offset..end));
        let Some(header) = header else {
            return FrameCheck::Cut;
        };
        let frame = match self {
            FrameLayout::Sl2 => from_sl2(offset, &bytemuck::pod_read_unaligned(header)),
            FrameLayout::Sl3 => from_sl3(offset, &bytemuck::pod_read_unaligned(header)),
        };
        if frame.size < self.shortest_header() || frame.channel > LAST_CHANNEL {
            return FrameCheck::Nothing;
        }
        if offset + frame.size > bytes.len() {
            return FrameCheck::Cut;
        }
        FrameCheck::Whole(frame)
    }
}

/// Number of bytes that were lost before `offset` (negative: came in) if a frame begins there; the
/// recorders count in 32 bits and start again beyond 4 GiB.
pub(super) fn lost_before(bytes: &[u8], offset: usize) -> Option<i64> {
    let stated = scalar::u32_le(bytes, offset)?;
    Some(i64::from(stated.wrapping_sub(offset as u32).cast_signed()))
}

/// Returns the offset of the data in a frame: behind the header, whose length is the frame's size
/// less the packet's, where that is a length a header can have.
fn data_start(size: usize, packet: usize, shortest: usize, usual: usize) -> usize {
    let stated = size.saturating_sub(packet);
    if (shortest..=LONGEST_HEADER).contains(&stated) { stated } else { usual.min(size) }
}

fn from_sl2(offset: usize, header: &sl2::Header) -> LowranceFrame {
    let size = usize::from(header.frame_size);
    let start = data_start(size, usize::from(header.packet), 144, 144);
    LowranceFrame {
        offset,
        size,
        data_offset: offset + start,
        data_len: size - start,
        channel: header.channel,
        min_range_ft: header.min_range_ft,
        max_range_ft: header.max_range_ft,
        frequency: u16::from(header.frequency),
        clock: header.clock,
        depth_ft: header.depth_ft,
        keel_ft: header.keel_ft,
        speed_kn: header.gps_speed_kn,
        x_m: header.x_m,
        y_m: header.y_m,
        course_rad: header.course_rad,
        heading_rad: header.heading_rad,
        time_ms: header.time_ms,
    }
}

fn from_sl3(offset: usize, header: &sl3::Header) -> LowranceFrame {
    let size = usize::from(header.frame_size);
    let usual = match (header.channel, header.frame_version) {
        (7 | 8, _) => 128,
        (_, 13) => 180,
        _ => 168,
    };
    let start = match header.channel {
        STRUCTURE_SCAN_3D => usual.min(size),
        _ => data_start(size, header.packet as usize, 128, usual),
    };
    LowranceFrame {
        offset,
        size,
        data_offset: offset + start,
        data_len: size - start,
        channel: header.channel,
        min_range_ft: header.min_range_ft,
        max_range_ft: header.max_range_ft,
        frequency: header.frequency,
        clock: header.clock,
        depth_ft: header.depth_ft,
        keel_ft: 0.0,
        speed_kn: header.gps_speed_kn,
        x_m: header.x_m,
        y_m: header.y_m,
        course_rad: header.course_rad,
        heading_rad: header.heading_rad,
        time_ms: header.time_ms,
    }
}

/// Feet, as a frame has them, in metres.
pub(super) fn metres(feet: f32) -> f32 {
    (f64::from(feet) * METRES_PER_FOOT) as f32
}
