//! Reads Lowrance SLG: blocks of one size, each with the fields that its flags name.
//!
//! A file begins with the header of SL2 (u16 format, 1; u16 version; u16 size of a block; u16) and
//! two bytes more. A block begins with u16 flags; then come, each where its flag is set: f32 lower
//! limit of the range and f32 depth, feet (0x0200 or 0x0400); f32 temperature (0x0010); f32 speed
//! through the water (0x0080); i32 X and Y, metres of Lowrance's Mercator (0x0100); f32 depth of
//! the surface clutter (0x0400); f32 top of the bottom (0x0800); f32 temperature 2 (0x0020) and 3
//! (0x0040); u32 milliseconds (0x2000); f32 speed, knots, and f32 course, radians (0x4000). Up to
//! two f32 follow, of which one is the altitude; then u16 bytes of echoes, and the echoes to the
//! block's end. A block is recognised by these sizes, which must add up to its own.
//!
//! Only depths and the track are read. Blocks without a time are spread evenly between those with
//! one.
//!
//! Sources: python-sllib, which reads these fields in this order and checks the sizes, and the list
//! of file sizes in OpenStreetMap's page on SL2 (both with a header of 10 bytes); a forum's
//! analysis of the LMS-525C has the same fields. No real file was available.

use super::frame::metres;
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted, WarningKind};
use crate::formats::scalar::{Fields, u16_le};
use crate::support::geo::{MPS_PER_KNOT, lowrance_mercator_inverse};
use crate::support::progress::{Cancelled, Progress};
use crate::survey::{ChannelKind, Fix};

/// Bytes before the first block.
pub(super) const HEADER: usize = 10;
/// Flags of the fields, in the order of the fields in a block.
const DEPTHS: u16 = 0x0600;
const TEMPERATURE: u16 = 0x0010;
const WATER_SPEED: u16 = 0x0080;
const POSITION: u16 = 0x0100;
const SURFACE: u16 = 0x0400;
const BOTTOM: u16 = 0x0800;
const TEMPERATURE_2: u16 = 0x0020;
const TEMPERATURE_3: u16 = 0x0040;
const TIME: u16 = 0x2000;
const SPEED: u16 = 0x4000;

/// Fewest bytes of a block; blocks with all fields are longer.
const SMALLEST: usize = 64;
/// Time between blocks of a log without any time, seconds.
const USUAL_STEP_S: f64 = 0.1;
/// Longest time between blocks, seconds: in a longer pause the blocks without a time are placed at
/// its beginning.
const LONGEST_STEP_S: f64 = 2.0;
/// Number of the only channel.
const CHANNEL: u16 = 0;

/// Fields of a block that are used, in the recorder's units; missing ones are NaN or `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Block {
    /// Offsets of the beginning and the end of the block in the file.
    at: usize,
    end: usize,
    depth_ft: f32,
    xy_m: Option<[i32; 2]>,
    time_ms: Option<u32>,
    speed_kn: f32,
    course_rad: f32,
}

impl Block {
    /// Returns the block of this size at an offset; `None` where the sizes do not add up, or the
    /// block exceeds the bytes.
    fn at(bytes: &[u8], at: usize, size: usize) -> Option<Self> {
        let end = at.checked_add(size)?;
        let block = bytes.get(at..end)?;
        let flags = u16_le(block, 0)?;
        let fields = Fields(block);
        let mut next = 2;
        // Returns the offset of a field of `length` bytes if one of its flags is set.
        let mut field = |mask: u16, length: usize| {
            let is_there = flags & mask != 0;
            let here = next;
            next += if is_there { length } else { 0 };
            is_there.then_some(here)
        };
        let depths = field(DEPTHS, 8);
        field(TEMPERATURE, 4);
        field(WATER_SPEED, 4);
        let position = field(POSITION, 8);
        for mask in [SURFACE, BOTTOM, TEMPERATURE_2, TEMPERATURE_3] {
            field(mask, 4);
        }
        let time = field(TIME, 4);
        let speed = field(SPEED, 8);
        let adds_up = |others: usize| {
            let count_at = next + others;
            u16_le(block, count_at).is_some_and(|count| count_at + 2 + usize::from(count) == size)
        };
        [0, 4, 8].into_iter().any(adds_up).then(|| Self {
            at,
            end,
            depth_ft: depths.map_or(f32::NAN, |at| fields.f32(at + 4)),
            xy_m: position.map(|at| [fields.i32(at), fields.i32(at + 4)]),
            time_ms: time.map(|at| fields.u32(at)),
            speed_kn: speed.map_or(f32::NAN, |at| fields.f32(at)),
            course_rad: speed.map_or(f32::NAN, |at| fields.f32(at + 4)),
        })
    }
}

