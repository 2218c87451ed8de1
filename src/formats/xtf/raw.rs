//! The records of an XTF file as they lie in it: little-endian, packed (Triton's "eXtended Triton Format").

use bytemuck::{Pod, Zeroable};

/// The fields used of the first 256 bytes of the file header; one [`ChannelInfo`] a channel follows.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct FileHeader {
    /// Offset 0: always 0x7B.
    pub file_format: u8,
    /// 1: recorder's number for itself.
    pub system_type: u8,
    /// 2: name of the recording program.
    pub program: [u8; 8],
    /// 10: its version.
    pub program_version: [u8; 8],
    /// 18: name of the sonar.
    pub sonar_name: [u8; 16],
    /// 34: number of the sonar's type.
    pub sonar_type: u16,
    /// 36: notes.
    pub note: [u8; 64],
    /// 100: name of the file when it was recorded.
    pub file_name: [u8; 64],
    /// 164: 0 projected metres (the zone is not stored), 3 degrees.
    pub nav_units: u16,
    /// 166: side-scan and sub-bottom channels.
    pub sonar_channels: u16,
    /// 168: bathymetry channels.
    pub bathymetry_channels: u16,
    /// 170: not used here.
    pub rest: [u8; 86],
}

/// What a channel is; 128 bytes each from byte 256 of the file header on.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct ChannelInfo {
    /// Offset 0: 0 sub-bottom, 1 port, 2 starboard, 3 bathymetry.
    pub kind: u8,
    /// 1: the channel's number in ping records.
    pub number: u8,
    /// 2: 1 slant range, 2 corrected to ground range.
    pub correction: u16,
    /// 4: 0 signed samples, 1 unsigned.
    pub unipolar: u16,
    /// 6: bytes a sample.
    pub bytes_per_sample: u16,
    /// 8: reserved.
    pub reserved: u32,
    /// 12: name in words.
    pub name: [u8; 16],
    /// 28: volts of full scale.
    pub volt_scale: f32,
    /// 32: frequency, kHz.
    pub frequency_khz: f32,
    /// 36: not used here: beam angles, offsets of the transducer.
    pub rest_36: [u8; 38],
    /// 74: 0 old, by bytes a sample; 1 IBM float, 2 int32, 3 int16, 5 float, 8 int8.
    pub sample_format: u8,
    /// 75: not used here.
    pub rest_75: [u8; 53],
}

/// The first 14 bytes of every packet.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct PacketHeader {
    /// Offset 0: 0xFACE.
    pub magic: u16,
    /// 2: 0 side-scan ping, 2 bathymetry, 3 attitude, others by vendor.
    pub kind: u8,
    /// 3: not used here.
    pub sub_channel: u8,
    /// 4: channels that follow in a ping.
    pub channels: u16,
    /// 6: reserved.
    pub reserved: [u16; 2],
    /// 10: the whole packet; the step to the next.
    pub size: u32,
}

/// The 256 bytes that a side-scan ping begins with, packet header included.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct PingHeader {
    /// Offset 0.
    pub packet: PacketHeader,
    /// 14: date and time of the ping.
    pub year: u16,
    /// 16: 1 to 12.
    pub month: u8,
    /// 17: 1 to 31.
    pub day: u8,
    /// 18: hour.
    pub hour: u8,
    /// 19: minute.
    pub minute: u8,
    /// 20: second.
    pub second: u8,
    /// 21: hundredths of a second.
    pub hundredths: u8,
    /// 22: not used here.
    pub rest_22: [u8; 6],
    /// 28: number of the ping.
    pub ping_number: u32,
    /// 32: one-way speed of sound, metres a second: half of 1500 as a rule.
    pub sound_velocity_mps: f32,
    /// 36: not used here.
    pub rest_36: [u8; 84],
    /// 120: the ship's speed, knots.
    pub ship_speed_kn: f32,
    /// 124: the ship's compass, degrees.
    pub ship_gyro_deg: f32,
    /// 128: the ship's latitude, or northing.
    pub ship_y: f64,
    /// 136: the ship's longitude, or easting.
    pub ship_x: f64,
    /// 144: not used here.
    pub rest_144: [u8; 8],
    /// 152: the sonar's speed, knots.
    pub sensor_speed_kn: f32,
    /// 156: not used here.
    pub rest_156: [u8; 4],
    /// 160: the sonar's latitude, or northing.
    pub sensor_y: f64,
    /// 168: the sonar's longitude, or easting.
    pub sensor_x: f64,
    /// 176: not used here.
    pub rest_176: [u8; 20],
    /// 196: height of the sonar above the bottom, metres; 0 when it is not known.
    pub sensor_altitude_m: f32,
    /// 200: not used here.
    pub rest_200: [u8; 12],
    /// 212: the sonar's compass, degrees.
    pub sensor_heading_deg: f32,
    /// 216: not used here.
    pub rest_216: [u8; 8],
    /// 224: milliseconds, by which attitude packets are matched: those of the day in most files.
    pub attitude_time_ms: u32,
    /// 228: not used here.
    pub rest_228: [u8; 28],
}

/// The 64 bytes before the samples of a channel in a ping.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct PingChannel {
    /// Offset 0: index of the channel.
    pub channel: u16,
    /// 2: how samples were thinned.
    pub downsample: u16,
    /// 4: slant range of the last sample, metres.
    pub slant_range_m: f32,
    /// 8: ground range of the last sample, metres.
    pub ground_range_m: f32,
    /// 12: time before the first sample, seconds.
    pub time_delay_s: f32,
    /// 16: time recorded, seconds (there and back).
    pub time_duration_s: f32,
    /// 20: time from ping to ping, seconds.
    pub ping_interval_s: f32,
    /// 24: not used here.
    pub rest_24: [u8; 2],
    /// 26: frequency, kHz.
    pub frequency_khz: u16,
    /// 28: not used here.
    pub rest_28: [u8; 14],
    /// 42: samples that follow.
    pub samples: u32,
    /// 46: not used here.
    pub rest_46: [u8; 18],
}

const _: () = assert!(size_of::<FileHeader>() == 256);
const _: () = assert!(size_of::<ChannelInfo>() == 128);
const _: () = assert!(size_of::<PacketHeader>() == 14);
const _: () = assert!(size_of::<PingHeader>() == 256);
const _: () = assert!(size_of::<PingChannel>() == 64);

/// Lays a record over the bytes at `offset`; `None` past the end.
pub(super) fn record<T: Pod>(bytes: &[u8], offset: usize) -> Option<T> {
    let end = offset.checked_add(size_of::<T>())?;
    bytes.get(offset..end).map(bytemuck::pod_read_unaligned)
}
