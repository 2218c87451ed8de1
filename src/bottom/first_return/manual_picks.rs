//! Stores and applies manual picks (bottom edits): where the detected first return is wrong and the
//! analyst recognises the ground, a manual pick replaces it.

use super::{FirstReturns, Pick};
use bathyscope_log::support::statistics::ends;
use bathyscope_log::survey::{Identity, Side, Survey};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// `bottom.*` settings: the edits of the first returns of one log. Bathyscope keeps them in
/// `LOG.bottom.toml`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BottomSettings {
    /// Size in bytes of the log that the edits were drawn on. The edits are not applied to another
    /// log.
    pub log_bytes: u64,
    /// Number of side-scan pings of that log.
    pub pings: usize,
    /// True if the edits were drawn with port and starboard exchanged against the recording
    /// (`mounting.swap_sides`).
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub swapped_sides: bool,
    /// Edited stretches; no two cover the same ping of a side.
    pub lines: Vec<BottomEdit>,
}

/// Edit of the bottom on one side over a stretch of pings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BottomEdit {
    /// Side of the boat.
    pub side: Side,
    /// First and last ping of the stretch.
    pub pings: [usize; 2],
    /// Corners of the drawn line: ping and slant range, metres by the recorder's scale. The line is
    /// straight between corners and level beyond the ends. No corners where no bottom is detected.
    #[serde(default)]
    pub corners: Vec<[f64; 2]>,
    /// True if the first returns stay where they were found, and are bottom whatever the recorded
    /// depth. Such an edit has no corners.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub accepted: bool,
}

/// Largest number of edits in a file: more were not made by a person.
const MOST_LINES: usize = 100_000;

impl BottomEdit {
    /// Creates the edit along a path of the pen. `path` holds pings with their fractions (ping 7 is
    /// from 7.0 to 8.0) and slant ranges, metres; where the pen went back, the last value counts.
    /// Corners within `tolerance_m` of the line are left out. Returns `None` for a path that meets
    /// none of the `count` pings.
    pub fn along(
        path: &[[f64; 2]],
        side: Side,
        count: usize,
        tolerance_m: f64,
    ) -> Option<BottomEdit> {
        let last = count.checked_sub(1)? as f64;
        let ping_of = |at: f64| at.floor().clamp(0.0, last) as usize;
        let [low, high] = ends(path.iter().map(|[ping, _]| *ping));
        if !(low <= high && high >= 0.0 && low <= last + 1.0) {
            return None;
        }
        let (from, to) = (ping_of(low), ping_of(high));
        let mut ranges_m = vec![f64::NAN; to - from + 1];
        for [ping, range_m] in path {
            ranges_m[ping_of(*ping) - from] = *range_m;
        }
        for pair in path.windows(2) {
            let [[a, at_a_m], [b, at_b_m]] = [pair[0], pair[1]];
            for ping in ping_of(a.min(b))..=ping_of(a.max(b)) {
                let share = (ping as f64 + 0.5 - a) / (b - a);
                if (0.0..=1.0).contains(&share) {
                    ranges_m[ping - from] = at_a_m + share * (at_b_m - at_a_m);
                }
            }
        }
        let drawn = (from..).zip(ranges_m);
        let corners = drawn.map(|(ping, range_m)| [ping as f64, range_m.max(0.0)]);
        Some(Self {
            side,
            pings: [from, to],
            corners: simplified(&corners.collect::<Vec<_>>(), tolerance_m),
            accepted: false,
        })
    }

    fn covers(&self, side: Side, ping: usize) -> bool {
        self.side == side && self.span().contains(&ping)
    }

    fn span(&self) -> RangeInclusive<usize> {
        self.pings[0]..=self.pings[1]
    }

