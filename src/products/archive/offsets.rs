//! Reads, solves for and writes the offsets of the logs of an archive against each other, in
//! height, position and the levels of their echoes. `offsets.csv` is a table that people read, edit
//! and pin; pinned offsets are kept.

use super::log_record::LogRecord;
use super::record::{Archive, MOST_MOVED_M};
use crate::Error;
use crate::export::write_bytes;
use bathyscope_bottom::bathymetry::height_offsets as solver;
use bathyscope_bottom::bathymetry::height_offsets::{Datum, HeightOffsets, LogOverlap};
use bathyscope_bottom::bathymetry::position_offsets::{FoundShift, Shift};
use bathyscope_log::support::regular_file;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The name of the table of offsets.
const OFFSETS: &str = "offsets.csv";
const COLUMNS: [&str; 14] = [
    "name",
    "log",
    "offset_m",
    "standard_error_m",
    "ties",
    "group",
    "pinned",
    "east_m",
    "north_m",
    "shift_error_m",
    "latency_s",
    "latency_error_s",
    "level_factor",
    "level_ties",
];
/// Largest size of a table that is read, bytes.
const LONGEST: u64 = 1 << 28;
/// Bounds of a factor on levels that a person may write.
const FACTORS: [f64; 2] = [0.05, 20.0];
/// Largest height offset of a log, metres, as for `height_offset_m`.
const MOST_M: f64 = 100.0;

/// Largest correction of positions to the east or north, metres, and largest latency, seconds.
const MOST_SHIFT_M: f64 = 6.0;
const MOST_LATENCY_S: f64 = 2.0;

/// The height offset of a log, and how its positions are corrected.
#[derive(Clone, Debug, PartialEq)]
pub struct OffsetRow {
    /// Name of the log.
    pub name: String,
    /// SHA-256 of the log.
    pub log: String,
    /// Offset added to every elevation of the log, metres, so that it agrees with the others.
    pub offset_m: f64,
    /// Standard error of the offset, metres; NaN where nothing ties the log, 0 where it is pinned.
    pub standard_error_m: f64,
    /// Number of places where the log crosses or overlaps other logs.
    pub ties: usize,
    /// Index of the group of logs that are tied to each other; heights of different groups cannot
    /// be compared.
    pub group: usize,
    /// True if a person has set the offset: the log is then a benchmark, its offset is kept, and
    /// the others are compared with it.
    pub is_pinned: bool,
    /// Correction of the positions of the log, with its errors; [`FoundShift::NONE`] where none was
    /// requested.
    pub found: FoundShift,
    /// Factor on the levels of its echoes in mosaics.
    pub level: LevelFactor,
}

/// Factor on the levels of a log, which makes them agree with the levels of the other logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelFactor {
    /// Factor, rounded to a thousandth; 1 for a log that shows no place in common with others.
    pub factor: f64,
    /// Number of blocks of ground that the log showed with others when the factor was computed; a
    /// factor with any such block is kept.
    pub ties: usize,
}

impl LevelFactor {
    /// Factor of a log without information.
    pub(super) const NONE: Self = Self { factor: 1.0, ties: 0 };
}

/// Limits a shift to the bounds of the table and rounds it as the table stores it.
pub(super) fn as_written(shift: Shift) -> Shift {
    let rounded = |value: f64, most: f64| (value.clamp(-most, most) * 1e3).round() / 1e3 + 0.0;
    Shift {
        east_m: rounded(shift.east_m, MOST_SHIFT_M),
        north_m: rounded(shift.north_m, MOST_SHIFT_M),
        latency_s: rounded(shift.latency_s, MOST_LATENCY_S),
    }
}

/// Returns a place with its correction, metres of the zone; the place moves by no more than
/// [`MOST_MOVED_M`], for which the halo has room.
pub(super) fn moved(place: [f64; 2], shift: Shift, velocity_mps: [f64; 2]) -> [f64; 2] {
    let [x, y] = shift.at(velocity_mps);
    let share = (MOST_MOVED_M / x.hypot(y).max(MOST_MOVED_M)).min(1.0);
    [place[0] + share * x, place[1] + share * y]
}

/// The offsets of an archive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Offsets {
    by_log: BTreeMap<String, OffsetRow>,
}

impl Offsets {
    /// Creates a table from rows, one for each log.
    pub(super) fn new(rows: Vec<OffsetRow>) -> Self {
        let by_log = rows.into_iter().map(|row| (row.log.clone(), row)).collect();
        Self { by_log }
    }

    /// Reads the table of an archive; an empty table where there is no file.
    ///
    /// # Errors
    /// When the file cannot be read, or a line cannot be used; the sentence names the line.
    pub fn read(archive: &Archive) -> Result<Self, Error> {
        let path = path_of(archive);
        if path.exists() { Ok(Self::new(rows_of(&path)?)) } else { Ok(Self::default()) }
    }

