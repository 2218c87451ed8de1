//! A map on the page: from metres of a plane to pixels, with graticule, scale bar and north arrow.

use super::text::one_two_five;
use crate::export::xml;
use crate::geo::{LonLat, MapPlane};
use std::fmt::Write as _;

/// Largest map, pixels.
const MOST_PX: [f64; 2] = [900.0, 760.0];
/// Smallest side, so that a single straight line still makes a map.
const LEAST_PX: f64 = 220.0;
/// Room for labels on the left and below, and for the legend on the right.
const LEFT_PX: f64 = 86.0;
const BELOW_PX: f64 = 26.0;
const ABOVE_PX: f64 = 6.0;
const RIGHT_PX: f64 = 96.0;
/// Part of the extent that is left free on every side.
const FREE: f64 = 0.04;
/// Steps between lines of the graticule, degrees: seconds and minutes of arc that divide evenly.
const STEPS_DEG: [f64; 12] = [
    0.000_05, 0.000_1, 0.000_2, 0.000_5, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2,
];

/// Bounds of a map: west, south, east, north, metres.
pub type Bounds = [f64; 4];

/// Where the metres of a plane lie on the page.
pub struct Frame {
    map: MapPlane,
    west_m: f64,
    north_m: f64,
    px_per_m: f64,
    width_px: f64,
    height_px: f64,
}

impl Frame {
    /// A frame around some bounds in the plane of a map; `None` where these are no place.
    pub fn around([west, south, east, north]: Bounds, map: &MapPlane) -> Option<Self> {
        let (width_m, height_m) = (east - west, north - south);
        let longest_m = width_m.max(height_m);
        if !(longest_m > 0.0 && longest_m.is_finite()) {
            return None;
        }
        let free_m = FREE * longest_m;
        let wanted_m = [width_m + 2.0 * free_m, height_m + 2.0 * free_m];
        let px_per_m = (MOST_PX[0] / wanted_m[0]).min(MOST_PX[1] / wanted_m[1]);
        let [width_px, height_px] = wanted_m.map(|metres| (metres * px_per_m).max(LEAST_PX));
        Some(Self {
            map: map.clone(),
            west_m: 0.5 * (west + east) - 0.5 * width_px / px_per_m,
            north_m: 0.5 * (south + north) + 0.5 * height_px / px_per_m,
            px_per_m,
            width_px,
            height_px,
        })
    }

    /// Pixels from the left and the top.
    pub fn place(&self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        [
            LEFT_PX + (east_m - self.west_m) * self.px_per_m,
            ABOVE_PX + (self.north_m - north_m) * self.px_per_m,
        ]
    }

