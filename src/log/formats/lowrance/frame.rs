//! Reads frames of SL2 and SL3: defines their headers as stored, recognises a frame in the bytes,
//! and walks from frame to frame through a log and skips damaged parts.

use crate::formats::collected::WarningKind;
use crate::formats::scalar;
use crate::formats::walk::Walk;
use crate::support::geo::METRES_PER_FOOT;
use crate::support::progress::Cancelled;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// Channel number of depths across the track. The packet length in headers of this channel is not
/// the length of the data.
pub(super) const STRUCTURE_SCAN_3D: u16 = 9;
/// Highest plausible channel number; a higher one in a header means that the bytes are no header.
const LAST_CHANNEL: u16 = 31;
/// Most bytes of a header.
const LONGEST_HEADER: usize = 256;
/// Number of bytes searched between two checks for cancellation.
const BYTES_A_CHECK: usize = 1 << 20;
/// Most bytes that may be missing (or inserted) in one place while the frames after it are still
/// found.
const MOST_LOST: u64 = 1 << 20;

/// The two frame layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameLayout {
    /// 144-byte headers.
    Sl2,
    /// 128-, 168- or 180-byte headers.
    Sl3,
}

/// SL2 frame header as stored: 144 bytes, little-endian, then `packet` bytes of echo, one byte a
/// sample. Ranges and depths are in feet, speeds in knots, angles in radians clockwise from north.
/// Verified on files of format versions 0 and 1; every offset of the older public tables is 2 too
/// small (they count the file header as 10 bytes).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Sl2Header {
    /// Offset 0: offset of this frame in the file, which identifies frames after damage.
    pub own_offset: u32,
    /// 4: offsets of the last primary, secondary, down-scan, left, right and composite frame.
    pub last_offsets: [u32; 6],
    /// 28: bytes of header and data together, the step to the next frame.
    pub frame_size: u16,
    /// 30: bytes of the frame before.
    pub previous_size: u16,
    /// 32: 0 primary, 1 secondary, 2 down-scan, 3 left, 4 right, 5 composite side-scan.
    pub channel: u16,
    /// 34: bytes of echo data.
    pub packet: u16,
    /// 36: frame number in its channel.
    pub index: u32,
    /// 40: near limit of the range; on composite side-scan the negative far limit.
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
    /// 108: east, metres of Lowrance's Mercator. Signed, which is needed in the western hemisphere.
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
    /// 132: flags of the values that are new in this frame; older units fill the other fields with
    /// the last known values.
    pub flags: u16,
    /// 134: unknown.
    pub unknown_134: [u8; 6],
    /// 140: milliseconds since the start of the log (older units: of the unit). Signed.
    pub time_ms: i32,
}

const _: () = assert!(size_of::<Sl2Header>() == 144);

/// SL3 frame header as stored: the first 128 bytes, little-endian. On channels 7 and 8 this is the
/// whole header; on the others it continues to 168 bytes (180 in frame version 13) with the offsets
/// of the last frames, so the data begins `frame_size - packet` bytes after the start of the frame,
/// never at a constant offset. Units as in [SL2](Sl2Header). Verified on files of frame version 10.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Sl3Header {
    /// Offset 0: this frame's own offset in the file.
    pub own_offset: u32,
    /// 4: version of the frame layout; 10 was seen, 13 is known.
    pub frame_version: u32,
    /// 8: bytes of header and data together, the step to the next frame.
    pub frame_size: u16,
    /// 10: bytes of the frame before.
    pub previous_size: u16,
    /// 12: as in SL2; 7 and 8 are raw data of the down sonar, 9 is 3D, 10 and 11 are internal to
    /// the recorder.
    pub channel: u16,
    /// 14: unknown.
    pub unknown_14: [u8; 2],
    /// 16: frame number in its channel.
    pub index: u32,
    /// 20: near limit of the range; on composite side-scan the negative far limit.
    pub min_range_ft: f32,
    /// 24: far limit of the range.
    pub max_range_ft: f32,
    /// 28: unknown.
    pub unknown_28: [u8; 12],
    /// 40: Unix seconds in frame 0 of every channel; a millisecond count later.
    pub clock: u32,
    /// 44: bytes of echo data. On channel 9 of some units the value is wrong; use `frame_size` to
    /// step.
    pub packet: u32,
    /// 48: water depth; 0 on channels without it.
    pub depth_ft: f32,
    /// 52: frequency code.
    pub frequency: u16,
    /// 54: unknown; contains the four -1.0 of SL2 at 64.
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
    /// 116: flags of the values that are new in this frame.
    pub flags: u16,
    /// 118: unknown.
    pub unknown_118: [u8; 6],
    /// 124: milliseconds since the start of the log. Signed: real files begin up to half a second
    /// before zero.
    pub time_ms: i32,
}

