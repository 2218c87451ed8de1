//! Makes the 3D point cloud of soundings under the boat, first returns beside it and depths across
//! the track, and filters outliers.
//!
//! In: a survey with its navigation, first returns and calibration. Out: points with classes, and
//! the depth under the boat at every ping.
//!
//! `build` makes the points, also those of depths across the track, decides which soundings with a
//! fault count, and finds the properties of each first return (`above_bottom` or `clutter`, and how
//! strong its echo is). It uses `specular` for the foot on a slope and the published feet, and
//! `correction` for the reference of depths. `reduction` joins the correction to the calibration
//! for every read-out; `class` decides the class of each point, `outliers` is the filter for any
//! points; `ping_depth` finds the depth under the boat, `residuals` measures agreement with
//! recorded depths and between clouds, and the ends of the scales by which points are coloured.

mod above_bottom;
mod build;
mod class;
mod clutter;
pub mod correction;
pub mod outliers;
mod ping_depth;
mod reduction;
mod residuals;
mod specular;

pub use build::{PickTraits, build, place};
pub use class::{ClassCounts, ClassRules, PointClass, classify};
pub use clutter::Clutter;
pub use correction::{Correction, DepthReference, DepthSettings};
pub use ping_depth::{DepthSource, PingDepth, TrackShare, clear_excluded_depths, ping_depths};
pub use reduction::Reduction;
pub use residuals::{DepthChange, PointScales, Residuals, residuals, same_ping_differences};
pub use specular::{across_track, fixed_bottom_point};

use crate::first_return::ground_confidence;
use bathyscope_log::named;
use bathyscope_log::survey::{
    ExclusionReason, Exclusions, Navigation, PingNav, Side, SoundingFault, Survey, SwathSounding,
};
use serde::{Deserialize, Serialize};
use std::num::NonZero;
use std::ops::Index;
use std::sync::Arc;

/// Method that places a first return.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Geometry {
    /// `z = r cos(alpha_2)`, `y = r sin(alpha_2)`, as printed in the paper.
    Published,
    /// The published geometry, with `PPD` measured so that the depth at the flat spot is
    /// reproduced.
    SelfConsistent,
    /// `z = r`, `y = 0`: the first return is straight below.
    Nadir,
    /// The specular point: the first return lies where the bottom is square to the beam. The slope
    /// of the bottom comes from the difference of the two sides.
    Slope,
}

/// `cloud.*` settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CloudSettings {
    /// Method that places a first return.
    pub geometry: Geometry,
    /// Angle of the first return from the vertical, degrees; 16 in the published code.
    pub alpha2_deg: f64,
    /// Recorded depths that are kept.
    pub down_scan: DownScan,
}

/// Recorded depths that belong to the cloud.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DownScan {
    /// All, as published.
    All,
    /// Depths at which the recorder had the bottom; the others are points of the class
    /// [`PointClass::NoBottom`].
    #[default]
    Locked,
}

impl Default for CloudSettings {
    fn default() -> Self {
        Self { geometry: Geometry::Slope, alpha2_deg: 16.0, down_scan: DownScan::Locked }
    }
}

/// `outliers.*` settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OutlierSettings {
    /// Radius of the sphere around a point, metres.
    pub radius_m: f64,
    /// A point is kept when the sphere holds more than this many points, itself included (Open3D's
    /// legacy rule).
    pub min_neighbors: usize,
}

impl Default for OutlierSettings {
    fn default() -> Self {
        Self { radius_m: 3.011, min_neighbors: 10 }
    }
}

/// Measurement that a point comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PointSource {
    /// The recorder's own depth.
    DownScan,
    /// The first return to port.
    Port,
    /// The first return to starboard.
    Starboard,
    /// A depth across the track that the recorder measured.
    Swath,
}

named! {
    /// All sources, in the order of points in a cloud.
    pub PointSource {
        DownScan: "downscan",
        Port: "port",
        Starboard: "starboard",
        Swath: "swath",
    }
}

impl PointSource {
    /// Returns true if the source is a first return of the side-scan.
    pub fn is_side_scan(self) -> bool {
        matches!(self, Self::Port | Self::Starboard)
    }
}

/// Evidence that a point is not the bottom.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PointDoubt {
    /// There is none.
    #[default]
    None,
    /// The point is an above-bottom return: its pick lies above the recorded depth
    /// ([`crate::first_return::Pick::above_bottom`]) by more than this depth departs from the bed
    /// nearby.
    AboveBottom,
    /// A sounding has this fault and is not kept. A sounding that a first return confirms has none,
    /// nor has any with [`DownScan::All`].
    Fault(SoundingFault),
}

