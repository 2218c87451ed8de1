//! Follows a log that is still being written: finds where its tail begins, joins the log with a new
//! tail, and cuts a stretch out of it as a log.

use super::NEAREST_SOUNDING_S;
use super::observations::mark_faults_from;
use super::{
    Bytes, Channel, ChannelKind, Echogram, EchogramPing, Encoding, Fix, Identity, Side, SidePing,
    SideScanState, SideSpan, Sounding, Survey, SwathPing, give_depths,
};
use crate::support::versions::Versions;
use std::collections::BTreeMap;
use std::mem::discriminant;
use std::sync::Arc;

/// Largest time by which recorders write records out of order, seconds; the readers allow as much.
const DISORDER_S: f64 = 2.0;
/// Time at the end of a log that is read again with the tail, seconds: the second side of a ping,
/// or records that confirm or refute a time, may have been written since.
const UNSETTLED_S: f64 = 3.0;
/// Age of the last ping of a channel beyond which the channel has ended, seconds.
const ENDED_S: f64 = 30.0;
/// Number of pings without a side after which that side has ended.
const ENDED_PINGS: usize = 1000;

/// Number of neighbouring pings that may be out of order in the file.
const NEIGHBOURS: usize = 16;
/// Largest number of bytes of a record.
const MOST_OF_A_PING: u64 = 1 << 17;

/// Beginning of the tail of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// Records of this time or later are taken from the tail, seconds after the log's time zero.
    pub time_s: f64,
    /// Byte offset in each file of the log before which no record of `time_s` or later was written.
    pub from: Vec<u64>,
}

/// Time of a record and the place where its samples begin.
#[derive(Clone, Copy)]
struct RecordPlace {
    /// Seconds after the log's time zero.
    time_s: f64,
    file: usize,
    /// Byte offset of the samples in the file.
    offset: u64,
}

impl RecordPlace {
    fn of(time_s: f64, span: &SideSpan) -> Self {
        Self { time_s, file: usize::from(span.file), offset: span.offset }
    }

    fn of_swath(ping: &SwathPing) -> Self {
        Self { time_s: ping.time_s, file: usize::from(ping.file), offset: ping.offset }
    }
}

/// Beginning of a stretch of a log ([`Survey::stretch_from`]), in the records other than side-scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StretchStart {
    /// Number of soundings before the stretch.
    pub sounding: usize,
    /// Number of pings of the swath before the stretch.
    pub swath: usize,
}

/// Versions of the lists of a log that is extended again and again ([`Survey::extended`]), so that
/// the time of an extension depends on the number of new records only.
#[derive(Debug, Default)]
pub struct SurveyVersions {
    side_scan: Versions<SidePing>,
    soundings: Versions<Sounding>,
    swath: Versions<SwathPing>,
    fixes: Versions<Fix>,
    echograms: BTreeMap<ChannelKind, Versions<EchogramPing>>,
}

impl Survey {
    /// Returns the place from which the log has to be read when more of it is written; `None` where
    /// all of it has to be read again: the log has no pings yet, its samples are packed, or its
    /// track is another receiver's.
    pub fn seam(&self) -> Option<Seam> {
        let is_packed = self.bytes.iter().any(Bytes::is_packed);
        let has_others = self.bytes.len() != self.source.files.len();
        if self.track.external.is_some() || has_others || is_packed {
            return None;
        }
        let lasts: Vec<RecordPlace> = self.lasts_before(f64::INFINITY).collect();
        let newest_s = lasts.iter().map(|last| last.time_s).reduce(f64::max)?;
        let is_live = |last: &&RecordPlace| newest_s - last.time_s < ENDED_S;
        let live = lasts.iter().filter(is_live);
        let slowest_s = live.fold(newest_s, |least_s, last| least_s.min(last.time_s));
        // Recorders count whole milliseconds: a time between two of them is not the time of a ping,
        // so every ping is clearly before or after the seam.
        let time_s = (slowest_s * 1e3).floor() / 1e3 - UNSETTLED_S - 0.0005;
        let settled_s = time_s - 2.0 * DISORDER_S;
        let settled: Vec<RecordPlace> = self.lasts_before(settled_s).collect();
        let from = (0..self.source.files.len()).map(|file| {
            let here = |last: &&RecordPlace| last.file == file;
            let offsets = |lasts: &[RecordPlace], has_ended: bool| {
                let those = lasts.iter().filter(here);
                let those = those.filter(|last| (settled_s - last.time_s > ENDED_S) == has_ended);
                those.map(|last| last.offset).reduce(u64::min)
            };
            // A file of which no record is settled yet, or that has no pings, is read from its
            // beginning.
            let ended = || {
                offsets(&settled, true)
                    .filter(|_| !lasts.iter().filter(here).any(|last| is_live(&last)))
            };
            offsets(&settled, false).or_else(ended).unwrap_or(0)
        });
        Some(Seam { time_s, from: from.collect() })
    }

