//! Objects on the bottom, with what is known of water and transducer: as the points of the cloud
//! are.

use super::Products;
use bathyscope_bottom::cloud::Correction;
use bathyscope_log::survey::Survey;
use bathyscope_objects::targets::{Placer, Target, TopShape};
use bathyscope_objects::{Mark, MeasuredShadow, ObjectExtent};

/// Places boxes of one survey.
pub struct ObjectLocator<'a> {
    placer: Placer<'a>,
    survey: &'a Survey,
    correction: &'a Correction,
}

impl<'a> ObjectLocator<'a> {
    /// Gets ready for the boxes of a survey.
    pub fn new(survey: &'a Survey, products: &'a Products) -> Self {
        let Products { navigation, returns, calibration, correction, relief, .. } = products;
        let placer = Placer::new(survey, navigation, returns, calibration)
            .with_range_factor(correction.range_factor())
            .with_relief(relief);
        Self { placer, survey, correction }
    }

    /// Returns the place of the object of a box, with its depth below the level that depths count
    /// from; `None` as for [`Placer::place`].
    pub fn place(&self, mark: &Mark) -> Option<Target> {
        self.place_as(mark, ObjectExtent::Found, None, TopShape::Unknown)
    }

    /// Returns the same as [`ObjectLocator::place`], with the extent and shadow that the analyst
    /// has drawn, and the shape that the class states: [`Placer::place_as`].
    pub fn place_as(
        &self,
        mark: &Mark,
        extent: ObjectExtent,
        measured: Option<MeasuredShadow>,
        top: TopShape,
    ) -> Option<Target> {
        let target = self.placer.place_as(mark, extent, measured, top)?;
        let middle = usize::midpoint(mark.pings.start, mark.pings.end);
        let ping = self.survey.side_scan.get(middle)?;
        Some(Target { depth_m: -self.correction.z_m(ping.time_s, target.depth_m), ..target })
    }

    /// The recording.
    pub fn survey(&self) -> &Survey {
        self.survey
    }

    /// Returns the placer, which measures and places boxes as the cloud's points are placed,
    /// without the correction of depths.
    pub fn placer(&self) -> &Placer<'a> {
        &self.placer
    }
}