/// Returns true if a file begins with a block of this size that has a depth or a position, and
/// another block follows unless the file ends before.
pub(super) fn begins_with_block(bytes: &[u8], size: usize) -> bool {
    let block = Block::at(bytes, HEADER, size).filter(|_| size >= SMALLEST);
    block.is_some_and(|block| {
        let tells = block.xy_m.is_some() || !block.depth_ft.is_nan();
        let is_last = bytes.len() - block.end < size;
        tells && (is_last || Block::at(bytes, block.end, size).is_some())
    })
}

/// Reads the blocks of a file, all of size `size`.
///
/// # Errors
/// When the user cancelled the reading.
pub(super) fn read_blocks(
    bytes: &[u8],
    size: usize,
    log: &mut Collected,
    is_growing: bool,
    progress: &Progress,
) -> Result<(), Cancelled> {
    let mut reader = Reader::default();
    progress.advance(HEADER.min(bytes.len()) as u64);
    progress.walk(HEADER, bytes.len(), |at| {
        if let Some(block) = Block::at(bytes, at, size) {
            reader.take(log, block);
            return Ok(block.end);
        }
        let rest = bytes.len() - at;
        let found = next_block(bytes, at + 1, size);
        // Whole files end with two additional bytes.
        let is_end = found.is_none() && (rest <= 2 || (is_growing && rest < size));
        let to = found.unwrap_or(bytes.len());
        if !is_end {
            let text = if found.is_none() && rest < size {
                format!(
                    "the recording was cut inside its last block ({rest} bytes of it are there); it was dropped"
                )
            } else {
                format!("{} bytes are no block and were skipped", to - at)
            };
            log.report.at(WarningKind::Gap, 0, at, text);
        }
        Ok(to)
    })?;
    reader.finish(log);
    Ok(())
}

/// Returns the offset of the next block that is followed by another block or by the end of the
/// bytes: the sizes of a single block may add up by chance.
fn next_block(bytes: &[u8], from: usize, size: usize) -> Option<usize> {
    let last = bytes.len().checked_sub(size)?;
    (from..=last).find(|&at| {
        let block = Block::at(bytes, at, size);
        block.is_some_and(|block| {
            bytes.len() - block.end <= 2 || Block::at(bytes, block.end, size).is_some()
        })
    })
}

/// Assigns times to blocks.
#[derive(Default)]
struct Reader {
    clock: Clock<Vec<Block>>,
    /// A block with a time, and the blocks without a time after it.
    open: Vec<Block>,
    /// Blocks before the first time.
    before: Vec<Block>,
    /// Time of the last block with a plausible time, seconds, and that block with those after it.
    last: Option<(f64, Vec<Block>)>,
    zero_s: Option<f64>,
    step_s: Option<f64>,
}

impl Reader {
    fn take(&mut self, log: &mut Collected, block: Block) {
        if block.time_ms.is_some() {
            self.close(log);
        }
        self.open.push(block);
    }

    /// Ends the group of open blocks.
    fn close(&mut self, log: &mut Collected) {
        let blocks = std::mem::take(&mut self.open);
        let Some(first) = blocks.first() else {
            return;
        };
        let Some(time_ms) = first.time_ms else {
            self.before = blocks;
            return;
        };
        let verdict = self.clock.push(f64::from(time_ms) / 1e3, blocks);
        verdict.into_iter().for_each(|verdict| self.settle(log, verdict));
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<Vec<Block>>) {
        match verdict {
            ClockVerdict::Sound { record, time_s } => {
                let time_s = time_s - *self.zero_s.get_or_insert(time_s);
                self.keep_before(log);
                if let Some((before_s, blocks)) = self.last.take() {
                    let step_s = (time_s - before_s) / blocks.len() as f64;
                    let step_s = step_s.clamp(0.0, LONGEST_STEP_S);
                    self.step_s = Some(step_s);
                    self.keep_all(log, before_s, step_s, &blocks);
                }
                self.last = Some((time_s, record));
            }
            ClockVerdict::Damaged(record) => {
                let at = record.first().map_or(0, |block| block.at);
                let text = "a block's time fits neither neighbour; it was dropped";
                log.report.at(WarningKind::Frame, 0, at, text);
            }
        }
    }

