//! Converts samples and recorded depths to metres, by the calibration and the corrections in force:
//! the only place where this is done, for the points of the cloud and for every read-out, line and
//! axis.
//!
//! Slant ranges are those of the picture as calibrated, by the true speed of sound. Depths count
//! from the [`DepthReference`].

use super::correction::DepthReference;
use super::{CloudPoint, Correction, PointRecord};
use crate::calibration::Calibration;
use bathyscope_log::survey::{Side, SideSpan, Survey};

/// Conversion of the recorder's samples and depths to ranges and depths. The default leaves both as
/// recorded.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reduction<'a> {
    calibration: Option<&'a Calibration>,
    correction: Option<&'a Correction>,
}

impl<'a> Reduction<'a> {
    /// Creates the conversion by a calibration and a correction.
    pub fn new(calibration: &'a Calibration, correction: &'a Correction) -> Self {
        Self { calibration: Some(calibration), correction: Some(correction) }
    }

    /// Returns the slant range at a distance of `sample` samples outward from the nearest edge of a
    /// recorded side, metres.
    pub fn range_m(&self, span: &SideSpan, sample: f64) -> f64 {
        let calibrated_m = match self.calibration {
            Some(calibration) => calibration.range_m(span, sample),
            None => span.range_m(sample),
        };
        self.factor() * calibrated_m
    }

    /// Returns the slant range of a sample of a ping, metres; NaN where that side was not recorded.
    pub fn range_at_m(&self, survey: &Survey, ping: usize, side: Side, sample: f32) -> f64 {
        survey.span(ping, side).map_or(f64::NAN, |span| self.range_m(span, f64::from(sample)))
    }

    /// Returns the slant range at which a point of the cloud was measured, metres: for a sounding
    /// the distance straight below, for a swath point the straight distance to its place. NaN where
    /// the log does not have the point's record.
    pub fn point_range_m(&self, survey: &Survey, point: &CloudPoint) -> f64 {
        let recorded_m = match (point.record(), point.side(survey)) {
            (PointRecord::Ping(ping), Some(side)) => {
                return self.range_at_m(survey, ping, side, point.sample);
            }
            (PointRecord::Ping(_), None) => None,
            (PointRecord::Sounding(index), _) => {
                let sounding = survey.soundings.get(index);
                sounding.map(|sounding| f64::from(sounding.depth_m))
            }
            (PointRecord::Swath(_), _) => {
                let sounding = point.swath_sounding(survey);
                sounding.map(|sounding| sounding.out_m.hypot(sounding.depth_m))
            }
        };
        recorded_m.map_or(f64::NAN, |recorded_m| self.altitude_m(recorded_m))
    }

    /// Returns the sample at a slant range: the inverse of [`Reduction::range_m`].
    pub fn sample_at(&self, span: &SideSpan, range_m: f64) -> f64 {
        // Every scale is linear in the sample.
        let start_m = self.range_m(span, 0.0);
        let step_m = self.range_m(span, 1.0) - start_m;
        (range_m - start_m) / step_m
    }

    /// Returns a slant range on the recorder's own scale, by which the picture is drawn, metres.
    pub fn recorded_range_m(&self, span: &SideSpan, range_m: f64) -> f64 {
        span.range_m(self.sample_at(span, range_m))
    }

    /// Returns the altitude for a recorded depth, metres: the distance from the transducer down to
    /// the bottom.
    pub fn altitude_m(&self, recorded_m: f64) -> f64 {
        self.factor() * recorded_m
    }

    /// Returns the depth for a depth recorded at a time of the log, metres below
    /// [`Reduction::reference`].
    pub fn depth_m(&self, time_s: f64, recorded_m: f64) -> f64 {
        match self.correction {
            Some(correction) => correction.depth_m(time_s, recorded_m),
            None => recorded_m,
        }
    }

    /// Returns the depth of a bottom `altitude_m` below the transducer at a time of the log, metres
    /// below [`Reduction::reference`].
    pub fn depth_below_m(&self, time_s: f64, altitude_m: f64) -> f64 {
        self.depth_m(time_s, altitude_m / self.factor())
    }

    /// Returns the reference that depths count from.
    pub fn reference(&self) -> DepthReference {
        self.correction.map_or(DepthReference::Transducer, Correction::reference)
    }

    /// Returns the reference that depths count from in words, with the levelling to the depths of
    /// other logs where there is one.
    pub fn reference_name(&self) -> String {
        let name = self.reference().name();
        match self.correction.map_or(0.0, Correction::height_offset_m) {
            0.0 => name.to_owned(),
            // A height that is added to elevations is subtracted from depths.
            offset_m => format!("{name}, levelled by {:+.2} m", -offset_m),
        }
    }

    fn factor(&self) -> f64 {
        self.correction.map_or(1.0, Correction::range_factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloud::DepthSettings;
    use crate::cloud::correction::SoundSpeedSettings;

    #[test]
    fn a_range_comes_back_to_its_sample_and_a_depth_names_what_it_counts_from() {
        let span = SideSpan::of_bytes(1000, [0.5, 20.5]);
        let calibration = Calibration { offset_m: -0.05, ..Calibration::default() };
        let settings = DepthSettings {
            draft_m: 0.3,
            sound_speed: SoundSpeedSettings { m_s: Some(1470.0), ..SoundSpeedSettings::default() },
            ..DepthSettings::default()
        };
        let correction = Correction::new(settings, &Survey::default());
        let reduction = Reduction::new(&calibration, &correction);
        // Sample 100 begins 2.5 m out by the header; 5 cm more as calibrated, and 2 % less by the
        // speed of sound.
        let range_m = reduction.range_m(&span, 100.0);
        assert!((range_m - 0.98 * 2.55).abs() < 1e-9, "{range_m}");
        assert!((reduction.sample_at(&span, range_m) - 100.0).abs() < 1e-9);
        assert!((reduction.recorded_range_m(&span, range_m) - 2.5).abs() < 1e-6);
        assert!((reduction.altitude_m(2.0) - 1.96).abs() < 1e-12);
        assert!((reduction.depth_m(0.0, 2.0) - 2.26).abs() < 1e-12);
        assert_eq!(reduction.reference().name(), "below surface");
        let recorded = Reduction::default();
        assert_eq!(recorded.depth_m(0.0, 2.0), 2.0);
        assert_eq!(recorded.range_m(&span, 100.0), 2.5);
        assert_eq!(recorded.reference().name(), "below transducer");
    }
}
