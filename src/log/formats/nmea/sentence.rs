//! Decodes one NMEA sentence.
//!
//! Fields as in the public descriptions of NMEA 0183: GGA, GNS, RMC and GLL give degrees and
//! minutes as `ddmm.mmmm`, RMC and VTG knots and the course over ground, HDT and THS the true
//! heading, HDM and HDG the compass heading, DPT and DBT the depth below the transducer, DBS the
//! depth below the water's surface.

use crate::support::calendar::unix_from_iso;
use crate::support::geo::{LonLat, METRES_PER_FOOT, MPS_PER_KNOT};

/// Metres in a fathom.
const METRES_PER_FATHOM: f64 = 6.0 * METRES_PER_FOOT;

/// Content of one sentence; missing values are NaN or `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::formats) struct Sentence {
    /// Time of day, seconds since midnight, UTC.
    pub(in crate::formats) utc_s: Option<f64>,
    /// Unix seconds; `None` where the sentence gives no date.
    pub(in crate::formats) unix_s: Option<f64>,
    /// Position of the receiver.
    pub(in crate::formats) position: Option<LonLat>,
    /// Course over ground, radians from north, clockwise.
    pub(in crate::formats) cog_rad: f32,
    /// Heading, radians from true north, clockwise.
    pub(in crate::formats) heading_rad: f32,
    /// Heading, radians from magnetic north, clockwise.
    pub(in crate::formats) magnetic_rad: f32,
    /// Magnetic variation, radians: the angle to add to a magnetic heading to get a true heading.
    pub(in crate::formats) variation_rad: f32,
    /// Speed over ground, metres a second.
    pub(in crate::formats) speed_mps: f32,
    /// Depth below the transducer, metres; for DBS below the water's surface.
    pub(in crate::formats) depth_m: f32,
    /// Distance from the transducer up to the water line, metres; if negative, from the transducer
    /// down to the keel.
    pub(in crate::formats) offset_m: f32,
}

/// A sentence without any value.
const EMPTY: Sentence = Sentence {
    utc_s: None,
    unix_s: None,
    position: None,
    cog_rad: f32::NAN,
    heading_rad: f32::NAN,
    magnetic_rad: f32::NAN,
    variation_rad: f32::NAN,
    speed_mps: f32::NAN,
    depth_m: f32::NAN,
    offset_m: f32::NAN,
};

/// Decodes a sentence, with or without its checksum; `None` for a damaged sentence and for one
/// without any of these values.
pub(in crate::formats) fn sentence(bytes: &[u8]) -> Option<Sentence> {
    let start = bytes.iter().position(|&byte| byte == b'$')?;
    Framed::of(&bytes[start..])?.sentence()
}

/// A sentence split into its fields.
#[derive(Clone, Debug)]
pub(super) struct Framed<'a> {
    /// True if the sentence has a checksum, which is then correct.
    pub(super) has_sum: bool,
    fields: Vec<&'a str>,
}

impl<'a> Framed<'a> {
    /// Splits bytes that begin with `$`; bytes after the line's end, and bytes that are no text,
    /// are ignored. `None` where the checksum is wrong.
    pub(super) fn of(bytes: &'a [u8]) -> Option<Self> {
        let bytes = bytes.get(1..).unwrap_or_default();
        let is_end = |byte: &u8| matches!(byte, b'\r' | b'\n' | b'\0');
        let end = bytes.iter().position(is_end).unwrap_or(bytes.len());
        let line = match std::str::from_utf8(&bytes[..end]) {
            Ok(line) => line,
            Err(error) => std::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or_default(),
        };
        let (body, has_sum) = match line.split_once('*') {
            Some((body, sum)) if !is_sum(body, sum) => return None,
            Some((body, _)) => (body, true),
            None => (line, false),
        };
        let fields = body.split(',').collect();
        Some(Self { has_sum, fields })
    }

