//! The SL3 frame header as it lies in the file.

use bytemuck::{Pod, Zeroable};

/// The first 128 bytes, little-endian. Channels 7 and 8 have no more; the others go on to 168 bytes
/// (frame version 13:
/// 180) with the offsets of the last frames, so the data begins `frame_size - packet` bytes after
///      the frame, never at a constant. Units as in [SL2](super::sl2::Header). Verified on files of
///      frame version 10.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Header {
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

const _: () = assert!(size_of::<Header>() == 128);