    /// Returns the last record of each channel before a time.
    fn lasts_before(&self, time_s: f64) -> impl Iterator<Item = RecordPlace> {
        let before = self.side_scan.partition_point(|ping| ping.time_s < time_s);
        let pings = &self.side_scan[..before];
        let sides = Side::BOTH.into_iter().filter_map(|side| {
            let mut lately = pings.iter().rev().take(ENDED_PINGS);
            lately.find_map(|ping| Some(RecordPlace::of(ping.time_s, ping.side(side)?)))
        });
        let down = self.echograms.iter().filter_map(move |echogram| {
            let before = echogram.pings.partition_point(|ping| ping.time_s < time_s);
            let last = echogram.pings.get(before.checked_sub(1)?)?;
            Some(RecordPlace::of(last.time_s, &last.span))
        });
        let before = self.swath.partition_point(|ping| ping.time_s < time_s);
        let swath = before.checked_sub(1).and_then(|last| self.swath.get(last));
        sides.chain(down).chain(swath.map(RecordPlace::of_swath))
    }

    /// Returns the log extended by `tail`, which was read from `seam` on and has the bytes of the
    /// longer files. The local coordinate frame, the time zero and the scale of 16-bit samples
    /// stay. `None` where the tail does not continue the log, which then has to be read again as a
    /// whole.
    pub fn extended(
        &self,
        mut tail: Survey,
        seam: &Seam,
        versions: &mut SurveyVersions,
    ) -> Option<Survey> {
        let is_same_kind = tail.side_scan.is_empty()
            || discriminant(&self.side_scan_state) == discriminant(&tail.side_scan_state)
            || self.side_scan_state == SideScanState::Usable;
        let has_new = (self.sounding_channel.is_none() && tail.sounding_channel.is_some())
            || (self.track.fixes.is_empty() && !tail.track.fixes.is_empty())
            || self.has_new_pair(&tail);
        if tail.source.files != self.source.files || !is_same_kind || has_new {
            return None;
        }
        let later_s = self.clock_shift_s(&tail, seam)?;
        tail.shift(later_s);
        tail.scale_like(self);
        let at_s = seam.time_s;
        let [kept, added] = join(at_s, &self.track.fixes, &tail.track.fixes, |fix| fix.time_s);
        let new = &tail.track.fixes[added..];
        let fixes = versions.fixes.next(&self.track.fixes, kept, new);
        let mut from_s = at_s;
        let [kept, added] =
            join(at_s, &self.soundings, &tail.soundings, |sounding| sounding.time_s);
        let new = &tail.soundings[added..];
        let has_side_scan = !(self.side_scan.is_empty() && tail.side_scan.is_empty());
        let soundings = (versions.soundings).next_changed(&self.soundings, kept, new, |all| {
            let marked = mark_faults_from(all, &fixes, has_side_scan, kept);
            from_s = all.get(marked).map_or(from_s, |sounding| from_s.min(sounding.time_s));
            marked
        });
        let [kept, added] = join(at_s, &self.side_scan, &tail.side_scan, |ping| ping.time_s);
        let new = &tail.side_scan[added..];
        let side_scan = (versions.side_scan).next_changed(&self.side_scan, kept, new, |all| {
            let from = all.partition_point(|ping| ping.time_s < from_s - NEAREST_SOUNDING_S);
            give_depths(&mut all[from..], &soundings);
            from
        });
        let [kept, added] = join(at_s, &self.swath, &tail.swath, |ping| ping.time_s);
        let swath = (versions.swath).next(&self.swath, kept, &tail.swath[added..]);
        let of_channels = &mut versions.echograms;
        let echograms = joined_echograms(&self.echograms, &tail.echograms, at_s, of_channels);
        let before = |place: &Option<(usize, u64)>| match place {
            Some((file, offset)) => seam.from.get(*file).is_none_or(|from| offset < from),
            None => true,
        };
        let warnings = self.warnings.iter().filter(|warning| before(&warning.place));
        let added = tail.warnings.iter().filter(|warning| warning.place.is_some());
        let mut longer = Survey {
            source: tail.source.clone(),
            channels: joined_channels(&self.channels, &tail.channels, later_s),
            side_scan,
            echograms,
            soundings,
            swath,
            track: self.track.with_fixes(fixes),
            warnings: warnings.chain(added).cloned().collect(),
            bytes: tail.bytes.clone(),
            ..self.without_records()
        };
        longer.pairs = self.extended_pairs(&tail, at_s, &longer);
        Some(longer)
    }

