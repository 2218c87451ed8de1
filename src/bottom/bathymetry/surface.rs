//! Computes the surface: depths on a grid over the soundings, with values only where a sounding is
//! near.

use super::from_levels::{FromLevels, SwathDepth};
use super::grid::{CellSource, measured_cells, settle};
use super::left_out::{LeftOut, bend_and_state_error};
use super::{
    Bends, Between, DepthPoint, Grid, Node, Tin, TinSampler, merge_repeated, suited_cell_m,
};
use crate::cloud::{CloudPoint, PointSource};
use crate::nearest::Nearest;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{ends, quantile, sorted};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Method that finds the depth between soundings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SurfaceMethod {
    /// Delaunay triangles: through every sounding, so that no shoal that was measured is lost. They
    /// bend to the slopes on the lines ([`Bends`]) where left-out soundings are then predicted
    /// better, and are plane elsewhere. Older projects may name a plate of least bending, which no
    /// longer exists.
    #[default]
    #[serde(alias = "auto", alias = "smooth")]
    Linear,
    /// Natural neighbours (Sibson): smooth except at the soundings.
    Natural,
    /// Inverse distance squared of the nearest 64 within the gap: smooth, draws towards the mean.
    InverseDistance,
}

impl SurfaceMethod {
    /// Returns the method in words, for texts such as `By ... in cells of 0.5 m`.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Linear => "linear triangles",
            Self::Natural => "natural neighbours",
            Self::InverseDistance => "inverse distance",
        }
    }
}

/// Distance within which a depth that was excluded casts doubt on cells, metres.
const DOUBTED_M: f64 = 1.0;

/// `surface.*` settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SurfaceSettings {
    /// Method that finds the depth between soundings.
    pub method: SurfaceMethod,
    /// Side of a cell, metres; chosen from the spacing of the soundings ([`suited_cell_m`]) when
    /// not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell_m: Option<f64>,
    /// Greatest distance from a sounding at which there is a value, metres; triangles between
    /// soundings more than twice as far apart have none either ([`super::Tin::with_max_gap`]).
    pub max_gap_m: f64,
    /// Largest number of cells along the longer side: a cell is larger where there would be more of
    /// them, or more than 20 million in all.
    pub max_side: usize,
    /// Weight of a recorder's own depth, a sounding or one of a swath, where several depths fall
    /// into one cell; 0 excludes them.
    pub down_scan_weight: f64,
    /// Weight of a side-scan point in such a cell; 0 excludes side-scan points.
    pub side_scan_weight: f64,
    /// True if all side-scan points above the recorded depth count: their depth may be that of weed
    /// or fish.
    pub above_bottom: bool,
    /// Least length along the track for which side-scan points above the recorded depth count,
    /// metres: where most first returns of their side lie above this depth, and those of the other
    /// side do not. A bank is longer than this, but no clump of weed, fish or object.
    pub longest_above_bottom_m: f64,
    /// Setting for depths between the lines from the levels of the echoes.
    pub swath: SwathDepth,
    /// True if echoes and objects are placed on the bottom that the log measured, where it did
    /// ([`bathyscope_log::survey::Relief`]); otherwise on a level one.
    pub relief: bool,
}

impl Default for SurfaceSettings {
    fn default() -> Self {
        Self {
            method: SurfaceMethod::default(),
            cell_m: None,
            max_gap_m: 20.0,
            max_side: 4096,
            down_scan_weight: 1.0,
            // On ponds 101 to 110 of `cargo bench -- surface` the map's error
            // falls up to 1 and stays beyond: RMS 3.8 cm with soundings only, 3.4 at 0.3, 3.2 at 1
            // (gentle), 17.4, 16.5, 16.4 (steep), 6.6, 6.5, 6.3 (rough).
            side_scan_weight: 1.0,
            above_bottom: false,
            longest_above_bottom_m: 40.0,
            swath: SwathDepth::default(),
            relief: true,
        }
    }
}

impl SurfaceSettings {
    /// Returns the weight of a point of the bottom; for a side-scan point it includes the
    /// confidence. 0 when its source is excluded.
    pub fn weight(&self, point: &CloudPoint) -> f64 {
        match point.source {
            // Both are depths of the recorder itself.
            PointSource::DownScan | PointSource::Swath => self.down_scan_weight,
            PointSource::Port | PointSource::Starboard => {
                self.side_scan_weight * f64::from(point.ground_confidence())
            }
        }
    }

