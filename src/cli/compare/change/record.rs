//! Records the figures of a change: for scripts, for a terminal, and for the page.

use bathyscope_bottom::bathymetry::change::{ChangeErrors, ChangeSum, ChangeTotals};
use serde::Serialize;
use std::path::Path;

const SIGN: &str = "newer minus older elevation, metres; positive where the bottom rose (fill)";

/// Figures of a change.
#[derive(Serialize)]
pub(super) struct ChangeRecord {
    /// Path of the newer map.
    pub newer: String,
    /// Path of the older map.
    pub older: String,
    sign: &'static str,
    /// Confidence of the level of detection and of the intervals.
    confidence: f64,
    /// Standard deviation of the errors that are the same everywhere, metres.
    pub systematic_m: f64,
    /// Distance from which on the errors of two depths are independent, metres.
    pub error_range_m: f64,
    /// Share of the errors stated by the maps that is in their difference, as observed in cells
    /// without a change: an error that both maps have alike between the same lines is not in the
    /// difference.
    pub error_share: f64,
    /// Median change, metres; `None` if unknown.
    pub median_m: Option<f64>,
    /// Median level of detection, metres; `None` if unknown.
    pub detection_level_m: Option<f64>,
    /// Sum over the places where a change is detected and the bottom rose.
    pub fill: Volume,
    /// Sum over the places where a change is detected and the bottom sank.
    pub cut: Volume,
    /// Sum of fill and cut.
    pub net: Volume,
    /// Sum over all cells that are known in both maps, with or without a detected change.
    pub all: Volume,
    /// Largest fill that may be hidden where no change is detected, cubic metres.
    pub hidden_fill_m3: f64,
    /// Largest cut that may be hidden where no change is detected, cubic metres.
    pub hidden_cut_m3: f64,
    /// Change at either end of the colour scale, metres.
    #[serde(skip)]
    pub reach_m: f64,
}

/// Area and volume of some cells.
#[derive(Clone, Copy, Serialize)]
pub(super) struct Volume {
    /// Number of connected places.
    places: usize,
    cells: usize,
    area_m2: f64,
    volume_m3: f64,
    /// Standard deviation of the volume by errors that vary from place to place.
    random_sigma_m3: f64,
    /// Standard deviation of the volume by errors that are the same everywhere.
    systematic_sigma_m3: f64,
    /// Standard deviation of the volume by the interpolation between measured places.
    between_sigma_m3: f64,
    /// Half the width of the interval that contains the volume with a probability of 95 %.
    within_95_m3: f64,
}

impl Volume {
    fn new(sum: &ChangeSum, errors: &ChangeErrors) -> Self {
        let [random_sigma_m3, systematic_sigma_m3, between_sigma_m3] = sum.sigma_m3(errors);
        Self {
            places: sum.places,
            cells: sum.cells,
            area_m2: sum.area_m2,
            volume_m3: sum.volume_m3,
            random_sigma_m3,
            systematic_sigma_m3,
            between_sigma_m3,
            within_95_m3: sum.within_95_m3(errors),
        }
    }

    /// Returns the volume as text: `12.3 m3 ± 1.2 m3 on 45 m2`.
    pub(super) fn in_words(&self) -> String {
        format!("{:+.2} m3 ± {:.2} m3 on {:.1} m2", self.volume_m3, self.within_95_m3, self.area_m2)
    }
}

impl ChangeRecord {
    /// Creates the record of two maps, the newer one first.
    pub(super) fn new(
        [newer, older]: [&Path; 2],
        totals: &ChangeTotals,
        errors: ChangeErrors,
        error_share: f64,
    ) -> Self {
        let volume = |sum| Volume::new(sum, &errors);
        let [hidden_fill_m3, hidden_cut_m3] = totals.hidden_m3(&errors);
        Self {
            newer: newer.display().to_string(),
            older: older.display().to_string(),
            sign: SIGN,
            confidence: 0.95,
            systematic_m: errors.systematic_m,
            error_range_m: errors.range_m,
            error_share,
            median_m: totals.median_rise_m(),
            detection_level_m: totals.median_level_m(),
            fill: volume(&totals.fill),
            cut: volume(&totals.cut),
            net: volume(&totals.net),
            all: volume(&totals.all),
            hidden_fill_m3,
            hidden_cut_m3,
            reach_m: totals.reach_m(),
        }
    }

    /// Returns the names and figures, one pair for each line.
    pub(super) fn rows(&self) -> Vec<(&'static str, String)> {
        let metres =
            |value: Option<f64>| value.map_or_else(String::new, |metres| format!("{metres:+.3} m"));
        let level = self.detection_level_m.unwrap_or_default();
        let detected = |volume: &Volume, hidden_m3: f64| match volume.places {
            0 => format!(
                "nothing above the detection level of {level:.3} m; up to {hidden_m3:.1} m3 could be hidden"
            ),
            places => format!(
                "{} in {places} {}; up to {hidden_m3:.1} m3 could be hidden elsewhere",
                volume.in_words(),
                if places == 1 { "place" } else { "places" },
            ),
        };
        let hidden_m3 = self.hidden_fill_m3.max(self.hidden_cut_m3);
        vec![
            ("fill", detected(&self.fill, self.hidden_fill_m3)),
            ("cut", detected(&self.cut, self.hidden_cut_m3)),
            ("net", detected(&self.net, hidden_m3)),
            ("all cells", self.all.in_words()),
            ("median", metres(self.median_m)),
            ("detection", format!("{level:.3} m in the median cell (95 %)")),
            (
                "errors",
                format!(
                    "{} m the same everywhere; {:.0} % of those that the maps state, as cells without a change show, independent beyond {:.1} m",
                    self.systematic_m,
                    100.0 * self.error_share,
                    self.error_range_m
                ),
            ),
        ]
    }

    /// Returns the rows as text for a terminal.
    pub(super) fn table(&self) -> String {
        let first =
            "newer minus older (up is positive); fill, cut and net of the places where a change is detected; ± is 95 %"
                .to_owned();
        let rows = self.rows().into_iter().map(|(name, text)| format!("{name:<9} {text}"));
        std::iter::once(first).chain(rows).collect::<Vec<String>>().join("\n")
    }
}
