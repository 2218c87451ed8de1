//! Whole recordings, harmed in every way, and what was lost of them: nothing but what the harm
//! touched, and a warning says where.
//!
//! What can be lost is known from the records, which `records` finds without the readers. A ping is
//! the same where its samples lie at the same place and its time and its range are the same.

use super::harm::{Harm, harms};
use bathyscope_log::formats::{OpenError, open_at_hand};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Bytes, ChannelKind, RangeSource, Side, SideSpan, Survey};
use bathyscope_test_support::records::layout_of;
use rayon::prelude::*;
use std::fs;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Harms that are done to one copy of a file.
const A_COPY: usize = 256;
/// Violations, and losses without a place, of one file that are listed.
const LISTED: usize = 10;
/// A side has the time of the other one, which is another where that side's header is harmed: by
/// less than from ping to ping.
const MOST_APART_MS: u64 = 250;
/// A report that lists so many warnings may leave out the one that is looked for.
const MANY_WARNINGS: usize = 20;

/// Sweeps over recordings, one in `each` of all harms; a recording of several files is named by its
/// description (`.DAT`). Prints a table; whether nothing was lost that should not be.
pub fn sweep(paths: &[PathBuf], each: usize) -> bool {
    println!(
        "| file | records | harms | refused | lost outside | lost by a harmed header | slowest, ms | loss without a place | panics |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut is_sound = true;
    for path in paths {
        for patient in Patient::all_of(path) {
            let outcome = patient.sweep(each);
            println!("{}", outcome.row(&patient));
            outcome
                .violations
                .iter()
                .take(LISTED)
                .chain(outcome.notes.iter().take(LISTED))
                .for_each(|what| println!("  {what}"));
            is_sound &= outcome.violations.is_empty();
        }
    }
    is_sound
}

/// A recording, and the file of it that is harmed.
struct Patient {
    name: String,
    files: Vec<(PathBuf, Bytes)>,
    harmed: usize,
    records: Vec<Range<u64>>,
    pings: Vec<PingPlace>,
    warnings: usize,
}

/// One channel of one ping, as it is to be found again. In this order they are sorted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct PingPlace {
    file: u8,
    offset: u64,
    channel: u8,
    time_ms: i64,
    samples: u32,
    range: [u32; 2],
}

impl PingPlace {
    fn key(&self) -> (u8, u64, u8) {
        (self.file, self.offset, self.channel)
    }

    fn is_same(&self, other: &Self) -> bool {
        self.time_ms.abs_diff(other.time_ms) <= MOST_APART_MS
            && (self.samples, self.range) == (other.samples, other.range)
    }
}

/// Result of one harm.
enum Found {
    Refused { lost: usize },
    Opened { lost: usize, has_unplaced: bool },
    Panicked,
}

/// Results of all harms of a file.
#[derive(Default)]
struct Outcome {
    harms: usize,
    refused: usize,
    lost_outside: usize,
    lost_by_header: usize,
    slowest: Duration,
    unplaced: usize,
    panics: usize,
    violations: Vec<String>,
    /// Losses that nothing can know of, as where a header says another kind of record.
    notes: Vec<String>,
}

