//! Reads columns of a Parquet file by their names, and checks the sizes that the pages of a column
//! claim, before the decoder allocates memory by them.
//!
//! A column is a sequence of pages: a header in the compact protocol of Thrift, whose fields 2 and
//! 3 are the bytes of the page decompressed and compressed, then the page (the Parquet format's
//! `parquet.thrift`). Three bytes of Snappy become at most 64, so that a page cannot be longer than
//! about twenty times its stored bytes.

use super::Values;
use crate::support::catch_panic::catch_panic;
use crate::support::file_error::FileError;
use crate::support::regular_file;
use parquet::basic::Type as Physical;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use std::error::Error;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

/// Largest ratio of decompressed to compressed bytes, and bytes that are allowed in addition.
const MOST_TIMES: u64 = 22;
const MOST_BESIDE: u64 = 1024;
/// Most structures that may be nested in a header.
const DEEPEST: usize = 8;

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
            if !are_sound(&mut pages, start..start.saturating_add(length)) {
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

/// Returns true if all pages in a range of a file can be followed, and none claims an impossible
/// length.
fn are_sound(file: &mut (impl BufRead + Seek), column: Range<u64>) -> bool {
    let mut walk = || -> Option<bool> {
        let mut at = file.seek(SeekFrom::Start(column.start)).ok()?;
        while at < column.end {
            let [unpacked, packed] = PageHeader { file }.sizes()?;
            if unpacked > packed.saturating_mul(MOST_TIMES).saturating_add(MOST_BESIDE) {
                return Some(false);
            }
            file.seek_relative(i64::try_from(packed).ok()?).ok()?;
            at = file.stream_position().ok()?;
        }
        Some(true)
    };
    walk().unwrap_or(false)
}

/// The header of a page.
struct PageHeader<'a, R> {
    file: &'a mut R,
}

impl<R: Read> PageHeader<'_, R> {
    /// Returns the bytes of the page, decompressed and compressed; the file is then after the
    /// header.
    fn sizes(&mut self) -> Option<[u64; 2]> {
        let mut sizes = [None; 2];
        self.structure(DEEPEST, |header, number, kind| match (number, kind) {
            (2 | 3, 4..=6) => {
                let size = header.whole()?;
                sizes[usize::from(number == 3)] = u64::try_from(size).ok();
                Some(())
            }
            _ => header.skip(kind, DEEPEST),
        })?;
        Some([sizes[0]?, sizes[1]?])
    }

    /// Calls `take` with the number and the type of each field of a structure; `take` must read its
    /// value.
    fn structure(
        &mut self,
        deepest: usize,
        mut take: impl FnMut(&mut Self, i64, u8) -> Option<()>,
    ) -> Option<()> {
        deepest.checked_sub(1)?;
        let mut number = 0_i64;
        loop {
            let head = self.byte()?;
            let (step, kind) = (i64::from(head >> 4), head & 0xF);
            if kind == 0 {
                return Some(());
            }
            number = match step {
                0 => self.whole()?,
                _ => number.checked_add(step)?,
            };
            take(self, number, kind)?;
        }
    }

    /// Skips a value of a type that occurs in page headers.
    fn skip(&mut self, kind: u8, deepest: usize) -> Option<()> {
        match kind {
            // A field that is true or false has its value in the type.
            1 | 2 => Some(()),
            3 => self.byte().map(drop),
            4..=6 => self.varint().map(drop),
            7 => self.over(8),
            8 => {
                let length = self.varint()?;
                self.over(length)
            }
            12 => self.structure(deepest - 1, |header, _, kind| header.skip(kind, deepest - 1)),
            _ => None,
        }
    }

    fn over(&mut self, bytes: u64) -> Option<()> {
        let skipped = std::io::copy(&mut self.file.by_ref().take(bytes), &mut std::io::sink());
        (skipped.ok()? == bytes).then_some(())
    }

    fn byte(&mut self) -> Option<u8> {
        let mut byte = [0];
        self.file.read_exact(&mut byte).ok()?;
        Some(byte[0])
    }

    /// Reads an unsigned number of seven bits a byte, the lowest first.
    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// Reads a whole number whose sign is the lowest bit.
    fn whole(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// Returns a page of four bytes that claims `unpacked` decompressed bytes: type 0, sizes, and a
    /// structure with a text.
    fn page(unpacked: u8) -> Vec<u8> {
        let mut bytes = vec![0x15, 0, 0x15];
        bytes.extend([unpacked << 1 | 0x80, 0x01 + (unpacked >> 6), 0x15, 8]);
        bytes.extend([0x2C, 0x15, 2, 0x18, 2, 7, 7, 0, 0]);
        bytes.extend([1, 2, 3, 4]);
        bytes
    }

    #[test]
    fn a_page_that_claims_more_than_it_can_hold_is_found_behind_others() {
        let sound = [page(0), page(60)].concat();
        let all = 0..sound.len() as u64;
        assert!(are_sound(&mut Cursor::new(&sound), all));
        let mut long = sound.clone();
        let at = long.len();
        long.extend([0x15, 0, 0x15, 0xFE, 0xFF, 0xFF, 0xFF, 0x0F, 0x15, 8, 0]);
        long.extend([1, 2, 3, 4]);
        assert!(!are_sound(&mut Cursor::new(&long), 0..long.len() as u64));
        assert!(are_sound(&mut Cursor::new(&long), 0..at as u64));
        // Truncated bytes, and bytes that are no header.
        assert!(!are_sound(&mut Cursor::new(&long[..7]), 0..100));
        assert!(!are_sound(&mut Cursor::new([0x19; 9]), 0..9));
    }
}
