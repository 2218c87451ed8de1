//! The map of echoes: the mosaic with the track and the objects.

use super::frame::Frame;
use super::{ReportData, objects, raster};
use crate::bathymetry::Grid;
use crate::mosaic::{GainTable, Layout, TILE_CELLS, TileIndex, gain_table, tile};
use crate::pipeline::mosaic_layout;
use crate::progress::{Cancelled, Progress};
use rayon::prelude::*;

/// Cells along the longer side: what a screen shows, and little to send.
const MOST_CELLS: f64 = 1500.0;
/// What shows where nothing was insonified.
const PAPER: u8 = 0xf7;

/// The map; `None` where no ping has side-scan, a place, a heading and an altitude.
pub fn mosaic_plan(
    from: &ReportData<'_>,
    progress: &Progress,
) -> Result<Option<String>, Cancelled> {
    let (survey, products) = (from.survey, from.products);
    if !survey.has_side_scan() {
        return Ok(None);
    }
    let layout = mosaic_layout(survey, products, from.map);
    // Where the ground lies is known from a coarse grid already.
    let Some(coarse) = layout.grid(10.0) else {
        return Ok(None);
    };
    let extent_m = coarse.cell_m * coarse.columns.max(coarse.rows) as f64;
    let Some(grid) = layout.grid((extent_m / MOST_CELLS).max(products.settings.mosaic.cell_m))
    else {
        return Ok(None);
    };
    let Some(frame) = Frame::around(bounds(&grid), from.map) else {
        return Ok(None);
    };
    let drawing = Drawing {
        from,
        layout: &layout,
        grid: &grid,
        gain: gain_table(survey, &layout, progress)?,
        index: layout.index(&grid),
    };
    let pixels = drawing.pixels(progress)?;
    let [x, y] = frame.place([grid.west_m, grid.north_m]);
    let scale = grid.cell_m * frame.px_per_m();
    let picture = format!(
        "<image x=\"{x:.2}\" y=\"{y:.2}\" width=\"{:.2}\" height=\"{:.2}\" preserveAspectRatio=\"none\" href=\"{}\"/>\n",
        grid.columns as f64 * scale,
        grid.rows as f64 * scale,
        raster::grey(&pixels, grid.columns, grid.rows)
    );
    let under = picture + &track(from, &frame, "#e6550d", 0.8);
    let name = "Side-scan mosaic with track and objects";
    Ok(Some(frame.svg(
        name,
        &under,
        &objects::marks(from, &frame),
        "",
    )))
}

fn bounds(grid: &Grid) -> [f64; 4] {
    [
        grid.west_m,
        grid.north_m - grid.rows as f64 * grid.cell_m,
        grid.west_m + grid.columns as f64 * grid.cell_m,
        grid.north_m,
    ]
}

struct Drawing<'a> {
    from: &'a ReportData<'a>,
    layout: &'a Layout,
    grid: &'a Grid,
    gain: GainTable,
    index: TileIndex,
}

impl Drawing<'_> {
    /// Levels of all cells, row by row.
    fn pixels(&self, progress: &Progress) -> Result<Vec<u8>, Cancelled> {
        let Grid { columns, rows, .. } = *self.grid;
        let places: Vec<(usize, usize)> = self.index.tiles().collect();
        progress.start(places.len() as u64);
        let settings = &self.from.products.settings.mosaic;
        let drawn = places.par_iter().map(|&(down, across)| {
            progress.check()?;
            let place = [down, across];
            let made = tile(
                self.from.survey,
                self.layout,
                self.grid,
                &self.index,
                &self.gain,
                settings,
                place,
            );
            progress.advance(1);
            Ok((place, made))
        });
        let drawn = drawn.collect::<Result<Vec<_>, Cancelled>>()?;
        let mut pixels = vec![PAPER; columns * rows];
        for ([down, across], tile) in drawn {
            let (top, left) = (down * TILE_CELLS, across * TILE_CELLS);
            let width = TILE_CELLS.min(columns.saturating_sub(left));
            let lines = tile.levels.chunks_exact(TILE_CELLS);
            for (row, levels) in (top..rows).zip(lines) {
                let to = &mut pixels[row * columns + left..][..width];
                for (pixel, level) in to.iter_mut().zip(levels) {
                    if *level > 0 {
                        *pixel = *level;
                    }
                }
            }
        }
        Ok(pixels)
    }
}

/// The way of the boat.
pub fn track(from: &ReportData<'_>, frame: &Frame, colour: &str, opacity: f64) -> String {
    let navigation = &from.products.navigation;
    let pings = match navigation.pings.is_empty() {
        true => &navigation.soundings,
        false => &navigation.pings,
    };
    let places = pings.iter().map(|place| {
        let position = navigation.to_lon_lat(&from.survey.track, place.east_m, place.north_m);
        from.map.place(position)
    });
    format!(
        "<path d=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-opacity=\"{opacity}\" stroke-width=\"1.1\"/>\n",
        frame.path(places)
    )
}