    /// Returns the slant range at a ping, metres by the recorder's scale; `None` where no bottom is
    /// detected.
    pub fn range_m(&self, ping: usize) -> Option<f64> {
        let at = ping as f64;
        let after = self.corners.partition_point(|[corner, _]| *corner <= at);
        let &[from, from_m] = self.corners.get(after.saturating_sub(1))?;
        match self.corners.get(after) {
            Some(&[to, to_m]) if after > 0 => {
                Some(from_m + (to_m - from_m) * (at - from) / (to - from))
            }
            _ => Some(from_m),
        }
    }

    /// Returns the parts of the edit before and after some pings.
    fn outside(&self, pings: [usize; 2]) -> impl Iterator<Item = BottomEdit> + use<> {
        let [first, last] = self.pings;
        let before = (first < pings[0]).then(|| [first, last.min(pings[0].saturating_sub(1))]);
        let after = (last > pings[1]).then(|| [first.max(pings[1] + 1), last]);
        let line = self.clone();
        [before, after].into_iter().flatten().map(move |pings| BottomEdit { pings, ..line.clone() })
    }
}

/// Error for bottom edits that belong to another log.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct OtherLog(String);

impl BottomSettings {
    /// Extension of the sidecar file of the settings, in place of that of the log.
    pub const SIDECAR: &str = "bottom.toml";

    /// Creates empty settings for a log.
    pub fn of(survey: &Survey) -> Self {
        let identity = Identity::of(survey);
        Self {
            log_bytes: identity.byte_count,
            pings: identity.pings,
            swapped_sides: identity.swapped_sides,
            lines: Vec::new(),
        }
    }

    /// Checks that the edits were drawn on this log.
    ///
    /// # Errors
    /// When the edits were drawn on another log.
    pub fn belongs_to(&self, survey: &Survey) -> Result<(), OtherLog> {
        let Self { log_bytes, pings, .. } = Self::of(survey);
        // An earlier version also counted the bytes of a track that was applied to the log.
        let track = survey.track.external.as_ref().and(survey.bytes.last());
        let with_track = log_bytes + track.map_or(0, |track| track.len() as u64);
        if self.pings == pings && [log_bytes, with_track].contains(&self.log_bytes) {
            return Ok(());
        }
        Err(OtherLog(format!(
            "it belongs to a log of {} bytes and {} pings, this one has {log_bytes} and {pings}",
            self.log_bytes, self.pings
        )))
    }

    /// Returns the edits of a sidecar file with the size and the sides of the log that it belongs
    /// to. An earlier version also counted the bytes of a track that was applied to the log, which
    /// may be gone.
    ///
    /// # Errors
    /// When the edits were drawn on another log.
    pub fn adopted(self, survey: &Survey) -> Result<Self, OtherLog> {
        let of = Self::of(survey);
        if survey.was(self.log_bytes, self.pings) {
            // The log has grown since the edits were drawn.
            return Ok(Self { log_bytes: of.log_bytes, pings: of.pings, ..self });
        }
        if self.pings != of.pings || self.log_bytes < of.log_bytes {
            self.belongs_to(survey)?;
        }
        Ok(Self { log_bytes: of.log_bytes, ..self }.with_sides(survey.swapped_sides))
    }

    /// Returns the edits for a log with port and starboard exchanged or not: an edit stays on the
    /// echoes that it was drawn on.
    #[must_use]
    pub fn with_sides(mut self, swapped_sides: bool) -> Self {
        if !self.is_empty() && self.swapped_sides != swapped_sides {
            for line in &mut self.lines {
                line.side = line.side.other();
            }
            self.lines.sort_by_key(|line| (line.side, line.pings));
            self.swapped_sides = swapped_sides;
        }
        self
    }

    /// Returns true if there is no edit.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// Returns the settings with one more edit; it replaces the earlier edits of its pings.
    pub fn with(&self, line: BottomEdit) -> Self {
        let mut all = self.without(line.side, line.pings);
        all.lines.push(line);
        all.lines.sort_by_key(|line| (line.side, line.pings));
        all
    }

