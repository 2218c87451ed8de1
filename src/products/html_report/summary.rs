//! Returns the values of the summary: a paragraph on the survey and its results, a row of figures,
//! and the water below each level, as two curves over the depth and as their table; for a survey of
//! several logs, when and what each recorded, and how their heights agree.

use super::ReportData;
use crate::pipeline::ProcessedLog;
use crate::pipeline::joint::LogReport;
use bathyscope_bottom::bathymetry::height_offsets::LogOffset;
use bathyscope_bottom::bathymetry::isobaths::{Storage, storage};
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::presentation::plot::{Axis, Plot, PlotCurve};
use bathyscope_bottom::presentation::text::{
    area, decimal, long_date, long_duration, position, typeset_count as count, typeset_signed, way,
};
use bathyscope_log::support::calendar;
use bathyscope_log::survey::{PingNav, Survey};
use std::collections::BTreeSet;

/// Length of a step above which it is a gap in the log or in the fixes, not a part of the track,
/// metres.
const LONGEST_STEP_M: f64 = 50.0;
/// Number of steps of the levels that the curves go through.
const STEPS: usize = 60;
/// Width and height of each plot, pixels.
const PLOT_PX: [f64; 2] = [360.0, 240.0];

/// Returns the values of the paragraph and of the figures.
pub(super) fn values(from: &ReportData<'_>) -> Value {
    let (counts, track) = (&from.report.counts, &from.report.track);
    let settings = &from.products.settings;
    let has_fixes = !from.survey.track.fixes.is_empty();
    context! {
        recorded => recorded(from),
        begins_at => has_fixes.then(|| position(from.survey.track.frame.origin())),
        points => context! {
            pings => count(counts.pings),
            soundings => count(counts.soundings),
            way => way(from.logs.iter().map(sailed_m).sum()),
            all => count(counts.points),
            kept => count(counts.kept),
            outliers => count(counts.outliers_removed),
            side_scan => count(counts.side_scan_points),
            outliers_percent => format!("{:.1}", 100.0 * counts.outliers_removed_share),
        },
        false_soundings => if_any(counts.false_soundings.all()).map(|count| context! {
            count,
            summary => counts.false_soundings.summary(),
        }),
        side_scan_only => if_any(track.side_scan_only_pings).map(|_| context! {
            way => way(track.side_scan_only_m),
            percent => format!("{:.0}", 100.0 * track.side_scan_only()),
        }),
        low_confidence => if_any(counts.low_confidence).map(|count| context! {
            count,
            limit => format!("{:.2}", settings.first_return.min_confidence),
        }),
        above_bottom => if_any(counts.above_bottom).map(|count| context! {
            count,
            left_out => if_any(counts.above_bottom_left_out),
            ground => if_any(counts.above_bottom_kept).filter(|_| !settings.surface.above_bottom),
            longest_m => settings.surface.longest_above_bottom_m.to_string(),
        }),
        mapped => mapped(from),
        residuals => from.report.residuals.as_ref().map(|residuals| context! {
            median_m => typeset_signed(residuals.median_m, 2),
            sd_m => decimal(residuals.sd_m, 2),
        }),
    }
}

/// Returns a number as text; `None` for 0.
fn if_any(number: usize) -> Option<String> {
    (number > 0).then(|| count(number))
}

/// Returns when the logs were recorded, and in which format.
fn recorded(from: &ReportData<'_>) -> Value {
    let logs = || from.logs.iter().map(|log| &*log.survey);
    let begins = || {
        logs().filter_map(|survey| {
            let (begin_s, _) = survey.time_span_s().unwrap_or((0.0, 0.0));
            survey.start_unix_s.map(|start_s| start_s + begin_s)
        })
    };
    let day = |day_s: Option<f64>| day_s.map(long_date);
    let spans_s = logs().filter_map(Survey::time_span_s);
    let formats: BTreeSet<&str> = logs().map(|survey| survey.source.format.as_str()).collect();
    let (begin_s, end_s) = from.survey.time_span_s().unwrap_or((0.0, 0.0));
    let clock = |start_s: f64| {
        [begin_s, end_s].map(|time_s| calendar::time_of_day(start_s + time_s)[..5].to_owned())
    };
    context! {
        logs => from.logs.len(),
        first_day => day(begins().min_by(f64::total_cmp)),
        last_day => day(begins().max_by(f64::total_cmp)),
        clock => from.survey.start_unix_s.map(clock),
        duration => long_duration(spans_s.map(|(begin_s, end_s)| end_s - begin_s).sum()),
        formats => Vec::from_iter(formats).join(", "),
    }
}

