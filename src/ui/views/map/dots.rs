//! Paints tiles of coloured dots, finds the dot nearest to a place, and makes dots of the points of
//! the cloud: the places on the bottom where depths were measured.

use super::tiles::{MapTileKey, SIDE, TilePainter};
use super::transform::{GroundBounds, PlaceBoxes, around};
use crate::app::{SideColours, SwathShown, ThemeChoice, ViewOptions, VisibleLog};
use crate::ui::theme;
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointCloud, PointSource};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Side;
use bathyscope_products::pipeline::Same;
use egui::Color32;
use std::sync::Arc;

/// Radius of a dot, texels.
const RADIUS: f64 = 1.5;
/// The finest level worth painting, as an exponent of 2 in metres.
const FINEST: i8 = -7;

/// A dot on the ground.
pub(super) struct Dot {
    pub east_m: f64,
    pub north_m: f64,
    /// Index of the dot's colour.
    pub colour: u8,
}

impl Dot {
    fn place(&self) -> [f64; 2] {
        [self.east_m, self.north_m]
    }

    fn has_place(&self) -> bool {
        self.east_m.is_finite() && self.north_m.is_finite()
    }
}

/// Dots in the order of the track, and their colours.
pub(super) struct Dots {
    dots: Vec<Dot>,
    boxes: PlaceBoxes,
    bounds: GroundBounds,
    colours: Vec<Color32>,
}

impl Dots {
    /// Creates the dots; `None` if no dot has a place. Dots without a place are not painted.
    pub(super) fn new(dots: Vec<Dot>, colours: Vec<Color32>) -> Option<Self> {
        if !dots.iter().any(Dot::has_place) {
            return None;
        }
        Some(Self {
            bounds: around(dots.iter().map(Dot::place)),
            boxes: PlaceBoxes::new(&dots, Dot::place),
            dots,
            colours,
        })
    }

    /// Returns the index of the dot nearest to a place, if one is within `reach_m`.
    pub(super) fn nearest(&self, place: [f64; 2], reach_m: f64) -> Option<usize> {
        Some(self.boxes.nearest(&self.dots, Dot::place, place, reach_m)?.0)
    }
}

impl TilePainter for Dots {
    fn bounds(&self) -> GroundBounds {
        let [west, south, east, north] = self.bounds;
        // A margin, so that a single dot has an extent, too.
        [west - 0.01, south - 0.01, east + 0.01, north + 0.01]
    }

    fn finest(&self) -> i8 {
        FINEST
    }

    fn paint(&self, key: MapTileKey, progress: &Progress) -> Option<Vec<Color32>> {
        let (texel_m, [west_m, north_m]) = (key.texel_m(), key.corner());
        let far = SIDE as f64 + RADIUS;
        let inside = |[west, south, east, north]: &GroundBounds| {
            let across = [(west - west_m) / texel_m, (east - west_m) / texel_m];
            let down = [(north_m - north) / texel_m, (north_m - south) / texel_m];
            [across, down].iter().all(|[low, high]| *low < far && *high > -RADIUS)
        };
        let mut colours = vec![Color32::TRANSPARENT; SIDE * SIDE];
        let mut is_empty = true;
        let chunks = self.dots.chunks(PlaceBoxes::EACH).zip(&self.boxes.boxes);
        for (dots, _) in chunks.filter(|(_, bounds)| inside(bounds)) {
            progress.check().ok()?;
            for dot in dots.iter().filter(|dot| dot.has_place()) {
                let at = [(dot.east_m - west_m) / texel_m, (north_m - dot.north_m) / texel_m];
                let colour = self.colours[usize::from(dot.colour)];
                is_empty &= !ink(&mut colours, at, colour);
            }
        }
        (!is_empty).then_some(colours)
    }
}

