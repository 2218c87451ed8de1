//! A thousand cuts and a thousand lost kilobytes in every kind of log: no panic, no hang, and
//! nothing is lost beyond the frames that the damage touched. What can be lost is known from a walk
//! of its own over the whole log.

use bathyscope_log::formats::{self, OpenError};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, SideSpan, Survey};
use bathyscope_test_support::Random;
use bathyscope_test_support::handmade;
use bathyscope_test_support::records::{
    FindRecords, sl2_records, sl3_records, son_records, xtf_records,
};
use std::fs::{self, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Cuts, and zeroed blocks, of each log.
const CASES: u64 = 1000;
const BLOCK: u64 = 1024;

/// A recording in a folder of its own, the file of it that is damaged, and what was in it.
struct Patient {
    _folder: tempfile::TempDir,
    opened: PathBuf,
    damaged: PathBuf,
    bytes: Vec<u8>,
    frames: Vec<Range<u64>>,
    pings_a_frame: usize,
    whole: Survey,
}

impl Patient {
    /// Copies `files` (paths below a folder) and opens the first; `damaged` is the index of the one
    /// to damage.
    fn new(files: &[(PathBuf, Vec<u8>)], damaged: usize, oracle: FindRecords) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for (path, bytes) in files {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
            fs::write(&path, bytes).expect("a copy");
        }
        let opened = folder.path().join(&files[0].0);
        let whole = formats::open(&opened, &Progress::new()).expect("a sound log");
        Self {
            opened,
            damaged: folder.path().join(&files[damaged].0),
            bytes: files[damaged].1.clone(),
            frames: oracle(&files[damaged].1),
            pings_a_frame: if whole.source.format == "XTF" { 2 } else { 1 },
            whole,
            _folder: folder,
        }
    }

    /// Cuts from the end on, so that the copy on disk only ever shrinks; written back at the end.
    fn cut(&self, seed: u64) {
        let mut random = Random(seed);
        let len = self.bytes.len() as u64;
        let mut cuts: Vec<u64> = (0..CASES).map(|_| random.below(len as usize) as u64).collect();
        cuts.sort_unstable();
        for cut in cuts.into_iter().rev() {
            let file = OpenOptions::new().write(true).open(&self.damaged).expect("the copy");
            file.set_len(cut).expect("a cut");
            self.check(&format!("cut at {cut}"), cut..len);
        }
        fs::write(&self.damaged, &self.bytes).expect("the copy");
    }

    /// Zeroes one block at a time.
    fn zero(&self, seed: u64) {
        self.overwrite(seed, "zeroed", |_, block| block.fill(0));
    }

    /// Fills one block at a time with anything.
    fn garble(&self, seed: u64) {
        self.overwrite(seed, "garbled", |random, block| {
            block.fill_with(|| random.below(256) as u8);
        });
    }

    fn overwrite(&self, seed: u64, what: &str, spoil: fn(&mut Random, &mut [u8])) {
        let mut random = Random(seed);
        let len = self.bytes.len() as u64;
        for _ in 0..CASES {
            let start = random.below(len as usize) as u64;
            let block = start..(start + BLOCK).min(len);
            let sound = &self.bytes[block.start as usize..block.end as usize];
            let mut spoiled = sound.to_vec();
            spoil(&mut random, &mut spoiled);
            self.write(block.start, &spoiled);
            self.check(&format!("{what} from {start}"), block.clone());
            self.write(block.start, sound);
        }
    }

    fn write(&self, at: u64, bytes: &[u8]) {
        let mut file = OpenOptions::new().write(true).open(&self.damaged).expect("the copy");
        file.seek(SeekFrom::Start(at)).expect("a seek");
        file.write_all(bytes).expect("a write");
    }

    fn check(&self, what: &str, damage: Range<u64>) {
        let left: Vec<&Range<u64>> =
            self.frames.iter().filter(|frame| !touches(frame, &damage)).collect();
        let touched = self.frames.len() - left.len();
        match formats::open(&self.opened, &Progress::new()) {
            Ok(survey) => self.compare(what, &survey, &damage, touched),
            // Fewer frames than it takes to recognise a log without its header may be left of a cut
            // one.
            Err(OpenError::Broken { .. } | OpenError::NotRecognised { .. }) => {
                assert!(
                    left.len() < 2,
                    "{what}: {} frames are left, and it does not open",
                    left.len()
                );
            }
            Err(error) => panic!("{what}: {error}"),
        }
    }

    fn compare(&self, what: &str, survey: &Survey, damage: &Range<u64>, touched: usize) {
        let pings = |survey: &Survey| {
            survey.channels.iter().map(|channel| channel.ping_count).sum::<usize>()
        };
        let (before, after) = (pings(&self.whole), pings(survey));
        assert!(after <= before, "{what}: {after} pings of {before}");
        assert!(
            after + touched * self.pings_a_frame >= before,
            "{what}: {after} pings of {before} with {touched} touched"
        );
        for side in Side::BOTH {
            self.compare_side(what, survey, damage, side);
        }
    }

    /// Every side of a ping whose frame the damage left alone is there, at its time, with its
    /// samples.
    fn compare_side(&self, what: &str, survey: &Survey, damage: &Range<u64>, side: Side) {
        let mut found = sides(survey, side).peekable();
        for (time_s, span) in sides(&self.whole, side) {
            let in_file = self.whole.source.files[usize::from(span.file)] == self.damaged;
            let frame = self.frame_of(&span);
            if in_file && touches(&frame, damage) {
                continue;
            }
            while found
                .next_if(|(other_s, other)| {
                    *other_s < time_s || (*other_s == time_s && other.offset < span.offset)
                })
                .is_some()
            {}
            let same = found.next_if(|(other_s, other)| {
                *other_s == time_s
                    && (other.offset, other.count, other.far_m)
                        == (span.offset, span.count, span.far_m)
            });
            assert!(
                same.is_some(),
                "{what}: the {} ping at {time_s} s, frame {frame:?}, is lost",
                side.name()
            );
        }
    }

    fn frame_of(&self, span: &SideSpan) -> Range<u64> {
        let index = self.frames.partition_point(|frame| frame.end <= span.offset);
        self.frames.get(index).cloned().unwrap_or(span.offset..span.offset)
    }
}

