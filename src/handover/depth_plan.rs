//! The map of depths: colours, isobaths with their depths, track and objects.

use super::frame::{Bounds, Frame};
use super::text::ticks;
use super::{Handover, raster};
use crate::bathymetry::Surface;
use crate::bathymetry::isobaths::{Isobath, isobaths};
use crate::progress::{Cancelled, Progress};
use crate::render::{depth_colour, depth_share};
use std::fmt::Write as _;

/// Longest side of the picture under the isobaths, pixels: what a screen shows of it, and little to send.
const MOST_CELLS: usize = 1200;
/// Isobaths shorter than this on the page get no depth written on them, pixels.
const LEAST_LABELLED_PX: f64 = 90.0;
/// Labels nearer than this to another are left out, pixels.
const APART_PX: f64 = 46.0;

/// The map; `None` where the depths span no surface.
pub fn depth_plan(from: &Handover<'_>, progress: &Progress) -> Result<Option<String>, Cancelled> {
    let Some(surface) = from.surface else {
        return Ok(None);
    };
    let Some(frame) = Frame::around(bounds(surface), from.zone) else {
        return Ok(None);
    };
    let range_m = range_m(surface);
    let settings = &from.products.settings.isobaths;
    // Too many levels were refused with a warning when the isobaths were written.
    let levels_m = settings
        .levels_m(range_m.map(f64::from))
        .unwrap_or_default();
    let lines = isobaths(surface, &levels_m, progress)?;
    let under = picture(surface, range_m, &frame);
    let over = isobath_lines(&lines, &frame) + &super::objects::marks(from, &frame);
    let name = "Depth map with isobaths, track and objects";
    let under = under + &super::mosaic_plan::track(from, &frame, "#000000", 0.35);
    Ok(Some(frame.svg(
        name,
        &under,
        &over,
        &legend(range_m, &frame),
    )))
}

fn bounds(surface: &Surface) -> Bounds {
    let grid = &surface.grid;
    [
        grid.west_m,
        grid.north_m - grid.rows as f64 * grid.cell_m,
        grid.west_m + grid.columns as f64 * grid.cell_m,
        grid.north_m,
    ]
}

/// Least and greatest depth.
pub fn range_m(surface: &Surface) -> [f32; 2] {
    let known = surface.depth_m.iter().filter(|depth| !depth.is_nan());
    known.fold([f32::MAX, f32::MIN], |[least, most], depth| {
        [least.min(*depth), most.max(*depth)]
    })
}

/// The depths as a picture, cells joined where there are more than can be seen.
fn picture(surface: &Surface, range_m: [f32; 2], frame: &Frame) -> String {
    let grid = &surface.grid;
    let joined = grid.columns.max(grid.rows).div_ceil(MOST_CELLS).max(1);
    let (columns, rows) = (grid.columns.div_ceil(joined), grid.rows.div_ceil(joined));
    let mut pixels = Vec::with_capacity(4 * columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let depth_m = mean_m(surface, [row * joined, column * joined], joined);
            pixels.extend(match depth_m.is_nan() {
                true => [0; 4],
                false => {
                    let [r, g, b] = depth_colour(depth_share(depth_m, range_m));
                    [r, g, b, 255]
                }
            });
        }
    }
    let side_m = grid.cell_m * joined as f64;
    let [x, y] = frame.place([grid.west_m, grid.north_m]);
    let scale = side_m * frame.px_per_m();
    format!(
        "<image x=\"{x:.2}\" y=\"{y:.2}\" width=\"{:.2}\" height=\"{:.2}\" preserveAspectRatio=\"none\" href=\"{}\"/>\n",
        columns as f64 * scale,
        rows as f64 * scale,
        raster::rgba(&pixels, columns, rows)
    )
}

/// Mean of the known depths of some cells; NaN without one.
fn mean_m(surface: &Surface, [row, column]: [usize; 2], side: usize) -> f32 {
    let grid = &surface.grid;
    let rows = row..(row + side).min(grid.rows);
    let (mut sum_m, mut count) = (0.0, 0);
    for row in rows {
        let first = row * grid.columns;
        let cells = &surface.depth_m[first + column..first + (column + side).min(grid.columns)];
        for depth_m in cells.iter().filter(|depth_m| !depth_m.is_nan()) {
            sum_m += depth_m;
            count += 1;
        }
    }
    match count {
        0 => f32::NAN,
        _ => sum_m / count as f32,
    }
}

/// The lines, and the depth of the longer ones in their middle.
fn isobath_lines(lines: &[Isobath], frame: &Frame) -> String {
    let mut drawn = String::from(
        "<g fill=\"none\" stroke=\"#ffffff\" stroke-opacity=\"0.85\" stroke-width=\"0.9\">\n",
    );
    for line in lines {
        let path = frame.path(line.points.iter().copied());
        // Writing to a string cannot fail.
        writeln!(drawn, "<path d=\"{path}\"/>").ok();
    }
    drawn.push_str("</g>\n<g text-anchor=\"middle\" font-size=\"10\" fill=\"#111111\" paint-order=\"stroke\" stroke=\"#ffffff\" stroke-width=\"2.5\">\n");
    let mut taken: Vec<[f64; 2]> = Vec::new();
    let mut longest_first: Vec<&Isobath> = lines.iter().collect();
    longest_first.sort_by(|a, b| b.length_m().total_cmp(&a.length_m()));
    for line in longest_first {
        if line.length_m() * frame.px_per_m() < LEAST_LABELLED_PX {
            break;
        }
        let Some(&middle) = line.points.get(line.points.len() / 2) else {
            continue;
        };
        let [x, y] = frame.place(middle);
        let crowded = |other: &[f64; 2]| (other[0] - x).hypot(other[1] - y) < APART_PX;
        if !taken.iter().any(crowded) {
            taken.push([x, y]);
            let depth_m = line.depth_m;
            writeln!(
                drawn,
                "<text x=\"{x:.1}\" y=\"{:.1}\">{depth_m}</text>",
                y + 3.5
            )
            .ok();
        }
    }
    drawn.push_str("</g>\n");
    drawn
}

/// A column of colours with depths beside it, shallow on top.
fn legend([least_m, most_m]: [f32; 2], frame: &Frame) -> String {
    const STEPS: usize = 32;
    let [x, y] = frame.legend_at();
    let height = (frame.height_px() - 40.0).min(240.0);
    let step = height / STEPS as f64;
    let mut drawn = format!("<text x=\"{x:.1}\" y=\"{:.1}\">depth, m</text>\n", y + 8.0);
    for index in 0..STEPS {
        let [r, g, b] = depth_colour((index as f32 + 0.5) / STEPS as f32);
        let top = y + 18.0 + index as f64 * step;
        // A little overlap, so that no seam shows between two colours.
        writeln!(drawn, "<rect x=\"{x:.1}\" y=\"{top:.2}\" width=\"16\" height=\"{:.2}\" fill=\"rgb({r},{g},{b})\"/>", step + 0.5).ok();
    }
    let extent_m = f64::from(most_m - least_m).max(f64::MIN_POSITIVE);
    for depth_m in ticks(f64::from(least_m), f64::from(most_m)) {
        let at = y + 18.0 + (depth_m - f64::from(least_m)) / extent_m * height + 4.0;
        let depth_m = (depth_m * 1e6).round() / 1e6;
        writeln!(
            drawn,
            "<text x=\"{:.1}\" y=\"{at:.1}\">{depth_m}</text>",
            x + 22.0
        )
        .ok();
    }
    drawn
}
