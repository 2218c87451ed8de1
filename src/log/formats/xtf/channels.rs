//! Channels of an XTF file, and the encoding of their samples.

use super::raw::{ChannelInfo, FileHeader, record};
use crate::survey::{ChannelKind, Encoding, NumberKind, SampleOrder};

/// A channel that pings can refer to by its index.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct XtfChannel {
    /// Port, starboard, or another that is only counted.
    pub(super) kind: ChannelKind,
    /// The recorder's name for it.
    pub(super) name: String,
    /// Frequency where it is stated.
    pub(super) frequency_khz: Option<f32>,
    /// Bytes a sample; `None` when the file does not say.
    pub(super) width: Option<usize>,
    /// Number of the format of samples; 0 where only their bytes are stated.
    pub(super) format: u8,
    /// True if samples may have a sign.
    pub(super) is_polar: bool,
    /// Samples of the pings that do not state how many they have.
    pub(super) samples: u32,
    /// The transducer forward and to starboard of the ship's reference point, metres.
    pub(super) offset_m: [f32; 2],
    /// True if the water column was taken out.
    pub(super) ground_range: bool,
}

/// No kind of channel has a higher number.
const LAST_KIND: u8 = 3;

/// The channels that the file header lists. Where one entry is damaged (no channel has samples of
/// no bytes), the kinds of the others are only believed when they say more than zero.
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

/// Guesses a channel that no header describes, from its index: recorders number the sides in pairs,
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

/// A frequency in kHz, of one that some recorders write in Hz; `None` where there is none.
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

/// Port is stored from far to near in XTF, starboard from near to far.
pub(super) fn order(kind: ChannelKind) -> SampleOrder {
    if kind == ChannelKind::Port { SampleOrder::FarToNear } else { SampleOrder::NearToFar }
}

/// A name that is padded with zeros; `None` where it is empty.
pub(super) fn text(padded: &[u8]) -> Option<String> {
    let end = padded.iter().position(|&byte| byte == 0).unwrap_or(padded.len());
    let name = String::from_utf8_lossy(&padded[..end]).trim().to_owned();
    (!name.is_empty()).then_some(name)
}
