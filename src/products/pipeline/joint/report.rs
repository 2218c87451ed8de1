//! Makes the `report.json` of a survey of several logs.

use super::{HeightComparison, LogReport, LogsReport, compare_heights, crossline_analysis};
use crate::pipeline::{CommonUncertainty, ProcessedLog, Report, Settings, setting_values};
use bathyscope_bottom::bathymetry::compare::{Comparison, Matching, ReferencePoints};
use bathyscope_bottom::bathymetry::height_offsets::{
    Datum, DepthScale, HeightDifference, PairDifference,
};
use bathyscope_bottom::cloud::{CloudPoint, Residuals, same_ping_differences};
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Survey, apart};
use std::collections::BTreeMap;

const DATUM: &str = "offset_m is what is to be added to the elevations of a log so that it agrees with those that it is connected with; \
     the mean of connected logs is zero. Differences are elevations, the second log minus the first: positive is shallower.";

/// Makes the report of a survey of several logs: counts, track and residuals are of all logs,
/// `format`, `start_unix_s`, settings and `calibration` of the first log, and properties of one log
/// are in the report of that log. `names` are the names of the logs. `None` if there is no log.
///
/// # Errors
/// When the work was cancelled.
pub(crate) fn joint_report(
    logs: &[ProcessedLog],
    names: &[String],
    progress: &Progress,
) -> Result<Option<Report>, Cancelled> {
    let single = |log: &ProcessedLog| Report::new(&log.survey, &log.products, progress);
    let singles = logs.iter().map(single).collect::<Result<Vec<_>, _>>()?;
    let Some(mut all) = singles.first().cloned() else {
        return Ok(None);
    };
    let HeightComparison { contradicted, offsets: found } =
        compare_heights(logs, Datum::Mean, progress)?;
    all.inputs = Vec::new();
    all.excluded = Vec::new();
    all.residuals = Residuals::of(&mut same_ping(logs));
    all.uncertainty = CommonUncertainty::of(logs, progress)?;
    all.warnings = Vec::new();
    let in_force_m: Vec<f64> =
        logs.iter().map(|log| log.products.correction.height_offset_m()).collect();
    let unlevelled = found.unlevelled(&in_force_m).map(|difference| {
        let said = heights_differ(&difference, names);
        format!("{said}; --adjust levels the logs, or height_offset_m of each")
    });
    let mut listed = Vec::new();
    for (index, (single, offset)) in singles.into_iter().zip(found.logs).enumerate() {
        if index > 0 {
            all.counts.add(&single.counts);
            all.track.add(&single.track);
        }
        all.inputs.extend(single.inputs.iter().cloned());
        let warnings = single.warnings.iter();
        all.warnings.extend(warnings.map(|warning| format!("{}: {warning}", names[index])));
        let others = logs.iter().enumerate().filter(|(other, _)| *other != index);
        let against_the_others = compare_logs(&logs[index], others.map(|(_, log)| log), progress)?;
        listed.push(LogReport {
            log: names[index].clone(),
            inputs: single.inputs,
            format: single.format,
            start_unix_s: single.start_unix_s,
            own_settings: own_settings(&logs[0].products.settings, &logs[index].products.settings),
            height_offset_in_force_m: logs[index].products.correction.height_offset_m(),
            offset,
            against_the_others,
            counts: single.counts,
            excluded: single.excluded,
            calibration: single.calibration,
            track: single.track,
            residuals: single.residuals,
            positions: single.positions,
            statement: single.statement,
        });
    }
    all.positions = String::new();
    all.statement = statement(&listed);
    all.warnings.extend(not_one_survey(logs, names));
    all.warnings.extend(not_connected(&listed));
    let left_in = contradicted.iter().map(|soundings| soundings.summary(names));
    all.warnings.extend(left_in.map(|said| format!("{said}; --adjust leaves them out")));
    all.warnings.extend(unlevelled);
    all.warnings.extend(found.scales.iter().map(|scale| depths_scale(scale, names)));
    all.warnings.extend(contradictions(&found.pairs, names));
    all.logs = Some(LogsReport {
        datum: DATUM,
        logs: listed,
        contradicted,
        pairs: found.pairs,
        scales: found.scales,
        crosslines: crossline_analysis(logs, progress)?,
    });
    Ok(Some(all))
}

/// Returns the statement of what the depths of all logs are, once if it is the same for all.
fn statement(logs: &[LogReport]) -> String {
    let first = logs.first().map_or("", |log| log.statement.as_str());
    if logs.iter().all(|log| log.statement == first) {
        return first.to_owned();
    }
    let each = logs.iter().map(|log| format!("{}: {}", log.log, log.statement));
    each.collect::<Vec<_>>().join(" ")
}

/// Returns the elevations of the side-scan points of all logs minus those of the recorded depths at
/// the same pings.
fn same_ping(logs: &[ProcessedLog]) -> Vec<f64> {
    let of_log = |log: &ProcessedLog| {
        let made = &log.products;
        same_ping_differences(&log.survey, &made.cloud, &made.correction, &made.classes)
    };
    logs.iter().flat_map(of_log).collect()
}

