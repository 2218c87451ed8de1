//! Records the figures of a change: for scripts, for a terminal, and on an HTML page with a
//! picture.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bathyscope_bottom::bathymetry::change::{ChangeErrors, ChangeSum, ChangeTotals};
use bathyscope_bottom::presentation::colours::{difference_colour, difference_reach_m};
use bathyscope_bottom::presentation::page::{Template, TemplateFault, Value, context, fill};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
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

/// Longest side of the picture, pixels.
const MOST_PIXELS: usize = 900;
/// Approximate side of a picture with fewer cells, which is shown with larger squares, pixels.
const SHOWN_PIXELS: u32 = 640;

const TEMPLATE: Template<'static> = ("change.html", include_str!("templates/change.html"));

/// Picture for the page: the change of each pixel, metres, row by row.
pub(super) struct ChangeImage {
    rise_m: Vec<f32>,
    size: [usize; 2],
}

/// Makes a picture of the changes of the cells; joins cells where there are more than
/// [`MOST_PIXELS`].
pub(super) fn picture(rise_m: &[f32], [columns, rows]: [usize; 2]) -> Box<ChangeImage> {
    let joined = columns.max(rows).div_ceil(MOST_PIXELS).max(1);
    let size = [columns.div_ceil(joined), rows.div_ceil(joined)];
    let mean = |pixel: usize| {
        let (left, top) = (pixel % size[0] * joined, pixel / size[0] * joined);
        let cells = (top..(top + joined).min(rows)).flat_map(|row| {
            (left..(left + joined).min(columns)).map(move |column| row * columns + column)
        });
        let known = cells.map(|cell| rise_m[cell]).filter(|rise| !rise.is_nan());
        let (sum, count) =
            known.fold((0.0, 0.0), |(sum, count), rise| (sum + rise, count + 1.0_f32));
        // The mean of no cells is NaN.
        sum / count
    };
    Box::new(ChangeImage { rise_m: (0..size[0] * size[1]).map(mean).collect(), size })
}

/// Returns the page as HTML.
pub(super) fn page(
    record: &ChangeRecord,
    shown: Option<&ChangeImage>,
) -> Result<String, TemplateFault> {
    let reach_m = difference_reach_m(record.reach_m);
    let values = context! {
        newer => &record.newer,
        older => &record.older,
        rows => record.rows(),
        figure => shown.and_then(|shown| figure(shown, reach_m)),
    };
    fill(&[TEMPLATE], values)
}

/// Returns the picture with its colours; `None` where it cannot be encoded.
fn figure(shown: &ChangeImage, reach_m: f64) -> Option<Value> {
    let share = |rise_m: f32| (0.5 + 0.5 * f64::from(rise_m) / reach_m) as f32;
    let pixels = shown.rise_m.iter().flat_map(|&rise_m| {
        if rise_m.is_nan() {
            [0; 4]
        } else {
            let [red, green, blue] = difference_colour(share(rise_m));
            [red, green, blue, 255]
        }
    });
    let pixels: Vec<u8> = pixels.collect();
    let [width, height] = shown.size.map(|count| count as u32);
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(&pixels, width, height, ExtendedColorType::Rgba8).ok()?;
    let times = (SHOWN_PIXELS / width.max(height).max(1)).max(1);
    let colours = (0..=8).map(|step| {
        let [red, green, blue] = difference_colour(step as f32 / 8.0);
        format!("#{red:02x}{green:02x}{blue:02x}")
    });
    Some(context! {
        colours => colours.collect::<Vec<String>>().join(","),
        least_m => format!("{:+}", -reach_m),
        most_m => format!("{reach_m:+}"),
        width => width * times,
        height => height * times,
        png => STANDARD.encode(png),
    })
}
