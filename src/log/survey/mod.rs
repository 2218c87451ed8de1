//! A survey as it was recorded: channels, pings, samples and track; immutable after load, whatever
//! the file format.
//!
//! In: pings, samples and fixes, as a format gives them. Out: a survey, and the places of its
//! pings.
//!
//! `samples` reads echoes where they lie in the file, `track` holds the fixes, and how far two
//! tracks of one boat lie apart, `observations` says which positions and recorded depths can be
//! believed, `mounting` says how the recorder is mounted on its boat, and by how much its positions
//! are off, `logs` identifies and names a log among others, `channels` holds the side-scan of
//! several frequencies and the channels that look down, `exclusions` which stretches count for
//! nothing, `relief` how the bottom lies across the track, `growing` what becomes of a log that is
//! still being written, `swath` the depths across the track, `water` the area and the level of the
//! water, `part` cuts a log. [`navigate`] places every ping on the ground, by `fitted_track` and
//! its `local_fit` where a track is fitted; [`turn_rates_deg_s`] says how fast the boat turns.

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
    /// Both sides, port first: the order of what is kept for each side, by `side as usize`.
    pub const BOTH: [Side; 2] = [Side::Port, Side::Starboard];

    /// A distance outward on this side as one to starboard, and one to starboard as one outward.
    pub fn to_starboard<T: std::ops::Neg<Output = T>>(self, outward: T) -> T {
        match self {
            Side::Port => -outward,
            Side::Starboard => outward,
        }
    }

    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Side::Port => Side::Starboard,
            Side::Starboard => Side::Port,
        }
    }

    /// `port` or `starboard`.
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
    /// A channel that Bathyscope counts but does not use, with the recorder's number for it.
    Other(u16),
}

impl ChannelKind {
    /// A word or two for tables and messages.
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

/// One channel of the log: a summary for `info` and the open dialog.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Kind of the recorded data.
    pub kind: ChannelKind,
    /// The recorder's own number or name of the channel, as text.
    pub recorder_name: String,
    /// Frequency in kHz where the recorder states it.
    pub frequency_khz: Option<f32>,
    /// Pings read.
    pub ping_count: usize,
    /// First and last time, seconds after the log's time zero; may be negative.
    pub time_span_s: Option<(f64, f64)>,
    /// Fewest and most samples in a ping (of one side, for side-scan).
    pub sample_count: (usize, usize),
    /// Smallest near and largest far limit of the recorded range, metres.
    pub range_m: Option<(f32, f32)>,
}

/// One side-scan ping: what was recorded on one or both sides at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SidePing {
    /// Seconds after the log's time zero; may be negative.
    pub time_s: f64,
    /// Recorded depth below the transducer, metres, from the sounding nearest in time; NaN when
    /// there is none.
    pub depth_m: f32,
    /// The fault of that sounding ([`Sounding::fault`]).
    pub depth_fault: Option<SoundingFault>,
    /// The port samples, if that side was recorded for this ping.
    pub port: Option<SideSpan>,
    /// The starboard samples, if that side was recorded for this ping.
    pub starboard: Option<SideSpan>,
}

impl SidePing {
    /// A ping without echoes, and a depth without a fault.
    pub fn with_depth(time_s: f64, depth_m: f32) -> Self {
        Self { time_s, depth_m, depth_fault: None, port: None, starboard: None }
    }

    /// The recorded depth, metres; NaN without one, or where it has a fault.
    pub fn good_depth_m(&self) -> f32 {
        if self.depth_fault.is_none() && self.depth_m > 0.0 { self.depth_m } else { f32::NAN }
    }

    /// The samples of one side.
    pub fn side(&self, side: Side) -> Option<&SideSpan> {
        match side {
            Side::Port => self.port.as_ref(),
            Side::Starboard => self.starboard.as_ref(),
        }
    }
}

/// One depth that the recorder's own bottom lock gave, per ping of the channel that it runs on (the
/// traditional sonar where there is one). The copies that other channels carry are left out by the
/// reader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sounding {
    /// Seconds after the log's time zero.
    pub time_s: f64,
    /// Metres below the transducer (keel offset removed where the log states one).
    pub depth_m: f32,
    /// The fault that makes it false: found by [`mark_faults`], or by what the side-scan shows.
    pub fault: Option<SoundingFault>,
}

