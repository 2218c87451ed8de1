//! Reads tables of water levels: CSV with the columns `time` and `level_m`.

use crate::support::calendar::unix_from_text;
use crate::support::file_error::{FaultText, FileError};
use crate::support::regular_file;
use crate::survey::{Gauge, WATER_LEVELS_M};
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// Size of the largest table that is read, bytes; enough for a reading every second of a year.
const LONGEST: u64 = 1 << 30;

/// Reads a table with the columns `time` (ISO 8601, UTC unless a zone is given, or Unix seconds)
/// and `level_m`, separated by commas or semicolons; other columns are ignored.
///
/// # Errors
/// When the file cannot be read, or is not such a table with readings in time order.
pub fn read_gauge(path: &Path) -> Result<Gauge, FileError> {
    let fail = FileError::<FaultText>::at(path);
    let bytes = regular_file::read(path, LONGEST)
        .map_err(|error| fail(format!("cannot read the water levels: {error}").into()))?;
    let readings = parse(&bytes).map_err(fail)?;
    let hash = Sha256::digest(&bytes);
    Ok(Gauge {
        path: path.to_owned(),
        bytes: bytes.len(),
        sha256: hash.iter().map(|byte| format!("{byte:02x}")).collect(),
        readings,
    })
}

/// Returns the time (Unix seconds) and the level (metres) of every line.
fn parse(bytes: &[u8]) -> Result<Vec<(f64, f64)>, FaultText> {
    let no_table = |error: csv::Error| format!("the water levels are no table: {error}");
    let mut table = table(bytes);
    let header = table.headers().map_err(no_table)?.clone();
    let column = |name: &str| {
        let found = header.iter().position(|field| field.eq_ignore_ascii_case(name));
        found.ok_or_else(|| {
            format!("the water levels have no column `{name}`; name the columns time and level_m")
        })
    };
    let [time, level] = [column("time")?, column("level_m")?];
    let mut readings: Vec<(f64, f64)> = Vec::new();
    for (index, row) in table.records().enumerate() {
        let row = row.map_err(no_table)?;
        let line = row.position().map_or(index as u64 + 2, |at| at.line());
        let field = |column| row.get(column).unwrap_or_default();
        let time_s = unix_from_text(field(time)).ok_or_else(|| {
            format!(
                "line {line} of the water levels: `{}` is no time; write 2021-10-12T00:53:20Z or Unix seconds",
                field(time)
            )
        })?;
        let level_m: Option<f64> = field(level).parse().ok();
        let level_m = level_m.filter(|level_m| WATER_LEVELS_M.contains(level_m));
        let level_m = level_m.ok_or_else(|| {
            format!(
                "line {line} of the water levels: `{}` is no level in metres between -1000 and 10000",
                field(level)
            )
        })?;
        if readings.last().is_some_and(|(last_s, _)| *last_s >= time_s) {
            return Err(format!(
                "line {line} of the water levels: its time is not after the one before; sort the readings"
            )
            .into());
        }
        readings.push((time_s, level_m));
    }
    if readings.is_empty() {
        return Err("the water levels hold no reading".into());
    }
    Ok(readings)
}

/// Returns the reader of a table whose fields are separated by commas or semicolons, as in its
/// first line, and in which lines that begin with `#` are comments.
pub(super) fn table(bytes: &[u8]) -> csv::Reader<&[u8]> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut lines = bytes.split(|byte| *byte == b'\n');
    let header = lines.find(|line| !line.starts_with(b"#"));
    let semicolons = header.is_some_and(|line| line.contains(&b';'));
    csv::ReaderBuilder::new()
        .delimiter(if semicolons { b';' } else { b',' })
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Gauge, FileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("levels.csv");
        std::fs::write(&path, text).unwrap();
        read_gauge(&path)
    }

    #[test]
    fn either_separator_and_either_time_are_read() {
        let text = "# gauge at the dam\nstation;time;level_m\nA;2021-10-12T00:53:20Z;1.5\nA;1634003600;2.5\n";
        let found = read(text).unwrap();
        let expected = [(1_634_000_000.0, 1.5), (1_634_003_600.0, 2.5)];
        assert_eq!(found.readings, expected);
        assert_eq!(found.bytes, text.len());
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
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