    /// Returns talker and type, as `GPRMC`; `None` where this is no address of the standard.
    pub(super) fn address(&self) -> Option<[u8; 5]> {
        let address: [u8; 5] = self.text(0).as_bytes().try_into().ok()?;
        let is_letter = |byte: &u8| byte.is_ascii_uppercase() || byte.is_ascii_digit();
        address.iter().all(is_letter).then_some(address)
    }

    /// Returns the content of the sentence; `None` for a type that is not read, and where no value
    /// is set.
    pub(super) fn sentence(&self) -> Option<Sentence> {
        let kind = self.text(0);
        let sentence = match kind.get(kind.len().checked_sub(3)?..)? {
            "GGA" | "GNS" => self.fix(),
            "RMC" => self.minimum(),
            "GLL" if self.text(6) != "V" => {
                Sentence { utc_s: self.utc_s(5), position: self.place(1), ..EMPTY }
            }
            "ZDA" => {
                let date = [4, 3, 2].map(|index| self.text(index));
                self.dated(1, date[0].parse().ok()?, date[1], date[2])
            }
            "VTG" => Sentence { cog_rad: self.degrees(1), speed_mps: self.knots(5), ..EMPTY },
            "HDT" => Sentence { heading_rad: self.degrees(1), ..EMPTY },
            "THS" if self.text(2) != "V" => Sentence { heading_rad: self.degrees(1), ..EMPTY },
            "HDM" => Sentence { magnetic_rad: self.degrees(1), ..EMPTY },
            "HDG" => {
                let deviation_rad = self.eastward(2);
                let magnetic_rad = self.degrees(1);
                Sentence {
                    magnetic_rad: if deviation_rad.is_nan() {
                        magnetic_rad
                    } else {
                        magnetic_rad + deviation_rad
                    },
                    variation_rad: self.eastward(4),
                    ..EMPTY
                }
            }
            "DPT" => Sentence {
                depth_m: self.number(1).map_or(f32::NAN, |metres| metres as f32),
                offset_m: self.number(2).map_or(f32::NAN, |metres| metres as f32),
                ..EMPTY
            },
            "DBT" | "DBS" => Sentence {
                depth_m: self.depth_m().map_or(f32::NAN, |metres| metres as f32),
                ..EMPTY
            },
            _ => return None,
        };
        sentence.tells().then_some(sentence)
    }

    /// Decodes GGA and GNS; quality 0, and mode N of all systems, mean "no fix".
    fn fix(&self) -> Sentence {
        let quality = self.text(6);
        let has_fix =
            quality.is_empty() || !quality.bytes().all(|byte| matches!(byte, b'0' | b'N'));
        Sentence { utc_s: self.utc_s(1), position: self.place(2).filter(|_| has_fix), ..EMPTY }
    }

    /// Decodes RMC; an invalid one has no values.
    fn minimum(&self) -> Sentence {
        if self.text(2) != "A" {
            return EMPTY;
        }
        let date = self.text(9);
        let two = |from: usize| date.get(from..from + 2).unwrap_or_default();
        let dated = match two(4).parse::<i32>() {
            // Years from 80 on are in the 20th century: receivers are younger than 1980.
            Ok(year) if date.len() == 6 => {
                let century = if year < 80 { 2000 } else { 1900 };
                self.dated(1, century + year, two(2), two(0))
            }
            _ => EMPTY,
        };
        Sentence {
            utc_s: self.utc_s(1),
            position: self.place(3),
            speed_mps: self.knots(7),
            cog_rad: self.degrees(8),
            variation_rad: self.eastward(10),
            ..dated
        }
    }

    /// Returns the time of day in the field `time`, on a date.
    fn dated(&self, time: usize, year: i32, month: &str, day: &str) -> Sentence {
        let utc_s = self.utc_s(time);
        let midnight_s = unix_from_iso(&format!("{year}-{month}-{day}T00:00"));
        Sentence {
            utc_s,
            unix_s: utc_s.zip(midnight_s).map(|(utc_s, midnight_s)| midnight_s + utc_s),
            ..EMPTY
        }
    }

