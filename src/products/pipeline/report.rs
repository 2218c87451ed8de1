//! Makes the contents of `report.json`: inputs, settings, results, and their reliability.

use super::fingerprint::{Fingerprint, hash_inputs, in_hexadecimal};
use super::joint::{LogsReport, RequestedCorrection};
use super::log_report::{CalibrationReport, RunCounts, SwathCounts};
use super::{CommonUncertainty, Preset, Products, Settings};
use crate::PROGRAM;
use bathyscope_bottom::cloud::{
    ClassCounts, PointClass, PointCloud, PointSource, Residuals, TrackShare, residuals,
};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{ExcludedStretch, FaultCounts, HeadingSource, Side, Survey};
use serde::Serialize;
use sha2::{Digest as _, Sha256};
use std::collections::HashSet;

/// Number of bytes of a hash that are the name of a run.
const RUN_BYTES: usize = 8;

/// Record written beside the products. Field names are the contract of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Program and version.
    pub program: String,
    /// Name of the run, as in the manifest and `report.html`: runs with the same inputs, settings
    /// and products have the same name. Empty until [`Report::name_run`].
    pub run: String,
    /// Files that were read.
    pub inputs: Vec<Fingerprint>,
    /// Format in words.
    pub format: String,
    /// Unix seconds of the log's time zero; `None` if unknown.
    pub start_unix_s: Option<f64>,
    /// Preset of the settings: `published`, `recommended` or `changed`.
    pub preset: &'static str,
    /// Every setting.
    pub settings: Settings,
    /// Counts.
    pub counts: RunCounts,
    /// Excluded stretches in time order, with the reasons.
    pub excluded: Vec<ExcludedStretch>,
    /// Scales.
    pub calibration: CalibrationReport,
    /// Sources of the depths along the track.
    pub track: TrackShare,
    /// Residuals: elevation of the kept side-scan points minus that of the recorded depth at the
    /// same ping, above 0 is shallower; `None` without any.
    pub residuals: Option<Residuals>,
    /// Corrections of recorded positions, in sentences; empty if there are none, and for a survey
    /// of several logs, each of which has its own.
    pub positions: String,
    /// Corrections of positions and heights that were requested, applied or refused.
    pub corrections: Vec<RequestedCorrection>,
    /// Uncertainty that all depths have in common, one standard deviation each, which is included
    /// in the stated error of the map.
    pub uncertainty: CommonUncertainty,
    /// Sentences on the depths between the lines; `None` if no depth map was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depths_between_lines: Option<String>,
    /// Statement of what these depths are, and what was not corrected.
    pub statement: String,
    /// Report on the logs of a survey of several, and on their agreement; `None` for one log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub logs: Option<LogsReport>,
    /// Warnings of the reader and of every stage.
    pub warnings: Vec<String>,
}

const STATEMENT: &str = "Agreement with the recorded depth is repeatability within one \
     instrument, not accuracy against a reference. first_returns.csv holds depths and ranges as recorded.";

