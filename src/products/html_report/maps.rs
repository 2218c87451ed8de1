//! Draws the maps of the page, each a picture with the track and the objects in a frame: depths, as
//! colours with isobaths and their depths, and echoes.

use super::frame::{PageTransform, pixels};
use super::{ReportData, jpeg_address, objects, png_address};
use crate::pipeline::{DepthMap, Mosaic, ProcessedLog};
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::bathymetry::isobaths::Isobath;
use bathyscope_bottom::mosaic::joint_grid;
use bathyscope_bottom::presentation::colours::{depth_colour, lit_depth_colour};
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::presentation::ticks::ticks;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Longest side of the picture under the isobaths, pixels: more would not be visible on a screen,
/// and fewer pixels make a smaller file.
const MOST_PIXELS: usize = 1200;
/// Length on the page below which an isobath has no depth label, pixels.
const LEAST_LABELLED_PX: f64 = 90.0;
/// Distance below which a label near another one is left out, pixels.
const APART_PX: f64 = 46.0;
/// Largest number of cells along the longer side: more would not be visible on a screen, and fewer
/// cells make a smaller file.
const MOST_CELLS: f64 = 1500.0;
/// Number of rows that are drawn together.
const BAND_ROWS: usize = 128;
/// Grey level of places that were not insonified.
const PAPER: u8 = 0xf7;

/// Draws the map of depths; `None` where they span no surface.
pub(super) fn depth_plan(
    from: &ReportData<'_>,
    progress: &Progress,
) -> Result<Option<Value>, Cancelled> {
    let Some(depth_map) = from.depth_map else {
        return Ok(None);
    };
    let surface = &depth_map.surface;
    let Some(frame) = PageTransform::around(surface.grid.bounds_m(), from.map) else {
        return Ok(None);
    };
    let range_m = surface.range_m().map(|depth_m| depth_m as f32);
    let picture = lit_picture(depth_map, range_m, depth_map.shade(progress)?, &frame);
    let settings = &from.products.settings;
    Ok(Some(context! {
        map => map(from, &frame, picture),
        isobaths => isobath_lines(&from.isobaths.lines, &frame),
        legend => legend(range_m, &frame),
        cell_m => format!("{:.2}", surface.grid.cell_m),
        method => surface.method_in_words(),
        system => from.map.crs.to_string(),
        between_lines => surface.between_lines(),
        max_gap_m => settings.surface.max_gap_m.to_string(),
        exaggeration => depth_map.light.exaggeration.to_string(),
        correction => correction(from),
    }))
}

/// Returns the depths with their hill-shade as a picture, in which several cells are joined to a
/// pixel if there are more than [`MOST_PIXELS`] along a side. `shade` is the brightness of every
/// cell, 0 where it is not known.
fn lit_picture(
    depth_map: &DepthMap,
    range_m: [f32; 2],
    shade: &[u8],
    frame: &PageTransform,
) -> Value {
    let (surface, grid) = (&depth_map.surface, &depth_map.surface.grid);
    let level_ground = f32::from(depth_map.light.level_ground());
    let joined = grid.columns.max(grid.rows).div_ceil(MOST_PIXELS).max(1);
    // The colour of the mean depth of some cells, lit by their mean shade; transparent where no
    // depth is known.
    let pixel = |row: usize, column: usize| -> [u8; 4] {
        let (mut depths, mut shades) = (Mean::default(), Mean::default());
        for row in row..(row + joined).min(grid.rows) {
            let first = row * grid.columns;
            let cells = first + column..first + (column + joined).min(grid.columns);
            for (depth_m, shade) in surface.depth_m[cells.clone()].iter().zip(&shade[cells]) {
                if !depth_m.is_nan() {
                    depths.add(*depth_m);
                }
                if *shade > 0 {
                    shades.add(f32::from(*shade));
                }
            }
        }
        let Some(depth_m) = depths.mean() else {
            return [0; 4];
        };
        // Level ground keeps its colour: its light is 1.
        let light = shades.mean().unwrap_or(level_ground) / level_ground;
        let [r, g, b] = lit_depth_colour(depth_m, range_m, light);
        [r, g, b, 255]
    };
    let coarse = grid.coarser(joined);
    let mut pixels = Vec::with_capacity(4 * coarse.len());
    for row in 0..coarse.rows {
        for column in 0..coarse.columns {
            pixels.extend(pixel(row * joined, column * joined));
        }
    }
    frame.picture(&coarse, png_address(&pixels, coarse.columns, coarse.rows))
}

#[derive(Default)]
struct Mean {
    sum: f32,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f32) {
        self.sum += value;
        self.count += 1;
    }

    fn mean(&self) -> Option<f32> {
        (self.count > 0).then(|| self.sum / self.count as f32)
    }
}

