//! Converts positions to the coordinate reference systems that files are written in, and to the
//! plane in metres that maps are drawn in, whatever the unit of the system.

use super::ellipsoid::metres_per_degree;
use super::projections::{transformed, wgs84};
use super::{LonLat, UtmZone, web_mercator, web_mercator_inverse};
use proj4rs::Proj;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// EPSG's number of WGS84 in degrees.
const WGS84: u16 = 4326;
/// EPSG's number of web Mercator.
const WEB_MERCATOR: u16 = 3857;
/// Names of datums on the ellipsoid of WGS84 or GRS80 that PROJ nevertheless shifts by up to 2 m
/// against WGS84.
const SHIFTED_DATUMS: [&str; 5] = [
    "NAD83_High_Accuracy_Reference_Network",
    "NAD83_Canadian_Spatial_Reference_System",
    "Posiciones_Geodesicas_Argentinas_2007",
    "Costa_Rica_2005",
    "St_Helena",
];
/// EPSG numbers of NAD83 systems in the Aleutians and Hawaii, where NAD83 is 0.8 m off WGS84.
const SHIFTED_SYSTEMS: [u16; 7] = [3373, 26_940, 26_961, 26_962, 26_963, 26_964, 26_965];
/// Factors by which a projection may stretch areas at a place that it is meant for.
const MODEST: std::ops::Range<f64> = 0.8..1.25;
/// Step over which the stretch of areas is measured, degrees: some 10 m.
const STEP_DEG: f64 = 1e-4;
/// Relative stretch of lengths up to which the metres of a system are used without scaling.
const LEAST_STRETCH: f64 = 0.02;

/// Reason why a system cannot be used; its text is one sentence that begins with the setting.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{setting}: {reason}")]
pub struct CrsError {
    setting: &'static str,
    reason: String,
}

impl CrsError {
    /// Creates the error of the system that files are written in.
    fn new(reason: String) -> Self {
        Self { setting: "crs", reason }
    }

    /// Creates the error of the system of a log's positions.
    fn of_source(reason: String) -> Self {
        Self { setting: "source.crs", reason }
    }
}

/// The `crs` setting: `utm`, `wgs84`, `web_mercator`, or `EPSG:` and a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum CrsChoice {
    /// The UTM zone of the survey's first fix.
    #[default]
    Utm,
    /// Degrees on WGS84.
    Wgs84,
    /// Web Mercator.
    WebMercator,
    /// A system by its EPSG number.
    Epsg(u16),
}

/// Error of a text that does not name a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is {0}")]
pub struct NoSystem(&'static str);

impl TryFrom<String> for CrsChoice {
    type Error = NoSystem;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let number = || {
            let (authority, number) = text.split_once(':')?;
            let is_epsg = authority.eq_ignore_ascii_case("epsg");
            is_epsg.then(|| number.trim().parse().ok()).flatten()
        };
        match text.as_str() {
            "utm" => Ok(Self::Utm),
            "wgs84" => Ok(Self::Wgs84),
            "web_mercator" => Ok(Self::WebMercator),
            _ => number()
                .map(Self::Epsg)
                .ok_or(NoSystem("utm, wgs84, web_mercator, or EPSG: and a number up to 65535")),
        }
    }
}

impl From<CrsChoice> for String {
    fn from(choice: CrsChoice) -> Self {
        match choice {
            CrsChoice::Utm => "utm".to_owned(),
            CrsChoice::Wgs84 => "wgs84".to_owned(),
            CrsChoice::WebMercator => "web_mercator".to_owned(),
            CrsChoice::Epsg(number) => format!("EPSG:{number}"),
        }
    }
}

impl CrsChoice {
    /// Checks that the system is known, in metres (or WGS84 in degrees), and on a datum that agrees
    /// with WGS84.
    ///
    /// # Errors
    /// When the system is not known, is neither in metres nor WGS84 in degrees, or is on a datum
    /// that does not agree with WGS84.
    pub fn check(self) -> Result<(), CrsError> {
        match self {
            CrsChoice::Epsg(number) => Crs::from_epsg(number).map(|_| ()),
            _ => Ok(()),
        }
    }

