//! Counts each kind of sentence in a log, chooses between kinds with the same content, and decodes
//! the sentences to depths and fixes in SI units.
//!
//! A sentence with a time begins an epoch; the sentences after it belong to the epoch, because
//! receivers send the time first. Depths between two epochs are placed between them in time.

use super::lines::{Found, stamps_apart_s};
use super::sentence::Sentence;
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted, WarningKind, WarningReport};
use crate::survey::{ChannelKind, Fix};
use std::collections::BTreeMap;
use std::f32::consts::TAU;

const DAY_S: f64 = 86_400.0;
/// Time between depths where the log does not give it, seconds.
const USUAL_STEP_S: f64 = 1.0;
/// Longest time between depths of an echo sounder, seconds: in a longer pause the depths are placed
/// at its beginning.
const LONGEST_STEP_S: f64 = 2.0;
/// Longest time from a position for which the logger's times are used, seconds.
const MOST_AFTER_S: f64 = 3600.0;
/// Longest time after which a course, heading or speed still belongs to a position, seconds.
const FRESH_S: f64 = 5.0;
/// Largest plausible distance of the transducer from the water line or the keel, metres.
const MOST_OFFSET_M: f32 = 100.0;
/// Number of the only channel.
const CHANNEL: u16 = 0;
/// Weight of a depth of DPT against a depth of DBT: DBT is only used where it has more than this
/// many times as many depths, because the second field of DPT states where depths count from. The
/// same weight applies to DBT against DBS, because DBT counts from the transducer, as first returns
/// do.
const COUNTS_MORE: usize = 4;

/// Talker and type of a sentence, as `GPRMC`.
type Address = [u8; 5];

/// Counts of the sentences of one address.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    depths: usize,
    /// Number of positions with a time.
    positions: usize,
    /// Number of positions whose time is different from that of the position before.
    new_times: usize,
    times: usize,
}

/// Counts of the sentences in a log.
#[derive(Debug, Default)]
pub(super) struct Tally {
    sources: BTreeMap<Address, Counts>,
    with_sum: usize,
    without_sum: usize,
    /// Time of the last position, seconds since midnight.
    last_utc_s: Option<f64>,
    /// First time with a date, Unix seconds.
    first_unix_s: Option<f64>,
    /// First magnetic variation, radians; positive to the east.
    variation_rad: Option<f32>,
    /// True if the log has headings from true north.
    has_true_heading: bool,
}

impl Tally {
    /// Counts a sentence.
    pub(super) fn take(&mut self, found: &Found<'_>) {
        let Some(framed) = found.framed() else {
            return;
        };
        if framed.has_sum {
            self.with_sum += 1
        } else {
            self.without_sum += 1
        }
        let Some((address, sentence)) = framed.address().zip(framed.sentence()) else {
            return;
        };
        let counts = self.sources.entry(address).or_default();
        counts.depths += usize::from(sentence.depth_m > 0.0);
        counts.times += usize::from(sentence.utc_s.is_some());
        if sentence.position.is_some() && sentence.utc_s.is_some() {
            counts.positions += 1;
            counts.new_times += usize::from(sentence.utc_s != self.last_utc_s);
            self.last_utc_s = sentence.utc_s;
        }
        self.first_unix_s = self.first_unix_s.or(sentence.unix_s);
        let variation_rad = Some(sentence.variation_rad).filter(|variation| !variation.is_nan());
        self.variation_rad = self.variation_rad.or(variation_rad);
        self.has_true_heading |= !sentence.heading_rad.is_nan();
    }

    /// Returns true if sentences without a checksum count as truncated, because most sentences have
    /// one.
    fn needs_sum(&self) -> bool {
        self.with_sum > self.without_sum
    }

    /// Returns the address whose depths are used; `None` where the log has no depths.
    fn depths_of(&self) -> Option<Address> {
        self.most(|address, counts| match &address[2..] {
            b"DPT" => COUNTS_MORE * COUNTS_MORE * counts.depths,
            b"DBT" => COUNTS_MORE * counts.depths,
            _ => counts.depths,
        })
    }