    /// Returns the settings without the edits of these pings, from the first to the last: the first
    /// returns found there count again.
    pub fn without(&self, side: Side, pings: [usize; 2]) -> Self {
        let lines = self.lines.iter().flat_map(|line| {
            let meets = line.side == side && line.pings[0] <= pings[1] && line.pings[1] >= pings[0];
            let whole = (!meets).then(|| line.clone());
            let parts = meets.then(|| line.outside(pings));
            whole.into_iter().chain(parts.into_iter().flatten())
        });
        Self { lines: lines.collect(), ..*self }
    }

    /// Returns the edit that covers a ping; `None` if there is none.
    pub fn line_at(&self, side: Side, ping: usize) -> Option<&BottomEdit> {
        self.lines.iter().find(|line| line.covers(side, ping))
    }

    /// Returns the number of pings with a manual pick, each side counted.
    pub fn ping_count(&self) -> usize {
        self.count(false)
    }

    fn count(&self, accepted: bool) -> usize {
        let lines = self.lines.iter().filter(|line| line.accepted == accepted);
        lines.map(|line| line.span().count()).sum()
    }

    /// Returns sentences for the report of the log about its manual picks and accepted first
    /// returns; empty where there are none, or they belong to another log.
    pub fn statement(&self, survey: &Survey) -> String {
        // Edits of another log are not even counted: they may claim any number of pings.
        if self.is_empty() || self.belongs_to(survey).is_err() {
            return String::new();
        }
        let drawn = match self.ping_count() {
            0 => String::new(),
            count => format!("{count} first returns are manual picks."),
        };
        let accepted = match self.accepted_count() {
            0 => String::new(),
            count => format!(
                "At {count} pings first returns above the recorded depth are accepted as bottom."
            ),
        };
        let gap = if drawn.is_empty() || accepted.is_empty() { "" } else { " " };
        drawn + gap + &accepted
    }

