//! `bathyscope info`: prints what is in a log, or the formats of logs that can be read.

use super::{Failure, output};
use bathyscope_bottom::calibration::header_scale;
use bathyscope_log::formats::{self, FORMATS, FileRole, FormatEntry};
use bathyscope_log::support::calendar;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Channel, SideScanState, Survey, Warning};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// `bathyscope info SURVEY [--json]`, `bathyscope info --formats [--json]`.
#[derive(Debug, clap::Args)]
pub(super) struct InfoArgs {
    /// The log to look into, or a folder of logs to list
    #[arg(required_unless_present = "formats")]
    survey: Option<PathBuf>,
    /// List the formats of logs that can be read
    #[arg(long, conflicts_with = "survey")]
    formats: bool,
    /// Print JSON for scripts
    #[arg(long)]
    json: bool,
}

/// Prints the summary of a log, a line for each log of a folder, or the formats.
pub(super) fn run(args: InfoArgs) -> Result<(), Failure> {
    let Some(survey) = &args.survey else {
        return print_formats(args.json);
    };
    let logs = formats::logs_in(survey);
    if logs.len() > 1 {
        return if args.json {
            output::results(format_args!("{:#}", list_to_json(&logs)))
        } else {
            output::results(list_to_text(survey, &logs))
        };
    }
    let survey = formats::open(survey, &Progress::new())?;
    if args.json {
        output::json(&to_json(&survey))
    } else {
        output::results(to_text(&survey).trim_end())
    }
}

/// Prints the formats, as text or as JSON for scripts.
fn print_formats(as_json: bool) -> Result<(), Failure> {
    let formats = FORMATS.iter();
    if as_json {
        output::json(&formats.map(format_to_json).collect::<Value>())
    } else {
        let texts: Vec<String> = formats.map(format_to_text).collect();
        output::results(texts.join("\n").trim_end())
    }
}

fn list_to_json(logs: &[PathBuf]) -> Value {
    let each = logs.iter().map(|log| match formats::open(log, &Progress::new()) {
        Ok(survey) => to_json(&survey),
        Err(error) => json!({ "files": [log.to_string_lossy()], "error": error.to_string() }),
    });
    each.collect()
}

fn list_to_text(folder: &Path, logs: &[PathBuf]) -> String {
    let mut text = format!("{} logs in this folder:\n", logs.len());
    for log in logs {
        let name = log.file_name().unwrap_or(log.as_os_str()).display();
        let what = match formats::open(log, &Progress::new()) {
            Ok(survey) => format!(
                "{}, start {}, side-scan {}",
                survey.source.format,
                survey.start_unix_s.map_or("unknown".to_owned(), utc),
                side_scan_sentence(&survey)
            ),
            Err(error) => error.to_string(),
        };
        text += &format!("{name}: {what}\n");
    }
    let folder = folder.display();
    text + &format!(
        "`bathyscope info` describes one of them in full, `bathyscope process {folder} -o OUT` processes each"
    )
}

/// Characters of the longest usual channel name, `side-scan starboard (STBDLF)`.
const CHANNEL_WIDTH: usize = 28;

/// Returns a count with its noun: `1 warning`, `2 warnings`.
fn counted(count: usize, what: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {what}{ending}")
}

/// Returns the number of side-scan pings as text, or why the log has none that are usable.
fn side_scan_sentence(survey: &Survey) -> String {
    match survey.side_scan_state {
        SideScanState::Usable => {
            let pings = &survey.side_scan;
            let port = pings.iter().filter(|ping| ping.port.is_some()).count();
            let starboard = pings.iter().filter(|ping| ping.starboard.is_some()).count();
            let pings = counted(pings.len(), "ping");
            format!("{pings} (port {port}, starboard {starboard})")
        }
        SideScanState::Absent => "none in this log".to_owned(),
        SideScanState::Noise { range_m } => {
            format!("noise only: the range is stuck at {range_m:.2} m, as without a transducer")
        }
    }
}

fn depth_span(survey: &Survey) -> Option<(f32, f32)> {
    survey.soundings.iter().map(|sounding| sounding.depth_m).fold(None, |span, depth| {
        let (low, high) = span.unwrap_or((depth, depth));
        Some((f32::min(low, depth), f32::max(high, depth)))
    })
}

