//! Paints the analyst's own picture in tiles under the other layers.

use super::tiles::{MapTileKey, SIDE, TilePainter, Warp};
use super::transform::{GroundBounds, NOWHERE, joined};
use bathyscope_log::formats::base_map::BaseMap;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Navigation, Survey};
use bathyscope_products::pipeline::Same;
use egui::Color32;
use std::sync::Arc;

/// Largest distance from the survey's origin at which the plane of the survey is used, metres.
const REACH_M: f64 = 300e3;
/// Points along each edge of the picture from which its bounds are computed.
const EDGE: usize = 17;
/// Largest number of samples of the picture along a side of a texel.
const MOST_LOOKS: usize = 3;

/// Inputs of the tiles of a base map.
#[derive(Clone, PartialEq)]
pub(super) struct BaseMapKey {
    map: Same<BaseMap>,
    survey: Same<Survey>,
    navigation: Same<Navigation>,
}

impl BaseMapKey {
    /// Creates the key of a base map in the plane of a survey.
    pub(super) fn new(
        map: &Arc<BaseMap>,
        survey: &Arc<Survey>,
        navigation: &Arc<Navigation>,
    ) -> Self {
        Self {
            map: Same(map.clone()),
            survey: Same(survey.clone()),
            navigation: Same(navigation.clone()),
        }
    }

    /// Returns the painter of the tiles.
    pub(super) fn source(self) -> Arc<dyn TilePainter> {
        let bounds = bounds(&self);
        let pixel_m = self.map.0.pixel_m();
        Arc::new(BaseTiles {
            // Tiles finer than the pixels of the picture show nothing more.
            finest: pixel_m.log2().floor().clamp(-8.0, 20.0) as i8 - 1,
            key: self,
            bounds,
            pixel_m,
        })
    }
}

/// Returns the bounds of the part of the picture near the survey, in the survey's plane.
fn bounds(key: &BaseMapKey) -> GroundBounds {
    let BaseMapKey { map, survey, navigation } = key;
    let near = [-REACH_M, -REACH_M, REACH_M, REACH_M];
    let [columns, rows] = map.0.size.map(f64::from);
    let shares = (0..EDGE).map(|step| step as f64 / (EDGE - 1) as f64);
    let around = shares.flat_map(|share| {
        let (x, y) = (share * columns, share * rows);
        [[x, 0.0], [x, rows], [0.0, y], [columns, y]]
    });
    let places = around.map(|pixel| {
        let at = map.0.place.to_position(pixel);
        navigation.0.to_plane(&survey.0.track, at)
    });
    let [west, south, east, north] = places.fold(NOWHERE, |all, [x, y]| joined(all, [x, y, x, y]));
    // The edges of a picture of half the Earth may be where the plane of the survey is not defined.
    if map.0.covers(survey.0.track.frame.origin()) && east - west > REACH_M {
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
        let map = &self.key.map.0;
        let (survey, navigation) = (&self.key.survey.0, &self.key.navigation.0);
        let warp = Warp::new(key, |[east_m, north_m]| {
            map.place.to_pixels(navigation.to_lon_lat(&survey.track, east_m, north_m))
        });
        let texel = key.texel_m() / self.pixel_m;
        let [low, high] = extent(&warp)?;
        let window = map.window(low, high, texel, progress)?;
        let looks = ((texel / window.scale[0]).ceil() as usize).clamp(1, MOST_LOOKS);
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