const _: () = assert!(size_of::<Sl3Header>() == 128);

/// Fields of a frame that Bathyscope uses, still in the recorder's units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LowranceFrame {
    /// Offset of the frame in the file.
    pub offset: usize,
    /// Bytes of header and data.
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
    /// Unix seconds, or a count of milliseconds.
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

/// Result of the search for a frame at an offset.
#[derive(Debug)]
pub(crate) enum FrameCheck {
    /// A complete frame.
    Whole(LowranceFrame),
    /// A frame header whose data exceeds the end of the file, or a truncated header.
    Cut,
    /// No frame header.
    Nothing,
}

impl FrameLayout {
    /// Returns the bytes of the shortest header of the layout.
    pub(crate) fn shortest_header(self) -> usize {
        match self {
            FrameLayout::Sl2 => size_of::<Sl2Header>(),
            FrameLayout::Sl3 => size_of::<Sl3Header>(),
        }
    }

    /// Checks for a frame at `offset`. `lost` is the number of bytes that the file lost before the
    /// frame: the frame states its offset before the loss.
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

/// Returns the number of bytes that were lost before `offset` (negative: inserted) if a frame
/// begins there; recorders store offsets in 32 bits, which wrap at 4 GiB.
fn lost_before(bytes: &[u8], offset: usize) -> Option<i64> {
    let stated = scalar::u32_le(bytes, offset)?;
    Some(i64::from(stated.wrapping_sub(offset as u32).cast_signed()))
}

/// Returns where the data in a frame begins: after the header, whose length is the frame's size
/// less the packet's, where this is a plausible length of a header, else the usual length.
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

/// Converts feet, the unit in frames, to metres.
pub(super) fn metres(feet: f32) -> f32 {
    (f64::from(feet) * METRES_PER_FOOT) as f32
}

/// A walk over the frames of a log.
pub(super) struct FrameWalk<'a> {
    /// The file, and the report of damaged frames.
    pub(super) walk: Walk<'a>,
    /// Layout of the file's frames.
    pub(super) layout: FrameLayout,
}