    fn metres(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.west_m + (x - LEFT_PX) / self.px_per_m,
            self.north_m - (y - ABOVE_PX) / self.px_per_m,
        ]
    }

    /// Pixels in a metre.
    pub fn px_per_m(&self) -> f64 {
        self.px_per_m
    }

    /// Left and upper edge of what lies to the right of the map.
    pub fn legend_at(&self) -> [f64; 2] {
        [LEFT_PX + self.width_px + 14.0, ABOVE_PX + 4.0]
    }

    /// Height of the map, pixels.
    pub fn height_px(&self) -> f64 {
        self.height_px
    }

    /// The outline of a line, without steps shorter than half a pixel; it breaks where a place is no number.
    pub fn path(&self, points: impl Iterator<Item = [f64; 2]>) -> String {
        let mut path = String::new();
        let (mut last, mut held) = (None::<[f64; 2]>, None::<[f64; 2]>);
        let step = |path: &mut String, letter: char, [x, y]: [f64; 2]| {
            // Writing to a string cannot fail.
            write!(path, "{letter}{x:.1} {y:.1}").ok();
        };
        for point in points {
            let at = self.place(point);
            if !at.iter().all(|pixels| pixels.is_finite()) {
                if let Some(end) = held.take() {
                    step(&mut path, 'L', end);
                }
                last = None;
                continue;
            }
            match last {
                None => step(&mut path, 'M', at),
                Some([x, y]) if (at[0] - x).hypot(at[1] - y) < 0.5 => {
                    held = Some(at);
                    continue;
                }
                Some(_) => step(&mut path, 'L', at),
            }
            (last, held) = (Some(at), None);
        }
        if let Some(end) = held {
            step(&mut path, 'L', end);
        }
        path
    }

    /// The map as an `svg` element: `under` the graticule, `over` it, and `beside` the map.
    pub fn svg(&self, name: &str, under: &str, over: &str, beside: &str) -> String {
        let (width, height) = (
            LEFT_PX + self.width_px + RIGHT_PX,
            ABOVE_PX + self.height_px + BELOW_PX,
        );
        let (inner_width, inner_height) = (self.width_px, self.height_px);
        // Names of clips belong to the whole page: this one follows from the picture's.
        let clip: String = name.chars().filter(char::is_ascii_alphanumeric).collect();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"{label}\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" font-family=\"sans-serif\" font-size=\"11\">\n\
             <clipPath id=\"{clip}\"><rect x=\"{LEFT_PX}\" y=\"{ABOVE_PX}\" width=\"{inner_width:.1}\" height=\"{inner_height:.1}\"/></clipPath>\n\
             <rect x=\"{LEFT_PX}\" y=\"{ABOVE_PX}\" width=\"{inner_width:.1}\" height=\"{inner_height:.1}\" fill=\"#f7f7f5\"/>\n\
             <g clip-path=\"url(#{clip})\">\n{under}</g>\n{graticule}<g clip-path=\"url(#{clip})\">\n{over}</g>\n\
             <rect x=\"{LEFT_PX}\" y=\"{ABOVE_PX}\" width=\"{inner_width:.1}\" height=\"{inner_height:.1}\" fill=\"none\" stroke=\"#333333\"/>\n{furniture}{beside}</svg>\n",
            label = xml(name),
            graticule = self.graticule(&clip),
            furniture = self.furniture(),
        )
    }

    /// Meridians and parallels with their degrees at the frame.
    fn graticule(&self, clip: &str) -> String {
        let (right, bottom) = (LEFT_PX + self.width_px, ABOVE_PX + self.height_px);
        let at = |x: f64, y: f64| self.map.to_lon_lat(self.metres([x, y]));
        let corners = [
            at(LEFT_PX, ABOVE_PX),
            at(right, ABOVE_PX),
            at(LEFT_PX, bottom),
            at(right, bottom),
        ];
        let mut drawn = String::new();
        for axis in Axis::BOTH {
            let along = corners.map(|corner| axis.of(corner));
            let [low, high] = [
                along.iter().copied().fold(f64::MAX, f64::min),
                along.iter().copied().fold(f64::MIN, f64::max),
            ];
            let across = corners.map(|corner| axis.other().of(corner));
            let length_px = match axis {
                Axis::Lon => self.width_px,
                Axis::Lat => self.height_px,
            };
            let step_deg = step_deg(high - low, length_px);
            let first = (low / step_deg).ceil() as i64;
            let last = (high / step_deg).floor() as i64;
            for index in first..=last {
                let value_deg = index as f64 * step_deg;
                self.graticule_line(&mut drawn, clip, axis, value_deg, step_deg, across);
            }
        }
        drawn
    }

    fn graticule_line(
        &self,
        drawn: &mut String,
        clip: &str,
        axis: Axis,
        value_deg: f64,
        step_deg: f64,
        across: [f64; 4],
    ) {
        let low = across.iter().copied().fold(f64::MAX, f64::min);
        let high = across.iter().copied().fold(f64::MIN, f64::max);
        let ends = [low, high].map(|other| self.place(self.map.place(axis.at(value_deg, other))));
        let [[x1, y1], [x2, y2]] = ends;
        let text = axis.text(value_deg, step_deg);
        let label = match axis {
            // Where the line meets the lower edge, and the left one: it is all but straight within a survey.
            Axis::Lon => {
                let bottom = ABOVE_PX + self.height_px;
                let x = x1 + (bottom - y1) / (y2 - y1) * (x2 - x1);
                let inside = (LEFT_PX + 20.0..LEFT_PX + self.width_px - 20.0).contains(&x);
                inside.then(|| {
                    format!(
                        "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{text}</text>",
                        bottom + 15.0
                    )
                })
            }
            Axis::Lat => {
                let y = y1 + (LEFT_PX - x1) / (x2 - x1) * (y2 - y1);
                let inside = (ABOVE_PX + 6.0..ABOVE_PX + self.height_px - 6.0).contains(&y);
                inside.then(|| {
                    format!(
                        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
                        LEFT_PX - 5.0,
                        y + 4.0
                    )
                })
            }
        };
        // Writing to a string cannot fail.
        writeln!(
            drawn,
            "<path clip-path=\"url(#{clip})\" d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" stroke=\"#000000\" stroke-opacity=\"0.18\" fill=\"none\"/>{}",
            label.unwrap_or_default()
        )
        .ok();
    }

    /// Scale bar below on the left, north arrow above on the right.
    fn furniture(&self) -> String {
        let middle = self.metres([
            LEFT_PX + 0.5 * self.width_px,
            ABOVE_PX + 0.5 * self.height_px,
        ]);
        let scale = self.map.area_scale_at(middle).sqrt();
        let px_per_ground_m = self.px_per_m * scale;
        let length_m = one_two_five(0.25 * self.width_px / px_per_ground_m);
        let length_px = length_m * px_per_ground_m;
        let (x, y) = (LEFT_PX + 14.0, ABOVE_PX + self.height_px - 14.0);
        let text = match length_m >= 1000.0 {
            true => format!("{} km", length_m / 1000.0),
            false => format!("{length_m} m"),
        };
        let (arrow_x, arrow_y) = (LEFT_PX + self.width_px - 20.0, ABOVE_PX + 14.0);
        format!(
            "<g stroke=\"#ffffff\" stroke-width=\"5\" stroke-opacity=\"0.8\" fill=\"none\"><path d=\"M{x} {y}h{length_px:.1}\"/></g>\
             <path d=\"M{x} {y}h{length_px:.1}m0 -4v8m-{length_px:.1} -8v8\" stroke=\"#111111\" stroke-width=\"1.5\" fill=\"none\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" paint-order=\"stroke\" stroke=\"#ffffff\" stroke-width=\"3\">{text}</text>\n\
             <path d=\"M{arrow_x} {arrow_y}l6 18l-6 -4l-6 4z\" fill=\"#111111\" stroke=\"#ffffff\"/>\
             <text x=\"{arrow_x}\" y=\"{:.1}\" text-anchor=\"middle\" font-weight=\"bold\" paint-order=\"stroke\" stroke=\"#ffffff\" stroke-width=\"3\">N</text>\n",
            x + 0.5 * length_px,
            y - 7.0,
            arrow_y + 31.0,
        )
    }
}

