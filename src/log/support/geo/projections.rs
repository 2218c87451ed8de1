//! Converts WGS84 positions to metres of the projections of recorders and of UTM, and back.
//!
//! The spherical Mercators are EPSG:3857, Lowrance's and Humminbird's; all stretch the ground by
//! about 1 / cos(latitude). Universal Transverse Mercator on WGS84 gives the metres that survey
//! programs expect in a file.

use super::LonLat;
use super::ellipsoid::metres_per_degree;
use proj4rs::Proj;
use proj4rs::transform::transform;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::{LazyLock, OnceLock};

/// Radius of the EPSG:3857 sphere: the equatorial radius of WGS84, metres.
const WEB_RADIUS_M: f64 = 6_378_137.0;
/// Radius of Lowrance's sphere: the polar radius of WGS84, metres.
const LOWRANCE_RADIUS_M: f64 = 6_356_752.314_2;
/// Radius of Humminbird's sphere: the equatorial radius of International 1924, metres.
const HUMMINBIRD_RADIUS_M: f64 = 6_378_388.0;
/// tan(geodetic latitude) / tan(spherical latitude) in Humminbird's logs, as other readers of these
/// logs use it (close to, but not exactly, (a / b) squared of International 1924).
const HUMMINBIRD_TAN_RATIO: f64 = 1.006_764_292_7;

/// A UTM zone of one hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct UtmZone {
    /// Number of the zone, 1 to 60.
    pub number: u8,
    /// True for the northern hemisphere.
    pub north: bool,
}

impl UtmZone {
    /// Returns the plain six-degree zone of a position (without the exceptions of Norway and
    /// Svalbard).
    pub fn of(position: LonLat) -> Self {
        let from_date_line = (position.lon_deg + 180.0).rem_euclid(360.0);
        Self { number: (from_date_line / 6.0) as u8 % 60 + 1, north: position.lat_deg >= 0.0 }
    }

    /// Returns the zones that have a place within `reach_m` of a position: the zone of the position
    /// first, then those across a meridian or the equator.
    pub fn near(position: LonLat, reach_m: f64) -> Vec<Self> {
        let [lon_m, lat_m] = metres_per_degree(position);
        let [lon_deg, lat_deg] = [reach_m / lon_m, reach_m / lat_m];
        let mut zones = vec![Self::of(position)];
        for [east, north] in [-1.0, 0.0, 1.0]
            .into_iter()
            .flat_map(|east| [-1.0, 0.0, 1.0].map(|north| [east, north]))
        {
            let zone = Self::of(LonLat::new(
                position.lon_deg + east * lon_deg,
                position.lat_deg + north * lat_deg,
            ));
            if !zones.contains(&zone) {
                zones.push(zone);
            }
        }
        zones
    }

    /// Returns the EPSG number of the zone.
    pub fn epsg(self) -> u32 {
        (if self.north { 32_600 } else { 32_700 }) + u32::from(self.number)
    }

    /// Returns the zone of an EPSG number; `None` where it is not a UTM zone on WGS84.
    pub(crate) fn from_epsg(epsg: u32) -> Option<Self> {
        let number = u8::try_from(epsg % 100).ok()?;
        let exists = (1..=60).contains(&number) && [326, 327].contains(&(epsg / 100));
        exists.then_some(Self { number, north: epsg / 100 == 326 })
    }

    /// Returns the name of the zone: `UTM 12N`.
    pub fn name(self) -> String {
        format!("UTM {}{}", self.number, if self.north { 'N' } else { 'S' })
    }

    /// Converts a position to easting and northing, metres, by Poder and Engsager's series to the
    /// sixth order: better than a tenth of a micrometre within the zone. NaN where the zone or the
    /// position does not exist.
    pub fn to_metres(self, position: LonLat) -> [f64; 2] {
        let from = [position.lon_deg, position.lat_deg].map(f64::to_radians);
        let there = self.projection();
        there.map_or([f64::NAN; 2], |there| transformed(wgs84(), there, from))
    }

    /// Inverse of [`UtmZone::to_metres`].
    pub fn to_lon_lat(self, metres: [f64; 2]) -> LonLat {
        let there = self.projection();
        let radians = there.map_or([f64::NAN; 2], |there| transformed(there, wgs84(), metres));
        let [lon_deg, lat_deg] = radians.map(f64::to_degrees);
        LonLat { lon_deg, lat_deg }
    }

    /// Returns the projection of the zone, created at the first call; `None` where no zone has the
    /// number.
    fn projection(self) -> Option<&'static Proj> {
        static ZONES: [OnceLock<Option<Proj>>; 120] = [const { OnceLock::new() }; 120];
        let of_hemisphere = usize::from(self.number).checked_sub(1)?;
        let index = of_hemisphere + if self.north { 0 } else { 60 };
        let zone = ZONES.get(index).filter(|_| of_hemisphere < 60)?;
        let made = zone.get_or_init(|| {
            let south = if self.north { "" } else { " +south" };
            let number = self.number;
            let words = format!("+proj=utm +zone={number}{south} +datum=WGS84 +units=m +no_defs");
            Proj::from_proj_string(&words).ok()
        });
        made.as_ref()
    }
}

/// Converts WGS84 to EPSG:3857 x and y, metres: the geodetic latitude is used as a spherical one,
/// as EPSG defines it.
pub fn web_mercator(position: LonLat) -> [f64; 2] {
    forward(position, WEB_RADIUS_M)
}

