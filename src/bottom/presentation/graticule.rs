//! Computes the graticule of a map, for Bathyscope and for the report: lines at round degrees,
//! minutes or seconds, or at round metres of the UTM zone, with labels of no more digits than
//! needed.
//!
//! In: bounds of a map, and the format of coordinates. Out: lines with labels.

use super::ticks;
use bathyscope_log::support::geo::{CoordinateFormat, LonLat, UtmZone};

/// Coordinates of the lines on a map.
#[derive(Clone, Copy, Debug)]
pub enum Net {
    /// Longitude and latitude; longitudes continue beyond 180 degrees from that of the middle, so
    /// that there is no gap at the date line.
    Degrees {
        /// Longitude of the middle of the map, degrees.
        middle_deg: f64,
        /// Format of coordinates.
        format: CoordinateFormat,
    },
    /// Easting and northing of a zone, metres.
    Utm(UtmZone),
}

/// West, south, east and north of a map, in degrees or metres of its net.
pub type NetBounds = [f64; 4];

/// Family of lines: meridians or lines of easting, parallels or lines of northing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineFamily {
    /// Lines from south to north, each at an easting or a longitude.
    Upright,
    /// Lines from west to east, each at a northing or a latitude.
    Level,
}

/// Line with its label.
#[derive(Clone, Debug, PartialEq)]
pub struct GraticuleLine {
    /// Coordinate of the line, degrees or metres.
    pub value: f64,
    /// Label of the line: `36.8775° N`, `462500 E`.
    pub label: String,
}

impl Net {
    /// Creates the net of a map around `middle`; from 80 degrees of latitude on, where UTM is not
    /// defined everywhere, a net of degrees.
    pub fn new(format: CoordinateFormat, zone: UtmZone, middle: LonLat) -> Self {
        match format {
            CoordinateFormat::Utm if middle.lat_deg.abs() < 80.0 => Self::Utm(zone),
            _ => Self::Degrees { middle_deg: middle.lon_deg, format },
        }
    }

    fn of_position(&self, at: LonLat) -> [f64; 2] {
        match self {
            Self::Degrees { middle_deg, .. } => {
                let beyond = at.lon_deg - middle_deg;
                let turns = (beyond / 360.0).round();
                [middle_deg + beyond - 360.0 * turns, at.lat_deg]
            }
            Self::Utm(zone) => zone.to_metres(at),
        }
    }

    fn to_position(self, [x, y]: [f64; 2]) -> LonLat {
        match self {
            Self::Degrees { .. } => LonLat::new(x, y),
            Self::Utm(zone) => zone.to_lon_lat([x, y]),
        }
    }

    /// Returns the bounds of a map from places along its edge; `None` where a coordinate is not
    /// finite.
    pub fn bounds(&self, edge: impl IntoIterator<Item = LonLat>) -> Option<NetBounds> {
        let nowhere = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let places = edge.into_iter().map(|at| self.of_position(at));
        let bounds =
            places.fold(nowhere, |[w, s, e, n], [x, y]| [w.min(x), s.min(y), e.max(x), n.max(y)]);
        bounds.iter().all(|edge| edge.is_finite()).then_some(bounds)
    }

    /// Returns the lines of a family within bounds, at least `least` degrees or metres apart.
    pub fn lines(&self, family: LineFamily, bounds: NetBounds, least: f64) -> Vec<GraticuleLine> {
        let [west, south, east, north] = bounds;
        let [low, high] = match family {
            LineFamily::Upright => [west, east],
            LineFamily::Level => [south, north],
        };
        match self {
            Self::Degrees { format, .. } => {
                let graticule = Graticule::new(*format, least);
                let line = |value| GraticuleLine { value, label: graticule.label(value, family) };
                graticule.lines(low, high).map(line).collect()
            }
            Self::Utm(_) => {
                let step = ticks::round_step(least, 1.0);
                let letter = match family {
                    LineFamily::Upright => 'E',
                    LineFamily::Level => 'N',
                };
                let line = |value| GraticuleLine {
                    value,
                    label: format!("{} {letter}", ticks::label(value, step)),
                };
                ticks::multiples(low, high, step).map(line).collect()
            }
        }
    }

    /// Returns a label as long as those of upright lines at least `least` apart, to measure the
    /// space that they take.
    pub fn typical_label(&self, [west, _, east, _]: NetBounds, least: f64) -> String {
        match self {
            Self::Degrees { format, .. } => {
                Graticule::new(*format, least).label(0.5 * (west + east), LineFamily::Upright)
            }
            Self::Utm(_) => "500000.0 E".to_owned(),
        }
    }

    /// Returns places along a line from one bound to the other, `count` of them, at least two.
    pub fn places(
        self,
        family: LineFamily,
        value: f64,
        bounds: NetBounds,
        count: usize,
    ) -> impl Iterator<Item = LonLat> {
        let [west, south, east, north] = bounds;
        let last = count.max(2) - 1;
        (0..=last).map(move |index| {
            let share = index as f64 / last as f64;
            self.to_position(match family {
                LineFamily::Upright => [value, south + (north - south) * share],
                LineFamily::Level => [west + (east - west) * share, value],
            })
        })
    }
}

