//! Reads structures of numbered fields, of which all parts of an RSD file consist.
//!
//! A structure is a count of fields and the fields. A field is a key and a value: the low three
//! bits of the key are the length of the value in bytes, or 7 where the length follows the key; the
//! other bits are the number of the field. Counts, keys and lengths are unsigned integers of seven
//! bits a byte, the lowest bits first; a set high bit means that another byte follows.

/// Number of fields that are stored; fields with higher numbers are not used here.
const FIELDS: usize = 16;
/// Most plausible fields of a structure; no structure was seen with more than fifteen.
const MOST_FIELDS: u32 = 64;
/// Most bytes of an unsigned integer of 32 bits with seven bits a byte.
const LONGEST_VARUINT: usize = 5;

/// A structure whose fields borrow the bytes that it was read from.
#[derive(Clone, Copy, Debug)]
pub(super) struct VarStruct<'a> {
    fields: [Option<&'a [u8]>; FIELDS],
    /// Offset of the end of the structure.
    pub(super) end: usize,
}

impl<'a> VarStruct<'a> {
    /// Reads the structure at `at`; `None` where it is damaged or truncated.
    pub(super) fn read(bytes: &'a [u8], at: usize) -> Option<Self> {
        let (count, mut at) = varuint(bytes, at)?;
        if count > MOST_FIELDS {
            return None;
        }
        let mut fields = [None; FIELDS];
        for _ in 0..count {
            let (key, value_at) = varuint(bytes, at)?;
            let (length, value_at) = match key & 7 {
                7 => varuint(bytes, value_at)?,
                length => (length, value_at),
            };
            let end = value_at.checked_add(usize::try_from(length).ok()?)?;
            let value = bytes.get(value_at..end)?;
            if let Some(field) = fields.get_mut((key >> 3) as usize) {
                *field = Some(value);
            }
            at = end;
        }
        Some(Self { fields, end: at })
    }

    /// Returns the value of a field as stored; `None` where the field is missing.
    pub(super) fn bytes(&self, number: usize) -> Option<&'a [u8]> {
        *self.fields.get(number)?
    }

    /// Returns a field that is a little-endian unsigned integer of one to four bytes.
    pub(super) fn unsigned(&self, number: usize) -> Option<u32> {
        let value = self.bytes(number).filter(|value| !value.is_empty())?;
        let mut four = [0; 4];
        four.get_mut(..value.len())?.copy_from_slice(value);
        Some(u32::from_le_bytes(four))
    }

    /// Returns a field that is a little-endian signed integer of four bytes.
    pub(super) fn signed(&self, number: usize) -> Option<i32> {
        self.bytes(number)?.try_into().ok().map(i32::from_le_bytes)
    }

    /// Returns a field that is a little-endian floating-point number of four bytes.
    pub(super) fn float(&self, number: usize) -> Option<f32> {
        self.bytes(number)?.try_into().ok().map(f32::from_le_bytes)
    }

    /// Returns a field that is one unsigned integer of seven bits a byte.
    pub(super) fn varuint(&self, number: usize) -> Option<u32> {
        whole_varuint(self.bytes(number)?)
    }

    /// Returns a field that is a structure.
    pub(super) fn structure(&self, number: usize) -> Option<VarStruct<'a>> {
        VarStruct::read(self.bytes(number)?, 0)
    }
}

/// Returns the unsigned integer at `at` and the offset of its end; `None` where it is truncated or
/// has more than 32 bits.
pub(super) fn varuint(bytes: &[u8], at: usize) -> Option<(u32, usize)> {
    let mut value = 0_u64;
    for index in 0..LONGEST_VARUINT {
        let at = at.checked_add(index)?;
        let byte = *bytes.get(at)?;
        value |= u64::from(byte & 0x7F) << (7 * index);
        if byte & 0x80 == 0 {
            return Some((u32::try_from(value).ok()?, at + 1));
        }
    }
    None
}

/// Returns the unsigned integer that these bytes consist of; `None` where more bytes follow it.
pub(super) fn whole_varuint(bytes: &[u8]) -> Option<u32> {
    varuint(bytes, 0).filter(|(_, end)| *end == bytes.len()).map(|(value, _)| value)
}

/// Returns the first item of an array, which is a count, then each item after its length.
pub(super) fn first_item(array: &[u8]) -> Option<&[u8]> {
    let (count, at) = varuint(array, 0)?;
    let (length, at) = varuint(array, at).filter(|_| count > 0)?;
    array.get(at..at.checked_add(usize::try_from(length).ok()?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_have_seven_bits_a_byte() {
        for (bytes, value) in [
            (&[0][..], Some((0, 1))),
            (&[0x7F], Some((127, 1))),
            (&[0xAC, 0x02, 9], Some((300, 2))),
            (&[0xFF, 0xFF, 0xFF, 0xFF, 0x0F], Some((u32::MAX, 5))),
            // 33 bits, six bytes, and a truncated integer.
            (&[0xFF, 0xFF, 0xFF, 0xFF, 0x1F], None),
            (&[0x80, 0x80, 0x80, 0x80, 0x80, 0], None),
            (&[0x80], None),
            (&[], None),
        ] {
            assert_eq!(varuint(bytes, 0), value, "{bytes:?}");
        }
        assert_eq!(whole_varuint(&[5, 0]), None);
        assert_eq!(varuint(&[1], usize::MAX), None);
    }

    #[test]
    fn fields_are_found_by_number_and_damage_is_no_structure() {
        // Field 0 of two bytes, field 2 of eight bytes after its length, field 9 without bytes, and
        // field 200, which is not used.
        let mut bytes = vec![4, 0x02, 0x34, 0x12, 0x17, 8, 1, 2, 3, 4, 5, 6, 7, 8];
        bytes.extend([9 << 3, 0xC1, 0x0C, 77, 0xEE]);
        let found = VarStruct::read(&bytes, 0).unwrap();
        assert_eq!(found.unsigned(0), Some(0x1234));
        assert_eq!(found.bytes(2).map(<[u8]>::len), Some(8));
        assert_eq!((found.unsigned(2), found.unsigned(9)), (None, None));
        assert_eq!((found.bytes(1), found.bytes(200)), (None, None));
        assert_eq!(found.end, bytes.len() - 1);
        for cut in 0..found.end {
            assert!(VarStruct::read(&bytes[..cut], 0).is_none(), "{cut}");
        }
        // Lengths and counts of 2^32 - 1.
        let long = [1, 0x07, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F, 1, 2];
        assert!(VarStruct::read(&long, 0).is_none());
        let many = [0xFF, 0xFF, 0xFF, 0xFF, 0x0F, 0, 0, 0];
        assert!(VarStruct::read(&many, 0).is_none());
    }

    #[test]
    fn arrays_have_a_length_before_each_item() {
        assert_eq!(first_item(&[2, 1, 5, 2, 6, 7]), Some(&[5][..]));
        for none in [&[][..], &[0], &[0, 1, 5], &[1, 9, 5], &[1, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F]] {
            assert_eq!(first_item(none), None, "{none:?}");
        }
    }
}
