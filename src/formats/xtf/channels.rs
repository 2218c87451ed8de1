//! What the channels of an XTF file are, and how their samples are stored.

use super::raw::{ChannelInfo, FileHeader, record};
use crate::survey::{ChannelKind, Encoding, SampleOrder, Samples, SideSpan};

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
    /// Whether the water column was taken out.
    pub(super) ground_range: bool,
}

/// No kind of channel has a higher number.
const LAST_KIND: u8 = 3;

/// The channels that the file header lists. Where one entry is damaged (no channel has samples of no bytes), the kinds
/// of the others are only believed when they say more than zero.
pub(super) fn list(bytes: &[u8], header: Option<FileHeader>) -> Vec<XtfChannel> {
    let count = header.map_or(0, |header| usize::from(header.sonar_channels));
    let infos: Vec<ChannelInfo> = (0..count)
        .map_while(|index| record(bytes, 256 + 128 * index))
        .collect();
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
        frequency_khz: Some(info.frequency_khz).filter(|khz| *khz >= 1.0 && *khz < 10_000.0),
        width: Some(usize::from(info.bytes_per_sample)).filter(|width| (1..=8).contains(width)),
        ground_range: info.correction == 2,
    }
}

/// What a channel that no header describes must be: recorders number the sides in pairs, port first.
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
        ground_range: false,
    }
}

/// How samples of `width` bytes are stored; `None` for widths that are no side-scan picture here.
pub(super) fn encoding(width: usize) -> Option<Encoding> {
    match width {
        1 => Some(Encoding::U8),
        2 => Some(Encoding::U16 { shift: 0 }),
        _ => None,
    }
}

/// Port is stored from far to near in XTF, starboard from near to far.
pub(super) fn order(kind: ChannelKind) -> SampleOrder {
    if kind == ChannelKind::Port {
        SampleOrder::FarToNear
    } else {
        SampleOrder::NearToFar
    }
}

/// Pings looked at to find how many bits of a 16-bit sample are in use.
const PINGS_LOOKED_AT: usize = 200;
/// Share of the samples that may be clipped by dropping low bits as if there were no more.
const CLIPPED_SHARE: f64 = 0.001;

/// How many low bits of samples of 16 or 32 bits to drop so that nearly all fit a byte.
pub(in crate::formats) fn shift_to_fit(bytes: &[u8], spans: &[&SideSpan]) -> u8 {
    let mut histogram = [0_u64; 33];
    for span in spans.iter().step_by(spans.len() / PINGS_LOOKED_AT + 1) {
        let width = span.encoding.width();
        let wide = SideSpan {
            count: span.count.saturating_mul(width as u32),
            encoding: Encoding::U8,
            order: SampleOrder::NearToFar,
            ..**span
        };
        let Some((stored, _)) = Samples::new(bytes, &wide).and_then(|samples| samples.stored_u8())
        else {
            continue;
        };
        for sample in stored.chunks_exact(width) {
            let add = |value: u32, byte: &u8| value << 8 | u32::from(*byte);
            let value = sample.iter().rev().fold(0, add);
            histogram[(u32::BITS - value.leading_zeros()) as usize] += 1;
        }
    }
    let total: u64 = histogram.iter().sum();
    let mut beyond = 0;
    for bits in (9..histogram.len()).rev() {
        beyond += histogram[bits];
        if beyond as f64 > CLIPPED_SHARE * total as f64 {
            return (bits - 8) as u8;
        }
    }
    0
}

/// A zero-padded name; `None` when it is empty.
/// A name that is padded with zeros; `None` where it is empty.
pub(super) fn text(padded: &[u8]) -> Option<String> {
    let end = padded
        .iter()
        .position(|&byte| byte == 0)
        .unwrap_or(padded.len());
    let name = String::from_utf8_lossy(&padded[..end]).trim().to_owned();
    (!name.is_empty()).then_some(name)
}