    /// Returns a survey without records, with the properties of the log as a whole.
    fn without_records(&self) -> Survey {
        Survey {
            start_unix_s: self.start_unix_s,
            clock_offset_s: self.clock_offset_s,
            sounding_lag_s: self.sounding_lag_s,
            swapped_sides: self.swapped_sides,
            side_scan_state: self.side_scan_state,
            range_source: self.range_source,
            sounding_channel: self.sounding_channel,
            ..Survey::default()
        }
    }

    /// Returns true if the log had `pings` side-scan pings when `byte_count` bytes of it were
    /// written, so that decisions about the shorter log still apply. For a recording in several
    /// files this is known to two seconds.
    pub fn was(&self, byte_count: u64, pings: usize) -> bool {
        let is_packed = self.bytes.iter().any(Bytes::is_packed);
        if byte_count > self.source.byte_count || pings > self.side_scan.len() || is_packed {
            return false;
        }
        if self.source.files.len() != 1 {
            let bytes_at = |time_s: f64| -> u64 {
                let mut ends = vec![0; self.bytes.len()];
                for last in self.lasts_before(time_s) {
                    if let Some(end) = ends.get_mut(last.file) {
                        *end = last.offset.max(*end);
                    }
                }
                ends.iter().sum()
            };
            let time_s = |ping: Option<usize>| {
                ping.and_then(|ping| self.side_scan.get(ping)).map(|ping| ping.time_s)
            };
            let first_s = time_s(pings.checked_sub(1)).unwrap_or(f64::NEG_INFINITY);
            let next_s = time_s(Some(pings)).unwrap_or(f64::INFINITY);
            let most = bytes_at(next_s + DISORDER_S) + MOST_OF_A_PING * self.bytes.len() as u64;
            return (bytes_at(first_s - DISORDER_S)..=most).contains(&byte_count);
        }
        // Pings are in time order in the file, except for a few neighbours.
        let from = pings.saturating_sub(NEIGHBOURS);
        let near = || self.side_scan.iter().skip(from).take(2 * NEIGHBOURS);
        let ends = |ping: &SidePing| {
            [ping.port, ping.starboard].map(|side| {
                let span = side?;
                let width = span.encoding.width() as u64;
                Some(span.offset + width * u64::from(span.count))
            })
        };
        let is_in = |end: Option<u64>| end.is_none_or(|end| end <= byte_count);
        let begun =
            near().filter(|ping| ends(ping).into_iter().flatten().any(|end| end <= byte_count));
        let whole = near().filter(|ping| ends(ping).into_iter().all(is_in));
        // Where each side has its own record, one side makes a ping; a record with both sides has
        // to be complete, including the bytes behind the samples.
        let least = (from + whole.count()).saturating_sub(1);
        (least..=from + begun.count()).contains(&pings)
    }

    /// Returns true if `log` identifies this log, now or when less of it was written. A shorter log
    /// must have the same file name.
    pub fn is_or_was(&self, log: &Identity) -> bool {
        let own = Identity::of(self);
        own.is_same_log(log) || (own.file == log.file && self.was(log.byte_count, log.pings))
    }

    /// Returns the seconds by which the times of a tail are too early, because the recorder's clock
    /// was set back before it. `None` where the tail does not contain the log's last settled ping,
    /// unless the tail was read from the beginning (0 then).
    fn clock_shift_s(&self, tail: &Survey, seam: &Seam) -> Option<f64> {
        let sides = tail.side_scan.iter().flat_map(|ping| {
            let place = |span: &SideSpan| RecordPlace::of(ping.time_s, span);
            Side::BOTH.map(|side| ping.side(side).map(place))
        });
        let down = tail.echograms.iter().flat_map(|echogram| echogram.pings.iter());
        let down = down.map(|ping| Some(RecordPlace::of(ping.time_s, &ping.span)));
        let swath = tail.swath.iter().map(RecordPlace::of_swath).map(Some);
        let all: Vec<RecordPlace> = sides.chain(down).chain(swath).flatten().collect();
        let shift_s = self.lasts_before(seam.time_s).find_map(|known| {
            let is_it =
                |place: &&RecordPlace| (place.file, place.offset) == (known.file, known.offset);
            let same = all.iter().find(is_it);
            same.map(|same| known.time_s - same.time_s)
        });
        shift_s.or_else(|| seam.from.iter().all(|from| *from == 0).then_some(0.0))
    }

