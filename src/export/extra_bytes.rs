//! What LAS points carry beyond its own fields: the Extra Bytes record of LAS 1.4 R15 (section 2.7.1 "Extra Bytes").

use crate::cloud::{CloudPoint, PointSource};
use las::Vlr;

/// Bytes of one description.
const DESCRIPTION: usize = 192;
/// Stands for "no confidence": a sounding has none.
const NO_CONFIDENCE: f32 = -1.0;

/// A dimension: name (32 bytes at most), type by the standard's number, value for "no data", what it is (32 at most).
struct Dimension {
    name: &'static str,
    kind: u8,
    no_data: Option<f64>,
    what: &'static str,
}

const U8: u8 = 1;
const U32: u8 = 5;
const F32: u8 = 9;

/// In the order of [`values`].
const DIMENSIONS: [Dimension; 5] = [
    Dimension {
        name: "source",
        kind: U8,
        no_data: None,
        what: "0 recorded depth, 1 side-scan",
    },
    Dimension {
        name: "ping",
        kind: U32,
        no_data: None,
        what: "side-scan ping, from 0",
    },
    Dimension {
        name: "side",
        kind: U8,
        no_data: None,
        what: "0 below, 1 port, 2 starboard",
    },
    Dimension {
        name: "confidence",
        kind: F32,
        no_data: Some(NO_CONFIDENCE as f64),
        what: "of the first return, 0 to 1",
    },
    Dimension {
        name: "range_m",
        kind: F32,
        no_data: None,
        what: "slant range, metres",
    },
];

/// Bytes that [`values`] adds to a point.
pub(super) const LENGTH: u16 = 1 + 4 + 1 + 4 + 4;

/// The record that names the dimensions.
pub(super) fn record() -> Vlr {
    Vlr {
        user_id: "LASF_Spec".to_owned(),
        record_id: 4,
        description: "Extra Bytes".to_owned(),
        data: DIMENSIONS.iter().flat_map(described).collect(),
    }
}

/// Two reserved bytes, type, options, name, four unused; "no data", least, most, scale and offset, 24 bytes each; description.
fn described(dimension: &Dimension) -> Vec<u8> {
    let mut bytes = vec![0; DESCRIPTION];
    bytes[2] = dimension.kind;
    bytes[4..4 + dimension.name.len()].copy_from_slice(dimension.name.as_bytes());
    if let Some(no_data) = dimension.no_data {
        // The first option says that this field means something; floating types store it in eight bytes.
        bytes[3] = 1;
        bytes[40..48].copy_from_slice(&no_data.to_le_bytes());
    }
    bytes[160..160 + dimension.what.len()].copy_from_slice(dimension.what.as_bytes());
    bytes
}

/// The dimensions of a point, which was measured at a slant range.
pub(super) fn values(point: &CloudPoint, range_m: f64) -> Vec<u8> {
    let (source, side) = match point.source {
        PointSource::DownScan => (0, 0),
        PointSource::Port => (1, 1),
        PointSource::Starboard => (1, 2),
    };
    let confidence = if point.confidence.is_nan() {
        NO_CONFIDENCE
    } else {
        point.confidence
    };
    let mut bytes = Vec::with_capacity(usize::from(LENGTH));
    bytes.push(source);
    bytes.extend(point.ping.to_le_bytes());
    bytes.push(side);
    bytes.extend(confidence.to_le_bytes());
    bytes.extend((range_m as f32).to_le_bytes());
    bytes
}