impl Patient {
    /// The recording at a path with each of its files harmed in turn.
    fn all_of(path: &Path) -> Vec<Self> {
        let read = |path: PathBuf| {
            let bytes =
                fs::read(&path).unwrap_or_else(|error| panic!("{error}: {}", path.display()));
            (path, Bytes::Held(Arc::new(bytes)))
        };
        let mut files = vec![read(path.to_owned())];
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("dat")) {
            let folder = fs::read_dir(path.with_extension("")).into_iter().flatten();
            let mut sons: Vec<PathBuf> = folder.flatten().map(|entry| entry.path()).collect();
            sons.retain(|son| {
                son.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("son"))
            });
            sons.sort();
            files.extend(sons.into_iter().map(read));
        }
        (0..files.len()).map(|harmed| Self::new(files.clone(), harmed)).collect()
    }

    fn new(files: Vec<(PathBuf, Bytes)>, harmed: usize) -> Self {
        let (path, bytes) = &files[harmed];
        let records = layout_of(bytes).map_or_else(Vec::new, |layout| (layout.find)(bytes));
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let whole = open_at_hand(files.clone(), &Progress::new()).expect("a whole recording");
        Self {
            name,
            harmed,
            records,
            pings: pings_of(&whole, &files),
            warnings: whole.warnings.len(),
            files,
        }
    }

    fn sweep(&self, each: usize) -> Outcome {
        let whole: &[u8] = &self.files[self.harmed].1;
        let harms = harms(whole, layout_of(whole), &self.records, each);
        let copy = || Arc::new(whole.to_vec());
        let done = harms.par_iter().with_min_len(A_COPY).map_init(copy, |copy, harm| {
            if copy.len() != whole.len() && !matches!(harm, Harm::Cut(at) if *at <= copy.len()) {
                *copy = Arc::new(whole.to_vec());
            }
            harm.apply(Arc::make_mut(copy));
            let began = Instant::now();
            let found = catch_unwind(AssertUnwindSafe(|| self.try_out(harm, copy)));
            let took = began.elapsed();
            harm.undo(Arc::make_mut(copy).as_mut_slice(), whole);
            (found.unwrap_or(Found::Panicked), took)
        });
        let done: Vec<(Found, Duration)> = done.collect();
        let mut outcome = Outcome::default();
        for (harm, (found, took)) in harms.iter().zip(done) {
            outcome.take(self, harm, &found, took);
        }
        outcome
    }

    /// Opens the recording with the harmed file and looks for what was in the whole one.
    fn try_out(&self, harm: &Harm, harmed: &Arc<Vec<u8>>) -> Found {
        let mut files = self.files.clone();
        files[self.harmed].1 = Bytes::Held(harmed.clone());
        let place = harm.place(self.files[self.harmed].1.len());
        let survey = match open_at_hand(files, &Progress::new()) {
            Ok(survey) => survey,
            Err(error) => {
                assert!(!matches!(error, OpenError::Io { .. } | OpenError::Cancelled(_)));
                let left = self.pings.iter().filter(|ping| !self.is_touched(ping, &place));
                let lost = left.count();
                // One frame, or one ping of two sides, is no proof of a format.
                return Found::Refused { lost: if lost <= 2 { 0 } else { lost } };
            }
        };
        let found = pings_of(&survey, &self.files);
        let is_there = |ping: &PingPlace| {
            let from = found.partition_point(|other| other.key() < ping.key());
            let mut alike = found[from..].iter().take_while(|other| other.key() == ping.key());
            alike.any(|other| other.is_same(ping))
        };
        let missing: Vec<&PingPlace> = self.pings.iter().filter(|ping| !is_there(ping)).collect();
        let outside = missing.iter().filter(|ping| !self.is_touched(ping, &place));
        let lost = outside.count();
        // What moved is not gone: a touched ping may have another time or range.
        let gone = missing.iter().any(|ping| {
            let at = found
                .partition_point(|other| (other.file, other.offset) < (ping.file, ping.offset));
            let other = found.get(at);
            other.is_none_or(|other| (other.file, other.offset) != (ping.file, ping.offset))
        });
        Found::Opened { lost, has_unplaced: gone && !self.says_where(&survey, &place) }
    }

    /// Returns true if a warning is about the records that the harm touched.
    fn says_where(&self, survey: &Survey, place: &Range<u64>) -> bool {
        let touched = self.records.iter().filter(|record| touches(record, place));
        let bounds = touched.fold(place.clone(), |all, record| {
            all.start.min(record.start)..all.end.max(record.end)
        });
        let (harmed, _) = &self.files[self.harmed];
        let is_here = |warning: &bathyscope_log::survey::Warning| {
            let here = warning.place.filter(|(file, _)| survey.source.files[*file] == *harmed);
            here.is_some_and(|(_, offset)| (bounds.start..=bounds.end).contains(&offset))
        };
        survey.warnings.len().max(self.warnings) >= MANY_WARNINGS
            || survey.warnings.iter().any(is_here)
    }

    fn is_touched(&self, ping: &PingPlace, place: &Range<u64>) -> bool {
        let index = self.records.partition_point(|record| record.end <= ping.offset);
        let record = self.records.get(index);
        usize::from(ping.file) == self.harmed && record.is_none_or(|record| touches(record, place))
    }

    /// Returns true if a harm touches what stands before the first record, which is about all of
    /// them.
    fn is_of_header(&self, harm: &Harm) -> bool {
        let first = self.records.first().map_or(u64::MAX, |record| record.start);
        matches!(harm, Harm::Changed { at, .. } if (*at as u64) < first)
    }
}

