//! A long series as few columns: the lowest and highest value in each, so that no spike is lost.

/// Lowest and highest value of each column; `None` where nothing was measured.
pub(super) type ColumnExtremes = Vec<Option<[f32; 2]>>;

/// Sorts `values`, pairs of time and value, into `count` columns over `from_s..=to_s`. Values that
/// are no numbers are left out.
pub(super) fn columns(
    values: impl Iterator<Item = (f64, f32)>,
    from_s: f64,
    to_s: f64,
    count: usize,
) -> ColumnExtremes {
    let mut columns: ColumnExtremes = vec![None; count];
    let width_s = (to_s - from_s).max(f64::MIN_POSITIVE);
    for (time_s, value) in values {
        if !value.is_finite() || !(from_s..=to_s).contains(&time_s) {
            continue;
        }
        let place = ((time_s - from_s) / width_s * count as f64) as usize;
        let Some(column) = columns.get_mut(place.min(count.saturating_sub(1))) else {
            continue;
        };
        let [low, high] = column.unwrap_or([value, value]);
        *column = Some([low.min(value), high.max(value)]);
    }
    columns
}

/// Lowest and highest value of all columns.
pub(super) fn span(columns: &ColumnExtremes) -> Option<[f32; 2]> {
    let known = columns.iter().flatten().copied();
    known.reduce(|[low, high], [l, h]| [low.min(l), high.max(h)])
}

/// The same series as `count` columns, more or fewer: extremes are kept, wide columns are repeated.
pub(super) fn resampled(
    columns: &ColumnExtremes,
    count: usize,
) -> impl Iterator<Item = Option<[f32; 2]>> + '_ {
    (0..count).map(move |index| {
        let from = index * columns.len() / count;
        let to = ((index + 1) * columns.len() / count).max(from + 1);
        let known = columns.get(from..to)?.iter().flatten().copied();
        known.reduce(|[low, high], [l, h]| [low.min(l), high.max(h)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_survives_any_decimation() {
        let values = (0..100_000).map(|index| {
            let value = if index == 54_321 { 9.0 } else { 1.0 };
            (f64::from(index), value)
        });
        let columns = columns(values, 0.0, 99_999.0, 100);
        assert_eq!(columns[54], Some([1.0, 9.0]));
        assert_eq!(columns[53], Some([1.0, 1.0]));
        assert_eq!(span(&columns), Some([1.0, 9.0]));
    }

    #[test]
    fn resampling_keeps_extremes_and_repeats_wide_columns() {
        let columns = vec![Some([1.0, 2.0]), Some([0.0, 1.0]), None, Some([3.0, 9.0])];
        let fewer: Vec<_> = resampled(&columns, 2).collect();
        assert_eq!(fewer, [Some([0.0, 2.0]), Some([3.0, 9.0])]);
        let more: Vec<_> = resampled(&columns, 8).collect();
        assert_eq!(more[..4], [columns[0], columns[0], columns[1], columns[1]]);
    }

    #[test]
    fn gaps_stay_gaps_and_what_is_no_number_is_left_out() {
        let values = [(0.0, 2.0), (5.0, f32::NAN), (10.0, 3.0), (11.0, 99.0)];
        let columns = columns(values.into_iter(), 0.0, 10.0, 4);
        assert_eq!(columns, [Some([2.0, 2.0]), None, None, Some([3.0, 3.0])]);
    }
}
