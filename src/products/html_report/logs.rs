//! Makes the section on the logs of a survey of several: when and what each recorded, and how their
//! heights agree.

use super::ReportData;
use super::summary::sailed_m;
use crate::pipeline::ProcessedLog;
use crate::pipeline::joint::{LogReport, LogsReport};
use bathyscope_bottom::bathymetry::height_offsets::LogOffset;
use bathyscope_bottom::presentation::text::{
    long_date, typeset_count as count, typeset_signed, way,
};
use bathyscope_log::support::calendar;
use bathyscope_log::support::printable::xml;
use bathyscope_log::survey::Survey;
use std::collections::BTreeSet;

/// Returns the table of logs; empty for a single log.
pub(super) fn section(from: &ReportData<'_>) -> String {
    let Some(all) = &from.report.logs else {
        return String::new();
    };
    let mut html = String::from(
        "<h2>The logs</h2>\n<table><tr><th class=\"text\">log</th><th class=\"text\">recorded, UTC</th><th>track</th><th>pings</th><th>soundings</th>\
         <th>excluded</th><th>recorded depth, m</th><th>height offset, m</th><th>in force, m</th><th>overlaps</th><th>against the others, m</th><th>95 %, m</th></tr>\n",
    );
    for (report, log) in all.logs.iter().zip(from.logs) {
        html += &line(report, log);
    }
    html += "</table>\n";
    html + &agreement(all)
}

fn line(report: &LogReport, log: &ProcessedLog) -> String {
    let LogOffset { offset_m, standard_error_m, log_overlaps, .. } = report.offset;
    let offset = match (log_overlaps, report.offset.is_determined()) {
        (0, _) => "unknown".to_owned(),
        (_, false) => "not determined".to_owned(),
        _ => format!("{} \u{b1} {standard_error_m:.3}", typeset_signed(offset_m, 3)),
    };
    let (median, p95) = match &report.against_the_others.residuals {
        Some(found) => (typeset_signed(found.median_m, 3), format!("{:.3}", found.p95_m)),
        None => ("apart".to_owned(), String::new()),
    };
    let excluded = match report.counts.excluded_pings {
        0 => String::new(),
        pings => count(pings),
    };
    format!(
        "<tr><td class=\"text\">{}</td><td class=\"text\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{excluded}</td><td>{}</td><td>{offset}</td><td>{}</td><td>{}</td><td>{median}</td><td>{p95}</td></tr>\n",
        xml(&report.log),
        recorded(&log.survey),
        way(sailed_m(log)),
        count(report.counts.pings),
        count(report.counts.soundings),
        depths(&log.survey),
        typeset_signed(report.height_offset_in_force_m, 3),
        count(log_overlaps),
    )
}

/// Returns the date of a log and the times of day at which it begins and ends.
fn recorded(survey: &Survey) -> String {
    let (begin_s, end_s) = survey.time_span_s().unwrap_or((0.0, 0.0));
    let Some(start_s) = survey.start_unix_s else {
        return "at a time that the log does not state".to_owned();
    };
    let clock = |time_s: f64| calendar::time_of_day(start_s + time_s)[..5].to_owned();
    format!("{}, {} to {}", long_date(start_s + begin_s), clock(begin_s), clock(end_s))
}

/// Returns the least and the greatest depth with bottom lock.
fn depths(survey: &Survey) -> String {
    let locked = survey.soundings.iter().filter(|sounding| sounding.is_good());
    let span = locked.fold(None, |span: Option<[f32; 2]>, one| {
        let [least, most] = span.unwrap_or([one.depth_m; 2]);
        Some([least.min(one.depth_m), most.max(one.depth_m)])
    });
    span.map_or_else(String::new, |[least_m, most_m]| format!("{least_m:.1} to {most_m:.1}"))
}

/// Explains the columns of the table and reports the differences at crossings.
fn agreement(all: &LogsReport) -> String {
    let mut html = String::from(
        "<p>The height offset is what is to be added to the elevations of a log so that it agrees with the others where their tracks meet, \
         with its standard error; the mean of connected logs is zero. In force is what was added. The last columns hold the points of a log \
         against those of all others, with the offsets in force: median, and what 95 % do not exceed.",
    );
    let between = all.crosslines.as_ref().and_then(|found| found.between_logs);
    match between {
        Some(found) => {
            html += &format!(
                " At {} crossings of two logs the depths differ by {} m in the median, with a standard deviation of {:.3} m.",
                count(found.n),
                typeset_signed(found.median_m, 3),
                found.sd_m
            )
        }
        None => html += " No track of one log crosses that of another.",
    }
    html + "</p>\n"
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
