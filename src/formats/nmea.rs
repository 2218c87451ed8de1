//! NMEA 0183 sentences that recorders write into their logs: position, course, speed and heading.
//!
//! Fields as the public descriptions of NMEA 0183 have them: GGA, RMC and GLL give degrees and minutes as `ddmm.mmmm`, RMC and VTG knots
//! and the course over ground, HDT the true heading.

use crate::support::geo::{LonLat, MPS_PER_KNOT};

/// What one sentence tells; what it does not is NaN or `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sentence {
    /// Seconds since midnight, UTC.
    pub(super) utc_s: Option<f64>,
    /// Where the receiver is.
    pub(super) position: Option<LonLat>,
    /// Course over ground, radians from north, clockwise.
    pub(super) cog_rad: f32,
    /// Heading, radians from north, clockwise.
    pub(super) heading_rad: f32,
    /// Speed over ground, metres a second.
    pub(super) speed_mps: f32,
}

/// Reads a sentence, with or without its checksum; `None` for a damaged one and for one that tells nothing of this.
pub(super) fn sentence(bytes: &[u8]) -> Option<Sentence> {
    let start = bytes.iter().position(|&byte| byte == b'$')?;
    let text = std::str::from_utf8(&bytes[start + 1..]);
    let text = match text {
        Ok(text) => text,
        // What follows the sentence may be padding.
        Err(error) => std::str::from_utf8(bytes.get(start + 1..start + 1 + error.valid_up_to())?)
            .unwrap_or_default(),
    };
    let line = text.split(['\r', '\n', '\0']).next()?;
    let body = match line.split_once('*') {
        Some((body, sum)) if !is_sum(body, sum) => return None,
        Some((body, _)) => body,
        None => line,
    };
    let fields: Vec<&str> = body.split(',').collect();
    let field = |index: usize| fields.get(index).copied().unwrap_or_default();
    let number = |index: usize| {
        field(index)
            .trim()
            .parse::<f64>()
            .ok()
            .filter(|n| n.is_finite())
    };
    let degrees = |index: usize| number(index).map_or(f32::NAN, |deg| deg.to_radians() as f32);
    let knots = |index: usize| number(index).map_or(f32::NAN, |kn| (kn * MPS_PER_KNOT) as f32);
    let place = |first: usize| {
        Some(LonLat {
            lat_deg: angle_deg(number(first)?, field(first + 1), "N", "S")?,
            lon_deg: angle_deg(number(first + 2)?, field(first + 3), "E", "W")?,
        })
    };
    let utc_s = |index: usize| {
        let value = number(index)?;
        let [hours, minutes] = [value / 10_000.0, value / 100.0 % 100.0].map(f64::trunc);
        let utc_s = hours * 3600.0 + minutes * 60.0 + value % 100.0;
        (0.0..86_401.0).contains(&utc_s).then_some(utc_s)
    };
    let empty = Sentence {
        utc_s: None,
        position: None,
        cog_rad: f32::NAN,
        heading_rad: f32::NAN,
        speed_mps: f32::NAN,
    };
    let kind = field(0);
    let told = match kind.get(kind.len().checked_sub(3)?..)? {
        // Quality 0 is no fix.
        "GGA" => Sentence {
            utc_s: utc_s(1),
            position: place(2).filter(|_| number(6) != Some(0.0)),
            ..empty
        },
        "RMC" if field(2) == "A" => Sentence {
            utc_s: utc_s(1),
            position: place(3),
            speed_mps: knots(7),
            cog_rad: degrees(8),
            ..empty
        },
        "GLL" if field(6) != "V" => Sentence {
            utc_s: utc_s(5),
            position: place(1),
            ..empty
        },
        "VTG" => Sentence {
            cog_rad: degrees(1),
            speed_mps: knots(5),
            ..empty
        },
        "HDT" => Sentence {
            heading_rad: degrees(1),
            ..empty
        },
        _ => return None,
    };
    let is_empty = told.position.is_none()
        && [told.cog_rad, told.heading_rad, told.speed_mps].map(f32::is_nan) == [true; 3];
    (!is_empty).then_some(told)
}

/// Whether the two digits after `*` are the exclusive or of the bytes before it.
fn is_sum(body: &str, sum: &str) -> bool {
    let expected = body.bytes().fold(0, |sum, byte| sum ^ byte);
    let stated = sum
        .get(..2)
        .and_then(|sum| u8::from_str_radix(sum, 16).ok());
    stated == Some(expected)
}

/// Degrees of `dddmm.mmmm` and a letter.
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
        // The example of the public descriptions.
        let gga = b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
        let at = sentence(gga)
            .and_then(|told| told.position)
            .expect("a position");
        assert!((at.lat_deg - 48.1173).abs() < 1e-9 && (at.lon_deg - 11.516_666_7).abs() < 1e-7);
        let rmc = b"$GPRMC,123519,A,4807.038,S,01131.000,W,022.4,084.4,230394,003.1,W*7A";
        let told = sentence(b"$GPRMC,123519,A,4807.038,S,01131.000,W,022.4,084.4,230394,003.1,W");
        let told = told.expect("a sentence without a sum");
        assert_eq!(
            sentence(rmc).map(|told| told.position),
            None,
            "its sum is wrong"
        );
        let at = told.position.expect("a position");
        assert!(at.lat_deg < -48.0 && at.lon_deg < -11.0);
        assert_eq!(told.utc_s, Some(45_319.0));
        assert!((told.speed_mps - 11.52).abs() < 0.01, "{}", told.speed_mps);
        assert!((told.cog_rad.to_degrees() - 84.4).abs() < 1e-3);
        let hdt = sentence(b"$HEHDT,271.5,T\0\0\xFF").expect("a heading");
        assert!((hdt.heading_rad.to_degrees() - 271.5).abs() < 1e-3);
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
