//! Makes the 3D bottom of a survey: the depth map with a limited number of corners, and a colour
//! for each.

use super::{DepthMap, Derived, MosaicKey, MosaicPlane};
use crate::pipeline::surface::farthest_m;
use crate::pipeline::{ProcessedLog, Same};
use bathyscope_bottom::bathymetry::{CellSource, Grid, Surface};
use bathyscope_bottom::mosaic::Colours;
use bathyscope_bottom::presentation::colours::{
    Rgb, SOURCES, depth_colour, depth_share, distance_colour, share_colour, uncertainty_colour,
};
use bathyscope_log::named;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Colour where the mosaic has no echo, or the value is unknown.
const UNSEEN: Rgb = [74, 84, 94];
/// Largest distance beside the depths to which the mosaic is drawn, metres: no side-scan sees
/// farther, but a damaged header may contain a longer range.
const MOST_BESIDE_M: f64 = 1000.0;
/// Cells along a side over which colours are averaged for pictures from far away.
const FAR_CELLS: usize = 4;
/// Share of the cells that do not exceed the end of the scale of an uncertainty or a distance, so
/// that single high values do not dull all others.
const SCALE_SHARE: f64 = 0.98;

/// Quantity that the colours of the bottom show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum BottomColour {
    /// Depth.
    #[default]
    Depth,
    /// Strength of the side-scan's echo.
    Mosaic,
    /// Uncertainty of the depth: `depth/uncertainty.tif`.
    Uncertainty,
    /// Distance to the nearest measured depth.
    Distance,
    /// Source of the depth.
    Source,
    /// Brightness of the bottom itself: `depth/hardness.tif`. Unknown without depths from echo
    /// levels.
    Hardness,
}

named! {
    /// All quantities, in the order of the menu.
    pub BottomColour {
        Depth: "depth",
        Mosaic: "mosaic",
        Uncertainty: "uncertainty",
        Distance: "distance",
        Source: "source",
        Hardness: "hardness",
    }
}

impl BottomColour {
    /// Returns the next quantity in the menu; the first after the last.
    #[must_use]
    pub fn next(self) -> Self {
        let here = Self::ALL.iter().position(|colour| *colour == self);
        here.map_or(self, |here| Self::ALL[(here + 1) % Self::ALL.len()])
    }
}

/// Inputs of a bottom: equal keys give equal bottoms.
#[derive(Clone, PartialEq)]
pub struct BottomKey {
    depth_map: Same<DepthMap>,
    mosaic: Option<MosaicKey>,
    colour: BottomColour,
    most_corners: usize,
}

impl BottomKey {
    /// Creates the key of a depth map, with the key of the mosaic of some logs if `colour` is the
    /// mosaic.
    pub fn of(
        depth_map: &Arc<DepthMap>,
        logs: &[ProcessedLog],
        colour: BottomColour,
        most_corners: usize,
    ) -> Self {
        let plane = || MosaicPlane::Map(depth_map.map.clone());
        Self {
            depth_map: Same(depth_map.clone()),
            mosaic: (colour == BottomColour::Mosaic).then(|| MosaicKey::of(logs, plane())),
            colour,
            most_corners,
        }
    }
}

/// Bottom of a survey. A corner is at the centre of each cell.
pub struct Bottom {
    /// Depth map from which the bottom was made.
    pub depth_map: Arc<DepthMap>,
    /// Surface of the corners if it is not that of the depth map: its means over larger cells, for
    /// a depth map with too many corners; or, in the colours of the mosaic, with a flat
    /// extrapolation over ground that has an echo and no depth.
    made: Option<Surface>,
    /// Shallowest and deepest depth of the depth map, metres.
    pub range_m: [f64; 2],
    /// Quantity that the colours show.
    pub colour: BottomColour,
    /// Colour of each corner.
    pub rgb: Vec<Rgb>,
    /// Mean colour of the ground around each corner, for pictures from far away; `None` if single
    /// colours vary little between cells.
    far_rgb: Option<Vec<Rgb>>,
    /// Values at the ends of the colour scale, metres, or decibels for hardness; `None` for the
    /// mosaic and the source of depths, and if no value is known.
    pub ends: Option<[f32; 2]>,
    /// True if the bottom includes ground with an echo but no known depth, on a flat extrapolation
    /// of the depths.
    pub has_flat_extrapolation: bool,
}