    /// Returns true if the same depths count, whatever the surface between them is.
    pub fn counts_the_same(&self, other: &Self) -> bool {
        Self {
            method: other.method,
            cell_m: other.cell_m,
            max_side: other.max_side,
            swath: other.swath,
            ..self.clone()
        } == *other
    }
}

/// Meaning of the spread of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spread {
    /// Disagreement of the soundings that carry a cell: the standard deviation of their depths
    /// about the cell's, each with its share and its own spread, so it grows with noise and with
    /// relief between soundings.
    OfSoundings,
    /// The standard deviation of the depth's error by the distance to the nearest sounding, as
    /// leaving soundings out shows it.
    OfError,
}

/// Depths on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Method that found the depth between soundings.
    pub method: SurfaceMethod,
    /// Bends of the triangles between the soundings; `None` where they are straight.
    pub bends: Option<Bends>,
    /// Result of depths between measured ones from the levels of the echoes (`crate::swath`).
    pub levels: FromLevels,
    /// Meaning of the spreads.
    pub spread_is: Spread,
    /// Grid of the cells.
    pub grid: Grid,
    /// Depth at the centre of each cell, metres, row by row; NaN where nothing is known.
    pub depth_m: Vec<f32>,
    /// Spread as [`Surface::spread_is`] defines it, metres; NaN where nothing is known.
    pub spread_m: Vec<f32>,
    /// Distance from the centre of each cell to the nearest sounding, metres; NaN where nothing is
    /// known.
    pub distance_m: Vec<f32>,
    /// The source of the depth in each cell.
    pub source: Vec<CellSource>,
    /// Brightness of the bed of each cell over that of the median cell, decibels of power, once
    /// slope, angle, range and the recorder's gain are taken out: a hard bottom is bright; NaN
    /// where no echo determines it. `None` without depths from levels.
    pub hardness_db: Option<Vec<f32>>,
}

impl Surface {
    /// Creates a surface from depths that are themselves known, metres, row by row.
    pub fn of_depths(grid: Grid, depth_m: Vec<f32>) -> Self {
        Self {
            method: SurfaceMethod::Linear,
            bends: None,
            levels: FromLevels::Off,
            spread_is: Spread::OfSoundings,
            grid,
            spread_m: vec![0.0; depth_m.len()],
            distance_m: vec![0.0; depth_m.len()],
            source: vec![CellSource::Sounding; depth_m.len()],
            hardness_db: None,
            depth_m,
        }
    }

    /// Creates a surface of unknown depths, without sources.
    pub(super) fn unknown(grid: Grid, method: SurfaceMethod) -> Self {
        let unknown = || vec![f32::NAN; grid.len()];
        Self {
            method,
            depth_m: unknown(),
            spread_m: unknown(),
            distance_m: unknown(),
            source: Vec::new(),
            ..Self::of_depths(grid, Vec::new())
        }
    }

    /// Sets the depth of each cell that holds a node and lies in no triangle to that of the node: a
    /// single track hardly spans a triangle, and its map consists of the cells that were measured.
    pub(super) fn fill_measured(&mut self, nodes: impl Iterator<Item = Node>) {
        for node in nodes {
            let Some(index) = self.grid.index_at(node.east_m, node.north_m) else {
                continue;
            };
            if self.depth_m.get(index).is_some_and(|depth| depth.is_nan()) {
                let [east_m, north_m] = self.grid.centre_of(index);
                let distance_m = (node.east_m - east_m).hypot(node.north_m - north_m);
                self.depth_m[index] = node.depth_m as f32;
                self.spread_m[index] = node.spread_m as f32;
                self.distance_m[index] = distance_m as f32;
            }
        }
    }

    /// Widens the stated error beside depths that were left out but may be the ground, such as a
    /// scarp at one side of the boat that cannot be distinguished from weed: by half of the depth
    /// by which nearby cells are deeper, as where the chance that the left-out depth is the ground
    /// is a quarter.
    pub fn doubt(&mut self, left_out: &[DepthPoint]) {
        if self.spread_is != Spread::OfError {
            return;
        }
        // Only the shoalest depth of each cell counts.
        let mut shoalest_m: HashMap<usize, f64> = HashMap::new();
        for point in left_out {
            if let Some(cell) = self.grid.index_at(point.east_m, point.north_m) {
                let depth_m = shoalest_m.entry(cell).or_insert(f64::INFINITY);
                *depth_m = depth_m.min(point.depth_m);
            }
        }
        let mut deeper_m: HashMap<usize, f32> = HashMap::new();
        for (at, shoalest_m) in shoalest_m {
            for cell in self.grid.cells_within(self.grid.centre_of(at), DOUBTED_M) {
                let more_m = self.depth_m[cell] - shoalest_m as f32;
                // False where no depth is known.
                if more_m > 0.0 {
                    let most_m = deeper_m.entry(cell).or_default();
                    *most_m = most_m.max(more_m);
                }
            }
        }
        for (cell, more_m) in deeper_m {
            self.spread_m[cell] = self.spread_m[cell].hypot(0.5 * more_m);
        }
    }

