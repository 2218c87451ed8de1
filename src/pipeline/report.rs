//! `report.json`: what went in, with which settings, what came out, and how far to trust it.

use super::fingerprint::{Fingerprint, Input, hash_inputs, in_hexadecimal};
use super::joint::{LogsReport, RequestedCorrection};
use super::{CommonUncertainty, Preset, Products, Settings};
use crate::bottom::cloud::{
    ClassCounts, PointClass, PointCloud, PointSource, Residuals, SoundingIndex, TrackShare,
    residuals,
};
use crate::sonar::calibration::{Calibration, PingRange, ScaleMode};
use crate::support::progress::{Cancelled, Progress};
use crate::survey::{ExcludedStretch, HeadingSource, Side, Survey, Track};
use serde::Serialize;
use sha2::{Digest as _, Sha256};

/// Bytes of a hash that name a run.
const RUN_BYTES: usize = 8;

/// The record written beside the products. Field names are the contract of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Program and version.
    pub program: String,
    /// Names the run, as the manifest and `report.html` do: the same inputs, settings and products have the same name. Empty
    /// until [`Report::name_run`].
    pub run: String,
    /// The files read.
    pub inputs: Vec<Input>,
    /// Format in words.
    pub format: String,
    /// Unix seconds of the log's time zero.
    pub start_unix_s: Option<f64>,
    /// `published`, `recommended` or `changed`.
    pub preset: &'static str,
    /// Every setting.
    pub settings: Settings,
    /// Counts.
    pub counts: RunCounts,
    /// Stretches that count for nothing, in time order, and why.
    pub excluded: Vec<ExcludedStretch>,
    /// Scales.
    pub calibration: CalibrationReport,
    /// What the depths along the track come from.
    pub track: TrackShare,
    /// Elevation of the kept side-scan points minus that of the recorded depth at the same ping: above 0 is shallower; absent
    /// without any.
    pub residuals: Option<Residuals>,
    /// How recorded positions are corrected, in sentences; empty where they are not, and of several logs, each of which has its own.
    pub positions: String,
    /// What became of the corrections of positions and heights that were asked for.
    pub corrections: Vec<RequestedCorrection>,
    /// What is uncertain in all depths alike, one standard deviation each: it is in the stated error of the map.
    pub uncertainty: CommonUncertainty,
    /// What depths between the lines are, where a depth map was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depths_between_lines: Option<String>,
    /// What these depths are, and what was not corrected.
    pub statement: String,
    /// The logs of a survey of several, and how they agree; absent of one log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub logs: Option<LogsReport>,
    /// Warnings of the reader and of every stage.
    pub warnings: Vec<String>,
}

/// How many of everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunCounts {
    /// Side-scan pings.
    pub pings: usize,
    /// Depths that the recorder gave.
    pub soundings: usize,
    /// Of these, depths written while the recorder had lost the bottom, and confirmed by no first return.
    pub soundings_without_bottom: usize,
    /// Pings with a port first return.
    pub port_first_returns: usize,
    /// Pings with a starboard first return.
    pub starboard_first_returns: usize,
    /// First returns above the recorded depth: weed, fish or boulders.
    pub above_bottom: usize,
    /// Points of these that do not count for the depth map, neither outliers nor of too low confidence.
    pub above_bottom_left_out: usize,
    /// Points of these that count for the depth map: all, or those of long stretches.
    pub above_bottom_kept: usize,
    /// Side-scan points that are not kept because the confidence of their first return is less than `first_return.min_confidence`.
    pub low_confidence: usize,
    /// Pings at which the boat moves.
    pub moving: usize,
    /// Pings without a heading.
    pub zero_heading: usize,
    /// Side-scan pings that are excluded.
    pub excluded_pings: usize,
    /// Soundings that are excluded.
    pub excluded_soundings: usize,
    /// Points, whatever their class.
    pub points: usize,
    /// Points that count for the depth map: `kept` of `cloud.csv`, class 40 of every file.
    pub kept: usize,
    /// Points by the code of their class.
    pub classes: ClassCounts,
    /// Points that are not soundings.
    pub side_scan_points: usize,
    /// Points that the filter removed.
    pub outliers_removed: usize,
    /// Removed share of the side-scan points, 0 to 1.
    pub outliers_removed_share: f64,
}

