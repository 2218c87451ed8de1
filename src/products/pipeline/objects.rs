//! Computes the places of objects on the bottom, corrected as the points of the cloud are; the list
//! of objects of processed logs; and the shapes of objects: a solid on the bottom from the boxes of
//! one object in one log or several.

use super::{ProcessedLog, Products};
use bathyscope_bottom::cloud::Correction;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Survey;
use bathyscope_objects::objects::{ObjectList, SurveyReview};
use bathyscope_objects::targets::{
    BoxLevels, FittedShape, PassLog, Placer, ShapeError, Target, TopShape, fit_shape,
};
use bathyscope_objects::{Mark, MeasuredShadow, ObjectExtent};

/// Locator of the boxes of one survey.
pub struct ObjectLocator<'a> {
    /// Measures and places boxes as the cloud's points are placed, without the correction of
    /// depths.
    pub placer: Placer<'a>,
    /// Survey of the boxes.
    pub survey: &'a Survey,
    correction: &'a Correction,
}

impl<'a> ObjectLocator<'a> {
    /// Creates a locator for the boxes of a survey.
    pub fn new(survey: &'a Survey, products: &'a Products) -> Self {
        let Products { navigation, returns, calibration, correction, relief, .. } = products;
        let factor = correction.range_factor();
        let placer = Placer::new(survey, navigation, returns, calibration, factor, relief);
        Self { placer, survey, correction }
    }

    /// Returns the place of the object of a box, with its depth below the level from which depths
    /// count; `None` as for [`Placer::place`].
    pub fn place(&self, mark: &Mark) -> Option<Target> {
        self.place_as(mark, ObjectExtent::Found, None, TopShape::Unknown)
    }

    /// Returns the place as [`ObjectLocator::place`] does, with the extent and shadow that the
    /// analyst has drawn, and the top shape of the class: [`Placer::place`].
    pub fn place_as(
        &self,
        mark: &Mark,
        extent: ObjectExtent,
        measured: Option<MeasuredShadow>,
        top: TopShape,
    ) -> Option<Target> {
        let target = self.placer.place(mark, extent, measured, top)?;
        let middle = usize::midpoint(mark.pings.start, mark.pings.end);
        let ping = self.survey.side_scan.get(middle)?;
        Some(Target { depth_m: -self.correction.z_m(ping.time_s, target.depth_m), ..target })
    }
}

/// Places the boxes of the logs, and joins the boxes of one object.
///
/// # Errors
/// When the work was cancelled.
pub fn list_objects(
    logs: &[ProcessedLog],
    review: &SurveyReview,
    progress: &Progress,
) -> Result<ObjectList, Cancelled> {
    let mut boxes = Vec::new();
    for (index, (log, review)) in logs.iter().zip(&review.logs).enumerate() {
        let Some(review) = review else {
            continue;
        };
        let locator = ObjectLocator::new(&log.survey, &log.products);
        for review_box in review.boxes(&log.products.exclusions) {
            progress.check()?;
            let top = TopShape::of_class(review.review.class_name(review_box.class));
            let target =
                locator.place_as(&review_box.mark, review_box.extent, review_box.shadow, top);
            boxes.push(review.object_box(index, review_box, target));
            progress.advance(1);
        }
    }
    let pass_logs: Vec<PassLog<'_>> = logs.iter().map(ProcessedLog::pass_log).collect();
    Ok(ObjectList::join(boxes, &pass_logs, &review.numbers))
}

/// Fits the shape of an object to its boxes, each with its log and its place; places of all logs
/// are in one plane. A box drawn as a point has no extent, and does not contribute to the shape.
///
/// # Errors
/// The reason why the object has no shape.
pub fn object_shape(boxes: &[(&ProcessedLog, &Target)]) -> Result<FittedShape, ShapeError> {
    let sightings: Vec<(&Target, Option<BoxLevels>)> = (boxes.iter())
        .map(|(log, target)| {
            let has_extent = target.extent != ObjectExtent::Point;
            let levels = has_extent.then(|| {
                let locator = ObjectLocator::new(&log.survey, &log.products);
                locator.placer.box_levels(&target.mark)
            });
            (*target, levels.flatten())
        })
        .collect();
    fit_shape(&sightings)
}
