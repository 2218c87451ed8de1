//! Lists objects as rows of tables, and fits shapes to them.

use crate::pipeline::{ProcessedLog, object_shape};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_objects::objects::{ListedObject, Object, ObjectBox, ObjectList};
use bathyscope_objects::targets::{FittedShape, Target};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Shapes of objects, by number; an object without a fitting shape has no entry.
pub(super) type Shapes = BTreeMap<u32, FittedShape>;

/// Fits shapes to the targets of a list.
pub(super) fn find_shapes(
    list: &ObjectList,
    logs: &[ProcessedLog],
    progress: &Progress,
) -> Result<Shapes, Cancelled> {
    let shape = |object: &&Object| {
        progress.check()?;
        let boxes: Vec<(&ProcessedLog, &Target)> = (list.members(object))
            .filter_map(|object_box| Some((logs.get(object_box.log)?, object_box.target.as_ref()?)))
            .collect();
        let shape = object_shape(&boxes).ok();
        Ok(shape.map(|shape| (object.number, shape)))
    };
    let targets: Vec<&Object> = list.targets().collect();
    targets.par_iter().filter_map(|object| shape(object).transpose()).collect()
}

/// Returns objects as rows of tables, with their shapes and outlines.
pub(super) fn listed<'a>(
    objects: impl Iterator<Item = &'a Object>,
    (list, shapes): (&ObjectList, &'a Shapes),
    logs: &[ProcessedLog],
    names: &'a [String],
) -> Vec<ListedObject<'a>> {
    let outline = |object: &Object| {
        let best = list.members(object).nth(object.best)?;
        outline(logs.get(best.log)?, best.target.as_ref()?)
    };
    let listed = objects.map(|object| ListedObject {
        object,
        shape: shapes.get(&object.number),
        outline: outline(object),
        log_names: if names.len() > 1 { names } else { &[] },
    });
    listed.collect()
}

/// Returns the boxes of targets.
pub(super) fn target_boxes(list: &ObjectList) -> Vec<&ObjectBox> {
    list.boxes().iter().filter(|object_box| list.is_target(object_box)).collect()
}

/// Returns the outline of a target in WGS84; `None` where its size is not known.
fn outline(of: &ProcessedLog, target: &Target) -> Option<[LonLat; 4]> {
    let is_known = target.length_m.is_finite() && target.width_m.is_finite();
    let (navigation, track) = (&of.products.navigation, &of.survey.track);
    let place = |[east_m, north_m]: [f64; 2]| navigation.to_lon_lat(track, east_m, north_m);
    is_known.then(|| target.corners().map(place))
}
