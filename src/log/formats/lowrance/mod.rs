//! Reads Lowrance SL2 and SL3 files, with the depths of StructureScan 3D (`decode`), and SLG files,
//! which contain depths and a track (`slg`); writes SL2.
//!
//! In: the bytes of a recording. Out: a collected log.

mod decode;
pub mod frame;
mod from_log;
mod slg;
pub mod write;

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::walk::Walk;
use super::{OpenError, Opened, assemble, collected::Collected, scalar};
use crate::support::progress::{Cancelled, Progress};
use crate::survey::Survey;
use frame::{FrameCheck, FrameLayout};

/// Bytes of the file header; the first frame follows.
pub const FILE_HEADER: usize = 8;
/// Bytes searched for frames where the file header is damaged.
const SEARCHED_FOR_FRAMES: usize = 1 << 20;
/// Number of frames in a row that identify a log: fewer may occur by chance.
const FRAMES_THAT_PROVE: usize = 4;
/// Most places that are tried as the start of a row of frames.
const MOST_TRIES: usize = 16;

/// Reader of the format.
pub(super) struct Lowrance;

impl LogFormat for Lowrance {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let found = sniff(&opened.bytes)?;
        let opened = opened.clone();
        Some(Box::new(move |reading, progress| read(&opened, found, reading, progress)))
    }
}

/// Kind of a file, by its header or its frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LowranceKind {
    /// SLG, without side-scan.
    Slg {
        /// Bytes of a block.
        size: usize,
        /// Version in the file header.
        version: u16,
    },
    /// Frames of a known layout.
    Frames {
        /// Layout of the frames.
        layout: FrameLayout,
        /// Version in the file header; `None` where the header is damaged.
        version: Option<u16>,
    },
}

/// Recognises a file by its header (u16 format, u16 version, u16 block size, u16 reserved) and its
/// frames; by its frames alone where the header is damaged, or names the other layout.
fn sniff(bytes: &[u8]) -> Option<LowranceKind> {
    let stated = sniff_header(bytes);
    match stated {
        Some(LowranceKind::Frames { layout, .. }) if has_frames(bytes, layout) => stated,
        _ => sniff_frames(bytes).or(stated),
    }
}

fn sniff_header(bytes: &[u8]) -> Option<LowranceKind> {
    let format = scalar::u16_le(bytes, 0)?;
    let version = scalar::u16_le(bytes, 2)?;
    let block = scalar::u16_le(bytes, 4)?;
    let usual = matches!(block, 1970 | 3200) && version <= 16;
    let first_frame = scalar::u32_le(bytes, FILE_HEADER) == Some(FILE_HEADER as u32);
    match format {
        1 if usual || (version <= 16 && slg::begins_with_block(bytes, block.into())) => {
            Some(LowranceKind::Slg { size: block.into(), version })
        }
        2 | 3 if usual || first_frame => Some(LowranceKind::Frames {
            layout: if format == 2 { FrameLayout::Sl2 } else { FrameLayout::Sl3 },
            version: Some(version),
        }),
        _ => None,
    }
}

fn sniff_frames(bytes: &[u8]) -> Option<LowranceKind> {
    let mut layouts = [FrameLayout::Sl2, FrameLayout::Sl3].into_iter();
    let found = layouts.find(|layout| has_frames(bytes, *layout));
    found.map(|layout| LowranceKind::Frames { layout, version: None })
}

/// Returns true if there are several frames in a row, found by the offsets that they state: tables
/// of rising numbers in other files may look like two frames.
fn has_frames(bytes: &[u8], layout: FrameLayout) -> bool {
    let mut from = FILE_HEADER;
    // A damaged beginning may still contain some whole frames.
    for _ in 0..MOST_TRIES {
        let range = from..SEARCHED_FOR_FRAMES.max(from);
        let Some(first) = frame::first_frame(bytes, layout, range, 0) else {
            return false;
        };
        if is_row_of_frames(bytes, layout, first) {
            return true;
        }
        from = first.at + 1;
    }
    false
}

/// Returns true if enough frames follow each other from a place on to rule out chance, or more than
/// one up to the end of the bytes.
fn is_row_of_frames(bytes: &[u8], layout: FrameLayout, first: frame::FrameStart) -> bool {
    let mut at = first.at;
    for found in 0..FRAMES_THAT_PROVE {
        match layout.look(bytes, at, first.lost) {
            FrameCheck::Whole(frame) => at += frame.size,
            _ => return found > 1 && bytes.len() - at < layout.shortest_header(),
        }
    }
    true
}

/// Reads a file that [`sniff`] recognised; fails where it contains no whole frame, or the user
/// cancelled.
fn read(
    opened: &Opened,
    kind: LowranceKind,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let format = format_name(kind);
    let mut log = Collected::new(&[opened], &format, reading);
    let bytes = &opened.bytes;
    match kind {
        LowranceKind::Slg { size, .. } => {
            progress.start(bytes.len() as u64);
            slg::read_blocks(bytes, size, &mut log, reading.is_growing, progress)?;
        }
        LowranceKind::Frames { layout, version } => {
            if version.is_none() {
                log.report
                    .log("the file header is damaged; the format was inferred from the frames");
            }
            read_frames(bytes, layout, &mut log, reading, progress)?;
        }
    }
    if log.channels.is_empty() {
        let what = format!(
            "no whole frame in its {} bytes; copy the file from the unit's card again",
            bytes.len()
        );
        return Err(opened.broken(&format, what));
    }
    Ok(assemble::assemble(log, reading))
}

fn read_frames(
    bytes: &[u8],
    layout: FrameLayout,
    log: &mut Collected,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<(), Cancelled> {
    progress.start(bytes.len() as u64);
    let start = match reading.from(0) {
        Some(from) => frame::first_frame(bytes, layout, from..bytes.len(), 0),
        None => Some(frame::FrameStart { at: FILE_HEADER.min(bytes.len()), lost: 0 }),
    };
    let start = start.unwrap_or(frame::FrameStart { at: bytes.len(), lost: 0 });
    progress.advance(start.at as u64);
    let mut reader = decode::Reader::default();
    let walk = Walk::new(bytes, "frame", &log.report, reading, progress);
    frame::FrameWalk { walk, layout }.run(start, |frame| reader.take(log, frame))?;
    reader.finish(log);
    Ok(())
}

fn format_name(kind: LowranceKind) -> String {
    let (name, version) = match kind {
        LowranceKind::Slg { version, .. } => ("Lowrance SLG", Some(version)),
        LowranceKind::Frames { layout: FrameLayout::Sl2, version } => ("Lowrance SL2", version),
        LowranceKind::Frames { layout: FrameLayout::Sl3, version } => ("Lowrance SL3", version),
    };
    version.map_or_else(|| name.to_owned(), |version| format!("{name} (version {version})"))
}
