//! Caches the tiles that were drawn most recently, up to a number of bytes.

use std::collections::HashMap;
use std::hash::Hash;

/// Cache of the values that were used most recently, up to a number of bytes; values used in the
/// current frame are never dropped.
pub struct Lru<K, V> {
    entries: HashMap<K, CacheEntry<V>>,
    bytes: usize,
    budget: usize,
    frame: u64,
}

struct CacheEntry<V> {
    value: V,
    bytes: usize,
    used: u64,
}

impl<K: Copy + Eq + Hash, V> Lru<K, V> {
    /// Creates an empty cache of at most `budget` bytes.
    pub fn new(budget: usize) -> Self {
        Self { entries: HashMap::new(), bytes: 0, budget, frame: 0 }
    }

    /// Begins a frame: drops the least recently used values until the cache is within its budget.
    pub fn begin_frame(&mut self) {
        if self.bytes > self.budget {
            let mut by_age: Vec<(u64, K)> = self
                .entries
                .iter()
                .map(|(key, entry)| (entry.used, *key))
                .filter(|(used, _)| *used < self.frame)
                .collect();
            by_age.sort_unstable_by_key(|(used, _)| *used);
            for (_, key) in by_age {
                if self.bytes <= self.budget {
                    break;
                }
                if let Some(entry) = self.entries.remove(&key) {
                    self.bytes -= entry.bytes;
                }
            }
        }
        self.frame += 1;
    }

    /// Adds or replaces a value of a size of `bytes` bytes.
    pub fn insert(&mut self, key: K, value: V, bytes: usize) {
        let entry = CacheEntry { value, bytes, used: self.frame };
        if let Some(old) = self.entries.insert(key, entry) {
            self.bytes -= old.bytes;
        }
        self.bytes += bytes;
    }

    /// Returns a value, and marks it as used in this frame.
    pub fn use_now(&mut self, key: &K) -> Option<&mut V> {
        let entry = self.entries.get_mut(key)?;
        entry.used = self.frame;
        Some(&mut entry.value)
    }

    /// Calls a function with every key and value, to change values in place.
    pub fn change(&mut self, mut change: impl FnMut(&K, &mut V)) {
        for (key, entry) in &mut self.entries {
            change(key, &mut entry.value);
        }
    }

    /// Returns a value without marking it as used.
    pub fn peek(&self, key: &K) -> Option<&V> {
        self.entries.get(key).map(|entry| &entry.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waterfall::WaterfallTileKey;
    use bathyscope_log::survey::Side;

    fn key(column: u32) -> WaterfallTileKey {
        WaterfallTileKey::at_boat(Side::Port, [0, 0], column)
    }

    #[test]
    fn drops_the_least_recently_used_beyond_the_budget() {
        let mut cache = Lru::new(30);
        for column in 0..3 {
            cache.begin_frame();
            cache.insert(key(column), column, 10);
        }
        cache.begin_frame();
        cache.use_now(&key(0));
        cache.insert(key(3), 3, 10);
        cache.begin_frame();
        let kept: Vec<u32> = (0..4).filter_map(|n| cache.peek(&key(n)).copied()).collect();
        assert_eq!(kept, [0, 2, 3]);
        assert_eq!(cache.bytes, 30);
    }

    #[test]
    fn keeps_what_the_last_frame_used_even_over_budget() {
        let mut cache = Lru::new(10);
        cache.begin_frame();
        for column in 0..5 {
            cache.insert(key(column), column, 10);
        }
        cache.begin_frame();
        assert_eq!((0..5).filter(|n| cache.peek(&key(*n)).is_some()).count(), 5);
        cache.begin_frame();
        assert_eq!(cache.bytes, 10);
    }
}
