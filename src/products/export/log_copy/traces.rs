//! Writes the records of a log as a table with a row for each trace: one side of a ping, a ping of
//! a down-looking channel, or a depth.

use bathyscope_log::formats::log_writer::{LogToWrite, Recorded};
use bathyscope_log::formats::parquet_table::{Column, ParquetWriter, Values};
use bathyscope_log::support::calendar::timestamp;
use bathyscope_log::support::geo::{LonLat, compass_deg};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{ChannelKind, Encoding, Fix, PingNav, SideSpan};
use std::fs::File;
use std::io::{self, Write};

/// Number of traces in a group of rows of a Parquet file: some megabytes of samples.
const GROUP_TRACES: usize = 4096;

/// A row of the table.
struct Trace<'a> {
    channel: &'static str,
    /// Index of the ping or the depth in its channel.
    index: usize,
    time_s: f64,
    unix_s: Option<f64>,
    fix: Option<&'a Fix>,
    /// Place of the boat on the fitted track; `None` where there is none.
    fitted: Option<(LonLat, &'a PingNav)>,
    depth_m: f32,
    span: Option<SideSpan>,
}

/// A column of numbers: its name, the number of decimals as text, and the function that returns its
/// value, NaN where there is none.
type NumberColumn = (&'static str, usize, fn(&Trace<'_>) -> f64);

/// Columns of all numbers that a trace can have.
const NUMBERS: [NumberColumn; 17] = [
    ("time_s", 3, |trace| trace.time_s),
    ("lon", 8, |trace| of_fix(trace, |fix| fix.position.lon_deg)),
    ("lat", 8, |trace| of_fix(trace, |fix| fix.position.lat_deg)),
    ("course_deg", 2, |trace| of_fix(trace, |fix| compass_deg(fix.cog_rad.into(), 2))),
    ("compass_deg", 2, |trace| of_fix(trace, |fix| compass_deg(fix.compass_rad.into(), 2))),
    ("speed_mps", 3, |trace| of_fix(trace, |fix| fix.speed_mps.into())),
    ("track_lon", 8, |trace| of_track(trace, |(at, _)| at.lon_deg)),
    ("track_lat", 8, |trace| of_track(trace, |(at, _)| at.lat_deg)),
    ("track_heading_deg", 2, |trace| {
        of_track(trace, |(_, place)| compass_deg(place.heading_rad, 2))
    }),
    ("track_speed_mps", 3, |trace| of_track(trace, |(_, place)| place.speed_mps)),
    ("depth_m", 3, |trace| trace.depth_m.into()),
    ("near_m", 4, |trace| of_span(trace, |span| span.near_m.into())),
    ("far_m", 4, |trace| of_span(trace, |span| span.far_m.into())),
    ("samples", 0, |trace| of_span(trace, |span| span.count.into())),
    ("bits", 0, |trace| of_span(trace, |span| bits(span).into())),
    ("file", 0, |trace| of_span(trace, |span| span.file.into())),
    ("offset", 0, |trace| of_span(trace, |span| span.offset as f64)),
];

fn of_fix(trace: &Trace<'_>, value: impl Fn(&Fix) -> f64) -> f64 {
    trace.fix.map_or(f64::NAN, value)
}

fn of_track(trace: &Trace<'_>, value: impl Fn(&(LonLat, &PingNav)) -> f64) -> f64 {
    trace.fitted.as_ref().map_or(f64::NAN, value)
}

fn of_span(trace: &Trace<'_>, value: impl Fn(&SideSpan) -> f64) -> f64 {
    trace.span.as_ref().map_or(f64::NAN, value)
}

/// Returns the number of bits of a sample in the Parquet file.
fn bits(span: &SideSpan) -> u8 {
    match span.encoding {
        Encoding::U8 => 8,
        _ => 16,
    }
}

/// Returns the largest possible number of rows of a log: a ping may lack a side.
fn trace_count(log: &LogToWrite<'_>) -> usize {
    let survey = log.survey;
    let down = survey.echograms.iter().map(|echogram| echogram.pings.len());
    2 * survey.side_scan.len() + down.sum::<usize>() + survey.soundings.len()
}