impl Sounding {
    /// Returns a sounding without a fault.
    pub fn new(time_s: f64, depth_m: f32) -> Self {
        Self { time_s, depth_m, fault: None }
    }

    /// Returns true where no fault of it is known.
    pub fn is_good(&self) -> bool {
        self.fault.is_none()
    }
}

/// Usability of the survey's side-scan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum SideScanState {
    /// There is a picture.
    Usable,
    /// The log holds no side-scan frames.
    #[default]
    Absent,
    /// There are frames but no picture: no transducer was connected, the range is stuck (metres
    /// given).
    Noise {
        /// The stuck range, metres.
        range_m: f32,
    },
}

/// Source of the slant ranges in a log's headers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RangeSource {
    /// The range that a fish-finder shows. Where in it the first sample begins is not stated, nor
    /// what its filters delay.
    #[default]
    FishFinder,
    /// The log states none: the range is estimated from the size of the transducer (Humminbird),
    /// and may be off by some percent.
    Estimated,
    /// The range that a survey recorder states, from the time since the transmission and the speed
    /// of sound (XTF).
    SurveyRecorder,
}

/// Files of a log, their format and the recorder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Source {
    /// The files read, the one that was opened first.
    pub files: Vec<PathBuf>,
    /// Format in words, for example `Lowrance SL2 (version 1)`.
    pub format: String,
    /// Name of the unit that recorded the log, as the log states it, for example `EdgeTech 4200`;
    /// empty where it states none.
    pub device: String,
    /// Bytes of the log's own files together, without those of a track that was applied to it.
    pub byte_count: u64,
}

impl Source {
    /// Returns a name of the recorder, as far as the log states it: its format, and the device
    /// where it names one. Logs of one recorder have the same words.
    pub fn recorder(&self) -> String {
        if self.device.is_empty() {
            self.format.clone()
        } else {
            format!("{}, {}", self.format, self.device)
        }
    }
}

/// Something that is wrong with the log but did not keep the rest from being read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Index into [`Source::files`] and byte offset, where there is a place.
    pub place: Option<(usize, u64)>,
    /// One sentence: what, and what was done about it.
    pub text: String,
}

/// A recorded survey. All vectors are in time order. The default one holds nothing; a survey is
/// built by filling it. A clone shares the bytes.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// Files that the survey was read from.
    pub source: Source,
    /// Unix seconds of the log's time zero, when the recorder knew the time; with the clock offset
    /// that is in force.
    pub start_unix_s: Option<f64>,
    /// Seconds added to the recorder's clock ([`MountingSettings::clock_offset_s`]).
    pub clock_offset_s: f64,
    /// True if port and starboard are exchanged against the recording
    /// ([`MountingSettings::swap_sides`]).
    pub swapped_sides: bool,
    /// Summary of each channel.
    pub channels: Vec<Channel>,
    /// The side-scan pings, both sides joined; shared by all copies of a survey, of which a change
    /// of the track makes one.
    pub side_scan: Arc<Vec<SidePing>>,
    /// All pairs of side-scan channels where the sonar has several frequencies, that which is shown
    /// first; none where there is one pair.
    pub pairs: Vec<SidePair>,
    /// Usability of the side-scan.
    pub side_scan_state: SideScanState,
    /// Source of its slant ranges.
    pub range_source: RangeSource,
    /// Channels that look down.
    pub echograms: Vec<Echogram>,
    /// Depths under the boat; shared likewise.
    pub soundings: Arc<Vec<Sounding>>,
    /// The channel that they are of.
    pub sounding_channel: Option<ChannelKind>,
    /// Depths across the track, where the recorder measures them; shared likewise.
    pub swath: Arc<Vec<SwathPing>>,
    /// Positions, courses and compass headings.
    pub track: Track,
    /// Faults of the log that were found when it was read.
    pub warnings: Vec<Warning>,
    /// The bytes of the files and of the samples in them, one entry a file.
    pub bytes: Vec<Bytes>,
}

impl Survey {
    /// Creates a survey of side-scan pings and nothing else.
    pub fn of_pings(pings: impl IntoIterator<Item = SidePing>) -> Self {
        Self { side_scan: Arc::new(pings.into_iter().collect()), ..Self::default() }
    }

