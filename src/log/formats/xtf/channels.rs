//! Reads the channels of an XTF file, and determines the encoding of their samples.

use super::raw::{ChannelInfo, FileHeader, record};
use crate::survey::{ChannelKind, Encoding, NumberKind, SampleOrder};

/// A channel to which pings refer by its index.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct XtfChannel {
    /// Port, starboard, or another kind that is only counted.
    pub(super) kind: ChannelKind,
    /// Recorder's name for the channel.
    pub(super) name: String,
    /// Frequency, kHz; `None` where it is not stated.
    pub(super) frequency_khz: Option<f32>,
    /// Bytes of a sample; `None` where the file does not state it.
    pub(super) width: Option<usize>,
    /// XTF's number for the format of samples; 0 where only their bytes are stated.
    pub(super) format: u8,
    /// True if samples may be signed.
    pub(super) is_polar: bool,
    /// Number of samples in pings that do not state it.
    pub(super) samples: u32,
    /// Position of the transducer forward and to starboard of the ship's reference point, metres.
    pub(super) offset_m: [f32; 2],
    /// True if the water column was removed from the samples.
    pub(super) ground_range: bool,
}

/// Highest number of a kind of channel.
const LAST_KIND: u8 = 3;

/// Returns the channels that the file header lists. An entry with 0 bytes a sample is damaged; the
/// kind 0 of any entry is then not trusted but guessed.
pub(super) fn list(bytes: &[u8], header: Option<FileHeader>) -> Vec<XtfChannel> {
    let count = header.map_or(0, |header| usize::from(header.sonar_channels));
    let infos: Vec<ChannelInfo> =
        (0..count).map_while(|index| record(bytes, 256 + 128 * index)).collect();
    let damaged = infos.iter().any(|info| info.bytes_per_sample == 0);
    let channel = |(index, info): (usize, &ChannelInfo)| {
        if (damaged && info.kind == 0) || info.kind > LAST_KIND {
            guess(index as u16)
        } else {
            listed(index as u16, info)
        }
    };
    infos.iter().enumerate().map(channel).collect()
}

fn listed(index: u16, info: &ChannelInfo) -> XtfChannel {
    XtfChannel {
        kind: match info.kind {
            1 => ChannelKind::Port,
            2 => ChannelKind::Starboard,
            _ => ChannelKind::Other(index),
        },
        name: text(&info.name).unwrap_or_else(|| index.to_string()),
        frequency_khz: khz(info.frequency_khz),
        width: Some(usize::from(info.bytes_per_sample)).filter(|width| (1..=8).contains(width)),
        format: info.sample_format,
        is_polar: info.unipolar == 0,
        samples: info.reserved,
        offset_m: [info.offset_y_m, info.offset_x_m],
        ground_range: info.correction == 2,
    }
}

/// Guesses a channel that no header describes from its index: recorders number the sides in pairs,
/// port first.
pub(super) fn guess(index: u16) -> XtfChannel {
    XtfChannel {
        kind: match index {
            0 | 2 => ChannelKind::Port,
            1 | 3 => ChannelKind::Starboard,
            other => ChannelKind::Other(other),
        },
        name: index.to_string(),
        frequency_khz: None,
        width: None,
        format: 0,
        is_polar: false,
        samples: 0,
        offset_m: [0.0; 2],
        ground_range: false,
    }
}

/// Converts a frequency to kHz, which some recorders write in Hz; `None` where it is not plausible.
fn khz(stated: f32) -> Option<f32> {
    let khz = if stated < 10_000.0 { stated } else { stated / 1000.0 };
    Some(khz).filter(|khz| (1.0..10_000.0).contains(khz))
}

impl XtfChannel {
    /// Returns the encoding of samples of `width` bytes, on a scale that is not set yet; `None` for
    /// samples that are not read.
    pub(super) fn encoding(&self, width: usize) -> Option<Encoding> {
        let kind = match (width, self.format) {
            (1, _) => NumberKind::U8,
            (2, _) => NumberKind::U16,
            (4, 1) => NumberKind::IbmF32,
            (4, 5) => NumberKind::F32,
            (4, _) => NumberKind::U32,
            _ => return None,
        };
        Some(Encoding::Number { kind, exponent: 0 })
    }
}

/// Returns the order of samples: in XTF, port is stored from far to near, starboard from near to
/// far.
pub(super) fn order(kind: ChannelKind) -> SampleOrder {
    if kind == ChannelKind::Port { SampleOrder::FarToNear } else { SampleOrder::NearToFar }
}

/// Returns a text that is padded with zeros; `None` where it is empty.
pub(super) fn text(padded: &[u8]) -> Option<String> {
    let end = padded.iter().position(|&byte| byte == 0).unwrap_or(padded.len());
    let name = String::from_utf8_lossy(&padded[..end]).trim().to_owned();
    (!name.is_empty()).then_some(name)
}