/// Returns the rows of a log, ordered by time.
fn traces<'a>(log: &'a LogToWrite<'a>) -> impl Iterator<Item = Trace<'a>> {
    let (survey, navigation) = (log.survey, log.navigation);
    log.records().into_iter().flat_map(move |record| {
        let time_s = record.time_s();
        let place = log.place(time_s);
        let trace = move |channel: &'static str, index: usize, span: Option<SideSpan>| Trace {
            channel,
            index,
            time_s,
            unix_s: survey.start_unix_s.map(|start_s| start_s + time_s),
            fix: log.fix(time_s),
            fitted: place.map(|place| {
                let at = navigation.to_lon_lat(&survey.track, place.east_m, place.north_m);
                (at, place)
            }),
            depth_m: log.depth_m(time_s),
            span,
        };
        let [first, second] = match record {
            Recorded::Side(index, ping) => [("port", ping.port), ("starboard", ping.starboard)]
                .map(|(side, span)| span.map(|span| trace(side, index, Some(span)))),
            Recorded::Down { kind, index, span, .. } => {
                [Some(trace(down(kind), index, Some(*span))), None]
            }
            Recorded::Sounding(index, _) => [Some(trace("sounding", index, None)), None],
        };
        first.into_iter().chain(second)
    })
}

/// Returns the name of a down-looking channel.
fn down(kind: ChannelKind) -> &'static str {
    match kind {
        ChannelKind::Primary => "primary",
        ChannelKind::Secondary => "secondary",
        _ => "down-scan",
    }
}

/// Writes a line for each trace; a field is empty where there is no value. `lon` to `speed_mps` are
/// those of the recorded fix that is valid at the time, `track_*` those of the fitted track,
/// `depth_m` is the nearest recorded depth; `file` and `offset` locate the first sample.
pub(super) fn write_csv(
    log: &LogToWrite<'_>,
    out: &mut impl Write,
    progress: &Progress,
) -> io::Result<()> {
    write!(out, "channel,index,time")?;
    for (name, ..) in NUMBERS {
        write!(out, ",{name}")?;
    }
    writeln!(out)?;
    progress.start(trace_count(log) as u64);
    for trace in traces(log) {
        progress.check().map_err(io::Error::other)?;
        let time = trace.unix_s.map(timestamp).unwrap_or_default();
        write!(out, "{},{},{time}", trace.channel, trace.index)?;
        for (_, decimals, value) in NUMBERS {
            match Some(value(&trace)).filter(|value| value.is_finite()) {
                Some(value) => write!(out, ",{value:.decimals$}")?,
                None => write!(out, ",")?,
            }
        }
        writeln!(out)?;
        progress.advance(1);
    }
    Ok(())
}

/// Writes a row for each trace, with the columns of [`write_csv`] and the `echoes` as bytes from
/// the boat outward: one byte each, or two, little-endian, where `bits` is 16.
pub(super) fn write_parquet(
    log: &LogToWrite<'_>,
    file: File,
    progress: &Progress,
) -> io::Result<()> {
    progress.start(trace_count(log) as u64);
    let mut writer = ParquetWriter::new(file, &columns(log, &[]), &[])?;
    let mut rows = traces(log);
    loop {
        progress.check().map_err(io::Error::other)?;
        let group: Vec<Trace<'_>> = rows.by_ref().take(GROUP_TRACES).collect();
        if group.is_empty() {
            return writer.finish();
        }
        writer.push(&columns(log, &group), 0..group.len())?;
        progress.advance(group.len() as u64);
    }
}

fn columns(log: &LogToWrite<'_>, rows: &[Trace<'_>]) -> Vec<Column> {
    let rows = || rows.iter();
    let microseconds = |unix_s: f64| (unix_s * 1e6).round() as i64;
    let mut columns = vec![
        Column::new("channel", Values::Text(rows().map(|trace| trace.channel).collect())),
        Column::new(
            "index",
            Values::Whole(rows().map(|trace| i32::try_from(trace.index).ok()).collect()),
        ),
        Column::new(
            "time",
            Values::Time(rows().map(|trace| trace.unix_s.map(microseconds)).collect()),
        ),
    ];
    columns.extend(NUMBERS.map(|(name, _, value)| Column::doubles(name, rows().map(value))));
    let samples = rows().map(|trace| stored(log, trace)).collect();
    columns.push(Column::new("echoes", Values::Bytes(samples)));
    columns
}

/// Returns the samples of a trace in the form in which they are written.
fn stored(log: &LogToWrite<'_>, trace: &Trace<'_>) -> Vec<u8> {
    let Some(samples) = trace.span.as_ref().and_then(|span| log.survey.samples_of(span)) else {
        return Vec::new();
    };
    let width = trace.span.map_or(1, |span| usize::from(bits(&span)) / 8);
    let values = (0..samples.len()).map(|index| samples.wide(index).to_le_bytes());
    values.flat_map(|bytes| bytes.into_iter().take(width)).collect()
}
