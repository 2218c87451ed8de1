//! Describes the dimensions of LAS points beyond the fields of the standard: the Extra Bytes record
//! of LAS 1.4 R15 (section 2.7.1 "Extra Bytes").

use las::Vlr;

/// Bytes of one description.
const DESCRIPTION: usize = 192;

/// A dimension.
#[derive(Clone, Copy)]
pub(super) struct Dimension {
    name: &'static str,
    kind: DimensionType,
    no_data: Option<f64>,
    what: &'static str,
}

/// Bytes that the standard has for the name, and for the description.
const LONGEST: usize = 32;

impl Dimension {
    /// A dimension of a name, a type, a value for "no data" and a description of what it is.
    pub(super) const fn new(
        name: &'static str,
        kind: DimensionType,
        no_data: Option<f64>,
        what: &'static str,
    ) -> Self {
        assert!(name.len() <= LONGEST && what.len() <= LONGEST);
        Self { name, kind, no_data, what }
    }
}

/// Type of a dimension, by the standard's number.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum DimensionType {
    U8 = 1,
    U32 = 5,
    F32 = 9,
}

impl DimensionType {
    fn bytes(self) -> u16 {
        match self {
            Self::U8 => 1,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Bytes that dimensions add to a point.
pub(super) fn length(dimensions: &[Dimension]) -> u16 {
    dimensions.iter().map(|one| one.kind.bytes()).sum()
}

/// The record that names the dimensions.
pub(super) fn record(dimensions: &[Dimension]) -> Vlr {
    Vlr {
        user_id: "LASF_Spec".to_owned(),
        record_id: 4,
        description: "Extra Bytes".to_owned(),
        data: dimensions.iter().flat_map(described).collect(),
    }
}

/// Two reserved bytes, type, options, name, four unused; "no data", least, most, scale and offset,
/// 24 bytes each; description.
fn described(dimension: &Dimension) -> Vec<u8> {
    let mut bytes = vec![0; DESCRIPTION];
    bytes[2] = dimension.kind as u8;
    bytes[4..4 + dimension.name.len()].copy_from_slice(dimension.name.as_bytes());
    if let Some(no_data) = dimension.no_data {
        // The first option says that this field means something; floating types store it in eight
        // bytes.
        bytes[3] = 1;
        bytes[40..48].copy_from_slice(&no_data.to_le_bytes());
    }
    bytes[160..160 + dimension.what.len()].copy_from_slice(dimension.what.as_bytes());
    bytes
}
