//! The orders of survey of IHO S-44.

use serde::Serialize;

/// An order of survey, by the vertical uncertainty that it allows at 95 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SurveyOrder {
    /// `exclusive`, `special`, `1a/1b`, `2`.
    pub order: &'static str,
    /// The part that does not depend on the depth, metres.
    pub a_m: f64,
    /// The share of the depth.
    pub b: f64,
}

/// The orders of IHO Standards for Hydrographic Surveys, S-44, edition 6, table 1; the strictest
/// first.
pub(crate) const ORDERS: [SurveyOrder; 4] = [
    order("exclusive", 0.15, 0.0075),
    order("special", 0.25, 0.0075),
    order("1a/1b", 0.5, 0.013),
    order("2", 1.0, 0.023),
];

const fn order(order: &'static str, a_m: f64, b: f64) -> SurveyOrder {
    SurveyOrder { order, a_m, b }
}

impl SurveyOrder {
    /// Total vertical uncertainty allowed at a depth, `sqrt(a^2 + (b d)^2)`, metres.
    pub(crate) fn limit_m(self, depth_m: f64) -> f64 {
        self.a_m.hypot(self.b * depth_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_printed_table() {
        let depths_m = [1.0, 2.3, 5.0, 10.0, 20.0, 40.0, 100.0];
        let printed = [
            [0.1502, 0.1510, 0.1546, 0.1677, 0.2121, 0.3354, 0.7649],
            [0.2501, 0.2506, 0.2528, 0.2610, 0.2915, 0.3905, 0.7906],
            [0.5002, 0.5009, 0.5042, 0.5166, 0.5636, 0.7214, 1.3928],
            [1.0003, 1.0014, 1.0066, 1.0261, 1.1007, 1.3588, 2.5080],
        ];
        for (order, row) in ORDERS.into_iter().zip(printed) {
            for (depth_m, limit_m) in depths_m.into_iter().zip(row) {
                assert!((order.limit_m(depth_m) - limit_m).abs() < 5.1e-5, "{order:?} {depth_m}");
            }
        }
    }
}
