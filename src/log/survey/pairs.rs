//! Pairs of side-scan channels: a sonar of several frequencies records one for each, of which one
//! is shown.

use super::{SidePing, SideScanState, SideSpan, Survey, give_depths};
use std::sync::Arc;

/// A pair of side-scan channels.
#[derive(Clone, Debug, PartialEq)]
pub struct SidePair {
    /// The recorder's name for it.
    pub name: String,
    /// Frequency where it is stated, kHz.
    pub frequency_khz: Option<f32>,
    /// Its pings, in time order, with depths as those of [`Survey::side_scan`].
    pub side_scan: Arc<Vec<SidePing>>,
}

impl SidePair {
    /// `400 kHz, PORT HF`.
    pub fn summary(&self) -> String {
        match self.frequency_khz {
            Some(khz) => format!("{khz} kHz, {}", self.name),
            None => self.name.clone(),
        }
    }
}

impl Survey {
    /// The last side of a ping of each pair, that of the pair that is shown first.
    pub(crate) fn last_spans(&self) -> impl Iterator<Item = SideSpan> {
        let others = self.pairs.iter().skip(1).map(|pair| &pair.side_scan);
        let last = |pings: &Arc<Vec<SidePing>>| {
            let mut pings = pings.iter().rev();
            pings.find_map(|ping| ping.port.or(ping.starboard))
        };
        std::iter::once(&self.side_scan).chain(others).filter_map(last)
    }

    /// Describes the pairs in a sentence: which one is shown, and how to show others; `None` where
    /// there is one at most.
    pub(crate) fn pairs_summary(&self) -> Option<String> {
        let [shown, others @ ..] = &self.pairs[..] else {
            return None;
        };
        let has_choice = self.pairs.iter().any(|pair| pair.frequency_khz.is_some());
        let others: Vec<String> = others.iter().map(SidePair::summary).collect();
        let others = if has_choice {
            format!("set source.frequency_khz to show {}", others.join(" or "))
        } else {
            format!("no frequencies are stated to choose {} by", others.join(" or "))
        };
        Some(format!(
            "the log holds {} pairs of side-scan channels: {} is shown; {others}",
            self.pairs.len(),
            shown.summary(),
        ))
    }

    /// The same log, showing the pair of channels whose frequency is nearest to one in kHz;
    /// unchanged where no pair states one.
    #[must_use]
    pub fn with_frequency(mut self, frequency_khz: f64) -> Self {
        let off_khz = |pair: &SidePair| {
            let khz = pair.frequency_khz.map_or(f64::INFINITY, f64::from);
            (khz - frequency_khz).abs()
        };
        let pairs = self.pairs.iter().enumerate();
        let pairs = pairs.filter(|(_, pair)| pair.frequency_khz.is_some());
        let nearest = pairs.min_by(|(_, a), (_, b)| off_khz(a).total_cmp(&off_khz(b)));
        let chosen = nearest.map(|(index, _)| index);
        let Some(chosen) = chosen.filter(|chosen| *chosen > 0) else {
            return self;
        };
        let before = self.pairs_summary().unwrap_or_default();
        self.pairs[..=chosen].rotate_right(1);
        let after = self.pairs_summary().unwrap_or_default();
        for warning in self.warnings.iter_mut().filter(|warning| warning.text == before) {
            warning.text.clone_from(&after);
        }
        self.side_scan = self.pairs[0].side_scan.clone();
        if !self.side_scan.is_empty() {
            self.side_scan_state = SideScanState::Usable;
        }
        self
    }

    /// Returns true if a pair began that the log did not hold.
    pub(super) fn has_new_pair(&self, tail: &Survey) -> bool {
        let is_known = |new: &SidePair| self.pairs.iter().any(|pair| pair.name == new.name);
        !tail.pairs.iter().all(is_known)
    }

    /// The pairs of the log with what `tail` added to them from a time on. `longer` has the pings
    /// of the pair that is shown, and all soundings.
    pub(super) fn extended_pairs(
        &self,
        tail: &Survey,
        from_s: f64,
        longer: &Survey,
    ) -> Vec<SidePair> {
        let extended = |(index, pair): (usize, &SidePair)| {
            if index == 0 {
                return SidePair { side_scan: longer.side_scan.clone(), ..pair.clone() };
            }
            let older = |pings: &[SidePing]| pings.partition_point(|ping| ping.time_s < from_s);
            let mut pings = pair.side_scan[..older(&pair.side_scan)].to_vec();
            let same = tail.pairs.iter().find(|one| one.name == pair.name);
            let added = same.map_or(&[][..], |one| &one.side_scan[..]);
            pings.extend_from_slice(&added[older(added)..]);
            give_depths(&mut pings, &longer.soundings);
            SidePair { side_scan: Arc::new(pings), ..pair.clone() }
        };
        self.pairs.iter().enumerate().map(extended).collect()
    }
}
