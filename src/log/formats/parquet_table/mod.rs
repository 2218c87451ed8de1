//! Reads and writes tables in Parquet files: columns of numbers, texts and geometries, which are
//! always written to the same bytes and are read by name.
//!
//! In: columns, or a file. Out: a file, or its columns.
//!
//! Follows Apache Parquet, <https://parquet.apache.org/docs/file-format>; geometries as in
//! GeoParquet 1.1: well-known binary, described by the key `geo` of the file. `write` and `read`
//! use the crate `parquet` without Arrow.

mod read;
mod write;

pub use read::read_parquet;
pub use write::{ParquetWriter, write_parquet};

use crate::support::geo::LonLat;
use serde_json::json;

/// Values of a column. Unknown values are null in the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers of 64 bits; NaN where unknown.
    Double(Vec<f64>),
    /// Numbers of 32 bits; NaN where unknown.
    Float(Vec<f32>),
    /// Whole numbers; `None` where unknown.
    Whole(Vec<Option<i32>>),
    /// Times in microseconds since 1970, UTC; `None` where unknown.
    Time(Vec<Option<i64>>),
    /// True or false.
    Flag(Vec<bool>),
    /// Texts; the empty text means unknown.
    Text(Vec<&'static str>),
    /// One text for all rows, and the number of rows.
    Same(String, usize),
    /// Points on WGS84, written as well-known binary. Reading gives [`Values::Bytes`] instead.
    Points(Vec<LonLat>),
    /// Bytes, of any length in each row.
    Bytes(Vec<Vec<u8>>),
}

impl Values {
    /// Returns the number of rows.
    pub fn row_count(&self) -> usize {
        match self {
            Self::Double(values) => values.len(),
            Self::Float(values) => values.len(),
            Self::Whole(values) => values.len(),
            Self::Time(values) => values.len(),
            Self::Flag(values) => values.len(),
            Self::Text(values) => values.len(),
            Self::Same(_, count) => *count,
            Self::Points(values) => values.len(),
            Self::Bytes(values) => values.len(),
        }
    }
}

/// A column and its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name of the column.
    pub name: &'static str,
    /// Values, one for each row.
    pub values: Values,
}

impl Column {
    /// Creates a column.
    pub fn new(name: &'static str, values: Values) -> Self {
        Self { name, values }
    }

    /// Creates a column of `f64`.
    pub fn doubles(name: &'static str, values: impl Iterator<Item = f64>) -> Self {
        Self::new(name, Values::Double(values.collect()))
    }

    /// Creates a column of `f32`.
    pub fn floats(name: &'static str, values: impl Iterator<Item = f32>) -> Self {
        Self::new(name, Values::Float(values.collect()))
    }

    /// Creates a column of whole numbers.
    pub fn wholes(name: &'static str, values: impl Iterator<Item = Option<i32>>) -> Self {
        Self::new(name, Values::Whole(values.collect()))
    }

    /// Creates a column of texts; the empty text means unknown.
    pub fn texts(name: &'static str, values: impl Iterator<Item = &'static str>) -> Self {
        Self::new(name, Values::Text(values.collect()))
    }

    /// Creates a column of true or false.
    pub fn flags(name: &'static str, values: impl Iterator<Item = bool>) -> Self {
        Self::new(name, Values::Flag(values.collect()))
    }
}

/// Returns the value of the key `geo` for a file with points in a column, by GeoParquet 1.1:
/// longitude and latitude on WGS84, its default system.
pub fn geo_key(column: &str, points: &[LonLat]) -> String {
    let start = [f64::MAX, f64::MAX, f64::MIN, f64::MIN];
    let bounds = points.iter().fold(start, |[w, s, e, n], at| {
        let (lon, lat) = (at.lon_deg, at.lat_deg);
        [w.min(lon), s.min(lat), e.max(lon), n.max(lat)]
    });
    let mut of_column = json!({ "encoding": "WKB", "geometry_types": ["Point"] });
    if !points.is_empty() {
        of_column["bbox"] = json!(bounds);
    }
    let columns = json!({ column: of_column });
    json!({ "version": "1.1.0", "primary_column": column, "columns": columns }).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};

    fn columns() -> Vec<Column> {
        let place = |index: u32| LonLat { lon_deg: 9.0 + 0.001 * f64::from(index), lat_deg: 47.5 };
        let points: Vec<LonLat> = (0..200_000).map(place).collect();
        let count = points.len();
        let whole = (0..count).map(|row| (row % 3 > 0).then_some(row as i32));
        vec![
            Column::new("geometry", Values::Points(points)),
            Column::doubles("x", (0..count).map(|row| [row as f64, f64::NAN][row % 2])),
            Column::wholes("ping", whole),
            Column::flags("kept", (0..count).map(|row| row % 5 > 0)),
            Column::new("confidence", Values::Float(vec![0.5; count])),
            Column::new("time", Values::Time(vec![Some(1_700_000_000_000_000); count])),
            Column::texts("side", (0..count).map(|row| ["", "port"][row % 2])),
            Column::new("log", Values::Same("abc".to_owned(), count)),
            Column::new(
                "port",
                Values::Bytes((0..count).map(|row| vec![row as u8; row % 3]).collect()),
            ),
        ]
    }

    #[test]
    fn a_table_comes_back_by_name_and_is_the_same_bytes_every_time() {
        let folder = tempfile::tempdir().unwrap();
        let [one, other] = ["one", "other"].map(|name| folder.path().join(name));
        let keys = [("note", "for the test".to_owned())];
        for path in [&one, &other] {
            write_parquet(File::create(path).unwrap(), &columns(), &keys).unwrap();
        }
        assert_eq!(fs::read(&one).unwrap(), fs::read(&other).unwrap());
        let names = ["kept", "x", "ping", "confidence", "time", "port"];
        let read = read_parquet(&one, &names).unwrap();
        for (name, values) in names.into_iter().zip(read) {
            let written = columns().into_iter().find(|column| column.name == name);
            let written = written.unwrap().values;
            match (values, written) {
                (Values::Double(read), Values::Double(written)) => {
                    let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
                    assert!(read.iter().zip(&written).all(same) && read.len() == written.len());
                }
                (read, written) => assert_eq!(read, written),
            }
        }
    }

    #[test]
    fn what_is_no_such_table_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.parquet");
        fs::write(&path, b"PAR1 and nothing more").unwrap();
        assert!(read_parquet(&path, &["x"]).is_err());
        write_parquet(File::create(&path).unwrap(), &columns(), &[]).unwrap();
        let missing = read_parquet(&path, &["depth_m"]).unwrap_err().to_string();
        assert!(missing.contains("no column depth_m"), "{missing}");
        let whole = fs::read(&path).unwrap();
        for cut in [whole.len() / 3, whole.len() - 9] {
            fs::write(&path, &whole[..cut]).unwrap();
            assert!(read_parquet(&path, &["x"]).is_err());
        }
    }
}
