//! Computes the differences of the points of a survey, of one log or of several, from a reference,
//! point by point.
//!
//! In: the results of logs, and a reference. Out: a difference for each point that has a reference,
//! with statistics of all points and of each source, and tables by possible causes.
//!
//! `reference` opens the reference: a file of points or another mission.

mod reference;

pub use reference::{MissionLog, Reference, positions};

use super::{NamedComparison, ProcessedLog, Products};
use crate::Error;
use bathyscope_bottom::bathymetry::compare::{
    self, Bin, Comparison, DifferenceHistogram, Match, Matching, binned, suited_width,
};
use bathyscope_bottom::cloud::{CloudPoint, PointCloud, PointSource};
use bathyscope_bottom::presentation::text::way;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::PingNav;
use reference::{bounds, distance_m};
use serde::Serialize;
use std::sync::Arc;

/// Groups of sources that are compared, each with a name.
const PARTS: [(&str, &[PointSource]); 6] = [
    ("all points", &PointSource::ALL),
    ("down-scan", &[PointSource::DownScan]),
    ("side-scan", &[PointSource::Port, PointSource::Starboard]),
    ("port", &[PointSource::Port]),
    ("starboard", &[PointSource::Starboard]),
    ("swath", &[PointSource::Swath]),
];
/// Width of a bin of headings, degrees.
const SECTOR_DEG: f64 = 45.0;
/// Width of a bin, metres, if the values give none, for example if all points are at one distance
/// from the track.
const ANY_WIDTH_M: f64 = 0.5;

/// Differences of the points of one or several logs from a reference, measured minus reference
/// elevation: up is positive.
#[derive(Clone, Debug)]
pub struct Agreement {
    /// Differences of the points of each log.
    pub logs: Vec<LogDifferences>,
    /// Reference of the points; `None` for the survey's own soundings.
    pub reference: Option<Arc<Reference>>,
    /// Way in which the reference of each point was found.
    pub matching: Matching,
    /// Statistics of all differences.
    pub comparison: Comparison,
    /// Differences by depth, across-track distance and heading, and their histogram.
    pub tables: ResidualTables,
}

/// Points of a log that have a reference.
#[derive(Clone, Debug)]
pub struct LogDifferences {
    /// Cloud of the points.
    pub cloud: Arc<PointCloud>,
    /// Number of points that were compared with the reference.
    pub measured: usize,
    /// Differences of the points that have a reference, in the cloud's order; their field
    /// `measured` is the index in the cloud. Empty if no point has a reference.
    pub differences: Vec<Match>,
}

/// Differences of points from a reference, measured minus reference elevation, sorted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualTables {
    /// Bins by the depth of the reference at the point, metres.
    pub by_depth_m: Vec<Bin>,
    /// Bins by the across-track distance, metres: port below 0, starboard above.
    pub by_across_m: Vec<Bin>,
    /// Bins by the heading, degrees clockwise from north.
    pub by_heading_deg: Vec<Bin>,
    /// Number of differences by size; `None` if there is none.
    pub histogram: Option<DifferenceHistogram>,
}

/// Point of one of the logs: its indices, in 32 bits because there are millions.
#[derive(Clone, Copy)]
struct Chosen {
    log: u32,
    point: u32,
}

