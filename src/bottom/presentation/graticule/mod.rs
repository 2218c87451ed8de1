//! Computes the graticule of a map, for Bathyscope and for the report: lines at round degrees, or
//! at round metres of the UTM zone, with their labels.
//!
//! In: bounds of a map, and the format of coordinates. Out: lines with labels.

mod degrees;

use super::ticks;
use bathyscope_log::support::geo::{CoordinateFormat, LonLat, UtmZone};
use degrees::{DegreeAxis, Graticule};

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
                let line =
                    |value| GraticuleLine { value, label: graticule.label(value, family.axis()) };
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
                Graticule::new(*format, least).label(0.5 * (west + east), DegreeAxis::Longitude)
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

impl LineFamily {
    fn axis(self) -> DegreeAxis {
        match self {
            Self::Upright => DegreeAxis::Longitude,
            Self::Level => DegreeAxis::Latitude,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
