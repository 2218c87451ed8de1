//! The truth in the survey's raster.

use super::Truth;
use crate::detection::dataset::{Chip, Known};
use crate::detection::{Raster, class_index, metrics};
use crate::progress::{Cancelled, Progress};
use crate::survey::{Side, Survey};
use rayon::prelude::*;
use std::sync::Arc;

/// The objects of a truth as boxes in the pixels of a raster.
#[derive(Clone, Debug)]
pub struct LaidTruth {
    pub(super) truth: Arc<Truth>,
    /// Boxes to the two sides, and which object each is.
    pub(super) sides: [Vec<(metrics::Truth, usize)>; 2],
}

impl LaidTruth {
    /// Lays the objects out. Those that do not stand out in a tile around them, by the rule by which a detector is taught
    /// ([`Chip::new`]), are marked to be ignored unless somebody saw them.
    ///
    /// # Errors
    /// When cancelled.
    pub fn new(
        survey: &Survey,
        raster: &Raster,
        truth: Arc<Truth>,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        progress.start(truth.objects.len() as u64);
        let laid: Vec<metrics::Truth> = truth
            .objects
            .par_iter()
            .map(|known| {
                progress.check()?;
                let ignored = !truth.was_seen && !is_seen(survey, raster, known);
                progress.advance(1);
                Ok(metrics::Truth {
                    class: known.class,
                    rect: raster.rect_of(&known.whole),
                    ignored,
                })
            })
            .collect::<Result<_, Cancelled>>()?;
        let on = |side: Side| {
            let all = laid.iter().zip(&truth.objects).enumerate();
            all.filter(|(_, (_, known))| known.whole.side == side)
                .map(|(object, (laid, _))| (*laid, object))
                .collect()
        };
        Ok(Self {
            sides: Side::BOTH.map(on),
            truth,
        })
    }

    /// The two sides as pictures with nothing proposed yet. Classes are those of `classes`, the same where their names are;
    /// those that only the truth has are added to them.
    pub fn images(&self, classes: &mut Vec<String>) -> [metrics::Image; 2] {
        let names = self.truth.classes.iter();
        let class_of: Vec<usize> = names.map(|name| class_index(classes, name)).collect();
        [0, 1].map(|side: usize| {
            let of_side = self.sides[side].iter();
            metrics::Image {
                truth: of_side
                    .map(|(one, _)| metrics::Truth {
                        class: class_of.get(one.class).copied().unwrap_or(usize::MAX),
                        ..*one
                    })
                    .collect(),
                predicted: Vec::new(),
            }
        })
    }

    /// What was laid out.
    pub fn truth(&self) -> &Arc<Truth> {
        &self.truth
    }
}

fn is_seen(survey: &Survey, raster: &Raster, known: &Known) -> bool {
    let [row, column] = raster.start_about(&raster.rect_of(&known.whole));
    let tile = raster.tile(survey, known.whole.side, row, column);
    let chip = Chip::new(tile, raster, std::slice::from_ref(known));
    !chip.boxes.labels.is_empty()
}
