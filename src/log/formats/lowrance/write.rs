//! Writes SL2: a file header of 8 bytes, then frames, each of a [`Sl2Header`], as the reader uses
//! it, and the echo bytes; all little-endian.

use super::decode::FREQUENCIES_KHZ;
use super::frame::Sl2Header;
use crate::support::geo::{METRES_PER_FOOT, MPS_PER_KNOT};
use bytemuck::Zeroable as _;
use std::io::{self, Write};

/// Header of the file: format 2 (SL2), version 1, block size 3200 (a side-scan unit).
const FILE_HEADER: [u8; 8] = [2, 0, 1, 0, 0x80, 0x0c, 0, 0];
/// Flags of a frame with a new fix: speed, packet, position, course, altitude.
const FRESH: u16 = 0x0002 | 0x0008 | 0x0010 | 0x0080 | 0x0200;
/// Flag of a frame with the temperature of the water.
const TEMPERATURE: u16 = 0x0004;
/// Flag of a frame with a compass heading.
const HEADING: u16 = 0x0100;
/// Flags of a frame that repeats the last fix.
const REPEATED: u16 = 0x0008;

/// Channel number of the composite side-scan; channels up to this number have a "last frame" field
/// in each header.
pub const COMPOSITE: u16 = 5;
/// Channel number of the primary sonar.
pub const PRIMARY: u16 = 0;
/// Channel number of the down-scan.
pub const DOWN_SCAN: u16 = 2;

/// A fix as the recorder writes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrittenFix {
    /// Lowrance Mercator metres east and north; zeros without a position.
    pub mercator: [i32; 2],
    /// Course over ground, radians clockwise from north.
    pub course_rad: f64,
    /// Speed over ground, metres a second.
    pub speed_mps: f64,
    /// Compass heading, radians; `None` without a compass.
    pub compass_rad: Option<f64>,
}

/// Content of a frame, without its place in the file.
#[derive(Clone, Debug)]
pub struct Sl2Frame {
    /// Channel number.
    pub channel: u16,
    /// Code of the channel's frequency ([`frequency_code`]).
    pub frequency: u8,
    /// Near and far limit of the echo bytes, metres; negative to port.
    pub range_m: [f64; 2],
    /// Depth below the transducer, metres; 0 where unknown.
    pub depth_m: f64,
    /// Milliseconds after the log's time zero.
    pub milliseconds: i32,
    /// Fix that is valid at this time.
    pub fix: WrittenFix,
    /// True for the first frame with this fix.
    pub fresh: bool,
    /// Echo levels.
    pub bytes: Vec<u8>,
}

/// Writer of an SL2 file.
pub struct Sl2Writer<W> {
    out: W,
    offset: u32,
    /// Offset of the last frame of each channel, and number of its frames so far.
    channels: [(u32, u32); 6],
    previous_size: u16,
    start_unix_s: u32,
    temperature_c: Option<f32>,
}

impl<W: Write> Sl2Writer<W> {
    /// Creates the writer of a log that starts at a time, Unix seconds, in water of a temperature,
    /// if known. The time 0 is written as "no time" (0xFFFFFFFF).
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(mut out: W, start_unix_s: u32, temperature_c: Option<f32>) -> io::Result<Self> {
        out.write_all(&FILE_HEADER)?;
        Ok(Self {
            out,
            offset: FILE_HEADER.len() as u32,
            channels: [(0, 0); 6],
            previous_size: 0,
            start_unix_s,
            temperature_c,
        })
    }

    /// Writes a frame.
    ///
    /// # Errors
    /// When writing fails, or the frame or the file is larger than the fields of the format allow.
    pub fn push(&mut self, frame: &Sl2Frame) -> io::Result<()> {
        let header = self.header(frame)?;
        self.out.write_all(bytemuck::bytes_of(&header))?;
        self.out.write_all(&frame.bytes)
    }

    fn header(&mut self, frame: &Sl2Frame) -> io::Result<Sl2Header> {
        let size = frame.bytes.len() + size_of::<Sl2Header>();
        let size = u16::try_from(size).map_err(|_| {
            let count = frame.bytes.len();
            io::Error::other(format!(
                "a ping has {count} samples, more than a frame of SL2 holds; write XTF"
            ))
        })?;
        let mut index = 0;
        if let Some((last, count)) = self.channels.get_mut(usize::from(frame.channel)) {
            *last = self.offset;
            index = *count;
            *count += 1;
        }
        let fix = &frame.fix;
        let header = Sl2Header {
            own_offset: self.offset,
            last_offsets: self.channels.map(|(last, _)| last),
            frame_size: size,
            previous_size: self.previous_size,
            channel: frame.channel,
            packet: frame.bytes.len() as u16,
            index,
            min_range_ft: feet(frame.range_m[0]),
            max_range_ft: feet(frame.range_m[1]),
            frequency: frame.frequency,
            clock: self.clock(frame),
            depth_ft: feet(frame.depth_m),
            minus_ones: [-1.0; 4],
            gps_speed_kn: (fix.speed_mps / MPS_PER_KNOT) as f32,
            temperature_c: self.temperature_c.unwrap_or_default(),
            x_m: fix.mercator[0],
            y_m: fix.mercator[1],
            course_rad: fix.course_rad as f32,
            heading_rad: fix.compass_rad.unwrap_or(0.0) as f32,
            flags: self.flags(frame),
            time_ms: frame.milliseconds,
            ..Sl2Header::zeroed()
        };
        self.offset = self.offset.checked_add(u32::from(size)).ok_or_else(|| {
            io::Error::other("SL2 holds 4 GiB at most; write the log in parts, or as XTF")
        })?;
        self.previous_size = size;
        Ok(header)
    }

    /// Returns the value of the hardware time field: Unix seconds in the first frame of the file,
    /// milliseconds later.
    fn clock(&self, frame: &Sl2Frame) -> u32 {
        match (self.previous_size, self.start_unix_s) {
            (0, 0) => u32::MAX,
            (0, seconds) => seconds,
            _ => frame.milliseconds as u32,
        }
    }

    fn flags(&self, frame: &Sl2Frame) -> u16 {
        let heading = frame.fix.compass_rad.map_or(0, |_| HEADING);
        let temperature = self.temperature_c.map_or(0, |_| TEMPERATURE);
        heading | if frame.fresh { FRESH | temperature } else { REPEATED }
    }
}

/// Returns the frequency of a channel by its number, kHz, as on most units with side-scan.
pub fn usual_frequency_khz(channel: u16) -> f32 {
    match channel {
        0 | 1 => 200.0,
        2 => 800.0,
        _ => 455.0,
    }
}

/// Returns the code of the nominal frequency that is nearest to `khz`.
pub fn frequency_code(khz: f32) -> u8 {
    let apart = |code: &u8| (FREQUENCIES_KHZ[usize::from(*code)] - khz).abs();
    let codes = 0..FREQUENCIES_KHZ.len() as u8;
    let nearest = codes.min_by(|a, b| apart(a).total_cmp(&apart(b)));
    nearest.unwrap_or_default()
}

fn feet(metres: f64) -> f32 {
    (metres / METRES_PER_FOOT) as f32
}
