//! Several logs of one water as one depth map.
//!
//! Each log is processed by itself, with its own calibration and outliers; what is left of it here are its kept points, in the plane
//! of the first log. So the memory holds one log at a time, and fifty bytes for each point of the others.

use super::Product;
use super::record::{write_json, write_record};
use super::registry::When;
use super::results::Results;
use super::run_folder::RunFolder;
use super::write::{Order, write_rows};
use crate::bathymetry::compare::{Comparison, Matching, Reference};
use crate::bathymetry::crossings::{Crossing, TrackDepth, crossings};
use crate::calibration::Calibration;
use crate::cloud::{CloudPoint, PointCloud, Residuals};
use crate::first_return::FirstReturns;
use crate::pipeline::{Fingerprint, Input, ProcessedLog, Products, Report, Settings};
use crate::progress::{Cancelled, Progress};
use crate::survey::{Navigation, Projection, Survey, Track};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

/// The logs taken in so far.
#[derive(Debug, Default)]
pub struct Merged {
    logs: Vec<Log>,
    /// Of the first log: its plane, and what was made of it.
    first: Option<(Track, Products)>,
    /// Of all logs, as far as records beside products need it: the first one's, with the inputs of all.
    report: Option<Report>,
}

/// What is left of a log.
#[derive(Debug)]
struct Log {
    name: String,
    inputs: Vec<Input>,
    /// Unix seconds of its time zero.
    start_unix_s: Option<f64>,
    statement: String,
    /// Kept points in the plane of the first log.
    points: Vec<CloudPoint>,
    /// Its soundings, for crossings.
    track: Vec<TrackDepth>,
}

/// `merged.json`.
#[derive(Serialize)]
struct Record<'a> {
    program: String,
    sign: &'static str,
    /// Every log, and how its points agree with the triangulated points of all others.
    logs: Vec<LogRecord<'a>>,
    /// Where tracks cross, each other and themselves.
    crossings: Option<CrossingsRecord>,
    warnings: &'a [String],
    settings: &'a Settings,
    run: &'a str,
    /// The other files of the run.
    files: Vec<Fingerprint>,
}

#[derive(Serialize)]
struct LogRecord<'a> {
    name: &'a str,
    inputs: &'a [Input],
    start_unix_s: Option<f64>,
    statement: &'a str,
    points: usize,
    against_the_others: Comparison,
}

#[derive(Serialize)]
struct CrossingsRecord {
    #[serde(flatten)]
    all: Residuals,
    /// Those of two logs; absent without any.
    between_logs: Option<Residuals>,
}

const SIGN: &str = "measured minus reference elevation, and second minus first log or pass, metres; positive is shallower";

impl Merged {
    /// Takes in the kept points of a processed log.
    pub fn add(&mut self, survey: &Survey, products: &Products, report: &Report) {
        let all = self.report.get_or_insert_with(|| Report {
            inputs: Vec::new(),
            ..report.clone()
        });
        all.inputs.extend(report.inputs.iter().cloned());
        let first = self
            .first
            .get_or_insert_with(|| (survey.track.clone(), shared_by_all(products)));
        let frame = &first.0.frame;
        let kept = products.cloud.points.iter().zip(products.kept.iter());
        let kept = kept.filter(|(_, kept)| **kept).map(|(point, _)| point);
        let points: Vec<CloudPoint> = kept
            .map(|point| {
                let at = products
                    .navigation
                    .to_lon_lat(&survey.track, point.east_m, point.north_m);
                let [east_m, north_m] = frame.to_enu(at);
                CloudPoint {
                    east_m,
                    north_m,
                    ..*point
                }
            })
            .filter(|point| {
                [point.east_m, point.north_m, point.z_m]
                    .iter()
                    .all(|value| value.is_finite())
            })
            .collect();
        let depth = |point: &CloudPoint| {
            Some(TrackDepth {
                time_s: survey.soundings.get(point.sounding?.get())?.time_s,
                east_m: point.east_m,
                north_m: point.north_m,
                depth_m: -point.z_m,
            })
        };
        self.logs.push(Log {
            name: survey.name(),
            inputs: report.inputs.clone(),
            start_unix_s: survey.start_unix_s,
            statement: report.statement.clone(),
            track: points.iter().filter_map(depth).collect(),
            points,
        });
    }

    /// How many logs were taken in.
    pub fn len(&self) -> usize {
        self.logs.len()
    }

    /// Whether no log was taken in.
    pub fn is_empty(&self) -> bool {
        self.logs.is_empty()
    }

