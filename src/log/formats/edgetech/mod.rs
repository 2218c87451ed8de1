//! Reads EdgeTech JSF files, which the side-scan sonars of EdgeTech and their program Discover
//! record.
//!
//! In: the bytes of a recording. Out: a collected log.
//!
//! A file is a sequence of messages, all numbers little-endian. A message has a header of 16 bytes:
//! u16 marker 0x1601, u8 version of the protocol, u8 session, u16 type, u8 command, u8 subsystem,
//! u8 channel, u8 sequence, u16 reserved, i32 bytes that follow. Subsystems 20, 21 and 22 are
//! side-scan of low, high and very high frequency, 70 to 72 the same with more pulses in the water,
//! 0 a sub-bottom profiler, 40 to 42 bathymetry. Channel 0 is port and 1 starboard; both are stored
//! from near to far.
//!
//! Message 80 is a ping of one channel, a trace: 240 bytes (`trace`), then samples of 16 bits.
//! Format 0 is the envelope, one u16 a sample; format 1 the analytic signal, a real and an
//! imaginary i16 a sample. Other formats were recorded before the matched filter, or are not
//! published by EdgeTech, and are not read. A sample counts 2^-w volts, with the weighting factor w
//! of its ping. Message 82 is an older trace with 80 bytes before the same samples. Of the other
//! messages, 182 names the sonar, 2002 is a NMEA sentence, 2060 a pressure sensor, 2080 a Doppler
//! log; the last two give the speed of sound where traces do not state it. The beams of a Doppler
//! log are not used as soundings: whether their ranges are slant or vertical is not stated.
//!
//! Sources: the fields of EdgeTech's "JSF Data File Description" (0023492), as the public readers
//! `sidescantools`, `PINGVerter` 2.1.7 and MB-System (`mbsys_jstar.h`) cite it. Difference from
//! these readers: the fractions that later protocols add to the sample interval (less than 1 ns)
//! and to course and speed are left out. No real file was at hand: the reader is checked with
//! generated files, from which PINGVerter reads the same.

mod decode;
mod pair;
#[cfg(test)]
mod tests;
mod trace;

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::Progress;
use crate::survey::Survey;
use trace::{FORMAT, MessageHeader};

const NAME: &str = "EdgeTech JSF";
/// Bytes searched for messages where the beginning of a file is damaged.
const SEARCHED_FOR_MESSAGES: usize = 1 << 20;
/// Highest plausible version of the protocol: 0x12 is the newest that is described.
const NEWEST_VERSION: u8 = 0x40;

/// Reader of the format.
pub(super) struct EdgeTech;

impl LogFormat for EdgeTech {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let first = sniff(&opened.bytes)?;
        let opened = opened.clone();
        Some(Box::new(move |reading, progress| read(&opened, first, reading, progress)))
    }
}

/// Recognises a file by its first message, or by two messages in a row where the first is damaged;
/// returns the offset of the first whole message.
fn sniff(bytes: &[u8]) -> Option<usize> {
    let first = MessageHeader::at(bytes, 0);
    if first.is_some_and(|header| header.version <= NEWEST_VERSION && header.kind != 0) {
        return Some(0);
    }
    FORMAT.next(bytes, 0, SEARCHED_FOR_MESSAGES)
}

/// Reads a file that [`sniff`] recognised.
///
/// # Errors
/// When the file contains no side-scan, or the user cancelled the reading.
fn read(
    opened: &Opened,
    first: usize,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let bytes = &opened.bytes;
    let mut log = Collected::new(&[opened], NAME, reading);
    let mut reader = decode::Reader::new(bytes, reading);
    let tail = reading.from(0).filter(|_| reader.zero_ms.is_some());
    FORMAT.read(bytes, (0, tail), &mut log, (reading, progress), |log, message| {
        reader.take(log, message);
    })?;
    reader.finish(&mut log);
    let has_side_scan = log.channels.iter().any(|(_, channel)| channel.kind.side().is_some());
    if !has_side_scan && reader.sensors.total() > 0 {
        return Err(opened.unsupported(format!(
            "this JSF file is whole, but there is no side-scan in it, only {}; open the file that the side-scan was recorded into",
            reader.sensors.summary()
        )));
    }
    if !has_side_scan {
        return Err(opened.broken(
            NAME,
            format!(
                "no side-scan ping in its {} bytes from byte {first} on; copy the file again",
                bytes.len()
            ),
        ));
    }
    Ok(assemble::assemble(log, reading))
}
