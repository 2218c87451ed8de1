//! Returns the values on the logs of a survey of several: when and what each recorded, and how
//! their heights agree.

use super::ReportData;
use super::summary::sailed_m;
use crate::pipeline::ProcessedLog;
use crate::pipeline::joint::LogReport;
use bathyscope_bottom::bathymetry::height_offsets::LogOffset;
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::presentation::text::{
    long_date, typeset_count as count, typeset_signed, way,
};
use bathyscope_log::support::calendar;
use bathyscope_log::survey::Survey;
use std::collections::BTreeSet;

/// Returns the rows of the table of logs; `None` for a single log.
pub(super) fn values(from: &ReportData<'_>) -> Option<Value> {
    let all = from.report.logs.as_ref()?;
    let crossings = all.crosslines.as_ref().and_then(|found| found.between_logs);
    let rows = all.logs.iter().zip(from.logs).map(|(report, log)| row(report, log));
    Some(context! {
        rows => rows.collect::<Vec<Value>>(),
        crossings => crossings.map(|found| context! {
            count => count(found.n),
            median_m => typeset_signed(found.median_m, 3),
            sd_m => format!("{:.3}", found.sd_m),
        }),
    })
}

fn row(report: &LogReport, log: &ProcessedLog) -> Value {
    let LogOffset { offset_m, standard_error_m, log_overlaps, .. } = report.offset;
    let is_known = log_overlaps > 0 && report.offset.is_determined();
    let residuals = report.against_the_others.residuals.as_ref();
    let excluded = report.counts.excluded_pings;
    context! {
        name => &report.log,
        recorded => recorded(&log.survey),
        way => way(sailed_m(log)),
        pings => count(report.counts.pings),
        soundings => count(report.counts.soundings),
        excluded => (excluded > 0).then(|| count(excluded)),
        depths => depths(&log.survey).map(|range_m| range_m.map(|depth_m| format!("{depth_m:.1}"))),
        offset => is_known.then(|| [typeset_signed(offset_m, 3), format!("{standard_error_m:.3}")]),
        in_force_m => typeset_signed(report.height_offset_in_force_m, 3),
        has_overlaps => log_overlaps > 0,
        overlaps => count(log_overlaps),
        against => residuals.map(|found| context! {
            median_m => typeset_signed(found.median_m, 3),
            p95_m => format!("{:.3}", found.p95_m),
        }),
    }
}

/// Returns the date of a log and the times of day at which it begins and ends; `None` where the
/// log states no time.
fn recorded(survey: &Survey) -> Option<String> {
    let (begin_s, end_s) = survey.time_span_s().unwrap_or((0.0, 0.0));
    let start_s = survey.start_unix_s?;
    let clock = |time_s: f64| calendar::time_of_day(start_s + time_s)[..5].to_owned();
    Some(format!("{}, {} to {}", long_date(start_s + begin_s), clock(begin_s), clock(end_s)))
}

/// Returns the least and the greatest depth with bottom lock, metres.
fn depths(survey: &Survey) -> Option<[f32; 2]> {
    let locked = survey.soundings.iter().filter(|sounding| sounding.is_good());
    let depths_m = locked.map(|sounding| [sounding.depth_m; 2]);
    depths_m.reduce(|[least, most], [a, b]| [least.min(a), most.max(b)])
}

/// Describes the corrections of all logs, applied or not; refers to another section where they
/// differ from log to log.
pub(super) fn correction(from: &ReportData<'_>) -> String {
    let statements = (from.logs.iter()).map(|log| log.products.correction.statement());
    let statements: BTreeSet<String> = statements.collect();
    match statements.len() {
        1 => statements.into_iter().collect(),
        _ => "Corrections differ from log to log; see how far to trust it.".to_owned(),
    }
}
