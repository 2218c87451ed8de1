//! The agreement of each source of points.

use super::{Agreement, matching_in_words};
use crate::bathymetry::compare::{Comparison, Match};
use crate::cloud::PointSource;
use crate::pipeline::{NamedComparison, Products};

const PARTS: [(&str, &[PointSource]); 5] = [
    (
        "all points",
        &[
            PointSource::DownScan,
            PointSource::Port,
            PointSource::Starboard,
        ],
    ),
    ("down-scan", &[PointSource::DownScan]),
    ("side-scan", &[PointSource::Port, PointSource::Starboard]),
    ("port", &[PointSource::Port]),
    ("starboard", &[PointSource::Starboard]),
];

impl Agreement {
    /// The comparison of all points, and of those of each source that has some.
    pub fn by_source(&self, products: &Products) -> Vec<NamedComparison> {
        let counted = super::counted(products);
        let points = &self.cloud.points;
        let level_m = products.correction.middle_level_m();
        let reference = self.reference.as_ref();
        let name = reference.map_or_else(|| "down-scan".to_owned(), |one| one.name());
        let part = |(source, sources): (&'static str, &[PointSource])| {
            let is_of = |index: usize| sources.contains(&points[index].source);
            let measured = counted.iter().filter(|index| is_of(**index)).count();
            let matches = self.differences.iter();
            let matches: Vec<Match> = matches.filter(|one| is_of(one.measured)).copied().collect();
            (!matches.is_empty()).then(|| NamedComparison {
                source,
                reference: name.clone(),
                matching: matching_in_words(self.matching),
                comparison: Comparison::new(measured, &matches, level_m),
            })
        };
        PARTS.into_iter().filter_map(part).collect()
    }
}