    /// Returns the method in words, such as `linear triangles, between the lines from echo levels`.
    pub fn method_in_words(&self) -> String {
        let straight = self.method.in_words();
        let method = match self.bends {
            Some(_) => format!("{straight} bent to the slopes on the lines"),
            None => straight.to_owned(),
        };
        match self.levels {
            FromLevels::Used { .. } => format!("{method}, between the lines from echo levels"),
            FromLevels::Off | FromLevels::Refused(_) => method,
        }
    }

    /// Returns sentences for reports about depths between the lines; `None` where these are
    /// interpolated and nothing else was tried.
    pub fn between_lines(&self) -> Option<String> {
        let sentences = [self.bends.map(|bends| bends.sentence()), self.levels.sentence()];
        let sentences: Vec<String> = sentences.into_iter().flatten().collect();
        (!sentences.is_empty()).then(|| sentences.join(" "))
    }

    /// Returns the shallowest and deepest known depth, metres; the first is above the second where
    /// no depth is known.
    pub fn range_m(&self) -> [f64; 2] {
        let known = self.depth_m.iter().filter(|depth| !depth.is_nan());
        ends(known.map(|depth| f64::from(*depth)))
    }

    /// Returns the west, south, east and north edge of the cells with a known depth, metres of the
    /// grid; `None` without any.
    pub fn known_bounds_m(&self) -> Option<[f64; 4]> {
        let grid = &self.grid;
        let rows = self.depth_m.chunks(grid.columns.max(1)).enumerate();
        let rows = rows.filter_map(|(row, depths)| {
            let first = depths.iter().position(|depth| !depth.is_nan())?;
            let last = depths.iter().rposition(|depth| !depth.is_nan())?;
            Some([row, row, first, last])
        });
        let [top, bottom, left, right] =
            rows.reduce(|all, row| [all[0], row[1], all[2].min(row[2]), all[3].max(row[3])])?;
        let east = |column: usize| grid.west_m + column as f64 * grid.cell_m;
        let north = |row: usize| grid.north_m - row as f64 * grid.cell_m;
        Some([east(left), north(bottom + 1), east(right + 1), north(top)])
    }

    /// Returns the standard deviations of the depth's error, metres, that half and nine tenths of
    /// the known cells do not exceed; `None` where the spreads are not of errors.
    pub fn usual_error_m(&self) -> Option<[f64; 2]> {
        let is_told = self.spread_is == Spread::OfError;
        let sigmas_m = is_told.then(|| self.spreads_m(|_| true)).filter(|all| !all.is_empty())?;
        Some([0.5, 0.9].map(|share| quantile(&sigmas_m, share)))
    }

    /// Returns the standard deviation of the depth's error, metres, that half of the cells with a
    /// measured depth do not exceed. Where too few soundings were left out to state errors, it is
    /// their disagreement in these cells. `None` where neither is known: by inverse distance the
    /// soundings of a cell lie far apart.
    pub fn measured_error_m(&self) -> Option<f64> {
        let is_measured = |source| matches!(source, CellSource::Sounding | CellSource::FirstReturn);
        let is_told =
            self.spread_is == Spread::OfError || self.method != SurfaceMethod::InverseDistance;
        let sigmas_m =
            is_told.then(|| self.spreads_m(is_measured)).filter(|all| !all.is_empty())?;
        Some(quantile(&sigmas_m, 0.5))
    }

    /// Returns the spreads of the known cells whose source counts, metres, rising.
    fn spreads_m(&self, counts: impl Fn(CellSource) -> bool) -> Vec<f64> {
        let known = self.spread_m.iter().zip(&self.source);
        let known = known.filter(|(spread, source)| !spread.is_nan() && counts(**source));
        sorted(known.map(|(spread, _)| f64::from(*spread)))
    }

    /// Returns the shares of the known cells of each source, in the order of [`CellSource::KNOWN`].
    pub fn source_shares(&self) -> [f64; 4] {
        let of = |source| {
            self.source.iter().filter(|cell_source| **cell_source == source).count() as f64
        };
        let counts = CellSource::KNOWN.map(of);
        let all: f64 = counts.iter().sum();
        counts.map(|count| count / all.max(1.0))
    }