/// One side of every ping with its time; XTF counts from its first ping, which may be lost, the
/// others from their own zero.
fn sides(survey: &Survey, side: Side) -> impl Iterator<Item = (f64, SideSpan)> {
    let from_first = survey.source.format == "XTF";
    let zero_s = survey.start_unix_s.filter(|_| from_first).unwrap_or(0.0);
    let milliseconds = move |time_s: f64| ((zero_s + time_s) * 1000.0).round() / 1000.0;
    survey
        .side_scan
        .iter()
        .filter_map(move |ping| Some((milliseconds(ping.time_s), *ping.side(side)?)))
}

fn touches(frame: &Range<u64>, damage: &Range<u64>) -> bool {
    frame.start < damage.end && damage.start < frame.end
}

fn damage_one(name: &str, bytes: Vec<u8>, oracle: FindRecords, seed: u64) -> Patient {
    let patient = Patient::new(&[(PathBuf::from(name), bytes)], 0, oracle);
    patient.cut(seed);
    patient.zero(seed);
    patient
}

fn damage_real(file: &str, oracle: FindRecords, seed: u64) {
    let Some(data) = bathyscope_test_support::real_data() else {
        return;
    };
    let bytes = fs::read(data.join(file)).expect("a readable recording");
    damage_one("log", bytes, oracle, seed);
}

#[test]
fn handmade_sl2() {
    let frames = handmade::survey_frames(40);
    damage_one("pond.sl2", handmade::sl2(&frames), sl2_records, 1).garble(1);
}

#[test]
fn handmade_sl3() {
    let frames = handmade::survey_frames(40);
    damage_one("pond.sl3", handmade::sl3(&frames, 168), sl3_records, 2).garble(2);
}

#[test]
fn handmade_xtf() {
    damage_one("pond.xtf", handmade::xtf(60, 1, 3, (-73.6, 42.7), 5.0), xtf_records, 3).garble(3);
}

#[test]
fn handmade_humminbird() {
    let files = handmade::humminbird(60, false, false);
    for (damaged, seed) in [(1, 4), (2, 5)] {
        let patient = Patient::new(&files, damaged, son_records);
        patient.cut(seed);
        patient.zero(seed);
        patient.garble(seed);
    }
    Patient::new(&files, 0, |_| Vec::new()).zero(6);
}

#[test]
fn real_transcoded_sl2() {
    damage_real("lowrance/glencanyon-transcoded.sl2", sl2_records, 11);
}

#[test]
fn real_transcoded_sl3() {
    damage_real("lowrance/glencanyon-transcoded.sl3", sl3_records, 12);
}

#[test]
fn real_hobart() {
    damage_real("lowrance/hobart-20m.sl3", sl3_records, 13);
    damage_real("lowrance/hobart-40m-negative-time.sl3", sl3_records, 14);
}

#[test]
fn real_small_sl2() {
    damage_real("lowrance/river-downscan-only.sl2", sl2_records, 15);
    damage_real("lowrance/elite4-stray-bytes.sl2", sl2_records, 16);
}

#[test]
fn real_xtf() {
    damage_real("xtf/000_1236.xtf", xtf_records, 17);
}

#[test]
fn real_humminbird() {
    let Some(data) = bathyscope_test_support::real_data() else {
        return;
    };
    let folder = data.join("humminbird-glen-canyon");
    let names = ["Rec00001.DAT", "Rec00001/B001.SON", "Rec00001/B002.SON", "Rec00001/B003.SON"];
    let read = |name: &&str| {
        (PathBuf::from(name), fs::read(folder.join(Path::new(name))).expect("a readable recording"))
    };
    let files: Vec<(PathBuf, Vec<u8>)> = names.iter().map(read).collect();
    let patient = Patient::new(&files, 2, son_records);
    patient.cut(18);
    patient.zero(19);
}
