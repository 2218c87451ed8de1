//! Paints tiles of coloured dots, and finds the dot nearest to a place: the points of the cloud,
//! which are the places on the bottom where depths were measured, and the map of residuals, which
//! is every compared point, coloured by its difference from its reference.

use super::tiles::{MapTileKey, SIDE, TilePainter};
use super::transform::{GroundBounds, PlaceBoxes, around};
use crate::app::{SideColours, SwathShown, ThemeChoice, ViewOptions, VisibleLog};
use crate::ui::theme;
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointCloud, PointSource};
use bathyscope_bottom::presentation::colours::{difference_colour, difference_reach_m};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Side;
use bathyscope_products::pipeline::{Agreement, Same};
use egui::Color32;
use std::sync::Arc;

/// Radius of a dot, texels.
const RADIUS: f64 = 1.5;
/// The finest level worth painting, as an exponent of 2 in metres.
const FINEST: i8 = -7;

/// A dot on the ground.
struct Dot {
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
struct Dots {
    dots: Vec<Dot>,
    boxes: PlaceBoxes,
    bounds: GroundBounds,
    colours: Vec<Color32>,
}

impl Dots {
    /// Creates the dots; `None` if no dot has a place. Dots without a place are not painted.
    fn new(dots: Vec<Dot>, colours: Vec<Color32>) -> Option<Self> {
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
    fn nearest(&self, place: [f64; 2], reach_m: f64) -> Option<usize> {
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

/// Inputs of the point layer: the points of each log, and their colours.
pub(super) type PointKey =
    (Vec<(Same<PointCloud>, Same<Vec<PointClass>>)>, (SideColours, ThemeChoice, SwathShown));

/// Returns the key of the points of these logs with their colours.
pub(super) fn point_key(logs: &[VisibleLog], options: &ViewOptions) -> PointKey {
    let key = |shown: &VisibleLog| {
        let products = &shown.log.products;
        (Same(products.cloud.clone()), Same(products.classes.clone()))
    };
    (logs.iter().map(key).collect(), (options.side_colours, options.theme, options.swath))
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
    let kept = logs.iter().flat_map(|shown| shown.log.products.kept_points());
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

/// Largest number of letters of a name in the legend.
const LETTERS: usize = 20;
/// Steps of the colours: an odd number, so that zero difference has a step of its own.
const STEPS: u8 = 255;

/// The points of an agreement, ready to paint and to search.
pub(super) struct ResidualLayer {
    agreement: Arc<Agreement>,
    /// Difference of each dot, metres.
    differences_m: Vec<f32>,
    dots: Arc<Dots>,
    /// Difference, plus or minus, at which the colours end, metres.
    pub reach_m: f64,
}

impl ResidualLayer {
    /// Creates the layer. The colours cover about 95 % of the differences; inner `None` if no point
    /// has a place, outer `None` when cancelled.
    pub(super) fn new(agreement: Arc<Agreement>, progress: &Progress) -> Option<Option<Self>> {
        let p95_m = agreement.comparison.residuals.map(|found| found.p95_m);
        let reach_m = difference_reach_m(p95_m.unwrap_or(0.0));
        let count = agreement.logs.iter().map(|log| log.differences.len()).sum();
        let mut dots = Vec::with_capacity(count);
        let mut differences_m = Vec::with_capacity(count);
        for (index, (cloud, matched)) in agreement.differences().enumerate() {
            if index % CHECK == 0 {
                progress.check().ok()?;
            }
            let point = &cloud.points[matched.measured];
            differences_m.push(matched.difference_m as f32);
            let share = 0.5 + 0.5 * (matched.difference_m / reach_m).clamp(-1.0, 1.0);
            dots.push(Dot {
                east_m: point.east_m,
                north_m: point.north_m,
                colour: (share * f64::from(STEPS - 1)).round() as u8,
            });
        }
        let share = |step: u8| f32::from(step) / f32::from(STEPS - 1);
        let colour = |step: u8| theme::rgb(difference_colour(share(step)));
        let dots = Dots::new(dots, (0..STEPS).map(colour).collect());
        Some(dots.map(|dots| Self { agreement, differences_m, dots: Arc::new(dots), reach_m }))
    }

    /// Returns the painter of the tiles.
    pub(super) fn tiles(&self) -> Arc<dyn TilePainter> {
        self.dots.clone()
    }

    /// Returns the difference from the reference at the point nearest to a place, metres; `None` if
    /// no point is within `reach_m`.
    pub(super) fn at(&self, place: [f64; 2], reach_m: f64) -> Option<f64> {
        let dot = self.dots.nearest(place, reach_m)?;
        self.differences_m.get(dot).copied().map(f64::from)
    }

    /// Returns a note for the legend.
    pub(super) fn note(&self) -> String {
        let what = match &self.agreement.reference {
            Some(reference) => {
                let name = shortened(&reference.name());
                format!("points minus\n{name}")
            }
            None => "side-scan\nminus soundings".to_owned(),
        };
        format!("residual: {what},\nabove 0 is shallower")
    }
}

/// Returns a name, or only its end if it is long.
fn shortened(name: &str) -> String {
    let count = name.chars().count();
    if count > LETTERS {
        format!("…{}", name.chars().skip(count - LETTERS + 1).collect::<String>())
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_bottom::bathymetry::compare::{Comparison, Match, Matching};
    use bathyscope_products::pipeline::{LogDifferences, ResidualTables};

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

    /// Returns points 10 m apart on a line eastwards, each with its difference from a reference.
    fn layer(differences_m: &[f64]) -> ResidualLayer {
        let point = |index: usize| CloudPoint {
            confidence: 1.0,
            sample: 0.0,
            ..CloudPoint::new(PointSource::Port, 0, [10.0 * index as f64, 5.0, -2.0])
        };
        let differences = differences_m.iter().enumerate();
        let differences = differences.map(|(measured, &difference_m)| Match {
            measured,
            reference_z_m: -2.0 - difference_m,
            difference_m,
        });
        let differences: Vec<Match> = differences.collect();
        let agreement = Agreement {
            reference: None,
            matching: Matching::Nearest { radius_m: 1.0 },
            comparison: Comparison::new(differences.len(), &differences, 0.0),
            logs: vec![LogDifferences {
                cloud: Arc::new(PointCloud {
                    points: (0..differences.len()).map(point).collect(),
                    zero_heading: 0,
                }),
                measured: differences.len(),
                differences,
            }],
            tables: ResidualTables {
                by_depth_m: Vec::new(),
                by_across_m: Vec::new(),
                by_heading_deg: Vec::new(),
                histogram: None,
            },
        };
        let layer = ResidualLayer::new(Arc::new(agreement), &Progress::new());
        layer.flatten().expect("points with a place")
    }

    #[test]
    fn the_difference_under_the_pointer_is_shown_and_shallower_is_red() {
        let layer = layer(&[0.3, 0.0, -0.3, 0.01]);
        assert!((layer.reach_m - 0.3).abs() < 1e-12);
        assert_eq!(layer.at([20.4, 5.3], 1.0), Some(f64::from(-0.3_f32)));
        assert_eq!(layer.at([24.9, 5.0], 1.0), None, "none is near");
        let key = MapTileKey { level: -3, column: 0, row: 0 };
        let colours = layer.tiles().paint(key, &Progress::new());
        let colours = colours.expect("points in the tile");
        let ([west_m, north_m], texel_m) = (key.corner(), key.texel_m());
        let [shallower, same, deeper] = [0.0, 10.0, 20.0].map(|east_m| {
            let column = ((east_m - west_m) / texel_m) as usize;
            colours[((north_m - 5.0) / texel_m) as usize * SIDE + column]
        });
        assert!(shallower.r() > 150 && shallower.b() < 60, "{shallower:?}");
        assert!(deeper.b() > 150 && deeper.r() < 80, "{deeper:?}");
        let [r, g, b] = [same.r(), same.g(), same.b()];
        assert!(r == g && g == b, "no difference has no colour: {same:?}");
    }
}
