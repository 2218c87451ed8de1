//! Keeps the scale of a log while the log is followed: the scale in force stays until the analyst
//! chooses another one, and changes of depth are reported.

use super::Active;
use crate::app::{Action, App, LogId, OpenLog};
use bathyscope_bottom::calibration::{Calibration, PingRange, ScaleMode};
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::pipeline::{Products, Settings};
use std::sync::Arc;
use toml::Value;

/// Key of the setting of the stretch that the scale is measured on.
const STRETCH: &str = "calibration.pings";
/// Least change of a depth by a scale that counts as a change, metres.
const SAME_M: f64 = 0.01;

impl App {
    /// Keeps the stretch that the scale of a followed log is measured on, because the best-ranked
    /// stretch of a longer log is often another one.
    pub(super) fn hold_scale(&mut self, active: &mut Active) {
        let Some(log) = self.logs.get(active.log) else {
            return;
        };
        let calibration = &log.settings.calibration;
        if calibration.mode != ScaleMode::FlatSpot {
            active.stretch = None;
            return;
        }
        if calibration.pings.is_some() {
            active.stretch = calibration.pings;
            return;
        }
        // Undo may restore settings that name no stretch.
        let in_use = || {
            let products = log.products.as_ref()?;
            let is_current = products.settings.calibration == *calibration;
            let made = &products.calibration;
            let is_measured = is_current && made.mode == ScaleMode::FlatSpot;
            let spot = made.flat_spot.as_ref().filter(|_| is_measured)?;
            Some(spot.range())
        };
        if let Some(pings) = active.stretch.or_else(in_use) {
            active.stretch = Some(pings);
            if let Some(log) = self.logs.get_mut(active.log) {
                log.name_stretch(pings);
            }
            self.keep_project("flat stretch");
        }
    }

    /// Offers the best-ranked stretch of a log that has grown if its scale differs from the scale
    /// in force, and withdraws the offer for a shorter state of the log.
    pub(super) fn offer_flatter(&mut self, id: LogId) {
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let found = log.products.as_ref().and_then(flatter);
        let offered = found.as_ref().map(|(pings, _)| *pings);
        if log.calibrating.offered == offered {
            return;
        }
        log.calibrating.offered = offered;
        self.notices.withdraw(Action::UseFlatterStretch);
        if let Some((_, text)) = found {
            self.notices.offer(text, Action::UseFlatterStretch);
        }
    }
}

impl OpenLog {
    /// Writes the stretch that the scale is measured on into the log's own settings. Results that
    /// used this stretch as the best-ranked one stay.
    fn name_stretch(&mut self, pings: PingRange) {
        Arc::make_mut(&mut self.own).set(STRETCH, Value::String(pings.into()));
        let name = |settings: &mut Arc<Settings>| {
            Arc::make_mut(settings).calibration.pings = Some(pings);
        };
        name(&mut self.settings);
        let whole = self.whole.as_mut().map(|whole| &mut whole.products);
        for products in self.products.as_mut().into_iter().chain(whole) {
            if is_measured_on(products, pings) {
                name(&mut products.settings);
            }
        }
    }
}

/// Returns true if results depend on the scale of these pings.
fn is_measured_on(products: &Products, pings: PingRange) -> bool {
    let made = &products.calibration;
    let spot = made.flat_spot.as_ref();
    made.mode == ScaleMode::FlatSpot && spot.is_some_and(|spot| spot.range() == pings)
}

/// Returns the best-ranked stretch, and a sentence about its effect; `None` if it is the stretch in
/// force, or gives the same depths.
fn flatter(products: &Products) -> Option<(PingRange, String)> {
    let made = &products.calibration;
    let used = made.flat_spot.as_ref();
    let used = used.filter(|_| made.mode == ScaleMode::FlatSpot)?;
    let best = products.flat_spots.first()?;
    let (now, then) = used.factor.zip(best.factor)?;
    let change_m = used.depth_m * (then / now - 1.0);
    let is_other = best.pings != used.pings && change_m.abs() >= SAME_M;
    is_other.then(|| {
        let text = format!(
            "A flatter stretch was found, pings {} to {}: ranges ×{then:.3} instead of ×{now:.3}; depths change by about {:+.0} cm",
            best.pings.start,
            best.pings.end - 1,
            100.0 * change_m
        );
        (best.range(), text)
    })
}

/// Returns a sentence about the change of depths by the results of the whole log; `None` if its
/// scale and its offset have not changed.
pub(super) fn drift(survey: &Survey, before: &Calibration, after: &Calibration) -> Option<String> {
    let change_m = depth_change_m(survey, before, after)?;
    let ranges = |calibration: &Calibration| {
        let change = calibration.range_change();
        change.unwrap_or_else(|| "ranges as recorded".to_owned())
    };
    (change_m.abs() >= SAME_M).then(|| {
        format!(
            "With more of the log, {} instead of {}: depths change by about {:+.0} cm",
            ranges(after),
            ranges(before),
            100.0 * change_m
        )
    })
}

/// Returns the depth of a first return at the median depth by the calibration `after` minus that by
/// `before`, metres.
fn depth_change_m(survey: &Survey, before: &Calibration, after: &Calibration) -> Option<f64> {
    let depth_m = after.measured_offset.or(before.measured_offset)?.depth_m;
    let mut spans = Side::BOTH.into_iter().filter_map(|side| survey.span(0, side));
    let span = spans.next()?;
    let sample = span.sample_at(depth_m);
    let change_m = after.range_m(span, sample) - before.range_m(span, sample);
    change_m.is_finite().then_some(change_m)
}
