//! Reads and writes tables in Parquet files: columns of numbers, texts and geometries, which are
//! always written to the same bytes and are read by name.
//!
//! In: columns, or a file. Out: a file, or its columns.
//!
//! Follows Apache Parquet, <https://parquet.apache.org/docs/file-format>; geometries as in
//! GeoParquet 1.1: well-known binary, described by the key `geo` of the file. Both `read` and the
//! writer, which writes rows in groups with one chunk for each column, use the crate `parquet`
//! without Arrow.

mod read;

pub use read::read_parquet;

use crate::support::geo::LonLat;
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type,
};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};
use serde_json::json;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::sync::Arc;

/// Number of rows in a group, which a reader loads at once.
const GROUP_ROWS: usize = 1 << 17;
/// Name of the program that writes the file. It has no version, so that the same rows always give
/// the same bytes.
const WRITER: &str = "bathyscope";

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

/// Writes a table with these key-value pairs of the file. The same columns give the same bytes. All
/// columns must have the same length.
pub fn write_parquet(file: File, columns: &[Column], keys: &[(&str, String)]) -> io::Result<()> {
    let mut writer = ParquetWriter::new(file, columns, keys)?;
    let count = columns.first().map_or(0, |column| column.values.row_count());
    for start in (0..count).step_by(GROUP_ROWS) {
        writer.push(columns, start..(start + GROUP_ROWS).min(count))?;
    }
    writer.finish()
}

/// Writer of a table one group of rows at a time, for tables that are too large for memory.
pub struct ParquetWriter {
    writer: SerializedFileWriter<File>,
}

impl ParquetWriter {
    /// Creates the writer of a table whose columns have these names and types.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(file: File, columns: &[Column], keys: &[(&str, String)]) -> io::Result<Self> {
        let begin = || {
            let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
            let schema = Type::group_type_builder("schema").with_fields(fields).build()?;
            let properties = Arc::new(properties(columns, keys));
            SerializedFileWriter::new(file, Arc::new(schema), properties)
        };
        let writer = begin().map_err(io::Error::other)?;
        Ok(Self { writer })
    }

    /// Writes some rows of the columns as a group.
    ///
    /// # Errors
    /// When writing fails.
    pub fn push(&mut self, columns: &[Column], rows: Range<usize>) -> io::Result<()> {
        let mut add = || {
            let mut group = self.writer.next_row_group()?;
            for column in columns {
                if let Some(mut chunk) = group.next_column()? {
                    write_chunk(&mut chunk, &column.values, rows.clone())?;
                    chunk.close()?;
                }
            }
            group.close().map(drop)
        };
        add().map_err(io::Error::other)
    }

    /// Writes the end of the file.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(self) -> io::Result<()> {
        self.writer.close().map(drop).map_err(io::Error::other)
    }
}

fn properties(columns: &[Column], keys: &[(&str, String)]) -> WriterProperties {
    let key = |(key, value): &(&str, String)| KeyValue::new((*key).to_owned(), value.clone());
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(WRITER.to_owned())
        .set_key_value_metadata(Some(keys.iter().map(key).collect()));
    for column in columns.iter().filter(|column| !repeats(&column.values)) {
        properties = properties.set_column_dictionary_enabled(ColumnPath::from(column.name), false);
    }
    properties.build()
}

/// Returns true if values repeat often, so that a dictionary makes the file smaller.
fn repeats(values: &Values) -> bool {
    matches!(values, Values::Text(_) | Values::Same(..) | Values::Float(_))
}

fn field(column: &Column) -> Result<Arc<Type>, parquet::errors::ParquetError> {
    let (physical, logical, repetition) = match &column.values {
        Values::Double(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
        Values::Float(_) => (Physical::FLOAT, None, Repetition::OPTIONAL),
        Values::Whole(_) => (Physical::INT32, None, Repetition::OPTIONAL),
        Values::Time(_) => (
            Physical::INT64,
            Some(LogicalType::timestamp(true, TimeUnit::MICROS)),
            Repetition::OPTIONAL,
        ),
        Values::Flag(_) => (Physical::BOOLEAN, None, Repetition::REQUIRED),
        Values::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::OPTIONAL),
        Values::Same(..) => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
        Values::Points(_) | Values::Bytes(_) => (Physical::BYTE_ARRAY, None, Repetition::REQUIRED),
    };
    let built = Type::primitive_type_builder(column.name, physical)
        .with_repetition(repetition)
        .with_logical_type(logical)
        .build()?;
    Ok(Arc::new(built))
}

fn write_chunk(
    chunk: &mut SerializedColumnWriter<'_>,
    values: &Values,
    rows: Range<usize>,
) -> Result<(), parquet::errors::ParquetError> {
    let text = |text: &&'static str| (!text.is_empty()).then(|| ByteArray::from(*text));
    match values {
        Values::Double(all) => {
            let known = all[rows].iter().map(|value| (!value.is_nan()).then_some(*value));
            put_known::<DoubleType>(chunk, known)
        }
        Values::Float(all) => {
            let known = all[rows].iter().map(|value| (!value.is_nan()).then_some(*value));
            put_known::<FloatType>(chunk, known)
        }
        Values::Whole(all) => put_known::<Int32Type>(chunk, all[rows].iter().copied()),
        Values::Time(all) => put_known::<Int64Type>(chunk, all[rows].iter().copied()),
        Values::Flag(all) => put::<BoolType>(chunk, &all[rows], None),
        Values::Text(all) => put_known::<ByteArrayType>(chunk, all[rows].iter().map(text)),
        Values::Same(text, _) => {
            let values = vec![ByteArray::from(text.as_str()); rows.len()];
            put::<ByteArrayType>(chunk, &values, None)
        }
        Values::Points(all) => {
            let values = all[rows].iter().map(|at| well_known(*at).into());
            put::<ByteArrayType>(chunk, &values.collect::<Vec<_>>(), None)
        }
        Values::Bytes(all) => {
            for row in &all[rows] {
                put::<ByteArrayType>(chunk, &[ByteArray::from(row.clone())], None)?;
            }
            Ok(())
        }
    }
}

fn put<T: DataType>(
    chunk: &mut SerializedColumnWriter<'_>,
    values: &[T::T],
    levels: Option<&[i16]>,
) -> Result<(), parquet::errors::ParquetError> {
    chunk.typed::<T>().write_batch(values, levels, None)?;
    Ok(())
}

/// Writes the known values, and for each row whether its value is known.
fn put_known<T: DataType>(
    chunk: &mut SerializedColumnWriter<'_>,
    all: impl Iterator<Item = Option<T::T>>,
) -> Result<(), parquet::errors::ParquetError> {
    let mut values = Vec::new();
    let levels = all.map(|value| {
        let level = i16::from(value.is_some());
        values.extend(value);
        level
    });
    let levels: Vec<i16> = levels.collect();
    put::<T>(chunk, &values, Some(&levels))
}

/// Returns a point as well-known binary: little-endian, of type 1, longitude before latitude.
fn well_known(at: LonLat) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(21);
    bytes.push(1);
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(at.lon_deg.to_le_bytes());
    bytes.extend(at.lat_deg.to_le_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

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
