//! Defines the settings of a recorder's mounting on its boat (place of the transducer relative to
//! the antenna, exchanged sides, errors of compass and clock) and of the error of its positions.

use super::observations::give_depths;
use super::{Channel, SidePing, Survey};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The `mounting.*` settings of one log. The default is a recorder without errors whose antenna is
/// right above its transducer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MountingSettings {
    /// True if the side recorded as port is starboard, and the other way round.
    pub swap_sides: bool,
    /// Distance from the antenna to the transducer along the boat, metres; positive forward.
    pub forward_m: f64,
    /// Distance from the antenna to the transducer across the boat, metres; positive to starboard.
    pub right_m: f64,
    /// Added to the recorded compass heading, degrees: the sum of the turn of the compass on the
    /// boat and the magnetic variation.
    pub heading_offset_deg: f64,
    /// Added to the log's clock, seconds: the time by which the clock is behind UTC.
    pub clock_offset_s: f64,
    /// Delay of the recorded positions after the echoes recorded with them, seconds.
    pub latency_s: f64,
    /// Delay of the recorded depths after the echoes recorded with them, seconds.
    pub sounding_lag_s: f64,
}

impl MountingSettings {
    /// Returns true if there is nothing to correct.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the distances from antenna to transducer, metres forward and to starboard; `None`
    /// where both are 0.
    pub fn lever_arm_m(&self) -> Option<[f64; 2]> {
        let arm = [self.forward_m, self.right_m];
        (arm != [0.0; 2]).then_some(arm)
    }

    /// Describes the corrections in sentences; empty where there are none. `compass` is true if
    /// headings come from the compass.
    pub fn statement(&self, compass: bool) -> String {
        let mut said = Vec::new();
        if self.swap_sides {
            said.push(
                "Port and starboard are exchanged: the recorder has them the other way round."
                    .to_owned(),
            );
        }
        if let Some([forward_m, right_m]) = self.lever_arm_m() {
            said.push(format!(
                "Positions are those of the transducer, {} of the antenna.",
                arm_in_words([forward_m, right_m], |metres| format!("{metres} m"))
            ));
        }
        if self.latency_s != 0.0 {
            said.push(format!(
                "Positions are those of {} s {}: so much {} they are recorded than echoes.",
                self.latency_s.abs(),
                if self.latency_s > 0.0 { "later" } else { "before" },
                if self.latency_s > 0.0 { "later" } else { "earlier" },
            ));
        }
        if self.sounding_lag_s != 0.0 {
            said.push(format!(
                "Soundings count {} s before they are recorded: the recorder is so late.",
                self.sounding_lag_s
            ));
        }
        if self.heading_offset_deg != 0.0 {
            said.push(if compass {
                format!("{:+} degrees are added to the compass heading.", self.heading_offset_deg)
            } else {
                "The heading offset is not in force: headings do not come from the compass."
                    .to_owned()
            });
        }
        if self.clock_offset_s != 0.0 {
            said.push(format!("{:+} s are added to the log's clock.", self.clock_offset_s));
        }
        said.join(" ")
    }
}

/// The `position_shift.*` settings of one log: the correction of an error that all its positions
/// share. A receiver without corrections is off by a metre or two, which changes little in an hour;
/// crossings with other logs show this error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PositionShift {
    /// Added to every position, metres to the east.
    pub east_m: f64,
    /// Added to every position, metres to the north.
    pub north_m: f64,
}

impl PositionShift {
    /// Returns the shift, metres east and north; `None` where it is 0.
    pub(crate) fn by_m(&self) -> Option<[f64; 2]> {
        let by_m = [self.east_m, self.north_m];
        (by_m != [0.0; 2]).then_some(by_m)
    }

    /// Describes the shift of the positions in a sentence; empty where there is none.
    pub fn statement(&self) -> String {
        let ways = [["east", "west"], ["north", "south"]];
        let by = ways_in_words([self.east_m, self.north_m], ways, |m| format!("{m} m"));
        if by.is_empty() { by } else { format!("Positions are moved by {by}.") }
    }
}

/// Describes a lever arm in words, `1.2 m forward and 0.3 m to port`; `length` formats the lengths.
pub fn arm_in_words([forward_m, right_m]: [f64; 2], length: impl Fn(f64) -> String) -> String {
    let ways = [["forward", "aft"], ["to starboard", "to port"]];
    ways_in_words([forward_m, right_m], ways, length)
}

