//! Tests that generated XTF files, whole, damaged and growing, are read as they were written.

mod damage;
mod multibeam;
mod places;
mod samples;

use super::raw::{ChannelInfo, FileHeader, PacketHeader, PacketTime, PingChannel, PingHeader};
use crate::formats::test_logs::{outward, says};
use crate::formats::{self, OpenError};
use crate::support::geo::LonLat;
use crate::support::progress::Progress;
use crate::survey::{Side, Survey};
use bytemuck::{Zeroable as _, bytes_of};

/// Number of samples of a side of a ping.
const SAMPLES: usize = 200;
/// Position of the first ping.
const START: LonLat = LonLat::new(11.5, 48.1);

/// Description of a file to write: pings of all channels, ten a second from noon on.
#[derive(Clone)]
struct Xtf {
    pings: usize,
    header: fn(&mut FileHeader),
    /// Kind and frequency (kHz) of each channel.
    channels: Vec<(u8, f32)>,
    /// Bytes of a sample, format, and true if samples are unsigned.
    stored: (u16, u8, bool),
    /// Bytes of a sample of a ping in the file.
    sample: fn(usize, usize) -> Vec<u8>,
    ping: fn(usize, &mut PingHeader),
    side: fn(usize, &mut PingChannel),
    /// Bytes of the packets before a ping.
    before: fn(usize) -> Vec<u8>,
}

/// Returns the value of a sample, which has 12 bits, so that four are dropped.
fn value(sample: usize) -> u32 {
    sample as u32 * 20
}

fn expected() -> Vec<u8> {
    (0..SAMPLES).map(|sample| (value(sample) >> 4) as u8).collect()
}

impl Default for Xtf {
    fn default() -> Self {
        Self {
            pings: 40,
            header: |_| (),
            channels: vec![(1, 0.0), (2, 0.0)],
            stored: (2, 0, true),
            sample: |_, sample| (value(sample) as u16).to_le_bytes().to_vec(),
            ping: |index, ping| {
                (ping.sensor_x, ping.sensor_y) = (START.lon_deg, latitude(index));
            },
            side: |_, side| side.slant_range_m = 25.0,
            before: |_| Vec::new(),
        }
    }
}

/// Returns the latitude of a ping: half a metre further north with each ping.
fn latitude(index: usize) -> f64 {
    START.lat_deg + index as f64 * 4.5e-6
}

/// Returns the packet header of a record of `size` bytes.
fn packet(kind: u8, size: usize) -> PacketHeader {
    PacketHeader { magic: 0xFACE, kind, size: size as u32, ..PacketHeader::zeroed() }
}

/// Returns the time of a ping, and the hundredths of its second.
fn time(index: usize) -> (PacketTime, u8) {
    let time = PacketTime {
        year: 2020,
        month: 6,
        day: 1,
        hour: 12,
        minute: (index / 600) as u8,
        second: (index / 10 % 60) as u8,
    };
    (time, (index % 10 * 10) as u8)
}

fn written(file: &Xtf) -> Vec<u8> {
    let mut header = FileHeader {
        file_format: 0x7B,
        nav_units: 3,
        sonar_channels: file.channels.len() as u16,
        ..FileHeader::zeroed()
    };
    (file.header)(&mut header);
    let mut bytes = bytes_of(&header).to_vec();
    let (width, format, is_unipolar) = file.stored;
    for (number, &(kind, frequency_khz)) in file.channels.iter().enumerate() {
        bytes.extend(bytes_of(&ChannelInfo {
            kind,
            number: number as u8,
            unipolar: is_unipolar.into(),
            bytes_per_sample: width,
            reserved: SAMPLES as u32,
            frequency_khz,
            sample_format: format,
            ..ChannelInfo::zeroed()
        }));
    }
    bytes.resize(1024, 0);
    for index in 0..file.pings {
        bytes.extend((file.before)(index));
        bytes.extend(ping(file, index));
    }
    bytes
}

fn ping(file: &Xtf, index: usize) -> Vec<u8> {
    let side_len = size_of::<PingChannel>() + SAMPLES * usize::from(file.stored.0);
    let size = size_of::<PingHeader>() + file.channels.len() * side_len;
    let (time, hundredths) = time(index);
    let mut header = PingHeader {
        packet: PacketHeader { channels: file.channels.len() as u16, ..packet(0, size) },
        time,
        hundredths,
        sensor_heading_deg: 90.0,
        ..PingHeader::zeroed()
    };
    (file.ping)(index, &mut header);
    let mut bytes = bytes_of(&header).to_vec();
    for (number, (kind, _)) in file.channels.iter().enumerate() {
        let mut side = PingChannel {
            channel: number as u16,
            samples: SAMPLES as u32,
            ..PingChannel::zeroed()
        };
        (file.side)(index, &mut side);
        bytes.extend(bytes_of(&side));
        for sample in 0..SAMPLES {
            // Port is stored from far to near.
            let sample = if *kind == 1 { SAMPLES - 1 - sample } else { sample };
            bytes.extend((file.sample)(index, sample));
        }
    }
    bytes
}

fn open(bytes: Vec<u8>) -> Result<Survey, OpenError> {
    formats::open_bytes("pond.xtf", bytes, &Progress::new())
}

fn read(file: &Xtf) -> Survey {
    open(written(file)).unwrap_or_else(|error| panic!("{error}"))
}