    fn finish(&mut self, log: &mut Collected) {
        self.close(log);
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        log.report.set_back(self.clock.set_back_s);
        self.keep_before(log);
        let step_s = self.step_s.unwrap_or(USUAL_STEP_S);
        if let Some((before_s, blocks)) = self.last.take() {
            self.keep_all(log, before_s, step_s, &blocks);
        }
        if self.zero_s.is_none() {
            log.report
                .log(format!("no block tells the time; they are taken as {USUAL_STEP_S} s apart"));
        }
    }

    /// Adds the blocks before the first time to the log.
    fn keep_before(&mut self, log: &mut Collected) {
        let blocks = std::mem::take(&mut self.before);
        self.keep_all(log, blocks.len() as f64 * -USUAL_STEP_S, USUAL_STEP_S, &blocks);
    }

    fn keep_all(&self, log: &mut Collected, from_s: f64, step_s: f64, blocks: &[Block]) {
        for (index, block) in blocks.iter().enumerate() {
            keep(log, block, from_s + index as f64 * step_s);
        }
    }
}

fn keep(log: &mut Collected, block: &Block, time_s: f64) {
    let counted = Counted { record: (0, block.end), time_s, samples: 0, range_m: None };
    log.count(CHANNEL, counted, || (ChannelKind::Primary, CHANNEL.to_string(), None));
    log.add_depth(ChannelKind::Primary, time_s, metres(block.depth_ft));
    let Some([x_m, y_m]) = block.xy_m.filter(|[x_m, y_m]| *x_m != 0 && *y_m != 0) else {
        return;
    };
    let finite = |value: f32| if value.is_finite() { value } else { f32::NAN };
    log.add_fix(Fix {
        cog_rad: finite(block.course_rad),
        speed_mps: if block.speed_kn >= 0.0 {
            finite((f64::from(block.speed_kn) * MPS_PER_KNOT) as f32)
        } else {
            f32::NAN
        },
        ..Fix::at(time_s, lowrance_mercator_inverse(f64::from(x_m), f64::from(y_m)))
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::test_logs::held;
    use crate::formats::{self, OpenError, open_growing};
    use crate::survey::{SideScanState, Survey};
    use bathyscope_test_support::Random;

    const SIZE: usize = 300;

    /// Returns a block with depth, position and course; every third has a time.
    fn block(index: usize, flags: u16) -> Vec<u8> {
        let mut block = flags.to_le_bytes().to_vec();
        let mut add = |mask: u16, field: &[u8]| {
            if flags & mask != 0 {
                block.extend_from_slice(field);
            }
        };
        let depth_ft = 10.0 + index as f32 / 10.0;
        add(DEPTHS, &60.0_f32.to_le_bytes());
        add(DEPTHS, &depth_ft.to_le_bytes());
        add(TEMPERATURE, &14.5_f32.to_le_bytes());
        add(WATER_SPEED, &1.0_f32.to_le_bytes());
        add(POSITION, &(-9_000_000 + index as i32).to_le_bytes());
        add(POSITION, &3_400_000_i32.to_le_bytes());
        for mask in [SURFACE, BOTTOM, TEMPERATURE_2, TEMPERATURE_3] {
            add(mask, &3.0_f32.to_le_bytes());
        }
        add(TIME, &(5000 + 200 * index as u32).to_le_bytes());
        add(SPEED, &5.0_f32.to_le_bytes());
        add(SPEED, &1.5_f32.to_le_bytes());
        block.extend(100.0_f32.to_le_bytes());
        let count = SIZE - block.len() - 2;
        block.extend((count as u16).to_le_bytes());
        block.resize(SIZE, 77);
        block
    }

    fn slg(count: usize) -> Vec<u8> {
        let mut file = vec![1, 0, 0, 0, (SIZE % 256) as u8, (SIZE / 256) as u8, 0, 0, 0, 0];
        for index in 0..count {
            let time = if index % 3 == 0 { TIME } else { 0 };
            let flags = [0x0200, 0x0600, 0x0E70][index % 3];
            file.extend(block(index, flags | POSITION | SPEED | WATER_SPEED | time));
        }
        file
    }

    fn read(bytes: Vec<u8>) -> Result<Survey, OpenError> {
        formats::open_bytes("pond.slg", bytes, &Progress::new())
    }

    #[test]
    fn depths_track_and_times_are_what_was_written() {
        let survey = read(slg(30)).expect("a log");
        assert_eq!(survey.source.recorder(), "Lowrance SLG (version 0)");
        assert_eq!(survey.side_scan_state, SideScanState::Absent);
        assert_eq!((survey.soundings.len(), survey.track.fixes.len()), (30, 30));
        for (index, sounding) in survey.soundings.iter().enumerate() {
            let depth_m = (10.0 + index as f32 / 10.0) * 0.3048;
            assert!((sounding.depth_m - depth_m).abs() < 1e-5);
            assert!((sounding.time_s - 0.2 * index as f64).abs() < 1e-9, "{index}");
            let fix = survey.track.fixes[index];
            let position = lowrance_mercator_inverse(-9_000_000.0 + index as f64, 3_400_000.0);
            assert_eq!(fix.position, position);
            assert_eq!((fix.cog_rad, (fix.speed_mps * 100.0).round()), (1.5, 257.0));
        }
        // Units write two additional bytes at the end.
        let padded = read([slg(30), vec![0; 2]].concat()).expect("a log");
        assert!(!padded.warnings.iter().any(|warning| warning.place.is_some()));
    }

    #[test]
    fn damage_costs_the_block_that_it_touched() {
        let whole = slg(30);
        let at = HEADER + 4 * SIZE;
        for (spoil, kept) in [
            ((|bytes, at| bytes[at + 1] ^= 0x40) as fn(&mut Vec<u8>, usize), 29),
            (|bytes, at| drop(bytes.drain(at + 100..at + 200)), 29),
            (|bytes, at| drop(bytes.splice(at..at, [9; 50])), 30),
            (|bytes, _| bytes.truncate(HEADER + 29 * SIZE + 100), 29),
        ] {
            let mut bytes = whole.clone();
            spoil(&mut bytes, at);
            let survey = read(bytes).expect("a log");
            assert_eq!(survey.soundings.len(), kept);
            let placed: Vec<u64> =
                survey.warnings.iter().filter_map(|warning| Some(warning.place?.1)).collect();
            assert_eq!(placed.len(), 1, "{:?}", survey.warnings);
        }
        let broken = read(whole[..HEADER].to_vec());
        assert!(broken.is_err());
        let mut usual = vec![1, 0, 0, 0, 0xB2, 7, 0, 0];
        usual.resize(6000, 0xFF);
        let error = read(usual).expect_err("no block");
        assert!(matches!(error, OpenError::Broken { .. }), "{error}");
    }

    #[test]
    fn a_growing_log_and_hostile_bytes_are_read_as_far_as_they_go() {
        let whole = slg(9);
        for length in 0..whole.len() {
            let files = held("pond.slg", &whole[..length]);
            if let Ok(survey) = open_growing(files, &Progress::new()) {
                assert!(!survey.warnings.iter().any(|warning| warning.place.is_some()), "{length}");
                assert_eq!(survey.soundings.len(), (length - HEADER) / SIZE);
            }
        }
        let mut random = Random(88_172_645_463_325_252);
        for _ in 0..5000 {
            let mut bytes = whole.clone();
            for _ in 0..=random.below(6) {
                // Fields are at the beginning of a block.
                let at = (random.below(10) * SIZE + random.below(50)).min(bytes.len() - 1);
                bytes[at] = random.below(256) as u8;
            }
            if let Ok(survey) = read(bytes) {
                assert!(survey.soundings.len() <= 10 && survey.track.fixes.len() <= 10);
                assert!(
                    survey
                        .soundings
                        .iter()
                        .all(|sounding| sounding.depth_m > 0.0 && sounding.time_s.is_finite())
                );
            }
        }
    }
}
