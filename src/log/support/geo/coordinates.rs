//! Formats positions as people write them: in degrees, minutes and seconds, or UTM metres.

use super::{LonLat, UtmZone};
use crate::named;
use serde::{Deserialize, Serialize};

/// Notation of a position. Each notation is precise to about a decimetre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum CoordinateFormat {
    /// Decimal degrees: `36.877100° N 111.516300° W`.
    #[default]
    Degrees,
    /// Degrees and minutes, as chart plotters show them: `36° 52.6260' N 111° 30.9780' W`.
    Minutes,
    /// Degrees, minutes and seconds: `36° 52' 37.56" N 111° 30' 58.68" W`.
    Seconds,
    /// Metres of a UTM zone: `UTM 12N 453987.7 E 4081363.2 N`.
    Utm,
}

/// Latitudes at which UTM is defined, degrees; the polar regions beyond have another grid.
const UTM_LATITUDES_DEG: std::ops::RangeInclusive<f64> = -80.0..=84.0;

named! {
    /// All formats in the order of the menu.
    pub CoordinateFormat {
        Degrees: "decimal degrees",
        Minutes: "degrees and minutes",
        Seconds: "degrees, minutes and seconds",
        Utm: "UTM metres",
    }
}

impl CoordinateFormat {
    /// Formats a position; a dash where it is not finite. UTM is written in `zone`, the zone of the
    /// survey, so that coordinates do not jump where the boat crosses the border of a zone; in the
    /// polar regions decimal degrees are written instead.
    pub fn write(self, at: LonLat, zone: UtmZone) -> String {
        if !(at.lon_deg.is_finite() && at.lat_deg.is_finite()) {
            return "–".to_owned();
        }
        if self == Self::Utm && UTM_LATITUDES_DEG.contains(&at.lat_deg) {
            let [easting_m, northing_m] = zone.to_metres(at);
            return format!("{} {easting_m:.1} E {northing_m:.1} N", zone.name());
        }
        format!("{} {}", self.latitude(at.lat_deg), self.longitude(at.lon_deg))
    }

    /// Formats a latitude alone; in decimal degrees for UTM.
    pub fn latitude(self, lat_deg: f64) -> String {
        self.angle(lat_deg, ["N", "S"])
    }

    /// Formats a longitude alone, between 180° W and 180° E; in decimal degrees for UTM.
    pub fn longitude(self, lon_deg: f64) -> String {
        let turns = if lon_deg.abs() > 180.0 { (lon_deg / 360.0).round() } else { 0.0 };
        self.angle(lon_deg - 360.0 * turns, ["E", "W"])
    }

    /// Formats an angle. It is rounded to a count of the smallest unit that is shown, and the count
    /// is split, so that 59.99996' becomes a whole degree and an angle that rounds to zero is not
    /// south or west.
    fn angle(self, degrees: f64, [positive, negative]: [&str; 2]) -> String {
        let per_degree: u64 = match self {
            Self::Degrees | Self::Utm => 1_000_000,
            Self::Minutes => 60 * 10_000,
            Self::Seconds => 3600 * 100,
        };
        let units = (degrees.abs() * per_degree as f64).round() as u64;
        let (whole, rest) = (units / per_degree, units % per_degree);
        let written = match self {
            Self::Degrees | Self::Utm => format!("{whole}.{rest:06}°"),
            Self::Minutes => format!("{whole}° {:02}.{:04}'", rest / 10_000, rest % 10_000),
            Self::Seconds => {
                let (minutes, seconds) = (rest / 6000, rest / 100 % 60);
                format!("{whole}° {minutes:02}' {seconds:02}.{:02}\"", rest % 100)
            }
        };
        let hemisphere = if degrees < 0.0 && units > 0 { negative } else { positive };
        format!("{written} {hemisphere}")
    }
}

#[cfg(test)]
mod tests {
    use super::CoordinateFormat::{Degrees, Minutes, Seconds, Utm};
    use super::*;
    use proptest::prelude::*;

    fn at(lon_deg: f64, lat_deg: f64) -> LonLat {
        LonLat { lon_deg, lat_deg }
    }

    fn write(format: CoordinateFormat, at: LonLat) -> String {
        format.write(at, UtmZone::of(at))
    }

    #[test]
    fn a_place_reads_the_same_in_every_form() {
        let bend = at(-111.5163, 36.8771);
        assert_eq!(write(Degrees, bend), "36.877100° N 111.516300° W");
        assert_eq!(write(Minutes, bend), "36° 52.6260' N 111° 30.9780' W");
        assert_eq!(write(Seconds, bend), "36° 52' 37.56\" N 111° 30' 58.68\" W");
        // pyproj 3.7.2, EPSG:32612 and EPSG:32756.
        assert_eq!(write(Utm, bend), "UTM 12N 453987.7 E 4081363.2 N");
        assert_eq!(write(Utm, at(151.2093, -33.8688)), "UTM 56S 334368.6 E 6250948.3 N");
    }

