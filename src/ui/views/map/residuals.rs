//! The map of residuals: every compared point, coloured by how it differs from its reference.

use super::dots::{Dot, Dots};
use super::tiles::TileSource;
use crate::pipeline::Agreement;
use crate::progress::Progress;
use crate::render::{diverging_colour, diverging_reach_m};
use egui::Color32;
use std::sync::Arc;

/// Points between two looks at whether the work was cancelled.
const CHECK: usize = 1 << 14;
/// Letters of a name that a legend has room for.
const LETTERS: usize = 20;
/// Steps of the colours: odd, so that no difference has a step of its own.
const STEPS: u8 = 255;

/// The points of an agreement, ready to paint and to search.
pub struct ResidualLayer {
    agreement: Arc<Agreement>,
    dots: Arc<Dots>,
    /// The colours end at plus and minus this, metres.
    pub reach_m: f64,
}

impl ResidualLayer {
    /// The colours reach as far as 95 % of the differences do, more or less; inner `None` where no point has a place, outer when
    /// cancelled.
    pub fn new(agreement: Arc<Agreement>, progress: &Progress) -> Option<Option<Self>> {
        let p95_m = agreement.comparison.residuals.map(|found| found.p95_m);
        let reach_m = diverging_reach_m(p95_m.unwrap_or(0.0));
        let mut dots = Vec::with_capacity(agreement.differences.len());
        for (index, one) in agreement.differences.iter().enumerate() {
            if index % CHECK == 0 {
                progress.check().ok()?;
            }
            let point = &agreement.cloud.points[one.measured];
            let share = 0.5 + 0.5 * (one.difference_m / reach_m).clamp(-1.0, 1.0);
            dots.push(Dot {
                east_m: point.east_m,
                north_m: point.north_m,
                colour: (share * f64::from(STEPS - 1)).round() as u8,
            });
        }
        let colour = |step: u8| {
            let [r, g, b] = diverging_colour(f32::from(step) / f32::from(STEPS - 1));
            Color32::from_rgb(r, g, b)
        };
        let dots = Dots::new(dots, (0..STEPS).map(colour).collect());
        Some(dots.map(|dots| Self {
            agreement,
            dots: Arc::new(dots),
            reach_m,
        }))
    }

    /// What paints it.
    pub fn tiles(&self) -> Arc<dyn TileSource> {
        self.dots.clone()
    }

    /// How the point nearest to a place differs from its reference, if one is within `reach_m`, metres.
    pub fn at(&self, place: [f64; 2], reach_m: f64) -> Option<f64> {
        let dot = self.dots.nearest(place, reach_m)?;
        let found = self.agreement.differences.get(dot)?;
        Some(found.difference_m)
    }

    /// What the legend says.
    pub fn note(&self) -> String {
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

/// A name whose end stands for all of it where it is long.
fn shortened(name: &str) -> String {
    let count = name.chars().count();
    match count > LETTERS {
        true => format!(
            "…{}",
            name.chars().skip(count - LETTERS + 1).collect::<String>()
        ),
        false => name.to_owned(),
    }
}
