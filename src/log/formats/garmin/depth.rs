//! Encoding of depths: millimetres as signed integers, or as unsigned ones.

use super::record::{RecordBody, RecordHeader};

/// Records at the beginning of a file that tell how depths are stored.
const RECORDS_LOOKED_AT: usize = 512;
/// Bytes at the beginning of a file that tell it.
const HEAD: usize = 1 << 22;
/// Share of the ranges that may be damaged without speaking for unsigned integers.
const DAMAGED_SHARE: f64 = 0.125;

/// Encoding of a depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum DepthEncoding {
    /// Twice the value where it is not negative, else one less than twice its amount ("zig-zag"):
    /// what the format's descriptions state.
    #[default]
    Signed,
    /// The value itself. PINGVerter reports such files.
    Unsigned,
}

impl DepthEncoding {
    /// Determines the encoding from the ranges of the first records: no range is negative.
    pub(super) fn of_head(bytes: &[u8], first_record: usize) -> Self {
        let head = &bytes[..bytes.len().min(first_record.saturating_add(HEAD))];
        let (mut at, mut ranges, mut odd) = (first_record, 0_usize, 0_usize);
        for _ in 0..RECORDS_LOOKED_AT {
            let found = super::walk::next_record(head, at, head.len());
            let header = found.and_then(|found| RecordHeader::read(head, found));
            let Some(header) = header else { break };
            let body = RecordBody::read(head, &header);
            if let Some(far) = body.and_then(|body| body.range[1]) {
                ranges += 1;
                odd += far as usize & 1;
            }
            at = header.body;
        }
        if odd as f64 > DAMAGED_SHARE * ranges as f64 {
            DepthEncoding::Unsigned
        } else {
            DepthEncoding::Signed
        }
    }

    /// Metres of a stored depth.
    pub(super) fn metres(self, stored: u32) -> f32 {
        let millimetres = match self {
            DepthEncoding::Signed => {
                let amount = i64::from(stored >> 1);
                if stored & 1 == 0 { amount } else { -amount - 1 }
            }
            DepthEncoding::Unsigned => i64::from(stored),
        };
        (millimetres as f64 / 1000.0) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_of_both_kinds_become_metres() {
        let signed = |stored| DepthEncoding::Signed.metres(stored);
        assert_eq!([0, 1, 2, 16_000].map(signed), [0.0, -0.001, 0.001, 8.0]);
        assert_eq!(signed(u32::MAX), -2_147_483.8);
        assert_eq!(DepthEncoding::Unsigned.metres(16_001), 16.001);
    }
}
