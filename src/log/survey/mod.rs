//! Represents a survey as it was recorded, whatever the file format: channels, pings, samples and
//! track. A survey is not changed after it was read.
//!
//! In: pings, samples and fixes from the reader of a format. Out: a survey, and the places of its
//! pings.
//!
//! `samples` reads echoes from the bytes of the file, `track` holds the fixes and compares two
//! tracks of one boat, `observations` finds false positions and recorded depths, `mounting` has the
//! settings of the recorder's mounting on its boat and of the error of its positions, `logs`
//! identifies and names a log among others, `channels` holds the side-scan of several frequencies
//! and the channels that look down, `exclusions` determines the excluded stretches, `relief` holds
//! the shape of the bottom across the track, `growing` extends a log that is still being written,
//! `swath` reads the depths across the track, `water` holds the area and the level of the water,
//! `part` cuts a log. [`navigate`] places every ping on the ground, by `fitted_track` and
//! `local_fit` where a track is fitted; [`turn_rates_deg_s`] computes the turn rate of the boat.

mod channels;
mod exclusions;
mod fitted_track;
mod growing;
mod local_fit;
mod logs;
mod mounting;
mod navigation;
mod observations;
mod part;
mod relief;
mod samples;
mod swath;
mod track;
mod water;

pub use channels::{Echogram, EchogramPing, SidePair};
pub use exclusions::{
    ExcludedStretch, ExclusionReason, ExclusionSettings, Exclusions, LogPart, Stretch,
};
pub(crate) use fitted_track::KnownTimes;
pub use growing::{Seam, StretchStart, SurveyVersions};
pub use logs::{Apart, Identity, apart, distinct_names};
pub use mounting::{MountingSettings, PositionShift, arm_in_words};
pub use navigation::{
    HeadingSettings, HeadingSource, Navigation, PingNav, PositionSettings, Projection, navigate,
    navigate_with, turn_rates_deg_s,
};
pub use observations::{
    FaultCounts, SoundingFault, differ_as_no_bed, is_step_of_no_bed, mark_faults,
};
pub(crate) use observations::{NEAREST_SOUNDING_S, drop_false_fixes, give_depths};
pub use relief::{AcrossTrack, Relief};
pub use samples::{Bytes, Encoding, LEVEL_BITS, NumberKind, SampleOrder, Samples, SideSpan};
pub(crate) use swath::{SWATH_PAIR, swath_pair_m};
pub use swath::{SwathPing, SwathSounding};
pub use track::{ExternalTrack, Fix, ProjectedTrack, Track, TrackSettings, TracksApart};
pub use water::{Gauge, WATER_LEVELS_M, WaterArea};

use crate::support::file_error::FileError;
use crate::support::geo::{LocalFrame, distance_m};
use crate::support::mapped_file::FileFault;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// The side of the boat that a beam looks to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Left of the boat, looking forward.
    Port,
    /// Right of the boat, looking forward.
    Starboard,
}

impl Side {
    /// Both sides, port first: the order of arrays with an entry for each side, indexed by `side as
    /// usize`.
    pub const BOTH: [Side; 2] = [Side::Port, Side::Starboard];

    /// Converts a distance outward on this side to a distance to starboard, and back.
    pub fn to_starboard<T: std::ops::Neg<Output = T>>(self, outward: T) -> T {
        match self {
            Side::Port => -outward,
            Side::Starboard => outward,
        }
    }

    /// Returns the other side.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Side::Port => Side::Starboard,
            Side::Starboard => Side::Port,
        }
    }

    /// Returns the name: `port` or `starboard`.
    pub fn name(self) -> &'static str {
        match self {
            Side::Port => "port",
            Side::Starboard => "starboard",
        }
    }
}

/// Kind of data that a channel of the log recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ChannelKind {
    /// Traditional sonar, first transducer element or frequency.
    Primary,
    /// Traditional sonar, second frequency.
    Secondary,
    /// Down-imaging sonar.
    DownScan,
    /// Side-scan, port side only.
    Port,
    /// Side-scan, starboard side only.
    Starboard,
    /// Side-scan, both sides in one frame.
    Composite,
    /// Depths across the track, measured by the recorder.
    Swath,
    /// A channel that Bathyscope counts but does not use, with the number that the recorder gives
    /// it.
    Other(u16),
}

impl From<Side> for ChannelKind {
    fn from(side: Side) -> Self {
        match side {
            Side::Port => ChannelKind::Port,
            Side::Starboard => ChannelKind::Starboard,
        }
    }
}