    /// Returns the cells of the surface on a smaller grid of the same cells, within its own grid.
    #[must_use]
    pub fn part(&self, part: Grid) -> Self {
        let grid = self.grid;
        let cells = |metres: f64| (metres / grid.cell_m).round() as usize;
        let first_row = cells(grid.north_m - part.north_m);
        let first_column = cells(part.west_m - grid.west_m);
        let start = |row: usize| (row + first_row) * grid.columns + first_column;
        let cut = |values: &[f32]| -> Vec<f32> {
            let rows = (0..part.rows).map(|row| &values[start(row)..start(row) + part.columns]);
            rows.flatten().copied().collect()
        };
        let sources = (0..part.rows).map(|row| &self.source[start(row)..start(row) + part.columns]);
        self.on_grid(part, cut, sources.flatten().copied().collect())
    }

    /// Returns the surface on another grid, with values that `numbers` computes and with these
    /// sources.
    pub(super) fn on_grid(
        &self,
        grid: Grid,
        numbers: impl Fn(&[f32]) -> Vec<f32>,
        source: Vec<CellSource>,
    ) -> Self {
        Self {
            grid,
            depth_m: numbers(&self.depth_m),
            spread_m: numbers(&self.spread_m),
            distance_m: numbers(&self.distance_m),
            source,
            hardness_db: self.hardness_db.as_deref().map(numbers),
            ..*self
        }
    }

    /// Returns the depth of the cell at a place and its distance to the nearest sounding, metres;
    /// `None` where nothing is known.
    pub fn at(&self, east_m: f64, north_m: f64) -> Option<(f32, f32)> {
        let index = self.grid.index_at(east_m, north_m)?;
        let depth_m = *self.depth_m.get(index)?;
        (!depth_m.is_nan()).then_some((depth_m, *self.distance_m.get(index)?))
    }
}

/// Samples the soundings on a grid: no value outside their hull, farther than the gap from one, or
/// in triangles between soundings too far apart ([`Tin::with_max_gap`]), so that the hull follows a
/// winding track; a cell that holds a sounding has a value. Soundings of one cell are merged first
/// ([`merge_repeated`]). `None` when there is no surface (fewer than three places, or all on one
/// line).
///
/// The function takes the points by value, since a log has millions: they are freed before the
/// triangles are made.
///
/// # Errors
/// When the work was cancelled.
pub fn surface(
    points: Vec<DepthPoint>,
    settings: &SurfaceSettings,
    progress: &Progress,
) -> Result<Option<Surface>, Cancelled> {
    let Some((mut made, tin)) = filled(points, settings, progress)? else {
        return Ok(None);
    };
    let between = match settings.method {
        SurfaceMethod::Linear => Some(Between::Linear),
        SurfaceMethod::Natural => Some(Between::NaturalNeighbour),
        SurfaceMethod::InverseDistance => None,
    };
    if let Some(between) = between {
        let cells = (&mut made.depth_m[..], &mut made.spread_m[..]);
        let left_out =
            bend_and_state_error(&made.grid, cells, &made.distance_m, &tin, between, progress)?;
        if let LeftOut::Told(bends) = left_out {
            made.spread_is = Spread::OfError;
            made.bends = bends;
        }
    }
    Ok(Some(made))
}

/// Computes a surface as [`surface()`] does, without bends and stated errors: the spreads are those
/// of the soundings.
///
/// # Errors
/// When the work was cancelled.
pub fn surface_of_depths(
    points: Vec<DepthPoint>,
    settings: &SurfaceSettings,
    progress: &Progress,
) -> Result<Option<Surface>, Cancelled> {
    Ok(filled(points, settings, progress)?.map(|(made, _)| made))
}

/// Returns a surface, and the triangles that it was read from.
fn filled(
    points: Vec<DepthPoint>,
    settings: &SurfaceSettings,
    progress: &Progress,
) -> Result<Option<(Surface, Tin)>, Cancelled> {
    let cell_m = settings.cell_m.or_else(|| suited_cell_m(&points, settings.max_gap_m));
    let Some(grid) = cell_m.and_then(|cell_m| Grid::over(&points, cell_m, settings.max_side))
    else {
        return Ok(None);
    };
    progress.check()?;
    // Soundings nearer to each other than a cell cannot be distinguished in the map.
    let nodes = merge_repeated(&points, grid.cell_m);
    let measured = measured_cells(&points, &grid);
    drop(points);
    progress.check()?;
    let Some(field) = DepthField::new(nodes, settings) else {
        return Ok(None);
    };
    let mut made = field.fill(grid, progress)?;
    made.source = measured;
    settle(&mut made.source, &made.depth_m);
    let known = made.depth_m.iter().any(|depth| !depth.is_nan());
    Ok(known.then_some((made, field.tin)))
}