/// Corner of the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BottomCorner {
    /// East and north in the plane of the survey, and elevation over its vertical reference,
    /// metres.
    pub place_m: [f64; 3],
    /// Unit normal of the bottom: east, north, up.
    pub normal: [f32; 3],
    /// Colour of the corner.
    pub rgb: Rgb,
    /// Mean colour of the ground around the corner, [`FAR_CELLS`] cells across.
    pub far_rgb: Rgb,
    /// Knowledge of the corner's depth; the elevation is 0 if it is unknown.
    pub ground: CornerGround,
}

/// Knowledge of the depth of a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CornerGround {
    /// The depth is unknown, and no echo is shown there.
    Unknown,
    /// The depth is unknown, but an echo is shown, on a flat extrapolation of the depths.
    Level,
    /// The depth is known.
    Depth,
}

impl Bottom {
    /// Creates the bottom of a depth map, with `most_corners` or fewer.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub(super) fn new(
        derived: &Derived,
        depth_map: &Arc<DepthMap>,
        logs: &[ProcessedLog],
        colour: BottomColour,
        most_corners: usize,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let times = depth_map.surface.grid.times_coarser(most_corners);
        let made = (times > 1).then(|| depth_map.surface.coarser(times));
        let surface = made.as_ref().unwrap_or(&depth_map.surface);
        progress.check()?;
        let (rgb, ends) = match colour {
            BottomColour::Depth => {
                let ends_m = depth_map.colour_range_m;
                let colour = |depth_m| depth_colour(depth_share(depth_m, ends_m));
                (of_values(&surface.depth_m, colour), Some(ends_m))
            }
            BottomColour::Uncertainty => scaled(&surface.spread_m, uncertainty_colour),
            BottomColour::Distance => scaled(&surface.distance_m, distance_colour),
            BottomColour::Source => (surface.source.iter().map(source_colour).collect(), None),
            BottomColour::Hardness => match &surface.hardness_db {
                Some(hardness_db) => hardness(hardness_db),
                None => (vec![UNSEEN; surface.grid.len()], None),
            },
            BottomColour::Mosaic => {
                return Self::under_mosaic(derived, depth_map, logs, most_corners, progress);
            }
        };
        Ok(Self {
            range_m: depth_map.surface.range_m(),
            depth_map: depth_map.clone(),
            colour,
            rgb,
            far_rgb: None,
            ends,
            has_flat_extrapolation: false,
            made,
        })
    }

    /// Creates the bottom in the colours of the mosaic, including ground around the depths that the
    /// mosaic shows, in cells as fine as the mosaic's if `most_corners` allows it.
    fn under_mosaic(
        derived: &Derived,
        depth_map: &Arc<DepthMap>,
        logs: &[ProcessedLog],
        most_corners: usize,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let plane = MosaicPlane::Map(depth_map.map.clone());
        let mosaic = derived.mosaic(logs, plane, progress)?;
        let fine = depth_map.surface.grid;
        let shown_m = mosaic.as_ref().map_or(fine.bounds_m(), |mosaic| {
            let reach_m = logs.iter().map(|log| farthest_m(&log.survey));
            beside(&fine, mosaic.bounds, reach_m.fold(0.0, f64::max))
        });
        let around = |times: usize| fine.coarser(times).reaching(shown_m);
        let mut times = 1;
        while around(times).len() > most_corners.max(1) {
            times += 1;
        }
        let around = around(times);
        let colours =
            (mosaic.as_ref()).map_or(Colours::default(), |mosaic| mosaic.settings.colours);
        let mosaic_cell_m = mosaic.as_ref().map_or(fine.cell_m, |mosaic| mosaic.settings.cell_m);
        let finest = (around.cell_m / mosaic_cell_m).round().max(1.0) as usize;
        let fits = |finer: &usize| around.finer(*finer).len() <= most_corners;
        let finer = (1..=finest).rev().find(fits).unwrap_or(1);
        let coloured = |grid: &Grid| match &mosaic {
            Some(mosaic) => mosaic.levels(grid, progress),
            None => Ok(vec![0; grid.len()]),
        };
        let grid = around.finer(finer);
        let levels = coloured(&grid)?;
        let far = grid.coarser(FAR_CELLS);
        let far_levels = coloured(&far)?;
        let surface = depth_map.surface.coarser(times).extrapolated_flat(around, |_| true);
        progress.check()?;
        let mut surface = surface.finer(finer);
        let cells = surface.depth_m.par_iter_mut().zip(&surface.source);
        cells.zip(&levels).for_each(|((depth_m, source), level)| {
            if *source == CellSource::None && *level == 0 {
                *depth_m = f32::NAN;
            }
        });
        let rgb: Vec<Rgb> =
            (levels.par_iter()).map(|level| Self::echo_colour(colours, *level)).collect();
        let far_rgb = (0..grid.len()).into_par_iter().map(|cell| {
            let place = grid.centre_of(cell);
            let level = between(&far, &far_levels, place);
            level.map_or(rgb[cell], |level| Self::echo_colour(colours, level))
        });
        Ok(Self {
            range_m: depth_map.surface.range_m(),
            depth_map: depth_map.clone(),
            colour: BottomColour::Mosaic,
            far_rgb: Some(far_rgb.collect()),
            rgb,
            ends: None,
            has_flat_extrapolation: is_flat_extrapolation(&surface),
            made: Some(surface),
        })
    }

    /// Returns the depth of the cell at a place east and north of the survey's origin, known or
    /// extrapolated flat, metres; `None` if there is none.
    pub fn depth_at(&self, place: [f64; 2]) -> Option<f32> {
        let [easting_m, northing_m] = self.depth_map.to_map(place);
        let (depth_m, _) = self.surface().at(easting_m, northing_m)?;
        Some(depth_m)
    }

    /// Returns the surface of the corners: that of the depth map, or the one made from it.
    pub fn surface(&self) -> &Surface {
        self.made.as_ref().unwrap_or(&self.depth_map.surface)
    }

    /// Returns the corners of some rows and columns, row by row from the north-west; corners
    /// outside the grid are unknown. Places are interpolated bilinearly between the four outermost
    /// corners: over some ten cells this differs from the projection by far less than a millimetre.
    pub fn corners(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
    ) -> impl Iterator<Item = BottomCorner> {
        let grid = &self.surface().grid;
        let place = |row, column| self.depth_map.to_survey(grid.centre(row, column));
        let ends = [
            place(rows.start, columns.start),
            place(rows.start, columns.end),
            place(rows.end, columns.start),
            place(rows.end, columns.end),
        ];
        let (first_row, first_column) = (rows.start, columns.start);
        let (height, width) = (rows.len().max(1) as f64, columns.len().max(1) as f64);
        rows.flat_map(move |row| columns.clone().map(move |column| (row, column))).map(
            move |(row, column)| {
                let down = (row - first_row) as f64 / height;
                let right = (column - first_column) as f64 / width;
                let between = |axis: usize| {
                    let [north_west, north_east, south_west, south_east] =
                        ends.map(|end| end[axis]);
                    let north = north_west + right * (north_east - north_west);
                    let south = south_west + right * (south_east - south_west);
                    north + down * (south - north)
                };
                self.corner(row, column, [between(0), between(1)])
            },
        )
    }

    /// Returns the colour of a level of the mosaic; for level 0, without an echo, the colour of
    /// unseen ground.
    pub(crate) fn echo_colour(colours: Colours, level: u8) -> Rgb {
        match colours.rgba(level) {
            [_, _, _, 0] => UNSEEN,
            [r, g, b, _] => [r, g, b],
        }
    }

    fn corner(&self, row: usize, column: usize, [east_m, north_m]: [f64; 2]) -> BottomCorner {
        let surface = self.surface();
        let grid = &surface.grid;
        let is_inside = row < grid.rows && column < grid.columns;
        let cell = row * grid.columns + column;
        let depth_m = if is_inside { surface.depth_m[cell] } else { f32::NAN };
        let ground = match depth_m.is_nan() {
            true => CornerGround::Unknown,
            false if surface.source[cell] == CellSource::None => CornerGround::Level,
            false => CornerGround::Depth,
        };
        let up_m = if depth_m.is_nan() { 0.0 } else { -f64::from(depth_m) };
        let rgb = if is_inside { self.rgb[cell] } else { UNSEEN };
        BottomCorner {
            place_m: [east_m, north_m, up_m],
            normal: surface.normal(row, column),
            rgb,
            far_rgb: match &self.far_rgb {
                Some(far_rgb) if is_inside => far_rgb[cell],
                _ => rgb,
            },
            ground,
        }
    }
}