impl Outcome {
    fn take(&mut self, patient: &Patient, harm: &Harm, found: &Found, took: Duration) {
        self.harms += 1;
        self.slowest = self.slowest.max(took);
        let (lost, has_unplaced) = match found {
            Found::Refused { lost } => {
                self.refused += 1;
                (*lost, false)
            }
            Found::Opened { lost, has_unplaced } => (*lost, *has_unplaced),
            Found::Panicked => {
                self.panics += 1;
                self.violations.push(format!("{harm}: it panicked"));
                return;
            }
        };
        if patient.is_of_header(harm) {
            self.lost_by_header = self.lost_by_header.max(lost);
            return;
        }
        self.lost_outside = self.lost_outside.max(lost);
        if lost > 0 {
            self.violations.push(format!("{harm}: {lost} pings are lost outside of it"));
        }
        if has_unplaced {
            self.unplaced += 1;
            self.notes.push(format!("{harm}: no warning says where a ping is lost"));
        }
    }

    fn row(&self, patient: &Patient) -> String {
        format!(
            "| {} | {} | {} | {} | {} | {} | {:.1} | {} | {} |",
            patient.name,
            patient.records.len(),
            self.harms,
            self.refused,
            self.lost_outside,
            self.lost_by_header,
            self.slowest.as_secs_f64() * 1000.0,
            self.unplaced,
            self.panics
        )
    }
}

/// All channels of all pings, sorted. Files are counted as in `files`: a survey leaves out those
/// without a ping.
fn pings_of(survey: &Survey, files: &[(PathBuf, Bytes)]) -> Vec<PingPlace> {
    let file_of = |span: &SideSpan| {
        let path = &survey.source.files[usize::from(span.file)];
        files.iter().position(|(other, _)| other == path).unwrap_or(usize::MAX) as u8
    };
    // Survey recorders count from their first ping, which may be lost; the others from their own
    // zero.
    let from_first = survey.range_source == RangeSource::SurveyRecorder;
    let zero_s = survey.start_unix_s.filter(|_| from_first).unwrap_or(0.0);
    let place = |channel: u8, time_s: f64, span: &SideSpan| PingPlace {
        file: file_of(span),
        offset: span.offset,
        channel,
        time_ms: ((zero_s + time_s) * 1000.0).round() as i64,
        samples: span.count,
        range: [span.near_m, span.far_m].map(f32::to_bits),
    };
    let mut all = Vec::new();
    for ping in survey.side_scan.iter() {
        for side in Side::BOTH {
            all.extend(ping.side(side).map(|span| place(side as u8, ping.time_s, span)));
        }
    }
    for echogram in &survey.echograms {
        let channel = match echogram.kind {
            ChannelKind::Primary => 2,
            ChannelKind::Secondary => 3,
            _ => 4,
        };
        let pings = echogram.pings.iter();
        all.extend(pings.map(|ping| place(channel, ping.time_s, &ping.span)));
    }
    all.sort_unstable();
    all
}

fn touches(record: &Range<u64>, place: &Range<u64>) -> bool {
    record.start < place.end && place.start < record.end
}
