//! The points of the cloud from above: where on the ground depths were heard.

use super::tiles::{SIDE, TileKey, TileSource};
use super::transform::GroundBounds;
use crate::app::{SideColours, ThemeChoice, ViewOptions};
use crate::cloud::{CloudPoint, PointCloud, PointSource};
use crate::pipeline::Products;
use crate::progress::Progress;
use crate::survey::Side;
use crate::ui::theme;
use crate::ui::views::background::Same;
use egui::Color32;
use std::sync::Arc;

/// Points in a box that tells whether they need to be looked at. A boat cannot jump: those in a row lie close together.
const BOXED: usize = 512;
/// Radius of a point, texels.
const RADIUS: f64 = 1.5;
/// The finest level worth painting, 2 to this in metres.
const FINEST: i8 = -7;
/// Points between two looks at whether the work was cancelled.
const CHECK: usize = 1 << 14;

/// What the points are drawn from, and in which colours.
#[derive(Clone, PartialEq)]
pub struct PointKey {
    cloud: Same<PointCloud>,
    kept: Same<Vec<bool>>,
    side_colours: SideColours,
    theme: ThemeChoice,
}

impl PointKey {
    /// Of the last results.
    pub fn of(products: &Products, options: &ViewOptions) -> Self {
        Self {
            cloud: Same(products.cloud.clone()),
            kept: Same(products.kept.clone()),
            side_colours: options.side_colours,
            theme: options.theme,
        }
    }
}

/// What the legend says.
pub fn note(colours: SideColours) -> &'static str {
    match colours {
        SideColours::Paper => "points: blue port,\nred starboard",
        SideColours::Maritime => "points: red port,\ngreen starboard",
    }
}

/// The tiles of all kept points; inner `None` where there is none, outer when cancelled.
pub fn source(
    products: &Products,
    options: &ViewOptions,
    progress: &Progress,
) -> Option<Option<Arc<dyn TileSource>>> {
    let flagged = products.cloud.points.iter().zip(products.kept.iter());
    let kept = flagged
        .filter(|(point, kept)| **kept && point.east_m.is_finite() && point.north_m.is_finite());
    let mut places = Vec::new();
    for (index, (point, _)) in kept.enumerate() {
        if index % CHECK == 0 {
            progress.check().ok()?;
        }
        places.push(Place {
            east_m: point.east_m,
            north_m: point.north_m,
            colour: source_slot(point),
        });
    }
    if places.is_empty() {
        return Some(None);
    }
    let boxes = places.chunks(BOXED).map(around).collect();
    Some(Some(Arc::new(PointTiles {
        bounds: around(&places),
        boxes,
        places,
        colours: [
            theme::down_scan_colour(options),
            theme::side_colour(options, Side::Port),
            theme::side_colour(options, Side::Starboard),
        ],
    })))
}

/// Index of a point's colour.
fn source_slot(point: &CloudPoint) -> u8 {
    match point.source {
        PointSource::DownScan => 0,
        PointSource::Port => 1,
        PointSource::Starboard => 2,
    }
}

struct Place {
    east_m: f64,
    north_m: f64,
    /// Index of its colour.
    colour: u8,
}

/// West, south, east and north of some places.
fn around(places: &[Place]) -> GroundBounds {
    let start = [f64::MAX, f64::MAX, f64::MIN, f64::MIN];
    places
        .iter()
        .fold(start, |[west, south, east, north], place| {
            [
                west.min(place.east_m),
                south.min(place.north_m),
                east.max(place.east_m),
                north.max(place.north_m),
            ]
        })
}

struct PointTiles {
    places: Vec<Place>,
    /// Around every [`BOXED`] places.
    boxes: Vec<GroundBounds>,
    bounds: GroundBounds,
    colours: [Color32; 3],
}

impl TileSource for PointTiles {
    fn bounds(&self) -> GroundBounds {
        let [west, south, east, north] = self.bounds;
        // A single place has an extent too.
        [west - 0.01, south - 0.01, east + 0.01, north + 0.01]
    }

    fn finest(&self) -> i8 {
        FINEST
    }

    fn paint(&self, key: TileKey, progress: &Progress) -> Option<Vec<Color32>> {
        let (texel_m, [west_m, north_m]) = (key.texel_m(), key.corner());
        let far = SIDE as f64 + RADIUS;
        let inside = |[west, south, east, north]: &GroundBounds| {
            let across = [(west - west_m) / texel_m, (east - west_m) / texel_m];
            let down = [(north_m - north) / texel_m, (north_m - south) / texel_m];
            [across, down]
                .iter()
                .all(|[low, high]| *low < far && *high > -RADIUS)
        };
        let mut colours = vec![Color32::TRANSPARENT; SIDE * SIDE];
        let mut is_empty = true;
        let chunks = self.places.chunks(BOXED).zip(&self.boxes);
        for (places, _) in chunks.filter(|(_, bounds)| inside(bounds)) {
            progress.check().ok()?;
            for place in places {
                let at = [
                    (place.east_m - west_m) / texel_m,
                    (north_m - place.north_m) / texel_m,
                ];
                let colour = self.colours[usize::from(place.colour)];
                is_empty &= !dot(&mut colours, at, colour);
            }
        }
        (!is_empty).then_some(colours)
    }
}

/// Draws a round point with a soft edge; whether any of it lies in the picture.
fn dot(colours: &mut [Color32], [x, y]: [f64; 2], colour: Color32) -> bool {
    let span = |place: f64| {
        let low = (place - RADIUS - 0.5).ceil().max(0.0) as usize;
        let high = (place + RADIUS + 0.5).floor().max(0.0) as usize;
        low..high.min(SIDE)
    };
    let mut is_seen = false;
    for row in span(y) {
        for column in span(x) {
            let off = (column as f64 + 0.5 - x).hypot(row as f64 + 0.5 - y);
            let cover = (RADIUS + 0.5 - off).clamp(0.0, 1.0) as f32;
            if cover > 0.0 {
                let texel = &mut colours[row * SIDE + column];
                *texel = texel.blend(colour.gamma_multiply(cover));
                is_seen = true;
            }
        }
    }
    is_seen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_on_the_edge_shows_in_both_tiles() {
        let place = |east_m: f64| Place {
            east_m,
            north_m: 10.0,
            colour: 1,
        };
        let places = vec![place(256.0), place(300.0)];
        let tiles = PointTiles {
            bounds: around(&places),
            boxes: places.chunks(BOXED).map(around).collect(),
            places,
            colours: [Color32::WHITE, Color32::BLUE, Color32::RED],
        };
        let inked = |column: i32| {
            let key = TileKey {
                level: 0,
                column,
                row: 0,
            };
            let painted = tiles.paint(key, &Progress::new());
            painted.map(|colours| {
                let row = SIDE - 1 - 11;
                let inked = |texel: &usize| colours[row * SIDE + texel].a() > 128;
                (0..SIDE).filter(inked).collect::<Vec<_>>()
            })
        };
        // With the border, 256 m east lies between texels 256 and 257 of the western tile, and 0 and 1 of the eastern.
        assert_eq!(inked(0), Some(vec![256, 257]));
        assert_eq!(inked(1), Some(vec![0, 1, 44, 45]));
        assert_eq!(inked(2), None);
    }
}
