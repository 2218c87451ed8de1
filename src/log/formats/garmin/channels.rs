//! Determines the kinds of the channels of an RSD file from the beam in the records, because the
//! numbers of channels differ between units.

use super::FileHeader;
use super::record::RecordBody;
use crate::formats::collected::WarningReport;
use crate::survey::{ChannelKind, Survey};
use std::collections::BTreeMap;

/// Lowest frequency of side-scan and down-scan, kHz; the traditional sonar is below. Other readers
/// split at the same frequency.
const LOWEST_SCAN_KHZ: f32 = 300.0;
/// Longest overlap of channels that were recorded one after the other, seconds; but at most half of
/// the shorter channel.
const SLACK_S: f64 = 2.0;
/// Factor of pings: a channel with less than this fraction (1/8) of the pings of another channel of
/// its role comes after that channel, whatever its number.
const FEW: usize = 8;
/// Number of channels without a number; the number of their beam is added.
pub(super) const UNNUMBERED: u16 = 65_000;

/// Role of a channel: the direction in which its sonar looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Traditional,
    Port,
    Starboard,
    Down,
    Other,
}

impl Role {
    /// Returns the role of the beam in a record, as PINGVerter and sidescantools map it.
    fn of_beam(beam: u32) -> Self {
        match beam {
            1 => Role::Traditional,
            2 => Role::Port,
            3 => Role::Starboard,
            4 => Role::Down,
            _ => Role::Other,
        }
    }

    /// Returns the kinds that channels of the role may have; the first free kind is used.
    fn kinds(self) -> &'static [ChannelKind] {
        match self {
            Role::Traditional => &[ChannelKind::Primary, ChannelKind::Secondary],
            Role::Port => &[ChannelKind::Port],
            Role::Starboard => &[ChannelKind::Starboard],
            Role::Down => &[ChannelKind::DownScan],
            Role::Other => &[],
        }
    }

    fn name(self) -> &'static str {
        match self {
            Role::Traditional => "traditional sonar",
            Role::Port => "side-scan port",
            Role::Starboard => "side-scan starboard",
            Role::Down => "down-scan",
            Role::Other => "another",
        }
    }
}

/// Counts of the pings of a channel, from which its role is determined.
#[derive(Clone, Debug)]
pub(super) struct SeenChannel {
    /// Number of the channel.
    pub(super) number: u16,
    pings: usize,
    with_samples: usize,
    span_s: (f64, f64),
    /// Pings by beam; the first entry counts pings of unknown beams.
    beams: [usize; 5],
    /// Pings whose transducer element is tilted to port, and to starboard.
    tilts: [usize; 2],
}

impl SeenChannel {
    /// Creates the counts of a channel without a ping.
    pub(super) fn new(number: u16) -> Self {
        Self {
            number,
            pings: 0,
            with_samples: 0,
            span_s: (f64::INFINITY, f64::NEG_INFINITY),
            beams: [0; 5],
            tilts: [0; 2],
        }
    }

    /// Counts a ping.
    pub(super) fn add(&mut self, time_s: f64, body: &RecordBody) {
        self.pings += 1;
        self.with_samples += usize::from(body.samples.is_some());
        self.span_s = (self.span_s.0.min(time_s), self.span_s.1.max(time_s));
        if let Some(beam) = body.beam {
            let place = usize::try_from(beam).unwrap_or(0);
            self.beams[if place < self.beams.len() { place } else { 0 }] += 1;
        }
        let tilt = body.tilt.unwrap_or(0.0);
        self.tilts[0] += usize::from(tilt < 0.0);
        self.tilts[1] += usize::from(tilt > 0.0);
    }

    /// Returns the recorder's name for the channel with a number.
    pub(super) fn name(number: u16) -> String {
        match number.checked_sub(UNNUMBERED) {
            Some(beam) => format!("beam {beam}"),
            None => number.to_string(),
        }
    }

    /// Returns the role that most pings state by their beam, else by the tilt of the element;
    /// `None` where they state neither.
    fn stated(&self) -> Option<Role> {
        if self.with_samples == 0 {
            return Some(Role::Other);
        }
        let most = (0..self.beams.len()).max_by_key(|&beam| self.beams[beam])?;
        if self.beams[most] > 0 {
            return Some(Role::of_beam(most as u32));
        }
        match self.tilts {
            [port, starboard] if port > starboard => Some(Role::Port),
            [port, starboard] if starboard > port => Some(Role::Starboard),
            _ => None,
        }
    }

