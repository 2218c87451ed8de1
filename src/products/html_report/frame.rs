//! Transforms metres of a plane to pixels on the page and computes the frame of a map, with
//! graticule, scale bar and north arrow.

use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::presentation::graticule::{LineFamily, Net};
use bathyscope_bottom::presentation::page::{Value, context};
use bathyscope_bottom::presentation::ticks;
use bathyscope_log::support::geo::{CoordinateFormat, MapPlane};

/// Largest width and height of a map, pixels.
const MOST_PX: [f64; 2] = [900.0, 760.0];
/// Smallest side of a map, pixels, so that a single straight line still makes a map.
const LEAST_PX: f64 = 220.0;
/// Margins of the map, pixels: for labels on the left and below, and for the legend on the right.
const LEFT_PX: f64 = 86.0;
const BELOW_PX: f64 = 26.0;
const ABOVE_PX: f64 = 6.0;
const RIGHT_PX: f64 = 96.0;
/// Share of the extent that is left free on every side.
const FREE: f64 = 0.04;
/// Least distance between lines of the graticule, pixels.
const BETWEEN_PX: f64 = 180.0;

/// Transform from metres of a plane to pixels on the page.
pub(super) struct PageTransform {
    map: MapPlane,
    west_m: f64,
    north_m: f64,
    /// Number of pixels in a metre.
    pub px_per_m: f64,
    width_px: f64,
    /// Height of the map, pixels.
    pub height_px: f64,
}

impl PageTransform {
    /// Creates the transform for a map around some bounds in its plane, metres; `None` where the
    /// bounds have no extent or are not finite.
    pub(super) fn around([west, south, east, north]: [f64; 4], map: &MapPlane) -> Option<Self> {
        let (width_m, height_m) = (east - west, north - south);
        let longest_m = width_m.max(height_m);
        if !(longest_m > 0.0 && longest_m.is_finite()) {
            return None;
        }
        let free_m = FREE * longest_m;
        let needed_m = [width_m + 2.0 * free_m, height_m + 2.0 * free_m];
        let px_per_m = (MOST_PX[0] / needed_m[0]).min(MOST_PX[1] / needed_m[1]);
        let [width_px, height_px] = needed_m.map(|metres| (metres * px_per_m).max(LEAST_PX));
        Some(Self {
            map: map.clone(),
            west_m: 0.5 * (west + east) - 0.5 * width_px / px_per_m,
            north_m: 0.5 * (south + north) + 0.5 * height_px / px_per_m,
            px_per_m,
            width_px,
            height_px,
        })
    }

    /// Returns the place of a picture with a pixel for each cell of a grid.
    pub(super) fn picture(&self, grid: &Grid, address: String) -> Value {
        let scale = grid.cell_m * self.px_per_m;
        let [x, y] = self.place([grid.west_m, grid.north_m]);
        context! {
            x => format!("{x:.2}"),
            y => format!("{y:.2}"),
            width => format!("{:.2}", grid.columns as f64 * scale),
            height => format!("{:.2}", grid.rows as f64 * scale),
            address,
        }
    }

    /// Converts a place of the plane to pixels from the left and from the top.
    pub(super) fn place(&self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        [
            LEFT_PX + (east_m - self.west_m) * self.px_per_m,
            ABOVE_PX + (self.north_m - north_m) * self.px_per_m,
        ]
    }

