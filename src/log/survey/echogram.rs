//! Channels that look down: what they recorded, ping by ping, and a log shown with one of them.

use super::{ChannelKind, SidePing, SideScanState, SideSpan, Survey, nearest_in_time};
use std::sync::Arc;

/// A ping of another channel farther off in time than this is none of the same moment, seconds.
const LONGEST_APART_S: f64 = 1.0;

/// One ping of a channel that looks down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchogramPing {
    /// Seconds after the log's time zero; may be negative.
    pub time_s: f64,
    /// Its samples, from the transducer down.
    pub span: SideSpan,
}

/// A channel that looks down.
#[derive(Clone, Debug, PartialEq)]
pub struct Echogram {
    /// Primary, secondary or down-scan.
    pub kind: ChannelKind,
    /// Its pings in time order; shared by all copies of a survey.
    pub pings: Arc<Vec<EchogramPing>>,
}

impl Survey {
    /// Returns true if the log has a channel that looks down.
    pub fn has_echogram(&self, kind: ChannelKind) -> bool {
        self.echograms.iter().any(|echogram| echogram.kind == kind)
    }

    /// The same log with the echoes of a channel that looks down in the place of those to
    /// starboard, and none to port: ping by ping the nearest in time, so that its pings are those
    /// of the side-scan. In a log without side-scan they are the channel's own. `None` where there
    /// is no such channel.
    pub fn looking_down(&self, kind: ChannelKind) -> Option<Self> {
        let echogram = self.echograms.iter().find(|one| one.kind == kind)?;
        let recorded = &echogram.pings;
        let side_scan = if self.side_scan.is_empty() {
            recorded.iter().map(|ping| self.below(ping)).collect()
        } else {
            let beside = |ping: &SidePing| {
                let nearest = nearest_in_time(recorded, ping.time_s, |other| other.time_s);
                let nearest = nearest
                    .map(|index| recorded[index])
                    .filter(|other| (other.time_s - ping.time_s).abs() <= LONGEST_APART_S);
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

    /// A ping of its own, with the depth that was recorded then.
    fn below(&self, ping: &EchogramPing) -> SidePing {
        let soundings = &self.soundings;
        let nearest = nearest_in_time(soundings, ping.time_s, |other| other.time_s);
        let nearest = nearest.map(|index| soundings[index]);
        let nearest = nearest.filter(|one| (one.time_s - ping.time_s).abs() <= LONGEST_APART_S);
        SidePing {
            time_s: ping.time_s,
            depth_m: nearest.map_or(f32::NAN, |one| one.depth_m),
            depth_fault: nearest.and_then(|one| one.fault),
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
        // At 2 s those of 2.1 s; at 4 s the last, of 3.6 s; at 5 s none is near.
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