    /// Returns true if both channels were recorded at once for more than a moment.
    fn overlaps(&self, other: &SeenChannel) -> bool {
        let from_s = self.span_s.0.max(other.span_s.0);
        let until_s = self.span_s.1.min(other.span_s.1);
        let length_s = |channel: &SeenChannel| channel.span_s.1 - channel.span_s.0;
        let shorter_s = length_s(self).min(length_s(other));
        until_s - from_s > SLACK_S.min(shorter_s / 2.0)
    }
}

/// Returns the kind of each channel; channels of a known log keep their kind. Warns about guessed
/// roles and about channels that are not shown.
pub(super) fn kinds(
    seen: &[SeenChannel],
    header: &FileHeader,
    known: Option<&Survey>,
    report: &WarningReport,
) -> BTreeMap<u16, ChannelKind> {
    let known_kind = |channel: &SeenChannel| {
        let name = SeenChannel::name(channel.number);
        let mut listed = known?.channels.iter();
        let found = listed.find(|channel| channel.recorder_name == name)?;
        Some((channel.number, found.kind))
    };
    let mut kinds: BTreeMap<u16, ChannelKind> = seen.iter().filter_map(known_kind).collect();
    let new: Vec<&SeenChannel> =
        (seen.iter()).filter(|channel| !kinds.contains_key(&channel.number)).collect();
    for (channel, role) in ordered(&new, header, report) {
        let is_free = |kind: &&ChannelKind| {
            let mut others = seen.iter();
            !others.any(|other| kinds.get(&other.number) == Some(*kind) && channel.overlaps(other))
        };
        let kind = role.kinds().iter().find(is_free).copied();
        if kind.is_none() && role != Role::Other {
            report.log(format!(
                "channel {} ({}) was recorded at the same time as another of its kind; its pings are counted but not shown",
                SeenChannel::name(channel.number),
                role.name()
            ));
        }
        let kind = kind.unwrap_or(ChannelKind::Other(channel.number));
        kinds.insert(channel.number, kind);
    }
    kinds
}

/// Returns the channels with their roles in the order in which they are given a kind: by number,
/// channels with few pings last.
fn ordered<'a>(
    channels: &[&'a SeenChannel],
    header: &FileHeader,
    report: &WarningReport,
) -> Vec<(&'a SeenChannel, Role)> {
    let unstated: Vec<&SeenChannel> =
        (channels.iter().copied()).filter(|channel| channel.stated().is_none()).collect();
    let role = |channel: &'a SeenChannel| {
        let role = channel.stated();
        (channel, role.unwrap_or_else(|| guess(channel, &unstated, header, report)))
    };
    let mut roles: Vec<(&SeenChannel, Role)> = channels.iter().copied().map(role).collect();
    let all = roles.clone();
    let most = |role: Role| {
        let same = all.iter().filter(|(_, other)| *other == role);
        same.map(|(channel, _)| channel.pings).max().unwrap_or(0)
    };
    roles.sort_by_key(|&(channel, role)| {
        (channel.pings.saturating_mul(FEW) < most(role), channel.number)
    });
    roles
}

/// Guesses the role of a channel whose pings state neither a beam nor a side, and warns about the
/// guess: two channels of the same high frequency are a pair, port first; any other number of them
/// looks down; channels of low or unknown frequency are the traditional sonar.
fn guess(
    channel: &SeenChannel,
    unstated: &[&SeenChannel],
    header: &FileHeader,
    report: &WarningReport,
) -> Role {
    let khz = header.frequency_khz(channel.number);
    let is_scan = khz.is_some_and(|khz| khz >= LOWEST_SCAN_KHZ);
    let alike = || unstated.iter().filter(|other| header.frequency_khz(other.number) == khz);
    let lower = alike().filter(|other| other.number < channel.number).count();
    let role = match (is_scan, alike().count(), lower) {
        (true, 2, 0) => Role::Port,
        (true, 2, _) => Role::Starboard,
        (true, ..) => Role::Down,
        (false, ..) => Role::Traditional,
    };
    let frequency = khz.map_or("of no stated frequency".to_owned(), |khz| format!("of {khz} kHz"));
    report.log(format!(
        "channel {}, {frequency}, states neither its beam nor its side; it was taken for {}",
        SeenChannel::name(channel.number),
        role.name()
    ));
    role
}