/// Draws a round dot with a soft edge; returns true if any of it is in the picture.
fn ink(colours: &mut [Color32], [x, y]: [f64; 2], colour: Color32) -> bool {
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

/// Number of points between two checks for cancellation.
const CHECK: usize = 1 << 14;

/// Inputs of the point layer: the points and their colours.
#[derive(Clone, PartialEq)]
pub(super) struct PointKey {
    logs: Vec<(Same<PointCloud>, Same<Vec<PointClass>>)>,
    side_colours: SideColours,
    theme: ThemeChoice,
    swath: SwathShown,
}

impl PointKey {
    /// Creates the key of the points of these logs with their colours.
    pub(super) fn of(logs: &[VisibleLog], options: &ViewOptions) -> Self {
        let key = |shown: &VisibleLog| {
            let products = &shown.log.products;
            (Same(products.cloud.clone()), Same(products.classes.clone()))
        };
        Self {
            logs: logs.iter().map(key).collect(),
            side_colours: options.side_colours,
            theme: options.theme,
            swath: options.swath,
        }
    }
}

/// Returns a note for the legend; `has_swath` is true if there are points of a swath.
pub(super) fn point_note(options: &ViewOptions, has_swath: bool) -> String {
    let sides = match options.side_colours {
        SideColours::Paper => "points: blue port,\nred starboard",
        SideColours::Maritime => "points: red port,\ngreen starboard",
    };
    if has_swath && options.swath.0 { format!("{sides},\nviolet swath") } else { sides.to_owned() }
}

/// Returns the tiles of all kept points; inner `None` if there is no point, outer `None` when
/// cancelled.
pub(super) fn point_source(
    logs: &[VisibleLog],
    options: &ViewOptions,
    progress: &Progress,
) -> Option<Option<Arc<dyn TilePainter>>> {
    let kept = logs.iter().flat_map(|shown| shown.log.kept_points());
    let is_shown = |point: &&CloudPoint| options.swath.0 || point.source != PointSource::Swath;
    let kept = kept.filter(is_shown);
    let mut dots = Vec::new();
    for (index, point) in kept.enumerate() {
        if index % CHECK == 0 {
            progress.check().ok()?;
        }
        dots.push(Dot { east_m: point.east_m, north_m: point.north_m, colour: source_slot(point) });
    }
    let colours = vec![
        theme::down_scan_colour(options),
        theme::side_colour(options, Side::Port),
        theme::side_colour(options, Side::Starboard),
        theme::SWATH_COLOUR,
    ];
    let dots = Dots::new(dots, colours);
    Some(dots.map(|dots| Arc::new(dots) as Arc<dyn TilePainter>))
}

/// Returns the index of a point's colour.
fn source_slot(point: &CloudPoint) -> u8 {
    match point.source {
        PointSource::DownScan => 0,
        PointSource::Port => 1,
        PointSource::Starboard => 2,
        PointSource::Swath => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(east_m: f64, north_m: f64) -> Dot {
        Dot { east_m, north_m, colour: 1 }
    }

    #[test]
    fn a_dot_on_the_edge_shows_in_both_tiles() {
        let dots = vec![dot(256.0, 10.0), dot(f64::NAN, 10.0), dot(300.0, 10.0)];
        let colours = vec![Color32::WHITE, Color32::BLUE];
        let dots = Dots::new(dots, colours).expect("two with a place");
        let inked = |column: i32| {
            let key = MapTileKey { level: 0, column, row: 0 };
            let painted = dots.paint(key, &Progress::new());
            painted.map(|colours| {
                let row = SIDE - 1 - 11;
                let inked = |texel: &usize| colours[row * SIDE + texel].a() > 128;
                (0..SIDE).filter(inked).collect::<Vec<_>>()
            })
        };
        // With the border, 256 m east is between texels 256 and 257 of the western tile, and
        // between 0 and 1 of the eastern.
        assert_eq!(inked(0), Some(vec![256, 257]));
        assert_eq!(inked(1), Some(vec![0, 1, 44, 45]));
        assert_eq!(inked(2), None);
    }
}