impl Report {
    /// Collects the report; reads every input byte once for its hash.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        survey: &Survey,
        products: &Products,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let Products {
            settings,
            navigation,
            exclusions,
            returns,
            calibration,
            correction,
            cloud,
            classes,
            ..
        } = products;
        let found = |side| returns.side(side).iter().filter(|pick| pick.is_some()).count();
        let classes_of = ClassCounts::of(cloud, classes);
        let above_bottom = cloud.points.iter().filter(|point| point.is_above_bottom());
        let above_bottom_kept = products.kept_points().filter(|point| point.is_above_bottom());
        Ok(Self {
            program: PROGRAM.to_owned(),
            run: String::new(),
            inputs: inputs(survey, products, progress)?,
            format: survey.source.format.clone(),
            start_unix_s: survey.start_unix_s,
            preset: settings.matching_preset().map_or("changed", Preset::name),
            settings: Settings::clone(settings),
            counts: RunCounts {
                pings: survey.side_scan.len(),
                soundings: survey.soundings.len(),
                false_soundings: faults(survey, cloud),
                port_first_returns: found(Side::Port),
                starboard_first_returns: found(Side::Starboard),
                above_bottom: above_bottom.count(),
                above_bottom_left_out: classes_of.count(PointClass::AboveBottom),
                above_bottom_kept: above_bottom_kept.count(),
                low_confidence: classes_of.count(PointClass::Unclassified),
                moving: navigation.moving,
                zero_heading: navigation.zero_heading,
                excluded_pings: exclusions.ping_count(),
                excluded_soundings: exclusions.sounding_count(),
                points: classes_of.all(),
                kept: classes_of.kept(),
                classes: classes_of,
                side_scan_points: classes_of.side_scan,
                swath: SwathCounts::of(survey, navigation, classes_of.swath),
                outliers_removed: classes_of.noise(),
                outliers_removed_share: classes_of.noise_share(),
            },
            excluded: exclusions.stretches.clone(),
            calibration: CalibrationReport::new(calibration),
            track: TrackShare::of(&products.depths, &navigation.pings),
            residuals: residuals(survey, cloud, correction, classes),
            positions: corrected_positions(settings),
            corrections: Vec::new(),
            uncertainty: CommonUncertainty::of_log(products),
            depths_between_lines: None,
            statement: [
                settings.bottom.statement(survey).as_str(),
                correction.statement().as_str(),
                positions(survey, settings).as_str(),
                STATEMENT,
            ]
            .join(" ")
            .trim_start()
            .to_owned(),
            logs: None,
            warnings: warnings(survey, products),
        })
    }

    /// Sets the name of the run from the products and the inputs and settings from which they were
    /// made.
    ///
    /// # Errors
    /// When a setting cannot be written as text.
    pub(crate) fn name_run(&mut self, products: &[Fingerprint]) -> Result<(), serde_json::Error> {
        let made_of = (&self.program, &self.inputs, &self.settings, products);
        let text = serde_json::to_vec(&made_of)?;
        self.run = in_hexadecimal(&Sha256::digest(text)[..RUN_BYTES]);
        Ok(())
    }

    /// Returns the results in a few lines of text.
    pub fn summary(&self) -> String {
        let Self {
            counts,
            excluded,
            calibration,
            track,
            residuals,
            positions,
            corrections,
            logs,
            ..
        } = self;
        let mut lines = vec![
            format!(
                "{} pings: first return port {}, starboard {}; {} above the bottom (weed, fish, boulders)",
                counts.pings,
                counts.port_first_returns,
                counts.starboard_first_returns,
                counts.above_bottom
            ),
            format!(
                "{} points, {} from side-scan; {} count for the depth map; of the others {} are above-bottom returns, {} of low confidence, {} outliers ({:.1} % of {}), {} false soundings; {} pings without heading",
                counts.points,
                counts.side_scan_points,
                counts.kept,
                counts.above_bottom_left_out,
                counts.low_confidence,
                counts.outliers_removed,
                100.0 * counts.outliers_removed_share,
                match counts.swath {
                    Some(_) => "side-scan and swath",
                    None => "side-scan",
                },
                counts.classes.count(PointClass::NoBottom),
                counts.zero_heading
            ),
        ];
        lines.extend(counts.swath.map(|swath| swath.summary()));
        if counts.excluded_pings + counts.excluded_soundings > 0 {
            let of_logs = logs.iter().flat_map(|all| &all.logs);
            let stretches: usize = of_logs.map(|log| log.excluded.len()).sum();
            lines.push(format!(
                "excluded: {} stretches of {} pings and {} soundings",
                excluded.len() + stretches,
                counts.excluded_pings,
                counts.excluded_soundings
            ));
        }
        match logs {
            Some(logs) => lines.push(logs.summary()),
            None => lines.extend(calibration.summary()),
        }
        lines.extend((!positions.is_empty()).then(|| positions.clone()));
        lines.extend(corrections.iter().map(ToString::to_string));
        if track.side_scan_only_pings > 0 && counts.soundings > 0 {
            lines.push(format!(
                "depth comes from side-scan only over {:.0} of {:.0} m of track ({:.0} %): the recorder had no bottom there",
                track.side_scan_only_m,
                track.track_m,
                100.0 * track.side_scan_only()
            ));
        }
        if let Some(residuals) = residuals {
            lines.push(format!(
                "side-scan minus recorded elevation at the same ping: n {}, median {:+.3} m, sd {:.3} m, p95 {:.3} m",
                residuals.n, residuals.median_m, residuals.sd_m, residuals.p95_m
            ));
        }
        lines.join("\n")
    }
}