/// Number of millionths of a second of arc in a degree, a minute and a second; every step is a
/// whole number of these units.
const DEGREE: i64 = 3_600_000_000;
const MINUTE: i64 = DEGREE / 60;
const SECOND: i64 = MINUTE / 60;

/// Lines at multiples of a round step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Graticule {
    format: CoordinateFormat,
    step: i64,
}

impl Graticule {
    /// Creates the graticule with the smallest round step of at least `least_deg`: 1, 2 or 5 times
    /// a power of ten of the unit of the format, and 10, 15, 20 and 30 minutes and seconds. UTM
    /// uses degrees, since it is not defined at the poles.
    fn new(format: CoordinateFormat, least_deg: f64) -> Self {
        let least = (least_deg * DEGREE as f64).min(90.0 * DEGREE as f64);
        let fitting = steps(format).into_iter().find(|step| *step as f64 >= least);
        Self { format, step: fitting.unwrap_or(90 * DEGREE) }
    }

    /// Returns the lines from `low_deg` to `high_deg`, degrees; at most a thousand.
    fn lines(self, low_deg: f64, high_deg: f64) -> impl Iterator<Item = f64> {
        let step = self.step as f64;
        let first = (low_deg * DEGREE as f64 / step).ceil();
        let last = (high_deg * DEGREE as f64 / step).floor();
        let count = (last - first + 1.0).clamp(0.0, 1000.0) as i64;
        (0..count).map(move |index| (first + index as f64) * step / DEGREE as f64)
    }

    /// Returns the label of a line: `36.8775° N`, `36° 52.65' N`, `36° 52' 38" N`.
    fn label(self, degrees: f64, family: LineFamily) -> String {
        let turned = match family {
            LineFamily::Upright if degrees.abs() > 180.0 => {
                degrees - 360.0 * (degrees / 360.0).round()
            }
            _ => degrees,
        };
        let units = (turned.abs() * DEGREE as f64 / self.step as f64).round() as i64 * self.step;
        let letter = match (family, turned < 0.0 && units != 0) {
            (LineFamily::Level, false) => " N",
            (LineFamily::Level, true) => " S",
            // The date line and Greenwich are neither east nor west.
            (LineFamily::Upright, _) if units == 180 * DEGREE || units == 0 => "",
            (LineFamily::Upright, false) => " E",
            (LineFamily::Upright, true) => " W",
        };
        format!("{}{letter}", self.angle(units))
    }

    fn angle(self, units: i64) -> String {
        let whole = units / DEGREE;
        let (minutes, rest) = (units % DEGREE / MINUTE, units % MINUTE);
        match self.format {
            CoordinateFormat::Degrees | CoordinateFormat::Utm => {
                format!("{}°", decimal(units, self.step, DEGREE, 1))
            }
            _ if self.step % DEGREE == 0 => format!("{whole}°"),
            CoordinateFormat::Minutes => {
                let minutes = decimal(units % DEGREE, self.step, MINUTE, 2);
                format!("{whole}° {minutes}'")
            }
            CoordinateFormat::Seconds if self.step % MINUTE == 0 => {
                format!("{whole}° {minutes:02}'")
            }
            CoordinateFormat::Seconds => {
                let seconds = decimal(rest, self.step, SECOND, 2);
                format!("{whole}° {minutes:02}' {seconds}\"")
            }
        }
    }
}

/// Returns `value / unit` as text, with the decimals that multiples of `step` have, and at least
/// `digits` digits before the point.
fn decimal(value: i64, step: i64, unit: i64, digits: usize) -> String {
    let needed = (0..9).find(|places| step * 10i64.pow(*places) % unit == 0);
    let places = needed.unwrap_or(9) as usize;
    let width = if places == 0 { digits } else { digits + 1 + places };
    format!("{:0width$.places$}", value as f64 / unit as f64)
}

/// Returns the round steps of a format, smallest first.
fn steps(format: CoordinateFormat) -> Vec<i64> {
    let sixths = |unit: i64| [1, 2, 5, 10, 15, 20, 30].map(|count| count * unit);
    let degrees = [1, 2, 5, 10, 15, 30, 45, 90].map(|count| count * DEGREE);
    match format {
        CoordinateFormat::Degrees | CoordinateFormat::Utm => {
            [decimals(DEGREE, 7), degrees.to_vec()].concat()
        }
        CoordinateFormat::Minutes => {
            [decimals(MINUTE, 5), sixths(MINUTE).to_vec(), degrees.to_vec()].concat()
        }
        CoordinateFormat::Seconds => [
            decimals(SECOND, 3),
            sixths(SECOND).to_vec(),
            sixths(MINUTE).to_vec(),
            degrees.to_vec(),
        ]
        .concat(),
    }
}