    /// Checks that the edits are possible.
    ///
    /// # Errors
    /// When there are too many edits, pings are out of order or beyond the log, or corners are not
    /// valid: a sentence about the first such edit.
    pub fn check(&self) -> Result<(), &'static str> {
        if self.lines.len() > MOST_LINES {
            return Err("bottom.lines may hold 100000 stretches at most");
        }
        for line in &self.lines {
            let [first, last] = line.pings;
            if first > last || last >= self.pings {
                return Err(
                    "pings of bottom.lines must be the first and the last ping, below bottom.pings",
                );
            }
            if line.accepted && !line.corners.is_empty() {
                return Err("an accepted stretch of bottom.lines has no corners");
            }
            let rises = line.corners.windows(2).all(|pair| pair[0][0] < pair[1][0]);
            let is_place = |[ping, range_m]: &[f64; 2]| {
                ping.is_finite() && range_m.is_finite() && *range_m >= 0.0
            };
            if !rises || !line.corners.iter().all(is_place) {
                return Err(
                    "corners of bottom.lines must be pings that rise, each with a slant range in metres",
                );
            }
        }
        Ok(())
    }

    /// Applies the edits to the first returns that were found. A manual pick has confidence 1, and
    /// neither a manual pick nor an accepted first return counts as above the bottom. Edits of
    /// another log are not applied, with a warning.
    pub fn apply(&self, survey: &Survey, returns: &mut FirstReturns) {
        if self.is_empty() {
            return;
        }
        if let Err(why) = self.belongs_to(survey) {
            let text = format!("the bottom edits are left out: {why}");
            return returns.warnings.push(text);
        }
        let own = self.clone().with_sides(survey.swapped_sides);
        for line in &own.lines {
            if line.accepted {
                let picks = returns.side_mut(line.side);
                let end = (line.pings[1] + 1).min(picks.len());
                let stretch = picks.get_mut(line.pings[0]..end).unwrap_or_default();
                stretch.iter_mut().for_each(Pick::accept);
                continue;
            }
            returns.drawn.push((line.side, line.pings));
            let picks = returns.side_mut(line.side);
            for ping in line.span() {
                if let (Some(pick), Some(span)) =
                    (picks.get_mut(ping), survey.span(ping, line.side))
                {
                    let sample = line.range_m(ping).map(|range_m| span.sample_at(range_m));
                    // A damaged header may state a range without extent.
                    let sample = sample.filter(|sample| sample.is_finite());
                    *pick = sample.map_or(Pick::NONE, |sample| Pick {
                        sample: sample.clamp(0.0, f64::from(span.count)) as f32,
                        confidence: 1.0,
                        above_bottom: false,
                    });
                }
            }
        }
    }

    /// Returns the settings with the first returns of these pings accepted as bottom where they
    /// were found; manual picks in these pings stay.
    pub fn accepting(&self, side: Side, pings: [usize; 2]) -> Self {
        let drawn = self.lines.iter().filter(|line| !line.accepted && line.side == side);
        let whole = BottomEdit { side, pings, corners: Vec::new(), accepted: true };
        let whole = Self { lines: vec![whole], ..*self };
        let rest = drawn.fold(whole, |rest, line| rest.without(side, line.pings));
        rest.lines.into_iter().fold(self.clone(), |all, part| all.with(part))
    }

    /// Returns the settings with no first return of these pings accepted; manual picks in these
    /// pings stay.
    pub fn not_accepting(&self, side: Side, pings: [usize; 2]) -> Self {
        let rest = self.without(side, pings).lines.into_iter().filter(|line| line.accepted);
        rest.fold(self.drawn_only(), |all, part| all.with(part))
    }

    /// Returns the settings with the manual picks alone: no first return is accepted.
    pub fn drawn_only(&self) -> Self {
        let lines = self.lines.iter().filter(|line| !line.accepted);
        Self { lines: lines.cloned().collect(), ..*self }
    }

    /// Returns true if first returns of any stretch were accepted as bottom.
    pub fn has_accepted(&self) -> bool {
        self.lines.iter().any(|line| line.accepted)
    }

    /// Returns the number of pings whose first returns were accepted as bottom, each side counted.
    pub fn accepted_count(&self) -> usize {
        self.count(true)
    }
}

