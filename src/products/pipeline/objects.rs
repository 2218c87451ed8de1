//! The list of objects of processed logs, and the shapes of objects: a solid on the bottom for what
//! the boxes of one log or several show of one object.

use crate::pipeline::{ObjectLocator, ProcessedLog};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_objects::ObjectExtent;
use bathyscope_objects::objects::{ObjectList, SurveyReview};
use bathyscope_objects::targets::{
    BoxLevels, FittedShape, PassLog, ShapeError, Target, TopShape, fit_shape,
};

/// Places the boxes of the logs, and joins those that show one object.
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
        for one in review.boxes(&log.products.exclusions) {
            progress.check()?;
            let top = TopShape::of_class(review.review.class_name(one.class));
            let target = locator.place_as(&one.mark, one.extent, one.shadow, top);
            boxes.push(review.object_box(index, one, target));
            progress.advance(1);
        }
    }
    let pass_logs: Vec<PassLog<'_>> = logs.iter().map(ProcessedLog::pass_log).collect();
    Ok(ObjectList::join(boxes, &pass_logs, &review.numbers))
}

/// The shape of an object by its boxes, each with its log and its place; places of all logs are in
/// one plane. What is drawn as a point has no extent, and tells nothing of a shape.
///
/// # Errors
/// Why it has none.
pub fn object_shape(boxes: &[(&ProcessedLog, &Target)]) -> Result<FittedShape, ShapeError> {
    let sightings: Vec<(&Target, Option<BoxLevels>)> = (boxes.iter())
        .map(|(log, target)| {
            let has_extent = target.extent != ObjectExtent::Point;
            let levels = has_extent.then(|| {
                let locator = ObjectLocator::new(&log.survey, &log.products);
                locator.placer().box_levels(&target.mark)
            });
            (*target, levels.flatten())
        })
        .collect();
    fit_shape(&sightings)
}
