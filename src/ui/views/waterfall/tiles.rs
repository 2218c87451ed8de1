//! Chooses the visible tiles, and what is drawn in place of tiles that are not ready.

use super::lens::Lens;
use crate::app::Orientation;
use crate::ui::render::waterfall::{DrawnTile, Quad, TILE_ROWS, TileRow, TileRows, TileTexture};
use bathyscope_bottom::picture::{LogPicture, PictureGeometry};
use bathyscope_bottom::waterfall::{
    Level, Lru, RangeAxis, TILE, Want, WaterfallTile, WaterfallTileKey,
};
use bathyscope_log::survey::Side;
use bathyscope_products::pipeline::Same;
use std::ops::Range;
use std::sync::Arc;

/// Bytes of tiles kept on the GPU: a 4K screen at the worst zoom needs 80 MB.
const BUDGET: usize = 96 << 20;

const _: () = assert!(TILE == TILE_ROWS, "a row of a tile has its place in its rows");
/// Values of a row that shows its echoes as recorded, while the log has no [`LogPicture`] yet.
const AS_RECORDED: TileRow = [0.0, 1.0, 0.0, 1.0];

/// A tile on the GPU and how complete it is.
pub(super) struct Resident {
    pub texture: TileTexture,
    /// Values of the rows of the tile for the shown picture of the log; `None` until the tile is
    /// drawn with it.
    rows: Option<TileRows>,
    pub completeness: u8,
    /// Number of rows of the tile.
    pub height: usize,
}

/// The tiles of one survey that were drawn recently.
pub(super) struct ResidentTiles {
    cache: Lru<WaterfallTileKey, Resident>,
    /// Picture that the rows of the tiles belong to; `None` without one.
    rows_of: Option<Same<LogPicture>>,
}

/// The plan of one frame: the tiles to draw, and those to request from the worker.
pub(super) struct FramePlan {
    pub draw: Vec<(Quad, DrawnTile)>,
    pub want: Vec<Want>,
}

impl ResidentTiles {
    pub(super) fn new() -> Self {
        Self { cache: Lru::new(BUDGET), rows_of: None }
    }

    pub(super) fn insert(&mut self, tile: &WaterfallTile, texture: TileTexture) {
        let resident =
            Resident { texture, rows: None, completeness: tile.completeness, height: tile.height };
        self.cache.insert(tile.key, resident, tile.byte_count());
    }

    /// Marks the tiles that reach beyond the unchanged pings as incomplete, so that they are made
    /// again; drops all tiles if no ping is unchanged.
    pub(super) fn outdate(&mut self, unchanged: Option<usize>) {
        match unchanged {
            Some(unchanged) => self.cache.change(|key, resident| {
                if key.end_ping() > unchanged {
                    resident.completeness = 0;
                }
            }),
            None => self.cache = Lru::new(BUDGET),
        }
    }

    /// Drops the rows of all tiles if another picture is shown, so that they are made again.
    pub(super) fn level_by(&mut self, picture: Option<&Arc<LogPicture>>) {
        let of = picture.cloned().map(Same);
        if self.rows_of != of {
            self.rows_of = of;
            self.cache.change(|_, resident| resident.rows = None);
        }
    }

    /// Chooses the tiles that the lens shows. `pixels_per_point` determines how fine they must be.
    pub(super) fn plan(
        &mut self,
        axis: &RangeAxis,
        lens: &Lens,
        pixels_per_point: f32,
        mut upload: impl FnMut(&[TileRow; TILE_ROWS]) -> TileRows,
    ) -> FramePlan {
        self.cache.begin_frame();
        let picture = self.rows_of.clone();
        let picture = picture.as_ref().map(|picture| &*picture.0);
        let scale = LensScale::new(axis, lens, picture, pixels_per_point);
        let mut plan = FramePlan { draw: Vec::new(), want: Vec::new() };
        for key in scale.keys_in_view() {
            self.plan_tile(&scale, key, &mut plan, &mut upload);
        }
        let level = axis.coarsest();
        for side in Side::BOTH {
            self.want(WaterfallTileKey { side, level, column: 0, row: 0 }, &mut plan);
        }
        plan
    }

