//! The two side-scan channels that are shown, of as many as the file has.

use super::channels;
use super::raw::PingChannel;
use crate::formats::collected::{Collected, HalfPing, is_sound};
use crate::formats::report::WarningKind;
use crate::survey::{ChannelKind, Encoding, SideSpan};

/// Speed of sound where the file gives a time instead of a range, metres a second.
const SOUND_MPS: f32 = 1500.0;

/// One channel of one ping.
#[derive(Clone, Copy, Debug)]
pub(super) struct Recorded {
    /// Its header.
    pub(super) header: PingChannel,
    /// What the channel is.
    pub(super) kind: ChannelKind,
    /// Bytes a sample.
    pub(super) width: usize,
    /// Offset of the first sample.
    pub(super) first: usize,
    /// Seconds after the log's time zero.
    pub(super) time_s: f64,
}

impl Recorded {
    /// Slant range of the last sample.
    pub(super) fn far_m(&self) -> f32 {
        if self.header.slant_range_m > 0.0 {
            self.header.slant_range_m
        } else {
            self.header.time_duration_s * SOUND_MPS / 2.0
        }
    }
}

/// Chooses the first port and the first starboard channel; programs that record two frequencies have two of each.
#[derive(Debug, Default)]
pub(super) struct SideChannels {
    port: Option<u16>,
    starboard: Option<u16>,
    hidden: usize,
    unread: usize,
}

impl SideChannels {
    /// Keeps a channel of a ping if it is one that is shown.
    pub(super) fn keep(&mut self, log: &mut Collected, recorded: &Recorded) {
        let (shown, halves) = match recorded.kind {
            ChannelKind::Port => (&mut self.port, &mut log.port),
            ChannelKind::Starboard => (&mut self.starboard, &mut log.starboard),
            _ => return,
        };
        let Some(encoding) = channels::encoding(recorded.width) else {
            self.unread += 1;
            return;
        };
        if *shown.get_or_insert(recorded.header.channel) != recorded.header.channel {
            self.hidden += 1;
            return;
        }
        let span = SideSpan {
            file: 0,
            encoding,
            order: channels::order(recorded.kind),
            offset: recorded.first as u64,
            count: recorded.header.samples,
            near_m: 0.0,
            far_m: recorded.far_m(),
        };
        if is_sound(&span) {
            let time_s = recorded.time_s;
            halves.push(HalfPing { time_s, span });
        } else {
            let text = format!(
                "a side of a ping has {} samples over {} m, which is no picture; it was dropped",
                span.count, span.far_m
            );
            log.report.at(WarningKind::Value, 0, recorded.first, text);
        }
    }

    /// The same channels, with nothing counted yet.
    pub(super) fn after_head(self) -> Self {
        Self {
            hidden: 0,
            unread: 0,
            ..self
        }
    }

    /// Chooses which eight bits of 16-bit samples are shown, the same on both sides, and says what is not shown.
    pub(super) fn finish(&self, bytes: &[u8], log: &mut Collected) {
        let halves = || log.port.iter().chain(&log.starboard);
        let wide: Vec<&SideSpan> = halves()
            .map(|half| &half.span)
            .filter(|span| span.encoding != Encoding::U8)
            .collect();
        let fitting = channels::shift_to_fit(bytes, &wide);
        for half in log.port.iter_mut().chain(&mut log.starboard) {
            if let Encoding::U16 { shift } = &mut half.span.encoding {
                *shift = fitting;
            }
        }
        if self.hidden > 0 {
            log.report.log(format!(
                "{} pings of a second pair of side-scan channels are counted but not shown",
                self.hidden
            ));
        }
        if self.unread > 0 {
            log.report.log(format!(
                "{} pings hold samples of a kind that is not read (neither 1 nor 2 bytes)",
                self.unread
            ));
        }
    }
}
