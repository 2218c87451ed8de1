//! Counts each kind of sentence in a log, and chooses between kinds that state the same.

use super::lines::Found;
use crate::formats::report::WarningReport;
use std::collections::BTreeMap;

/// Talker and type of a sentence, `GPRMC`.
pub(super) type Address = [u8; 5];

/// Weight of a depth of DPT against one of DBT: DBT is taken only where it has more than this many
/// times as many depths, as the second field of DPT states what they count from. The same weight
/// holds for DBT against DBS: below the transducer is where the first returns count from.
const COUNTS_MORE: usize = 4;

/// Counts of the sentences of one address.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    depths: usize,
    /// Positions with a time.
    positions: usize,
    /// Positions with a time that no sentence before them told.
    new_times: usize,
    times: usize,
}

/// Counts the sentences of a log.
#[derive(Debug, Default)]
pub(super) struct Tally {
    sources: BTreeMap<Address, Counts>,
    with_sum: usize,
    without_sum: usize,
    /// Time of the last position, seconds since midnight.
    last_utc_s: Option<f64>,
    /// The first time that tells the date, Unix seconds.
    pub(super) first_unix_s: Option<f64>,
    /// The first magnetic variation, radians; positive to the east.
    pub(super) variation_rad: Option<f32>,
    /// True if there are headings from true north.
    pub(super) has_true_heading: bool,
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
        let Some((address, told)) = framed.address().zip(framed.told()) else {
            return;
        };
        let counts = self.sources.entry(address).or_default();
        counts.depths += usize::from(told.depth_m > 0.0);
        counts.times += usize::from(told.utc_s.is_some());
        if told.position.is_some() && told.utc_s.is_some() {
            counts.positions += 1;
            counts.new_times += usize::from(told.utc_s != self.last_utc_s);
            self.last_utc_s = told.utc_s;
        }
        self.first_unix_s = self.first_unix_s.or(told.unix_s);
        let variation_rad = Some(told.variation_rad).filter(|variation| !variation.is_nan());
        self.variation_rad = self.variation_rad.or(variation_rad);
        self.has_true_heading |= !told.heading_rad.is_nan();
    }

    /// Returns true if a sentence without a sum is one that was cut: most have one.
    pub(super) fn needs_sum(&self) -> bool {
        self.with_sum > self.without_sum
    }

    /// Returns the address whose depths are taken; `None` where there are none.
    pub(super) fn depths_of(&self) -> Option<Address> {
        self.most(|address, counts| match &address[2..] {
            b"DPT" => COUNTS_MORE * COUNTS_MORE * counts.depths,
            b"DBT" => COUNTS_MORE * counts.depths,
            _ => counts.depths,
        })
    }

    /// Returns the addresses whose positions are taken. First comes the address that has most of
    /// them, of several with as many that which has course and speed beside them; then other
    /// sentences of that talker where they take turns, so that hardly any time is stated twice.
    pub(super) fn positions_of(&self) -> Vec<Address> {
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

    /// Returns the addresses whose times are taken: those of the positions, where there are any.
    pub(super) fn times_of(&self) -> Vec<Address> {
        let positions_of = self.positions_of();
        if positions_of.is_empty() {
            self.most(|_, counts| counts.times).into_iter().collect()
        } else {
            positions_of
        }
    }

    /// The address with most of something; `None` where all have none.
    fn most(&self, count: impl Fn(&Address, &Counts) -> usize) -> Option<Address> {
        let counts = self.sources.iter().map(|(at, counts)| (count(at, counts), at));
        let (most, address) = counts.max_by_key(|(count, _)| *count)?;
        (most > 0).then_some(*address)
    }

    /// Says which sentences are not used because others tell the same.
    pub(super) fn remark(&self, report: &WarningReport) {
        let depths = |counts: &Counts| counts.depths;
        let positions = |counts: &Counts| counts.positions;
        let depths_of: Vec<Address> = self.depths_of().into_iter().collect();
        self.remark_on("depths", &depths_of, depths, report);
        self.remark_on("positions", &self.positions_of(), positions, report);
    }

    /// Says it of what is counted by `count`, of which those of some addresses are taken.
    fn remark_on(
        &self,
        what: &str,
        taken: &[Address],
        count: impl Fn(&Counts) -> usize,
        report: &WarningReport,
    ) {
        let Some(first) = taken.first() else {
            return;
        };
        let others =
            self.sources.iter().filter(|(at, counts)| !taken.contains(at) && count(counts) > 0);
        let others = others.map(|(at, counts)| format!("{} of {}", count(counts), name(at)));
        let others = others.collect::<Vec<_>>().join(", ");
        if !others.is_empty() {
            report.log(format!(
                "the {what} of {} are read; others that tell the same are not: {others}",
                name(first)
            ));
        }
    }

    /// Describes the content other than depths in words: `120 positions`.
    pub(super) fn summary(&self) -> String {
        let positions: usize = self.sources.values().map(|counts| counts.positions).sum();
        format!("{positions} positions")
    }
}

/// An address as text.
pub(super) fn name(address: &Address) -> String {
    String::from_utf8_lossy(address).into_owned()
}