impl FrameWalk<'_> {
    /// Calls `take` for every whole frame from `start` on; fails only if cancelled.
    pub(super) fn run(
        &self,
        start: FrameStart,
        mut take: impl FnMut(LowranceFrame),
    ) -> Result<(), Cancelled> {
        let (mut lost, mut longest) = (start.lost, 0);
        self.walk.progress.walk(start.at, self.walk.bytes.len(), |at| {
            let here = FrameStart { at, lost };
            let next = match self.layout.look(self.walk.bytes, at, lost) {
                FrameCheck::Whole(frame) => self.step(here, frame, &mut longest, &mut take)?,
                FrameCheck::Cut => self.over_cut(here)?,
                FrameCheck::Nothing => self.over_gap(here)?,
            };
            lost = next.lost;
            Ok(next.at)
        })
    }

    /// Passes a frame to `take` if another frame follows it, or if none begins inside it: the size
    /// of a frame that none follows may be damaged. A damaged size may also end at the start of
    /// another frame by chance: a frame that is longer than the `longest` before it is therefore
    /// searched for frames inside it. Returns where to continue.
    fn step(
        &self,
        here: FrameStart,
        frame: LowranceFrame,
        longest: &mut usize,
        take: &mut impl FnMut(LowranceFrame),
    ) -> Result<FrameStart, Cancelled> {
        let next = here.at + frame.size;
        let goes_on =
            next == self.walk.bytes.len() || lost_before(self.walk.bytes, next) == Some(here.lost);
        if !goes_on || frame.size > *longest {
            let inside = here.at + self.layout.shortest_header();
            let found = self.find(inside, next, here.lost)?;
            if let Some(found) = found.filter(|found| !goes_on || self.reaches(*found, next)) {
                self.walk.over_long(here.at, next, found.at);
                return Ok(found);
            }
        }
        *longest = frame.size.max(*longest);
        take(frame);
        Ok(FrameStart { at: next, ..here })
    }

    /// Returns true if whole frames from `start` on end exactly at `end`.
    fn reaches(&self, start: FrameStart, end: usize) -> bool {
        let mut at = start.at;
        while at < end {
            match self.layout.look(self.walk.bytes, at, start.lost) {
                FrameCheck::Whole(frame) => at += frame.size,
                _ => return false,
            }
        }
        at == end
    }

    fn over_cut(&self, here: FrameStart) -> Result<FrameStart, Cancelled> {
        let Some(found) = self.find(here.at + 4, self.walk.bytes.len(), here.lost)? else {
            return Ok(FrameStart { at: self.walk.over_cut(here.at, "recording"), ..here });
        };
        let text = "a frame header is damaged; the frame was dropped";
        self.walk.report.at(WarningKind::Frame, 0, here.at, text);
        Ok(found)
    }

    fn over_gap(&self, here: FrameStart) -> Result<FrameStart, Cancelled> {
        let len = self.walk.bytes.len();
        let found = self.find(here.at + 1, len, here.lost)?;
        let to = found.unwrap_or(FrameStart { at: len, ..here });
        if found.is_none() && self.walk.is_growing {
            return Ok(to);
        }
        let bytes = to.at - here.at;
        let text = match found {
            Some(found) if found.lost != here.lost => format!(
                "{bytes} bytes belong to no frame and were skipped; {} bytes were lost around here",
                found.lost - here.lost
            ),
            Some(_) => format!("{bytes} bytes belong to no frame and were skipped"),
            // Some recorders add such an end to a file. A truncated frame has at least its own
            // offset.
            None if bytes < size_of::<u32>() => return Ok(to),
            None => {
                format!("the last {bytes} bytes of the file belong to no frame and were skipped")
            }
        };
        self.walk.report.at(WarningKind::Gap, 0, here.at, text);
        Ok(to)
    }

    /// Returns the first whole frame that begins in `from..to`.
    fn find(&self, from: usize, to: usize, lost: i64) -> Result<Option<FrameStart>, Cancelled> {
        let mut at = from;
        while at < to.min(self.walk.bytes.len()) {
            self.walk.progress.check()?;
            let until = to.min(at.saturating_add(BYTES_A_CHECK));
            if let Some(found) = first_frame(self.walk.bytes, self.layout, at..until, lost) {
                return Ok(Some(found));
            }
            at = until;
        }
        Ok(None)
    }
}

/// Beginning of a frame, and the number of bytes that the file lost before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrameStart {
    /// Offset in the file.
    pub(super) at: usize,
    /// Number of lost bytes; negative where bytes were inserted.
    pub(super) lost: i64,
}

/// Returns the first whole frame that begins in `range`. `lost` bytes are known to be missing
/// before the range: a frame that agrees with this number is accepted; otherwise the frame after it
/// must agree with it.
pub(super) fn first_frame(
    bytes: &[u8],
    layout: FrameLayout,
    range: Range<usize>,
    lost: i64,
) -> Option<FrameStart> {
    (range.start..range.end.min(bytes.len()))
        .filter_map(|at| Some(FrameStart { at, lost: lost_before(bytes, at)? }))
        .filter(|place| place.lost.abs_diff(lost) <= MOST_LOST)
        .find(|place| {
            let FrameCheck::Whole(frame) = layout.look(bytes, place.at, place.lost) else {
                return false;
            };
            let next = layout.look(bytes, place.at + frame.size, place.lost);
            place.lost == lost || matches!(next, FrameCheck::Whole(_))
        })
}