impl ChannelKind {
    /// Returns the side of a channel with one side only.
    pub(crate) fn side(self) -> Option<Side> {
        Side::BOTH.into_iter().find(|side| self == ChannelKind::from(*side))
    }

    /// Returns true for a channel of the sonar that looks down.
    pub(crate) fn looks_down(self) -> bool {
        matches!(self, ChannelKind::Primary | ChannelKind::Secondary | ChannelKind::DownScan)
    }

    /// Returns the name for tables and messages.
    pub fn name(self) -> String {
        match self {
            ChannelKind::Primary => "primary".into(),
            ChannelKind::Secondary => "secondary".into(),
            ChannelKind::DownScan => "down-scan".into(),
            ChannelKind::Port => "side-scan port".into(),
            ChannelKind::Starboard => "side-scan starboard".into(),
            ChannelKind::Composite => "side-scan".into(),
            ChannelKind::Swath => "swath".into(),
            ChannelKind::Other(number) => format!("channel {number}"),
        }
    }
}

/// Summary of a channel of the log, for `info` and the open dialog.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Kind of the recorded data.
    pub kind: ChannelKind,
    /// The recorder's own number or name of the channel, as text.
    pub recorder_name: String,
    /// Frequency, kHz; `None` where the recorder does not state it.
    pub frequency_khz: Option<f32>,
    /// Number of pings read.
    pub ping_count: usize,
    /// First and last time, seconds after the log's time zero; may be negative. `None` where the
    /// channel has no times.
    pub time_span_s: Option<(f64, f64)>,
    /// Smallest and largest number of samples in a ping (of one side, for side-scan).
    pub sample_count: (usize, usize),
    /// Smallest near and largest far limit of the recorded range, metres; `None` where there is
    /// none.
    pub range_m: Option<(f32, f32)>,
}

/// A side-scan ping: the samples of one or both sides at one time, with the recorded depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SidePing {
    /// Seconds after the log's time zero; may be negative.
    pub time_s: f64,
    /// Recorded depth below the transducer, metres, from the sounding nearest in time; NaN when
    /// there is none.
    pub depth_m: f32,
    /// The fault of the sounding that `depth_m` is from ([`Sounding::fault`]).
    pub depth_fault: Option<SoundingFault>,
    /// Span of the port samples; `None` where that side was not recorded for this ping.
    pub port: Option<SideSpan>,
    /// Span of the starboard samples; `None` where that side was not recorded for this ping.
    pub starboard: Option<SideSpan>,
}

impl SidePing {
    /// Creates a ping without echoes, with a depth without a fault.
    pub fn with_depth(time_s: f64, depth_m: f32) -> Self {
        Self { time_s, depth_m, depth_fault: None, port: None, starboard: None }
    }

    /// Returns the recorded depth, metres; NaN where there is none, or where it has a fault.
    pub fn good_depth_m(&self) -> f32 {
        if self.depth_fault.is_none() && self.depth_m > 0.0 { self.depth_m } else { f32::NAN }
    }

    /// Returns the span of the samples of one side; `None` where the side was not recorded.
    pub fn side(&self, side: Side) -> Option<&SideSpan> {
        match side {
            Side::Port => self.port.as_ref(),
            Side::Starboard => self.starboard.as_ref(),
        }
    }
}

/// A depth from the recorder's own bottom lock, one per ping of the channel that the bottom lock
/// uses (the traditional sonar where there is one). The readers leave out the copies in other
/// channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sounding {
    /// Seconds after the log's time zero.
    pub time_s: f64,
    /// Depth below the transducer, metres (keel offset removed where the log states one).
    pub depth_m: f32,
    /// The fault that makes the depth false, found by [`mark_faults`] or from the side-scan; `None`
    /// where no fault is known.
    pub fault: Option<SoundingFault>,
}

impl Sounding {
    /// Returns a sounding without a fault.
    pub fn new(time_s: f64, depth_m: f32) -> Self {
        Self { time_s, depth_m, fault: None }
    }

    /// Returns true if no fault of the sounding is known.
    pub fn is_good(&self) -> bool {
        self.fault.is_none()
    }
}

/// Usability of the survey's side-scan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum SideScanState {
    /// The side-scan has a picture.
    Usable,
    /// The log holds no side-scan frames.
    #[default]
    Absent,
    /// There are side-scan frames but no picture: no transducer was connected, and the range is
    /// stuck.
    Noise {
        /// The stuck range, metres.
        range_m: f32,
    },
}

/// Source of the slant ranges in a log's headers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RangeSource {
    /// The range that a fish-finder shows. The log states neither the range of the first sample nor
    /// the delay of the filters.
    #[default]
    FishFinder,
    /// The log states no range: it is estimated from the size of the transducer (Humminbird), and
    /// may be wrong by some percent.
    Estimated,
    /// The range that a survey recorder states, from the time since the transmission and the speed
    /// of sound (XTF).
    SurveyRecorder,
}