    fn shift(&mut self, later_s: f64) {
        if later_s == 0.0 {
            return;
        }
        let later = |time_s: &mut f64| *time_s += later_s;
        let pairs = self.pairs.iter_mut().map(|pair| &mut pair.side_scan);
        for pings in [&mut self.side_scan].into_iter().chain(pairs) {
            Arc::make_mut(pings).iter_mut().for_each(|ping| later(&mut ping.time_s));
        }
        for echogram in &mut self.echograms {
            let pings = Arc::make_mut(&mut echogram.pings);
            pings.iter_mut().for_each(|ping| later(&mut ping.time_s));
        }
        Arc::make_mut(&mut self.soundings)
            .iter_mut()
            .for_each(|sounding| later(&mut sounding.time_s));
        Arc::make_mut(&mut self.swath).iter_mut().for_each(|ping| later(&mut ping.time_s));
        Arc::make_mut(&mut self.track.fixes).iter_mut().for_each(|fix| later(&mut fix.time_s));
    }

    /// Gives 16-bit samples the encoding that the log has so far, so that the same bits are shown.
    /// Samples with a scale for each ping already have the scale of the log, which their reader
    /// uses.
    fn scale_like(&mut self, log: &Survey) {
        let spans = log.side_scan.iter().rev().take(ENDED_PINGS);
        let mut spans = spans.flat_map(|ping| [ping.port, ping.starboard]).flatten();
        let is_shifted = |span: &SideSpan| matches!(span.encoding, Encoding::U16 { .. });
        let Some(known) = spans.find(is_shifted) else {
            return;
        };
        for ping in Arc::make_mut(&mut self.side_scan) {
            for span in [&mut ping.port, &mut ping.starboard].into_iter().flatten() {
                if is_shifted(span) {
                    span.encoding = known.encoding;
                }
            }
        }
    }

    /// Returns the pings from `first` on as a log, in the same local coordinate frame and over the
    /// same bytes, and the beginning of this stretch in the other records. Stages run over the
    /// stretch where only the end of a log is new.
    pub fn stretch_from(&self, first: usize) -> (Survey, StretchStart) {
        let from_s = self.stretch_from_s(first);
        let start = self.stretch_start(first);
        let fix = self.track.fixes.partition_point(|fix| fix.time_s < from_s);
        let stretch = Survey {
            source: self.source.clone(),
            side_scan: Arc::new(self.side_scan[first.min(self.side_scan.len())..].to_vec()),
            soundings: Arc::new(self.soundings[start.sounding..].to_vec()),
            swath: Arc::new(self.swath[start.swath..].to_vec()),
            track: self.track.with_fixes(self.track.fixes[fix..].to_vec()),
            bytes: self.bytes.clone(),
            ..self.without_records()
        };
        (stretch, start)
    }

    /// Returns the beginning, in the other records, of the stretch that begins at ping `first`.
    pub fn stretch_start(&self, first: usize) -> StretchStart {
        let from_s = self.stretch_from_s(first);
        StretchStart {
            sounding: self.soundings.partition_point(|sounding| sounding.time_s < from_s),
            swath: self.swath.partition_point(|ping| ping.time_s < from_s),
        }
    }

    /// Returns the time of the first ping of a stretch; minus infinity for a stretch from ping 0
    /// on, infinity where the ping is not in the log.
    fn stretch_from_s(&self, first: usize) -> f64 {
        match first {
            0 => f64::NEG_INFINITY,
            _ => self.side_scan.get(first).map_or(f64::INFINITY, |ping| ping.time_s),
        }
    }
}

/// Returns the number of records of a log before the time at which its tail begins, and the index
/// of the first record of the tail that is not before it.
fn join<T>(at_s: f64, log: &[T], tail: &[T], time_s: impl Fn(&T) -> f64) -> [usize; 2] {
    [log, tail].map(|records| records.partition_point(|record| time_s(record) < at_s))
}

