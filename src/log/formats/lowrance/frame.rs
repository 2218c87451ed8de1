//! Frames of both formats: their headers as they lie in the file, and how one is recognised.

use crate::formats::scalar;
use crate::support::geo::METRES_PER_FOOT;
use bytemuck::{Pod, Zeroable};

/// Channel number of depths across the track. The packet length in its headers is not that of the
/// data.
pub(super) const STRUCTURE_SCAN_3D: u16 = 9;
/// No channel number above this was ever seen; a header with one is not a header.
const LAST_CHANNEL: u16 = 31;
/// No header is longer than this.
const LONGEST_HEADER: usize = 256;

/// The two frame layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameLayout {
    /// 144-byte headers.
    Sl2,
    /// 128-, 168- or 180-byte headers.
    Sl3,
}

/// The SL2 frame header as it lies in the file: 144 bytes, little-endian, then `packet` bytes of
/// echo, one byte a sample. Ranges and depths are in feet, speeds in knots, angles in radians
/// clockwise from north. Verified on files of format versions 0 and 1; every offset of the older
/// public tables is 2 too small (they count the file header as 10 bytes).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Sl2Header {
    /// Offset 0: this frame's own offset in the file; the key for finding frames again after
    /// damage.
    pub own_offset: u32,
    /// 4: offsets of the last primary, secondary, down-scan, left, right and composite frame.
    pub last_offsets: [u32; 6],
    /// 28: header and data together; the step to the next frame.
    pub frame_size: u16,
    /// 30: size of the frame before.
    pub previous_size: u16,
    /// 32: 0 primary, 1 secondary, 2 down-scan, 3 left, 4 right, 5 composite side-scan.
    pub channel: u16,
    /// 34: bytes of echo data.
    pub packet: u16,
    /// 36: frame number in its channel.
    pub index: u32,
    /// 40: near limit of the range; minus the far one on composite side-scan.
    pub min_range_ft: f32,
    /// 44: far limit of the range.
    pub max_range_ft: f32,
    /// 48: unknown.
    pub unknown_48: [u8; 5],
    /// 53: frequency code (older tables say 50: wrong on real files).
    pub frequency: u8,
    /// 54: unknown.
    pub unknown_54: [u8; 6],
    /// 60: Unix seconds in the first frame, 0xFFFFFFFF without GPS time; a millisecond count later.
    pub clock: u32,
    /// 64: water depth.
    pub depth_ft: f32,
    /// 68: keel offset that the depth includes.
    pub keel_ft: f32,
    /// 72: unknown.
    pub unknown_72: [u8; 8],
    /// 80: four times -1.0 on every file seen.
    pub minus_ones: [f32; 4],
    /// 96: unknown.
    pub unknown_96: [u8; 4],
    /// 100: speed over ground by GPS.
    pub gps_speed_kn: f32,
    /// 104: water temperature, degrees Celsius.
    pub temperature_c: f32,
    /// 108: east, metres of Lowrance's Mercator. Signed: read unsigned, the western hemisphere
    /// breaks.
    pub x_m: i32,
    /// 112: north, metres of Lowrance's Mercator. Signed.
    pub y_m: i32,
    /// 116: speed through the water.
    pub water_speed_kn: f32,
    /// 120: course over ground.
    pub course_rad: f32,
    /// 124: GPS altitude.
    pub altitude_ft: f32,
    /// 128: compass heading; 0 without a compass.
    pub heading_rad: f32,
    /// 132: which values are fresh in this frame; older units fill the others with the last ones
    /// known.
    pub flags: u16,
    /// 134: unknown.
    pub unknown_134: [u8; 6],
    /// 140: milliseconds since the log (older units: the unit) was started. Signed.
    pub time_ms: i32,
}

const _: () = assert!(size_of::<Sl2Header>() == 144);

/// The SL3 frame header as it lies in the file: the first 128 bytes, little-endian. Channels 7 and
/// 8 have no more; the others go on to 168 bytes (180 in frame version 13) with the offsets of the
/// last frames, so the data begins `frame_size - packet` bytes after the frame, never at a
/// constant. Units as in [SL2](Sl2Header). Verified on files of frame version 10.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Sl3Header {
    /// Offset 0: this frame's own offset in the file.
    pub own_offset: u32,
    /// 4: version of the frame layout; 10 seen, 13 known.
    pub frame_version: u32,
    /// 8: header and data together; the step to the next frame.
    pub frame_size: u16,
    /// 10: size of the frame before.
    pub previous_size: u16,
    /// 12: as in SL2; 7 and 8 are raw products of the down sonar, 9 is 3D, 10 and 11 are the
    /// recorder's own.
    pub channel: u16,
    /// 14: unknown.
    pub unknown_14: [u8; 2],
    /// 16: frame number in its channel.
    pub index: u32,
    /// 20: near limit of the range; minus the far one on composite side-scan.
    pub min_range_ft: f32,
    /// 24: far limit of the range.
    pub max_range_ft: f32,
    /// 28: unknown.
    pub unknown_28: [u8; 12],
    /// 40: Unix seconds in frame 0 of every channel; a millisecond count later.
    pub clock: u32,
    /// 44: bytes of echo data. On channel 9 of some units it is not: step by `frame_size`.
    pub packet: u32,
    /// 48: water depth; 0 on channels that do not know it.
    pub depth_ft: f32,
    /// 52: frequency code.
    pub frequency: u16,
    /// 54: unknown; holds the four -1.0 of SL2 at 64.
    pub unknown_54: [u8; 30],
    /// 84: speed over ground by GPS.
    pub gps_speed_kn: f32,
    /// 88: water temperature, degrees Celsius.
    pub temperature_c: f32,
    /// 92: east, metres of Lowrance's Mercator. Signed.
    pub x_m: i32,
    /// 96: north, metres of Lowrance's Mercator. Signed.
    pub y_m: i32,
    /// 100: speed through the water.
    pub water_speed_kn: f32,
    /// 104: course over ground.
    pub course_rad: f32,
    /// 108: GPS altitude.
    pub altitude_ft: f32,
    /// 112: compass heading; 0 without a compass.
    pub heading_rad: f32,
    /// 116: which values are fresh in this frame.
    pub flags: u16,
    /// 118: unknown.
    pub unknown_118: [u8; 6],
    /// 124: milliseconds since the log was started. Signed: real files begin up to half a second
    /// before zero.
    pub time_ms: i32,
}

const _: () = assert!(size_of::<Sl3Header>() == 128);

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
            FrameLayout::Sl2 => size_of::<Sl2Header>(),
            FrameLayout::Sl3 => size_of::<Sl3Header>(),
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

fn from_sl2(offset: usize, header: &Sl2Header) -> LowranceFrame {
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

fn from_sl3(offset: usize, header: &Sl3Header) -> LowranceFrame {
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
