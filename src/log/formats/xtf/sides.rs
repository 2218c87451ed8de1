//! Collects the side-scan channels of a file in pairs; programs that record two frequencies have
//! two channels of each side.

use super::channels::{self, XtfChannel};
use super::levels::{self, Stated};
use super::raw::PingChannel;
use crate::formats::collected::{Collected, CollectedPair, HalfPing, WarningKind, is_sound};
use crate::survey::{Side, SidePing, SideSpan, Survey};
use std::collections::BTreeMap;

/// One channel of one ping.
#[derive(Clone, Copy, Debug)]
pub(super) struct Recorded {
    /// Header of the channel in the ping.
    pub(super) header: PingChannel,
    /// Bytes of a sample.
    pub(super) width: usize,
    /// Offset of the first sample in the file.
    pub(super) first: usize,
    /// Seconds after the log's time zero.
    pub(super) time_s: f64,
    /// Slant range of the first and of the last sample, metres.
    pub(super) range_m: [f32; 2],
}

/// A port and a starboard channel of one frequency, or one of them.
#[derive(Debug, Default)]
struct Pair {
    /// Numbers of the port and of the starboard channel.
    channels: [Option<u16>; 2],
    name: String,
    frequency_khz: Option<f32>,
    stated: Stated,
    halves: [Vec<HalfPing>; 2],
}

/// Collects the sides in pairs; the pair whose first ping came first is shown.
#[derive(Debug, Default)]
pub(super) struct SideChannels {
    pairs: Vec<Pair>,
    is_weighted: bool,
    /// Number of pings that are not read, by bytes of a sample and format.
    unread: BTreeMap<(usize, u8), usize>,
}

impl SideChannels {
    /// Creates a collection without sides. `is_weighted` is true if the sonar's samples count
    /// 2^-weight.
    pub(super) fn new(is_weighted: bool) -> Self {
        Self { is_weighted, ..Self::default() }
    }

    /// Adds a channel of a ping if it is a side.
    pub(super) fn keep(&mut self, log: &mut Collected, channel: &XtfChannel, recorded: &Recorded) {
        let Some(side) = channel.kind.side() else { return };
        let Some(encoding) = channel.encoding(recorded.width) else {
            *self.unread.entry((recorded.width, channel.format)).or_default() += 1;
            return;
        };
        let span = SideSpan {
            encoding,
            order: channels::order(channel.kind),
            offset: recorded.first as u64,
            ..SideSpan::of_bytes(recorded.header.samples, recorded.range_m)
        };
        if is_sound(&span) {
            let time_s = recorded.time_s;
            let pair = self.pair(side, recorded.header.channel, channel);
            pair.halves[side as usize].push(HalfPing { time_s, span });
        } else {
            let text = format!(
                "a side of a ping has {} samples over {} m, which is no picture; it was dropped",
                span.count, span.far_m
            );
            log.report.at(WarningKind::Value, 0, recorded.first, text);
        }
    }

    /// Returns the pair of a channel: its own pair, else one that lacks this side and has no other
    /// frequency, else a new pair.
    fn pair(&mut self, side: Side, number: u16, channel: &XtfChannel) -> &mut Pair {
        let of_side = |pair: &Pair| pair.channels[side as usize];
        let known = self.pairs.iter().position(|pair| of_side(pair) == Some(number));
        let is_partner = |pair: &Pair| {
            let both = pair.frequency_khz.zip(channel.frequency_khz);
            of_side(pair).is_none() && both.is_none_or(|(one, other)| one == other)
        };
        let partner = || self.pairs.iter().position(is_partner);
        let index = known.or_else(partner).unwrap_or(self.pairs.len());
        if index == self.pairs.len() {
            let is_taken = self.pairs.iter().any(|pair| pair.name == channel.name);
            let name = if is_taken {
                format!("{}, channel {number}", channel.name)
            } else {
                channel.name.clone()
            };
            self.pairs.push(Pair { name, ..Pair::default() });
        }
        let pair = &mut self.pairs[index];
        pair.channels[side as usize] = Some(number);
        pair.frequency_khz = pair.frequency_khz.or(channel.frequency_khz);
        pair.stated = Stated {
            is_polar: pair.stated.is_polar || channel.is_polar,
            is_legacy: channel.format == 0,
            is_weighted: self.is_weighted,
        };
        pair
    }

    /// Returns the same pairs of channels without collected pings.
    pub(super) fn after_head(mut self) -> Self {
        for pair in &mut self.pairs {
            pair.halves = Default::default();
        }
        self.unread.clear();
        self
    }

    /// Adds the pairs to the log with their scales, for the tail of a log those of the log `known`,
    /// and warns about pings that are not read.
    pub(super) fn finish(&mut self, bytes: &[u8], log: &mut Collected, known: Option<&Survey>) {
        for mut pair in std::mem::take(&mut self.pairs) {
            let halves = pair.halves.iter_mut().flatten();
            let mut spans: Vec<&mut SideSpan> = halves.map(|half| &mut half.span).collect();
            let known = known.and_then(|known| last_span(known, &pair.name));
            levels::fit(bytes, &mut spans, pair.stated, known);
            let [port, starboard] = pair.halves;
            log.pairs.push(CollectedPair {
                name: pair.name,
                frequency_khz: pair.frequency_khz,
                port,
                starboard,
            });
        }
        for ((width, format), pings) in &self.unread {
            log.report.log(format!(
                "{pings} pings hold samples of {width} bytes (format {format}), which are not read; export them with 1, 2 or 4 bytes"
            ));
        }
    }
}

/// Returns the last span of the pair with this name, or of the shown side-scan.
fn last_span(known: &Survey, name: &str) -> Option<SideSpan> {
    let pair = known.pairs.iter().find(|pair| pair.name == name);
    let pings: &[SidePing] = pair.map_or(&known.side_scan, |pair| &pair.side_scan);
    pings.iter().rev().find_map(|ping| ping.port.or(ping.starboard))
}