    /// Writes the wanted maps of depth of all logs together, and `merged.json` about them, as the files of a run. Gives back the
    /// files and what there is to warn of.
    ///
    /// # Errors
    /// A sentence that names the file, or says that the work was cancelled.
    pub fn write(
        &self,
        wanted: &[Product],
        run: RunFolder,
        progress: &Progress,
    ) -> Result<(Vec<&'static str>, Vec<String>), String> {
        let (Some((track, products)), Some(report)) = (&self.first, &self.report) else {
            return Ok(Default::default());
        };
        let names: Vec<&str> = self.logs.iter().map(|log| log.name.as_str()).collect();
        let mut survey = Survey {
            track: track.clone(),
            ..Survey::default()
        };
        survey.source.files = vec![PathBuf::from(names.join(" with "))];
        let points: Vec<CloudPoint> = self
            .logs
            .iter()
            .flat_map(|log| &log.points)
            .copied()
            .collect();
        let all = Products {
            kept: Arc::new(vec![true; points.len()]),
            cloud: Arc::new(PointCloud {
                points,
                zero_heading: 0,
            }),
            ..products.clone()
        };
        let maps = [Product::Depth, Product::Xyz, Product::Isobaths];
        let folder = run.path();
        let logs = [ProcessedLog {
            survey: Arc::new(survey),
            products: all,
        }];
        let order = Order {
            logs: &logs,
            wanted,
            reference: None,
            search: None,
            review: None,
        };
        let mut results = Results::new(&order, progress)?;
        let asked = |when| {
            let of = |map: &Product| wanted.contains(map) && when == When::Chosen(*map);
            maps.iter().any(of)
        };
        let written = write_rows(&mut results, &folder, asked, &mut |_| ())?;
        drop(results);
        drop(logs);
        let mut report = report.clone();
        report.name_run(run.files(progress)?)?;
        for (row, content) in &written.files {
            write_record(row, content, &report, &[], &folder)?;
        }
        report.files = run.files(progress)?;
        report.warnings.clone_from(&written.warnings);
        self.write_agreement(report, &run, progress)?;
        run.commit("merged.json")?;
        let files = written.files.iter().map(|(row, _)| row.name);
        Ok((files.chain(["merged.json"]).collect(), written.warnings))
    }

    fn write_agreement(
        &self,
        report: Report,
        run: &RunFolder,
        progress: &Progress,
    ) -> Result<(), String> {
        let Report {
            settings, warnings, ..
        } = &report;
        let cancelled = |error: Cancelled| error.to_string();
        let logs = (0..self.logs.len()).map(|log| self.against_the_others(log, settings, progress));
        let record = Record {
            program: format!("bathyscope {}", env!("CARGO_PKG_VERSION")),
            sign: SIGN,
            logs: logs.collect::<Result<_, _>>().map_err(cancelled)?,
            crossings: self.crossings(progress).map_err(cancelled)?,
            warnings,
            settings,
            run: &report.run,
            files: report.files.clone(),
        };
        write_json(&run.path().join("merged.json"), &record)
    }

    fn against_the_others(
        &self,
        log: usize,
        settings: &Settings,
        progress: &Progress,
    ) -> Result<LogRecord<'_>, Cancelled> {
        let places = |log: &Log| -> Vec<[f64; 3]> {
            let counted = log
                .points
                .iter()
                .filter(|point| settings.surface.weight(point) > 0.0);
            counted
                .map(|point| [point.east_m, point.north_m, point.z_m])
                .collect()
        };
        let others = self
            .logs
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != log);
        let others: Vec<[f64; 3]> = others.flat_map(|(_, other)| places(other)).collect();
        let max_gap_m = settings.surface.max_gap_m;
        let reference = Reference::new(others.iter().copied(), Matching::Surface { max_gap_m });
        let log = &self.logs[log];
        let measured = places(log);
        let matches = reference.matches(&measured, |place| *place, progress)?;
        let level_m = self
            .first
            .as_ref()
            .map_or(0.0, |(_, products)| products.correction.middle_level_m());
        Ok(LogRecord {
            name: &log.name,
            inputs: &log.inputs,
            start_unix_s: log.start_unix_s,
            statement: &log.statement,
            points: log.points.len(),
            against_the_others: Comparison::new(measured.len(), &matches, level_m),
        })
    }

    fn crossings(&self, progress: &Progress) -> Result<Option<CrossingsRecord>, Cancelled> {
        let tracks: Vec<Vec<TrackDepth>> = self.logs.iter().map(|log| log.track.clone()).collect();
        let found = crossings(&tracks, progress)?;
        let between = found
            .iter()
            .filter(|one| one.passes[0].track != one.passes[1].track);
        let mut between: Vec<f64> = between.map(Crossing::difference_m).collect();
        let mut all: Vec<f64> = found.iter().map(Crossing::difference_m).collect();
        let between_logs = Residuals::of(&mut between);
        Ok(Residuals::of(&mut all).map(|all| CrossingsRecord { all, between_logs }))
    }
}

/// What the logs share: settings and correction, without anything of the first log's pings.
fn shared_by_all(products: &Products) -> Products {
    Products {
        navigation: Arc::new(Navigation {
            pings: Vec::new(),
            soundings: Vec::new(),
            // The plane of the points here, whatever that of each log was.
            projection: Projection::Enu,
            zero_heading: 0,
            moving: 0,
        }),
        flat_spots: Arc::default(),
        returns: Arc::new(FirstReturns::default()),
        calibration: Arc::new(Calibration {
            flat_spot: None,
            header: None,
            fit: None,
            measured_offset: None,
            warnings: Vec::new(),
            ..Calibration::clone(&products.calibration)
        }),
        cloud: Arc::default(),
        kept: Arc::default(),
        depths: Arc::default(),
        ..products.clone()
    }
}
