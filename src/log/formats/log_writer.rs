//! Defines the trait of the writers of formats, and the data of a log that all writers use: its
//! records in time order, and the fix of each.

use crate::support::progress::Progress;
use crate::survey::{
    ChannelKind, Fix, Navigation, PingNav, SidePing, SideSpan, Survey, nearest_in_time,
    nearest_within,
};
use std::io::{self, Write};

/// Longest time for which a fix is valid, seconds. Recorders repeat the last fix until the next; a
/// longer pause is a loss of fixes.
const LONGEST_VALID_S: f64 = 10.0;

/// Format of recorders' logs that can be written. The row in [`super::table::FORMATS`] has its
/// name.
pub trait LogWriter: Sync {
    /// Writes a log. Returns a sentence for each kind of data in the log that the format cannot
    /// store.
    ///
    /// # Errors
    /// When writing fails, the work is cancelled, or the format cannot store the log at all.
    fn write(
        &self,
        log: &LogToWrite<'_>,
        out: &mut dyn Write,
        progress: &Progress,
    ) -> io::Result<Vec<String>>;
}

/// A log, or a part of one, to be written.
#[derive(Clone, Copy, Debug)]
pub struct LogToWrite<'a> {
    /// Recorded data.
    pub survey: &'a Survey,
    /// Positions of the boat on the fitted track, in the survey's east-north plane.
    pub navigation: &'a Navigation,
}

/// A record of a log.
#[derive(Clone, Copy, Debug)]
pub enum Recorded<'a> {
    /// A side-scan ping, and its index.
    Side(usize, &'a SidePing),
    /// A ping of a channel that looks down.
    Down {
        /// Kind of the channel.
        kind: ChannelKind,
        /// Index of the ping in its channel.
        index: usize,
        /// Seconds after the log's time zero.
        time_s: f64,
        /// Samples of the ping.
        span: &'a SideSpan,
    },
    /// A depth: its index, and its time in seconds after the log's time zero.
    Sounding(usize, f64),
}

impl Recorded<'_> {
    /// Returns the time, seconds after the log's time zero.
    pub fn time_s(&self) -> f64 {
        match self {
            Recorded::Side(_, ping) => ping.time_s,
            Recorded::Down { time_s, .. } | Recorded::Sounding(_, time_s) => *time_s,
        }
    }
}

impl<'a> LogToWrite<'a> {
    /// Returns all records in time order; at the same time depths come first, then channels that
    /// look down, as recorders write them.
    pub fn records(&self) -> Vec<Recorded<'a>> {
        let survey = self.survey;
        let soundings = survey.soundings.iter().enumerate();
        let soundings =
            soundings.map(|(index, sounding)| Recorded::Sounding(index, sounding.time_s));
        let down = survey.echograms.iter().flat_map(|echogram| {
            let pings = echogram.pings.iter().enumerate();
            pings.map(|(index, ping)| Recorded::Down {
                kind: echogram.kind,
                index,
                time_s: ping.time_s,
                span: &ping.span,
            })
        });
        let sides = survey.side_scan.iter().enumerate();
        let sides = sides.map(|(index, ping)| Recorded::Side(index, ping));
        let mut records: Vec<Recorded<'a>> = soundings.chain(down).chain(sides).collect();
        records.sort_by(|a, b| a.time_s().total_cmp(&b.time_s()));
        records
    }

    /// Returns the fix that is valid at a time: the last fix, unless it is too old.
    pub fn fix(&self, time_s: f64) -> Option<&'a Fix> {
        let fixes = &self.survey.track.fixes;
        let after = fixes.partition_point(|fix| fix.time_s <= time_s);
        let last = fixes.get(after.checked_sub(1)?)?;
        (time_s - last.time_s <= LONGEST_VALID_S).then_some(last)
    }

    /// Returns the position of the boat on the fitted track at the record nearest to a time; `None`
    /// without a record.
    pub fn place(&self, time_s: f64) -> Option<&'a PingNav> {
        let (survey, navigation) = (self.survey, self.navigation);
        let sides = &survey.side_scan;
        if !sides.is_empty() {
            nearest_in_time(sides, time_s, |ping| ping.time_s)
                .and_then(|index| navigation.pings.get(index))
        } else {
            nearest_in_time(&survey.soundings, time_s, |sounding| sounding.time_s)
                .and_then(|index| navigation.soundings.get(index))
        }
    }

    /// Returns the recorded depth nearest to a time, metres below the transducer; NaN where there
    /// is none within two seconds.
    pub fn depth_m(&self, time_s: f64) -> f32 {
        const LONGEST_APART_S: f64 = 2.0;
        let soundings = &self.survey.soundings;
        let near = nearest_within(soundings, time_s, LONGEST_APART_S, |sounding| sounding.time_s);
        near.map_or(f32::NAN, |sounding| sounding.depth_m)
    }
}