/// Returns corners whose line stays within a tolerance of all given corners, by the algorithm of D.
/// Douglas and T. Peucker (1973), measured along the range.
fn simplified(corners: &[[f64; 2]], tolerance_m: f64) -> Vec<[f64; 2]> {
    let Some(last) = corners.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut kept = vec![false; corners.len()];
    (kept[0], kept[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        let ([a, a_m], [b, b_m]) = (corners[from], corners[to]);
        let off_m = |index: usize| {
            let [at, at_m] = corners[index];
            (at_m - a_m - (b_m - a_m) * (at - a) / (b - a)).abs()
        };
        let farthest = (from + 1..to).max_by(|&one, &other| off_m(one).total_cmp(&off_m(other)));
        if let Some(index) = farthest.filter(|&index| off_m(index) > tolerance_m) {
            kept[index] = true;
            open.extend([(from, index), (index, to)]);
        }
    }
    let kept = corners.iter().zip(kept).filter(|(_, kept)| *kept);
    kept.map(|(corner, _)| *corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::{SidePing, SideSpan};
    use std::sync::Arc;

    fn line(side: Side, pings: [usize; 2], range_m: f64) -> BottomEdit {
        BottomEdit {
            side,
            pings,
            corners: vec![[pings[0] as f64, range_m], [pings[1] as f64 + 1.0, range_m]],
            accepted: false,
        }
    }

    #[test]
    fn a_path_of_the_pen_gives_each_ping_its_range_and_few_corners() {
        // A straight path of 40 pings in 9 steps, then back over the last ten at 9 m.
        let mut path: Vec<[f64; 2]> = (0..10)
            .map(|step| [10.5 + f64::from(step) * 40.0 / 9.0, 4.0 + f64::from(step) * 0.4])
            .collect();
        path.extend([[50.5, 9.0], [40.5, 9.0]]);
        let drawn = BottomEdit::along(&path, Side::Port, 100, 0.01).expect("a line");
        assert_eq!(drawn.pings, [10, 50]);
        for ping in 10..40 {
            let expected_m = 4.0 + 3.6 * (ping - 10) as f64 / 40.0;
            let found_m = drawn.range_m(ping).expect("a range");
            assert!((found_m - expected_m).abs() < 0.011, "{ping}: {found_m}");
        }
        assert!((40..=50).all(|ping| drawn.range_m(ping) == Some(9.0)));
        assert!(drawn.corners.len() <= 5, "{:?}", drawn.corners);
    }

    #[test]
    fn paths_beyond_the_log_are_cut_and_those_outside_it_are_none() {
        let along = |path: &[[f64; 2]]| BottomEdit::along(path, Side::Port, 20, 0.0);
        let cut = along(&[[-5.0, 3.0], [25.0, -1.0]]).expect("a line");
        assert_eq!(cut.pings, [0, 19]);
        assert!((0..20).all(|ping| cut.range_m(ping).is_some_and(|range_m| range_m >= 0.0)));
        assert_eq!(along(&[[4.2, 3.0]]).map(|line| line.pings), Some([4, 4]));
        assert_eq!(along(&[[-9.0, 3.0], [-2.0, 3.0]]), None);
        assert_eq!(along(&[[30.0, 3.0]]), None);
        assert_eq!(along(&[]), None);
        assert_eq!(BottomEdit::along(&[[1.0, 1.0]], Side::Port, 0, 0.0), None);
    }

    #[test]
    fn the_last_line_counts_and_what_it_does_not_cover_stays() {
        let log = BottomSettings { pings: 99, ..BottomSettings::default() };
        let all = log
            .with(line(Side::Port, [10, 30], 3.0))
            .with(line(Side::Starboard, [0, 98], 5.0))
            .with(line(Side::Port, [20, 25], 4.0));
        assert_eq!(all.check(), Ok(()));
        let range_m = |side, ping| all.line_at(side, ping).and_then(|line| line.range_m(ping));
        for (ping, expected) in [
            (9, None),
            (10, Some(3.0)),
            (19, Some(3.0)),
            (20, Some(4.0)),
            (25, Some(4.0)),
            (26, Some(3.0)),
            (30, Some(3.0)),
            (31, None),
        ] {
            assert_eq!(range_m(Side::Port, ping), expected, "{ping}");
        }
        assert_eq!(range_m(Side::Starboard, 22), Some(5.0));
        assert_eq!(all.ping_count(), 21 + 99);
        let less = all.without(Side::Starboard, [0, 97]).without(Side::Port, [0, 98]);
        assert_eq!(less.ping_count(), 1);
        assert!(less.without(Side::Starboard, [98, 98]).is_empty());
    }

    #[test]
    fn damaged_ranges_and_edits_of_another_log_do_no_harm() {
        let span = |near_m: f32, far_m: f32| SideSpan::of_bytes(100, [near_m, far_m]);
        let pings = [(0.0, 10.0), (2.0, 2.0), (f32::NAN, 5.0), (9.0, 1.0)];
        let survey = Survey {
            side_scan: Arc::new(
                pings
                    .map(|(near_m, far_m)| SidePing {
                        port: Some(span(near_m, far_m)),
                        ..SidePing::with_depth(0.0, f32::NAN)
                    })
                    .to_vec(),
            ),
            ..Survey::default()
        };
        let drawn = BottomSettings::of(&survey).with(line(Side::Port, [0, 3], 2.0));
        let mut returns = FirstReturns {
            port: vec![Pick::NONE; 4].into(),
            starboard: vec![Pick::NONE; 4].into(),
            ..FirstReturns::default()
        };
        drawn.apply(&survey, &mut returns);
        assert_eq!(returns.port[0].sample, 20.0);
        assert!((0..4).all(|ping| returns.is_drawn(Side::Port, ping)));
        assert!(!returns.is_drawn(Side::Port, 4) && !returns.is_drawn(Side::Starboard, 0));
        assert!(returns.port.iter().all(|pick| pick.is_some() || pick.confidence == 0.0));
        assert!(!returns.port[1].is_some() && !returns.port[2].is_some());

        let of_another_log = BottomSettings {
            log_bytes: 1,
            pings: usize::MAX,
            swapped_sides: false,
            lines: vec![line(Side::Port, [0, usize::MAX - 2], 2.0); 3],
        };
        assert_eq!(of_another_log.statement(&survey), "");
        of_another_log.apply(&survey, &mut returns);
        assert_eq!(returns.warnings.len(), 1);
    }

    #[test]
    fn settings_that_no_hand_can_have_drawn_are_refused() {
        let with = |lines: &str| {
            let text = format!("log_bytes = 9\npings = 50\n{lines}");
            toml::from_str::<BottomSettings>(&text).expect("settings").check()
        };
        assert_eq!(
            with("[[lines]]\nside = 'port'\npings = [3, 9]\ncorners = [[3, 2], [9, 2.5]]"),
            Ok(())
        );
        assert_eq!(with("[[lines]]\nside = 'starboard'\npings = [3, 3]"), Ok(()));
        for wrong in [
            "pings = [9, 3]",
            "pings = [3, 50]",
            "pings = [3, 9]\ncorners = [[3, nan]]",
            "pings = [3, 9]\ncorners = [[3, -1]]",
            "pings = [3, 9]\ncorners = [[9, 1], [3, 1]]",
        ] {
            assert!(with(&format!("[[lines]]\nside = 'port'\n{wrong}")).is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_accepted_stretch_is_bottom_where_it_was_found_and_leaves_what_was_drawn() {
        let recorded = SidePing {
            port: Some(SideSpan::of_bytes(100, [0.0, 10.0])),
            ..SidePing::with_depth(0.0, 3.0)
        };
        let survey = Survey::of_pings(vec![recorded; 40]);
        let flagged = Pick { sample: 24.0, confidence: 0.02, above_bottom: true };
        let drawn = BottomSettings::of(&survey).with(BottomEdit {
            side: Side::Port,
            pings: [10, 12],
            corners: vec![[10.0, 2.0], [13.0, 2.0]],
            accepted: false,
        });
        let all = drawn.accepting(Side::Port, [5, 20]);
        assert_eq!(all.check(), Ok(()));
        assert_eq!((all.ping_count(), all.accepted_count()), (3, 13));
        assert_eq!(all.drawn_only(), drawn);
        let mut returns = FirstReturns {
            port: vec![flagged; 40].into(),
            starboard: vec![Pick::NONE; 40].into(),
            ..FirstReturns::default()
        };
        all.apply(&survey, &mut returns);
        for (ping, pick) in returns.port.iter().enumerate() {
            assert_eq!(pick.above_bottom, !(5..=20).contains(&ping), "{ping}");
        }
        assert_eq!(returns.port[7].sample, flagged.sample, "it stays in its place");
        assert!(returns.port[7].confidence > 0.6, "{:?}", returns.port[7]);
        assert_eq!(returns.port[11].sample, 20.0, "what was drawn stays");
        assert!(!returns.is_drawn(Side::Port, 7) && returns.is_drawn(Side::Port, 11));
        // The edits can be removed again, and written and read.
        assert_eq!(all.without(Side::Port, [0, 39]).lines, []);
        let text = toml::to_string(&all).expect("text");
        assert_eq!(toml::from_str::<BottomSettings>(&text), Ok(all));
    }
}