fn joined_echograms(
    log: &[Echogram],
    tail: &[Echogram],
    at_s: f64,
    versions: &mut BTreeMap<ChannelKind, Versions<EchogramPing>>,
) -> Vec<Echogram> {
    let of = |echograms: &[Echogram], kind| {
        let found = echograms.iter().find(|echogram| echogram.kind == kind);
        found.map_or_else(Arc::default, |echogram: &Echogram| echogram.pings.clone())
    };
    let mut kinds: Vec<_> = log.iter().chain(tail).map(|echogram| echogram.kind).collect();
    kinds.sort_by_key(|kind| std::cmp::Reverse(*kind));
    kinds.dedup();
    let each = kinds.into_iter().map(|kind| {
        let (known, tail) = (of(log, kind), of(tail, kind));
        let [kept, added] = join(at_s, &known, &tail, |ping| ping.time_s);
        let versions = versions.entry(kind).or_default();
        Echogram { kind, pings: versions.next(&known, kept, &tail[added..]) }
    });
    each.collect()
}

/// Returns the channels of a log extended by those of its tail.
fn joined_channels(log: &[Channel], tail: &[Channel], later_s: f64) -> Vec<Channel> {
    let mut channels = log.to_vec();
    for added in tail.iter().filter(|channel| channel.ping_count > 0) {
        let is_it = |channel: &&mut Channel| {
            channel.kind == added.kind && channel.recorder_name == added.recorder_name
        };
        let time_span_s = added.time_span_s.map(|(from, to)| (from + later_s, to + later_s));
        let Some(known) = channels.iter_mut().find(is_it) else {
            channels.push(Channel { time_span_s, ..added.clone() });
            continue;
        };
        known.ping_count += added.ping_count;
        known.time_span_s = wider(known.time_span_s, time_span_s, f64::min, f64::max);
        known.range_m = wider(known.range_m, added.range_m, f32::min, f32::max);
        let ((least, most), (other_least, other_most)) = (known.sample_count, added.sample_count);
        known.sample_count = (least.min(other_least), most.max(other_most));
    }
    channels.sort_by(|a, b| (a.kind, &a.recorder_name).cmp(&(b.kind, &b.recorder_name)));
    channels
}

fn wider<T>(
    one: Option<(T, T)>,
    other: Option<(T, T)>,
    least: fn(T, T) -> T,
    most: fn(T, T) -> T,
) -> Option<(T, T)> {
    match (one, other) {
        (Some((a, b)), Some((c, d))) => Some((least(a, c), most(b, d))),
        (one, other) => one.or(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// Creates a log of one record per ping: 100 bytes of header, 200 port and 200 starboard
    /// samples.
    fn log(pings: u64) -> Survey {
        let span = |offset| SideSpan { offset, ..SideSpan::of_bytes(200, [0.0, 10.0]) };
        let ping = |index: u64| SidePing {
            port: Some(span(500 * index + 100)),
            starboard: Some(span(500 * index + 300)),
            ..SidePing::with_depth(0.05 * index as f64, f32::NAN)
        };
        let mut log = Survey {
            bytes: vec![Bytes::Held(Arc::new(vec![0; 500 * pings as usize]))],
            ..Survey::of_pings((0..pings).map(ping))
        };
        log.source.files = vec![PathBuf::from("log.sl2")];
        log.source.byte_count = 500 * pings;
        log
    }

    #[test]
    fn a_log_is_known_from_what_it_was_when_it_was_shorter() {
        let log = log(400);
        for pings in [1_u64, 20, 399] {
            for torn in [0, 1, 250, 350, 499] {
                let bytes = 500 * pings + torn;
                assert!(log.was(bytes, pings as usize), "{pings} pings and {torn} bytes");
                assert!(!log.was(bytes, pings as usize + 3));
                assert!(pings < 5 || !log.was(bytes, pings as usize - 3));
            }
        }
        assert!(!log.was(500 * 401, 400), "it never was longer");
        let shorter = |file: &str| Identity {
            file: file.to_owned(),
            byte_count: 500 * 100 + 250,
            pings: 100,
            swapped_sides: false,
        };
        assert!(log.is_or_was(&shorter("log.sl2")));
        assert!(!log.is_or_was(&shorter("other.sl2")), "another name");
    }

    #[test]
    fn the_tail_begins_before_what_is_not_settled() {
        let log = log(400);
        let seam = log.seam().expect("a seam");
        assert!(seam.time_s < 19.95 - UNSETTLED_S && seam.time_s > 19.95 - UNSETTLED_S - 0.01);
        let first = log.side_scan.partition_point(|ping| ping.time_s < seam.time_s);
        assert!(seam.from[0] < log.side_scan[first].port.map_or(0, |span| span.offset));
        let (stretch, start) = log.stretch_from(first);
        assert_eq!((stretch.side_scan.len(), start.sounding), (400 - first, 0));
        assert!(Survey::default().seam().is_none());
    }
}
