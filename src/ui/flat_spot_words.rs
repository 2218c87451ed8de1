//! The texts of flat stretches, the same in all views and panels.

use bathyscope_bottom::calibration::FlatSpot;
use bathyscope_bottom::presentation::text;
use bathyscope_bottom::presentation::units::Units;

/// `10 m, relief 4 cm, ±1.2 %`.
pub(super) fn brief(spot: &FlatSpot, units: Units) -> String {
    let length = units.measure(spot.length_m, 0);
    let relief = relief(spot, units);
    match spread(spot) {
        Some(spread) => format!("{length}, relief {relief}, {spread}"),
        None => format!("{length}, relief {relief}, no scale"),
    }
}

/// `±1.2 %`, of the scale of single pings.
pub(super) fn spread(spot: &FlatSpot) -> Option<String> {
    Some(format!("±{:.1} %", 100.0 * spot.spread()?))
}

/// `×0.949`, of the recorded range.
pub(super) fn factor(spot: &FlatSpot) -> Option<String> {
    Some(format!("×{:.3}", spot.factor?))
}

/// `4 cm`.
pub(super) fn relief(spot: &FlatSpot, units: Units) -> String {
    let written = units.small_difference(spot.relief_m);
    if spot.relief_m.is_finite() {
        written.trim_start_matches('+').to_owned()
    } else {
        text::NONE.to_owned()
    }
}