/// Returns the number of depths across the track, and of those that the recorder marks as
/// unreliable.
fn swath_depths(survey: &Survey) -> [usize; 2] {
    let counts = survey.swath.iter();
    let counts = counts.map(|ping| [ping.len(), usize::from(ping.unreliable)]);
    counts.fold([0; 2], |[a, b], [c, d]| [a + c, b + d])
}

fn to_text(survey: &Survey) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        text += &format!("{name:<12} {value}\n");
    };
    line("format", survey.source.format.clone());
    if !survey.source.device.is_empty() {
        line("device", survey.source.device.clone());
    }
    line("bytes", survey.source.byte_count.to_string());
    line("start", survey.start_unix_s.map_or("unknown".to_owned(), utc));
    if let Some((from, to)) = survey.time_span_s() {
        line("time", format!("{from:.3} s to {to:.3} s ({:.1} s)", to - from));
    }
    line("side-scan", side_scan_sentence(survey));
    if let Some(scale) = header_scale(survey) {
        line("scale", format!("{:.2} samples a metre, as recorded", scale.px_per_m));
    }
    match depth_span(survey) {
        Some((low, high)) => {
            let soundings = counted(survey.soundings.len(), "sounding");
            line("depth", format!("{low:.2} m to {high:.2} m below transducer ({soundings})"));
        }
        None => line("depth", "none recorded".to_owned()),
    }
    if !survey.swath.is_empty() {
        let (pings, [depths, unreliable]) = (survey.swath.len(), swath_depths(survey));
        line(
            "swath",
            format!(
                "{depths} depths across the track in {pings} pings; {unreliable} unreliable ones are not used"
            ),
        );
    }
    match survey.track.fixes.first() {
        Some(fix) => {
            let place = format!("{:.6}, {:.6}", fix.position.lat_deg, fix.position.lon_deg);
            let records = counted(survey.track.fixes.len(), "record");
            let distinct = distinct_fixes(survey);
            line("position", format!("{place} (lat, lon); {distinct} distinct in {records}"));
        }
        None => line("position", "none recorded".to_owned()),
    }
    let (channel, pings) = ("channel", "pings");
    text += &format!(
        "\n{channel:<CHANNEL_WIDTH$} {pings:>6}   samples        range              time\n"
    );
    for channel in &survey.channels {
        text += &format!("{}\n", channel_row(channel));
    }
    if !survey.warnings.is_empty() {
        text += &format!("\n{}\n", counted(survey.warnings.len(), "warning"));
    }
    for warning in &survey.warnings {
        text += &warning_row(survey, warning);
    }
    text
}

fn warning_row(survey: &Survey, warning: &Warning) -> String {
    let place = warning.place.map_or(String::new(), |(file, offset)| {
        let path = survey.source.files.get(file);
        let name = path.and_then(|path| path.file_name());
        let name = name.map_or(String::new(), |name| name.to_string_lossy().into_owned());
        format!("{name} at byte {offset}: ")
    });
    format!("  {place}{}\n", warning.text)
}

fn channel_row(channel: &Channel) -> String {
    let range = |(near, far): (f32, f32)| format!("{near:.2} to {far:.2} m");
    let time = |(from, to): (f64, f64)| format!("{from:.3} to {to:.3} s");
    let samples = match channel.sample_count {
        (low, high) if low == high => low.to_string(),
        (low, high) => format!("{low} to {high}"),
    };
    format!(
        "{:<CHANNEL_WIDTH$} {:>6}   {:<13}  {:<17}  {}",
        format!("{} ({})", channel.kind.name(), channel.recorder_name),
        channel.ping_count,
        samples,
        channel.range_m.map_or(String::new(), range),
        channel.time_span_s.map_or(String::new(), time),
    )
    .trim_end()
    .to_owned()
}

fn distinct_fixes(survey: &Survey) -> usize {
    survey.track.fixes.chunk_by(|one, other| one.position == other.position).count()
}