/// Returns the settings of another log that differ from those of the first, with their values;
/// `None` for a setting without a value in that log.
fn own_settings(first: &Settings, own: &Settings) -> BTreeMap<String, Option<toml::Value>> {
    let [values, others] = [first, own].map(setting_values);
    let keys = values.keys().chain(others.keys());
    // The log of the excluded stretches is known here: the report is about that log.
    let keys = keys.filter(|key| key.as_str() != "excluded.log");
    let differ = keys.filter(|key| values.get(*key) != others.get(*key));
    let differ = differ.map(|key| (key.clone(), others.get(key).cloned()));
    let mut differ: BTreeMap<_, _> = differ.collect();
    if own.bottom.lines != first.bottom.lines {
        let edits = Some(&own.bottom).filter(|bottom| !bottom.is_empty());
        let edits = edits.and_then(|bottom| toml::Value::try_from(bottom).ok());
        differ.insert("bottom".to_owned(), edits);
    }
    differ
}

/// Returns a sentence on the difference of the depths of two logs in metres; `names` are the names
/// of the logs.
pub fn heights_differ(difference: &HeightDifference, names: &[String]) -> String {
    let [deeper, other] = difference.logs.map(|log| names.get(log).map_or("", String::as_str));
    format!(
        "Depths of {deeper} are {:.3} m deeper than those of {other} where they cross (standard error {:.3} m)",
        difference.difference_m, difference.standard_error_m
    )
}

/// Returns a sentence on the difference of the depths of two logs as a share of the depth; `names`
/// are the names of the logs.
pub fn depths_scale(scale: &DepthScale, names: &[String]) -> String {
    let [deeper, other] = scale.logs.map(|log| names.get(log).map_or("", String::as_str));
    let [least_m, most_m] = scale.depth_m;
    format!(
        "Depths of {deeper} are {:.1} +- {:.1} % greater than those of {other} at {}, {least_m:.1} m to {most_m:.1} m deep: sound speeds that differ by {:.0} m/s do that; set the sound speed or the temperature of the water for each log",
        100.0 * scale.share,
        100.0 * scale.standard_error,
        text::plural(scale.n, "place", "places"),
        scale.share * SOUND_SPEED_M_S
    )
}

/// Usual sound speed in fresh water, metres a second, for converting a share of the depth to a
/// difference of sound speeds.
const SOUND_SPEED_M_S: f64 = 1480.0;

/// Returns a warning that names the logs whose heights cannot be compared with the first; `None` if
/// all can.
fn not_connected(logs: &[LogReport]) -> Option<String> {
    let apart: Vec<&str> =
        logs.iter().filter(|log| log.offset.group != 0).map(|log| log.log.as_str()).collect();
    (!apart.is_empty()).then(|| {
        format!(
            "heights cannot be compared with the first log, since no track leads there by crossings: {}",
            apart.join(", ")
        )
    })
}

/// Returns a warning for every log that is no part of the survey; `names` are the names of the
/// logs.
fn not_one_survey<'a>(
    logs: &[ProcessedLog],
    names: &'a [String],
) -> impl Iterator<Item = String> + 'a {
    let surveys: Vec<&Survey> = logs.iter().map(|log| log.survey.as_ref()).collect();
    let why = apart(&surveys, &vec![false; surveys.len()]);
    let why = names.iter().zip(why);
    why.filter_map(|(name, why)| {
        Some(format!("{name} is no part of this survey, {}: process it by itself", why?))
    })
}

/// Returns a warning for every two logs whose difference no height offset explains; `names` are the
/// names of the logs.
pub fn contradictions<'a>(
    pairs: &'a [PairDifference],
    names: &'a [String],
) -> impl Iterator<Item = String> + 'a {
    let left = pairs.iter().filter(|pair| pair.is_contradiction());
    left.map(|pair| {
        let [one, other] = pair.logs.map(|log| names.get(log).map_or("", String::as_str));
        let (left_m, places) = (pair.residual_m, text::plural(pair.n, "place", "places"));
        format!(
            "{one} and {other} differ by {left_m:+.2} m at {places}, which no height offset explains: look for a clock, a water level or a bottom that changed, and exclude what is wrong"
        )
    })
}

/// Compares the points of a log with the triangulated points of others, all in one plane. Only the
/// points of the depth map are compared, and `surface.max_gap_m` of the log limits the size of a
/// triangle.
///
/// # Errors
/// When the work was cancelled.
fn compare_logs<'a>(
    log: &ProcessedLog,
    others: impl Iterator<Item = &'a ProcessedLog>,
    progress: &Progress,
) -> Result<Comparison, Cancelled> {
    let max_gap_m = log.products.settings.surface.max_gap_m;
    let reference: Vec<[f64; 3]> = others.flat_map(places).collect();
    let reference =
        ReferencePoints::new(reference.iter().copied(), Matching::Surface { max_gap_m });
    let places: Vec<[f64; 3]> = places(log).collect();
    let matches = reference.matches(&places, |place| *place, progress)?;
    Ok(Comparison::new(places.len(), &matches, log.products.correction.middle_level_m))
}

/// Returns east, north and elevation of the points from which the depth map is made.
fn places(log: &ProcessedLog) -> impl Iterator<Item = [f64; 3]> {
    let surface = &log.products.settings.surface;
    let counted = log.products.kept_points();
    let counted = counted.filter(|point| surface.weight(point) > 0.0);
    let places = counted.map(CloudPoint::place);
    places.filter(|place| place.iter().all(|value| value.is_finite()))
}
