//! Finds the record nearest to a time.

/// Index of the item nearest to `time_s`, the earlier of two equally near; `None` without items.
/// `items` are in the order of `time_of`, seconds.
pub fn nearest_in_time<T>(items: &[T], time_s: f64, time_of: impl Fn(&T) -> f64) -> Option<usize> {
    let after = items.partition_point(|item| time_of(item) < time_s);
    let before = after.saturating_sub(1);
    match (items.get(before), items.get(after)) {
        (Some(a), Some(b)) if time_of(b) - time_s < time_s - time_of(a) => Some(after),
        (Some(_), _) => Some(before),
        (None, _) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_found_before_between_and_beyond() {
        let times = [1.0, 2.0, 4.0];
        let nearest = |time_s| nearest_in_time(&times, time_s, |time| *time);
        assert_eq!(nearest(-3.0), Some(0));
        assert_eq!(nearest(1.5), Some(0));
        assert_eq!(nearest(1.6), Some(1));
        assert_eq!(nearest(3.5), Some(2));
        assert_eq!(nearest(9.0), Some(2));
        assert_eq!(nearest_in_time(&[] as &[f64], 0.0, |time| *time), None);
    }
}
