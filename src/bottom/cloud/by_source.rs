//! Provides a list with one part for each source of points.

use super::{CloudPoint, PointSource};
use std::iter::Chain;
use std::ops::Index;
use std::slice::Iter;
use std::sync::Arc;

/// Entries by their source, in the order of [`PointSource`] and numbered through all parts. All
/// copies share the parts; each part can grow without the others being moved.
#[derive(Clone, Debug, PartialEq)]
pub struct BySource<T>([Arc<Vec<T>>; PointSource::ALL.len()]);

/// Entries of all sources: soundings, both sides, the swath.
type Entries<'a, T> = Chain<Chain<Iter<'a, T>, Chain<Iter<'a, T>, Iter<'a, T>>>, Iter<'a, T>>;

impl<T> Default for BySource<T> {
    fn default() -> Self {
        Self(Default::default())
    }
}

impl<T> BySource<T> {
    /// Creates the list from the entries of each source, made by `part`.
    pub fn from_parts(part: impl FnMut(PointSource) -> Arc<Vec<T>>) -> Self {
        Self(PointSource::ALL.map(part))
    }

    /// Returns the entries of one source.
    pub fn of(&self, source: PointSource) -> &Arc<Vec<T>> {
        &self.0[source as usize]
    }

    /// Returns the number of the first entry of a source.
    pub fn start(&self, source: PointSource) -> usize {
        let before = &self.0[..source as usize];
        before.iter().map(|part| part.len()).sum()
    }

    /// Returns the number of entries of all sources.
    pub fn len(&self) -> usize {
        self.0.iter().map(|part| part.len()).sum()
    }

    /// Returns true if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the entry with a number.
    pub fn get(&self, mut number: usize) -> Option<&T> {
        for part in &self.0 {
            match part.get(number) {
                Some(entry) => return Some(entry),
                None => number -= part.len(),
            }
        }
        None
    }

    /// Returns all entries in the order of their numbers.
    pub fn iter(&self) -> Entries<'_, T> {
        let [down_scan, port, starboard, swath] = &self.0;
        let sides = port.iter().chain(starboard.iter());
        down_scan.iter().chain(sides).chain(swath.iter())
    }
}

impl FromIterator<CloudPoint> for BySource<CloudPoint> {
    fn from_iter<I: IntoIterator<Item = CloudPoint>>(points: I) -> Self {
        let mut parts: [Vec<CloudPoint>; PointSource::ALL.len()] = Default::default();
        for point in points {
            parts[point.source as usize].push(point);
        }
        Self(parts.map(Arc::new))
    }
}

impl<'a, T> IntoIterator for &'a BySource<T> {
    type Item = &'a T;
    type IntoIter = Entries<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T> Index<usize> for BySource<T> {
    type Output = T;

    /// Returns the entry with a number.
    ///
    /// # Panics
    /// When there is no entry with this number.
    fn index(&self, number: usize) -> &T {
        match self.get(number) {
            Some(entry) => entry,
            None => panic!("entry {number} of {}", self.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_numbered_through_all_parts() {
        let list = BySource::from_parts(|source| match source {
            PointSource::DownScan => Arc::new(vec!['a', 'b']),
            PointSource::Port => Arc::default(),
            PointSource::Starboard => Arc::new(vec!['c']),
            PointSource::Swath => Arc::new(vec!['d', 'e']),
        });
        let all: Vec<char> = list.iter().copied().collect();
        assert_eq!(all, ['a', 'b', 'c', 'd', 'e']);
        assert_eq!((list.len(), list[2], list[4], list.get(5)), (5, 'c', 'e', None));
        let starts = PointSource::ALL.map(|source| list.start(source));
        assert_eq!(starts, [0, 2, 2, 3]);
        assert_eq!(list.of(PointSource::Starboard)[0], 'c');
    }
}
