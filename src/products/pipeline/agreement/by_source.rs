//! The agreement of each source of points.

use super::Agreement;
use crate::pipeline::{NamedComparison, ProcessedLog};
use bathyscope_bottom::bathymetry::compare::{Comparison, Match};
use bathyscope_bottom::cloud::{CloudPoint, PointSource};

const PARTS: [(&str, &[PointSource]); 6] = [
    ("all points", &PointSource::ALL),
    ("down-scan", &[PointSource::DownScan]),
    ("side-scan", &[PointSource::Port, PointSource::Starboard]),
    ("port", &[PointSource::Port]),
    ("starboard", &[PointSource::Starboard]),
    ("swath", &[PointSource::Swath]),
];

impl Agreement {
    /// The comparison of all points of the logs that it was made of, and of those of each source
    /// that has some.
    pub(crate) fn by_source(&self, logs: &[ProcessedLog]) -> Vec<NamedComparison> {
        let counted: Vec<Vec<usize>> =
            logs.iter().map(|log| super::counted(&log.products)).collect();
        let reference = self.reference.as_ref();
        let name = reference.map_or_else(|| "down-scan".to_owned(), |one| one.name());
        let part = |(source, sources): (&'static str, &[PointSource])| {
            let is_of = |point: &CloudPoint| sources.contains(&point.source);
            let of_log = |(log, counted): (&ProcessedLog, &Vec<usize>)| {
                let points = &log.products.cloud.points;
                counted.iter().filter(|index| is_of(&points[**index])).count()
            };
            let measured = logs.iter().zip(&counted).map(of_log).sum();
            let matches = self.differences();
            let matches = matches.filter(|(cloud, one)| is_of(&cloud.points[one.measured]));
            let matches: Vec<Match> = matches.map(|(_, one)| *one).collect();
            (!matches.is_empty()).then(|| NamedComparison {
                source,
                reference: name.clone(),
                matching: self.matching.in_words(),
                comparison: Comparison::new(measured, &matches, super::level_m(logs)),
            })
        };
        PARTS.into_iter().filter_map(part).collect()
    }
}
