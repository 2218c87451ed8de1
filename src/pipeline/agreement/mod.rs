//! How the points of a survey agree with a reference, one by one.
//!
//! `reference` is what can be held against it: a file of points or another mission. `tables` sorts the differences by what they may
//! hang on, `by_source` tells the sources of points apart.

mod by_source;
mod reference;
mod tables;

pub use reference::{Reference, positions};
pub use tables::ResidualTables;

use super::Products;
use crate::bathymetry::compare::{self, Comparison, Match, Matching};
use crate::cloud::{CloudPoint, PointCloud, PointSource};
use crate::progress::{Cancelled, Progress};
use crate::survey::Survey;
use reference::{bounds, distance_m};
use std::sync::Arc;

/// Points and how they differ from a reference, measured minus reference elevation: up is positive.
#[derive(Clone, Debug)]
pub struct Agreement {
    /// The cloud that the points are of.
    pub cloud: Arc<PointCloud>,
    /// What they were held against; `None` for the survey's own soundings.
    pub reference: Option<Arc<Reference>>,
    /// How a point found its reference.
    pub matching: Matching,
    /// The points that have a reference, in the cloud's order: `measured` is the index there. Never empty.
    pub differences: Vec<Match>,
    /// Their statistics.
    pub comparison: Comparison,
    /// What the differences hang on.
    pub tables: ResidualTables,
}

impl Agreement {
    /// Of the kept side-scan points with the triangulated soundings at their place; `None` where no point lies over them.
    pub fn with_soundings(
        products: &Products,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let is_sounding = |point: &CloudPoint| point.source == PointSource::DownScan;
        let points = &products.cloud.points;
        let soundings = kept(products, is_sounding);
        let soundings = soundings.iter().map(|index| place(&points[*index]));
        let max_gap_m = products.settings.surface.max_gap_m;
        let chosen = kept(products, |point| !is_sounding(point));
        let matching = Matching::Surface { max_gap_m };
        Self::of(products, &chosen, soundings, matching, progress)
    }

    /// Of the kept points that a depth map is made of with a reference. The error is one sentence.
    pub fn with_reference(
        survey: &Survey,
        products: &Products,
        reference: &Arc<Reference>,
        matching: Matching,
        progress: &Progress,
    ) -> Result<Self, String> {
        let chosen = counted(products);
        let points = chosen.iter().map(|index| &products.cloud.points[*index]);
        let there = bounds(points.map(|point| [point.east_m, point.north_m]));
        let mut places = reference.places(survey, products, progress)?;
        let all = bounds(places.iter().map(|&[x, y, _]| [x, y]));
        // No triangle that the surface keeps, and no radius, reaches farther: what is left out changes nothing.
        let reach_m = match matching {
            Matching::Nearest { radius_m } => radius_m,
            Matching::Surface { max_gap_m } => 2.0 * max_gap_m,
        };
        places.retain(|&[x, y, _]| distance_m(there, [x, y, x, y]) <= reach_m);
        let places = places.iter().copied();
        let made = Self::of(products, &chosen, places, matching, progress);
        match made.map_err(|error| error.to_string())? {
            Some(agreement) => Ok(Self {
                reference: Some(reference.clone()),
                ..agreement
            }),
            None => Err(unmatched(reference, matching, distance_m(there, all))),
        }
    }

    /// Of chosen points of the cloud with points in the survey's plane.
    fn of(
        products: &Products,
        chosen: &[usize],
        reference: impl Iterator<Item = [f64; 3]> + Clone,
        matching: Matching,
        progress: &Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let points = &products.cloud.points;
        let reference = compare::Reference::new(reference, matching);
        progress.check()?;
        let at = |index: &usize| place(&points[*index]);
        let mut differences = reference.matches(chosen, at, progress)?;
        drop(reference);
        if differences.is_empty() {
            return Ok(None);
        }
        for one in &mut differences {
            one.measured = chosen[one.measured];
        }
        progress.check()?;
        let level_m = products.correction.middle_level_m();
        Ok(Some(Self {
            cloud: products.cloud.clone(),
            reference: None,
            matching,
            comparison: Comparison::new(chosen.len(), &differences, level_m),
            tables: tables::tables(products, &differences),
            differences,
        }))
    }
}

/// How a point finds its reference, in words.
pub fn matching_in_words(matching: Matching) -> String {
    match matching {
        Matching::Nearest { radius_m } => format!("nearest point within {radius_m} m"),
        Matching::Surface { max_gap_m } => format!("triangulated surface, gap {max_gap_m} m"),
    }
}

fn unmatched(reference: &Reference, matching: Matching, away_m: f64) -> String {
    let path = reference.path().display();
    if !away_m.is_finite() || away_m > f64::MAX / 4.0 {
        return format!("the reference holds no point with a place: {path}");
    }
    if away_m > 0.0 {
        return format!(
            "the reference lies {:.1} km from this survey; see whether both are of one water and whether its columns are named right: {path}",
            away_m / 1000.0
        );
    }
    let by = matching_in_words(matching);
    format!("no point of this survey has a reference ({by}); take a larger distance: {path}")
}

/// Indices of the kept points that count.
fn kept(products: &Products, counts: impl Fn(&CloudPoint) -> bool) -> Vec<usize> {
    let chosen = || {
        let flagged = products.cloud.points.iter().zip(products.kept.iter());
        let chosen = flagged.enumerate();
        chosen.filter(|(_, (point, kept))| **kept && counts(point))
    };
    // Counted first: a vector of a million that grows takes three times its memory for a moment.
    let mut indices = Vec::with_capacity(chosen().count());
    indices.extend(chosen().map(|(index, _)| index));
    indices
}

/// Indices of the kept points that a depth map is made of.
fn counted(products: &Products) -> Vec<usize> {
    let settings = &products.settings.surface;
    kept(products, |point| settings.weight(point) > 0.0)
}

/// East, north and elevation in the survey's plane, metres.
fn place(point: &CloudPoint) -> [f64; 3] {
    [point.east_m, point.north_m, point.z_m]
}