/// Returns the depth of a cell from nodes with their shares: the mean depth, and the standard
/// deviation of the mixture of the nodes.
fn mean_and_spread_m(nodes: impl Iterator<Item = (Node, f64)> + Clone) -> [f64; 2] {
    let depth_m: f64 = nodes.clone().map(|(node, share)| share * node.depth_m).sum();
    let variance = |node: Node| node.spread_m.powi(2) + (node.depth_m - depth_m).powi(2);
    let variance: f64 = nodes.map(|(node, share)| share * variance(node)).sum();
    [depth_m, variance.max(0.0).sqrt()]
}

/// Nodes, prepared for sampling.
pub(super) struct DepthField {
    method: SurfaceMethod,
    gap_m: f64,
    tin: Tin,
    /// Nodes by place, for the inverse distance method only, which searches for many of them.
    near: Option<(Vec<Node>, Nearest)>,
}

/// Samples a [`DepthField`] in one thread.
struct Sampler<'a> {
    field: &'a DepthField,
    tin: TinSampler<'a>,
    weights: Vec<(usize, f64)>,
}

impl DepthField {
    fn new(nodes: Vec<Node>, settings: &SurfaceSettings) -> Option<Self> {
        let gap_m = settings.max_gap_m;
        let tin = Tin::new(nodes)?.with_max_gap(gap_m);
        let near = match settings.method {
            SurfaceMethod::InverseDistance => {
                let places: Vec<[f64; 2]> = tin.nodes().map(|node| node.place()).collect();
                Some((tin.nodes().collect(), Nearest::of(&places)?))
            }
            _ => None,
        };
        Some(Self { method: settings.method, gap_m, tin, near })
    }

    /// Creates a field of triangles alone, of which none depends on what lies far away
    /// ([`Tin::with_local_triangles`]).
    pub(super) fn local(nodes: Vec<Node>, gap_m: f64) -> Option<Self> {
        let tin = Tin::new(nodes)?.with_max_gap(gap_m);
        Some(Self {
            method: SurfaceMethod::Linear,
            gap_m,
            tin: tin.with_local_triangles(),
            near: None,
        })
    }

    /// Returns a surface with every cell of a grid filled, rows in parallel.
    pub(super) fn fill(&self, grid: Grid, progress: &Progress) -> Result<Surface, Cancelled> {
        let mut made = Surface::unknown(grid, self.method);
        progress.start(grid.rows as u64);
        let columns = grid.columns.max(1);
        made.depth_m
            .par_chunks_mut(columns)
            .zip(made.spread_m.par_chunks_mut(columns))
            .zip(made.distance_m.par_chunks_mut(columns))
            .enumerate()
            .try_for_each(|(row, ((depths_m, spreads_m), distances_m))| {
                progress.check()?;
                let mut sampler = self.sampler();
                for column in 0..depths_m.len() {
                    if let Some(cell) = sampler.cell(grid.centre(row, column)) {
                        [depths_m[column], spreads_m[column], distances_m[column]] = cell;
                    }
                }
                progress.advance(1);
                Ok(())
            })?;
        made.fill_measured(self.tin.nodes());
        Ok(made)
    }

    fn sampler(&self) -> Sampler<'_> {
        let between = match self.method {
            SurfaceMethod::Natural => Between::NaturalNeighbour,
            _ => Between::Linear,
        };
        Sampler { field: self, tin: self.tin.sampler(between), weights: Vec::new() }
    }
}

impl Sampler<'_> {
    /// Returns the depth, its spread and the distance to the nearest sounding at a place, metres.
    fn cell(&mut self, place: [f64; 2]) -> Option<[f32; 3]> {
        let gap_m = self.field.gap_m;
        drop(self.tin.nodes_at(place)?);
        let distance_m = self.tin.distance_m(place);
        if distance_m > gap_m {
            return None;
        }
        let [depth_m, spread_m] = match &self.field.near {
            Some((nodes, nearest)) => {
                nearest.inverse_distance(place, gap_m, &mut self.weights);
                let carried = self.weights.iter();
                mean_and_spread_m(carried.map(|(index, share)| (nodes[*index], *share)))
            }
            None => mean_and_spread_m(self.tin.nodes()),
        };
        Some([depth_m, spread_m, distance_m].map(|metres| metres as f32))
    }
}

#[cfg(test)]
mod tests;
