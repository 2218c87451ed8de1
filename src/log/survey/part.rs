//! Cuts a part out of a log: some of its pings, and everything that was recorded during their time.

use super::{Echogram, Navigation, Survey};
use std::ops::Range;
use std::sync::Arc;

impl Survey {
    /// Returns the times of the records by which a part is chosen: the side-scan pings, or the
    /// soundings of a log without side-scan.
    pub fn record_times_s(&self) -> Vec<f64> {
        if !self.side_scan.is_empty() {
            self.side_scan.iter().map(|ping| ping.time_s).collect()
        } else {
            self.soundings.iter().map(|sounding| sounding.time_s).collect()
        }
    }

    /// Returns a part of the log, and its navigation: the stretches `records`, indices into
    /// [`Survey::record_times_s`] in order and without overlap, with everything that was recorded
    /// from the first record of each stretch to the record after its last. The samples are shared,
    /// not copied.
    pub fn part(&self, navigation: &Navigation, records: &[Range<usize>]) -> (Survey, Navigation) {
        let times_s = self.record_times_s();
        let spans: Vec<Range<f64>> =
            (records.iter()).map(|stretch| span_s(&times_s, stretch)).collect();
        let by_sides = !self.side_scan.is_empty();
        let echogram = |echogram: &Echogram| {
            let chosen = indices(&echogram.pings, &spans, |ping| ping.time_s);
            Echogram { kind: echogram.kind, pings: Arc::new(select(&echogram.pings, &chosen)) }
        };
        let mut fixes: Vec<Range<usize>> = Vec::new();
        for span in &spans {
            let all = &self.track.fixes;
            let begun = all.partition_point(|fix| fix.time_s <= span.start);
            let taken_to = fixes.last().map_or(0, |stretch| stretch.end);
            // The last fix before the stretch is valid at its first record.
            let start = begun.saturating_sub(1).max(taken_to);
            let end = all.partition_point(|fix| fix.time_s < span.end);
            fixes.push(start..end.max(start));
        }
        let chosen_soundings = if by_sides {
            indices(&self.soundings, &spans, |sounding| sounding.time_s)
        } else {
            records.to_vec()
        };
        let chosen_swath = indices(&self.swath, &spans, |ping| ping.time_s);
        let survey = Self {
            side_scan: Arc::new(select(&self.side_scan, records)),
            echograms: self.echograms.iter().map(echogram).collect(),
            soundings: Arc::new(select(&self.soundings, &chosen_soundings)),
            swath: Arc::new(select(&self.swath, &chosen_swath)),
            track: self.track.with_fixes(select(&self.track.fixes, &fixes)),
            ..self.clone()
        };
        let navigation = Navigation {
            pings: Arc::new(select(&navigation.pings, records)),
            soundings: Arc::new(select(&navigation.soundings, &chosen_soundings)),
            swath: Arc::new(select(&navigation.swath, &chosen_swath)),
            ..navigation.clone()
        };
        (survey, navigation)
    }
}

/// Returns the time span of a stretch of records: up to the record after it, and without limit
/// before the first record and after the last.
fn span_s(times_s: &[f64], stretch: &Range<usize>) -> Range<f64> {
    let time_s = |index: usize| times_s.get(index).copied();
    let start = match stretch.start {
        0 => f64::NEG_INFINITY,
        start => time_s(start).unwrap_or(f64::INFINITY),
    };
    start..time_s(stretch.end).unwrap_or(f64::INFINITY)
}

/// Returns the index ranges of the items in some time spans; the items are in time order.
fn indices<T>(items: &[T], spans: &[Range<f64>], time_s: impl Fn(&T) -> f64) -> Vec<Range<usize>> {
    let before = |at_s: f64| items.partition_point(|item| time_s(item) < at_s);
    let stretches = spans.iter().map(|span| before(span.start)..before(span.end));
    stretches.collect()
}

