//! Counts each kind of sentence in a log, and chooses between kinds with the same content.

use super::lines::Found;
use crate::formats::collected::WarningReport;
use std::collections::BTreeMap;

/// Talker and type of a sentence, as `GPRMC`.
pub(super) type Address = [u8; 5];

/// Weight of a depth of DPT against a depth of DBT: DBT is only used where it has more than this
/// many times as many depths, because the second field of DPT states where depths count from. The
/// same weight applies to DBT against DBS, because DBT counts from the transducer, as first returns
/// do.
const COUNTS_MORE: usize = 4;

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
    pub(super) first_unix_s: Option<f64>,
    /// First magnetic variation, radians; positive to the east.
    pub(super) variation_rad: Option<f32>,
    /// True if the log has headings from true north.
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
    pub(super) fn needs_sum(&self) -> bool {
        self.with_sum > self.without_sum
    }

    /// Returns the address whose depths are used; `None` where the log has no depths.
    pub(super) fn depths_of(&self) -> Option<Address> {
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

    /// Returns the addresses whose times are used: those of the positions, if any, else the address
    /// with the most times.
    pub(super) fn times_of(&self) -> Vec<Address> {
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
    pub(super) fn remark(&self, report: &WarningReport) {
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
pub(super) fn name(address: &Address) -> String {
    String::from_utf8_lossy(address).into_owned()
}