/// Describes two distances in words, each with the name of its direction: `1.2 m east and 0.3 m
/// south`; empty where both are 0.
fn ways_in_words(
    distances_m: [f64; 2],
    ways: [[&str; 2]; 2],
    length: impl Fn(f64) -> String,
) -> String {
    let distances = distances_m.into_iter().zip(ways);
    let parts = distances.filter(|(metres, _)| *metres != 0.0);
    let parts = parts.map(|(metres, [positive, negative])| {
        let way = if metres > 0.0 { positive } else { negative };
        format!("{} {way}", length(metres.abs()))
    });
    parts.collect::<Vec<_>>().join(" and ")
}

impl Survey {
    /// Returns the log with its sides, its clock and the times of its soundings corrected by the
    /// mounting. Lever arm, latency and heading offset are applied where pings are placed
    /// ([`super::navigate_with`]).
    #[must_use]
    pub fn mounted(mut self, mounting: &MountingSettings) -> Self {
        if mounting.swap_sides {
            let exchanged =
                |ping: &SidePing| SidePing { port: ping.starboard, starboard: ping.port, ..*ping };
            self.side_scan = Arc::new(self.side_scan.iter().map(exchanged).collect());
            self.channels.iter_mut().for_each(exchange_channel);
            self.swapped_sides = !self.swapped_sides;
        }
        self.start_unix_s = self.start_unix_s.map(|start_s| start_s + mounting.clock_offset_s);
        self.clock_offset_s += mounting.clock_offset_s;
        if mounting.sounding_lag_s != 0.0 {
            self.sounding_lag_s += mounting.sounding_lag_s;
            for sounding in Arc::make_mut(&mut self.soundings).iter_mut() {
                sounding.time_s -= mounting.sounding_lag_s;
            }
            let pings: &mut Vec<SidePing> = Arc::make_mut(&mut self.side_scan);
            give_depths(pings, &self.soundings);
        }
        self
    }
}

fn exchange_channel(channel: &mut Channel) {
    if let Some(side) = channel.kind.side() {
        channel.kind = side.other().into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{Side, SideSpan};

    #[test]
    fn an_arm_is_said_in_words() {
        let said = |arm| arm_in_words(arm, |metres| format!("{metres} m"));
        assert_eq!(said([1.2, -0.3]), "1.2 m forward and 0.3 m to port");
        assert_eq!(said([-2.0, 0.0]), "2 m aft");
        assert_eq!(said([0.0, 0.5]), "0.5 m to starboard");
        let mounting = MountingSettings {
            forward_m: -2.0,
            heading_offset_deg: 3.5,
            ..MountingSettings::default()
        };
        assert!(mounting.statement(true).contains("2 m aft of the antenna"));
        assert!(mounting.statement(true).contains("+3.5 degrees"));
        assert!(mounting.statement(false).contains("not in force"));
        assert_eq!(MountingSettings::default().statement(true), "");
    }

    #[test]
    fn exchanged_twice_a_log_is_as_it_was() {
        let span = |offset| SideSpan { offset, ..SideSpan::of_bytes(10, [0.0, 5.0]) };
        let survey = Survey {
            start_unix_s: Some(100.0),
            side_scan: Arc::new(vec![SidePing {
                port: Some(span(1)),
                ..SidePing::with_depth(0.0, 3.0)
            }]),
            ..Survey::default()
        };
        let mounting = MountingSettings {
            swap_sides: true,
            clock_offset_s: 2.5,
            latency_s: 0.6,
            ..MountingSettings::default()
        };
        let once = survey.clone().mounted(&mounting);
        assert!(once.swapped_sides && once.span(0, Side::Port).is_none());
        assert_eq!(once.span(0, Side::Starboard), Some(&span(1)));
        assert_eq!(once.start_unix_s, Some(102.5));
        let twice = once.mounted(&mounting);
        assert!(!twice.swapped_sides);
        assert_eq!(twice.side_scan, survey.side_scan);
    }

    #[test]
    fn a_shift_is_said_in_words() {
        let shift = |east_m, north_m| PositionShift { east_m, north_m };
        assert_eq!(shift(0.0, 0.0).statement(), "");
        let said = shift(1.25, -0.5).statement();
        assert_eq!(said, "Positions are moved by 1.25 m east and 0.5 m south.");
        assert_eq!(shift(-2.0, 0.0).statement(), "Positions are moved by 2 m west.");
    }
}