/// Returns 1, 2 and 5 times the unit at each of `places` decimal places, smallest first.
fn decimals(unit: i64, places: u32) -> Vec<i64> {
    let at = |place: u32| [1, 2, 5].map(|count| count * unit / 10i64.pow(place));
    (1..=places).rev().flat_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use CoordinateFormat::{Degrees, Minutes, Seconds, Utm};

    fn at(lon_deg: f64, lat_deg: f64) -> LonLat {
        LonLat { lon_deg, lat_deg }
    }

    #[test]
    fn lines_run_across_the_date_line() {
        let middle = at(180.0, -17.0);
        let net = Net::new(CoordinateFormat::Degrees, UtmZone::of(middle), middle);
        let bounds = net.bounds([at(178.5, -17.5), at(-178.5, -16.4)]).unwrap();
        assert_eq!(bounds, [178.5, -17.5, 181.5, -16.4]);
        let names = |family| -> Vec<String> {
            let lines = net.lines(family, bounds, 0.7).into_iter();
            lines.map(|line| line.label).collect()
        };
        assert_eq!(names(LineFamily::Upright), ["179° E", "180°", "179° W"]);
        assert_eq!(names(LineFamily::Level), ["17° S"]);
    }

    #[test]
    fn utm_lines_lie_at_their_metres() {
        let middle = at(-111.49, 36.93);
        let net = Net::new(CoordinateFormat::Utm, UtmZone::of(middle), middle);
        let edge = [at(-111.492, 36.929), at(-111.488, 36.931)];
        let bounds = net.bounds(edge).unwrap();
        let lines = net.lines(LineFamily::Upright, bounds, 60.0);
        assert!(!lines.is_empty());
        for line in lines {
            assert_eq!(line.value % 100.0, 0.0);
            assert_eq!(line.label, format!("{} E", line.value));
            for place in net.places(LineFamily::Upright, line.value, bounds, 3) {
                let [easting_m, _] = net.of_position(place);
                assert!((easting_m - line.value).abs() < 1e-3);
            }
        }
        // UTM ends before the poles.
        let pole = Net::new(CoordinateFormat::Utm, UtmZone::of(middle), at(0.0, 85.0));
        assert!(matches!(pole, Net::Degrees { .. }));
    }

    #[test]
    fn what_is_no_place_has_no_bounds() {
        let net = Net::Degrees { middle_deg: 0.0, format: CoordinateFormat::Degrees };
        assert_eq!(net.bounds([at(f64::NAN, 1.0)]), None);
        assert_eq!(net.bounds([]), None);
    }

    fn labels(
        format: CoordinateFormat,
        least_deg: f64,
        low: f64,
        high: f64,
        family: LineFamily,
    ) -> Vec<String> {
        let graticule = Graticule::new(format, least_deg);
        graticule.lines(low, high).map(|line| graticule.label(line, family)).collect()
    }

    #[test]
    fn lines_are_round_in_what_the_format_counts_in() {
        let found = labels(Degrees, 4e-4, 36.8769, 36.8782, LineFamily::Level);
        assert_eq!(found, ["36.8770° N", "36.8775° N", "36.8780° N"]);
        let found = labels(Minutes, 0.7 / 60.0, 0.0 - 1.5 / 60.0, 1.5 / 60.0, LineFamily::Upright);
        assert_eq!(found, ["0° 01' W", "0° 00'", "0° 01' E"]);
        let found = labels(Minutes, 0.03 / 60.0, -36.8352, -36.8334, LineFamily::Level);
        assert_eq!(found, ["36° 50.10' S", "36° 50.05' S"]);
        let found = labels(Seconds, 11.0 / 3600.0, 7.995, 8.005, LineFamily::Upright);
        assert_eq!(found, ["7° 59' 45\" E", "8° 00' 00\" E", "8° 00' 15\" E"]);
        let found = labels(Seconds, 0.15 / 3600.0, 7.0, 7.0001, LineFamily::Level);
        assert_eq!(found, ["7° 00' 00.0\" N", "7° 00' 00.2\" N"]);
        assert_eq!(labels(Seconds, 0.4, 7.9, 9.1, LineFamily::Level).len(), 3);
    }

    #[test]
    fn steps_grow_and_are_never_smaller_than_asked() {
        for format in [Degrees, Minutes, Seconds, Utm] {
            let all = steps(format);
            assert!(all.is_sorted() && all[0] > 0, "{format:?} {all:?}");
            for least_deg in [1e-9, 1e-6, 3e-4, 0.02, 0.3, 7.0, 89.0, 1e5, f64::INFINITY] {
                let step = Graticule::new(format, least_deg).step as f64 / DEGREE as f64;
                assert!(
                    step >= least_deg.min(90.0) && step <= (3.1 * least_deg).max(1.1e-6),
                    "{step} {least_deg}"
                );
            }
        }
        assert_eq!(Graticule::new(Degrees, 1e-9).lines(f64::NAN, 1.0).count(), 0);
    }
}
