//! Writes a simulated survey as Lowrance SL2: an 8-byte file header, then frames: the reader's own [`Header`] and the echo
//! bytes, all little-endian.

use crate::formats::lowrance::sl2::Header;
use crate::support::geo::{METRES_PER_FOOT, MPS_PER_KNOT};
use bytemuck::Zeroable as _;
use std::io::{self, Write};

/// Header of the file: format 2 (SL2), version 1, block size 3200 (a side-scan unit).
const FILE_HEADER: [u8; 8] = [2, 0, 1, 0, 0x80, 0x0c, 0, 0];
/// Flags of a frame with a fresh fix: speed, temperature, packet, position, course, altitude.
const FRESH: u16 = 0x0002 | 0x0004 | 0x0008 | 0x0010 | 0x0080 | 0x0200;
/// Flag of a frame with a compass heading.
const HEADING: u16 = 0x0100;
/// Flags of a frame that repeats the last fix.
const REPEATED: u16 = 0x0008;

/// The recorder's channel number of the composite side-scan; channels up to it have a "last frame" field in each header.
pub(super) const COMPOSITE: u16 = 5;
/// The recorder's channel number of the primary sonar.
pub(super) const PRIMARY: u16 = 0;
/// The recorder's channel number of the down-scan.
pub(super) const DOWN_SCAN: u16 = 2;

/// A fix as the recorder writes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WrittenFix {
    /// Lowrance Mercator metres east and north.
    pub mercator: [i32; 2],
    pub course_rad: f64,
    pub speed_mps: f64,
    /// Compass heading; `None` without a compass.
    pub compass_rad: Option<f64>,
}

/// A frame before it has a place in the file.
#[derive(Clone, Debug)]
pub(super) struct Sl2Frame {
    pub channel: u16,
    /// Counts the pings of the channel.
    pub index: u32,
    /// Near and far limit of the echo bytes, metres; negative to port.
    pub range_m: [f64; 2],
    pub depth_m: f64,
    pub milliseconds: i32,
    pub fix: WrittenFix,
    /// First frame since this fix.
    pub fresh: bool,
    pub bytes: Vec<u8>,
}

/// Writes a whole log. `start_unix_s` 0 writes "no time" (0xFFFFFFFF).
///
/// # Errors
/// When writing fails, or when a frame or the file is larger than the format's fields can say.
pub(super) fn write(
    frames: &[Sl2Frame],
    start_unix_s: u32,
    out: &mut impl Write,
) -> io::Result<()> {
    out.write_all(&FILE_HEADER)?;
    let mut writer = Writer {
        offset: FILE_HEADER.len() as u32,
        last: [0; 6],
        previous_size: 0,
        start_unix_s,
    };
    for frame in frames {
        let header = writer.header(frame)?;
        out.write_all(bytemuck::bytes_of(&header))?;
        out.write_all(&frame.bytes)?;
    }
    Ok(())
}

struct Writer {
    offset: u32,
    /// Offset of the last frame of each channel.
    last: [u32; 6],
    previous_size: u16,
    start_unix_s: u32,
}

impl Writer {
    fn header(&mut self, frame: &Sl2Frame) -> io::Result<Header> {
        let too_large = || io::Error::other("the log is larger than SL2 can hold");
        let packet = u16::try_from(frame.bytes.len()).map_err(|_| too_large())?;
        let size = packet
            .checked_add(size_of::<Header>() as u16)
            .ok_or_else(too_large)?;
        if let Some(last) = self.last.get_mut(usize::from(frame.channel)) {
            *last = self.offset;
        }
        let fix = &frame.fix;
        let header = Header {
            own_offset: self.offset,
            last_offsets: self.last,
            frame_size: size,
            previous_size: self.previous_size,
            channel: frame.channel,
            packet,
            index: frame.index,
            min_range_ft: feet(frame.range_m[0]),
            max_range_ft: feet(frame.range_m[1]),
            frequency: frequency_code(frame.channel),
            clock: self.clock(frame),
            depth_ft: feet(frame.depth_m),
            minus_ones: [-1.0; 4],
            gps_speed_kn: (fix.speed_mps / MPS_PER_KNOT) as f32,
            temperature_c: WATER_C,
            x_m: fix.mercator[0],
            y_m: fix.mercator[1],
            course_rad: fix.course_rad as f32,
            heading_rad: fix.compass_rad.unwrap_or(0.0) as f32,
            flags: flags(frame),
            time_ms: frame.milliseconds,
            ..Header::zeroed()
        };
        self.offset = self
            .offset
            .checked_add(u32::from(size))
            .ok_or_else(too_large)?;
        self.previous_size = size;
        Ok(header)
    }

    /// The hardware time field: Unix seconds in the first frame of the file, milliseconds later.
    fn clock(&self, frame: &Sl2Frame) -> u32 {
        match (self.previous_size, self.start_unix_s) {
            (0, 0) => u32::MAX,
            (0, seconds) => seconds,
            _ => frame.milliseconds as u32,
        }
    }
}

/// Temperature of the water, degrees Celsius: the one the default absorption belongs to.
const WATER_C: f32 = 20.0;

/// Frequency codes: 200 kHz for the primary, 800 kHz for the down-scan, 455 kHz for the side-scan.
fn frequency_code(channel: u16) -> u8 {
    match channel {
        PRIMARY => 0,
        DOWN_SCAN => 4,
        _ => 3,
    }
}

fn flags(frame: &Sl2Frame) -> u16 {
    let heading = frame.fix.compass_rad.map_or(0, |_| HEADING);
    heading | if frame.fresh { FRESH } else { REPEATED }
}

fn feet(metres: f64) -> f32 {
    (metres / METRES_PER_FOOT) as f32
}