    fn metres(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.west_m + (x - LEFT_PX) / self.px_per_m, self.north_m - (y - ABOVE_PX) / self.px_per_m]
    }

    /// Returns the left and the upper edge of the legend, to the right of the map, pixels.
    pub(super) fn legend_at(&self) -> [f64; 2] {
        [LEFT_PX + self.width_px + 14.0, ABOVE_PX + 4.0]
    }

    /// Returns the path of a line without steps shorter than half a pixel; the path breaks where a
    /// place is not finite.
    pub(super) fn path(&self, points: impl Iterator<Item = [f64; 2]>) -> String {
        let mut path = String::new();
        let (mut last, mut held) = (None::<[f64; 2]>, None::<[f64; 2]>);
        let step = |path: &mut String, letter: char, [x, y]: [f64; 2]| {
            *path += &format!("{letter}{x:.1} {y:.1}");
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

    /// Returns the frame of the map.
    pub(super) fn values(&self) -> Value {
        context! {
            left => LEFT_PX.to_string(),
            top => ABOVE_PX.to_string(),
            inner_width => pixels(self.width_px),
            inner_height => pixels(self.height_px),
            width => format!("{:.0}", LEFT_PX + self.width_px + RIGHT_PX),
            height => format!("{:.0}", ABOVE_PX + self.height_px + BELOW_PX),
            graticule => self.graticule(),
            bar => self.scale_bar(),
            north => self.north_arrow(),
        }
    }

    /// Returns meridians and parallels with their degrees at the edges of the map.
    fn graticule(&self) -> Vec<Value> {
        let (right, bottom) = (LEFT_PX + self.width_px, ABOVE_PX + self.height_px);
        let at = |x: f64, y: f64| self.map.to_lon_lat(self.metres([x, y]));
        let net = Net::Degrees {
            middle_deg: at(0.5 * (LEFT_PX + right), 0.5 * (ABOVE_PX + bottom)).lon_deg,
            format: CoordinateFormat::Degrees,
        };
        let corners =
            [at(LEFT_PX, ABOVE_PX), at(right, ABOVE_PX), at(LEFT_PX, bottom), at(right, bottom)];
        let Some(bounds) = net.bounds(corners) else {
            return Vec::new();
        };
        let [west, south, east, north] = bounds;
        let across_deg = (east - west) * BETWEEN_PX / self.width_px;
        let up_deg = (north - south) * BETWEEN_PX / self.height_px;
        let mut drawn = Vec::new();
        for (family, least_deg) in [(LineFamily::Upright, across_deg), (LineFamily::Level, up_deg)]
        {
            for line in net.lines(family, bounds, least_deg) {
                // Two points are enough, because the lines are nearly straight within a survey.
                let places = net.places(family, line.value, bounds, 2);
                let ends: Vec<[f64; 2]> = places.map(|at| self.place(self.map.place(at))).collect();
                if let [from, to] = ends[..] {
                    drawn.push(self.graticule_line(family, &line.label, [from, to]));
                }
            }
        }
        drawn
    }

    /// Returns a line with its label where it meets the lower or the left edge.
    fn graticule_line(
        &self,
        family: LineFamily,
        label: &str,
        [[x1, y1], [x2, y2]]: [[f64; 2]; 2],
    ) -> Value {
        let (right, bottom) = (LEFT_PX + self.width_px, ABOVE_PX + self.height_px);
        let (is_labelled, x, y, anchor) = match family {
            LineFamily::Upright => {
                let x = x1 + (bottom - y1) / (y2 - y1) * (x2 - x1);
                let is_inside = (LEFT_PX + 20.0..right - 20.0).contains(&x);
                (is_inside, x, bottom + 15.0, "middle")
            }
            LineFamily::Level => {
                let y = y1 + (LEFT_PX - x1) / (x2 - x1) * (y2 - y1);
                let is_inside = (ABOVE_PX + 6.0..bottom - 6.0).contains(&y);
                (is_inside, LEFT_PX - 5.0, y + 4.0, "end")
            }
        };
        context! {
            path => format!("M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}"),
            is_labelled,
            label,
            x => pixels(x),
            y => pixels(y),
            anchor,
        }
    }

    /// Returns the scale bar at the lower left.
    fn scale_bar(&self) -> Value {
        let middle = self.metres([LEFT_PX + 0.5 * self.width_px, ABOVE_PX + 0.5 * self.height_px]);
        let px_per_ground_m = self.px_per_m * self.map.area_scale_at(middle).sqrt();
        let length_m = ticks::round_down(0.25 * self.width_px / px_per_ground_m);
        let length_px = length_m * px_per_ground_m;
        let (x, y) = (LEFT_PX + 14.0, ABOVE_PX + self.height_px - 14.0);
        context! {
            x => x.to_string(),
            y => y.to_string(),
            length => pixels(length_px),
            text_x => pixels(x + 0.5 * length_px),
            text_y => pixels(y - 7.0),
            label => ticks::bar_label(length_m),
        }
    }

    /// Returns the north arrow at the upper right.
    fn north_arrow(&self) -> Value {
        let (x, y) = (LEFT_PX + self.width_px - 20.0, ABOVE_PX + 14.0);
        context!(x => x.to_string(), y => y.to_string(), text_y => pixels(y + 31.0))
    }
}

/// Writes a length or a place on the page.
pub(super) fn pixels(pixels: f64) -> String {
    format!("{pixels:.1}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::{CrsChoice, LonLat};

    fn zone_12() -> MapPlane {
        let origin = LonLat { lon_deg: -111.0, lat_deg: 36.9 };
        MapPlane::new(CrsChoice::Utm.at(origin).unwrap(), origin)
    }

    #[test]
    fn places_keep_their_shape_and_lie_inside() {
        let bounds = [456_000.0, 4_087_000.0, 456_400.0, 4_087_100.0];
        let frame = PageTransform::around(bounds, &zone_12()).unwrap();
        let [west, south] = frame.place([bounds[0], bounds[1]]);
        let [east, north] = frame.place([bounds[2], bounds[3]]);
        assert!(((east - west) / (south - north) - 4.0).abs() < 1e-9);
        assert!(west > LEFT_PX && east < LEFT_PX + MOST_PX[0] && north > ABOVE_PX);
        let [e, n] = frame.metres(frame.place([456_123.0, 4_087_045.0]));
        assert!((e - 456_123.0).abs() < 1e-6 && (n - 4_087_045.0).abs() < 1e-6);
    }

    #[test]
    fn no_extent_makes_no_map() {
        assert!(PageTransform::around([1.0, 1.0, 1.0, 1.0], &zone_12()).is_none());
        assert!(
            PageTransform::around([f64::MAX, f64::MAX, f64::MIN, f64::MIN], &zone_12()).is_none()
        );
    }

    #[test]
    fn paths_break_at_gaps_and_keep_their_ends() {
        let frame = PageTransform::around([0.0, 0.0, 100.0, 100.0], &zone_12()).unwrap();
        let dense = (0..1000).map(|step| [f64::from(step) * 0.001, 0.0]);
        let path = frame.path(dense.chain([[f64::NAN, 0.0], [50.0, 50.0], [60.0, 60.0]]));
        assert_eq!(path.matches('M').count(), 2, "{path}");
        let steps = path.matches('L').count();
        assert!((2..25).contains(&steps), "{path}");
        let [x, y] = frame.place([0.999, 0.0]);
        assert!(path.contains(&format!("L{x:.1} {y:.1}M")), "{path}");
    }
}