/// Files of a log, their format and the recorder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Source {
    /// The files that were read, first the one that the user opened.
    pub files: Vec<PathBuf>,
    /// Format in words, for example `Lowrance SL2 (version 1)`.
    pub format: String,
    /// Name of the unit that recorded the log, as the log states it, for example `EdgeTech 4200`;
    /// empty where it states none.
    pub device: String,
    /// Number of bytes of the log's own files together, without those of a track that was applied
    /// to it.
    pub byte_count: u64,
}

impl Source {
    /// Returns a name of the recorder, as far as the log states it: the format, and the device
    /// where the log names one. Logs of the same recorder return the same name.
    pub fn recorder(&self) -> String {
        if self.device.is_empty() {
            self.format.clone()
        } else {
            format!("{}, {}", self.format, self.device)
        }
    }
}

/// A fault of the log that did not prevent the rest of it from being read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Index into [`Source::files`] and byte offset; `None` for a fault without a place.
    pub place: Option<(usize, u64)>,
    /// One sentence: the fault, and what the reader did about it.
    pub text: String,
}

/// A recorded survey. All vectors are in time order. The default survey is empty, and readers fill
/// its fields. A clone shares the bytes.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// Files that the survey was read from.
    pub source: Source,
    /// Unix seconds of the log's time zero, with the clock offset added; `None` where the recorder
    /// did not know the time.
    pub start_unix_s: Option<f64>,
    /// Seconds added to the recorder's clock ([`MountingSettings::clock_offset_s`]).
    pub clock_offset_s: f64,
    /// Seconds taken off the times of the soundings ([`MountingSettings::sounding_lag_s`]).
    pub sounding_lag_s: f64,
    /// True if port and starboard are exchanged against the recording
    /// ([`MountingSettings::swap_sides`]).
    pub swapped_sides: bool,
    /// Summary of each channel.
    pub channels: Vec<Channel>,
    /// The side-scan pings, both sides joined; shared by all copies of a survey, such as those with
    /// another track.
    pub side_scan: Arc<Vec<SidePing>>,
    /// All pairs of side-scan channels where the sonar has several frequencies, first the pair that
    /// is shown; empty where there is only one pair.
    pub pairs: Vec<SidePair>,
    /// Usability of the side-scan.
    pub side_scan_state: SideScanState,
    /// Source of the slant ranges.
    pub range_source: RangeSource,
    /// Channels that look down.
    pub echograms: Vec<Echogram>,
    /// Depths under the boat; shared by all copies of a survey.
    pub soundings: Arc<Vec<Sounding>>,
    /// The channel that the soundings are from; `None` where that is not known.
    pub sounding_channel: Option<ChannelKind>,
    /// Depths across the track, where the recorder measures them; shared by all copies of a survey.
    pub swath: Arc<Vec<SwathPing>>,
    /// Positions, courses and compass headings.
    pub track: Track,
    /// Faults of the log that were found when it was read.
    pub warnings: Vec<Warning>,
    /// The bytes of the files and of the samples in them, one entry per file.
    pub bytes: Vec<Bytes>,
}

impl Survey {
    /// Creates a survey with side-scan pings and nothing else.
    pub fn of_pings(pings: impl IntoIterator<Item = SidePing>) -> Self {
        Self { side_scan: Arc::new(pings.into_iter().collect()), ..Self::default() }
    }

    /// Returns the place of the samples of one side of one ping; `None` when the ping or the side
    /// was not recorded.
    pub fn span(&self, ping: usize, side: Side) -> Option<&SideSpan> {
        self.side_scan.get(ping)?.side(side)
    }

