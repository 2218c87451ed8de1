//! Points of a GeoJSON file (RFC 7946): longitude, latitude, and a height from the third coordinate
//! or a property.

use super::PointFault;
use crate::support::regular_file;
use serde_json::Value;
use std::io::ErrorKind;
use std::path::Path;

/// Properties that are taken for a height when the user names none and a point has no third
/// coordinate; true for depths.
const KNOWN: [(&str, bool); 6] = [
    ("z_m", false),
    ("z", false),
    ("elevation", false),
    ("elevation_m", false),
    ("depth_m", true),
    ("depth", true),
];

/// Longer than any table of soundings that is written as GeoJSON.
const LONGEST: u64 = 1 << 30;

/// Points of a file.
pub(super) struct GeoJsonPoints {
    /// Longitude and latitude, degrees, and elevation, up.
    pub points: Vec<[f64; 3]>,
    /// Features that are no point, or have no height.
    pub left_out: usize,
}

/// Reads the points; `height` names the property that the height is taken from. Where it is none,
/// depths are turned.
pub(super) fn read(path: &Path, height: Option<&str>) -> Result<GeoJsonPoints, PointFault> {
    let text = regular_file::read(path, LONGEST).map_err(|error| match error.kind() {
        ErrorKind::FileTooLarge => PointFault::LongGeoJson,
        _ => error.into(),
    })?;
    let root: Value = serde_json::from_slice(&text)?;
    let features = root["features"].as_array().ok_or(PointFault::NoFeatures)?;
    let points: Vec<[f64; 3]> =
        features.iter().filter_map(|feature| point(feature, height)).collect();
    Ok(GeoJsonPoints { left_out: features.len() - points.len(), points })
}

fn point(feature: &Value, height: Option<&str>) -> Option<[f64; 3]> {
    let geometry = &feature["geometry"];
    let at = geometry["coordinates"].as_array().filter(|_| geometry["type"] == "Point")?;
    let coordinate = |axis: usize| at.get(axis)?.as_f64();
    let property = |name: &str| feature["properties"][name].as_f64();
    let known = || {
        KNOWN.iter().find_map(|(name, downwards)| {
            let value = property(name)?;
            Some(if *downwards { -value } else { value })
        })
    };
    let z = match height {
        Some(name) => property(name),
        None => coordinate(2).or_else(known),
    };
    Some([coordinate(0)?, coordinate(1)?, z?])
}