/// Inverse of [`web_mercator`].
pub fn web_mercator_inverse(x: f64, y: f64) -> LonLat {
    inverse(x, y, WEB_RADIUS_M)
}

/// Converts Lowrance's Mercator metres (sphere of the WGS84 polar radius) to WGS84.
pub fn lowrance_mercator_inverse(x: f64, y: f64) -> LonLat {
    inverse(x, y, LOWRANCE_RADIUS_M)
}

/// Converts WGS84 to Lowrance's Mercator metres (before the recorder's rounding).
pub fn lowrance_mercator(position: LonLat) -> [f64; 2] {
    forward(position, LOWRANCE_RADIUS_M)
}

/// Converts Humminbird's Mercator metres (International 1924 sphere, then to geodetic latitude) to
/// WGS84.
pub fn humminbird_mercator_inverse(x: f64, y: f64) -> LonLat {
    let spherical = inverse(x, y, HUMMINBIRD_RADIUS_M);
    let tangent = spherical.lat_deg.to_radians().tan() * HUMMINBIRD_TAN_RATIO;
    LonLat { lat_deg: tangent.atan().to_degrees(), ..spherical }
}

fn forward(position: LonLat, radius_m: f64) -> [f64; 2] {
    let half_colatitude = FRAC_PI_4 + position.lat_deg.to_radians() / 2.0;
    [radius_m * position.lon_deg.to_radians(), radius_m * half_colatitude.tan().ln()]
}

fn inverse(x: f64, y: f64, radius_m: f64) -> LonLat {
    LonLat::new(
        (x / radius_m).to_degrees(),
        (2.0 * (y / radius_m).exp().atan() - FRAC_PI_2).to_degrees(),
    )
}

/// Returns longitude and latitude on WGS84, radians, as the system that every projection is
/// converted from or to.
#[allow(clippy::expect_used, reason = "a text that a test reads")]
pub(super) fn wgs84() -> &'static Proj {
    static WGS84_RADIANS: LazyLock<Proj> = LazyLock::new(|| {
        let made = Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs");
        made.expect("the words are those of the library's own documentation")
    });
    &WGS84_RADIANS
}

/// Converts coordinates of one system to another; NaN where the other is not defined.
pub(super) fn transformed(from: &Proj, to: &Proj, [x, y]: [f64; 2]) -> [f64; 2] {
    let mut point = (x, y, 0.0);
    match transform(from, to, &mut point) {
        Ok(()) => [point.0, point.1],
        Err(_) => [f64::NAN; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_and_metres_are_those_of_proj() {
        // pyproj 3.7.2: transform(lon, lat).
        let goldens = [
            (17, true, -82.11, 29.41, 392311.9646362, 3253923.7680122),
            (12, true, -111.48, 36.86, 457213.1723420, 4079449.4104993),
            (32, true, 10.3951, 63.4305, 569618.6286081, 7034313.8490130),
            (56, false, 151.2093, -33.8688, 334368.6336481, 6250948.3453850),
            (31, true, 5.9, 0.001, 822836.1939948, 110.6727342),
            (17, true, -84.0, 29.0, 207728.9289299, 3211697.3733454),
        ];
        for (number, north, lon_deg, lat_deg, east_m, north_m) in goldens {
            let zone = UtmZone { number, north };
            let position = LonLat { lon_deg, lat_deg };
            let found = zone.to_metres(position);
            assert!((found[0] - east_m).hypot(found[1] - north_m) < 1e-7, "{found:?}");
            let back = zone.to_lon_lat([east_m, north_m]);
            let off_deg = (back.lon_deg - lon_deg).hypot(back.lat_deg - lat_deg);
            assert!(off_deg < 1e-12, "{back:?}");
        }
    }

    #[test]
    fn zones_meet_at_meridians_and_the_equator() {
        let near = |lon_deg, lat_deg, reach_m| {
            let zones = UtmZone::near(LonLat { lon_deg, lat_deg }, reach_m);
            zones.into_iter().map(UtmZone::name).collect::<Vec<_>>()
        };
        assert_eq!(near(9.0, 47.5, 100.0), ["UTM 32N"]);
        // At this latitude a thousandth of a degree of longitude is 75 m.
        assert_eq!(near(11.999, 47.5, 100.0), ["UTM 32N", "UTM 33N"]);
        assert_eq!(near(11.999, 47.5, 50.0), ["UTM 32N"]);
        assert_eq!(near(-179.9999, 47.5, 50.0), ["UTM 1N", "UTM 60N"]);
        let corner = near(12.0001, -0.0001, 50.0);
        assert_eq!(corner, ["UTM 33S", "UTM 32S", "UTM 32N", "UTM 33N"]);
    }

    #[test]
    fn what_is_no_zone_or_no_place_is_nowhere() {
        let position = LonLat::new(9.0, 50.0);
        for number in [0, 61, 255] {
            let zone = UtmZone { number, north: true };
            assert!(zone.to_metres(position).iter().all(|metres| metres.is_nan()));
        }
        let zone = UtmZone::of(position);
        let nowhere = LonLat { lon_deg: f64::NAN, ..position };
        assert!(zone.to_metres(nowhere).iter().any(|metres| metres.is_nan()));
    }
}