    /// Returns the system for a survey that begins at a position.
    ///
    /// # Errors
    /// When the system is not known, is neither in metres nor WGS84 in degrees, or is on a datum
    /// that does not agree with WGS84; when `position` is far outside of the area of the system.
    pub fn at(self, position: LonLat) -> Result<Crs, CrsError> {
        let number = match self {
            CrsChoice::Utm => return Ok(Crs::utm(position)),
            CrsChoice::Wgs84 => WGS84,
            CrsChoice::WebMercator => WEB_MERCATOR,
            CrsChoice::Epsg(number) => number,
        };
        let crs = Crs::from_epsg(number)?;
        let back = crs.to_lon_lat(crs.place(position));
        // The limit, 0.1 mm, allows for rounding, but not for the errors of a projection far
        // outside of its area.
        let off_deg = (back.lon_deg - position.lon_deg).hypot(back.lat_deg - position.lat_deg);
        let stretched = !crs.is_mercator() && !MODEST.contains(&area_scale(&crs, position));
        if off_deg < 1e-9 && !stretched {
            return Ok(crs);
        }
        Err(CrsError::new(format!(
            "the survey lies far outside of {crs}; choose another system, or utm"
        )))
    }
}

/// The `source.crs` setting, `EPSG:` and a number: the system of a log whose positions are in
/// metres of a system that the log does not name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct SourceCrs(pub u16);

impl TryFrom<String> for SourceCrs {
    type Error = NoSystem;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        match CrsChoice::try_from(text) {
            Ok(CrsChoice::Epsg(number)) => Ok(Self(number)),
            _ => Err(NoSystem("EPSG: and a number up to 65535, EPSG:32633 for UTM zone 33 north")),
        }
    }
}

impl From<SourceCrs> for String {
    fn from(SourceCrs(number): SourceCrs) -> Self {
        CrsChoice::Epsg(number).into()
    }
}

impl SourceCrs {
    /// Returns the system.
    ///
    /// # Errors
    /// A sentence that names `source.crs`, when the system is not known, not in metres, or on a
    /// datum that does not agree with WGS84.
    pub fn system(self) -> Result<Crs, CrsError> {
        let Self(number) = self;
        if crs_definitions::from_code(number).is_none() {
            return Err(CrsError::of_source(format!(
                "EPSG:{number} is not known; give the number of the system that the recorder was set to, EPSG:32633 for UTM zone 33 north"
            )));
        }
        let of_source = |error: CrsError| CrsError::of_source(error.reason);
        let crs = Crs::from_epsg(number).map_err(of_source)?;
        if crs.is_degrees() {
            Err(CrsError::of_source(format!(
                "{crs} has degrees; it is for positions in metres: name the projected system that they are of"
            )))
        } else {
            Ok(crs)
        }
    }
}

/// A coordinate reference system: WGS84 in degrees, or metres of a projection on WGS84 or a datum
/// that agrees with it.
#[derive(Clone)]
pub struct Crs {
    epsg: u16,
    wkt: String,
    kind: Kind,
}

#[derive(Clone)]
enum Kind {
    Degrees,
    Utm(UtmZone),
    WebMercator,
    Other(Arc<Proj>),
}

impl Crs {
    /// Creates a system by its EPSG number.
    ///
    /// Projections other than web Mercator are those of `proj4rs`. Datums are not shifted, so only
    /// datums that PROJ treats as WGS84 are accepted (ETRS89, GDA, NZGD2000, most of NAD83 ...):
    /// they differ from WGS84 by less than the positions of fish-finders do.
    ///
    /// # Errors
    /// When the system is not known, is neither in metres nor WGS84 in degrees, or is on a datum
    /// that does not agree with WGS84.
    pub fn from_epsg(epsg: u16) -> Result<Self, CrsError> {
        let known = crs_definitions::from_code(epsg);
        let unknown = || {
            CrsError::new(format!(
                "EPSG:{epsg} is not known; choose utm, wgs84, web_mercator or another EPSG number"
            ))
        };
        let known = known.ok_or_else(unknown)?;
        let kind = match (epsg, UtmZone::from_epsg(epsg.into())) {
            (WGS84, _) => Kind::Degrees,
            (WEB_MERCATOR, _) => Kind::WebMercator,
            (_, Some(zone)) => Kind::Utm(zone),
            (_, None) => Kind::Other(Arc::new(projection(epsg, known.proj4, known.wkt)?)),
        };
        Ok(Self { epsg, wkt: without_shift(known.wkt), kind })
    }

    /// Returns the UTM system of a position's zone.
    pub fn utm(position: LonLat) -> Self {
        Self::of_zone(UtmZone::of(position))
    }

    /// Returns the system of a UTM zone.
    pub fn of_zone(zone: UtmZone) -> Self {
        let epsg = zone.epsg() as u16;
        let known = crs_definitions::from_code(epsg);
        Self {
            epsg,
            wkt: known.map_or_else(String::new, |known| without_shift(known.wkt)),
            kind: Kind::Utm(zone),
        }
    }

    /// Returns the EPSG number.
    pub fn epsg(&self) -> u16 {
        self.epsg
    }