/// Returns the items of some index ranges; indices beyond the last item are ignored.
fn select<T: Clone>(items: &[T], stretches: &[Range<usize>]) -> Vec<T> {
    let parts = stretches.iter().flat_map(|stretch| {
        let end = stretch.end.min(items.len());
        &items[stretch.start.min(end)..end]
    });
    parts.cloned().collect()
}

#[cfg(test)]
mod tests {
    use crate::support::geo::LonLat;
    use crate::survey::{
        ChannelKind, Echogram, EchogramPing, Fix, Navigation, PingNav, SidePing, SideSpan,
        Sounding, Survey, Track,
    };
    use std::sync::Arc;

    /// Creates a log of ten side-scan pings a second apart (if `has_sides`), a sounding and a
    /// down-scan ping half a second after each, and a fix every three seconds.
    fn log(has_sides: bool) -> (Survey, Navigation) {
        let times = (0..10).map(f64::from);
        let sounding = |time_s: f64| Sounding::new(time_s + 0.5, 3.0);
        let down = |time_s: f64| EchogramPing {
            time_s: time_s + 0.5,
            span: SideSpan::of_bytes(1, [0.0, 1.0]),
        };
        let fix = |number: usize| Fix::at(3.0 * number as f64, LonLat::new(number as f64, 1.0));
        let place = |time_s: f64| PingNav::northbound([0.0, time_s], 1.0);
        let sides: Vec<f64> = times.clone().filter(|_| has_sides).collect();
        let survey = Survey {
            side_scan: Arc::new(
                sides.iter().map(|time_s| SidePing::with_depth(*time_s, 3.0)).collect(),
            ),
            soundings: Arc::new(times.clone().map(sounding).collect()),
            echograms: vec![Echogram {
                kind: ChannelKind::DownScan,
                pings: Arc::new(times.clone().map(down).collect()),
            }],
            track: Track::new((0..4).map(fix).collect()),
            ..Survey::default()
        };
        let navigation = Navigation {
            soundings: Arc::new(times.map(place).collect()),
            ..Navigation::of_pings(sides.into_iter().map(place))
        };
        (survey, navigation)
    }

    #[test]
    fn a_part_has_what_was_recorded_meanwhile_and_the_fix_that_was_valid() {
        let (survey, navigation) = log(true);
        let (part, places) = survey.part(&navigation, &[2..4, 8..10]);
        let times: Vec<f64> = part.side_scan.iter().map(|ping| ping.time_s).collect();
        assert_eq!(times, [2.0, 3.0, 8.0, 9.0]);
        let norths: Vec<f64> = places.pings.iter().map(|place| place.north_m).collect();
        assert_eq!(norths, times);
        let soundings: Vec<f64> = part.soundings.iter().map(|sounding| sounding.time_s).collect();
        assert_eq!(soundings, [2.5, 3.5, 8.5, 9.5]);
        assert_eq!(part.echograms[0].pings.len(), 4);
        let fixes: Vec<f64> = part.track.fixes.iter().map(|fix| fix.time_s).collect();
        assert_eq!(fixes, [0.0, 3.0, 6.0, 9.0]);
        // The first and the last stretch have no border.
        let (whole, _) = survey.part(&navigation, std::slice::from_ref(&(0..10)));
        assert_eq!(whole.soundings, survey.soundings);
        assert_eq!(whole.track.fixes.len(), survey.track.fixes.len());
        let (beyond, _) = survey.part(&navigation, std::slice::from_ref(&(9..99)));
        assert_eq!(beyond.side_scan.len(), 1);
    }

    #[test]
    fn a_log_without_side_scan_is_cut_by_its_soundings() {
        let (survey, navigation) = log(false);
        let (part, places) = survey.part(&navigation, std::slice::from_ref(&(3..5)));
        let soundings: Vec<f64> = part.soundings.iter().map(|sounding| sounding.time_s).collect();
        assert_eq!(soundings, [3.5, 4.5]);
        assert_eq!(places.soundings.len(), 2);
        assert!(part.side_scan.is_empty() && places.pings.is_empty());
    }
}
