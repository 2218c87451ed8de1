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

    /// The zone in the first version of well-known text, as LAS 1.4 wants it.
    pub fn wkt(self) -> String {
        let Self { number, north } = self;
        let hemisphere = if north { 'N' } else { 'S' };
        let false_northing_m = if north { 0.0 } else { FALSE_NORTHING_SOUTH_M };
        let meridian = self.central_meridian_deg();
        let epsg = self.epsg();
        format!(
            r#"PROJCS["WGS 84 / UTM zone {number}{hemisphere}",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4326"]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",{meridian}],PARAMETER["scale_factor",{SCALE}],PARAMETER["false_easting",{FALSE_EASTING_M}],PARAMETER["false_northing",{false_northing_m}],UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Easting",EAST],AXIS["Northing",NORTH],AUTHORITY["EPSG","{epsg}"]]"#
        )
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