    fn plan_tile(
        &mut self,
        scale: &LensScale<'_>,
        key: WaterfallTileKey,
        plan: &mut FramePlan,
        mut upload: impl FnMut(&[TileRow; TILE_ROWS]) -> TileRows,
    ) {
        self.want(key, plan);
        let Some(area) = scale.area(&key, &scale.whole(key.side)) else {
            return;
        };
        let Some(shown) = self.nearest(scale, key) else {
            return;
        };
        if let Some(resident) = self.cache.use_now(&shown)
            && let Some(area) = scale.area(
                &shown,
                &area.until(shown.first_ping() + resident.height * shown.level.pings()),
            )
        {
            let upload = || upload(&scale.rows(&shown));
            let tile = DrawnTile {
                texture: resident.texture.clone(),
                rows: resident.rows.get_or_insert_with(upload).clone(),
            };
            plan.draw.push((scale.quad(&shown, &area), tile));
        }
    }

    fn want(&self, key: WaterfallTileKey, plan: &mut FramePlan) {
        let have = self.cache.peek(&key).map(|resident| resident.completeness);
        if have != Some(WaterfallTile::COMPLETE) && plan.want.iter().all(|want| want.key != key) {
            plan.want.push(Want { key, have });
        }
    }

    /// Returns the tile itself, or else the finest coarser tile that covers it.
    fn nearest(&self, scale: &LensScale<'_>, key: WaterfallTileKey) -> Option<WaterfallTileKey> {
        let coarsest = scale.axis.coarsest();
        let most = Level {
            along: coarsest.along.saturating_sub(key.level.along),
            across: coarsest.across.saturating_sub(key.level.across),
        };
        (0..=most.along + most.across)
            .flat_map(|sum| (0..=sum.min(most.along)).map(move |along| (along, sum - along)))
            .filter(|(_, across)| *across <= most.across)
            .map(|(along, across)| WaterfallTileKey {
                level: Level { along: key.level.along + along, across: key.level.across + across },
                column: key.column >> along,
                row: key.row >> across,
                ..key
            })
            .find(|key| self.cache.peek(key).is_some())
    }
}

/// Pings and bins that a quad covers.
struct QuadArea {
    pings: Range<f64>,
    bins: Range<f64>,
}

impl QuadArea {
    /// Returns the area without the pings from `ping` on, which a tile lacks if the log has grown
    /// since.
    fn until(&self, ping: usize) -> Self {
        Self { pings: self.pings.start..self.pings.end.min(ping as f64), bins: self.bins.clone() }
    }
}

/// The lens in units of pings and bins instead of points and metres.
struct LensScale<'a> {
    axis: &'a RangeAxis,
    lens: &'a Lens,
    picture: Option<&'a LogPicture>,
    pings_per_pixel: f64,
    bins_per_pixel: f64,
    level: Level,
}

impl<'a> LensScale<'a> {
    fn new(
        axis: &'a RangeAxis,
        lens: &'a Lens,
        picture: Option<&'a LogPicture>,
        pixels_per_point: f32,
    ) -> Self {
        let pixels_per_point = f64::from(pixels_per_point);
        let pings_per_pixel = lens.pings_per_point() / pixels_per_point;
        let bins_per_pixel = lens.metres_per_point() / axis.bin_m / pixels_per_point;
        // Texels are no larger than a pixel; the shader averages the one to two that a pixel
        // covers.
        let halvings = |per_pixel: f64| (per_pixel + 1e-6).log2().floor().clamp(0.0, 40.0) as u8;
        let level = axis
            .drawable(Level { along: halvings(pings_per_pixel), across: halvings(bins_per_pixel) });
        Self { axis, lens, picture, pings_per_pixel, bins_per_pixel, level }
    }

    /// Returns the area of a side that the lens shows, within the survey.
    fn whole(&self, side: Side) -> QuadArea {
        let shown = self.lens.seen_of(side);
        let [near_m, far_m] = self.recorded_m([shown.start, shown.end]);
        let seen = self.lens.pings();
        QuadArea {
            pings: seen.start.max(0.0)..seen.end.min(self.axis.pings as f64),
            bins: if shown.is_empty() {
                0.0..0.0
            } else {
                (near_m / self.axis.bin_m).max(0.0)
                    ..(far_m / self.axis.bin_m).min(f64::from(self.axis.bins))
            },
        }
    }

    /// Returns the least and the greatest recorded range that any ping shows between two distances
    /// from the middle, metres.
    fn recorded_m(&self, shown_m: [f64; 2]) -> [f64; 2] {
        match (self.lens.geometry(), self.picture) {
            (PictureGeometry::Slant, _) | (_, None) => shown_m,
            (geometry, Some(picture)) => picture.extremes.recorded_m(geometry, shown_m),
        }
    }