/// Returns the paths of the isobaths, and the depth of the longer ones at their middle.
fn isobath_lines(lines: &[Isobath], frame: &PageTransform) -> Value {
    let paths = lines.iter().map(|line| frame.path(line.points.iter().copied()));
    let mut labels: Vec<(String, String, String)> = Vec::new();
    let mut label_places: Vec<[f64; 2]> = Vec::new();
    let mut longest_first: Vec<&Isobath> = lines.iter().collect();
    longest_first.sort_by(|a, b| b.length_m().total_cmp(&a.length_m()));
    for line in longest_first {
        if line.length_m() * frame.px_per_m < LEAST_LABELLED_PX {
            break;
        }
        let Some(&middle) = line.points.get(line.points.len() / 2) else {
            continue;
        };
        let [x, y] = frame.place(middle);
        let crowded = |other: &[f64; 2]| (other[0] - x).hypot(other[1] - y) < APART_PX;
        if !label_places.iter().any(crowded) {
            label_places.push([x, y]);
            labels.push((pixels(x), pixels(y + 3.5), line.depth_m.to_string()));
        }
    }
    context!(paths => paths.collect::<Vec<String>>(), labels)
}

/// Returns a column of colours with depths beside it, shallow on top.
fn legend([least_m, most_m]: [f32; 2], frame: &PageTransform) -> Value {
    const STEPS: usize = 32;
    let [x, y] = frame.legend_at();
    let height = (frame.height_px - 40.0).min(240.0);
    let step = height / STEPS as f64;
    let steps = (0..STEPS).map(|index| {
        let [r, g, b] = depth_colour((index as f32 + 0.5) / STEPS as f32);
        let top = y + 18.0 + index as f64 * step;
        (format!("{top:.2}"), format!("rgb({r},{g},{b})"))
    });
    let extent_m = f64::from(most_m - least_m).max(f64::MIN_POSITIVE);
    let ticks = ticks(f64::from(least_m), f64::from(most_m)).into_iter().map(|(depth_m, label)| {
        let at = y + 18.0 + (depth_m - f64::from(least_m)) / extent_m * height + 4.0;
        (pixels(at), label)
    });
    context! {
        x => pixels(x),
        y => pixels(y + 8.0),
        text_x => pixels(x + 22.0),
        steps => steps.collect::<Vec<_>>(),
        // A little overlap, so that no seam shows between two colours.
        step_height => format!("{:.2}", step + 0.5),
        ticks => ticks.collect::<Vec<_>>(),
    }
}

/// Draws the map of echoes of all logs; `None` where no ping has side-scan, a place, a heading and
/// an altitude.
pub(super) fn mosaic_plan(
    from: &ReportData<'_>,
    progress: &Progress,
) -> Result<Option<Value>, Cancelled> {
    let Some(mosaic) = from.mosaic else {
        return Ok(None);
    };
    let [west, south, east, north] = mosaic.bounds;
    let extent_m = (east - west).max(north - south);
    let cell_m = (extent_m / MOST_CELLS).max(from.products.settings.mosaic.cell_m);
    let Some(grid) = joint_grid(&mosaic.logs, cell_m) else {
        return Ok(None);
    };
    let Some(frame) = PageTransform::around(grid.bounds_m(), from.map) else {
        return Ok(None);
    };
    let levels = mosaic_levels(mosaic, &grid, progress)?;
    let picture = frame.picture(&grid, jpeg_address(&levels, grid.columns, grid.rows));
    Ok(Some(map(from, &frame, picture)))
}

/// Returns the levels of all cells, row by row.
fn mosaic_levels(mosaic: &Mosaic, grid: &Grid, progress: &Progress) -> Result<Vec<u8>, Cancelled> {
    let tops: Vec<usize> = (0..grid.rows).step_by(BAND_ROWS).collect();
    progress.start(tops.len() as u64);
    let bands = tops.into_par_iter().map(|top| {
        let band = Grid {
            north_m: grid.north_m - top as f64 * grid.cell_m,
            rows: BAND_ROWS.min(grid.rows - top),
            ..*grid
        };
        let mut levels = mosaic.levels(&band, progress)?;
        for level in levels.iter_mut().filter(|level| **level == 0) {
            *level = PAPER;
        }
        progress.advance(1);
        Ok(levels)
    });
    let bands = bands.collect::<Result<Vec<_>, Cancelled>>()?;
    Ok(bands.concat())
}

/// Returns the values of a map around a picture.
fn map(from: &ReportData<'_>, frame: &PageTransform, picture: Value) -> Value {
    context! {
        picture,
        track => track(from, frame),
        marks => objects::marks(from, frame),
        ..frame.values()
    }
}

/// Returns the path of the boat in all logs.
fn track(from: &ReportData<'_>, frame: &PageTransform) -> String {
    let of_log = |log: &ProcessedLog| {
        let navigation = &log.products.navigation;
        let pings =
            if navigation.pings.is_empty() { &navigation.soundings } else { &navigation.pings };
        let places = pings.iter().map(|place| {
            let track = &log.survey.track;
            from.map.place(navigation.to_lon_lat(track, place.east_m, place.north_m))
        });
        frame.path(places)
    };
    from.logs.iter().map(of_log).collect()
}

/// Describes the corrections of all logs, applied or not; refers to another section where they
/// differ from log to log.
fn correction(from: &ReportData<'_>) -> String {
    let statements = (from.logs.iter()).map(|log| log.products.correction.statement());
    let statements: BTreeSet<String> = statements.collect();
    match statements.len() {
        1 => statements.into_iter().collect(),
        _ => "Corrections differ from log to log; see how far to trust it.".to_owned(),
    }
}