    /// Returns the addresses whose positions are used. The first is the address with the most
    /// positions; of several with as many, RMC, which also has course and speed. Other addresses of
    /// the same talker follow where their positions alternate with the first, so that hardly any
    /// time occurs twice.
    fn positions_of(&self) -> Vec<Address> {
        let first = self.most(|address, counts| {
            2 * counts.positions + usize::from(counts.positions > 0 && address.ends_with(b"RMC"))
        });
        let takes_turns = |address: &Address| {
            self.sources.get(address).is_some_and(|counts| {
                counts.new_times > 0 && 10 * counts.new_times >= 9 * counts.positions
            })
        };
        let others = self.sources.keys().copied().filter(|address| {
            first.is_some_and(|first| *address != first && address[..2] == first[..2])
                && first.as_ref().is_some_and(takes_turns)
                && takes_turns(address)
        });
        first.into_iter().chain(others).collect()
    }

    /// Returns the addresses whose times are used: those of the positions, if any, else the address
    /// with the most times.
    fn times_of(&self) -> Vec<Address> {
        let positions_of = self.positions_of();
        if positions_of.is_empty() {
            self.most(|_, counts| counts.times).into_iter().collect()
        } else {
            positions_of
        }
    }

    /// Returns the address with the largest count; `None` where all counts are 0.
    fn most(&self, count: impl Fn(&Address, &Counts) -> usize) -> Option<Address> {
        let counts = self.sources.iter().map(|(at, counts)| (count(at, counts), at));
        let (most, address) = counts.max_by_key(|(count, _)| *count)?;
        (most > 0).then_some(*address)
    }

    /// Warns about sentences that are not used because others have the same content.
    fn remark(&self, report: &WarningReport) {
        let depths = |counts: &Counts| counts.depths;
        let positions = |counts: &Counts| counts.positions;
        let depths_of: Vec<Address> = self.depths_of().into_iter().collect();
        self.remark_on("depths", &depths_of, depths, report);
        self.remark_on("positions", &self.positions_of(), positions, report);
    }

    /// Adds the warning about one kind of content: `count` counts it, and `used` are the addresses
    /// in use.
    fn remark_on(
        &self,
        what: &str,
        used: &[Address],
        count: impl Fn(&Counts) -> usize,
        report: &WarningReport,
    ) {
        let Some(first) = used.first() else {
            return;
        };
        let others =
            self.sources.iter().filter(|(at, counts)| !used.contains(at) && count(counts) > 0);
        let others = others.map(|(at, counts)| format!("{} of {}", count(counts), name(at)));
        let others = others.collect::<Vec<_>>().join(", ");
        if !others.is_empty() {
            report.log(format!(
                "the {what} of {} are read; others that tell the same are not: {others}",
                name(first)
            ));
        }
    }

    /// Describes the content other than depths, as `120 positions`.
    pub(super) fn summary(&self) -> String {
        let positions: usize = self.sources.values().map(|counts| counts.positions).sum();
        format!("{positions} positions")
    }
}

/// Returns an address as text.
fn name(address: &Address) -> String {
    String::from_utf8_lossy(address).into_owned()
}

/// A depth whose time is not determined yet.
#[derive(Clone, Copy, Debug)]
struct Depth {
    depth_m: f32,
    stamp_s: Option<f64>,
    /// Offset of the end of the depth's line.
    end: usize,
}

/// Course (radians), heading (radians) and speed (metres a second).
type Values = [f32; 3];

/// A time, and the values up to the next time.
#[derive(Debug)]
struct Epoch {
    at: usize,
    /// Time of the epoch, seconds: Unix seconds, or seconds since the first midnight where the date
    /// is unknown.
    time_s: f64,
    stamp_s: Option<f64>,
    fix: Option<Fix>,
    values: Values,
    /// Depths before this epoch, after the one before.
    depths: Vec<Depth>,
}

/// Decodes sentences, with the sources that the tally chose.
pub(super) struct Reader<'a> {
    tally: &'a Tally,
    depths_of: Address,
    positions_of: Vec<Address>,
    times_of: Vec<Address>,
    needs_sum: bool,
    clock: Clock<Epoch>,
    open: Option<Epoch>,
    /// Last time, to which the next time of day must be nearest, seconds.
    last_s: Option<f64>,
    /// Last value of course, heading and speed, each with its time, seconds.
    latest: [(f32, f64); 3],
    variation_rad: f32,
    waiting: Vec<Depth>,
    /// Depths of processed epochs whose times are not determined yet.
    held: Vec<Depth>,
    zero_s: Option<f64>,
    /// Time of the last processed epoch, seconds after the log's time zero, and the logger's time.
    before: Option<(f64, Option<f64>)>,
    step_s: f64,
    offset_m: f32,
    is_magnetic: bool,
}