    /// Decodes the depth of DBT and DBS, which is in feet, metres and fathoms. The unit with the
    /// smallest last digit is used: many sounders write all three with one decimal, which is 3 cm
    /// in feet and 10 cm in metres.
    fn depth_m(&self) -> Option<f64> {
        let units = [(3, 1.0), (1, METRES_PER_FOOT), (5, METRES_PER_FATHOM)];
        let written = units.into_iter().filter_map(|(index, unit_m)| {
            let decimals =
                self.text(index).split_once('.').map_or(0, |(_, decimals)| decimals.len());
            let last_digit_m = unit_m * 0.1_f64.powi(decimals.min(9) as i32);
            Some((last_digit_m, self.number(index)? * unit_m))
        });
        written.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, depth_m)| depth_m)
    }

    fn text(&self, index: usize) -> &'a str {
        self.fields.get(index).copied().unwrap_or_default().trim()
    }

    fn number(&self, index: usize) -> Option<f64> {
        let number: Option<f64> = self.text(index).parse().ok();
        number.filter(|number| number.is_finite())
    }

    fn degrees(&self, index: usize) -> f32 {
        let degrees = self.number(index);
        degrees.map_or(f32::NAN, |degrees| degrees.to_radians() as f32)
    }

    fn knots(&self, index: usize) -> f32 {
        let knots = self.number(index);
        knots.map_or(f32::NAN, |knots| (knots * MPS_PER_KNOT) as f32)
    }

    /// Returns degrees with the letter E or W after them, in radians; positive to the east.
    fn eastward(&self, index: usize) -> f32 {
        match self.text(index + 1) {
            "E" => self.degrees(index),
            "W" => -self.degrees(index),
            _ => f32::NAN,
        }
    }

    fn place(&self, first: usize) -> Option<LonLat> {
        let angle = |at: usize, positive, negative| {
            angle_deg(self.number(at)?, self.text(at + 1), positive, negative)
        };
        Some(LonLat { lat_deg: angle(first, "N", "S")?, lon_deg: angle(first + 2, "E", "W")? })
    }

    /// Returns the time of day of `hhmmss.sss`, seconds.
    fn utc_s(&self, index: usize) -> Option<f64> {
        let value = self.number(index)?;
        let [hours, minutes] = [value / 10_000.0, value / 100.0 % 100.0].map(f64::trunc);
        let utc_s = hours * 3600.0 + minutes * 60.0 + value % 100.0;
        (0.0..86_401.0).contains(&utc_s).then_some(utc_s)
    }
}

impl Sentence {
    /// Returns true if the sentence has any value apart from a time of day.
    fn tells(&self) -> bool {
        let figures = [
            self.cog_rad,
            self.heading_rad,
            self.magnetic_rad,
            self.variation_rad,
            self.speed_mps,
            self.depth_m,
        ];
        let is_set = figures.iter().any(|figure| !figure.is_nan());
        self.position.is_some() || self.unix_s.is_some() || is_set
    }
}

/// Returns true if the two digits after `*` are the exclusive or of the bytes before it.
fn is_sum(body: &str, sum: &str) -> bool {
    let expected = body.bytes().fold(0, |sum, byte| sum ^ byte);
    let stated = sum.get(..2).and_then(|sum| u8::from_str_radix(sum, 16).ok());
    stated == Some(expected)
}