    /// Returns the system as well-known text, version 1, which LAS files and shapefiles need.
    pub fn wkt(&self) -> &str {
        &self.wkt
    }

    /// Returns the name of the system, for example `WGS 84 / UTM zone 12N`.
    pub fn name(&self) -> &str {
        quoted_after(&self.wkt, "[")
    }

    /// Returns true if the coordinates of the system are degrees.
    pub fn is_degrees(&self) -> bool {
        matches!(self.kind, Kind::Degrees)
    }

    /// Returns true if the system is a Mercator or in degrees: both stretch the ground far from the
    /// equator, and people choose them nevertheless, so that their stretch is not checked.
    fn is_mercator(&self) -> bool {
        self.wkt.contains("PROJECTION[\"Mercator_") || self.is_degrees()
    }

    /// Returns east (or longitude) and north (or latitude) of a position; NaN where the projection
    /// is not defined.
    pub fn place(&self, position: LonLat) -> [f64; 2] {
        match &self.kind {
            Kind::Degrees => [position.lon_deg, position.lat_deg],
            Kind::Utm(zone) => zone.to_metres(position),
            Kind::WebMercator => web_mercator(position),
            Kind::Other(there) => {
                let from = [position.lon_deg, position.lat_deg].map(f64::to_radians);
                transformed(wgs84(), there, from)
            }
        }
    }

    /// Returns true if `metres` of this system, easting and northing, are in the area that the
    /// system is meant for.
    fn reaches(&self, metres: [f64; 2]) -> bool {
        let position = self.to_lon_lat(metres);
        if !position.is_on_earth() {
            return false;
        }
        let back = self.place(position);
        let off_m = (back[0] - metres[0]).hypot(back[1] - metres[1]);
        off_m < 1e-3 && (self.is_mercator() || MODEST.contains(&area_scale(self, position)))
    }

    /// Checks that metres of a log, easting and northing, can be of this system.
    ///
    /// # Errors
    /// A sentence that names `source.crs`, the metres and the system, when the metres are outside
    /// of the area of the system.
    pub(crate) fn check_source(&self, metres: [f64; 2]) -> Result<(), CrsError> {
        if self.reaches(metres) {
            Ok(())
        } else {
            Err(CrsError::of_source(format!(
                "the log's position {:.0} E {:.0} N lies outside of {self}; name the system that the recorder was set to",
                metres[0], metres[1]
            )))
        }
    }

    /// Inverse of [`Crs::place`].
    pub fn to_lon_lat(&self, [x, y]: [f64; 2]) -> LonLat {
        let [lon_deg, lat_deg] = match &self.kind {
            Kind::Degrees => [x, y],
            Kind::Utm(zone) => return zone.to_lon_lat([x, y]),
            Kind::WebMercator => return web_mercator_inverse(x, y),
            Kind::Other(there) => transformed(there, wgs84(), [x, y]).map(f64::to_degrees),
        };
        LonLat { lon_deg, lat_deg }
    }
}

impl PartialEq for Crs {
    fn eq(&self, other: &Self) -> bool {
        self.epsg == other.epsg
    }
}

impl fmt::Display for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "EPSG:{} ({})", self.epsg, self.name())
    }
}

impl fmt::Debug for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Crs({self})")
    }
}

/// A coordinate reference system as a plane in metres. A system in degrees, or one that stretches
/// the ground, is scaled to metres on the ground at the survey's origin, so that the sizes of cells
/// and gaps are the same in every system; square cells of the plane are then oblong in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPlane {
    /// The coordinate reference system.
    pub crs: Crs,
    /// Units of the system per metre of the plane, east and north.
    pub units: [f64; 2],
}

impl MapPlane {
    /// Creates the plane of a system around an origin.
    pub fn new(crs: Crs, origin: LonLat) -> Self {
        let stretch = area_scale(&crs, origin).sqrt();
        let units = match crs.is_degrees() {
            true => metres_per_degree(origin).map(f64::recip),
            false if (stretch - 1.0).abs() > LEAST_STRETCH => [stretch; 2],
            false => [1.0, 1.0],
        };
        Self { crs, units }
    }

    /// Returns the place of a position in the plane, metres east and north.
    pub fn place(&self, position: LonLat) -> [f64; 2] {
        let place = self.crs.place(position);
        [0, 1].map(|axis| place[axis] / self.units[axis])
    }

    /// Inverse of [`MapPlane::place`].
    pub fn to_lon_lat(&self, place: [f64; 2]) -> LonLat {
        self.crs.to_lon_lat(self.in_crs(place))
    }

