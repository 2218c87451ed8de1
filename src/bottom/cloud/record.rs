//! Identifies the record of a log that measured a point: the point's time, its boat's place and its
//! exclusion follow from it.

use super::{CloudPoint, PointSource};
use bathyscope_log::survey::{
    ExclusionReason, Exclusions, Navigation, PingNav, Side, Survey, SwathSounding,
};
use std::num::NonZero;

/// Index of a record, stored so that an `Option` of it takes no more room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordIndex(NonZero<u32>);

impl RecordIndex {
    /// Creates the index; `None` beyond four billion.
    pub fn new(index: usize) -> Option<Self> {
        let next = u32::try_from(index).ok()?.checked_add(1)?;
        NonZero::new(next).map(Self)
    }

    /// Returns the index into [`Survey::soundings`] or [`Survey::swath`].
    pub fn get(self) -> usize {
        self.0.get() as usize - 1
    }
}

/// Record of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointRecord {
    /// A side-scan ping, by its index in [`Survey::side_scan`].
    Ping(usize),
    /// A sounding, by its index in [`Survey::soundings`].
    Sounding(usize),
    /// A ping of the swath, by its index in [`Survey::swath`].
    Swath(usize),
}

impl CloudPoint {
    /// Returns the record that measured the point.
    pub fn record(&self) -> PointRecord {
        match (self.source, self.record) {
            (PointSource::DownScan, Some(index)) => PointRecord::Sounding(index.get()),
            (PointSource::Swath, Some(index)) => PointRecord::Swath(index.get()),
            _ => PointRecord::Ping(self.ping as usize),
        }
    }

    /// Returns the side of the boat that the point was measured on; `None` for a sounding under the
    /// boat, and where the log does not have the record of a swath point.
    pub fn side(&self, survey: &Survey) -> Option<Side> {
        match self.source {
            PointSource::DownScan => None,
            PointSource::Port => Some(Side::Port),
            PointSource::Starboard => Some(Side::Starboard),
            PointSource::Swath => self.swath_sounding(survey).map(|sounding| sounding.side),
        }
    }

    /// Returns the depth across the track that the point was made of; `None` for other points.
    pub fn swath_sounding(&self, survey: &Survey) -> Option<SwathSounding> {
        let PointRecord::Swath(index) = self.record() else {
            return None;
        };
        survey.swath_sounding(survey.swath.get(index)?, self.sample as usize)
    }

    /// Returns the index of the sounding that the point was made of; `None` for other points.
    pub fn sounding(&self) -> Option<usize> {
        match self.record() {
            PointRecord::Sounding(index) => Some(index),
            PointRecord::Ping(_) | PointRecord::Swath(_) => None,
        }
    }
}

impl PointRecord {
    /// Returns the seconds after the log's time zero; `None` where the log does not have the
    /// record.
    pub fn time_s(self, survey: &Survey) -> Option<f64> {
        match self {
            Self::Ping(index) => survey.side_scan.get(index).map(|ping| ping.time_s),
            Self::Sounding(index) => survey.soundings.get(index).map(|sounding| sounding.time_s),
            Self::Swath(index) => survey.swath.get(index).map(|ping| ping.time_s),
        }
    }

    /// Returns the place of the boat at the record; `None` where the navigation does not have the
    /// record.
    pub fn place(self, navigation: &Navigation) -> Option<&PingNav> {
        match self {
            Self::Ping(index) => navigation.pings.get(index),
            Self::Sounding(index) => navigation.soundings.get(index),
            Self::Swath(index) => navigation.swath.get(index),
        }
    }

    /// Returns the reason why the record is excluded; `None` where it counts.
    pub fn exclusion(self, exclusions: &Exclusions) -> Option<ExclusionReason> {
        match self {
            Self::Ping(index) => exclusions.ping(index),
            Self::Sounding(index) => exclusions.sounding(index),
            Self::Swath(index) => exclusions.swath(index),
        }
    }
}
