//! Universal Transverse Mercator on WGS84: the metres that survey programs expect in a file.

use super::LonLat;

/// Equatorial radius of WGS84, metres.
const A_M: f64 = 6_378_137.0;
/// Flattening of WGS84.
const F: f64 = 1.0 / 298.257_223_563;
/// Third flattening.
const N: f64 = F / (2.0 - F);
const SCALE: f64 = 0.9996;
const FALSE_EASTING_M: f64 = 500_000.0;
const FALSE_NORTHING_SOUTH_M: f64 = 10_000_000.0;

/// A UTM zone of one hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UtmZone {
    /// 1 to 60.
    pub number: u8,
    /// Northern hemisphere.
    pub north: bool,
}

impl UtmZone {
    /// The plain six-degree zone of a position (without the exceptions of Norway and Svalbard).
    pub fn of(position: LonLat) -> Self {
        let from_date_line = (position.lon_deg + 180.0).rem_euclid(360.0);
        Self {
            number: (from_date_line / 6.0) as u8 % 60 + 1,
            north: position.lat_deg >= 0.0,
        }
    }

    /// Its number among the EPSG coordinate reference systems.
    pub fn epsg(self) -> u32 {
        (if self.north { 32_600 } else { 32_700 }) + u32::from(self.number)
    }

    /// The zone of an EPSG number; `None` for any other system.
    pub fn from_epsg(epsg: u32) -> Option<Self> {
        let number = u8::try_from(epsg % 100).ok()?;
        let exists = (1..=60).contains(&number) && [326, 327].contains(&(epsg / 100));
        exists.then_some(Self {
            number,
            north: epsg / 100 == 326,
        })
    }

    /// Its name: `UTM 12N`.
    pub fn name(self) -> String {
        format!("UTM {}{}", self.number, if self.north { 'N' } else { 'S' })
    }

    fn central_meridian_deg(self) -> f64 {
        6.0 * f64::from(self.number) - 183.0
    }

    /// Easting and northing, metres: Krueger's series to the fourth order of the flattening (Karney 2011, J. Geodesy 85),
    /// better than a micrometre within the zone.
    pub fn to_metres(self, position: LonLat) -> [f64; 2] {
        let radius_m = A_M / (1.0 + N) * (1.0 + N.powi(2) / 4.0 + N.powi(4) / 64.0);
        let beyond = (position.lon_deg - self.central_meridian_deg()).to_radians();
        let sin_lat = position.lat_deg.to_radians().sin();
        let eccentricity = 2.0 * N.sqrt() / (1.0 + N);
        // Tangent of the conformal latitude.
        let tangent = (sin_lat.atanh() - eccentricity * (eccentricity * sin_lat).atanh()).sinh();
        let xi = tangent.atan2(beyond.cos());
        let eta = (beyond.sin() / tangent.hypot(1.0)).atanh();
        let (mut east, mut north) = (eta, xi);
        for (order, alpha) in series().into_iter().enumerate() {
            let angle = 2.0 * (order + 1) as f64;
            east += alpha * (angle * xi).cos() * (angle * eta).sinh();
            north += alpha * (angle * xi).sin() * (angle * eta).cosh();
        }
        let false_northing_m = if self.north {
            0.0
        } else {
            FALSE_NORTHING_SOUTH_M
        };
        [
            FALSE_EASTING_M + SCALE * radius_m * east,
            false_northing_m + SCALE * radius_m * north,
        ]
    }

    /// Inverse of [`UtmZone::to_metres`], by the inverse series and Newton's method for the latitude; better than a micrometre
    /// within the zone.
    pub fn to_lon_lat(self, [easting_m, northing_m]: [f64; 2]) -> LonLat {
        let radius_m = SCALE * A_M / (1.0 + N) * (1.0 + N.powi(2) / 4.0 + N.powi(4) / 64.0);
        let false_northing_m = if self.north {
            0.0
        } else {
            FALSE_NORTHING_SOUTH_M
        };
        let east = (easting_m - FALSE_EASTING_M) / radius_m;
        let north = (northing_m - false_northing_m) / radius_m;
        let (mut eta, mut xi) = (east, north);
        for (order, beta) in inverse_series().into_iter().enumerate() {
            let angle = 2.0 * (order + 1) as f64;
            xi -= beta * (angle * north).sin() * (angle * east).cosh();
            eta -= beta * (angle * north).cos() * (angle * east).sinh();
        }
        let conformal = xi.sin() / eta.sinh().hypot(xi.cos());
        LonLat {
            lon_deg: self.central_meridian_deg() + eta.sinh().atan2(xi.cos()).to_degrees(),
            lat_deg: geodetic_tangent(conformal).atan().to_degrees(),
        }
    }
}

/// The coefficients of Krueger's series.
fn series() -> [f64; 4] {
    let [n2, n3, n4] = [N.powi(2), N.powi(3), N.powi(4)];
    [
        N / 2.0 - 2.0 / 3.0 * n2 + 5.0 / 16.0 * n3 + 41.0 / 180.0 * n4,
        13.0 / 48.0 * n2 - 3.0 / 5.0 * n3 + 557.0 / 1440.0 * n4,
        61.0 / 240.0 * n3 - 103.0 / 140.0 * n4,
        49_561.0 / 161_280.0 * n4,
    ]
}

/// The coefficients of Krueger's inverse series.
fn inverse_series() -> [f64; 4] {
    let [n2, n3, n4] = [N.powi(2), N.powi(3), N.powi(4)];
    [
        N / 2.0 - 2.0 / 3.0 * n2 + 37.0 / 96.0 * n3 - n4 / 360.0,
        n2 / 48.0 + n3 / 15.0 - 437.0 / 1440.0 * n4,
        17.0 / 480.0 * n3 - 37.0 / 840.0 * n4,
        4397.0 / 161_280.0 * n4,
    ]
}

/// Tangent of the geodetic latitude from that of the conformal one (Karney 2011, equations 7 to 9 and 19 to 21).
fn geodetic_tangent(conformal: f64) -> f64 {
    let e2 = F * (2.0 - F);
    let e = e2.sqrt();
    let mut tangent = conformal;
    // Converges quadratically from a start that is off by 0.3 %.
    for _ in 0..4 {
        let secant = tangent.hypot(1.0);
        let sigma = (e * (e * tangent / secant).atanh()).sinh();
        let reached = tangent * sigma.hypot(1.0) - sigma * secant;
        let slope = (1.0 + (1.0 - e2) * tangent.powi(2)) / ((1.0 - e2) * secant);
        tangent += (conformal - reached) / reached.hypot(1.0) * slope;
    }
    tangent
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
            (
                56,
                false,
                151.2093,
                -33.8688,
                334368.6336481,
                6250948.3453850,
            ),
            (31, true, 5.9, 0.001, 822836.1939948, 110.6727342),
            (17, true, -84.0, 29.0, 207728.9289299, 3211697.3733454),
        ];
        for (number, north, lon_deg, lat_deg, east_m, north_m) in goldens {
            let zone = UtmZone { number, north };
            let position = LonLat { lon_deg, lat_deg };
            let found = zone.to_metres(position);
            assert!(
                (found[0] - east_m).hypot(found[1] - north_m) < 1e-6,
                "{found:?}"
            );
            let back = zone.to_lon_lat([east_m, north_m]);
            let off_deg = (back.lon_deg - lon_deg).hypot(back.lat_deg - lat_deg);
            assert!(off_deg < 1e-11, "{back:?}");
        }
    }
}
