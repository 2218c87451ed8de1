//! Turns bottom edits, made by strokes of the pen and steps of the keys, into settings that can be
//! undone.

use super::untitled::ReadBottom;
use super::{Action, App, LogPlace, OpenLog};
use bathyscope_bottom::first_return::{BottomEdit, BottomSettings};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::Error;
use std::sync::Arc;

/// Effect of a stroke of the pen on its pings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// The bottom is where it was drawn.
    Bottom,
    /// No bottom is detected.
    Silence,
    /// Edits are removed: the first returns that the search found count again.
    Search,
}

/// A stroke of the pen over the waterfall.
#[derive(Clone, Debug, PartialEq)]
pub struct BottomStroke {
    /// The side on which the stroke began.
    pub side: Side,
    /// Points of the stroke: fractional ping, and slant range in metres by the recorder's scale.
    pub path: Vec<[f64; 2]>,
    /// Effect of the stroke on its pings.
    pub ink: Ink,
}

impl OpenLog {
    /// Returns the bottom edits of the open log; none where the settings hold those of another log.
    fn bottom_of(&self, survey: &Survey) -> BottomSettings {
        let bottom = &self.settings.bottom;
        match bottom.belongs_to(survey) {
            Ok(()) => bottom.clone(),
            Err(_) => BottomSettings::of(survey),
        }
    }

    /// Returns the present slant range of the bottom, metres: the drawn one, else the found one,
    /// else the recorded depth; `None` where none of them is known.
    fn bottom_at(&self, survey: &Survey, mark: LogPlace, side: Side) -> Option<f64> {
        let line = self.settings.bottom.line_at(side, mark.ping);
        let drawn_m = line.and_then(|line| line.range_m(mark.ping));
        let span = survey.span(mark.ping, side)?;
        let pick = self.bottom_line().and_then(|all| all.side(side).get(mark.ping));
        let found_m =
            pick.filter(|pick| pick.is_some()).map(|pick| span.range_m(f64::from(pick.sample)));
        let recorded_m = Some(f64::from(survey.good_depth_m(mark.ping)));
        drawn_m.or(found_m).or(recorded_m.filter(|depth_m| depth_m.is_finite()))
    }

    /// Takes bottom edits from the sidecar file of the log, which an earlier version wrote; returns
    /// the text of a notice about them.
    pub(super) fn take_bottom(&mut self, read: ReadBottom) -> Result<String, Error> {
        let swapped = self.survey.as_ref().is_some_and(|survey| survey.swapped_sides);
        let kept = read?.with_sides(swapped);
        let pings = kept.ping_count() + kept.accepted_count();
        Arc::make_mut(&mut self.own).bottom = kept.clone();
        Arc::make_mut(&mut self.settings).bottom = kept;
        Ok(format!(
            "The bottom edits of {pings} pings were taken from {} next to the log",
            quoted(&format!("{}.{}", self.name, BottomSettings::SIDECAR))
        ))
    }
}

impl App {
    /// Edits the bottom along a stroke; on both sides at the same ranges if that option is on.
    pub(super) fn draw_bottom(&mut self, stroke: &BottomStroke) {
        let Some(survey) = &self.logs.shown.survey else {
            return;
        };
        let count = survey.side_scan.len();
        let mut bottom = self.logs.shown.bottom_of(survey);
        for side in self.view.options.waterfall.sides_of(stroke.side) {
            let tolerance_m = half_a_sample_m(survey, side, &stroke.path);
            let Some(line) = BottomEdit::along(&stroke.path, side, count, tolerance_m) else {
                return;
            };
            bottom = match stroke.ink {
                Ink::Bottom => bottom.with(line),
                Ink::Silence => bottom.with(BottomEdit { corners: Vec::new(), ..line }),
                Ink::Search => bottom.without(side, line.pings),
            };
        }
        self.edit_settings("bottom", |settings| settings.bottom = bottom);
    }

    /// Accepts the first returns of some pings as bottom where they were found, or undoes the
    /// acceptance, as an undo step; on both sides if that option is on.
    pub(super) fn accept_bottom(&mut self, side: Side, pings: [usize; 2], accept: bool) {
        let Some(survey) = &self.logs.shown.survey else {
            return;
        };
        let last = survey.side_scan.len().saturating_sub(1);
        let pings = pings.map(|ping| ping.min(last));
        let [first, last] = pings;
        let mut bottom = self.logs.shown.bottom_of(survey);
        for side in self.view.options.waterfall.sides_of(side) {
            bottom = if accept {
                bottom.accepting(side, pings)
            } else {
                bottom.not_accepting(side, pings)
            };
        }
        if bottom == self.logs.shown.settings.bottom {
            return;
        }
        self.edit_settings("bottom", |settings| settings.bottom = bottom);
        let what = if accept { "Accepted as bottom" } else { "No longer accepted as bottom" };
        let sides = if self.view.options.waterfall.bottom_both_sides {
            "both sides".to_owned()
        } else {
            side.name().to_owned()
        };
        self.notices.withdraw(Action::Undo);
        self.notices.offer(format!("{what}: pings {first} to {last}, {sides}"), Action::Undo);
    }

    /// Moves the bottom at the selected ping outward by samples, beginning at the recorded depth
    /// where no bottom is detected.
    pub(super) fn nudge_bottom(&mut self, samples: i32) {
        let (Some(survey), Some(mark)) = (self.logs.shown.survey.clone(), self.view.selection)
        else {
            return self.notices.warn("select a ping first, with the arrow keys or a click");
        };
        let mut bottom = self.logs.shown.bottom_of(&survey);
        for side in self.view.options.waterfall.sides_of(mark.side.unwrap_or(Side::Starboard)) {
            let Some(span) = survey.span(mark.ping, side) else {
                continue;
            };
            let from_m = self.logs.shown.bottom_at(&survey, mark, side);
            let range_m = from_m.unwrap_or_else(|| span.range_m(0.0))
                + f64::from(samples) * span.metres_per_sample();
            // `clamp` would panic on the limits that a damaged header may contain.
            let range_m = range_m.max(f64::from(span.near_m)).min(f64::from(span.far_m));
            let line = BottomEdit {
                side,
                pings: [mark.ping, mark.ping],
                corners: vec![[mark.ping as f64, range_m]],
                accepted: false,
            };
            bottom = bottom.with(line);
        }
        self.edit_settings("bottom", |settings| settings.bottom = bottom);
    }
}

/// Returns half of the slant range of a sample where a stroke begins, metres: finer corners have no
/// meaning.
fn half_a_sample_m(survey: &Survey, side: Side, path: &[[f64; 2]]) -> f64 {
    let ping = path.first().map_or(0, |[ping, _]| ping.max(0.0) as usize);
    let span = survey.span(ping, side);
    0.5 * span.map_or(0.02, |span| span.metres_per_sample())
}