    /// Writes the table, unless the file has this content already.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(super) fn write(&self, archive: &Archive) -> Result<(), Error> {
        let path = path_of(archive);
        let fail = |error: String| {
            format!("cannot write the table of offsets: {error}: {}", path.display())
        };
        let mut table = csv::Writer::from_writer(Vec::new());
        let mut lines = vec![COLUMNS.map(str::to_owned)];
        lines.extend(self.rows().into_iter().map(fields));
        for line in lines {
            table.write_record(&line).map_err(|error| fail(error.to_string()))?;
        }
        let text = table.into_inner().map_err(|error| fail(error.to_string()))?;
        if regular_file::read(&path, LONGEST).is_ok_and(|there| there == text) {
            return Ok(());
        }
        Ok(write_bytes(&path, text)?)
    }

    /// Returns the row of a log, if any.
    pub fn row(&self, log: &str) -> Option<&OffsetRow> {
        self.by_log.get(log)
    }

    /// Returns the offset added to every elevation of a log, metres; 0 for a log without a row.
    pub fn of(&self, log: &str) -> f64 {
        self.row(log).map_or(0.0, |row| row.offset_m)
    }

    /// Returns the correction of the positions of a log; zero for a log without a row.
    pub(crate) fn shift_of(&self, log: &str) -> Shift {
        self.row(log).map_or(Shift::default(), |row| row.found.shift)
    }

    /// Returns the factor on the levels of a log; 1 for a log without a row.
    pub(super) fn level_factor(&self, log: &str) -> f64 {
        self.row(log).map_or(1.0, |row| row.level.factor)
    }

    /// Returns all rows, by the names of the logs.
    pub fn rows(&self) -> Vec<&OffsetRow> {
        let mut rows: Vec<&OffsetRow> = self.by_log.values().collect();
        rows.sort_by(|a, b| (&a.name, &a.log).cmp(&(&b.name, &b.log)));
        rows
    }

    /// Returns the names of the logs that nothing ties to another log, sorted.
    pub fn untied(&self) -> Vec<&str> {
        let rows = self.rows().into_iter();
        rows.filter(|row| row.ties == 0).map(|row| row.name.as_str()).collect()
    }

    /// Returns the logs that have no row yet.
    pub fn missing<'a>(&self, logs: &'a [LogRecord]) -> Vec<&'a LogRecord> {
        logs.iter().filter(|log| self.row(&log.log).is_none()).collect()
    }
}

fn path_of(archive: &Archive) -> PathBuf {
    archive.folder().join(OFFSETS)
}

fn fields(row: &OffsetRow) -> [String; COLUMNS.len()] {
    let error = |value: f64, decimals: usize| {
        if value.is_nan() { String::new() } else { format!("{value:.decimals$}") }
    };
    let FoundShift { shift, shift_error_m, latency_error_s } = row.found;
    let Shift { east_m, north_m, latency_s } = shift;
    [
        row.name.clone(),
        row.log.clone(),
        // Adding 0 removes the sign of a negative zero.
        format!("{:.4}", row.offset_m + 0.0),
        error(row.standard_error_m, 4),
        row.ties.to_string(),
        row.group.to_string(),
        u8::from(row.is_pinned).to_string(),
        format!("{:.3}", east_m + 0.0),
        format!("{:.3}", north_m + 0.0),
        error(shift_error_m, 3),
        format!("{:.3}", latency_s + 0.0),
        error(latency_error_s, 3),
        format!("{:.3}", row.level.factor),
        row.level.ties.to_string(),
    ]
}

pub(super) fn rows_of(path: &Path) -> Result<Vec<OffsetRow>, Error> {
    let fail = |what: String| Error::from(format!("{what}: {}", path.display()));
    let text = regular_file::read_text(path, LONGEST)
        .map_err(|error| fail(format!("cannot read the table of offsets: {error}")))?;
    let mut table = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        // Rows that a person has written by hand may end early.
        .flexible(true)
        .from_reader(text.as_bytes());
    let in_words = |error: csv::Error| fail(format!("cannot read the table of offsets: {error}"));
    let header = table.headers().map_err(in_words)?.clone();
    let place = |name: &str| header.iter().position(|column| column == name);
    // A table that a person wrote may lack the other columns.
    for name in ["log", "offset_m", "pinned"] {
        if place(name).is_none() {
            return Err(fail(format!("the table of offsets has no column {name}")));
        }
    }
    let places = COLUMNS.map(place);
    let mut rows = Vec::new();
    for (line, record) in (2..).zip(table.records()) {
        let record = record.map_err(in_words)?;
        let field = |place: usize| record.get(place).unwrap_or_default();
        let Some(row) = row_of(places.map(|place| place.map_or("", field))) else {
            return Err(fail(format!(
                "line {line} of the table of offsets cannot be used: offset_m is a number of metres up to {MOST_M}, pinned 1 or 0, east_m and north_m metres up to {MOST_SHIFT_M}, latency_s seconds up to {MOST_LATENCY_S}, level_factor {} to {}",
                FACTORS[0], FACTORS[1]
            )));
        };
        rows.push(row);
    }
    Ok(rows)
}

