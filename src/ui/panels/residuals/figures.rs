//! The statistics of differences, in rows.

use crate::ui::panels::cloud;
use crate::ui::panels::parts::fact;
use crate::ui::text;
use bathyscope_bottom::bathymetry::compare::Comparison;
use bathyscope_bottom::cloud::Residuals;
use bathyscope_bottom::presentation::units::Units;
use egui::Ui;

/// Draws them; `same_ping` are those against the sounding of each point's own ping, where that is
/// the reference.
pub(super) fn ui(
    ui: &mut Ui,
    comparison: &Comparison,
    same_ping: Option<&Residuals>,
    units: Units,
) {
    if let Some(residuals) = same_ping {
        let value = cloud::same_ping(residuals, units);
        fact(ui, cloud::SAME_PING, cloud::SAME_PING_HINT, value);
    }
    let matched = comparison.measured - comparison.unmatched;
    let hint = "Points that have a reference, of all that could have one.";
    let [matched, measured] = [matched, comparison.measured].map(text::count);
    fact(ui, "Compared", hint, format!("{matched} of {measured}"));
    if let Some(found) = &comparison.residuals {
        let pairs = [
            (
                "Mean, median",
                "Of the differences at the same place: above 0 is shallower than the reference.",
                [found.mean_m, found.median_m].map(|value_m| units.signed_difference(value_m)),
            ),
            (
                "SD, RMS",
                "Standard deviation about the mean, and root mean square about 0.",
                [found.sd_m, found.rms_m].map(|value_m| units.difference(value_m)),
            ),
            (
                "MAE, 95 %",
                "Mean absolute difference, and 95th percentile of the absolute difference.",
                [found.mae_m, found.p95_m].map(|value_m| units.difference(value_m)),
            ),
        ];
        for (name, hint, [first, second]) in pairs {
            fact(ui, name, hint, format!("{first}, {second}"));
        }
    }
}

/// Draws the shares within the orders of IHO S-44.
pub(super) fn orders(ui: &mut Ui, comparison: &Comparison) {
    for within in &comparison.orders {
        let name = format!("S-44 {}", within.order.order);
        let verdict = if within.share >= 0.95 { "" } else { ", 95 % required" };
        let share = format!("{:.1} % within{verdict}", 100.0 * within.share);
        let hint = "Share of the points within what this order of IHO S-44 allows at their depth.";
        fact(ui, &name, hint, share);
    }
}