/// Returns the figures of the mapped bottom; `None` without a depth map.
fn mapped(from: &ReportData<'_>) -> Option<Value> {
    let surface = &from.depth_map?.surface;
    let [least_m, most_m] = surface.range_m();
    let known = || surface.depth_m.iter().filter(|depth_m| !depth_m.is_nan());
    let cells = known().count() as f64;
    let sum_m: f64 = known().map(|depth_m| f64::from(*depth_m)).sum();
    let grid = &surface.grid;
    let middle = grid.centre(grid.rows / 2, grid.columns / 2);
    let cell_m2 = grid.cell_m.powi(2) / from.map.area_scale_at(middle);
    let shares = surface.source_shares().map(|share| format!("{:.0} %", 100.0 * share));
    Some(context! {
        least_m => format!("{least_m:.2}"),
        most_m => format!("{most_m:.2}"),
        mean_m => format!("{:.2}", sum_m / cells),
        area => area(cell_m2 * cells),
        volume => volume(cell_m2 * sum_m),
        shares => shares.join(", "),
        error => surface.usual_error_m().map(|error_m| error_m.map(|error_m| decimal(error_m, 2))),
    })
}

fn volume(cubic_m: f64) -> String {
    if cubic_m < 1e6 {
        format!("{} m\u{b3}", count(cubic_m.round() as usize))
    } else {
        format!("{:.2} million m\u{b3}", cubic_m / 1e6)
    }
}

/// Returns the length of the fitted track of a log, metres.
fn sailed_m(log: &ProcessedLog) -> f64 {
    let navigation = &log.products.navigation;
    let pings = if navigation.pings.is_empty() { &navigation.soundings } else { &navigation.pings };
    let step = |pair: &[PingNav]| {
        let metres = (pair[1].east_m - pair[0].east_m).hypot(pair[1].north_m - pair[0].north_m);
        (metres < LONGEST_STEP_M).then_some(metres)
    };
    pings.windows(2).filter_map(step).sum()
}

/// Returns the area and volume of the water below each level, as curves and as rows of a table;
/// `None` without a depth map.
pub(super) fn levels(from: &ReportData<'_>) -> Option<Value> {
    let surface = &from.depth_map?.surface;
    let [least_m, most_m] = surface.range_m();
    let grid = &surface.grid;
    let middle = grid.centre(grid.rows / 2, grid.columns / 2);
    // A square metre of the map is not exactly a square metre on the ground.
    let ground = from.map.area_scale_at(middle).recip();
    let below = |levels: &[f64]| -> Vec<Storage> {
        let mut rows = storage(surface, levels, from.isobaths.clip.as_deref());
        for row in &mut rows {
            row.area_m2 *= ground;
            row.volume_m3 *= ground;
        }
        rows
    };
    let even: Vec<f64> =
        (0..=STEPS).map(|step| least_m + step as f64 / STEPS as f64 * (most_m - least_m)).collect();
    let level = |row: Storage| {
        context! {
            depth_m => format!("{:.2}", row.depth_m),
            area_m2 => count(row.area_m2.round() as usize),
            volume_m3 => count(row.volume_m3.round() as usize),
        }
    };
    Some(context! {
        plots => curves(&below(&even)),
        // The same levels as in `storage.csv`.
        levels => below(&from.isobaths.levels_m).into_iter().map(level).collect::<Vec<Value>>(),
    })
}

/// Draws area and volume, each in a plot whose depth axis points down.
fn curves(rows: &[Storage]) -> Vec<Value> {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return Vec::new();
    };
    let plot = |name: &str, amount: fn(&Storage) -> f64| {
        let mut across = Axis::new(&format!("{name} deeper than"), [0.0, amount(first)]);
        for (value, label) in &mut across.ticks {
            *label = count(value.round() as usize);
        }
        let plot = Plot {
            title: format!("{name} deeper than each level"),
            across,
            up: Axis::new("depth, m", [last.depth_m, first.depth_m]),
            curves: vec![PlotCurve {
                name: name.to_owned(),
                points: rows.iter().map(|row| [amount(row), row.depth_m]).collect(),
            }],
            mark: None,
            limit: None,
        };
        Value::from_safe_string(plot.svg(PLOT_PX))
    };
    vec![plot("area, m\u{b2}", |row| row.area_m2), plot("volume, m\u{b3}", |row| row.volume_m3)]
}

/// Returns the rows of the table of logs; `None` for a single log.
pub(super) fn logs(from: &ReportData<'_>) -> Option<Value> {
    let all = from.report.logs.as_ref()?;
    let crossings = all.crosslines.as_ref().and_then(|found| found.between_logs);
    let rows = all.logs.iter().zip(from.logs).map(|(report, log)| log_row(report, log));
    Some(context! {
        rows => rows.collect::<Vec<Value>>(),
        crossings => crossings.map(|found| context! {
            count => count(found.n),
            median_m => typeset_signed(found.median_m, 3),
            sd_m => format!("{:.3}", found.sd_m),
        }),
    })
}

fn log_row(report: &LogReport, log: &ProcessedLog) -> Value {
    let LogOffset { offset_m, standard_error_m, log_overlaps, .. } = report.offset;
    let is_known = log_overlaps > 0 && report.offset.is_determined();
    let residuals = report.against_the_others.residuals.as_ref();
    context! {
        name => &report.log,
        recorded => span(&log.survey),
        way => way(sailed_m(log)),
        pings => count(report.counts.pings),
        soundings => count(report.counts.soundings),
        excluded => if_any(report.counts.excluded_pings),
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
fn span(survey: &Survey) -> Option<String> {
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
