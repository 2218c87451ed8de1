//! Finds the records of a whole log and the values in their headers, without the readers, from the
//! format notes.

use std::ops::Range;

/// Function that finds the byte ranges of the records of a whole file.
pub type FindRecords = fn(&[u8]) -> Vec<Range<u64>>;

/// Kind of the number in a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// A whole number of so many bytes: a size, a count, an offset, a time.
    Whole(usize),
    /// A float of so many bytes.
    Float(usize),
}

impl FieldKind {
    /// Its bytes.
    pub fn width(self) -> usize {
        match self {
            FieldKind::Whole(width) | FieldKind::Float(width) => width,
        }
    }
}

/// Layout of the records of a format, as the sweep needs it.
#[derive(Clone, Copy)]
pub struct RecordLayout {
    /// Finds the records.
    pub find: FindRecords,
    /// Fields by their offset in a record.
    pub fields: &'static [(usize, FieldKind)],
    /// Bytes of the numbers are the most significant first.
    pub big_endian: bool,
}

use FieldKind::{Float, Whole};

const SL2_FIELDS: &[(usize, FieldKind)] = &[
    (0, Whole(4)),
    (4, Whole(4)),
    (8, Whole(4)),
    (28, Whole(2)),
    (30, Whole(2)),
    (32, Whole(2)),
    (34, Whole(2)),
    (36, Whole(4)),
    (40, Float(4)),
    (44, Float(4)),
    (53, Whole(1)),
    (60, Whole(4)),
    (64, Float(4)),
    (68, Float(4)),
    (100, Float(4)),
    (108, Whole(4)),
    (112, Whole(4)),
    (116, Float(4)),
    (128, Float(4)),
    (132, Whole(2)),
    (140, Whole(4)),
];
const SL3_FIELDS: &[(usize, FieldKind)] = &[
    (0, Whole(4)),
    (4, Whole(4)),
    (8, Whole(2)),
    (10, Whole(2)),
    (12, Whole(2)),
    (16, Whole(4)),
    (20, Float(4)),
    (24, Float(4)),
    (40, Whole(4)),
    (44, Whole(4)),
    (48, Float(4)),
    (52, Whole(2)),
    (84, Float(4)),
    (92, Whole(4)),
    (96, Whole(4)),
    (104, Float(4)),
    (112, Float(4)),
    (116, Whole(2)),
    (124, Whole(4)),
];
const XTF_FIELDS: &[(usize, FieldKind)] = &[
    (0, Whole(2)),
    (2, Whole(1)),
    (3, Whole(1)),
    (4, Whole(2)),
    (10, Whole(4)),
    (14, Whole(2)),
    (16, Whole(1)),
    (18, Whole(1)),
    (19, Whole(1)),
    (20, Whole(1)),
    (21, Whole(1)),
    (160, Float(8)),
    (168, Float(8)),
    (196, Float(4)),
    (212, Float(4)),
    (256, Whole(2)),
    (260, Float(4)),
    (264, Float(4)),
    (268, Float(4)),
    (298, Whole(4)),
];
const SON_FIELDS: &[(usize, FieldKind)] = &[
    (0, Whole(4)),
    (4, Whole(1)),
    (5, Whole(4)),
    (10, Whole(4)),
    (15, Whole(4)),
    (20, Whole(4)),
    (25, Whole(2)),
    (27, Whole(2)),
    (30, Whole(4)),
    (35, Whole(4)),
    (40, Whole(1)),
    (44, Whole(4)),
    (62, Whole(4)),
    (66, Whole(1)),
];

/// Returns the layout of the records of a file, by its first bytes; `None` for other formats.
pub fn layout_of(bytes: &[u8]) -> Option<RecordLayout> {
    let (find, fields, big_endian): (FindRecords, _, _) = match bytes {
        [2, 0, _, 0, ..] => (sl2_records, SL2_FIELDS, false),
        [3, 0, _, 0, ..] => (sl3_records, SL3_FIELDS, false),
        [0x7B, ..] => (xtf_records, XTF_FIELDS, false),
        [0xC0, 0xDE, 0xAB, 0x21, ..] => (son_records, SON_FIELDS, true),
        _ => return None,
    };
    Some(RecordLayout { find, fields, big_endian })
}

fn by_size(bytes: &[u8], start: usize, size_at: impl Fn(usize) -> usize) -> Vec<Range<u64>> {
    let mut records = Vec::new();
    let mut at = start;
    while at + 144 <= bytes.len() {
        let end = at + size_at(at).max(1);
        records.push(at as u64..end as u64);
        at = end;
    }
    records
}

fn u16_at(bytes: &[u8], at: usize) -> usize {
    usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]))
}

/// Frames of SL2.
pub fn sl2_records(bytes: &[u8]) -> Vec<Range<u64>> {
    by_size(bytes, 8, |at| u16_at(bytes, at + 28))
}

/// Frames of SL3.
pub fn sl3_records(bytes: &[u8]) -> Vec<Range<u64>> {
    by_size(bytes, 8, |at| u16_at(bytes, at + 8))
}

/// Packets of XTF.
pub fn xtf_records(bytes: &[u8]) -> Vec<Range<u64>> {
    by_size(bytes, 1024, |at| u16_at(bytes, at + 10) | u16_at(bytes, at + 12) << 16)
}

/// Pings lie from one magic number to the next; the data of these logs does not contain it.
pub fn son_records(bytes: &[u8]) -> Vec<Range<u64>> {
    let magic = [0xC0, 0xDE, 0xAB, 0x21];
    let windows = bytes.windows(magic.len()).enumerate();
    let marked = windows.filter(|(_, window)| *window == magic);
    let mut starts: Vec<u64> = marked.map(|(at, _)| at as u64).collect();
    starts.push(bytes.len() as u64);
    starts.windows(2).map(|pair| pair[0]..pair[1]).collect()
}
