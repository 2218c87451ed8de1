//! Values of a row as bytes.

use std::cmp::Ordering;

/// A value of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Nothing; also the number of a row in its own column.
    Null,
    /// A whole number.
    Integer(i64),
    /// A number; NaN is written as nothing.
    Real(f64),
    /// A text.
    Text(String),
    /// Bytes.
    Blob(Vec<u8>),
}

impl Value {
    /// A number of things.
    pub fn count(number: usize) -> Self {
        Value::Integer(i64::try_from(number).unwrap_or(i64::MAX))
    }

    /// The code of its type, which says how long it is.
    fn code(&self) -> u64 {
        match self {
            Value::Null => 0,
            Value::Integer(_) => 6,
            Value::Real(number) if number.is_nan() => 0,
            Value::Real(_) => 7,
            Value::Text(text) => 13 + 2 * text.len() as u64,
            Value::Blob(bytes) => 12 + 2 * bytes.len() as u64,
        }
    }

    fn write(&self, out: &mut Vec<u8>) {
        match self {
            Value::Null => {}
            Value::Integer(number) => out.extend(number.to_be_bytes()),
            Value::Real(number) if number.is_nan() => {}
            Value::Real(number) => out.extend(number.to_be_bytes()),
            Value::Text(text) => out.extend(text.as_bytes()),
            Value::Blob(bytes) => out.extend(bytes),
        }
    }

    /// The order of an index: nothing, numbers, texts, bytes.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        let place = |value: &Self| match value {
            Value::Null => 0,
            Value::Integer(_) | Value::Real(_) => 1,
            Value::Text(_) => 2,
            Value::Blob(_) => 3,
        };
        match (self, other) {
            (Value::Integer(a), Value::Integer(b)) => a.cmp(b),
            (Value::Text(a), Value::Text(b)) => a.as_bytes().cmp(b.as_bytes()),
            (Value::Blob(a), Value::Blob(b)) => a.cmp(b),
            _ => place(self).cmp(&place(other)),
        }
    }
}

/// A number in as few bytes as it needs, seven bits each, the highest first; the ninth has eight.
pub(super) fn varint(number: u64) -> Vec<u8> {
    if number >> 56 != 0 {
        let mut bytes = vec![number as u8];
        let mut rest = number >> 8;
        for _ in 0..8 {
            bytes.push((rest & 0x7f) as u8 | 0x80);
            rest >>= 7;
        }
        bytes.reverse();
        return bytes;
    }
    let mut bytes = vec![(number & 0x7f) as u8];
    let mut rest = number >> 7;
    while rest > 0 {
        bytes.push((rest & 0x7f) as u8 | 0x80);
        rest >>= 7;
    }
    bytes.reverse();
    bytes
}

/// A row: how long what says its types is, the types, the values.
pub(super) fn record<'a>(values: impl Iterator<Item = &'a Value> + Clone) -> Vec<u8> {
    let codes: Vec<u8> = values
        .clone()
        .flat_map(|value| varint(value.code()))
        .collect();
    // The length counts itself: one byte up to 127, two beyond.
    let mut length = codes.len() as u64 + 1;
    if varint(length).len() > 1 {
        length = codes.len() as u64 + 2;
    }
    let mut bytes = varint(length);
    bytes.extend(codes);
    for value in values {
        value.write(&mut bytes);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_as_many_bytes_as_they_need() {
        assert_eq!(varint(0), [0]);
        assert_eq!(varint(127), [0x7f]);
        assert_eq!(varint(128), [0x81, 0]);
        assert_eq!(varint(4326), [0xa1, 0x66]);
        assert_eq!(varint((1 << 56) - 1).len(), 8);
        // Of -1 all nine bytes are full.
        assert_eq!(varint(u64::MAX), [0xff; 9]);
        assert_eq!(
            varint(1 << 63),
            [0xc0, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0]
        );
    }

    #[test]
    fn a_row_says_its_types_and_then_its_values() {
        let row = [
            Value::Null,
            Value::Integer(-2),
            Value::Text("ab".to_owned()),
            Value::Blob(vec![7]),
            Value::Real(f64::NAN),
        ];
        let bytes = record(row.iter());
        assert_eq!(bytes[..6], [6, 0, 6, 17, 14, 0]);
        assert_eq!(bytes[6..14], (-2_i64).to_be_bytes());
        assert_eq!(bytes[14..], [b'a', b'b', 7]);
    }
}
