//! The boxes of a survey as rows of tables, and the objects that they are sightings of, over all logs.

use crate::detection::review::{Confidence, Review, State};
use crate::detection::targets::{FittedShape, GroupSettings, PassLog, Target};
use crate::detection::{Detection, Mark};
use crate::pipeline::joint::{JointObject, PlacedBox, joint_objects, object_shape};
use crate::pipeline::{Placing, ProcessedLog, Products};
use crate::products::export::{ObjectPoint, ObjectRow};
use crate::products::outputs::OutputError;
use crate::support::geo::LonLat;
use crate::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::sync::Arc;

/// Boxes of all logs, and the objects that they show.
#[derive(Default)]
pub struct ObjectRows<'a> {
    /// A row a box; those of one object have its number.
    pub rows: Vec<ObjectRow<'a>>,
    /// The objects, number 1 first: members count the rows.
    pub objects: Vec<JointObject>,
}

impl<'a> ObjectRows<'a> {
    /// Adds what a model found in a log, numbered on from what is there.
    pub fn add_found(
        &mut self,
        log: usize,
        of: &ProcessedLog,
        names: &'a [String],
        found: &'a [Detection],
    ) {
        let placing = placing(of);
        let first = self.rows.len() as u32 + 1;
        let rows = (first..).zip(found).map(|(id, one)| {
            let target = placing.place(&one.mark);
            ObjectRow {
                log,
                id,
                class: names.get(one.class).map_or("", String::as_str),
                score: Some(one.score),
                state: State::Proposed.name(),
                mark: &one.mark,
                outline: target.as_ref().and_then(|target| outline(of, target)),
                target,
                object: None,
                shape: None,
                note: "",
                name: "",
                confidence: "",
            }
        });
        self.rows.extend(rows);
    }

    /// Adds the boxes of a log's review but those in stretches that are left out.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn add_reviewed(
        &mut self,
        log: usize,
        of: &ProcessedLog,
        review: &'a Review,
        progress: &Progress,
    ) -> Result<(), OutputError> {
        let placing = placing(of);
        let boxes = review.boxes();
        for one in boxes.filter(|one| !is_left_out(&of.products, &one.mark)) {
            progress.check()?;
            let target = placing.place_as(&one.mark, one.extent, one.shadow);
            self.rows.push(ObjectRow {
                log,
                id: one.id.0,
                class: review.class_name(one.class),
                score: one.score,
                state: one.state.name(),
                mark: &one.mark,
                outline: target.as_ref().and_then(|target| outline(of, target)),
                target,
                object: None,
                shape: None,
                note: &one.note,
                name: &one.name,
                confidence: one.confidence.map_or("", Confidence::name),
            });
            progress.advance(1);
        }
        Ok(())
    }

    /// Makes one object of the sightings of it in all logs, and gives them its number. As long as nobody has decided about any box, every
    /// proposal is a sighting; then those are that were accepted or added.
    pub fn group(&mut self) {
        let proposed = State::Proposed.name();
        let is_decided = self.rows.iter().any(|row| row.state != proposed);
        let (members, boxes): (Vec<usize>, Vec<PlacedBox<'_>>) = (self.rows.iter())
            .enumerate()
            .filter(|(_, row)| !is_decided || is_decided_object(row.state))
            .filter_map(|(index, row)| {
                let placed = PlacedBox {
                    log: row.log,
                    class: row.class,
                    score: row.score,
                    target: row.target.as_ref()?,
                };
                Some((index, placed))
            })
            .unzip();
        let mut objects = joint_objects(&boxes, &GroupSettings::default());
        for (number, object) in (1..).zip(&mut objects) {
            for member in &mut object.members {
                *member = members[*member];
                self.rows[*member].object = Some(number);
            }
        }
        self.objects = objects;
    }

    /// Leaves the boxes that an analyst accepted or added, and their objects.
    pub fn retain_decided(&mut self) {
        self.rows.retain(|row| is_decided_object(row.state));
        self.group();
    }

    /// The objects as points of a map.
    pub fn points(&self, logs: &[ProcessedLog]) -> Vec<ObjectPoint> {
        let Some(ProcessedLog { survey, products }) = logs.first() else {
            return Vec::new();
        };
        let pass_logs: Vec<PassLog<'_>> = logs.iter().map(pass_log).collect();
        let point = |(number, object): (usize, &JointObject)| {
            let boxes: Vec<&ObjectRow<'_>> = (object.members.iter())
                .map(|member| &self.rows[*member])
                .collect();
            let [east_m, north_m] = object.place_m;
            let place = products
                .navigation
                .to_lon_lat(&survey.track, east_m, north_m);
            Some(ObjectPoint {
                class: object.class.clone(),
                position: place,
                sigma_m: object.sigma_m,
                height: object.height,
                sightings: object.sightings(&pass_logs),
                ..ObjectPoint::new(number, &boxes)?
            })
        };
        (1..).zip(&self.objects).filter_map(point).collect()
    }

    /// The shapes of the objects, in their order.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn find_shapes(
        &self,
        logs: &[ProcessedLog],
        progress: &Progress,
    ) -> Result<Shapes, Cancelled> {
        let shape = |object: &JointObject| {
            progress.check()?;
            let members = object.members.iter().map(|member| &self.rows[*member]);
            let boxes: Vec<(&ProcessedLog, &Target)> = members
                .filter_map(|row| Some((logs.get(row.log)?, row.target.as_ref()?)))
                .collect();
            Ok(object_shape(&boxes).ok().map(Arc::new))
        };
        self.objects.par_iter().map(shape).collect()
    }

    /// Gives every sighting of an object its shape.
    pub fn set_shapes(&mut self, shapes: &Shapes) {
        for (object, shape) in self.objects.iter().zip(shapes) {
            for member in &object.members {
                self.rows[*member].shape.clone_from(shape);
            }
        }
    }
}

/// Whether a state says that an analyst accepted or added the box.
fn is_decided_object(state: &str) -> bool {
    [State::Accepted, State::Added]
        .map(State::name)
        .contains(&state)
}

/// A log whose passes are counted.
pub(super) fn pass_log(log: &ProcessedLog) -> PassLog<'_> {
    (&log.survey, &log.products.navigation)
}

/// The shape of each object; `None` of one that has none.
pub type Shapes = Vec<Option<Arc<FittedShape>>>;

/// The footprint in WGS84; `None` where the size is not known.
fn outline(of: &ProcessedLog, target: &Target) -> Option<[LonLat; 4]> {
    let is_known = target.length_m.is_finite() && target.width_m.is_finite();
    let (navigation, track) = (&of.products.navigation, &of.survey.track);
    let place = |[east_m, north_m]: [f64; 2]| navigation.to_lon_lat(track, east_m, north_m);
    is_known.then(|| target.corners().map(place))
}

fn placing(of: &ProcessedLog) -> Placing<'_> {
    Placing::new(&of.survey, &of.products)
}

/// Whether the middle of a box lies in a stretch that is left out.
pub fn is_left_out(products: &Products, mark: &Mark) -> bool {
    let middle = usize::midpoint(mark.pings.start, mark.pings.end);
    products.left_out.ping(middle).is_some()
}