impl<'a> Reader<'a> {
    /// Creates a reader of the log that was counted; `None` where the log has no depth.
    pub(super) fn new(tally: &'a Tally) -> Option<Self> {
        Some(Self {
            tally,
            depths_of: tally.depths_of()?,
            positions_of: tally.positions_of(),
            times_of: tally.times_of(),
            needs_sum: tally.needs_sum(),
            clock: Clock::default(),
            open: None,
            last_s: tally.first_unix_s,
            latest: [(f32::NAN, 0.0); 3],
            variation_rad: tally.variation_rad.unwrap_or(f32::NAN),
            waiting: Vec::new(),
            held: Vec::new(),
            zero_s: None,
            before: None,
            step_s: USUAL_STEP_S,
            offset_m: 0.0,
            is_magnetic: false,
        })
    }

    /// Decodes the next sentence.
    pub(super) fn take(&mut self, log: &mut Collected, found: &Found<'_>) {
        let framed = found.framed();
        let Some(framed) = framed.filter(|framed| framed.has_sum || !self.needs_sum) else {
            let text =
                "the sum of a sentence is missing or not that of its letters; it was dropped";
            return log.report.at(WarningKind::Frame, 0, found.at, text);
        };
        let Some((address, sentence)) = framed.address().zip(framed.sentence()) else {
            return;
        };
        if !sentence.depth_m.is_nan() {
            if address == self.depths_of {
                self.take_depth(&sentence, found);
            }
            return;
        }
        self.last_s = sentence.unix_s.or(self.last_s);
        if self.times_of.contains(&address)
            && let Some(utc_s) = sentence.utc_s
        {
            self.close(log);
            let is_taken = self.positions_of.contains(&address);
            let days = self.last_s.map_or(0.0, |last_s| ((last_s - utc_s) / DAY_S).round());
            let time_s = utc_s + days * DAY_S;
            self.last_s = Some(time_s);
            self.open = Some(Epoch {
                at: found.at,
                time_s,
                stamp_s: found.stamp_s(),
                fix: (sentence.position.filter(|_| is_taken))
                    .map(|position| Fix::at(time_s, position)),
                values: [f32::NAN; 3],
                depths: std::mem::take(&mut self.waiting),
            });
        }
        self.take_values(&sentence);
    }

    fn take_depth(&mut self, sentence: &Sentence, found: &Found<'_>) {
        if sentence.offset_m != 0.0 && sentence.offset_m.abs() < MOST_OFFSET_M {
            self.offset_m = sentence.offset_m;
        }
        self.waiting.push(Depth {
            depth_m: sentence.depth_m,
            stamp_s: found.stamp_s(),
            end: found.end,
        });
    }

    /// Stores course, heading and speed: the open epoch keeps the first value of each, and the last
    /// values are used for epochs without their own.
    fn take_values(&mut self, sentence: &Sentence) {
        if !sentence.variation_rad.is_nan() {
            self.variation_rad = sentence.variation_rad;
        }
        let heading_rad = if self.tally.has_true_heading {
            sentence.heading_rad
        } else {
            sentence.magnetic_rad
                + if self.variation_rad.is_nan() { 0.0 } else { self.variation_rad }
        };
        self.is_magnetic |= !self.tally.has_true_heading && !heading_rad.is_nan();
        let values = [sentence.cog_rad, heading_rad.rem_euclid(TAU), sentence.speed_mps];
        for (index, value) in values.into_iter().enumerate() {
            if value.is_nan() {
                continue;
            }
            self.latest[index] = (value, self.last_s.unwrap_or(0.0));
            if let Some(open) = &mut self.open
                && open.values[index].is_nan()
            {
                open.values[index] = value;
            }
        }
    }

    /// Ends the open epoch.
    fn close(&mut self, log: &mut Collected) {
        let Some(mut epoch) = self.open.take() else {
            return;
        };
        for (value, (latest, latest_s)) in epoch.values.iter_mut().zip(self.latest) {
            if value.is_nan() && (0.0..=FRESH_S).contains(&(epoch.time_s - latest_s)) {
                *value = latest;
            }
        }
        if let Some(verdict) = self.clock.push(epoch.time_s, epoch) {
            self.settle(log, verdict);
        }
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<Epoch>) {
        match verdict {
            ClockVerdict::Sound { record, time_s } => {
                let zero_s = *self.zero_s.get_or_insert(time_s);
                // Unix seconds in f64 have fewer decimals than receivers write.
                let time_s = ((time_s - zero_s) * 1e3).round() / 1e3;
                self.held.extend(record.depths);
                self.place(log, Some((time_s, record.stamp_s)));
                self.before = Some((time_s, record.stamp_s));
                let [cog_rad, compass_rad, speed_mps] = record.values;
                if let Some(fix) = record.fix {
                    log.add_fix(Fix { time_s, cog_rad, compass_rad, speed_mps, ..fix });
                }
            }
            ClockVerdict::Damaged(record) => {
                let text = "a sentence's time fits neither neighbour; its position was dropped";
                log.report.at(WarningKind::Value, 0, record.at, text);
                self.held.extend(record.depths);
            }
        }
    }