    /// Returns the place of the samples of one side of one ping; `None` when the ping or the side
    /// was not recorded.
    pub fn span(&self, ping: usize, side: Side) -> Option<&SideSpan> {
        self.side_scan.get(ping)?.side(side)
    }

    /// The samples of one side of one ping; `None` when the ping or the side was not recorded, or
    /// lies outside the bytes.
    pub fn samples(&self, ping: usize, side: Side) -> Option<Samples<'_>> {
        self.samples_of(self.span(ping, side)?)
    }

    /// The samples of a span of any channel; `None` where it lies outside the bytes.
    pub fn samples_of(&self, span: &SideSpan) -> Option<Samples<'_>> {
        Samples::new(self.bytes.get(usize::from(span.file))?.samples(), span)
    }

    /// Checks that the files still hold the data that was read from them. Asks their disks, so it
    /// may wait for one that does not answer.
    ///
    /// # Errors
    /// Names the first that was cut or overwritten since the log was opened, or that could not be
    /// read to its end.
    pub fn check_files(&self) -> Result<(), FileError<FileFault>> {
        let mut files = self.source.files.iter().zip(&self.bytes);
        let fault = files.find_map(|(path, bytes)| Some(FileError::new(bytes.fault(path)?, path)));
        fault.map_or(Ok(()), Err)
    }

    /// [`SidePing::good_depth_m`] of a ping; NaN beyond the last.
    pub fn good_depth_m(&self, ping: usize) -> f32 {
        self.side_scan.get(ping).map_or(f32::NAN, SidePing::good_depth_m)
    }

    /// The survey's name for people: the opened file's stem.
    pub fn name(&self) -> String {
        let stem = self.source.files.first().and_then(|file| file.file_stem());
        stem.map_or_else(|| "survey".into(), |stem| stem.to_string_lossy().into_owned())
    }

    /// The same log in a frame that it shares with others: all logs of one survey lie in the frame
    /// of the first one's track, so that places of one are places of all. The samples are shared,
    /// not copied.
    #[must_use]
    pub fn in_frame(self, frame: &LocalFrame) -> Self {
        Self { track: self.track.in_frame(frame), ..self }
    }

    /// Returns the log in the frame that a project keeps, as [`Survey::in_frame`] does. Where the
    /// project's logs were exchanged for those of other waters, so far away that the plane of the
    /// frame would bend their tracks, the log stays in its own frame.
    #[must_use]
    pub fn in_frame_if_near(self, frame: &LocalFrame) -> Self {
        // Lengths are short by 0.05 % there, `d^2 / 2 R^2`; a quarter of the Earth away all places
        // lie on one line.
        const FARTHEST_M: f64 = 200_000.0;
        let first = self.track.fixes.first();
        if first.is_some_and(|fix| distance_m(fix.position, frame.origin()) > FARTHEST_M) {
            self
        } else {
            self.in_frame(frame)
        }
    }

    /// First and last time over all channels, seconds after the log's time zero.
    pub fn time_span_s(&self) -> Option<(f64, f64)> {
        let spans = self.channels.iter().filter_map(|channel| channel.time_span_s);
        spans.reduce(|(from, to), (other_from, other_to)| (from.min(other_from), to.max(other_to)))
    }

    /// Returns true if the recording says anywhere where it was.
    pub fn has_place(&self) -> bool {
        !self.track.fixes.is_empty()
    }

    /// Returns true if the side-scan can be processed.
    pub fn has_side_scan(&self) -> bool {
        self.side_scan_state == SideScanState::Usable
    }
}

/// Index of the item nearest to `time_s`, the earlier of two equally near; `None` without items.
/// `items` are in the order of `time_of`, seconds.
pub fn nearest_in_time<T>(items: &[T], time_s: f64, time_of: impl Fn(&T) -> f64) -> Option<usize> {
    let after = items.partition_point(|item| time_of(item) < time_s);
    let before = after.saturating_sub(1);
    match (items.get(before), items.get(after)) {
        (Some(a), Some(b)) if time_of(b) - time_s < time_s - time_of(a) => Some(after),
        (Some(_), _) => Some(before),
        (None, _) => None,
    }
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