/// Converts `dddmm.mmmm` and a letter to degrees; `None` where they are not plausible.
fn angle_deg(value: f64, letter: &str, positive: &str, negative: &str) -> Option<f64> {
    let whole_deg = (value / 100.0).trunc();
    let minutes = value - whole_deg * 100.0;
    let deg = whole_deg + minutes / 60.0;
    match letter {
        _ if !(0.0..60.0).contains(&minutes) || deg > 180.0 => None,
        letter if letter == positive => Some(deg),
        letter if letter == negative => Some(-deg),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_courses_and_headings_are_read() {
        // Example of the public descriptions.
        let gga = b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
        let at = sentence(gga).and_then(|sentence| sentence.position).expect("a position");
        assert!((at.lat_deg - 48.1173).abs() < 1e-9 && (at.lon_deg - 11.516_666_7).abs() < 1e-7);
        let rmc = b"$GPRMC,123519,A,4807.038,S,01131.000,W,022.4,084.4,230394,003.1,W*7A";
        let parsed = sentence(b"$GPRMC,123519,A,4807.038,S,01131.000,W,022.4,084.4,230394,003.1,W");
        let parsed = parsed.expect("a sentence without a sum");
        assert_eq!(sentence(rmc).map(|sentence| sentence.position), None, "its sum is wrong");
        let at = parsed.position.expect("a position");
        assert!(at.lat_deg < -48.0 && at.lon_deg < -11.0);
        assert_eq!(parsed.utc_s, Some(45_319.0));
        assert!((parsed.speed_mps - 11.52).abs() < 0.01, "{}", parsed.speed_mps);
        assert!((parsed.cog_rad.to_degrees() - 84.4).abs() < 1e-3);
        // `date -u -d "1994-03-23 12:35:19" +%s`
        assert_eq!(parsed.unix_s, Some(764_426_119.0));
        assert!((parsed.variation_rad.to_degrees() + 3.1).abs() < 1e-4);
        let hdt = sentence(b"$HEHDT,271.5,T\0\0\xFF").expect("a heading");
        assert!((hdt.heading_rad.to_degrees() - 271.5).abs() < 1e-3);
    }

    #[test]
    fn depths_dates_and_magnetic_headings_are_read() {
        let read = |text: &str| sentence(text.as_bytes()).expect(text);
        let dpt = read("$SDDPT,6.29,-0.40*73");
        assert_eq!([dpt.depth_m, dpt.offset_m], [6.29, -0.4]);
        for text in
            ["$SDDBT,32.81,f,10.00,M,5.47,F", "$SDDBT,32.81,f,,M,,F", "$SDDBT,,f,,M,5.468,F"]
        {
            assert!((read(text).depth_m - 10.0).abs() < 1e-3, "{text}");
        }
        // `date -u -d "2024-02-29 23:59:59" +%s`
        assert_eq!(read("$GPZDA,235959.5,29,02,2024,00,00").unix_s, Some(1_709_251_199.5));
        let hdg = read("$HCHDG,98.3,1.0,E,12.6,W");
        let degrees = [hdg.magnetic_rad, hdg.variation_rad].map(f32::to_degrees);
        assert!((degrees[0] - 99.3).abs() < 1e-4 && (degrees[1] + 12.6).abs() < 1e-4);
        assert!((read("$HCHDM,238.5,M").magnetic_rad.to_degrees() - 238.5).abs() < 1e-3);
        assert!(read("$GNGNS,101112,4807.038,N,01131.000,E,AN,08,1.1,,,").position.is_some());
        assert_eq!(sentence(b"$GNGNS,101112,4807.038,N,01131.000,E,NN,08"), None);
        assert_eq!(sentence(b"$GPZDA,235959,31,02,2024"), None);
        assert_eq!(sentence(b"$SDDPT,,"), None);
    }

    #[test]
    fn what_tells_nothing_is_left_out() {
        for bytes in [
            &b""[..],
            b"$",
            b"$GP",
            b"$GPGSV,1",
            b"$GPGGA,123519,4807.038,N,01131.000,E,0,08",
            b"$GPGGA,123519,4867.038,N,01131.000,E,1,08",
            b"$GPGGA,123519,NaN,N,inf,E,1,08",
            b"$GPRMC,123519,V,4807.038,N,01131.000,E,022.4,084.4",
            b"no sentence",
            b"$\xFF\xFE",
        ] {
            assert_eq!(sentence(bytes), None, "{bytes:?}");
        }
    }
}
