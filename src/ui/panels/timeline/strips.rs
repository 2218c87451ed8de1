//! Reduces the data of the time line in a background thread to a few columns with the lowest and
//! highest value of each, so that no spike is lost.

use bathyscope_bottom::cloud::{DepthReference, DepthSource};
use bathyscope_bottom::presentation::units::Units;
use bathyscope_log::survey::{Sounding, Survey};
use bathyscope_products::pipeline::Products;
use egui::Rect;

/// Greatest number of columns that a log is reduced to; more than the width of any screen.
const COLUMNS: usize = 2048;

/// Data of the strips, computed in a background thread for each survey and navigation.
pub(super) struct Strips {
    /// First time of the log, seconds after its time zero.
    pub from_s: f64,
    /// Last time of the log, seconds after its time zero.
    pub to_s: f64,
    /// Depths of the recorder's bottom lock as the depth map uses them, metres.
    pub depth: ColumnExtremes,
    /// Depths by side-scan where the recorder had lost the bottom or has no depth, metres.
    pub side_scan: ColumnExtremes,
    /// Depths of the recorder after it had lost the bottom, metres.
    pub lost: ColumnExtremes,
    /// Speeds over ground, metres a second.
    pub speed: ColumnExtremes,
    /// Level that the depths are counted from.
    pub reference: DepthReference,
    /// Times of the log's warnings, seconds after its time zero.
    pub warnings_s: Vec<f64>,
}

impl Strips {
    pub(super) fn of(survey: &Survey, products: Option<&Products>) -> Option<Self> {
        let reduction = products.map(Products::reduction).unwrap_or_default();
        let pings = &survey.side_scan;
        let soundings = &survey.soundings;
        let starts = [pings.first().map(|p| p.time_s), soundings.first().map(|s| s.time_s)];
        let ends = [pings.last().map(|p| p.time_s), soundings.last().map(|s| s.time_s)];
        let from_s = starts.into_iter().flatten().reduce(f64::min)?;
        let to_s = ends.into_iter().flatten().reduce(f64::max)?;
        let depths = |is_good: bool| {
            let some = soundings.iter().filter(move |s| s.is_good() == is_good);
            let count = column_count(soundings.len());
            let depth = |s: &Sounding| {
                let depth_m = reduction.depth_m(s.time_s, f64::from(s.depth_m));
                (s.time_s, depth_m as f32)
            };
            columns(some.map(depth), from_s, to_s, count)
        };
        // A log without side-scan still has the boat's speed at its soundings.
        let times = if pings.is_empty() {
            soundings.iter().map(|s| s.time_s).collect::<Vec<_>>()
        } else {
            pings.iter().map(|ping| ping.time_s).collect()
        };
        let places = products.map_or(&[][..], |products| {
            let navigation = &products.navigation;
            if pings.is_empty() { &navigation.soundings } else { &navigation.pings }
        });
        let speeds = times.iter().zip(places);
        let speeds = speeds.map(|(time_s, here)| (*time_s, here.speed_mps as f32));
        let ping_depths = products.map_or(&[][..], |products| &products.depths[..]);
        let by_side_scan = pings.iter().zip(ping_depths);
        let by_side_scan = by_side_scan
            .filter(|(_, depth)| depth.source == DepthSource::SideScan)
            .map(|(ping, depth)| (ping.time_s, depth.depth_m));
        Some(Self {
            from_s,
            to_s,
            depth: depths(true),
            side_scan: columns(by_side_scan, from_s, to_s, column_count(pings.len())),
            lost: depths(false),
            speed: columns(speeds, from_s, to_s, column_count(times.len())),
            reference: reduction.reference(),
            warnings_s: warning_times(survey),
        })
    }

    /// Returns the depth of the strip's lower edge with its reference as text; `None` without
    /// depths.
    pub(super) fn deepest(&self, units: Units) -> Option<String> {
        let deepest_m = span(&self.depth).or_else(|| span(&self.lost))?[1];
        let deepest = units.measure(f64::from(deepest_m), 1);
        Some(format!("to {deepest} {}", self.reference.name()))
    }

    /// Returns the screen x of a time.
    pub(super) fn x(&self, rect: Rect, time_s: f64) -> f32 {
        let share = (time_s - self.from_s) / (self.to_s - self.from_s).max(f64::MIN_POSITIVE);
        rect.left() + rect.width() * share as f32
    }

    /// Returns the time at a screen x.
    pub(super) fn time_s(&self, rect: Rect, x: f32) -> f64 {
        let share = f64::from(((x - rect.left()) / rect.width()).clamp(0.0, 1.0));
        self.from_s + share * (self.to_s - self.from_s)
    }
}

/// Returns the number of columns for a number of values: each column gets so many that a regular
/// series leaves no gaps.
fn column_count(values: usize) -> usize {
    (values / 3).clamp(16, COLUMNS)
}

/// Returns the times of the pings that the log's warnings refer to, at most as many as columns.
fn warning_times(survey: &Survey) -> Vec<f64> {
    let offset = |ping: &bathyscope_log::survey::SidePing, file: usize| {
        let span = ping.port.or(ping.starboard)?;
        (usize::from(span.file) == file).then_some(span.offset)
    };
    let places = survey.warnings.iter().filter_map(|warning| warning.place);
    places
        .take(COLUMNS)
        .filter_map(|(file, at)| {
            let after = survey
                .side_scan
                .partition_point(|ping| offset(ping, file).is_some_and(|offset| offset < at));
            survey.side_scan.get(after).map(|ping| ping.time_s)
        })
        .collect()
}

/// Lowest and highest value of each column; `None` for a column without a measurement.
pub(super) type ColumnExtremes = Vec<Option<[f32; 2]>>;

/// Sorts `values`, pairs of time and value, into `count` columns over `from_s..=to_s`. Values that
/// are not finite are left out.
fn columns(
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

/// Returns the lowest and highest value of all columns; `None` if all are empty.
pub(super) fn span(columns: &ColumnExtremes) -> Option<[f32; 2]> {
    let known = columns.iter().flatten().copied();
    known.reduce(|[low, high], [l, h]| [low.min(l), high.max(h)])
}

/// Returns a series with another number of columns: merged columns keep their extremes, and wide
/// columns are repeated.
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
