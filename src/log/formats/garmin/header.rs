//! Reads the file header: the time when the recording began, the unit, and the frequencies of its
//! channels.

use super::varstruct::{VarStruct, first_item, varuint, whole_varuint};
use crate::formats::scalar::u32_le;

/// Value of field 0 of the file header.
const MAGIC: u32 = 0xD926_4B7C;
/// Unix seconds of 31 December 1989, 0 h UTC, the start of Garmin's times.
const GARMIN_EPOCH_UNIX_S: f64 = 631_065_600.0;
/// Plausible Unix seconds of logs: from the year 2000, before which no unit recorded, to 2100. The
/// values 0 and all ones are outside.
const UNIX_S: std::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;
/// Plausible frequencies of sonars, Hz.
const SONAR_HZ: std::ops::Range<u32> = 1_000..10_000_000;
/// Most channels that are read from the list in the header.
const MOST_CHANNELS: u32 = 64;

/// Fields of the file header.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FileHeader {
    /// Unix seconds of the start of the recording; `None` where missing or not plausible.
    pub(super) start_unix_s: Option<f64>,
    /// Garmin's number of the unit's model.
    pub(super) product: Option<u32>,
    /// Numbers of channels, each with the middle of its frequency band, kHz.
    pub(super) frequencies: Vec<(u32, f32)>,
}

impl FileHeader {
    /// Reads the header of a file; `None` where the file does not begin with one. Damaged fields
    /// are left empty.
    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        // The number of fields, the key of field 0 with its length of 4, and the magic number.
        if bytes.get(1) != Some(&4) || u32_le(bytes, 2) != Some(MAGIC) {
            return None;
        }
        let Some(fields) = VarStruct::read(bytes, 0) else {
            return Some(Self::default());
        };
        let file = fields.structure(5);
        let seconds = file.and_then(|file| file.unsigned(3));
        let unix_s = seconds.map(|seconds| GARMIN_EPOCH_UNIX_S + f64::from(seconds));
        Some(Self {
            start_unix_s: unix_s.filter(|unix_s| UNIX_S.contains(unix_s)),
            product: file.and_then(|file| file.unsigned(2)),
            frequencies: fields.bytes(6).map_or_else(Vec::new, frequencies),
        })
    }

    /// Returns the middle of a channel's frequency band, kHz; `None` where the header does not list
    /// it.
    pub(super) fn frequency_khz(&self, channel: u16) -> Option<f32> {
        let mut listed = self.frequencies.iter();
        let found = listed.find(|(id, _)| *id == u32::from(channel));
        found.map(|(_, khz)| *khz)
    }
}

/// Reads the frequencies in the list of channels: a count, then one structure after the other.
fn frequencies(list: &[u8]) -> Vec<(u32, f32)> {
    let Some((count, mut at)) = varuint(list, 0) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for _ in 0..count.min(MOST_CHANNELS) {
        let Some(channel) = VarStruct::read(list, at) else {
            break;
        };
        at = channel.end;
        let id = channel.bytes(0).and_then(first_item).and_then(whole_varuint);
        let band = channel.bytes(2).and_then(first_item);
        let band = band.and_then(|item| VarStruct::read(item, 0)?.structure(1));
        let middle_khz = band.and_then(|band| Some((hertz(&band, 1)?, hertz(&band, 2)?)));
        let middle_khz = middle_khz.map(|(low, high)| (low as f32 + high as f32) / 2000.0);
        found.extend(id.zip(middle_khz));
    }
    found
}

/// Reads a frequency, Hz. It is four bytes in some files and an integer of seven bits a byte in
/// others, which takes three bytes below 2 MHz.
fn hertz(band: &VarStruct<'_>, number: usize) -> Option<u32> {
    let hertz = match band.bytes(number)?.len() {
        4 => band.unsigned(number),
        _ => band.varuint(number),
    };
    hertz.filter(|hertz| SONAR_HZ.contains(hertz))
}