/// The scales, flat, as scripts want them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CalibrationReport {
    /// `flat_spot` or `header`.
    pub mode: ScaleMode,
    /// Pixels (u8 samples) per metre at the flat spot.
    pub ppd_px_per_m: Option<f64>,
    /// Its robust standard deviation.
    pub ppd_spread_px_per_m: Option<f64>,
    /// Picks behind it.
    pub ppd_picks: usize,
    /// What a metre of the header measures at the flat spot.
    pub ppd_factor: Option<f64>,
    /// Pings of the flat spot, `A..B`.
    pub pings: Option<PingRange>,
    /// Recorded depth at the flat spot.
    pub flat_spot_depth_m: Option<f64>,
    /// Pixels per metre that the headers imply.
    pub header_px_per_m: Option<f64>,
    /// Its spread over the log: above zero when the range changed.
    pub header_spread_px_per_m: Option<f64>,
    /// Slope of range against depth.
    pub k: Option<f64>,
    /// Offset of range against depth.
    pub b_m: Option<f64>,
    /// Taken off every slant range, metres (`calibration.offset`).
    pub offset_m: f64,
    /// The offset that the log shows, in force or not, metres.
    pub offset_measured_m: Option<f64>,
    /// How far it may be off by its scatter, metres.
    pub offset_uncertainty_m: Option<f64>,
    /// Why none is taken off.
    pub offset_note: Option<&'static str>,
    /// Robust standard deviation about that line.
    pub fit_spread_m: Option<f64>,
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
        let found = |side| {
            returns
                .side(side)
                .iter()
                .filter(|pick| pick.is_some())
                .count()
        };
        let classes_of = ClassCounts::of(cloud, classes);
        let above_bottom = cloud.points.iter().filter(|point| point.above_bottom);
        let above_bottom_kept = products.kept_points().filter(|point| point.above_bottom);
        Ok(Self {
            program: format!("bathyscope {}", env!("CARGO_PKG_VERSION")),
            run: String::new(),
            inputs: inputs(survey, products, progress)?,
            format: survey.source.format.clone(),
            start_unix_s: survey.start_unix_s,
            preset: settings.matching_preset().map_or("changed", Preset::name),
            settings: Settings::clone(settings),
            counts: RunCounts {
                pings: survey.side_scan.len(),
                soundings: survey.soundings.len(),
                soundings_without_bottom: lost_soundings(survey, cloud),
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
                outliers_removed: classes_of.noise(),
                outliers_removed_share: classes_of.noise_share(),
            },
            excluded: exclusions.stretches.clone(),
            calibration: CalibrationReport::new(calibration),
            track: TrackShare::of(&products.depths, &navigation.pings),
            residuals: residuals(survey, cloud, correction, classes),
            positions: corrected_positions(settings),
            corrections: Vec::new(),
            uncertainty: CommonUncertainty::of_log(survey, products),
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

    /// Takes over the products of the run, and names it after them and what they were made from.
    ///
    /// # Errors
    /// When a setting cannot be written as text.
    pub fn name_run(&mut self, products: &[Fingerprint]) -> Result<(), serde_json::Error> {
        let made_of = (&self.program, &self.inputs, &self.settings, products);
        let text = serde_json::to_vec(&made_of)?;
        self.run = in_hexadecimal(&Sha256::digest(text)[..RUN_BYTES]);
        Ok(())
    }

    /// What came out, in a few lines for people.
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
                "{} points, {} from side-scan; {} count for the depth map; of the others {} are above-bottom returns, {} of low confidence, {} outliers ({:.1} % of side-scan), {} soundings without bottom; {} pings without heading",
                counts.points,
                counts.side_scan_points,
                counts.kept,
                counts.above_bottom_left_out,
                counts.low_confidence,
                counts.outliers_removed,
                100.0 * counts.outliers_removed_share,
                counts.classes.count(PointClass::NoBottom),
                counts.zero_heading
            ),
        ];
        if counts.excluded_pings + counts.excluded_soundings > 0 {
            lines.push(format!(
                "excluded: {} stretches of {} pings and {} soundings",
                excluded.len(),
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

/// Soundings without bottom lock that do not count.
fn lost_soundings(survey: &Survey, cloud: &PointCloud) -> usize {
    let lost = survey.soundings.iter().filter(|sounding| !sounding.locked);
    let points = cloud.points.of(PointSource::DownScan).iter();
    let counts = points.filter(|point| point.reliable);
    let of_lost = counts.filter(|point| {
        let sounding = point.sounding.map(SoundingIndex::get);
        sounding.is_some_and(|index| !survey.soundings[index].locked)
    });
    lost.count() - of_lost.count()
}

impl RunCounts {
    /// Adds those of another log.
    pub(super) fn add(&mut self, other: &Self) {
        self.pings += other.pings;
        self.soundings += other.soundings;
        self.soundings_without_bottom += other.soundings_without_bottom;
        self.port_first_returns += other.port_first_returns;
        self.starboard_first_returns += other.starboard_first_returns;
        self.above_bottom += other.above_bottom;
        self.above_bottom_left_out += other.above_bottom_left_out;
        self.above_bottom_kept += other.above_bottom_kept;
        self.low_confidence += other.low_confidence;
        self.moving += other.moving;
        self.zero_heading += other.zero_heading;
        self.excluded_pings += other.excluded_pings;
        self.excluded_soundings += other.excluded_soundings;
        self.points += other.points;
        self.kept += other.kept;
        self.classes.add(&other.classes);
        self.side_scan_points += other.side_scan_points;
        self.outliers_removed += other.outliers_removed;
        self.outliers_removed_share = self.classes.noise_share();
    }
}

impl CalibrationReport {
    /// The scale in force first, and what is done to the ranges; `None` where nothing gives a scale.
    fn summary(&self) -> Option<String> {
        let header = (self.header_px_per_m).map(|px| format!("as recorded {px:.2} px/m"));
        let flat_spot = (self.ppd_px_per_m.zip(self.ppd_spread_px_per_m))
            .map(|(ppd, spread)| format!("flat spot {ppd:.2} +- {spread:.2} px/m"));
        let [first, second] = match self.mode {
            ScaleMode::Header => [header, flat_spot],
            ScaleMode::FlatSpot => [flat_spot, header],
        };
        let first = first?;
        let second = second.map_or(String::new(), |second| format!("; not in force: {second}"));
        let offset = match self.offset_m {
            0.0 => String::new(),
            offset_m => format!(", range offset {:+.2} m", -offset_m),
        };
        Some(format!("scale: {first}{offset}{second}"))
    }

    fn new(calibration: &Calibration) -> Self {
        let Calibration {
            mode,
            flat_spot,
            header,
            fit,
            offset_m,
            measured_offset,
            offset_note,
            ..
        } = calibration;
        let ppd = calibration.ppd();
        Self {
            mode: *mode,
            ppd_px_per_m: ppd.map(|scale| scale.px_per_m),
            ppd_spread_px_per_m: ppd.map(|scale| scale.spread_px_per_m),
            ppd_picks: ppd.map_or(0, |scale| scale.picks),
            ppd_factor: calibration.factor(),
            pings: flat_spot.as_ref().map(|spot| PingRange {
                start: spot.pings.start,
                end: spot.pings.end,
            }),
            flat_spot_depth_m: flat_spot.as_ref().map(|spot| spot.depth_m),
            header_px_per_m: header.map(|scale| scale.px_per_m),
            header_spread_px_per_m: header.map(|scale| scale.spread_px_per_m),
            offset_m: *offset_m,
            offset_measured_m: measured_offset.map(|measured| measured.offset_m),
            offset_uncertainty_m: measured_offset.map(|measured| measured.uncertainty_m),
            offset_note: *offset_note,
            k: fit.map(|fit| fit.k),
            b_m: fit.map(|fit| fit.b_m),
            fit_spread_m: fit.map(|fit| fit.spread_m),
        }
    }
}

/// All warnings of the reader and the stages, for the report and the window.
pub fn warnings(survey: &Survey, products: &Products) -> Vec<String> {
    let read = survey.warnings.iter().map(|warning| warning.text.clone());
    read.chain(products.bottom_line.warnings.iter().cloned())
        .chain(products.calibration.warnings.iter().cloned())
        .chain(products.correction.refused().map(ToString::to_string))
        .chain(products.exclusions.warnings.iter().cloned())
        .collect()
}

/// Whose positions they are, and how the recorder is mounted.
fn positions(survey: &Survey, settings: &Settings) -> String {
    let mut said = whose(&survey.track);
    let system = survey.track.projected.as_ref();
    if let Some(system) = system.and_then(|projected| projected.system.as_ref()) {
        said += &format!(" Its metres are taken for those of {system}.");
    }
    format!("{said} {}", corrected_positions(settings))
        .trim_end()
        .to_owned()
}

/// How recorded positions are corrected; empty where they are not.
fn corrected_positions(settings: &Settings) -> String {
    let compass = settings.heading.source == HeadingSource::Compass;
    let mounting = settings.mounting.statement(compass);
    let both = [mounting, settings.position_shift.statement()].join(" ");
    both.trim().to_owned()
}

fn whose(track: &Track) -> String {
    match &track.external {
        Some(external) => format!(
            "Positions are those of {}, {} s later than it says.",
            external.path.file_name().unwrap_or_default().display(),
            external.offset_s
        ),
        None => "Positions are the recorder's GPS.".to_owned(),
    }
}

/// The log's files, and the readings of the water level and the area of the isobaths where they are in force.
fn inputs(
    survey: &Survey,
    products: &Products,
    progress: &Progress,
) -> Result<Vec<Input>, Cancelled> {
    let mut inputs = hash_inputs(survey, progress)?;
    inputs.extend(products.correction.gauge().map(|gauge| Input {
        file: gauge.path.display().to_string(),
        bytes: gauge.bytes,
        sha256: gauge.sha256.clone(),
    }));
    let area = products.settings.isobaths.area.as_deref();
    inputs.extend(area.map(|area| Input {
        file: area.path.display().to_string(),
        bytes: area.bytes,
        sha256: area.sha256.clone(),
    }));
    Ok(inputs)
}
