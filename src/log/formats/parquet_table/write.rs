//! Writes tables to Parquet files: rows in groups, with one chunk for each column.

use super::{Column, Values};
use crate::support::geo::LonLat;
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type,
};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};
use std::fs::File;
use std::io;
use std::ops::Range;
use std::sync::Arc;

/// Number of rows in a group, which a reader loads at once.
const GROUP_ROWS: usize = 1 << 17;
/// Name of the program that writes the file. It has no version, so that the same rows always give
/// the same bytes.
const WRITER: &str = "bathyscope";

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
