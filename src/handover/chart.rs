//! The water below each level: two curves over the depth, and their table.

use super::Handover;
use crate::bathymetry::isobaths::{Storage, storage};
use crate::presentation::text::typeset_count as count;
use crate::presentation::ticks::ticks;
use std::fmt::Write as _;

/// Levels that the curves go through.
const STEPS: usize = 60;
/// Area of the curves, pixels, and room around it.
const SIZE: [f64; 2] = [380.0, 240.0];
const LEFT: f64 = 60.0;
const BELOW: f64 = 40.0;
const GAP: f64 = 90.0;
const RIGHT: f64 = 36.0;

/// Curves and table; empty without a depth map.
pub fn storage_section(from: &Handover<'_>) -> String {
    let Some(surface) = from.surface else {
        return String::new();
    };
    let [least_m, most_m] = surface.range_m();
    let grid = &surface.grid;
    let middle = grid.centre(grid.rows / 2, grid.columns / 2);
    // A map's square metres are not quite those of the ground.
    let ground = from.map.area_scale_at(middle).recip();
    let below = |levels: &[f64]| -> Vec<Storage> {
        let mut rows = storage(surface, levels);
        for row in &mut rows {
            row.area_m2 *= ground;
            row.volume_m3 *= ground;
        }
        rows
    };
    let mut html = String::from("<h2>Area and volume below each level</h2>\n<figure>");
    let even: Vec<f64> = (0..=STEPS)
        .map(|step| least_m + step as f64 / STEPS as f64 * (most_m - least_m))
        .collect();
    html += &curves(&below(&even));
    html += "</figure>\n<table><tr><th>below depth, m</th><th>area, m\u{b2}</th><th>volume, m\u{b3}</th></tr>\n";
    // The levels of the isobaths, as in `storage.csv`; too many were refused with a warning.
    let isobaths = &from.products.settings.isobaths;
    let levels = isobaths.levels_m([least_m, most_m]).unwrap_or_default();
    for row in below(&levels) {
        // Writing to a string cannot fail.
        writeln!(
            html,
            "<tr><td>{:.2}</td><td>{}</td><td>{}</td></tr>",
            row.depth_m,
            count(row.area_m2.round() as usize),
            count(row.volume_m3.round() as usize)
        )
        .ok();
    }
    html + "</table>\n<p>What was not mapped does not count: a basin holds more than this where the survey leaves parts of it out.</p>\n"
}

fn curves(rows: &[Storage]) -> String {
    let width = LEFT + 2.0 * SIZE[0] + GAP + RIGHT;
    let height = SIZE[1] + BELOW + 8.0;
    let mut drawn = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"Area and volume below each level\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" font-family=\"sans-serif\" font-size=\"11\">\n"
    );
    let area = |row: &Storage| row.area_m2;
    let volume = |row: &Storage| row.volume_m3;
    // Writing to a string cannot fail.
    curve(&mut drawn, rows, LEFT, "area, m\u{b2}", area).ok();
    let second = LEFT + SIZE[0] + GAP;
    curve(&mut drawn, rows, second, "volume, m\u{b3}", volume).ok();
    drawn + "</svg>"
}

/// One curve: the amount across, the depth down.
fn curve(
    drawn: &mut String,
    rows: &[Storage],
    left: f64,
    name: &str,
    of: fn(&Storage) -> f64,
) -> std::fmt::Result {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return Ok(());
    };
    let most = of(first).max(f64::MIN_POSITIVE);
    let extent_m = (last.depth_m - first.depth_m).max(f64::MIN_POSITIVE);
    let x = |row: &Storage| left + of(row) / most * SIZE[0];
    let y = |depth_m: f64| 8.0 + (depth_m - first.depth_m) / extent_m * SIZE[1];
    for (amount, _) in ticks(0.0, most) {
        let at = left + amount / most * SIZE[0];
        writeln!(
            drawn,
            "<path d=\"M{at:.1} 8V{:.1}\" stroke=\"#dddddd\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            8.0 + SIZE[1],
            8.0 + SIZE[1] + 15.0,
            count(amount.round() as usize),
        )?;
    }
    for (depth_m, label) in ticks(first.depth_m, last.depth_m) {
        let at = y(depth_m);
        writeln!(
            drawn,
            "<path d=\"M{left:.1} {at:.1}H{:.1}\" stroke=\"#dddddd\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            left + SIZE[0],
            left - 5.0,
            at + 4.0,
        )?;
    }
    let mut path = String::new();
    for (index, row) in rows.iter().enumerate() {
        let letter = if index == 0 { 'M' } else { 'L' };
        write!(path, "{letter}{:.1} {:.1}", x(row), y(row.depth_m))?;
    }
    writeln!(
        drawn,
        "<path d=\"{path}\" stroke=\"#0b5394\" stroke-width=\"2\" fill=\"none\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{name} deeper than</text><text transform=\"translate({:.1} {:.1}) rotate(-90)\" text-anchor=\"middle\">depth, m</text>",
        left + 0.5 * SIZE[0],
        8.0 + SIZE[1] + 32.0,
        left - 42.0,
        8.0 + 0.5 * SIZE[1],
    )
}