/// Returns the extent of a grid, widened to the shown extent, by at most `reach_m` or
/// [`MOST_BESIDE_M`].
fn beside(grid: &Grid, shown_m: [f64; 4], reach_m: f64) -> [f64; 4] {
    let reach_m = reach_m.min(MOST_BESIDE_M);
    let [west_m, south_m, east_m, north_m] = grid.bounds_m();
    [
        shown_m[0].max(west_m - reach_m).min(west_m),
        shown_m[1].max(south_m - reach_m).min(south_m),
        shown_m[2].min(east_m + reach_m).max(east_m),
        shown_m[3].min(north_m + reach_m).max(north_m),
    ]
}

/// Interpolates a level of the mosaic between the middles of cells, from those of the nearest cells
/// that have an echo; `None` if none has.
fn between(grid: &Grid, levels: &[u8], place: [f64; 2]) -> Option<u8> {
    let [rows, columns] = grid.about(place);
    let weighted = |[before, behind]: [usize; 2], share: f64| {
        let share = share.clamp(0.0, 1.0);
        [(before, 1.0 - share), (behind, share)]
    };
    let mut sums = [0.0; 2];
    for (row, down) in weighted(rows.cells, rows.share) {
        for (column, right) in weighted(columns.cells, columns.share) {
            let level = levels[row * grid.columns + column];
            if level > 0 {
                sums[0] += down * right * f64::from(level);
                sums[1] += down * right;
            }
        }
    }
    (sums[1] > 0.0).then(|| (sums[0] / sums[1]).round() as u8)
}

