//! Reads columns of a Parquet file by their names.

use super::{Values, pages};
use crate::support::catch_panic::catch_panic;
use crate::support::file_error::FileError;
use crate::support::regular_file;
use parquet::basic::Type as Physical;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use std::error::Error;
use std::io::BufReader;
use std::path::Path;

/// Returns the columns with these names, of numbers, times, flags or bytes, in the order of the
/// names.
///
/// # Errors
/// When the file cannot be read, is damaged, or has no such column.
pub fn read_parquet(path: &Path, names: &[&str]) -> Result<Vec<Values>, FileError> {
    // The decoder panics on some damaged files.
    let read = catch_panic(|| read(path, names).map_err(|error| error.to_string()));
    read.unwrap_or(Err("the file is damaged".to_owned())).map_err(|what| {
        FileError::new(format!("cannot read the Parquet file: {what}").into(), path)
    })
}

fn read(path: &Path, names: &[&str]) -> Result<Vec<Values>, Box<dyn Error>> {
    let mut pages = BufReader::new(regular_file::open(path)?);
    let reader = SerializedFileReader::new(regular_file::open(path)?)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let columns = schema.columns().iter().enumerate();
    let mut chosen = Vec::new();
    for name in names {
        let found = columns.clone().find(|(_, column)| column.name() == *name);
        let (index, column) = found.ok_or_else(|| format!("it has no column {name}"))?;
        chosen.push((index, empty(column.physical_type(), name)?));
    }
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or_default();
        for (index, values) in &mut chosen {
            let (start, length) = group.metadata().column(*index).byte_range();
            if !pages::are_sound(&mut pages, start..start.saturating_add(length)) {
                return Err("a page of it is damaged".into());
            }
            let chunk = group.get_column_reader(*index)?;
            append(chunk, rows, values)?;
        }
    }
    Ok(chosen.into_iter().map(|(_, values)| values).collect())
}

fn empty(physical: Physical, name: &str) -> Result<Values, String> {
    Ok(match physical {
        Physical::DOUBLE => Values::Double(Vec::new()),
        Physical::FLOAT => Values::Float(Vec::new()),
        Physical::INT32 => Values::Whole(Vec::new()),
        Physical::INT64 => Values::Time(Vec::new()),
        Physical::BOOLEAN => Values::Flag(Vec::new()),
        Physical::BYTE_ARRAY => Values::Bytes(Vec::new()),
        _ => return Err(format!("its column {name} holds no numbers")),
    })
}

fn append(chunk: ColumnReader, rows: usize, values: &mut Values) -> Result<(), Box<dyn Error>> {
    match (chunk, values) {
        (ColumnReader::DoubleColumnReader(chunk), Values::Double(all)) => {
            let read = nullable(chunk, rows)?.into_iter();
            all.extend(read.map(|value| value.unwrap_or(f64::NAN)));
        }
        (ColumnReader::FloatColumnReader(chunk), Values::Float(all)) => {
            let read = nullable(chunk, rows)?.into_iter();
            all.extend(read.map(|value| value.unwrap_or(f32::NAN)));
        }
        (ColumnReader::Int32ColumnReader(chunk), Values::Whole(all)) => {
            all.extend(nullable(chunk, rows)?);
        }
        (ColumnReader::Int64ColumnReader(chunk), Values::Time(all)) => {
            all.extend(nullable(chunk, rows)?);
        }
        (ColumnReader::BoolColumnReader(chunk), Values::Flag(all)) => {
            let read = nullable(chunk, rows)?.into_iter();
            all.extend(read.map(|value| value.unwrap_or_default()));
        }
        (ColumnReader::ByteArrayColumnReader(chunk), Values::Bytes(all)) => {
            let read = nullable(chunk, rows)?.into_iter();
            all.extend(read.map(|value| value.map_or(Vec::new(), |bytes| bytes.data().to_vec())));
        }
        _ => return Err("its columns change their type".into()),
    }
    Ok(())
}

/// Returns the values of all rows of a group; a column without null values has no levels.
fn nullable<T: DataType>(
    mut chunk: ColumnReaderImpl<T>,
    rows: usize,
) -> Result<Vec<Option<T::T>>, Box<dyn Error>> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let (mut records, mut all) = (0, 0);
    while records < rows {
        let (read, _, _) =
            chunk.read_records(rows - records, Some(&mut levels), None, &mut values)?;
        if read == 0 {
            return Err("it ends before its last row".into());
        }
        records += read;
        all += read;
    }
    let mut known = values.into_iter();
    match levels.is_empty() {
        true => Ok(known.map(Some).collect()),
        false if levels.len() == all => {
            let value = |level: i16| (level > 0).then(|| known.next()).flatten();
            Ok(levels.into_iter().map(value).collect())
        }
        false => Err("its columns are not of one length".into()),
    }
}
