//! Holds the channels of a log other than the side-scan that is shown: further pairs of side-scan
//! channels, and channels that look down.
//!
//! A sonar of several frequencies records one pair of side-scan channels for each frequency, and
//! one pair is shown. A channel that looks down can be shown in place of the side-scan
//! ([`Survey::looking_down`]).

use super::{ChannelKind, SidePing, SideScanState, SideSpan, Survey, give_depths, nearest_within};
use std::sync::Arc;

/// Largest difference in time between pings of two channels that belong together, seconds.
const LONGEST_APART_S: f64 = 1.0;

/// A pair of side-scan channels, port and starboard.
#[derive(Clone, Debug, PartialEq)]
pub struct SidePair {
    /// The recorder's name of the pair.
    pub name: String,
    /// Frequency, kHz; `None` where the log does not state one.
    pub frequency_khz: Option<f32>,
    /// Pings of the pair in time order, with depths as in [`Survey::side_scan`].
    pub side_scan: Arc<Vec<SidePing>>,
}

impl SidePair {
    /// Describes the pair: `400 kHz, PORT HF`.
    pub fn summary(&self) -> String {
        match self.frequency_khz {
            Some(khz) => format!("{khz} kHz, {}", self.name),
            None => self.name.clone(),
        }
    }
}

impl Survey {
    /// Returns the last recorded side (port, or starboard where the ping has no port) of each pair,
    /// first that of the pair that is shown.
    pub(crate) fn last_spans(&self) -> impl Iterator<Item = SideSpan> {
        let others = self.pairs.iter().skip(1).map(|pair| &pair.side_scan);
        let last = |pings: &Arc<Vec<SidePing>>| {
            let mut pings = pings.iter().rev();
            pings.find_map(|ping| ping.port.or(ping.starboard))
        };
        std::iter::once(&self.side_scan).chain(others).filter_map(last)
    }

    /// Describes the pairs in a sentence: which one is shown, and how to show others; `None` where
    /// there is one at most.
    pub(crate) fn pairs_summary(&self) -> Option<String> {
        let [shown, others @ ..] = &self.pairs[..] else {
            return None;
        };
        let has_choice = self.pairs.iter().any(|pair| pair.frequency_khz.is_some());
        let others: Vec<String> = others.iter().map(SidePair::summary).collect();
        let others = if has_choice {
            format!("set source.frequency_khz to show {}", others.join(" or "))
        } else {
            format!("no frequencies are stated to choose {} by", others.join(" or "))
        };
        Some(format!(
            "the log holds {} pairs of side-scan channels: {} is shown; {others}",
            self.pairs.len(),
            shown.summary(),
        ))
    }

    /// Returns the log with the pair of channels shown whose frequency is nearest to
    /// `frequency_khz`; unchanged where no pair states a frequency.
    #[must_use]
    pub fn with_frequency(mut self, frequency_khz: f64) -> Self {
        let off_khz = |pair: &SidePair| {
            let khz = pair.frequency_khz.map_or(f64::INFINITY, f64::from);
            (khz - frequency_khz).abs()
        };
        let pairs = self.pairs.iter().enumerate();
        let pairs = pairs.filter(|(_, pair)| pair.frequency_khz.is_some());
        let nearest = pairs.min_by(|(_, a), (_, b)| off_khz(a).total_cmp(&off_khz(b)));
        let chosen = nearest.map(|(index, _)| index);
        let Some(chosen) = chosen.filter(|chosen| *chosen > 0) else {
            return self;
        };
        let before = self.pairs_summary().unwrap_or_default();
        self.pairs[..=chosen].rotate_right(1);
        let after = self.pairs_summary().unwrap_or_default();
        for warning in self.warnings.iter_mut().filter(|warning| warning.text == before) {
            warning.text.clone_from(&after);
        }
        self.side_scan = self.pairs[0].side_scan.clone();
        if !self.side_scan.is_empty() {
            self.side_scan_state = SideScanState::Usable;
        }
        self
    }

    /// Returns true if `tail` has a pair that the log does not have.
    pub(super) fn has_new_pair(&self, tail: &Survey) -> bool {
        let is_known = |new: &SidePair| self.pairs.iter().any(|pair| pair.name == new.name);
        !tail.pairs.iter().all(is_known)
    }

    /// Returns the pairs of the log with the pings of `tail` added from a time on. `longer` is the
    /// extended log, with the pings of the pair that is shown, and all soundings.
    pub(super) fn extended_pairs(
        &self,
        tail: &Survey,
        from_s: f64,
        longer: &Survey,
    ) -> Vec<SidePair> {
        let extended = |(index, pair): (usize, &SidePair)| {
            if index == 0 {
                return SidePair { side_scan: longer.side_scan.clone(), ..pair.clone() };
            }
            let older = |pings: &[SidePing]| pings.partition_point(|ping| ping.time_s < from_s);
            let mut pings = pair.side_scan[..older(&pair.side_scan)].to_vec();
            let same = tail.pairs.iter().find(|tail_pair| tail_pair.name == pair.name);
            let added = same.map_or(&[][..], |tail_pair| &tail_pair.side_scan[..]);
            pings.extend_from_slice(&added[older(added)..]);
            give_depths(&mut pings, &longer.soundings);
            SidePair { side_scan: Arc::new(pings), ..pair.clone() }
        };
        self.pairs.iter().enumerate().map(extended).collect()
    }
}

