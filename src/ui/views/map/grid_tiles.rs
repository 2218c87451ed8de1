//! Paints the tiles of the depth map, of its hill-shade and of the side-scan mosaic, and those of
//! the analyst's own picture under the other layers.

use super::tiles::{MapTileKey, SIDE, TilePainter, Warp};
use super::transform::{GroundBounds, NOWHERE, joined};
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::mosaic::{MosaicSettings, Overlap};
use bathyscope_bottom::presentation::colours::{depth_colour, depth_share};
use bathyscope_log::formats::base_map::BaseMap;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Navigation, Survey};
use bathyscope_products::pipeline::{DepthMap, FINEST, Mosaic, Same};
use egui::Color32;
use std::sync::Arc;

/// Opacity of the depth map at a sounding and at the farthest place from one: less certain depths
/// are fainter.
const OPACITY: [f32; 2] = [0.9, 0.3];
/// Strength with which the hill-shade brightens slopes that face the light, 0 to 1; slopes that
/// face away are multiplied with their shade.
const HIGHLIGHT: f32 = 0.45;
/// Largest number of samples of the surface along a side of a texel that is larger than a cell.
const MOST_LOOKS: usize = 4;
/// Texels along a cell's side beyond which finer tiles show nothing more.
const FINEST_SHARE: f64 = 16.0;

/// Returns the places on the grid of the texels of a tile.
fn warp(depth_map: &DepthMap, key: MapTileKey) -> Warp {
    let grid = &depth_map.surface.grid;
    Warp::new(key, |place| {
        let [easting_m, northing_m] = depth_map.to_map(place);
        [
            (easting_m - grid.west_m) / grid.cell_m - 0.5,
            (grid.north_m - northing_m) / grid.cell_m - 0.5,
        ]
    })
}

/// Returns the colours of all texels, row by row: `colour` gets the mean of the samples that `look`
/// takes within the texel. `None` if all are empty, or when cancelled.
fn paint<const N: usize>(
    depth_map: &DepthMap,
    key: MapTileKey,
    progress: &Progress,
    look: impl Fn([f64; 2]) -> Option<[f32; N]>,
    colour: impl Fn([f32; N]) -> Color32,
) -> Option<Vec<Color32>> {
    let warp = warp(depth_map, key);
    let looks = (key.texel_m() / depth_map.surface.grid.cell_m).ceil() as usize;
    let looks = looks.clamp(1, MOST_LOOKS);
    let mut colours = vec![Color32::TRANSPARENT; SIDE * SIDE];
    let mut is_empty = true;
    for (row, texels) in colours.chunks_exact_mut(SIDE).enumerate() {
        progress.check().ok()?;
        for (column, texel) in texels.iter_mut().enumerate() {
            let mut sums = [0.0; N];
            let mut known = 0;
            for place in warp.places(row, column, looks) {
                if let Some(values) = look(place) {
                    for (sum, value) in sums.iter_mut().zip(values) {
                        *sum += value;
                    }
                    known += 1;
                }
            }
            if known > 0 {
                let share = known as f32 / (looks * looks) as f32;
                *texel = colour(sums.map(|sum| sum / known as f32)).gamma_multiply(share);
                is_empty = false;
            }
        }
    }
    (!is_empty).then_some(colours)
}

/// Returns a value between the centres of cells: linear where all four cells around are known, else
/// that of the nearest cell.
fn between(grid: &Grid, [x, y]: [f64; 2], value: impl Fn(usize) -> Option<f32>) -> Option<f32> {
    let [near_x, near_y] = [x.round(), y.round()];
    let inside = |place: f64, count: usize| place >= 0.0 && place < count as f64;
    if !(inside(near_x, grid.columns) && inside(near_y, grid.rows)) {
        return None;
    }
    let cell = |column: f64, row: f64| row as usize * grid.columns + column as usize;
    let nearest = value(cell(near_x, near_y))?;
    let [left, top] = [x.floor(), y.floor()];
    let whole = inside(left, grid.columns - 1) && inside(top, grid.rows - 1);
    if !whole {
        return Some(nearest);
    }
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
        .map(|(right, down)| value(cell(left + right, top + down)));
    let [Some(a), Some(b), Some(c), Some(d)] = corners else {
        return Some(nearest);
    };
    let [right, down] = [(x - left) as f32, (y - top) as f32];
    let upper = a + (b - a) * right;
    let lower = c + (d - c) * right;
    Some(upper + (lower - upper) * down)
}

fn known(values: &[f32]) -> impl Fn(usize) -> Option<f32> {
    |cell| values.get(cell).copied().filter(|value| !value.is_nan())
}

/// The tiles of the depths in colour, which fade with the distance to a sounding.
pub(super) struct DepthTiles(pub Arc<DepthMap>);

/// The tiles of the hill-shade: black and white, whose opacity is the strength of the shade.
pub(super) struct ShadeTiles(pub Arc<DepthMap>);

