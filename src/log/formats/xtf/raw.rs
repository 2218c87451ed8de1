//! Defines the records of an XTF file as stored: little-endian, packed (Triton's "eXtended Triton
//! Format"); and reads packet headers, with which a walk finds the next packet, and the date and
//! time of a ping.

use crate::formats::walk::MessageFormat;
use bytemuck::{Pod, Zeroable};
use chrono::NaiveDate;

/// Number at the beginning of every packet.
pub(super) const MAGIC: u16 = 0xFACE;
/// Limit of a packet's bytes; longer packets are damage.
const LONGEST_PACKET: usize = 1 << 24;

/// Marker and length of packets, with which a walk finds the next packet.
pub(super) const PACKETS: MessageFormat = MessageFormat {
    noun: "packet",
    marker: MAGIC.to_le_bytes(),
    length: |bytes, offset| header(bytes, offset).map(|packet| packet.size as usize),
};

/// Fields of the first 256 bytes of the file header; one [`ChannelInfo`] for each channel follows.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct FileHeader {
    /// Offset 0: always 0x7B.
    pub file_format: u8,
    /// 1: recorder's number for itself.
    pub system_type: u8,
    /// 2: name of the recording program.
    pub program: [u8; 8],
    /// 10: version of the recording program.
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
    pub rest_170: [u8; 34],
    /// 204: delay of positions, milliseconds.
    pub nav_latency_ms: i32,
    /// 208: not used here.
    pub rest_208: [u8; 8],
    /// 216: position of the antenna forward of the ship's reference point, metres.
    pub nav_offset_y_m: f32,
    /// 220: position of the antenna to starboard of the ship's reference point, metres.
    pub nav_offset_x_m: f32,
    /// 224: not used here.
    pub rest_224: [u8; 32],
}

/// Description of a channel, 128 bytes each, from byte 256 of the file header on.
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
    /// 8: number of samples in every ping, in files from before pings stated it; 1024 or 0 in later
    /// files.
    pub reserved: u32,
    /// 12: name of the channel.
    pub name: [u8; 16],
    /// 28: volts of full scale.
    pub volt_scale: f32,
    /// 32: frequency, kHz.
    pub frequency_khz: f32,
    /// 36: not used here: beam angles.
    pub rest_36: [u8; 12],
    /// 48: position of the transducer to starboard of the ship's reference point, metres.
    pub offset_x_m: f32,
    /// 52: position of the transducer forward of the ship's reference point, metres.
    pub offset_y_m: f32,
    /// 56: not used here.
    pub rest_56: [u8; 18],
    /// 74: format of samples: 0 old, by bytes a sample; 1 IBM float, 2 int32, 3 int16, 5 float, 8
    /// int8.
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
    /// 4: number of channels that follow in a ping.
    pub channels: u16,
    /// 6: reserved.
    pub reserved: [u16; 2],
    /// 10: bytes of the whole packet, the step to the next.
    pub size: u32,
}

/// First 256 bytes of a side-scan ping, with the packet header.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct PingHeader {
    /// Offset 0: packet header.
    pub packet: PacketHeader,
    /// 14: date and time to the second.
    pub time: PacketTime,
    /// 21: hundredths of a second.
    pub hundredths: u8,
    /// 22: day of the year.
    pub julian_day: u16,
    /// 24: number of the last event.
    pub event: u32,
    /// 28: number of the ping.
    pub ping_number: u32,
    /// 32: speed of sound, metres a second: about 1500, or about 750 where it is half of the speed,
    /// for two-way travel times.
    pub sound_velocity_mps: f32,
    /// 36: not used here.
    pub rest_36: [u8; 36],
    /// 72: speed of sound by conductivity, temperature and pressure, metres a second.
    pub computed_sound_velocity_mps: f32,
    /// 76: not used here.
    pub rest_76: [u8; 44],
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
    pub rest_176: [u8; 6],
    /// 182: length of cable paid out, metres.
    pub cable_out_m: u16,
    /// 184: horizontal distance from the ship to the towed sonar, metres.
    pub layback_m: f32,
    /// 188: not used here.
    pub rest_188: [u8; 4],
    /// 192: depth of the sonar below the water's surface, metres.
    pub sensor_depth_m: f32,
    /// 196: height of the sonar above the bottom, metres; 0 where unknown.
    pub sensor_altitude_m: f32,
    /// 200: height of the sonar above the bottom by another instrument, metres; 0 where unknown.
    pub sensor_aux_altitude_m: f32,
    /// 204: the sonar's pitch, degrees, positive with its nose up.
    pub sensor_pitch_deg: f32,
    /// 208: the sonar's roll, degrees, positive to starboard.
    pub sensor_roll_deg: f32,
    /// 212: the sonar's compass, degrees.
    pub sensor_heading_deg: f32,
    /// 216: not used here.
    pub rest_216: [u8; 8],
    /// 224: milliseconds for matching attitude packets: those of the day in most files.
    pub attitude_time_ms: u32,
    /// 228: not used here.
    pub rest_228: [u8; 28],
}