    /// Returns the samples of one side of one ping; `None` when the ping or the side was not
    /// recorded, or its samples are outside of the bytes.
    pub fn samples(&self, ping: usize, side: Side) -> Option<Samples<'_>> {
        self.samples_of(self.span(ping, side)?)
    }

    /// Returns the samples of a span of any channel; `None` where the span is outside of the bytes.
    pub fn samples_of(&self, span: &SideSpan) -> Option<Samples<'_>> {
        Samples::new(self.bytes.get(usize::from(span.file))?.samples(), span)
    }

    /// Checks that the files still have the data that was read from them. The check reads the state
    /// of the files from their disks, so it may block on a disk that does not answer.
    ///
    /// # Errors
    /// Names the first file that was cut or overwritten since the log was opened, or that could not
    /// be read to its end.
    pub fn check_files(&self) -> Result<(), FileError<FileFault>> {
        let mut files = self.source.files.iter().zip(&self.bytes);
        let fault = files.find_map(|(path, bytes)| Some(FileError::new(bytes.fault(path)?, path)));
        fault.map_or(Ok(()), Err)
    }

    /// Returns [`SidePing::good_depth_m`] of a ping; NaN beyond the last ping.
    pub fn good_depth_m(&self, ping: usize) -> f32 {
        self.side_scan.get(ping).map_or(f32::NAN, SidePing::good_depth_m)
    }

    /// Returns the name of the survey for users: the stem of the opened file, or `survey`.
    pub fn name(&self) -> String {
        let stem = self.source.files.first().and_then(|file| file.file_stem());
        stem.map_or_else(|| "survey".into(), |stem| stem.to_string_lossy().into_owned())
    }

    /// Returns the log in a local coordinate frame that it shares with other logs: all logs of one
    /// survey are in the frame of the first log's track, so that their coordinates agree. The
    /// samples are shared, not copied.
    #[must_use]
    pub fn in_frame(self, frame: &LocalFrame) -> Self {
        Self { track: self.track.in_frame(frame), ..self }
    }

    /// Returns the log in the local coordinate frame that a project stores, as [`Survey::in_frame`]
    /// does. Where the logs of the project were replaced by logs of other waters, so far away that
    /// the plane of the frame would distort their tracks, the log stays in its own frame.
    #[must_use]
    pub fn in_frame_if_near(self, frame: &LocalFrame) -> Self {
        // At this distance lengths are short by 0.05 %, `d^2 / 2 R^2`; a quarter of the Earth away
        // all places are on one line.
        const FARTHEST_M: f64 = 200_000.0;
        let first = self.track.fixes.first();
        if first.is_some_and(|fix| distance_m(fix.position, frame.origin()) > FARTHEST_M) {
            self
        } else {
            self.in_frame(frame)
        }
    }

    /// Returns the first and last time over all channels, seconds after the log's time zero; `None`
    /// where no channel has times.
    pub fn time_span_s(&self) -> Option<(f64, f64)> {
        let spans = self.channels.iter().filter_map(|channel| channel.time_span_s);
        spans.reduce(|(from, to), (other_from, other_to)| (from.min(other_from), to.max(other_to)))
    }

    /// Returns true if the recording has a position.
    pub fn has_place(&self) -> bool {
        !self.track.fixes.is_empty()
    }

    /// Returns true if the side-scan can be processed.
    pub fn has_side_scan(&self) -> bool {
        self.side_scan_state == SideScanState::Usable
    }
}

/// Returns the index of the item nearest to `time_s`, the earlier of two equally near; `None`
/// without items. `items` are in the order of `time_of`, seconds.
pub fn nearest_in_time<T>(items: &[T], time_s: f64, time_of: impl Fn(&T) -> f64) -> Option<usize> {
    let after = items.partition_point(|item| time_of(item) < time_s);
    let before = after.saturating_sub(1);
    match (items.get(before), items.get(after)) {
        (Some(a), Some(b)) if time_of(b) - time_s < time_s - time_of(a) => Some(after),
        (Some(_), _) => Some(before),
        (None, _) => None,
    }
}

/// Returns the item nearest to `time_s` as [`nearest_in_time`] does; `None` where none is within
/// `within_s`.
pub(crate) fn nearest_within<T>(
    items: &[T],
    time_s: f64,
    within_s: f64,
    time_of: impl Fn(&T) -> f64,
) -> Option<&T> {
    let nearest = &items[nearest_in_time(items, time_s, &time_of)?];
    ((time_of(nearest) - time_s).abs() <= within_s).then_some(nearest)
}

/// Returns the index ranges of the runs of items in which each belongs together with the next.
fn run_ranges<T>(
    items: &[T],
    together: impl Fn(&T, &T) -> bool,
) -> impl Iterator<Item = Range<usize>> {
    let mut end = 0;
    items.chunk_by(together).map(move |run| {
        end += run.len();
        end - run.len()..end
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_found_before_between_and_beyond() {
        let times = [1.0, 2.0, 4.0];
        let nearest = |time_s| nearest_in_time(&times, time_s, |time| *time);
        assert_eq!(nearest(-3.0), Some(0));
        assert_eq!(nearest(1.5), Some(0));
        assert_eq!(nearest(1.6), Some(1));
        assert_eq!(nearest(3.5), Some(2));
        assert_eq!(nearest(9.0), Some(2));
        assert_eq!(nearest_in_time(&[] as &[f64], 0.0, |time| *time), None);
    }
}
