//! Draws the area and volume of the water below each level: two curves over the depth, and their
//! table.

use super::ReportData;
use bathyscope_bottom::bathymetry::isobaths::{Storage, storage};
use bathyscope_bottom::presentation::plot::{Axis, Plot, PlotCurve};
use bathyscope_bottom::presentation::text::typeset_count as count;

/// Number of steps of the levels that the curves go through.
const STEPS: usize = 60;
/// Width and height of each plot, pixels.
const PLOT_PX: [f64; 2] = [360.0, 240.0];

/// Returns the section with the curves and the table; empty without a depth map.
pub(super) fn storage_section(from: &ReportData<'_>) -> String {
    let Some(surface) = from.depth_map.map(|depth_map| &depth_map.surface) else {
        return String::new();
    };
    let [least_m, most_m] = surface.range_m();
    let grid = &surface.grid;
    let middle = grid.centre(grid.rows / 2, grid.columns / 2);
    // A square metre of the map is not exactly a square metre on the ground.
    let ground = from.map.area_scale_at(middle).recip();
    let below = |levels: &[f64]| -> Vec<Storage> {
        let mut rows = storage(surface, levels, from.isobaths.clip.as_deref());
        for row in &mut rows {
            row.area_m2 *= ground;
            row.volume_m3 *= ground;
        }
        rows
    };
    let mut html = String::from("<h2>Area and volume below each level</h2>\n<figure>");
    let even: Vec<f64> =
        (0..=STEPS).map(|step| least_m + step as f64 / STEPS as f64 * (most_m - least_m)).collect();
    html += &curves(&below(&even));
    html += "</figure>\n<table><tr><th>below depth, m</th><th>area, m\u{b2}</th><th>volume, m\u{b3}</th></tr>\n";
    // The same levels as in `storage.csv`.
    for row in below(&from.isobaths.levels_m) {
        html += &format!(
            "<tr><td>{:.2}</td><td>{}</td><td>{}</td></tr>\n",
            row.depth_m,
            count(row.area_m2.round() as usize),
            count(row.volume_m3.round() as usize)
        );
    }
    html + "</table>\n<p>What was not mapped does not count: a basin holds more than this where the survey leaves parts of it out.</p>\n"
}

/// Draws area and volume, each in a plot whose depth axis points down.
fn curves(rows: &[Storage]) -> String {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return String::new();
    };
    let plot = |name: &str, amount: fn(&Storage) -> f64| {
        let mut across = Axis::new(&format!("{name} deeper than"), [0.0, amount(first)]);
        for (value, label) in &mut across.ticks {
            *label = count(value.round() as usize);
        }
        let plot = Plot {
            title: format!("{name} deeper than each level"),
            across,
            up: Axis::new("depth, m", [last.depth_m, first.depth_m]),
            curves: vec![PlotCurve {
                name: name.to_owned(),
                points: rows.iter().map(|row| [amount(row), row.depth_m]).collect(),
            }],
            mark: None,
            limit: None,
        };
        plot.svg(PLOT_PX)
    };
    plot("area, m\u{b2}", |row| row.area_m2) + &plot("volume, m\u{b3}", |row| row.volume_m3)
}