/// Header of 64 bytes before the samples of a channel in a ping.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct PingChannel {
    /// Offset 0: index of the channel.
    pub channel: u16,
    /// 2: method by which samples were thinned.
    pub downsample: u16,
    /// 4: slant range of the last sample, metres.
    pub slant_range_m: f32,
    /// 8: ground range of the last sample, metres.
    pub ground_range_m: f32,
    /// 12: time before the first sample, seconds.
    pub time_delay_s: f32,
    /// 16: recorded two-way travel time, seconds.
    pub time_duration_s: f32,
    /// 20: time from ping to ping, seconds.
    pub seconds_per_ping: f32,
    /// 24: method by which samples were processed.
    pub processing: u16,
    /// 26: frequency, kHz.
    pub frequency_khz: u16,
    /// 28: not used here.
    pub rest_28: [u8; 14],
    /// 42: number of samples that follow.
    pub samples: u32,
    /// 46: not used here.
    pub rest_46: [u8; 12],
    /// 58: weight; the samples of EdgeTech's and Kongsberg's sonars count 2^-weight.
    pub weight: i16,
    /// 60: not used here.
    pub rest_60: [u8; 4],
}

/// Position (packet type 42), with the time that its source states.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct NavigationPacket {
    /// Offset 0.
    pub packet: PacketHeader,
    /// 14: date and time to the second.
    pub time: PacketTime,
    /// 21: millionths of the second.
    pub microseconds: u32,
    /// 25: not used here.
    pub rest_25: [u8; 8],
    /// 33: latitude, or northing.
    pub y: f64,
    /// 41: longitude, or easting.
    pub x: f64,
    /// 49: not used here.
    pub rest_49: [u8; 15],
}

/// Position and attitude (packet type 107).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct RawNavigationPacket {
    /// Offset 0.
    pub packet: PacketHeader,
    /// 14: date and time to the second.
    pub time: PacketTime,
    /// 21: ten thousandths of the second.
    pub tenths_ms: u16,
    /// 23: latitude, or northing.
    pub y: f64,
    /// 31: longitude, or easting.
    pub x: f64,
    /// 39: not used here.
    pub rest_39: [u8; 20],
    /// 59: the ship's compass, degrees.
    pub heading_deg: f32,
    /// 63: not used here.
    pub rest_63: u8,
}

/// Compass (packet types 23 and 84).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct GyroPacket {
    /// Offset 0.
    pub packet: PacketHeader,
    /// 14: date and time to the second.
    pub time: PacketTime,
    /// 21: millionths of the second.
    pub microseconds: u32,
    /// 25: not used here.
    pub rest_25: [u8; 8],
    /// 33: the ship's compass, degrees.
    pub heading_deg: f32,
    /// 37: not used here.
    pub rest_37: [u8; 27],
}

/// Attitude (packet type 3).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct AttitudePacket {
    /// Offset 0.
    pub packet: PacketHeader,
    /// 14: not used here.
    pub rest_14: [u8; 20],
    /// 34: roll, degrees, positive to starboard.
    pub roll_deg: f32,
    /// 38: not used here.
    pub rest_38: [u8; 12],
    /// 50: the ship's compass, degrees; 0 when it is not known.
    pub heading_deg: f32,
    /// 54: date and time to the second.
    pub time: PacketTime,
    /// 61: thousandths of the second.
    pub milliseconds: u16,
    /// 63: not used here.
    pub rest_63: u8,
}

/// Date and time in packets.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, packed)]
pub(crate) struct PacketTime {
    /// Year, in full or with two digits.
    pub year: u16,
    /// Month, 1 to 12.
    pub month: u8,
    /// Day, 1 to 31.
    pub day: u8,
    /// Hour.
    pub hour: u8,
    /// Minute.
    pub minute: u8,
    /// Second.
    pub second: u8,
}