    /// Converts a place in the plane to the units of the system.
    pub fn in_crs(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| place[axis] * self.units[axis])
    }

    /// Returns the square metres of the plane per square metre on the ground at a place.
    pub fn area_scale_at(&self, place: [f64; 2]) -> f64 {
        area_scale(&self.crs, self.to_lon_lat(place)) / (self.units[0] * self.units[1])
    }
}

/// Returns the square units of a system per square metre on the ground at a position.
fn area_scale(crs: &Crs, at: LonLat) -> f64 {
    let moved = |east_deg: f64, north_deg: f64| {
        crs.place(LonLat::new(at.lon_deg + east_deg, at.lat_deg + north_deg))
    };
    let half = 0.5 * STEP_DEG;
    let across = |from: [f64; 2], to: [f64; 2]| [0, 1].map(|axis| to[axis] - from[axis]);
    let east = across(moved(-half, 0.0), moved(half, 0.0));
    let north = across(moved(0.0, -half), moved(0.0, half));
    let [lon_m, lat_m] = metres_per_degree(at).map(|metres| metres * STEP_DEG);
    (east[0] * north[1] - east[1] * north[0]).abs() / (lon_m * lat_m)
}

/// Creates the projection of a system by its PROJ text; refuses systems that are not in metres, or
/// on a datum that does not agree with WGS84.
fn projection(epsg: u16, proj4: &str, wkt: &str) -> Result<Proj, CrsError> {
    let refused =
        |why: &str| CrsError::new(format!("EPSG:{epsg} ({}) {why}", quoted_after(wkt, "[")));
    let in_metres = wkt.starts_with("PROJCS") && proj4.contains("+units=m ");
    if !in_metres {
        return Err(refused("is not a map projection in metres; choose one that is"));
    }
    if !agrees_with_wgs84(epsg, proj4, wkt) {
        return Err(refused(
            "lies on another datum than WGS84; choose a system on WGS84, ETRS89 or NAD83 and let a GIS shift it",
        ));
    }
    // The datum is left out of the projection: its shift to WGS84 is zero.
    Proj::from_proj_string(proj4)
        .map_err(|_| refused("uses a projection that is not known here; choose another system"))
}

fn agrees_with_wgs84(epsg: u16, proj4: &str, wkt: &str) -> bool {
    let word = |key: &str| proj4.split_whitespace().find_map(|word| word.strip_prefix(key));
    let shift_is_none = word("+towgs84=").is_none_or(|shift| {
        let mut parts = shift.split(',');
        parts.all(|part| part.parse() == Ok(0.0))
    });
    let ellipsoid = match word("+datum=") {
        Some(datum) => matches!(datum, "WGS84" | "NAD83"),
        None => matches!(word("+ellps="), Some("GRS80" | "WGS84")),
    };
    let datum = quoted_after(wkt, "DATUM[");
    let shifted = SHIFTED_DATUMS.iter().any(|name| datum.starts_with(name));
    let by_grid = word("+nadgrids=").is_some();
    shift_is_none && ellipsoid && !shifted && !by_grid && !SHIFTED_SYSTEMS.contains(&epsg)
}

/// Removes the shift to WGS84 from the text of a system: it is zero, but keeps PROJ from
/// recognising the system.
fn without_shift(wkt: &str) -> String {
    let Some((before, behind)) = wkt.split_once("TOWGS84[") else {
        return wkt.to_owned();
    };
    let behind = behind.split_once("],").map_or("", |(_, behind)| behind);
    format!("{before}{behind}")
}

/// Returns the first quoted text behind a word; empty where there is none.
fn quoted_after<'a>(text: &'a str, word: &str) -> &'a str {
    let behind = text.split_once(word).map_or("", |(_, behind)| behind);
    behind.split('"').nth(1).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn area_scales_are_those_of_proj() {
        // pyproj 3.7.2: Proj(...).get_factors(-111.48, 36.86).areal_scale. The scale of web
        // Mercator is its area divided by that of Geod.polygon_area_perimeter: PROJ's factors
        // ignore the ellipsoid.
        let at = LonLat::new(-111.48, 36.86);
        for (choice, scale) in [
            (CrsChoice::Utm, 0.999_245_248),
            (CrsChoice::WebMercator, 1.0),
            (CrsChoice::Wgs84, 1.0),
            (CrsChoice::Epsg(6350), 1.0),
        ] {
            let plane = MapPlane::new(choice.at(at).unwrap(), at);
            let found = plane.area_scale_at(plane.place(at));
            assert!((found - scale).abs() < 1e-6, "{choice:?}: {found}");
        }
        let web = CrsChoice::WebMercator.at(at).unwrap();
        assert!((area_scale(&web, at) - 1.565_056).abs() < 1e-5);
    }
}
