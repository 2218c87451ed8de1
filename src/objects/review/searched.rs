//! Keeps which pings of the survey a model has searched.

use super::Review;
use crate::Mark;
use std::ops::Range;
use std::sync::Arc;

/// Pings that were searched on both sides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Searched {
    /// Name of the model that searched the pings last.
    pub model: Arc<str>,
    /// The pings, the end excluded.
    pub pings: Range<usize>,
}

impl Review {
    /// Returns the searched pings, along the track; empty if they are not known: no search was
    /// made, or the review is from a program that did not record them.
    pub fn searched(&self) -> &[Searched] {
        &self.searched
    }

    /// Returns the pings that no search has covered, along the track; empty if the searched pings
    /// are not known.
    pub fn unsearched(&self) -> Vec<Range<usize>> {
        if self.searched.is_empty() {
            return Vec::new();
        }
        let starts = self.searched.iter().map(|search| search.pings.start);
        let ends = self.searched.iter().map(|search| search.pings.end);
        let from = std::iter::once(0).chain(ends);
        let to = starts.chain(std::iter::once(self.identity.pings));
        let between = from.zip(to).map(|(from, to)| from..to);
        between.filter(|gap| !gap.is_empty()).collect()
    }

    /// Returns the searched pings in words, such as `pings 0 to 811 of 3453`; `None` if all pings
    /// were searched, or the searched pings are not known.
    pub fn coverage(&self) -> Option<String> {
        if self.unsearched().is_empty() {
            return None;
        }
        let mut parts: Vec<Range<usize>> = Vec::new();
        for Searched { pings, .. } in &self.searched {
            match parts.last_mut() {
                Some(last) if last.end == pings.start => last.end = pings.end,
                _ => parts.push(pings.clone()),
            }
        }
        let parts = parts.iter();
        let parts: Vec<String> =
            parts.map(|part| format!("{} to {}", part.start, part.end - 1)).collect();
        Some(format!("pings {} of {}", parts.join(", "), self.identity.pings))
    }

    /// Returns true if a mark has pings that no search has covered; `unsearched` is the result of
    /// [`Review::unsearched`].
    pub(crate) fn reaches_into(unsearched: &[Range<usize>], mark: &Mark) -> bool {
        let meets = |gap: &Range<usize>| mark.pings.start < gap.end && gap.start < mark.pings.end;
        unsearched.iter().any(meets)
    }

    /// Records that a model has searched some pings, in place of any earlier search of them.
    pub(super) fn note_search(&mut self, model: &Arc<str>, pings: Range<usize>) {
        let pings = pings.start..pings.end.min(self.identity.pings);
        if pings.is_empty() {
            return;
        }
        let mut noted: Vec<Searched> = Vec::with_capacity(self.searched.len() + 2);
        for earlier in self.searched.drain(..) {
            let Range { start, end } = earlier.pings;
            for left in [start..end.min(pings.start), start.max(pings.end)..end] {
                if !left.is_empty() {
                    noted.push(Searched { model: earlier.model.clone(), pings: left });
                }
            }
        }
        noted.push(Searched { model: model.clone(), pings });
        noted.sort_by_key(|search| search.pings.start);
        for search in noted {
            match self.searched.last_mut() {
                Some(last)
                    if last.model == search.model && last.pings.end == search.pings.start =>
                {
                    last.pings.end = search.pings.end;
                }
                _ => self.searched.push(search),
            }
        }
    }
}