/// Counts the faults of the soundings that no first return confirms.
fn faults(survey: &Survey, cloud: &PointCloud) -> FaultCounts {
    let confirmed = cloud.points.of(PointSource::DownScan).iter();
    let confirmed = confirmed.filter(|point| point.fault().is_none());
    let confirmed = confirmed.filter_map(|point| point.sounding());
    let confirmed: HashSet<usize> =
        confirmed.filter(|&index| !survey.soundings[index].is_good()).collect();
    let soundings = survey.soundings.iter().enumerate();
    let left_out = soundings.filter(|(index, _)| !confirmed.contains(index));
    FaultCounts::of(left_out.filter_map(|(_, sounding)| sounding.fault))
}

/// Returns all warnings of the reader and the stages, for the report and the window.
pub(super) fn warnings(survey: &Survey, products: &Products) -> Vec<String> {
    let read = survey.warnings.iter().map(|warning| warning.text.clone());
    read.chain(products.bottom_line.warnings.iter().cloned())
        .chain(products.calibration.warnings.iter().cloned())
        .chain(products.correction.refused.iter().map(ToString::to_string))
        .chain(products.correction.gap_warning())
        .chain(products.exclusions.warnings.iter().cloned())
        .chain(products.clutter.and_then(|clutter| clutter.warning()))
        .chain(products.latency_warning())
        .chain(products.repeatability_warning())
        .collect()
}

/// Returns sentences on the source of positions and on their corrections.
fn positions(survey: &Survey, settings: &Settings) -> String {
    let mut said = match &survey.track.external {
        Some(external) => format!(
            "Positions are those of {}, {} s later than it says.",
            external.path.file_name().unwrap_or_default().display(),
            external.offset_s
        ),
        None => "Positions are the recorder's GPS.".to_owned(),
    };
    let system = survey.track.projected.as_ref();
    if let Some(system) = system.and_then(|projected| projected.system.as_ref()) {
        said += &format!(" Its metres are taken for those of {system}.");
    }
    format!("{said} {}", corrected_positions(settings)).trim_end().to_owned()
}

/// Returns the corrections of recorded positions, in sentences; empty if there are none.
fn corrected_positions(settings: &Settings) -> String {
    let compass = settings.heading.source == HeadingSource::Compass;
    let mounting = settings.mounting.statement(compass);
    let both = [mounting, settings.position_shift.statement()].join(" ");
    both.trim().to_owned()
}

/// Returns the files of the log, and those of the water levels and of the isobaths' area if these
/// are in force.
fn inputs(
    survey: &Survey,
    products: &Products,
    progress: &Progress,
) -> Result<Vec<Fingerprint>, Cancelled> {
    let mut inputs = hash_inputs(survey, progress)?;
    let gauge = products.correction.gauge();
    inputs.extend(gauge.map(|gauge| Fingerprint::of_read(&gauge.path, gauge.bytes, &gauge.sha256)));
    let area = products.settings.isobaths.area.as_deref();
    inputs.extend(area.map(|area| Fingerprint::of_read(&area.path, area.bytes, &area.sha256)));
    Ok(inputs)
}