fn is_flat_extrapolation(surface: &Surface) -> bool {
    let mut cells = surface.depth_m.iter().zip(&surface.source);
    cells.any(|(depth_m, source)| !depth_m.is_nan() && *source == CellSource::None)
}

fn source_colour(source: &CellSource) -> Rgb {
    let known = CellSource::KNOWN.iter().position(|known| known == source);
    known.map_or(UNSEEN, |index| SOURCES[index])
}

fn of_values(values: &[f32], colour: impl Fn(f32) -> Rgb + Sync) -> Vec<Rgb> {
    values.par_iter().map(|value| colour(*value)).collect()
}

/// Returns the colours of decibels on a scale symmetric about 0, and the ends of the scale.
fn hardness(values_db: &[f32]) -> (Vec<Rgb>, Option<[f32; 2]>) {
    let most = usual_most(values_db.iter().map(|value| value.abs()));
    let ends = most.map(|most| [-most, most]);
    let colour = |value: f32| match ends {
        Some([low, high]) if value.is_finite() => share_colour((value - low) / (high - low)),
        _ => UNSEEN,
    };
    (of_values(values_db, colour), ends)
}

/// Returns the colours of values on a scale that begins at 0, and the ends of the scale.
fn scaled(values: &[f32], colour: fn(f32) -> Rgb) -> (Vec<Rgb>, Option<[f32; 2]>) {
    match usual_most(values.iter().copied()) {
        Some(most) => (of_values(values, |value| colour(value / most)), Some([0.0, most])),
        None => (of_values(values, colour), None),
    }
}

/// Returns the value, above 0, that [`SCALE_SHARE`] of the known values do not exceed; `None` if
/// none is known.
fn usual_most(values: impl Iterator<Item = f32>) -> Option<f32> {
    let mut known: Vec<f32> = values.filter(|value| value.is_finite()).collect();
    let rank = (SCALE_SHARE * known.len().checked_sub(1)? as f64) as usize;
    let most = *known.select_nth_unstable_by(rank, f32::total_cmp).1;
    Some(most.max(f32::MIN_POSITIVE))
}
