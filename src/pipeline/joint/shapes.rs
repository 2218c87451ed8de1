//! Shapes of objects: a solid on the bottom for what the boxes of one log or several show of one object.

use crate::detection::ObjectExtent;
use crate::detection::targets::{BoxLevels, FittedShape, ShapeError, Target, fit_shape};
use crate::pipeline::{Placing, ProcessedLog};

/// The shape of an object by its boxes, each with its log and its place; places of all logs are in one plane. What is drawn as a point has
/// no extent, and tells nothing of a shape.
///
/// # Errors
/// Why it has none.
pub fn object_shape(boxes: &[(&ProcessedLog, &Target)]) -> Result<FittedShape, ShapeError> {
    let sightings: Vec<(&Target, Option<BoxLevels>)> = (boxes.iter())
        .map(|(log, target)| {
            let has_extent = target.extent != ObjectExtent::Point;
            let levels = has_extent.then(|| {
                let placing = Placing::new(&log.survey, &log.products);
                placing.placer().box_levels(&target.mark)
            });
            (*target, levels.flatten())
        })
        .collect();
    fit_shape(&sightings)
}