const _: () = assert!(size_of::<FileHeader>() == 256);
const _: () = assert!(size_of::<ChannelInfo>() == 128);
const _: () = assert!(size_of::<PacketHeader>() == 14);
const _: () = assert!(size_of::<PingHeader>() == 256);
const _: () = assert!(size_of::<PingChannel>() == 64);
const _: () = assert!(size_of::<NavigationPacket>() == 64);
const _: () = assert!(size_of::<RawNavigationPacket>() == 64);
const _: () = assert!(size_of::<GyroPacket>() == 64);
const _: () = assert!(size_of::<AttitudePacket>() == 64);

/// Reads a record from the bytes at `offset`; `None` past the end.
pub(super) fn record<T: Pod>(bytes: &[u8], offset: usize) -> Option<T> {
    let end = offset.checked_add(size_of::<T>())?;
    bytes.get(offset..end).map(bytemuck::pod_read_unaligned)
}

/// Returns the packet header at `offset`; `None` where there is no plausible one.
pub(super) fn header(bytes: &[u8], offset: usize) -> Option<PacketHeader> {
    let packet: PacketHeader = record(bytes, offset)?;
    let size = packet.size as usize;
    (packet.magic == MAGIC && (size_of::<PacketHeader>()..LONGEST_PACKET).contains(&size))
        .then_some(packet)
}

/// Returns the full year of a recorded year, which may have two digits or count from 1900 as C's
/// `tm_year` does.
fn year_meant(recorded: u16) -> i32 {
    match i32::from(recorded) {
        year @ 0..80 => 2000 + year,
        year @ 80..200 => 1900 + year,
        year => year,
    }
}

/// Returns the Unix seconds of a date and time; without a valid date, the seconds of the time of
/// day.
pub(super) fn seconds(time: PacketTime) -> i64 {
    let date = NaiveDate::from_ymd_opt(year_meant(time.year), time.month.into(), time.day.into());
    let days = date.map_or(0, |date| i64::from(date.to_epoch_days()));
    let minutes = i64::from(time.hour) * 60 + i64::from(time.minute);
    days * 86_400 + minutes * 60 + i64::from(time.second)
}

/// Returns the Unix milliseconds of a ping's date and time; without a valid date, as in
/// [`seconds`]. The time of day is in hundredths of a second; where the time for attitude packets
/// is the same moment of the day, its milliseconds are used too.
pub(super) fn unix_ms(ping: &PingHeader) -> i64 {
    let unix_ms = seconds(ping.time) * 1000 + i64::from(ping.hundredths) * 10;
    let day_ms = unix_ms.rem_euclid(86_400_000);
    let attitude_ms = i64::from(ping.attitude_time_ms);
    let is_same = attitude_ms / 10 == day_ms / 10;
    unix_ms + if is_same { attitude_ms - day_ms } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::clock::unix_s;
    use bytemuck::Zeroable;

    #[test]
    fn dates_become_unix_seconds() {
        let time = PacketTime { year: 2009, month: 11, day: 8, hour: 12, minute: 36, second: 34 };
        let mut ping = PingHeader { time, hundredths: 33, ..PingHeader::zeroed() };
        // `date -u -d "2009-11-08 12:36:34" +%s`
        assert_eq!(unix_ms(&ping), 1_257_683_794_330);
        // Milliseconds of the same moment of the day, and of another moment.
        ping.attitude_time_ms = 45_394_337;
        assert_eq!(unix_ms(&ping), 1_257_683_794_337);
        ping.attitude_time_ms = 45_394_340;
        assert_eq!(unix_ms(&ping), 1_257_683_794_330);
        ping.time = PacketTime { year: 2024, month: 2, day: 29, ..time };
        assert_eq!(unix_ms(&ping) / 1000, 1_709_210_194);
        ping.time = PacketTime { year: 1996, month: 7, day: 31, ..time };
        // `date -u -d "1996-07-31 12:36:34" +%s`
        assert_eq!(unix_s(unix_ms(&ping)), Some(838_816_594.33));
        for year in [200, 1970, 1979, 2101, u16::MAX] {
            ping.time.year = year;
            assert_eq!(unix_s(unix_ms(&ping)), None, "{year}");
        }
        for (year, meant) in [(96, 1996), (80, 1980), (0, 2000), (9, 2009), (109, 2009)] {
            let of = |year| {
                ping.time.year = year;
                unix_s(unix_ms(&ping))
            };
            let [recorded, meant] = [year, meant].map(of);
            assert!(recorded.is_some() && recorded == meant, "{year}");
        }
        // A date that was never set is not read as the first of January.
        ping.time = PacketTime { year: 0, month: 0, day: 0, ..time };
        assert_eq!(unix_s(unix_ms(&ping)), None);
    }
}
