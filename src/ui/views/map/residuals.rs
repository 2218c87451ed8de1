//! Paints the map of residuals: every compared point, coloured by its difference from its
//! reference.

use super::dots::{Dot, Dots};
use super::tiles::TilePainter;
use bathyscope_bottom::presentation::colours::{difference_colour, difference_reach_m};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::Agreement;
use egui::Color32;
use std::sync::Arc;

/// Number of points between two checks for cancellation.
const CHECK: usize = 1 << 14;
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
        let colour = |step: u8| {
            let [r, g, b] = difference_colour(f32::from(step) / f32::from(STEPS - 1));
            Color32::from_rgb(r, g, b)
        };
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
    use crate::ui::views::map::tiles::{MapTileKey, SIDE};
    use bathyscope_bottom::bathymetry::compare::{Comparison, Match, Matching};
    use bathyscope_bottom::cloud::{CloudPoint, PointCloud, PointSource};
    use bathyscope_products::pipeline::{LogDifferences, ResidualTables};

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