fn finest(depth_map: &DepthMap) -> i8 {
    let finest_m = depth_map.surface.grid.cell_m / FINEST_SHARE;
    finest_m.log2().floor().clamp(-128.0, 127.0) as i8
}

impl TilePainter for DepthTiles {
    fn bounds(&self) -> GroundBounds {
        self.0.bounds_m()
    }

    fn finest(&self) -> i8 {
        finest(&self.0)
    }

    fn paint(&self, key: MapTileKey, progress: &Progress) -> Option<Vec<Color32>> {
        let depth_map = &self.0;
        let surface = &depth_map.surface;
        let gap_m = depth_map.gap_m as f32;
        let look = |place| {
            let depth_m = between(&surface.grid, place, known(&surface.depth_m))?;
            let distance_m = between(&surface.grid, place, known(&surface.distance_m))?;
            Some([depth_m, distance_m])
        };
        paint(depth_map, key, progress, look, |[depth_m, distance_m]| {
            let [r, g, b] = depth_colour(depth_share(depth_m, depth_map.colour_range_m));
            // The root makes depths look less certain already a few metres across-track.
            let unsure = (distance_m / gap_m).clamp(0.0, 1.0).sqrt();
            let opacity = OPACITY[0] + (OPACITY[1] - OPACITY[0]) * unsure;
            Color32::from_rgba_unmultiplied(r, g, b, (255.0 * opacity) as u8)
        })
    }
}

impl TilePainter for ShadeTiles {
    fn bounds(&self) -> GroundBounds {
        self.0.bounds_m()
    }

    fn finest(&self) -> i8 {
        finest(&self.0)
    }

    fn paint(&self, key: MapTileKey, progress: &Progress) -> Option<Vec<Color32>> {
        let depth_map = &self.0;
        let level = f32::from(depth_map.light.level_ground());
        let shades = depth_map.shade(progress).ok()?;
        let shade = |cell: usize| match shades.get(cell) {
            Some(0) | None => None,
            Some(shade) => Some(f32::from(*shade)),
        };
        let look = |place| Some([between(&depth_map.surface.grid, place, shade)?]);
        paint(depth_map, key, progress, look, |[shade]| {
            // Level ground leaves the layers below unchanged.
            if shade < level {
                Color32::from_black_alpha((255.0 * (1.0 - shade / level)) as u8)
            } else {
                let lit = (shade - level) / (255.0 - level).max(1.0);
                Color32::from_white_alpha((255.0 * HIGHLIGHT * lit) as u8)
            }
        })
    }
}

/// Returns a note on the mosaic for the legend.
pub(super) fn mosaic_note(settings: &MosaicSettings) -> &'static str {
    match settings.overlap {
        Overlap::Later => "mosaic: later\npass on top",
        Overlap::Brighter => "mosaic: brighter\npass on top",
        Overlap::Middle => "mosaic: middle\nof the swath on top",
        Overlap::Blend => "mosaic: passes\nblended",
    }
}

/// The tiles of a mosaic in its colours.
pub(super) struct MosaicTiles {
    mosaic: Arc<Mosaic>,
    /// Colour of every level of the echo.
    palette: [Color32; 256],
}

impl MosaicTiles {
    /// Creates the tiles of a mosaic in the plane of the survey, in the colours of `settings`.
    pub(super) fn new(mosaic: Arc<Mosaic>, settings: &MosaicSettings) -> Self {
        let colour = |level: usize| {
            let [r, g, b, a] = settings.colours.rgba(level as u8);
            Color32::from_rgba_unmultiplied(r, g, b, a)
        };
        Self { mosaic, palette: std::array::from_fn(colour) }
    }
}

impl TilePainter for MosaicTiles {
    fn bounds(&self) -> GroundBounds {
        self.mosaic.bounds
    }

    fn finest(&self) -> i8 {
        FINEST
    }

    fn paint(&self, key: MapTileKey, progress: &Progress) -> Option<Vec<Color32>> {
        let [west_m, north_m] = key.corner();
        let grid = Grid { west_m, north_m, cell_m: key.texel_m(), columns: SIDE, rows: SIDE };
        let levels = self.mosaic.levels(&grid, progress).ok()?;
        let seen = levels.iter().any(|level| *level > 0);
        seen.then(|| {
            let colour = |level: &u8| self.palette[usize::from(*level)];
            levels.iter().map(colour).collect()
        })
    }
}

/// Largest distance from the survey's origin at which the plane of the survey is used, metres.
const REACH_M: f64 = 300e3;
/// Points along each edge of the picture from which its bounds are computed.
const EDGE: usize = 17;
/// Largest number of samples of the picture along a side of a texel.
const MOST_BASE_LOOKS: usize = 3;

/// Inputs of the tiles of a base map: the map, and the survey in whose plane it is shown.
pub(super) type BaseMapKey = (Same<BaseMap>, Same<Survey>, Same<Navigation>);

