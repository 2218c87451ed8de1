//! A large SL2: a simulated survey's frames (2 x 1400 samples a ping, as an Elite Ti records) over
//! and over, each with its own offset and a time that goes on, each survey beside the one before: a
//! lake in patches.

use bathyscope_log::formats::lowrance::{FILE_HEADER, frame::Sl2Header};
use bathyscope_log::support::progress::Progress;
use bathyscope_simulation::{Scene, simulate};
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::mem::offset_of;
use std::path::Path;

/// Frame fields that change from copy to copy, and the one that tells a frame's length.
const OWN_OFFSET: usize = offset_of!(Sl2Header, own_offset);
const MILLISECONDS: usize = offset_of!(Sl2Header, time_ms);
const EAST: usize = offset_of!(Sl2Header, x_m);
const NORTH: usize = offset_of!(Sl2Header, y_m);
const FRAME_SIZE: usize = offset_of!(Sl2Header, frame_size);

/// Distance from one patch to the next, metres of Lowrance's Mercator, and patches in a row.
const PATCH_M: i32 = 45;
const PATCHES: i32 = 20;

/// Writes at least `bytes` bytes and returns how many.
pub(super) fn write(path: &Path, bytes: usize) -> io::Result<usize> {
    let survey = simulate(&Scene::default(), 1, &Progress::new()).map_err(io::Error::other)?;
    write_patches(path, &survey.sl2_bytes(), 0, bytes)
}

/// Writes at least `bytes` bytes of a log over and over, the first time in patch `first`, and
/// returns how many.
pub(super) fn write_patches(
    path: &Path,
    log: &[u8],
    first: i32,
    bytes: usize,
) -> io::Result<usize> {
    let frames = frames(log);
    let last = frames.last().map_or(0, |frame| integer(frame, MILLISECONDS));
    let mut out = BufWriter::new(File::create(path)?);
    out.write_all(&log[..FILE_HEADER])?;
    let (mut offset, mut lap) = (FILE_HEADER, first);
    while offset < bytes {
        for frame in &frames {
            let mut frame = frame.to_vec();
            let own = u32::try_from(offset).map_err(io::Error::other)?;
            frame[OWN_OFFSET..][..4].copy_from_slice(&own.to_le_bytes());
            for (field, more) in [
                (MILLISECONDS, lap * (last + 50)),
                (EAST, PATCH_M * (lap % PATCHES)),
                (NORTH, PATCH_M * (lap / PATCHES)),
            ] {
                let moved = integer(&frame, field) + more;
                frame[field..][..4].copy_from_slice(&moved.to_le_bytes());
            }
            out.write_all(&frame)?;
            offset += frame.len();
        }
        lap += 1;
    }
    out.flush()?;
    Ok(offset)
}

fn integer(frame: &[u8], field: usize) -> i32 {
    i32::from_le_bytes(frame[field..][..4].try_into().expect("four bytes"))
}

fn frames(log: &[u8]) -> Vec<&[u8]> {
    let mut rest = &log[FILE_HEADER..];
    let mut frames = Vec::new();
    while rest.len() > FRAME_SIZE + 2 {
        let size = usize::from(u16::from_le_bytes([rest[FRAME_SIZE], rest[FRAME_SIZE + 1]]));
        let Some((frame, after)) = rest.split_at_checked(size) else {
            break;
        };
        frames.push(frame);
        rest = after;
    }
    frames
}
