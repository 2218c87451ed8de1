//! Decides the class of each point of a cloud, once for the map, every file, every count and every
//! view.

use super::{CloudPoint, OutlierSettings, PointCloud, PointSource, outliers};
use bathyscope_log::named;
use bathyscope_log::support::progress::{Cancelled, Progress};
use serde::ser::{Serialize, SerializeMap, Serializer};

/// Class of a point, in the code of ASPRS LAS 1.4 and its topo-bathymetric profile. Classes from 64
/// on are free for users; those here are named in LAS files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum PointClass {
    /// A first return of less confidence than [`ClassRules::min_confidence`].
    Unclassified = 1,
    /// A first return that the outlier filter removes.
    LowNoise = 7,
    /// A first return that the outlier filter removes, nearer than the recorded depth by more than
    /// the margin.
    HighNoise = 18,
    /// The bottom: the map, the figures of agreement and everything that is based on depths use
    /// these points and no others.
    Bottom = 40,
    /// A sounding with a fault.
    NoBottom = 45,
    /// A first return of weed, fish or an object above the bottom.
    AboveBottom = 64,
}

named! {
    /// All classes, by their codes.
    pub PointClass {
        Unclassified: "unclassified",
        LowNoise: "low noise",
        HighNoise: "high noise",
        Bottom: "bathymetric",
        NoBottom: "no bottom found",
        AboveBottom: "above bottom",
    }
}

impl PointClass {
    /// Returns the number of the class in files.
    pub fn code(self) -> u8 {
        self as u8
    }

    /// Returns true if the point counts for the map (`kept` in `cloud.csv`).
    pub fn is_kept(self) -> bool {
        self == PointClass::Bottom
    }
}

/// Rules that decide the class of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassRules<'a> {
    /// Least confidence of first returns that are kept, and that count as neighbours
    /// (`first_return.min_confidence`).
    pub min_confidence: f32,
    /// True if all above-bottom returns count as bottom (`surface.above_bottom`).
    pub above_bottom: bool,
    /// Length of a stretch above which its above-bottom returns count as bottom, metres
    /// (`surface.longest_above_bottom_m`).
    pub longest_above_bottom_m: f64,
    /// Settings of the outlier filter.
    pub outliers: &'a OutlierSettings,
}

impl ClassRules<'_> {
    /// Returns the class of a point; `is_outlier` is true if the outlier filter removes it.
    fn class(&self, point: &CloudPoint, is_outlier: bool) -> PointClass {
        let is_long = f64::from(point.above_bottom_m) > self.longest_above_bottom_m;
        match point.source {
            PointSource::DownScan if point.fault().is_none() => PointClass::Bottom,
            PointSource::DownScan => PointClass::NoBottom,
            _ if self.has_low_confidence(point) => PointClass::Unclassified,
            _ if is_outlier && point.is_above_bottom() => PointClass::HighNoise,
            _ if is_outlier => PointClass::LowNoise,
            _ if point.is_above_bottom() && !self.above_bottom && !is_long => {
                PointClass::AboveBottom
            }
            _ => PointClass::Bottom,
        }
    }

    /// Returns true if the confidence of a point is too low. Soundings have no confidence. The
    /// stretch of an above-bottom return decides whether it is the ground.
    fn has_low_confidence(&self, point: &CloudPoint) -> bool {
        point.ground_confidence() < self.min_confidence
    }
}

/// Returns the class of every point. Outliers are found among the side-scan points as in the
/// published code: neither soundings nor points of too low confidence are neighbours. Outliers of a
/// swath are found among the points of the swath, which lie much closer to each other.
///
/// # Errors
/// When the work was cancelled.
pub fn classify(
    cloud: &PointCloud,
    rules: &ClassRules<'_>,
    progress: &Progress,
) -> Result<Vec<PointClass>, Cancelled> {
    let side_scan = |index: u32| match &cloud.points[index as usize] {
        point if point.source.is_side_scan() && !rules.has_low_confidence(point) => point.place(),
        _ => [f64::NAN; 3],
    };
    let OutlierSettings { radius_m, min_neighbors } = *rules.outliers;
    let count = cloud.points.len();
    let mut kept = outliers::keep_places(count, &side_scan, radius_m, min_neighbors, progress)?;
    let swath = cloud.points.of(PointSource::Swath);
    if !swath.is_empty() {
        let place = |index: u32| swath[index as usize].place();
        let of_swath =
            outliers::keep_places(swath.len(), &place, radius_m, min_neighbors, progress)?;
        kept.truncate(count - swath.len());
        kept.extend(of_swath);
    }
    let points = cloud.points.iter().zip(kept);
    Ok(points.map(|(point, is_kept)| rules.class(point, !is_kept)).collect())
}

/// Number of points of each class.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClassCounts {
    /// Counts in the order of [`PointClass::ALL`].
    counts: [usize; PointClass::ALL.len()],
    /// Number of first returns of the side-scan.
    pub side_scan: usize,
    /// Number of points of the swath.
    pub swath: usize,
}

impl ClassCounts {
    /// Counts the points of a cloud with a class for each point.
    pub fn of(cloud: &PointCloud, classes: &[PointClass]) -> Self {
        let count = |class: PointClass| classes.iter().filter(|other| **other == class).count();
        let of_source = |source| cloud.points.of(source).len();
        Self {
            counts: PointClass::ALL.map(count),
            side_scan: of_source(PointSource::Port) + of_source(PointSource::Starboard),
            swath: of_source(PointSource::Swath),
        }
    }

    /// Returns the number of points of a class.
    pub fn count(&self, class: PointClass) -> usize {
        let all = PointClass::ALL.into_iter().zip(self.counts);
        all.filter(|(other, _)| *other == class).map(|(_, count)| count).sum()
    }

    /// Returns the number of all points.
    pub fn all(&self) -> usize {
        self.counts.iter().sum()
    }

    /// Returns the number of points that count for the map.
    pub fn kept(&self) -> usize {
        self.count(PointClass::Bottom)
    }

    /// Returns the number of points that the outlier filter removed.
    pub fn noise(&self) -> usize {
        self.count(PointClass::LowNoise) + self.count(PointClass::HighNoise)
    }

    /// Returns the share of points that the outlier filter removed, of all those of side-scan and
    /// swath, 0 to 1.
    pub fn noise_share(&self) -> f64 {
        self.noise() as f64 / (self.side_scan + self.swath).max(1) as f64
    }

    /// Adds the counts of another log.
    pub fn add(&mut self, other: &Self) {
        for (count, more) in self.counts.iter_mut().zip(other.counts) {
            *count += more;
        }
        self.side_scan += other.side_scan;
        self.swath += other.swath;
    }
}

/// Writes the number of points by the code of their class, without classes that have no points.
impl Serialize for ClassCounts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (class, count) in PointClass::ALL.into_iter().zip(self.counts) {
            if count > 0 {
                map.serialize_entry(&class.code(), &count)?;
            }
        }
        map.end()
    }
}
