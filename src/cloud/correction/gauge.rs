//! Readings of a gauge or tide table over time.

use super::LEVELS_M;
use crate::calendar::unix_from_text;
use crate::regular_file;
use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};

/// Longer than the readings of a survey: one a second of a year take as much.
const LONGEST: u64 = 1 << 30;

/// Heights of the water's surface over the gauge's zero, at rising times.
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    /// The file that they were read from.
    pub path: PathBuf,
    /// Its size.
    pub bytes: usize,
    /// Its SHA-256, hexadecimal.
    pub sha256: String,
    /// Unix seconds and metres; at least one.
    readings: Vec<(f64, f64)>,
}

impl Gauge {
    /// Reads a table with the columns `time` (ISO 8601, UTC unless it says otherwise, or Unix seconds) and `level_m`, separated
    /// by commas or semicolons; other columns are left alone.
    ///
    /// The error is one sentence, the path last.
    pub fn read(path: &Path) -> Result<Self, String> {
        let fail = |what: String| format!("{what}: {}", path.display());
        let bytes = regular_file::read(path, LONGEST)
            .map_err(|error| fail(format!("cannot read the water levels: {error}")))?;
        let readings = parse(&bytes).map_err(fail)?;
        let hash = Sha256::digest(&bytes);
        Ok(Self {
            path: path.to_owned(),
            bytes: bytes.len(),
            sha256: hash.iter().map(|byte| format!("{byte:02x}")).collect(),
            readings,
        })
    }

    /// Unix seconds of the first and the last reading.
    pub fn span_s(&self) -> [f64; 2] {
        let time_s = |reading: Option<&(f64, f64)>| reading.map_or(f64::NAN, |(time_s, _)| *time_s);
        [time_s(self.readings.first()), time_s(self.readings.last())]
    }

    /// The level at a time, Unix seconds, straight between the readings; that of the nearest end beyond them.
    pub fn level_m(&self, unix_s: f64) -> f64 {
        let after = self
            .readings
            .partition_point(|(time_s, _)| *time_s <= unix_s);
        let before = self.readings.get(after.saturating_sub(1));
        let (Some(&(from_s, from_m)), next) = (before, self.readings.get(after)) else {
            return f64::NAN;
        };
        match next {
            Some(&(to_s, to_m)) if after > 0 => {
                from_m + (to_m - from_m) * (unix_s - from_s) / (to_s - from_s)
            }
            _ => from_m,
        }
    }
}

/// Unix seconds and metres of every line.
fn parse(bytes: &[u8]) -> Result<Vec<(f64, f64)>, String> {
    let mut lines = bytes.split(|byte| *byte == b'\n');
    let header = lines.find(|line| !line.starts_with(b"#"));
    let semicolons = header.is_some_and(|line| line.contains(&b';'));
    let mut table = csv::ReaderBuilder::new()
        .delimiter(if semicolons { b';' } else { b',' })
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let header = table.headers().map_err(not_a_table)?.clone();
    let column = |name: &str| {
        let is = |field: &str| {
            field
                .trim_start_matches('\u{feff}')
                .eq_ignore_ascii_case(name)
        };
        let missing = || {
            format!("the water levels have no column `{name}`; name the columns time and level_m")
        };
        header.iter().position(is).ok_or_else(missing)
    };
    let [time, level] = [column("time")?, column("level_m")?];
    let mut readings: Vec<(f64, f64)> = Vec::new();
    for (index, row) in table.records().enumerate() {
        let row = row.map_err(not_a_table)?;
        let line = row.position().map_or(index as u64 + 2, |at| at.line());
        let field = |column| row.get(column).unwrap_or_default();
        let time_s = unix_from_text(field(time)).ok_or_else(|| {
            format!(
                "line {line} of the water levels: `{}` is no time; write 2021-10-12T00:53:20Z or Unix seconds",
                field(time)
            )
        })?;
        let level_m: Option<f64> = field(level).parse().ok();
        let level_m = level_m
            .filter(|level_m| LEVELS_M.contains(level_m))
            .ok_or_else(|| {
                format!(
                    "line {line} of the water levels: `{}` is no level in metres between -1000 and 10000",
                    field(level)
                )
            })?;
        if readings.last().is_some_and(|(last_s, _)| *last_s >= time_s) {
            return Err(format!(
                "line {line} of the water levels: its time is not after the one before; sort the readings"
            ));
        }
        readings.push((time_s, level_m));
    }
    if readings.is_empty() {
        return Err("the water levels hold no reading".to_owned());
    }
    Ok(readings)
}

fn not_a_table(error: csv::Error) -> String {
    format!("the water levels are no table: {error}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gauge(text: &str) -> Result<Vec<(f64, f64)>, String> {
        parse(text.as_bytes())
    }

    #[test]
    fn readings_are_joined_by_straight_lines() {
        let text = "# gauge at the dam\nstation;time;level_m\nA;2021-10-12T00:53:20Z;1.5\nA;2021-10-12 01:53:20;2.5\n";
        let made = Gauge {
            path: PathBuf::new(),
            bytes: 0,
            sha256: String::new(),
            readings: gauge(text).unwrap(),
        };
        assert_eq!(made.span_s(), [1_634_000_000.0, 1_634_003_600.0]);
        for (after_s, expected_m) in [
            (-9.0, 1.5),
            (0.0, 1.5),
            (900.0, 1.75),
            (3600.0, 2.5),
            (4000.0, 2.5),
        ] {
            let found_m = made.level_m(1_634_000_000.0 + after_s);
            assert!((found_m - expected_m).abs() < 1e-12, "{after_s}: {found_m}");
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, words) in [
            ("time,level\n1,2\n", "no column `level_m`"),
            ("time,level_m\n", "no reading"),
            ("time,level_m\n1,2\nnoon,3\n", "line 3"),
            ("time,level_m\n1,2\n2,high\n", "line 3"),
            ("time,level_m\n1,2\n1,3\n", "sort"),
            ("time,level_m\n1,nan\n", "line 2"),
            ("time,level_m\n1,2\n2,1e9\n", "line 3"),
        ] {
            let error = gauge(text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