/// Returns the row of some fields; `None` where one of them is out of its bounds. Fields of columns
/// that the table lacks are empty.
fn row_of(fields: [&str; COLUMNS.len()]) -> Option<OffsetRow> {
    let [
        name,
        log,
        offset_m,
        standard_error_m,
        ties,
        group,
        pinned,
        east_m,
        north_m,
        shift_error_m,
        latency_s,
        latency_error_s,
        level_factor,
        level_ties,
    ] = fields;
    let number = |text: &str| text.parse::<f64>().ok();
    let up_to = |text: &str, most: f64| number(text).filter(|value| value.abs() <= most);
    let shift = |text: &str, most: f64| match text {
        "" => Some(0.0),
        text => up_to(text, most),
    };
    let factor = match level_factor {
        "" => Some(1.0),
        text => number(text).filter(|factor| (FACTORS[0]..=FACTORS[1]).contains(factor)),
    };
    Some(OffsetRow {
        name: name.to_owned(),
        log: log.to_owned(),
        offset_m: up_to(offset_m, MOST_M)?,
        standard_error_m: number(standard_error_m).unwrap_or(f64::NAN),
        ties: ties.parse().unwrap_or(0),
        group: group.parse().unwrap_or(0),
        is_pinned: match pinned {
            "" | "0" | "no" | "false" => false,
            "1" | "yes" | "true" => true,
            _ => return None,
        },
        found: FoundShift {
            shift: Shift {
                east_m: shift(east_m, MOST_SHIFT_M)?,
                north_m: shift(north_m, MOST_SHIFT_M)?,
                latency_s: shift(latency_s, MOST_LATENCY_S)?,
            },
            shift_error_m: number(shift_error_m).unwrap_or(f64::NAN),
            latency_error_s: number(latency_error_s).unwrap_or(f64::NAN),
        },
        level: LevelFactor { factor: factor?, ties: level_ties.parse().unwrap_or(0) },
    })
}

/// Returns the offsets that the overlaps give. Pinned logs are replaced by one further log, whose
/// offset is zero: the difference of an overlap with a pinned log is corrected by the pinned
/// offset. Overlaps between two pinned logs are dropped.
pub(super) fn solve(log_overlaps: &[LogOverlap], pinned: &[Option<f64>]) -> HeightOffsets {
    let count = pinned.len();
    if pinned.iter().all(Option::is_none) {
        return solver::adjust(count, log_overlaps, Datum::Mean);
    }
    let of = |log: usize| pinned.get(log).copied().flatten();
    let held = log_overlaps.iter().filter_map(|log_overlap| {
        let [first, second] = log_overlap.logs;
        let (logs, difference_m, lines) = match (of(first), of(second)) {
            (None, None) => (log_overlap.logs, log_overlap.difference_m, log_overlap.lines),
            (None, Some(offset_m)) => {
                ([first, count], log_overlap.difference_m + offset_m, log_overlap.lines)
            }
            (Some(offset_m), None) => (
                [second, count],
                offset_m - log_overlap.difference_m,
                log_overlap.lines.map(|[first, second]| [second, first]),
            ),
            (Some(_), Some(_)) => return None,
        };
        Some(LogOverlap { logs, difference_m, lines, ..*log_overlap })
    });
    let mut held: Vec<LogOverlap> = held.collect();
    held.sort_by_key(|log_overlap| log_overlap.logs);
    let mut solved = solver::adjust(count + 1, &held, Datum::Log(count));
    let benchmark = solved.logs.pop().map_or(0, |log| log.group);
    for (log, offset) in solved.logs.iter_mut().enumerate() {
        if of(log).is_some() {
            offset.group = benchmark;
        }
    }
    solved
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_bottom::bathymetry::height_offsets::OverlapKind;

    fn log_overlap(logs: [usize; 2], heights_m: [f64; 2]) -> LogOverlap {
        let difference_m = heights_m[0] - heights_m[1];
        LogOverlap::new(logs, OverlapKind::Crossing, [0.0; 2], difference_m, 0.0)
    }

    #[test]
    fn pinned_logs_hold_the_others_and_each_other() {
        // True offsets of five logs, of which the first and the last are pinned 10 cm away from the
        // offsets that the overlaps give, and the fourth crosses no other log.
        let true_m = [0.3, -0.2, 0.5, 0.0, 0.1];
        let pairs = [[0, 1], [1, 2], [2, 4], [0, 4]];
        let log_overlaps: Vec<LogOverlap> = pairs
            .iter()
            .flat_map(|[a, b]| [log_overlap([*a, *b], [true_m[*a], true_m[*b]]); 5])
            .collect();
        let pinned = [Some(0.4), None, None, None, Some(0.2)];
        let solved = solve(&log_overlaps, &pinned);
        for (log, offset_m) in [(1, -0.1), (2, 0.6)] {
            assert!((solved.logs[log].offset_m - offset_m).abs() < 1e-9, "{solved:?}");
            assert_eq!(solved.logs[log].group, solved.logs[0].group);
        }
        assert_eq!(solved.logs[4].group, solved.logs[0].group);
        assert_ne!(solved.logs[3].group, solved.logs[0].group);
        assert_eq!(solved.logs.len(), 5);
    }
}
