//! Summarises the survey and its results in a paragraph and a row of figures.

use super::{ReportData, objects};
use crate::pipeline::ProcessedLog;
use bathyscope_bottom::presentation::text::{
    area, decimal, long_date, long_duration, position, typeset_count as count, typeset_signed, way,
};
use bathyscope_log::support::calendar;
use bathyscope_log::support::printable::xml;
use bathyscope_log::survey::{PingNav, Survey};
use std::collections::BTreeSet;

/// Length of a step above which it is a gap in the log or in the fixes, not a part of the track,
/// metres.
const LONGEST_STEP_M: f64 = 50.0;

/// Returns the title, the paragraph and the figures.
pub(super) fn summary(from: &ReportData<'_>) -> String {
    let mut html = format!("<h1>Survey {}</h1>\n<p class=\"lead\">", xml(&from.title));
    html += &sentences(from);
    html += "</p>\n<div class=\"figures\">\n";
    for (value, what) in figures(from) {
        html += &format!("<div><b>{value}</b><span>{what}</span></div>\n");
    }
    html + "</div>\n"
}

/// Describes when the survey was recorded, and in which format.
fn recorded(from: &ReportData<'_>) -> String {
    let begin_s = |survey: &Survey| {
        let begin_s = survey.time_span_s().unwrap_or((0.0, 0.0)).0;
        survey.start_unix_s.map(|start_s| start_s + begin_s)
    };
    let logs = || from.logs.iter().map(|log| &*log.survey);
    if from.logs.len() > 1 {
        let formats: BTreeSet<&str> = logs().map(|survey| survey.source.format.as_str()).collect();
        let formats: Vec<&str> = formats.into_iter().collect();
        let known = || logs().filter_map(begin_s);
        let days =
            [known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max)];
        let when = match days.map(|day_s| day_s.is_finite().then(|| long_date(day_s))) {
            [Some(first), Some(last)] if first == last => format!(" on {first}"),
            [Some(first), Some(last)] => format!(" from {first} to {last}"),
            _ => String::new(),
        };
        let spans = logs().filter_map(Survey::time_span_s);
        let duration_s: f64 = spans.map(|(begin_s, end_s)| end_s - begin_s).sum();
        return format!(
            "Recorded in {} logs{when} ({} in all), {}.",
            from.logs.len(),
            long_duration(duration_s),
            xml(&formats.join(", "))
        );
    }
    let survey = from.survey;
    let (begin_s, end_s) = survey.time_span_s().unwrap_or((0.0, 0.0));
    let when = survey.start_unix_s.map_or(
        ", at a time that the log does not state".to_owned(),
        |start_s| {
            let clock = |time_s: f64| calendar::time_of_day(start_s + time_s)[..5].to_owned();
            format!(
                " on {}, {} to {} UTC",
                long_date(start_s + begin_s),
                clock(begin_s),
                clock(end_s)
            )
        },
    );
    format!("Recorded{when} ({}), {}.", long_duration(end_s - begin_s), xml(&survey.source.format))
}

fn sentences(from: &ReportData<'_>) -> String {
    let (survey, counts) = (from.survey, &from.report.counts);
    let mut text = recorded(from);
    let place = survey.track.frame.origin();
    if !survey.track.fixes.is_empty() {
        let what = match from.logs.len() {
            1 => "The log",
            _ => "The first log",
        };
        text += &format!(" {what} begins at {}.", position(place));
    }
    text += &format!(
        " {} side-scan pings and {} soundings along {} of track gave {} points, of which {} count for the depth map; {} of the {} side-scan points ({:.1} %) were set aside as outliers.",
        count(counts.pings),
        count(counts.soundings),
        way(from.logs.iter().map(sailed_m).sum()),
        count(counts.points),
        count(counts.kept),
        count(counts.outliers_removed),
        count(counts.side_scan_points),
        100.0 * counts.outliers_removed_share,
    );
    if counts.false_soundings.all() > 0 {
        text += &format!(
            " {} soundings are false and were not used: {}.",
            count(counts.false_soundings.all()),
            counts.false_soundings.summary()
        );
    }
    let track = &from.report.track;
    if track.side_scan_only_pings > 0 {
        text += &format!(
            " Over {} of the track ({:.0} %) depth comes from side-scan only.",
            way(track.side_scan_only_m),
            100.0 * track.side_scan_only(),
        );
    }
    if counts.low_confidence > 0 {
        text += &format!(
            " {} first returns have a confidence below {:.2} and were set aside.",
            count(counts.low_confidence),
            from.products.settings.first_return.min_confidence,
        );
    }
    if counts.above_bottom > 0 {
        text += &above_bottom(from);
    }
    text
}