impl Agreement {
    /// Compares the kept points of some sources of all logs with the triangulated soundings of all
    /// logs at the same place; `None` if no point is over the soundings. The logs are in one local
    /// coordinate frame.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn with_soundings(
        logs: &[ProcessedLog],
        sources: &[PointSource],
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let Some(first) = logs.first() else {
            return Ok(None);
        };
        let is_asked = |point: &CloudPoint| sources.contains(&point.source);
        let asked = chosen(logs, |products| kept(products, is_asked));
        if asked.is_empty() {
            return Ok(None);
        }
        let is_sounding = |point: &CloudPoint| point.source == PointSource::DownScan;
        let soundings = chosen(logs, |products| kept(products, is_sounding));
        let soundings = soundings.iter().map(|chosen_point| point(logs, *chosen_point).place());
        let max_gap_m = first.products.settings.surface.max_gap_m;
        let matching = Matching::Surface { max_gap_m };
        Self::of(logs, &asked, soundings, matching, progress)
    }

    /// Compares the kept points of all logs from which a depth map is made with a reference. The
    /// logs are in one local coordinate frame.
    ///
    /// # Errors
    /// When there is no log, the reference cannot be used, no point has a reference, or the work
    /// was cancelled.
    pub fn with_reference(
        logs: &[ProcessedLog],
        reference: &Arc<Reference>,
        matching: Matching,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let Some(first) = logs.first() else {
            return Err("there is no log to compare with the reference".into());
        };
        let counted = chosen(logs, counted);
        let points = counted.iter().map(|chosen_point| point(logs, *chosen_point));
        let there = bounds(points.map(|point| [point.east_m, point.north_m]));
        let mut places = reference.places(first, progress)?;
        let all = bounds(places.iter().map(|&[x, y, _]| [x, y]));
        // No triangle that the surface keeps, and no radius, reaches farther: the points removed
        // here have no influence.
        let reach_m = match matching {
            Matching::Nearest { radius_m } => radius_m,
            Matching::Surface { max_gap_m } => 2.0 * max_gap_m,
        };
        places.retain(|&[x, y, _]| distance_m(there, [x, y, x, y]) <= reach_m);
        let places = places.iter().copied();
        let made = Self::of(logs, &counted, places, matching, progress);
        match made? {
            Some(agreement) => Ok(Self { reference: Some(reference.clone()), ..agreement }),
            None => {
                let what = unmatched(matching, distance_m(there, all));
                Err(format!("{what}: {}", reference.path().display()).into())
            }
        }
    }

    /// Compares chosen points of the logs, sorted by log, with reference points in the same plane;
    /// `None` if no point has a reference.
    fn of(
        logs: &[ProcessedLog],
        chosen: &[Chosen],
        reference: impl Iterator<Item = [f64; 3]> + Clone,
        matching: Matching,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let reference = compare::ReferencePoints::new(reference, matching);
        progress.check()?;
        let at = |chosen_point: &Chosen| point(logs, *chosen_point).place();
        let differences = reference.matches(chosen, at, progress)?;
        drop(reference);
        if differences.is_empty() {
            return Ok(None);
        }
        progress.check()?;
        let measured = |matched: &Match| {
            let chosen = chosen[matched.measured];
            let products = &logs[chosen.log as usize].products;
            (products, point(logs, chosen))
        };
        Ok(Some(Self {
            reference: None,
            matching,
            comparison: Comparison::new(chosen.len(), &differences, level_m(logs)),
            tables: tables(&differences, measured),
            logs: by_log(logs, chosen, &differences),
        }))
    }

    /// Returns all differences, log by log, each with the cloud in which its `measured` is an
    /// index.
    pub fn differences(&self) -> impl Iterator<Item = (&PointCloud, &Match)> {
        let logs = self.logs.iter();
        logs.flat_map(|log| log.differences.iter().map(|matched| (&*log.cloud, matched)))
    }

    /// Returns the statistics of each log alone.
    pub(crate) fn comparison_of_each(&self, logs: &[ProcessedLog]) -> Vec<Comparison> {
        let each = self.logs.iter().zip(logs);
        each.map(|(found, log)| {
            let level_m = log.products.correction.middle_level_m;
            Comparison::new(found.measured, &found.differences, level_m)
        })
        .collect()
    }

    /// Returns the comparison of all points of the logs from which this agreement was made, and of
    /// the points of each group of sources that has some.
    pub(crate) fn by_source(&self, logs: &[ProcessedLog]) -> Vec<NamedComparison> {
        let counted: Vec<Vec<usize>> = logs.iter().map(|log| counted(&log.products)).collect();
        let reference = self.reference.as_ref();
        let name = reference.map_or_else(|| "down-scan".to_owned(), |reference| reference.name());
        let part = |(source, sources): (&'static str, &[PointSource])| {
            let is_of = |point: &CloudPoint| sources.contains(&point.source);
            let of_log = |(log, counted): (&ProcessedLog, &Vec<usize>)| {
                let points = &log.products.cloud.points;
                counted.iter().filter(|index| is_of(&points[**index])).count()
            };
            let measured = logs.iter().zip(&counted).map(of_log).sum();
            let matches = self.differences();
            let matches = matches.filter(|(cloud, matched)| is_of(&cloud.points[matched.measured]));
            let matches: Vec<Match> = matches.map(|(_, matched)| *matched).collect();
            (!matches.is_empty()).then(|| NamedComparison {
                source,
                reference: name.clone(),
                matching: self.matching.in_words(),
                comparison: Comparison::new(measured, &matches, level_m(logs)),
            })
        };
        PARTS.into_iter().filter_map(part).collect()
    }
}

/// Returns the elevation of the water surface from which the depths of all points are counted: that
/// of the first log.
fn level_m(logs: &[ProcessedLog]) -> f64 {
    let first = logs.first();
    first.map_or(0.0, |log| log.products.correction.middle_level_m)
}

/// Returns points of all logs, in the order of the logs and of their points.
fn chosen(logs: &[ProcessedLog], of: impl Fn(&Products) -> Vec<usize>) -> Vec<Chosen> {
    let mut all = Vec::new();
    for (log, processed) in (0..).zip(logs) {
        let points = of(&processed.products);
        all.reserve_exact(points.len());
        // A cloud numbers its pings in 32 bits, too.
        all.extend(points.into_iter().map(|point| Chosen { log, point: point as u32 }));
    }
    all
}

