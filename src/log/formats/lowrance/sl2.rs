//! The SL2 frame header as it lies in the file.

use bytemuck::{Pod, Zeroable};

/// 144 bytes, little-endian, then `packet` bytes of echo, one byte a sample. Ranges and depths are
/// in feet, speeds in knots, angles in radians clockwise from north. Verified on files of format
/// versions 0 and 1; every offset of the older public tables is 2 too small (they count the file
/// header as 10 bytes).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Header {
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

const _: () = assert!(size_of::<Header>() == 144);
