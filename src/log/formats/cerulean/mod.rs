//! Reads Cerulean svlog files, which SonarView records from Omniscan 450 side-scan sonars, as on
//! boats of Blue Robotics.
//!
//! In: the bytes of a recording. Out: a collected log.
//!
//! A file is a sequence of packets of the Ping protocol, all numbers little-endian: `BR`, u16 bytes
//! of the payload, u16 packet id, u8 source device, u8 destination device, the payload, u16 sum of
//! all bytes before. Packet 2198 is a profile, the ping of one transducer; `packet` reads packets
//! and profiles. A profile has 52 bytes, then u16 samples from near to far, scaled between the
//! lowest and the highest decibels of that ping. Packet 10 is a description of the session in JSON
//! with the time when recording began, 109 a NMEA sentence, 150 a MAVLink message in JSON, of which
//! `GLOBAL_POSITION_INT` has a position. No packet has the depth.
//!
//! The sign of the transducer's heading gives the side: negative is port. Where the heading is 0,
//! the channel number of a profile gives the side, 0 for port and 1 for starboard. Boats with one
//! transducer, or with two transducers on separate computers, use the number 0 for all channels; a
//! heading that contradicts the number is therefore preferred, with a warning. The milliseconds of
//! both transducers are assumed to start at the same moment, as in BlueBoat-SideScanSonar; a
//! warning states where this cannot be true. Packets of one transducer may come in a row before
//! those of the other, so that each channel is in time order but the file is not. NMEA and MAVLink
//! have clocks of their own; `navigation` gives their positions the times of the profiles around
//! them. The time when recording began is assigned to the first profile after the session packet,
//! to about a second.
//!
//! Sources: the Ping protocol's definitions (`omniscan450.json`, `common.json` of
//! bluerobotics/ping-protocol), Cerulean's description of its packets and of the Omniscan 450's
//! interface, and the readers PINGVerter 2.1.7, GeoHammer and BlueBoat-SideScanSonar; the order of
//! packets, the sides and the clocks are as BlueBoat-SideScanSonar measured them on 18 real logs.
//! Differences from PINGVerter: the range ends at start plus length, as the protocol states, and
//! the clock of the sonar may differ from the clock of the computer. No real file was at hand: the
//! reader is checked with generated files, from which PINGVerter reads the same.

mod decode;
mod navigation;
mod packet;
#[cfg(test)]
mod tests;

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::Progress;
use crate::survey::Survey;
use packet::{FORMAT, Packet};

const NAME: &str = "Cerulean svlog";
/// Bytes searched for packets where the beginning of a file is damaged.
const SEARCHED_FOR_PACKETS: usize = 1 << 20;
/// Most markers that are tried as the start of a packet before a file counts as another format.
const MOST_TRIES: usize = 16;

/// Reader of the format.
pub(super) struct Cerulean;

impl LogFormat for Cerulean {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let opened = is_log(&opened.bytes).then(|| opened.clone())?;
        Some(Box::new(move |reading, progress| read(&opened, reading, progress)))
    }
}

/// Recognises a file by a packet whose checksum is right and that another packet follows.
fn is_log(bytes: &[u8]) -> bool {
    let next = |from: usize| FORMAT.next(bytes, from, SEARCHED_FOR_PACKETS);
    let mut starts = std::iter::successors(next(0), |at| next(at + 1)).take(MOST_TRIES);
    starts.any(|at| Packet::at(bytes, at).is_some_and(|packet| packet.is_sound()))
}

/// Reads a file that [`is_log`] recognised.
///
/// # Errors
/// When the file contains no profile, or the user cancelled the reading.
fn read(opened: &Opened, reading: &Reading<'_>, progress: &Progress) -> Result<Survey, OpenError> {
    let bytes = &opened.bytes;
    let mut log = Collected::new(&[opened], NAME, reading);
    log.source.device = "Omniscan 450".to_owned();
    let mut reader = decode::Reader::new(bytes, reading);
    let tail = reading.from(0).filter(|_| reader.zero_ms.is_some());
    FORMAT.read(bytes, (0, tail), &mut log, (reading, progress), |log, packet| {
        reader.take(log, packet.start);
    })?;
    reader.finish(&mut log);
    if log.channels.is_empty() {
        return Err(opened.unsupported(format!(
            "this svlog holds no side-scan profile of an Omniscan 450 in its {} bytes, only {}; open the log that was recorded with one",
            bytes.len(),
            reader.summary()
        )));
    }
    Ok(assemble::assemble(log, reading))
}