fn point(logs: &[ProcessedLog], chosen: Chosen) -> &CloudPoint {
    &logs[chosen.log as usize].products.cloud.points[chosen.point as usize]
}

/// Splits the differences by log; their field `measured` changes from the index among the chosen
/// points to the index in the log's cloud.
fn by_log(logs: &[ProcessedLog], chosen: &[Chosen], differences: &[Match]) -> Vec<LogDifferences> {
    let with = |(number, log): (u32, &ProcessedLog)| {
        let first = chosen.partition_point(|chosen_point| chosen_point.log < number);
        let end = chosen.partition_point(|chosen_point| chosen_point.log <= number);
        let from = differences.partition_point(|matched| matched.measured < first);
        let to = differences.partition_point(|matched| matched.measured < end);
        let own = differences[from..to].iter();
        LogDifferences {
            cloud: log.products.cloud.clone(),
            measured: end - first,
            differences: own
                .map(|matched| Match {
                    measured: chosen[matched.measured].point as usize,
                    ..*matched
                })
                .collect(),
        }
    };
    (0..).zip(logs).map(with).collect()
}

/// Returns the reason why no point has a reference, which is this distance away from the survey.
fn unmatched(matching: Matching, away_m: f64) -> String {
    if !away_m.is_finite() || away_m > f64::MAX / 4.0 {
        "the reference holds no point with a place".to_owned()
    } else if away_m >= 1.0 {
        format!(
            "the reference lies {} from this survey; see whether both are of one water and whether its columns are named right",
            way(away_m)
        )
    } else {
        format!(
            "no point of this survey has a reference ({}); take a larger distance",
            matching.in_words()
        )
    }
}

/// Returns the indices of the kept points for which `counts` is true.
fn kept(products: &Products, counts: impl Fn(&CloudPoint) -> bool) -> Vec<usize> {
    let chosen = || {
        let kept = products.cloud.kept(&products.classes);
        kept.filter(|(_, point)| counts(point))
    };
    // Counted first: a vector of a million elements that grows takes three times its memory for a
    // moment.
    let mut indices = Vec::with_capacity(chosen().count());
    indices.extend(chosen().map(|(index, _)| index));
    indices
}

/// Returns the indices of the kept points from which a depth map is made.
fn counted(products: &Products) -> Vec<usize> {
    let settings = &products.settings.surface;
    kept(products, |point| settings.weight(point) > 0.0)
}

/// Sorts differences into tables; `measured` returns the results of the log and the point of each
/// difference.
fn tables<'a>(
    differences: &[Match],
    measured: impl Fn(&Match) -> (&'a Products, &'a CloudPoint),
) -> ResidualTables {
    let by = |variable: &dyn Fn(&Match) -> f64, width: Option<f64>| {
        let mut values: Vec<f64> = differences.iter().map(variable).collect();
        values.retain(|value| value.is_finite());
        let width = width.or_else(|| suited_width(&mut values));
        let pairs = differences.iter().map(|matched| (variable(matched), matched.difference_m));
        binned(pairs, width.unwrap_or(ANY_WIDTH_M))
    };
    let all: Vec<f64> = differences.iter().map(|matched| matched.difference_m).collect();
    let of_point = |of: fn(&Products, &CloudPoint) -> f64| {
        let measured = &measured;
        move |matched: &Match| {
            let (products, point) = measured(matched);
            of(products, point)
        }
    };
    ResidualTables {
        by_depth_m: by(&|matched| -matched.reference_z_m, None),
        by_across_m: by(&of_point(across_m), None),
        by_heading_deg: by(&of_point(heading_deg), Some(SECTOR_DEG)),
        histogram: DifferenceHistogram::of(&all),
    }
}

/// Returns the place and heading of the boat when a point was measured.
fn boat<'a>(products: &'a Products, point: &CloudPoint) -> Option<&'a PingNav> {
    point.record().place(&products.navigation)
}

/// Returns the distance of a point to starboard of the boat, metres; NaN if the boat's place is
/// unknown.
fn across_m(products: &Products, point: &CloudPoint) -> f64 {
    let across = boat(products, point).and_then(|boat| {
        let [east, north] = boat.starboard()?;
        Some((point.east_m - boat.east_m) * east + (point.north_m - boat.north_m) * north)
    });
    across.unwrap_or(f64::NAN)
}

fn heading_deg(products: &Products, point: &CloudPoint) -> f64 {
    boat(products, point).map_or(f64::NAN, |boat| boat.heading_rad.to_degrees().rem_euclid(360.0))
}