/// Share by which the slope that a first return lies on ends before the nadir, in steps of 1/254: a
/// point with a number of four bytes would be eight bytes larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlopeEnd(u8);

impl SlopeEnd {
    /// Value of a point that lies up no slope.
    pub(crate) const NO_SLOPE: Self = Self(u8::MAX);
    /// Number of steps from 0 to 1.
    const STEPS: f32 = 254.0;

    /// Returns the value nearest to a share, 0 to 1: 0 where the slope goes on under the boat, 1
    /// where the bottom is level there.
    pub(crate) fn of(share: f64) -> Self {
        Self((Self::STEPS * share as f32).round() as u8)
    }

    /// Returns the share, 0 to 1; NaN for a point that lies up no slope.
    pub fn share(self) -> f32 {
        if self == Self::NO_SLOPE { f32::NAN } else { f32::from(self.0) / Self::STEPS }
    }
}

/// Point of a cloud, and its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPoint {
    /// Measurement that the point comes from.
    pub source: PointSource,
    /// Index of the side-scan ping; for other points that of the side-scan ping nearest in time (0
    /// in a log without side-scan).
    pub ping: u32,
    /// Index of the sounding for down-scan points, and of the ping of the swath for swath points
    /// ([`CloudPoint::record`]); `None` for other points.
    pub record: Option<RecordIndex>,
    /// Evidence that the point is not the bottom.
    pub doubt: PointDoubt,
    /// Share by which the slope that a first return lies on ends before the nadir.
    pub slope_end: SlopeEnd,
    /// Level of the echo of a first return: the greatest recorded level, 0 to 255, from the pick to
    /// 0.2 m of slant range beyond it; 0 for other points, whose level is not known. Samples of two
    /// bytes are scaled to one, as everywhere.
    pub level: u8,
    /// Length of track over which most first returns of its side lie above the recorded depth as
    /// this point does, metres; 0 where it does not, and where it is too high to be ground.
    pub above_bottom_m: f32,
    /// The confidence of the first return ([`crate::first_return::Pick::confidence`]); NaN for
    /// other points.
    pub confidence: f32,
    /// First return in u8 samples outward; for a swath point the number of its depth in its ping;
    /// NaN for a sounding.
    pub sample: f32,
    /// Metres east of the survey's origin.
    pub east_m: f64,
    /// Metres north of the survey's origin.
    pub north_m: f64,
    /// Elevation, metres: negative below the transducer, or below the reference that [`Correction`]
    /// makes depths count from.
    pub z_m: f64,
}

/// All points of a log, before the outlier filter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointCloud {
    /// Soundings first, then port and starboard in ping order, then the swath.
    pub points: BySource<CloudPoint>,
    /// Number of pings that gave no side-scan point because they have no heading.
    pub zero_heading: usize,
}

impl PointCloud {
    /// Returns the side-scan points of a ping, port first.
    pub fn of_ping(&self, ping: usize) -> impl Iterator<Item = &CloudPoint> {
        let sides = [PointSource::Port, PointSource::Starboard];
        sides.into_iter().flat_map(move |source| {
            let points = self.points.of(source);
            let first = points.partition_point(|point| (point.ping as usize) < ping);
            let points = points[first..].iter();
            points.take_while(move |point| point.ping as usize == ping)
        })
    }

    /// Returns the cloud without the points of records that are excluded.
    #[must_use]
    pub fn without(self, exclusions: &Exclusions) -> Self {
        if exclusions.is_empty() {
            return self;
        }
        let counts = |point: &&CloudPoint| point.record().exclusion(exclusions).is_none();
        let counted = |source| self.points.of(source).iter().filter(counts).copied();
        Self { points: BySource::from_parts(|source| Arc::new(counted(source).collect())), ..self }
    }

    /// Returns the points that count for the map, with their index; `classes` holds the class of
    /// each point.
    pub fn kept<'a>(
        &'a self,
        classes: &'a [PointClass],
    ) -> impl Iterator<Item = (usize, &'a CloudPoint)> + Clone + use<'a> {
        let classed = self.points.iter().zip(classes).enumerate();
        classed.filter_map(|(index, (point, class))| class.is_kept().then_some((index, point)))
    }
}