/// Describes the use of first returns above the recorded depth.
fn above_bottom(from: &ReportData<'_>) -> String {
    let counts = &from.report.counts;
    let mut text = format!(
        " {} first returns are nearer than the recorded depth (weed, fish or boulders).",
        count(counts.above_bottom)
    );
    if counts.above_bottom_left_out > 0 {
        text += &format!(
            " {} of them are points of the class 64, which do not count for the depth map.",
            count(counts.above_bottom_left_out)
        );
    }
    if counts.above_bottom_kept > 0 && !from.products.settings.surface.above_bottom {
        text += &format!(
            " {} go on for more than {} m along the track and count as ground (surface.longest_above_bottom_m).",
            count(counts.above_bottom_kept),
            from.products.settings.surface.longest_above_bottom_m
        );
    }
    text
}

/// Returns the figures, each a value with its unit, and a description.
fn figures(from: &ReportData<'_>) -> Vec<(String, &'static str)> {
    let mut figures = Vec::new();
    if let Some(surface) = from.depth_map.map(|depth_map| &depth_map.surface) {
        let [least_m, most_m] = surface.range_m();
        let known: Vec<f64> = surface
            .depth_m
            .iter()
            .filter(|depth_m| !depth_m.is_nan())
            .map(|depth_m| f64::from(*depth_m))
            .collect();
        let grid = &surface.grid;
        let middle = grid.centre(grid.rows / 2, grid.columns / 2);
        let cell_m2 = grid.cell_m.powi(2) / from.map.area_scale_at(middle);
        let sum_m: f64 = known.iter().sum();
        figures.extend([
            (format!("{least_m:.2} to {most_m:.2} m"), "depth"),
            (format!("{:.2} m", sum_m / known.len() as f64), "mean depth of the mapped bottom"),
            (area(cell_m2 * known.len() as f64), "mapped"),
            (volume(cell_m2 * sum_m), "water above the mapped bottom"),
        ]);
        let shares = surface.source_shares();
        let shares = shares.map(|share| format!("{:.0} %", 100.0 * share));
        figures.push((
            shares.join(", "),
            "of the mapped bottom in cells with a sounding, in cells with a first return alone, from echo levels between them, and interpolated",
        ));
        if let Some([half_m, most_m]) = surface.usual_error_m() {
            figures.push((
                format!("\u{b1} {} m, \u{b1} {} m", decimal(half_m, 2), decimal(most_m, 2)),
                "error of a mapped depth, as depths that were left out show it: half of the map, nine tenths of it (standard deviation)",
            ));
        }
    }
    if let Some(residuals) = &from.report.residuals {
        figures.push((
            format!(
                "{} \u{b1} {} m",
                typeset_signed(residuals.median_m, 2),
                decimal(residuals.sd_m, 2)
            ),
            "side-scan minus recorded elevation at the same ping (above 0 is shallower), median \u{b1} standard deviation",
        ));
    }
    if from.objects.is_some() {
        let what =
            if objects::is_reviewed(from) { "objects" } else { "objects proposed, not reviewed" };
        figures.push((count(objects::count(from)), what));
    }
    figures
}

fn volume(cubic_m: f64) -> String {
    if cubic_m < 1e6 {
        format!("{} m\u{b3}", count(cubic_m.round() as usize))
    } else {
        format!("{:.2} million m\u{b3}", cubic_m / 1e6)
    }
}

/// Returns the length of the fitted track of a log, metres.
pub(super) fn sailed_m(log: &ProcessedLog) -> f64 {
    let navigation = &log.products.navigation;
    let pings = if navigation.pings.is_empty() { &navigation.soundings } else { &navigation.pings };
    let step = |pair: &[PingNav]| {
        let metres = (pair[1].east_m - pair[0].east_m).hypot(pair[1].north_m - pair[0].north_m);
        (metres < LONGEST_STEP_M).then_some(metres)
    };
    pings.windows(2).filter_map(step).sum()
}
