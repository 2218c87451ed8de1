//! Draws the area and volume of the water below each level: two curves over the depth, and their
//! table.

use super::ReportData;
use bathyscope_bottom::bathymetry::isobaths::{Storage, storage};
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::presentation::plot::{Axis, Plot, PlotCurve};
use bathyscope_bottom::presentation::text::typeset_count as count;

/// Number of steps of the levels that the curves go through.
const STEPS: usize = 60;
/// Width and height of each plot, pixels.
const PLOT_PX: [f64; 2] = [360.0, 240.0];

/// Returns the curves and the rows of the table; `None` without a depth map.
pub(super) fn values(from: &ReportData<'_>) -> Option<Value> {
    let surface = &from.depth_map?.surface;
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
    let even: Vec<f64> =
        (0..=STEPS).map(|step| least_m + step as f64 / STEPS as f64 * (most_m - least_m)).collect();
    let level = |row: Storage| {
        context! {
            depth_m => format!("{:.2}", row.depth_m),
            area_m2 => count(row.area_m2.round() as usize),
            volume_m3 => count(row.volume_m3.round() as usize),
        }
    };
    Some(context! {
        plots => curves(&below(&even)),
        // The same levels as in `storage.csv`.
        levels => below(&from.isobaths.levels_m).into_iter().map(level).collect::<Vec<Value>>(),
    })
}

/// Draws area and volume, each in a plot whose depth axis points down.
fn curves(rows: &[Storage]) -> Vec<Value> {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return Vec::new();
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
        Value::from_safe_string(plot.svg(PLOT_PX))
    };
    vec![plot("area, m\u{b2}", |row| row.area_m2), plot("volume, m\u{b3}", |row| row.volume_m3)]
}