fn to_json(survey: &Survey) -> Value {
    let span = |pair: Option<(f64, f64)>| pair.map(|(from, to)| [from, to]);
    let channels: Vec<Value> = survey
        .channels
        .iter()
        .map(|channel| {
            json!({
                "kind": channel.kind.name(),
                "recorder_name": channel.recorder_name,
                "frequency_khz": channel.frequency_khz,
                "pings": channel.ping_count,
                "samples": [channel.sample_count.0, channel.sample_count.1],
                "time_s": span(channel.time_span_s),
                "range_m": channel.range_m.map(|(near, far)| [near, far]),
            })
        })
        .collect();
    let warnings: Vec<Value> = survey
        .warnings
        .iter()
        .map(|warning| {
            json!({ "file": warning.place.map(|place| place.0), "offset": warning.place.map(|place| place.1), "text": warning.text })
        })
        .collect();
    let first = survey.track.fixes.first();
    // JSON is UTF-8; a file name need not be.
    let name = |path: &PathBuf| path.to_string_lossy().into_owned();
    let swath = (!survey.swath.is_empty()).then(|| {
        let [depths, unreliable] = swath_depths(survey);
        json!({ "pings": survey.swath.len(), "depths": depths, "unreliable": unreliable })
    });
    let files: Vec<String> = survey.source.files.iter().map(name).collect();
    let mut all = json!({
        "files": files,
        "format": survey.source.format,
        "device": survey.source.device,
        "bytes": survey.source.byte_count,
        "start_unix_s": survey.start_unix_s,
        "time_s": span(survey.time_span_s()),
        "side_scan": {
            "state": match survey.side_scan_state {
                SideScanState::Usable => "usable",
                SideScanState::Absent => "absent",
                SideScanState::Noise { .. } => "noise",
            },
            "pings": survey.side_scan.len(),
            "port": survey.side_scan.iter().filter(|ping| ping.port.is_some()).count(),
            "starboard": survey.side_scan.iter().filter(|ping| ping.starboard.is_some()).count(),
        },
        "header_px_per_m": header_scale(survey).map(|scale| scale.px_per_m),
        "depth_m": depth_span(survey).map(|(low, high)| [low, high]),
        "soundings": survey.soundings.len(),
        "position": first.map(|fix| json!({ "lon": fix.position.lon_deg, "lat": fix.position.lat_deg })),
        "position_records": survey.track.fixes.len(),
        "distinct_positions": distinct_fixes(survey),
        "channels": channels,
        "warnings": warnings,
    });
    if let Some(swath) = swath {
        all["swath"] = swath;
    }
    all
}

/// Returns Unix seconds as text: `2012-05-05 17:01:02 UTC`.
fn utc(unix_s: f64) -> String {
    format!("{} {} UTC", calendar::date(unix_s), calendar::time_of_day(unix_s))
}

/// Returns the name of a format, and below it a line for each known property, the values in one
/// column.
fn format_to_text(format: &FormatEntry) -> String {
    let lines = [
        ("recorders", format.recorders.to_owned()),
        ("open", format.opened_as(str::to_owned)),
        ("recognised by", format.magic.to_owned()),
        ("carries", format.carried()),
        ("tried on", format.tried().to_owned()),
        ("notes", format.notes.replace('`', "")),
    ];
    let written = format.written_as();
    let written = written.map(|ending| ("written as", format!(".{ending}")));
    let lines = lines.into_iter().chain(written);
    let lines = lines.map(|(name, value)| format!("  {name:<14} {value}\n"));
    format!("{}\n{}", format.name, lines.collect::<String>())
}

fn format_to_json(format: &FormatEntry) -> Value {
    let ending =
        |(ending, role): &(&str, FileRole)| json!({ "ending": ending, "role": role.name() });
    let endings: Vec<Value> = format.endings.iter().map(ending).collect();
    let carries: Vec<&str> = format.carries.iter().map(|kind| kind.name()).collect();
    json!({
        "name": format.name,
        "recorders": format.recorders,
        "endings": endings,
        "recognised_by": format.magic,
        "carries": carries,
        "tried_on": format.tried_on,
        "written_as": format.written_as(),
        "notes": format.notes,
    })
}
