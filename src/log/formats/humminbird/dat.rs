//! Reads the DAT file, which describes the recording as a whole.

use crate::formats::ByteOrder;
use crate::formats::clock::UNIX_S;
use crate::formats::scalar::take;

/// Salinity of lakes and rivers, parts per thousand.
pub(super) const FRESH: f64 = 1.0;
/// Bytes of the shortest DAT that is no text, and offset of the recording's name in it.
const SHORTEST: usize = 64;
const NAME_AT: usize = 32;
/// Most bytes of an Onix DAT that are read; its text is about a screen long.
const LONGEST_ONIX: usize = 1 << 16;

/// The three kinds of DAT files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DatFamily {
    /// 700 to 1100 series and Helix: 64 bytes, big-endian.
    Classic,
    /// Solix: 96, 100 or more bytes, little-endian.
    Solix,
    /// Onix: some binary words, then text such as `<NumberOfPings=11712>`.
    Onix,
}

/// Fields of a DAT file that are used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dat {
    /// Kind of DAT file.
    pub family: DatFamily,
    /// Byte 1: the kind of water that the user set the unit to.
    pub water_code: u8,
    /// Offset 4: the recorder's number of its sonar; `None` where it is 0.
    pub sonar: Option<u32>,
    /// Offset 20: Unix seconds of the start; `None` where the value is no time.
    pub start_unix_s: Option<u32>,
    /// Offset 44: number of pings in all channels.
    pub record_count: u32,
}

impl Dat {
    /// Reads a DAT file; `None` where the bytes are none. It is recognised by the recording's name
    /// (`R01224.SON`, `Rec00042.SON`) at offset 32, on Onix by its text. Files of unknown length
    /// are read in the byte order in which the start is a time.
    pub(crate) fn parse(bytes: &[u8]) -> Option<Self> {
        let name: Option<[u8; 12]> = take(bytes, NAME_AT);
        if bytes.len() < SHORTEST || !name.is_some_and(|name| is_name(&name)) {
            return Self::parse_onix(bytes);
        }
        let classic = Self::in_order(bytes, DatFamily::Classic, ByteOrder::Big);
        let solix = Self::in_order(bytes, DatFamily::Solix, ByteOrder::Little);
        match bytes.len() {
            SHORTEST => classic,
            96 | 100 => solix,
            _ => solix.filter(|dat| dat.start_unix_s.is_some_and(|at| at < UNIX_S.end)).or(classic),
        }
    }

    fn in_order(bytes: &[u8], family: DatFamily, order: ByteOrder) -> Option<Self> {
        let number = |at| take(bytes, at).map(|bytes| order.u32(bytes));
        Some(Self {
            family,
            water_code: *bytes.get(1)?,
            sonar: number(4).filter(|&number| number > 0),
            start_unix_s: number(20).filter(|&unix_s| unix_s > UNIX_S.start),
            record_count: number(44)?,
        })
    }

    fn parse_onix(bytes: &[u8]) -> Option<Self> {
        let text = String::from_utf8_lossy(bytes.get(24..bytes.len().min(LONGEST_ONIX))?);
        let number = |name: &str| -> Option<u32> {
            let (_, after) = text.split_once(&format!("<{name}="))?;
            after.split_once('>')?.0.trim().parse().ok()
        };
        // Every Onix states the length of the recording, too.
        number("TotalTimeMs")?;
        Some(Self {
            family: DatFamily::Onix,
            water_code: *bytes.get(1)?,
            sonar: None,
            start_unix_s: None,
            record_count: number("NumberOfPings")?,
        })
    }

    /// Returns the salinity of the kind of water that the unit was set to, parts per thousand; each
    /// family numbers the kinds differently. `None` for an unknown number.
    pub(crate) fn salinity(&self) -> Option<f64> {
        match (self.family, self.water_code) {
            (DatFamily::Classic | DatFamily::Onix, 0) | (DatFamily::Solix, 1) => Some(FRESH),
            // Shallow, then deep salt water.
            (_, 2) => Some(30.0),
            (DatFamily::Classic | DatFamily::Onix, 1) | (DatFamily::Solix, 3) => Some(35.0),
            _ => None,
        }
    }
}

/// Returns true if these bytes are the name of a recording: six letters and the ending, or eight on
/// newer units.
fn is_name(name: &[u8; 12]) -> bool {
    let ends_at = |at: usize| name[at..at + 4].eq_ignore_ascii_case(b".SON");
    name[0].eq_ignore_ascii_case(&b'R') && (ends_at(6) || ends_at(8))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First DAT of the USGS river survey, byte for byte.
    const RIVER: [u8; 64] = *b"\xc1\x00\x7b\x01\x00\x00\x01\x26\x00\x00\x00\x0b\x00\x00\x00\x00\
        \xa0\x01\x00\x00\x52\x69\xad\x2c\xff\x42\x93\x09\x00\x43\x16\x6cR01224.SON\x00\x0d\
        \x00\x00\x28\x77\x00\x02\x4c\x59\x00\x00\x06\x51\x00\x00\x00\x00\x00\x00\x00\x0f";

    #[test]
    fn a_real_dat_is_read() {
        let dat = Dat::parse(&RIVER).unwrap();
        assert_eq!(dat.start_unix_s, Some(1_382_657_324));
        assert_eq!(dat.record_count, 2 * 3453 + 1726 + 1727);
        assert_eq!(dat.salinity(), Some(FRESH));
    }

    #[test]
    fn solix_is_little_endian_and_longer() {
        let mut solix = [0_u8; 96];
        solix[1] = 3;
        solix[20..24].copy_from_slice(&1_600_000_000_u32.to_le_bytes());
        solix[32..42].copy_from_slice(b"R00042.SON");
        solix[44..48].copy_from_slice(&77_u32.to_le_bytes());
        let dat = Dat::parse(&solix).unwrap();
        assert_eq!((dat.start_unix_s, dat.record_count), (Some(1_600_000_000), 77));
        assert_eq!(dat.salinity(), Some(35.0));
    }

    #[test]
    fn lengths_and_names_of_newer_units_are_read() {
        for (length, order) in
            [(96, ByteOrder::Little), (108, ByteOrder::Little), (128, ByteOrder::Big)]
        {
            let mut dat = vec![0_u8; length];
            let number = |value: u32| match order {
                ByteOrder::Little => value.to_le_bytes(),
                ByteOrder::Big => value.to_be_bytes(),
            };
            dat[20..24].copy_from_slice(&number(1_600_000_000));
            dat[32..44].copy_from_slice(b"Rec00042.SON");
            dat[44..48].copy_from_slice(&number(77));
            let dat = Dat::parse(&dat).unwrap();
            assert_eq!((dat.start_unix_s, dat.record_count), (Some(1_600_000_000), 77));
            let is_solix = order == ByteOrder::Little;
            assert_eq!(dat.family == DatFamily::Solix, is_solix, "{length}");
        }
    }

    #[test]
    fn onix_is_text() {
        let mut onix = vec![0_u8; 24];
        onix.extend_from_slice(
            b"<Version=SonarRecordThumbVersion><NumberOfPings=11712><TotalTimeMs=143092>",
        );
        let dat = Dat::parse(&onix).unwrap();
        assert_eq!((dat.family, dat.record_count), (DatFamily::Onix, 11_712));
    }

    #[test]
    fn other_files_of_that_length_are_not_dat() {
        assert_eq!(Dat::parse(&[0; 64]), None);
        assert_eq!(Dat::parse(&RIVER[..63]), None);
    }
}