#[derive(Clone, Copy)]
enum Axis {
    Lon,
    Lat,
}

impl Axis {
    const BOTH: [Axis; 2] = [Axis::Lon, Axis::Lat];

    fn of(self, position: LonLat) -> f64 {
        match self {
            Axis::Lon => position.lon_deg,
            Axis::Lat => position.lat_deg,
        }
    }

    fn other(self) -> Self {
        match self {
            Axis::Lon => Axis::Lat,
            Axis::Lat => Axis::Lon,
        }
    }

    fn at(self, value_deg: f64, other_deg: f64) -> LonLat {
        let (lon_deg, lat_deg) = match self {
            Axis::Lon => (value_deg, other_deg),
            Axis::Lat => (other_deg, value_deg),
        };
        LonLat { lon_deg, lat_deg }
    }

    fn text(self, value_deg: f64, step_deg: f64) -> String {
        let decimals = (-step_deg.log10()).ceil().clamp(0.0, 6.0) as usize;
        let letter = match (self, value_deg < 0.0) {
            (Axis::Lon, false) => 'E',
            (Axis::Lon, true) => 'W',
            (Axis::Lat, false) => 'N',
            (Axis::Lat, true) => 'S',
        };
        format!("{:.decimals$}\u{b0} {letter}", value_deg.abs())
    }
}

/// Step between lines about 180 pixels apart.
fn step_deg(extent_deg: f64, length_px: f64) -> f64 {
    let wanted = extent_deg * 180.0 / length_px;
    let found = STEPS_DEG.into_iter().find(|step| *step >= wanted);
    // A map of more than a few degrees is a damaged one; whole degrees then.
    found.unwrap_or_else(|| one_two_five(wanted).max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geo::CrsChoice;

    fn zone_12() -> MapPlane {
        let origin = LonLat {
            lon_deg: -111.0,
            lat_deg: 36.9,
        };
        MapPlane::new(CrsChoice::Utm.at(origin).unwrap(), origin)
    }

    #[test]
    fn places_keep_their_shape_and_lie_inside() {
        let bounds = [456_000.0, 4_087_000.0, 456_400.0, 4_087_100.0];
        let frame = Frame::around(bounds, &zone_12()).unwrap();
        let [west, south] = frame.place([bounds[0], bounds[1]]);
        let [east, north] = frame.place([bounds[2], bounds[3]]);
        assert!(((east - west) / (south - north) - 4.0).abs() < 1e-9);
        assert!(west > LEFT_PX && east < LEFT_PX + MOST_PX[0] && north > ABOVE_PX);
        let [e, n] = frame.metres(frame.place([456_123.0, 4_087_045.0]));
        assert!((e - 456_123.0).abs() < 1e-6 && (n - 4_087_045.0).abs() < 1e-6);
    }

    #[test]
    fn no_extent_makes_no_map() {
        assert!(Frame::around([1.0, 1.0, 1.0, 1.0], &zone_12()).is_none());
        assert!(Frame::around([f64::MAX, f64::MAX, f64::MIN, f64::MIN], &zone_12()).is_none());
    }

    #[test]
    fn paths_break_at_gaps_and_keep_their_ends() {
        let frame = Frame::around([0.0, 0.0, 100.0, 100.0], &zone_12()).unwrap();
        let dense = (0..1000).map(|step| [f64::from(step) * 0.001, 0.0]);
        let path = frame.path(dense.chain([[f64::NAN, 0.0], [50.0, 50.0], [60.0, 60.0]]));
        assert_eq!(path.matches('M').count(), 2, "{path}");
        let steps = path.matches('L').count();
        assert!((2..25).contains(&steps), "{path}");
        let [x, y] = frame.place([0.999, 0.0]);
        assert!(path.contains(&format!("L{x:.1} {y:.1}M")), "{path}");
    }

    #[test]
    fn steps_are_round() {
        assert_eq!(step_deg(0.004, 800.0), 0.001);
        assert_eq!(Axis::Lon.text(-111.49, 0.005), "111.490\u{b0} W");
    }
}