    /// Determines the times of the depths in `held`, which are between the last epoch and `next`.
    fn place(&mut self, log: &mut Collected, next: Option<(f64, Option<f64>)>) {
        let depths = std::mem::take(&mut self.held);
        let count = depths.len() as f64;
        if let (Some((from_s, _)), Some((to_s, _)), true) = (self.before, next, count > 0.0) {
            self.step_s = ((to_s - from_s) / count).clamp(0.0, LONGEST_STEP_S);
        }
        let (from_s, beside) = match (self.before, next) {
            (Some(before), _) => (before.0, before),
            (None, Some(next)) => (next.0 - count * self.step_s, next),
            (None, None) => return self.place_alone(log, &depths),
        };
        for (index, depth) in depths.iter().enumerate() {
            let after_s = depth.stamp_s.zip(beside.1);
            let after_s = after_s.map(|(its_s, stamp_s)| stamps_apart_s(stamp_s, its_s));
            let after_s = after_s.filter(|after_s| after_s.abs() <= MOST_AFTER_S);
            let time_s = match after_s {
                Some(after_s) => beside.0 + after_s,
                None => from_s + (index as f64 + 0.5) * self.step_s,
            };
            self.keep(log, depth, time_s);
        }
    }

    /// Determines the times of the depths in a log without any time of a receiver: the logger's
    /// times, or equal steps.
    fn place_alone(&mut self, log: &mut Collected, depths: &[Depth]) {
        let (mut time_s, mut last_s) = (-USUAL_STEP_S, None);
        for depth in depths {
            let step_s = last_s.zip(depth.stamp_s);
            time_s += step_s.map_or(USUAL_STEP_S, |(last_s, stamp_s)| {
                stamps_apart_s(last_s, stamp_s).clamp(0.0, MOST_AFTER_S)
            });
            last_s = depth.stamp_s.or(last_s);
            self.keep(log, depth, time_s);
        }
        let first_s = depths.first().and_then(|depth| depth.stamp_s);
        log.start_unix_s = first_s.filter(|first_s| *first_s > DAY_S);
        log.has_times = last_s.is_some();
        log.report.log(match last_s {
            Some(_) => "no sentence tells the time: the times of the depths are those that stand before them",
            None => "no sentence tells the time: the depths are taken to be one second apart",
        });
    }

    fn keep(&self, log: &mut Collected, depth: &Depth, time_s: f64) {
        let counted = Counted { record: (0, depth.end), time_s, samples: 0, range_m: None };
        log.count(CHANNEL, counted, || (ChannelKind::Primary, name(&self.depths_of), None));
        log.add_depth(ChannelKind::Primary, time_s, depth.depth_m);
    }

    /// Processes the remaining epochs and depths, and adds warnings about the log.
    pub(super) fn finish(mut self, log: &mut Collected) {
        self.close(log);
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        self.held.append(&mut self.waiting);
        self.place(log, None);
        log.report.set_back(self.clock.set_back_s);
        if self.tally.first_unix_s.is_some() {
            log.start_unix_s = self.zero_s;
        }
        self.tally.remark(&log.report);
        if self.depths_of.ends_with(b"DBS") {
            log.report.log("the depths (DBS) count from the water's surface and not from the transducer: leave draft_m at 0");
        }
        if self.offset_m != 0.0 {
            let offset_m = self.offset_m.abs();
            log.report.log(if self.offset_m > 0.0 { format!("the log says that the transducer hangs {offset_m:.2} m below the water line; depths count from the transducer: set draft_m to {offset_m:.2}") } else { format!("the log says that the keel lies {offset_m:.2} m below the transducer; depths count from the transducer: set draft_m to what it hangs below the water's surface") });
        }
        if self.is_magnetic && self.variation_rad.is_nan() {
            log.report.log("headings are magnetic and no sentence tells the variation; set mounting.heading_offset_deg to it");
        }
        if self.zero_s.is_some() && log.start_unix_s.is_none() {
            log.report.log("no sentence tells the date (RMC, ZDA): the time of day is known, and the day is not");
        }
    }
}