    /// Returns the distances from the middle, within the view, between which pings show two
    /// recorded ranges of a side, metres.
    fn shown_m(&self, side: Side, recorded_m: [f64; 2]) -> [f64; 2] {
        match (self.lens.geometry(), self.picture) {
            (PictureGeometry::Slant, _) | (_, None) => recorded_m,
            (geometry, Some(picture)) => {
                let [near_m, far_m] = picture.extremes.across_m(geometry, recorded_m);
                let seen = self.lens.seen_of(side);
                [near_m.max(seen.start), far_m.min(seen.end).max(seen.start)]
            }
        }
    }

    /// Returns the visible tiles, those nearest to the middle of the view first.
    fn keys_in_view(&self) -> Vec<WaterfallTileKey> {
        let tiles = |extent: &Range<f64>, step: usize| {
            let size = (TILE * step) as f64;
            (extent.start / size).floor() as u32..(extent.end / size).ceil().max(0.0) as u32
        };
        let mut keys = Vec::new();
        for side in Side::BOTH {
            let seen = self.whole(side);
            for column in tiles(&seen.pings, self.level.pings()) {
                for row in tiles(&seen.bins, self.level.bins()) {
                    keys.push(WaterfallTileKey { side, level: self.level, column, row });
                }
            }
        }
        let pings = self.lens.pings();
        let middle = (pings.start + pings.end) / 2.0 / (TILE * self.level.pings()) as f64 - 0.5;
        keys.sort_by(|a, b| {
            let far = |key: &WaterfallTileKey| (f64::from(key.column) - middle).abs();
            far(a).total_cmp(&far(b))
        });
        keys
    }

    /// Returns the part of `limits` that a tile covers; `None` if it covers none.
    fn area(&self, key: &WaterfallTileKey, limits: &QuadArea) -> Option<QuadArea> {
        let clip = |first: usize, step: usize, limits: &Range<f64>| {
            let (first, last) = (first as f64, (first + TILE * step) as f64);
            let clipped = first.max(limits.start)..last.min(limits.end);
            (clipped.start < clipped.end).then_some(clipped)
        };
        Some(QuadArea {
            pings: clip(key.first_ping(), key.level.pings(), &limits.pings)?,
            bins: clip(key.first_bin(), key.level.bins(), &limits.bins)?,
        })
    }

    fn quad(&self, key: &WaterfallTileKey, area: &QuadArea) -> Quad {
        let seen = self.lens.pings();
        let metres = self.lens.metres();
        let share = |value: f64, seen: &Range<f64>| (value - seen.start) / (seen.end - seen.start);
        let along = [area.pings.start, area.pings.end].map(|ping| {
            let share = share(ping, &seen);
            if self.lens.is_flipped() { 1.0 - share } else { share }
        });
        let bin_m = self.axis.bin_m;
        let shown_m = self.shown_m(key.side, [area.bins.start * bin_m, area.bins.end * bin_m]);
        let across = shown_m.map(|shown_m| share(self.lens.signed_m(key.side, shown_m), &metres));
        let right = |share: f64| (2.0 * share - 1.0) as f32;
        let down = |share: f64| (1.0 - 2.0 * share) as f32;
        let (along, across) = match self.lens.orientation {
            Orientation::Horizontal => (along.map(right), across.map(down)),
            Orientation::Vertical => (along.map(down), across.map(right)),
        };
        let texels = |range: &Range<f64>, first: usize, step: usize| {
            [range.start, range.end].map(|value| ((value - first as f64) / step as f64) as f32)
        };
        Quad {
            along,
            across,
            rows: texels(&area.pings, key.first_ping(), key.level.pings()),
            columns: texels(&area.bins, key.first_bin(), key.level.bins()),
            footprint: [
                (self.bins_per_pixel / key.level.bins() as f64) as f32,
                (self.pings_per_pixel / key.level.pings() as f64) as f32,
            ],
            across_m: shown_m.map(|metres| metres as f32),
            column_m: [
                (key.first_bin() as f64 * bin_m) as f32,
                (key.level.bins() as f64 * bin_m) as f32,
            ],
            side: u32::from(key.side == Side::Starboard),
        }
    }

    /// Returns altitude, gain and stripe factor of each row of a tile, with which the shader evens
    /// the rows.
    fn rows(&self, key: &WaterfallTileKey) -> [TileRow; TILE_ROWS] {
        std::array::from_fn(|row| {
            let first = key.first_ping() + row * key.level.pings();
            let pings = first..first + key.level.pings();
            self.picture.map_or(AS_RECORDED, |picture| picture.row(key.side, pings))
        })
    }
}