/// One ping of a channel that looks down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchogramPing {
    /// Seconds after the log's time zero; may be negative.
    pub time_s: f64,
    /// Samples of the ping, from the transducer down.
    pub span: SideSpan,
}

/// A channel that looks down.
#[derive(Clone, Debug, PartialEq)]
pub struct Echogram {
    /// Kind of the channel: primary, secondary or down-scan.
    pub kind: ChannelKind,
    /// Pings of the channel in time order; shared by all copies of a survey.
    pub pings: Arc<Vec<EchogramPing>>,
}

impl Survey {
    /// Returns true if the log has the channel `kind`, looking down.
    pub fn has_echogram(&self, kind: ChannelKind) -> bool {
        self.echograms.iter().any(|echogram| echogram.kind == kind)
    }

    /// Returns the log with the echoes of a channel that looks down in place of the starboard
    /// samples, and without port samples. Each side-scan ping gets the echo of the ping of the
    /// channel nearest in time; in a log without side-scan the pings are those of the channel.
    /// `None` where the log does not have the channel.
    pub fn looking_down(&self, kind: ChannelKind) -> Option<Self> {
        let echogram = self.echograms.iter().find(|echogram| echogram.kind == kind)?;
        let recorded = &echogram.pings;
        let side_scan = if self.side_scan.is_empty() {
            recorded.iter().map(|ping| self.below(ping)).collect()
        } else {
            let beside = |ping: &SidePing| {
                let nearest =
                    nearest_within(recorded, ping.time_s, LONGEST_APART_S, |other| other.time_s);
                SidePing { port: None, starboard: nearest.map(|other| other.span), ..*ping }
            };
            self.side_scan.iter().map(beside).collect()
        };
        Some(Self {
            side_scan: Arc::new(side_scan),
            side_scan_state: SideScanState::Usable,
            ..self.clone()
        })
    }

    /// Makes a side-scan ping of a ping of a channel that looks down, with the recorded depth
    /// nearest in time.
    fn below(&self, ping: &EchogramPing) -> SidePing {
        let nearest =
            nearest_within(&self.soundings, ping.time_s, LONGEST_APART_S, |other| other.time_s);
        SidePing {
            time_s: ping.time_s,
            depth_m: nearest.map_or(f32::NAN, |sounding| sounding.depth_m),
            depth_fault: nearest.and_then(|sounding| sounding.fault),
            port: None,
            starboard: Some(ping.span),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{Side, Sounding};

    fn span(offset: u64) -> SideSpan {
        SideSpan { offset, ..SideSpan::of_bytes(10, [0.0, 5.0]) }
    }

    fn log(side_scan: usize) -> Survey {
        let ping = |index: usize| SidePing {
            port: Some(span(1000)),
            ..SidePing::with_depth(index as f64, 3.0)
        };
        let below = |index: u32| EchogramPing {
            time_s: 0.1 + 0.5 * f64::from(index),
            span: span(u64::from(index)),
        };
        Survey {
            side_scan: Arc::new((0..side_scan).map(ping).collect()),
            soundings: Arc::new(vec![Sounding::new(0.0, 4.0)]),
            echograms: vec![Echogram {
                kind: ChannelKind::DownScan,
                pings: Arc::new((0..8).map(below).collect()),
            }],
            ..Survey::default()
        }
    }

    #[test]
    fn each_ping_has_the_echo_of_its_moment() {
        let log = log(9);
        assert!(log.looking_down(ChannelKind::Primary).is_none());
        let down = log.looking_down(ChannelKind::DownScan).expect("a channel");
        assert_eq!(down.side_scan.len(), 9);
        let offset = |ping| down.span(ping, Side::Starboard).map(|span| span.offset);
        // At 2 s the echo of 2.1 s; at 4 s the last echo, of 3.6 s; at 5 s there is none near.
        assert_eq!([0, 2, 4, 5].map(offset), [Some(0), Some(4), Some(7), None]);
        assert!(down.span(2, Side::Port).is_none());
        assert_eq!(down.side_scan[2].depth_m, 3.0);
    }

    #[test]
    fn without_side_scan_the_pings_are_the_channels_own() {
        let down = log(0).looking_down(ChannelKind::DownScan).expect("a channel");
        assert_eq!(down.side_scan.len(), 8);
        assert_eq!(down.side_scan[1].depth_m, 4.0);
        assert!(down.side_scan[7].depth_m.is_nan());
    }
}
