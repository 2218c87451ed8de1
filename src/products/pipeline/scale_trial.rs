//! Computes the effect of another scale on a log before any setting is changed.

use super::Products;
use bathyscope_bottom::calibration::{
    self, Calibration, CalibrationSettings, FlatSpot, PingRange, RangeAtDepth, ScaleMode,
};
use bathyscope_bottom::cloud::{self, DepthChange, PickTraits, Residuals};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Survey;

/// Scale that a stretch of pings gives, and its effect.
#[derive(Clone, Debug)]
pub struct ScaleTrial {
    /// Stretch of pings and its scale.
    pub spot: FlatSpot,
    /// Objections to the scale, in sentences.
    pub objections: Vec<String>,
    /// Ranges of the first returns of the whole log at recorded depths, by the recorder's scale.
    pub points: Vec<RangeAtDepth>,
    /// Effect of the scale on the depths; `None` if the stretch gives no scale, or the log has no
    /// side-scan depths.
    pub effect: Option<ScaleEffect>,
}

/// Effect of another scale on the depths of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleEffect {
    /// Change of the depths.
    pub change: DepthChange,
    /// Elevation of side-scan points minus that of the soundings of the same pings, with the
    /// present scale and with the other; `None` without soundings.
    pub residuals: Option<[Residuals; 2]>,
}

impl ScaleTrial {
    /// Computes the scale that a stretch of pings gives, and its effect on a log with its results.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        survey: &Survey,
        products: &Products,
        pings: PingRange,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let returns = products.judged_returns(survey);
        let stretch = pings.start..pings.end;
        let spot = calibration::stretch(survey, &products.navigation, &returns, stretch);
        let objections = spot.objections(survey, products.flat_spots.first());
        progress.check()?;
        let points = calibration::ranges_at_depths(survey, &returns);
        let effect = match spot.ppd {
            Some(_) => {
                let settings = CalibrationSettings {
                    mode: ScaleMode::FlatSpot,
                    pings: Some(pings),
                    ..products.settings.calibration.clone()
                };
                let made = products.calibrated(survey, &returns, &settings, progress)?;
                effect(survey, products, &made, progress)?
            }
            None => None,
        };
        Ok(Self { spot, objections, points, effect })
    }
}

/// Computes the effect of a calibration from the points that result from it.
fn effect(
    survey: &Survey,
    products: &Products,
    calibration: &Calibration,
    progress: &Progress,
) -> Result<Option<ScaleEffect>, Cancelled> {
    let (before, classes) = (&products.cloud, &products.classes);
    let counted = products.counted_returns();
    let settings = &products.settings.cloud;
    let traits = PickTraits::new(survey, &products.navigation, &counted);
    let counted = (&*counted, &traits);
    let after = products.placed(survey, counted, calibration, settings, progress)?;
    let change = DepthChange::between(before, classes, &after);
    // The same first returns give the same number of points, each of which keeps its class.
    let is_alike = after.points.len() == before.points.len();
    let of = |cloud| cloud::residuals(survey, cloud, &products.correction, classes);
    let then = is_alike.then(|| of(&after)).flatten();
    let residuals = of(before).zip(then).map(|(now, then)| [now, then]);
    Ok(change.map(|change| ScaleEffect { change, residuals }))
}