/// Returns the painter of the tiles of a base map.
pub(super) fn base_tiles(key: BaseMapKey) -> Arc<dyn TilePainter> {
    let pixel_m = key.0.0.pixel_m();
    Arc::new(BaseTiles {
        // Tiles finer than the pixels of the picture show nothing more.
        finest: pixel_m.log2().floor().clamp(-8.0, 20.0) as i8 - 1,
        bounds: bounds(&key),
        key,
        pixel_m,
    })
}

/// Returns the bounds of the part of the picture near the survey, in the survey's plane.
fn bounds((Same(map), Same(survey), Same(navigation)): &BaseMapKey) -> GroundBounds {
    let near = [-REACH_M, -REACH_M, REACH_M, REACH_M];
    let [columns, rows] = map.size.map(f64::from);
    let shares = (0..EDGE).map(|step| step as f64 / (EDGE - 1) as f64);
    let around = shares.flat_map(|share| {
        let (x, y) = (share * columns, share * rows);
        [[x, 0.0], [x, rows], [0.0, y], [columns, y]]
    });
    let places = around.map(|pixel| {
        let at = map.place.to_position(pixel);
        navigation.to_plane(&survey.track, at)
    });
    let [west, south, east, north] = places.fold(NOWHERE, |all, [x, y]| joined(all, [x, y, x, y]));
    // The edges of a picture of half the Earth may be where the plane of the survey is not defined.
    if map.covers(survey.track.frame.origin()) && east - west > REACH_M {
        near
    } else {
        [west.max(near[0]), south.max(near[1]), east.min(near[2]), north.min(near[3])]
    }
}

struct BaseTiles {
    key: BaseMapKey,
    bounds: GroundBounds,
    finest: i8,
    pixel_m: f64,
}

impl TilePainter for BaseTiles {
    fn bounds(&self) -> GroundBounds {
        self.bounds
    }

    fn finest(&self) -> i8 {
        self.finest
    }

    fn paint(&self, key: MapTileKey, progress: &Progress) -> Option<Vec<Color32>> {
        let (Same(map), Same(survey), Same(navigation)) = &self.key;
        let warp = Warp::new(key, |[east_m, north_m]| {
            map.place.to_pixels(navigation.to_lon_lat(&survey.track, east_m, north_m))
        });
        let texel = key.texel_m() / self.pixel_m;
        let [low, high] = extent(&warp)?;
        let window = map.window(low, high, texel, progress)?;
        let looks = ((texel / window.scale[0]).ceil() as usize).clamp(1, MOST_BASE_LOOKS);
        let mut colours = Vec::with_capacity(SIDE * SIDE);
        for row in 0..SIDE {
            progress.check().ok()?;
            colours.extend((0..SIDE).map(|column| {
                let looks = warp.places(row, column, looks);
                mean(looks.map(|place| window.at(place)))
            }));
        }
        let seen = colours.iter().any(|colour| colour.a() > 0);
        seen.then_some(colours)
    }
}

/// Returns least and greatest column and row of the picture under a tile; `None` if one of them is
/// no finite number.
fn extent(warp: &Warp) -> Option<[[f64; 2]; 2]> {
    let last = SIDE - 1;
    let edge = (0..=8).map(|step| step * last / 8);
    let around = edge.flat_map(|at| [[at, 0], [at, last], [0, at], [last, at]]);
    let places = around.flat_map(|[row, column]| warp.places(row, column, 2));
    let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    let found = places.fold(start, |[low, high], place| {
        [
            [low[0].min(place[0]), low[1].min(place[1])],
            [high[0].max(place[0]), high[1].max(place[1])],
        ]
    });
    let mut edges = found.iter().flatten();
    edges.all(|edge| edge.is_finite()).then_some(found)
}

/// Returns the mean colour, each colour weighted by its opacity.
fn mean(looks: impl Iterator<Item = [u8; 4]>) -> Color32 {
    let (mut sum, mut count) = ([0u32; 4], 0);
    for [r, g, b, a] in looks {
        let opaque = u32::from(a);
        for (sum, value) in sum.iter_mut().zip([r, g, b, 255]) {
            *sum += u32::from(value) * opaque;
        }
        count += 255;
    }
    let [r, g, b, a] = sum.map(|sum| (sum / count.max(1)) as u8);
    Color32::from_rgba_premultiplied(r, g, b, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_linear_between_cells_and_end_with_them() {
        let grid = Grid { west_m: 0.0, north_m: 0.0, cell_m: 1.0, columns: 3, rows: 2 };
        let values = [0.0, 1.0, 2.0, 10.0, 11.0, f32::NAN];
        let at = |x, y| between(&grid, [x, y], known(&values));
        assert_eq!(at(0.25, 0.5), Some(5.25));
        assert_eq!(at(1.4, 0.4), Some(1.0), "a corner is unknown: the nearest");
        assert_eq!(at(1.6, 0.9), None);
        assert_eq!(at(-0.4, 0.0), Some(0.0), "to the edge of the outer cell");
        assert_eq!(at(-0.6, 0.0), None);
    }
}