    #[test]
    fn what_rounds_to_a_whole_minute_or_degree_is_carried() {
        let nearly = 36.0 + 59.999_96 / 60.0;
        assert_eq!(Minutes.latitude(nearly), "37° 00.0000' N");
        assert_eq!(Minutes.latitude(36.0 + 59.9996 / 60.0), "36° 59.9996' N");
        assert_eq!(Seconds.longitude(-(nearly + 1e-4)), "37° 00' 00.36\" W");
        assert_eq!(Seconds.longitude(7.0 + 59.996 / 3600.0), "7° 01' 00.00\" E");
        assert_eq!(Degrees.latitude(-0.999_999_7), "1.000000° S");
    }

    #[test]
    fn zero_has_no_south_and_no_west() {
        for format in [Degrees, Minutes, Seconds] {
            for zero in [0.0, -0.0, -1e-9] {
                assert!(format.latitude(zero).ends_with(" N"), "{format:?} {zero}");
                assert!(format.longitude(zero).ends_with(" E"), "{format:?} {zero}");
            }
        }
        assert_eq!(Seconds.latitude(-0.01 / 3600.0), "0° 00' 00.01\" S");
    }

    #[test]
    fn the_date_line_and_the_poles_are_places() {
        assert_eq!(Degrees.longitude(180.0), "180.000000° E");
        assert_eq!(Degrees.longitude(-180.0), "180.000000° W");
        assert_eq!(Degrees.longitude(180.5), "179.500000° W");
        assert_eq!(Degrees.longitude(-181.0), "179.000000° E");
        assert_eq!(Minutes.latitude(89.999_999_99), "90° 00.0000' N");
        assert_eq!(write(Utm, at(15.0, 84.5)), "84.500000° N 15.000000° E");
        assert_eq!(write(Utm, at(15.0, -80.5)), "80.500000° S 15.000000° E");
        assert_eq!(write(Utm, at(f64::NAN, 3.0)), "–");
        assert_eq!(write(Degrees, at(3.0, f64::INFINITY)), "–");
    }

    #[test]
    fn a_survey_keeps_its_zone_across_the_border() {
        let zone = UtmZone::of(at(-108.001, 36.9));
        assert_eq!(zone.name(), "UTM 12N");
        let [west, east] = [-108.001, -107.999].map(|lon_deg| Utm.write(at(lon_deg, 36.9), zone));
        assert!(
            west.starts_with("UTM 12N 767") && east.starts_with("UTM 12N 767"),
            "{west} {east}"
        );
        let own = write(Utm, at(-107.999, 36.9));
        assert!(own.starts_with("UTM 13N 232"), "{own}");
    }

    /// Reads back a written position, from the numbers and the letters alone.
    fn read(text: &str) -> LonLat {
        if let Some(utm) = text.strip_prefix("UTM ") {
            let words: Vec<&str> = utm.split(' ').collect();
            let (number, hemisphere) = words[0].split_at(words[0].len() - 1);
            let zone = UtmZone { number: number.parse().unwrap(), north: hemisphere == "N" };
            return zone.to_lon_lat([words[1].parse().unwrap(), words[3].parse().unwrap()]);
        }
        let end = text.find(['N', 'S']).unwrap();
        let degrees = |angle: &str| {
            let numbers = angle.split(|letter: char| !letter.is_ascii_digit() && letter != '.');
            let parts = numbers.filter(|part| !part.is_empty());
            let parts = parts.map(|part| part.parse::<f64>().unwrap());
            let sign = if angle.ends_with(['S', 'W']) { -1.0 } else { 1.0 };
            sign * parts.zip([1.0, 60.0, 3600.0]).map(|(part, per)| part / per).sum::<f64>()
        };
        at(degrees(&text[end + 1..]), degrees(&text[..=end]))
    }

    proptest! {
        #[test]
        fn what_was_written_names_the_same_place(lon in -180.0..180.0f64, lat in -79.9..83.9f64) {
            for format in CoordinateFormat::ALL {
                let text = write(format, at(lon, lat));
                let back = read(&text);
                // Half of the last digit of the coarsest form, 0.01", and 0.05 m of UTM.
                let north_deg = (back.lat_deg - lat).abs();
                let east_deg = (back.lon_deg - lon).abs() * lat.to_radians().cos();
                prop_assert!(north_deg < 1.5e-6 && east_deg < 1.5e-6, "{text} is not {lon} {lat}");
                prop_assert!(!text.contains("° 60") && !text.contains("' 60"), "{text}");
            }
        }
    }
}
