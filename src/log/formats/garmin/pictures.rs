//! The samples of the pings: sides of the side-scan, and channels that look down.

use super::depth::DepthEncoding;
use super::record::Ping;
use crate::formats::collected::{Collected, HalfPing, is_range, is_sound};
use crate::formats::report::WarningKind;
use crate::formats::xtf::shift_to_fit;
use crate::survey::{ChannelKind, Encoding, SampleOrder, SideSpan, Survey};
use std::sync::Arc;

/// Near and far limit of a ping's samples, metres, where it states limits that can be.
pub(super) fn range_m(ping: &Ping, depths: DepthEncoding) -> Option<(f32, f32)> {
    let [near, far] = ping.body.range.map(|stored| stored.map(|stored| depths.metres(stored)));
    let (near_m, far_m) = (near.unwrap_or(0.0), far?);
    is_range(near_m, far_m).then_some((near_m, far_m))
}

/// Keeps the samples of a ping that can be a picture; says so where they cannot.
pub(super) fn keep(
    log: &mut Collected,
    kind: ChannelKind,
    ping: &Ping,
    (time_s, range_m): (f64, Option<(f32, f32)>),
) {
    if matches!(kind, ChannelKind::Other(_)) || ping.body.stated_samples == 0 {
        return;
    }
    let (near_m, far_m) = range_m.unwrap_or((0.0, 0.0));
    let span = ping.body.samples.map(|samples| SideSpan {
        file: 0,
        encoding: if samples.is_wide { Encoding::U16 { shift: 0 } } else { Encoding::U8 },
        // Peers show the first sample of both sides at the transducer.
        order: SampleOrder::NearToFar,
        offset: samples.offset as u64,
        count: samples.count,
        near_m,
        far_m,
    });
    let Some(span) = span else {
        let text = format!(
            "a ping says that it has {} samples, which do not lie in its record; it has no picture",
            ping.body.stated_samples
        );
        log.report.at(WarningKind::Frame, 0, ping.offset, text);
        return;
    };
    if !is_sound(&span) {
        let text = format!(
            "a ping has {} samples over no range that can be, which is no picture; it was dropped",
            span.count
        );
        log.report.at(WarningKind::Value, 0, ping.offset, text);
        return;
    }
    match kind {
        ChannelKind::Port => log.port.push(HalfPing { time_s, span }),
        ChannelKind::Starboard => log.starboard.push(HalfPing { time_s, span }),
        _ => log.add_echogram(kind, time_s, span),
    }
}

/// Chooses which eight bits of 16-bit samples are shown: the same on both sides, and the same in
/// all pings of a channel that looks down. Of the tail of a log they are those of the log.
pub(super) fn choose_levels(bytes: &[u8], log: &mut Collected, known: Option<&Survey>) {
    let sides = log.port.iter_mut().chain(&mut log.starboard);
    show_alike(bytes, sides.map(|half| &mut half.span), None);
    for echogram in &mut log.echograms {
        let kind = echogram.kind;
        let mut before = known.into_iter().flat_map(|known| &known.echograms);
        let before = before.find(|one| one.kind == kind);
        let mut before = before.into_iter().flat_map(|one| one.pings.iter().rev());
        let chosen = before.find_map(|ping| shift(&ping.span));
        let pings = Arc::make_mut(&mut echogram.pings);
        show_alike(bytes, pings.iter_mut().map(|ping| &mut ping.span), chosen);
    }
}

fn shift(span: &SideSpan) -> Option<u8> {
    match span.encoding {
        Encoding::U16 { shift } => Some(shift),
        _ => None,
    }
}

fn show_alike<'a>(bytes: &[u8], spans: impl Iterator<Item = &'a mut SideSpan>, chosen: Option<u8>) {
    let wide: Vec<&mut SideSpan> = spans.filter(|span| shift(span).is_some()).collect();
    let fitting = chosen.unwrap_or_else(|| {
        let wide: Vec<&SideSpan> = wide.iter().map(|span| &**span).collect();
        shift_to_fit(bytes, &wide)
    });
    for span in wide {
        span.encoding = Encoding::U16 { shift: fitting };
    }
}