impl CloudPoint {
    /// Creates a point at east, north and up, metres, that has neither a record, a fault nor an
    /// echo.
    pub fn new(source: PointSource, ping: u32, [east_m, north_m, z_m]: [f64; 3]) -> Self {
        Self {
            source,
            ping,
            record: None,
            doubt: PointDoubt::None,
            slope_end: SlopeEnd::NO_SLOPE,
            level: 0,
            above_bottom_m: 0.0,
            confidence: f32::NAN,
            sample: f32::NAN,
            east_m,
            north_m,
            z_m,
        }
    }

    /// Returns east, north and elevation, metres.
    pub fn place(&self) -> [f64; 3] {
        [self.east_m, self.north_m, self.z_m]
    }

    /// Returns true for an above-bottom return.
    pub fn is_above_bottom(&self) -> bool {
        self.doubt == PointDoubt::AboveBottom
    }

    /// Returns the fault for which a sounding is not kept.
    pub fn fault(&self) -> Option<SoundingFault> {
        match self.doubt {
            PointDoubt::Fault(fault) => Some(fault),
            PointDoubt::None | PointDoubt::AboveBottom => None,
        }
    }

    /// Returns the confidence of the point if it is bottom although it lies above the recorded
    /// depth, as in a long stretch; any other point has its own confidence.
    pub fn ground_confidence(&self) -> f32 {
        ground_confidence(self.confidence, self.is_above_bottom())
    }

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

/// Entries by their source, in the order of [`PointSource`] and numbered through all parts. All
/// copies share the parts; each part can grow without the others being moved.
#[derive(Clone, Debug, PartialEq)]
pub struct BySource<T>([Arc<Vec<T>>; PointSource::ALL.len()]);

impl<T> Default for BySource<T> {
    fn default() -> Self {
        Self(Default::default())
    }
}

impl<T> BySource<T> {
    /// Creates the list from the entries of each source, made by `part`.
    pub fn from_parts(part: impl FnMut(PointSource) -> Arc<Vec<T>>) -> Self {
        Self(PointSource::ALL.map(part))
    }

    /// Returns the entries of one source.
    pub fn of(&self, source: PointSource) -> &Arc<Vec<T>> {
        &self.0[source as usize]
    }

    /// Returns the number of the first entry of a source.
    pub fn start(&self, source: PointSource) -> usize {
        let before = &self.0[..source as usize];
        before.iter().map(|part| part.len()).sum()
    }

    /// Returns the number of entries of all sources.
    pub fn len(&self) -> usize {
        self.0.iter().map(|part| part.len()).sum()
    }

    /// Returns true if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the entry with a number.
    pub fn get(&self, mut number: usize) -> Option<&T> {
        for part in &self.0 {
            match part.get(number) {
                Some(entry) => return Some(entry),
                None => number -= part.len(),
            }
        }
        None
    }

    /// Returns all entries in the order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = &T> + Clone {
        let [down_scan, port, starboard, swath] = &self.0;
        let sides = port.iter().chain(starboard.iter());
        down_scan.iter().chain(sides).chain(swath.iter())
    }
}

impl FromIterator<CloudPoint> for BySource<CloudPoint> {
    fn from_iter<I: IntoIterator<Item = CloudPoint>>(points: I) -> Self {
        let mut parts: [Vec<CloudPoint>; PointSource::ALL.len()] = Default::default();
        for point in points {
            parts[point.source as usize].push(point);
        }
        Self(parts.map(Arc::new))
    }
}

impl<T> Index<usize> for BySource<T> {
    type Output = T;

    /// Returns the entry with a number.
    ///
    /// # Panics
    /// When there is no entry with this number.
    fn index(&self, number: usize) -> &T {
        match self.get(number) {
            Some(entry) => entry,
            None => panic!("entry {number} of {}", self.len()),
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_numbered_through_all_parts() {
        let list = BySource::from_parts(|source| match source {
            PointSource::DownScan => Arc::new(vec!['a', 'b']),
            PointSource::Port => Arc::default(),
            PointSource::Starboard => Arc::new(vec!['c']),
            PointSource::Swath => Arc::new(vec!['d', 'e']),
        });
        let all: Vec<char> = list.iter().copied().collect();
        assert_eq!(all, ['a', 'b', 'c', 'd', 'e']);
        assert_eq!((list.len(), list[2], list[4], list.get(5)), (5, 'c', 'e', None));
        let starts = PointSource::ALL.map(|source| list.start(source));
        assert_eq!(starts, [0, 2, 2, 3]);
        assert_eq!(list.of(PointSource::Starboard)[0], 'c');
    }
}
